"""Tracking a reference walk as a Gymnasium environment, ``plantigrade/Walk-v0``.

::

    import gymnasium
    import plantigrade.learn

    env = gymnasium.make("plantigrade/Walk-v0", reference="runs/fit-walk")
    observation, info = env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

Many of them in one process, which takes half the time for each::

    envs = gymnasium.make_vec("plantigrade/Walk-v0", num_envs=16)
"""

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.extras import require
from plantigrade.learn.following import DIVERGED, Following, Rules, part_of_stride
from plantigrade.options import refuse_unknown
from plantigrade.record import Record
from plantigrade.world import World

if TYPE_CHECKING:
    import gymnasium
else:
    gymnasium = require("gymnasium", "learn")
    require("gymnasium.vector", "learn")


class Walk(gymnasium.Env[np.ndarray, np.ndarray]):
    """A person who tracks a walk, at 30 decisions per second.

    Every episode begins on the reference, at a random instant of it [DeepMimic]_, and ends early
    (``terminated``) where the person has fallen or lost the way, or the simulation has diverged;
    ``truncated`` after its ``duration``, or where a reference that is no walk ends.

    Args:
        reference: Whom and what to follow, as in :class:`~plantigrade.learn.following.Rules`.
        render_mode: None; look at :meth:`record` instead.
        rules: Fields of :class:`~plantigrade.learn.following.Rules` by name: ``form="paper"``,
            ``gains=True``, ``ground="bumps:2"``, …

    Raises:
        ParameterError: If a value is not allowed, or the reference cannot be followed.
        MissingExtra: If Gymnasium is not installed.

    Attributes:
        following: The person, and what is followed.
    """

    metadata = {"render_modes": []}

    def __init__(self, reference: Any = None, *, render_mode: str | None = None, **rules: Any):
        if render_mode is not None:
            raise ParameterError("render_mode must be None: save a run of record() and view that")
        self.render_mode = None
        self.following = Following(_rules(reference, rules))
        self.observation_space, self.action_space = spaces(self.following)

    @property
    def world(self) -> World:
        """The world."""
        return self.following.worlds[0]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode on the reference.

        Args:
            seed: Seed of the random numbers of this environment, from now on.
            options: ``{"phase": …}``: at which part of the stride, from 0 to 1.

        Raises:
            ParameterError: If the phase is none.
        """
        super().reset(seed=seed)
        where = _start(self.following, options)
        part = self.np_random.random() if where is None else where
        self.following.begin([0], [part], [int(self.np_random.integers(2**31))])
        return self.following.seen()[0], {"phase": self.phase}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Let one decision act, held for one control step.

        ``info`` has the terms of the reward by name, ``phase``, and ``end``: why the episode ended.

        Raises:
            ParameterError: If the action has another size, or is not finite.
        """
        rewards, (end,), over, terms = self.following.step(np.asarray(action)[None])
        info: dict[str, Any] = {name: float(value[0]) for name, value in terms.items()}
        info |= {"phase": self.phase, "end": end}
        seen = self.following.seen()[0]
        if end == DIVERGED:
            seen = np.zeros_like(seen)
        return seen, float(rewards[0]), bool(end), bool(over[0]), info

    @property
    def phase(self) -> float:
        """Which part of the stride has passed, from 0 to 1."""
        return float(self.following.phase[0])

    def record(self) -> Record:
        """Return the episode so far, for report and viewer.

        Raises:
            ParameterError: If the environment was made without ``recording``.
        """
        return self.world.record()


class Walks(gymnasium.vector.VectorEnv):
    """Many persons who track a walk, in one process.

    What is seen and rewarded is computed for all of them at once. An episode that has ended begins
    anew in the same step: its last sight is ``infos["final_obs"]``, where ``infos["_final_obs"]``
    says so, and likewise ``final_info`` with ``end``.

    Args:
        num_envs: How many.
        reference: As for :class:`Walk`.
        rules: Likewise.

    Raises:
        ParameterError: As :class:`Walk`.
    """

    metadata = {
        "render_modes": [],
        "autoreset_mode": gymnasium.vector.AutoresetMode.SAME_STEP,
    }

    def __init__(self, num_envs: int = 1, reference: Any = None, **rules: Any):
        if num_envs < 1:
            raise ParameterError(f"num_envs={num_envs} must be 1 or more")
        self.num_envs, self.render_mode = num_envs, None
        self.following = Following(_rules(reference, rules), num_envs)
        own = spaces(self.following)
        self.single_observation_space, self.single_action_space = own
        self.observation_space, self.action_space = (
            gymnasium.vector.utils.batch_space(space, num_envs) for space in own
        )

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start all episodes.

        Args:
            seed: Seed of the random numbers of all, from now on.
            options: As of :meth:`Walk.reset`, for all of them.

        Raises:
            ParameterError: As :meth:`Walk.reset`.
        """
        if isinstance(seed, list):
            known = [s for s in seed if s is not None]
            seed = int(np.random.SeedSequence(known).generate_state(1)[0]) if known else None
        super().reset(seed=seed)
        self._begin(list(range(self.num_envs)), _start(self.following, options))
        return self.following.seen(), {"phase": self.following.phase}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Let one decision of everybody act, held for one control step.

        Raises:
            ParameterError: As :meth:`Walk.step`.
        """
        rewards, ends, truncated, terms = self.following.step(actions)
        terminated = np.array([bool(end) for end in ends])
        seen, phase = self.following.seen(), self.following.phase
        for i, end in enumerate(ends):
            if end == DIVERGED:
                seen[i] = 0.0
        done = terminated | truncated
        infos: dict[str, Any] = {**terms, "phase": phase}
        if done.any():
            which = np.flatnonzero(done).tolist()
            infos["final_obs"], infos["_final_obs"] = seen, done
            infos["final_info"] = {"end": np.array(ends, dtype=object), "_end": done}
            infos["_final_info"] = done
            self._begin(which, self.following.rules.start)
            seen = self.following.seen()
        return seen, rewards, terminated, truncated, infos

    def _begin(self, which: list[int], start: float | None) -> None:
        parts = self.np_random.random(len(which)) if start is None else [start] * len(which)
        seeds = self.np_random.integers(2**31, size=len(which))
        self.following.begin(which, [float(p) for p in parts], [int(s) for s in seeds])


def spaces(following: Following) -> tuple[Any, Any]:
    """Return the observation and action spaces of one person."""
    wide = np.full(len(following.observation), np.inf, dtype=np.float32)
    one = np.ones(len(following.action), dtype=np.float32)
    box = gymnasium.spaces.Box
    return box(-wide, wide, dtype=np.float32), box(-one, one, dtype=np.float32)


def _start(following: Following, options: dict[str, Any] | None) -> float | None:
    """Return at which part of the stride episodes begin; None where it is random."""
    return part_of_stride("phase", (options or {}).get("phase", following.rules.start))


def _rules(reference: Any, rules: dict[str, Any]) -> Rules:
    refuse_unknown("Walk", rules, [f.name for f in fields(Rules)])
    return Rules(reference=reference, **rules)
