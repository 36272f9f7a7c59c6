"""Tracking a reference walk as a Gymnasium environment, ``plantigrade/Walk-v0``.

::

    import gymnasium
    import plantigrade.learn

    env = gymnasium.make("plantigrade/Walk-v0", reference="runs/fit-walk")
    observation, info = env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

Parallel environments in one process take half the time per environment::

    envs = gymnasium.make_vec("plantigrade/Walk-v0", num_envs=16)
"""

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.extras import require
from plantigrade.learn.parallel_tracking import DIVERGED, ParallelTracking
from plantigrade.learn.rules import Rules, check_phase
from plantigrade.options import refuse_unknown
from plantigrade.record import Record
from plantigrade.world import World

if TYPE_CHECKING:
    import gymnasium
else:
    gymnasium = require("gymnasium", "learn")
    require("gymnasium.vector", "learn")


class WalkEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """A person who tracks a reference walk, at 30 decisions per second.

    Every episode begins at a random phase of the reference [DeepMimic]_. It is ``terminated`` when
    the person falls or loses the reference, or the simulation diverges, and ``truncated`` after its
    ``duration``, or at the end of a reference that is not cyclic.

    Args:
        reference: Reference motion and person, as in :class:`~plantigrade.learn.rules.Rules`.
        render_mode: None; see :meth:`record` instead.
        rules: Fields of :class:`~plantigrade.learn.rules.Rules` by name: ``form="paper"``,
            ``gains=True``, ``ground="bumps:2"``, …

    Raises:
        ParameterError: If a value is not allowed, or the reference cannot be tracked.
        MissingExtra: If Gymnasium is not installed.

    Attributes:
        tracking: The person and the reference.
    """

    metadata = {"render_modes": []}

    def __init__(self, reference: Any = None, *, render_mode: str | None = None, **rules: Any):
        if render_mode is not None:
            raise ParameterError("render_mode must be None: save a run of record() and view that")
        self.render_mode = None
        self.tracking = ParallelTracking(_rules(reference, rules))
        self.observation_space, self.action_space = spaces(self.tracking)

    @property
    def world(self) -> World:
        """The world."""
        return self.tracking.worlds[0]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode on the reference.

        Args:
            seed: Seed of the random numbers of this environment, from now on.
            options: ``{"phase": …}`` is the initial phase of the stride, from 0 to 1.

        Raises:
            ParameterError: If the phase is out of range.
        """
        super().reset(seed=seed)
        where = _start(self.tracking, options)
        part = self.np_random.random() if where is None else where
        self.tracking.start_episodes([0], [part], [int(self.np_random.integers(2**31))])
        return self.tracking.observations()[0], {"phase": self.phase}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Apply an action for one control step.

        ``info`` has the terms of the reward by name, ``phase``, and ``end``, the reason why the
        episode ended.

        Raises:
            ParameterError: If the action has another size, or is not finite.
        """
        rewards, (end,), over, terms = self.tracking.step(np.asarray(action)[None])
        info: dict[str, Any] = {name: float(value[0]) for name, value in terms.items()}
        info |= {"phase": self.phase, "end": end}
        seen = self.tracking.observations()[0]
        if end == DIVERGED:
            seen = np.zeros_like(seen)
        return seen, float(rewards[0]), bool(end), bool(over[0]), info

    @property
    def phase(self) -> float:
        """Phase of the stride, from 0 to 1."""
        return float(self.tracking.phase[0])

    def record(self) -> Record:
        """Return the episode so far, for report and viewer.

        Raises:
            ParameterError: If the environment was made without ``recording``.
        """
        return self.world.record()


class Walks(gymnasium.vector.VectorEnv):
    """Parallel environments of persons who track a reference walk, in one process.

    Observations and rewards are computed for all of them at once. An episode that has ended
    restarts in the same step: its last observation is ``infos["final_obs"]`` where
    ``infos["_final_obs"]`` is true, and likewise ``final_info`` with ``end``.

    Args:
        num_envs: Number of environments.
        reference: Reference, as for :class:`Walk`.
        rules: Rules, as for :class:`Walk`.

    Raises:
        ParameterError: As :class:`Walk`.
    """

    metadata = {"render_modes": [], "autoreset_mode": gymnasium.vector.AutoresetMode.SAME_STEP}

    def __init__(self, num_envs: int = 1, reference: Any = None, **rules: Any):
        if num_envs < 1:
            raise ParameterError(f"num_envs={num_envs} must be 1 or more")
        self.num_envs, self.render_mode = num_envs, None
        self._random = [np.random.default_rng() for _ in range(num_envs)]
        self.tracking = ParallelTracking(_rules(reference, rules), num_envs)
        own = spaces(self.tracking)
        self.single_observation_space, self.single_action_space = own
        self.observation_space, self.action_space = (
            gymnasium.vector.utils.batch_space(space, num_envs) for space in own
        )

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start all episodes.

        Args:
            seed: Seed of the random numbers of each environment, from now on; a number is that of
                the first, followed by the next numbers.
            options: Options of :meth:`Walk.reset`, for all environments.

        Raises:
            ParameterError: As :meth:`Walk.reset`.
        """
        if not isinstance(seed, list):
            seed = [None if seed is None else seed + i for i in range(self.num_envs)]
        super().reset(seed=seed[0])
        for i, own in enumerate(seed):
            if own is not None:
                self._random[i] = np.random.default_rng(own)
        self._begin(list(range(self.num_envs)), _start(self.tracking, options))
        return self.tracking.observations(), {"phase": self.tracking.phase}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Apply one action per environment for one control step.

        Raises:
            ParameterError: As :meth:`Walk.step`.
        """
        rewards, ends, truncated, terms = self.tracking.step(actions)
        terminated = np.array([bool(end) for end in ends])
        seen, phase = self.tracking.observations(), self.tracking.phase
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
            self._begin(which, self.tracking.rules.start)
            seen = self.tracking.observations()
        return seen, rewards, terminated, truncated, infos

    def _begin(self, which: list[int], start: float | None) -> None:
        random = [self._random[i] for i in which]
        parts = [float(own.random()) if start is None else start for own in random]
        self.tracking.start_episodes(which, parts, [int(own.integers(2**31)) for own in random])


def spaces(tracking: ParallelTracking) -> tuple[Any, Any]:
    """Return the observation and action spaces of one person."""
    wide = np.full(len(tracking.observation), np.inf, dtype=np.float32)
    one = np.ones(len(tracking.action), dtype=np.float32)
    box = gymnasium.spaces.Box
    return box(-wide, wide, dtype=np.float32), box(-one, one, dtype=np.float32)


def _start(tracking: ParallelTracking, options: dict[str, Any] | None) -> float | None:
    """Return the initial phase of episodes; None if it is random."""
    return check_phase("phase", (options or {}).get("phase", tracking.rules.start))


def _rules(reference: Any, rules: dict[str, Any]) -> Rules:
    refuse_unknown("Walk", rules, [f.name for f in fields(Rules)])
    return Rules(reference=reference, **rules)
