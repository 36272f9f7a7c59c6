"""Parallel environments with the interface of stable-baselines3."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plantigrade.extras import require
from plantigrade.learn.reward import TERMS
from plantigrade.learn.shared_walks import SharedWalks

require("stable_baselines3", "learn")
_vec = require("stable_baselines3.common.vec_env", "learn")


class TrainingEnvironment(_vec.VecEnv):
    """Parallel environments for training, with counts of rewards and falls.

    Attributes:
        rewards: Sums of rewards and their terms since :meth:`reset_counts`.
        decisions: Number of decisions since then.
        falls: Number of episodes since then that ended by a fall or a lost reference.
    """

    def __init__(self, walks: SharedWalks, factor: float):
        self._walks, self._factor = walks, factor
        one = (walks.single_observation_space, walks.single_action_space)
        super().__init__(walks.num_envs, *one)
        self._actions = np.zeros((walks.num_envs, len(walks.tracking.action)))
        self.reset_counts()

    def reset_counts(self) -> None:
        """Reset the counts."""
        self.rewards = dict.fromkeys(("reward", *TERMS), 0.0)
        self.decisions = self.falls = 0

    def reset(self) -> np.ndarray:
        """Start all episodes, with the seed of :meth:`seed` if there is one."""
        seen, _ = self._walks.reset(seed=self._seeds[0])
        self._reset_seeds()
        return seen

    def step_async(self, actions: np.ndarray) -> None:
        """Store the actions."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Apply the actions."""
        seen, rewards, ended, over, infos = self._walks.step(self._actions)
        self.decisions += len(rewards)
        self.falls += int(ended.sum())
        self.rewards["reward"] += float(rewards.sum())
        for term in TERMS:
            self.rewards[term] += float(infos[term].sum()) if term in infos else 0.0
        ended_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        done = ended | over
        for i in np.flatnonzero(done).tolist():
            ended_infos[i] = {
                "terminal_observation": infos["final_obs"][i],
                "TimeLimit.truncated": bool(over[i] and not ended[i]),
            }
        return seen, (self._factor * rewards).astype(np.float32), done, ended_infos

    def close(self) -> None:
        """End the other processes."""
        self._walks.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute, which is the same for all environments."""
        return [getattr(self._walks, attr_name, None)] * self._many(indices)

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raise an error, because environments share their attributes."""
        raise NotImplementedError("environments share their attributes")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kw: Any) -> list[Any]:
        """Raise an error, because environments share their methods."""
        raise NotImplementedError("environments share their methods")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Return False for every environment."""
        return [False] * self._many(indices)

    def _many(self, indices: int | Sequence[int] | None) -> int:
        if indices is None:
            return self.num_envs
        return 1 if isinstance(indices, int) else len(indices)
