"""Persons in one process as stable-baselines3 wants its environments."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plantigrade.extras import require
from plantigrade.learn.environment import Walks

require("stable_baselines3", "learn")
_vec = require("stable_baselines3.common.vec_env", "learn")

TERMS = ("pose", "velocity", "com", "ends", "force", "soles")
"""Terms of the reward; some have not all."""


class Persons(_vec.VecEnv):
    """Persons who learn, and what is counted of them.

    Args:
        walks: Where they walk.
        factor: What rewards are multiplied by, so that values are near one.

    Attributes:
        rewards: Sum of the rewards and of their terms since :meth:`count_anew`.
        decisions: Number of decisions since then.
        falls: Episodes since then that ended by a fall, or because the person lost the way.
    """

    def __init__(self, walks: Walks, factor: float):
        self._walks, self._factor = walks, factor
        one = (walks.single_observation_space, walks.single_action_space)
        super().__init__(walks.num_envs, *one)
        self._actions = np.zeros((walks.num_envs, len(walks.following.action)))
        self.count_anew()

    def count_anew(self) -> None:
        """Forget what was counted."""
        self.rewards = dict.fromkeys(("reward", *TERMS), 0.0)
        self.decisions = self.falls = 0

    def reset(self) -> np.ndarray:
        """Start all episodes; with the seed that :meth:`seed` has given, if there is one."""
        seen, _ = self._walks.reset(seed=self._seeds[0])
        self._reset_seeds()
        return seen

    def step_async(self, actions: np.ndarray) -> None:
        """Keep what everybody decides."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Let it act."""
        seen, rewards, ended, over, infos = self._walks.step(self._actions)
        self.decisions += len(rewards)
        self.falls += int(ended.sum())
        self.rewards["reward"] += float(rewards.sum())
        for term in TERMS:
            self.rewards[term] += float(infos[term].sum()) if term in infos else 0.0
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        done = ended | over
        for i in np.flatnonzero(done).tolist():
            told[i] = {
                "terminal_observation": infos["final_obs"][i],
                "TimeLimit.truncated": bool(over[i] and not ended[i]),
            }
        return seen, (self._factor * rewards).astype(np.float32), done, told

    def close(self) -> None:
        """Nothing is held."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, the same for everybody."""
        return [getattr(self._walks, attr_name, None)] * self._many(indices)

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: nothing is set for one person alone."""
        raise NotImplementedError("persons share their attributes")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kw: Any) -> list[Any]:
        """Refuse: nothing is called for one person alone."""
        raise NotImplementedError("persons share their methods")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Return that nobody is wrapped."""
        return [False] * self._many(indices)

    def _many(self, indices: int | Sequence[int] | None) -> int:
        if indices is None:
            return self.num_envs
        return 1 if isinstance(indices, int) else len(indices)
