"""Walking after a reference as a Gymnasium environment, ``plantigrade/Walk-v0``.

::

    import gymnasium
    import plantigrade.learn

    env = gymnasium.make("plantigrade/Walk-v0", reference="runs/fit-walk")
    observation, info = env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.extras import require
from plantigrade.kinematics.state import State as BodyState
from plantigrade.learn.action import PAPER_GAINS, Action, Gains
from plantigrade.learn.observation import Observation
from plantigrade.learn.reference import Frame, Heading, Reference
from plantigrade.learn.reward import LEAN_WEIGHTS, Reward, Weights
from plantigrade.record import Record, Run
from plantigrade.world import Disturbance, World, on_ground
from plantigrade.world.grounds import ground_named, platform_named

if TYPE_CHECKING:
    import gymnasium
else:
    gymnasium = require("gymnasium", "learn")

RATE, CONTROL_RATE = 150.0, 30.0
"""Steps of the physics, and of the policy, by default [1/s]."""
TOLERANCE = 1e-5
"""Of the solver of contacts: rates of joints are then within 1e-4 rad/s in a control step."""
FORMS = ("lean", "paper")
LOST = 0.6
"""A centre of mass farther than this from its path is lost [m]."""
LOW = 0.7
"""A pelvis lower than this has fallen, of its height in standing."""
UPRIGHT = 0.5
"""Cosine of the greatest angle between the pelvis' long axis and the vertical."""


class Walk(gymnasium.Env[np.ndarray, np.ndarray]):
    """A person who is to follow a walk, at 30 decisions per second.

    Every episode begins on the reference, at a random instant of it [DeepMimic]_, and ends early
    (``terminated``) where the person has fallen or lost the way, or the simulation has diverged;
    ``truncated`` after ``duration``, or where a reference that is no walk ends.

    Args:
        reference: Whom and what to follow: a run (recorded and fitted, rebuilt, or synthesised),
            its folder, a :class:`~plantigrade.record.Record` or a :class:`Reference`. The published
            mean walk on a person of 66 coordinates if absent.
        form: ``"lean"``, with which walking was learned in a million steps: the joints of the body
            are displaced, the rates of the reference are known to the motors, and the person sees
            how far it is off; or ``"paper"``, state and action as [Park2020]_ prints them.
        gains: Whether gains of the feet are in the action; so in ``"paper"`` if absent.
        base: The gains; those of the form if absent.
        weights: Weights of the reward; those of the form if absent.
        reach: Displacement of a joint for an action of 1; 0.6 in ``"lean"``, 1 in ``"paper"`` if
            absent [rad].
        ground: What the person walks on, or its name (``"bumps:2"``, ``"tilting:3"``).
        disturbances: What else acts; their times are those of the episode.
        duration: Longest episode [s].
        rate: Steps of the physics per second, a whole multiple of ``control_rate`` [1/s].
        control_rate: Decisions per second [1/s].
        passive: Whether joints resist by themselves, as tissue does; the paper's do not.
        recording: Whether :meth:`record` is wanted; it costs a tenth.
        start: At which part of the stride every episode begins, from 0 to 1; random if absent.
        render_mode: None; look at :meth:`record` instead.

    Raises:
        ParameterError: If a value is not allowed, or the reference cannot be followed.
        MissingExtra: If Gymnasium is not installed.

    Attributes:
        reference: The reference.
        world: The world.
        action: Which numbers of an action are what.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        reference: str | Path | Run | Record | Reference | None = None,
        *,
        form: str = "lean",
        gains: bool | None = None,
        base: Gains | None = None,
        weights: Weights | None = None,
        reach: float | None = None,
        ground: Ground | str = "flat",
        disturbances: Sequence[Disturbance] = (),
        duration: float = 10.0,
        rate: float = RATE,
        control_rate: float = CONTROL_RATE,
        passive: bool = False,
        recording: bool = False,
        start: float | None = None,
        render_mode: str | None = None,
    ):
        if form not in FORMS:
            raise ParameterError(f"form={form!r} must be one of {', '.join(FORMS)}")
        if not duration > 0:
            raise ParameterError(f"duration={duration:g} s must be positive")
        if start is not None and not 0.0 <= start <= 1.0:
            raise ParameterError(f"start={start:g} must be a part of a stride, from 0 to 1")
        if render_mode is not None:
            raise ParameterError("render_mode must be None: save a run of record() and look at it")
        lean = form == "lean"
        self.render_mode, self.start, self.duration = None, start, float(duration)
        self.reference = Reference.of(reference)
        human = self.reference.human
        self.action = Action(
            human,
            base or (Gains() if lean else PAPER_GAINS),
            all_joints=not lean,
            variable=not lean if gains is None else gains,
            reach=reach or (0.6 if lean else 1.0),
            lead=lean,
        )
        plate = platform_named(ground) if isinstance(ground, str) else None
        if isinstance(ground, str):
            ground = ground_named("flat" if plate else ground)
        self._even = ground == Ground(friction=ground.friction)
        self.world = World(
            human,
            ground,
            (*(() if plate is None else (plate,)), *disturbances),
            rate=rate,
            control_rate=control_rate,
            passive=passive,
            recording=recording,
            exact_limits=False,
        )
        self.world.model.opt.tolerance = TOLERANCE
        self._see = Observation(self.world, lean=lean)
        self._reward = Reward(self.world, weights or (LEAN_WEIGHTS if lean else Weights()))
        rest = BodyState(human, human.standing())
        self._feet = [human.body(f"foot_{side}") for side in SIDES]
        self._ankle = min(float(rest.origin(f"foot_{side}")[2]) for side in SIDES)
        self._low = LOW * float(human.standing()[2])
        self._begin, self._now = 0.0, self.reference.at(0.0)
        wide = np.full(len(self._see), np.inf, dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-wide, wide, dtype=np.float32)
        one = np.ones(len(self.action), dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-one, one, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode on the reference.

        Args:
            seed: Seed of the random numbers of this environment, from now on.
            options: ``{"phase": …}``: at which part of the stride, from 0 to 1.
        """
        super().reset(seed=seed)
        where = (options or {}).get("phase", self.start)
        part = self.np_random.random() if where is None else float(where)
        self._begin = part * self.reference.period
        self._now = frame = self.reference.at(self._begin)
        qpos = frame.qpos.copy()
        if self._even:
            qpos[2] += frame.depth
        else:
            qpos = on_ground(self.reference.human, self.world.ground, qpos)
        self.world.reset(int(self.np_random.integers(2**31)), qpos=qpos, qvel=frame.qvel)
        phase = self.phase
        return self._see.of(self._refresh(), frame, phase), {"phase": phase}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Let one decision act, held for one control step.

        ``info`` has the terms of the reward by name, ``phase``, and ``end``: why the episode ended.
        """
        world = self.world
        bounded = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        time = self._begin + world.time + 1.0 / world.control_rate
        self._now = frame = self.reference.at(time)
        world.advance(self.action.command(bounded, frame))
        if world.diverged is not None:
            nothing = np.zeros(len(self._see), dtype=np.float32)
            return nothing, 0.0, True, False, {"phase": self.phase, "end": "diverged"}
        turn = self._refresh()
        end, phase = self._end(frame), self.phase
        seen = self._see.of(turn, frame, phase)
        reward, info = self._reward.of(turn, frame)
        over = not self.reference.cyclic and time >= self.reference.period
        long = world.time >= self.duration - 1e-9
        more = {**info, "phase": phase, "end": end}
        return seen, reward, bool(end), not end and (over or long), more

    @property
    def phase(self) -> float:
        """Which part of the stride has passed, from 0 to 1."""
        return self.reference.phase(self._begin + self.world.time)

    def record(self) -> Record:
        """Return the episode so far, for report and viewer.

        Raises:
            ParameterError: If the environment was made without ``recording``.
        """
        return self.world.record()

    def _refresh(self) -> Heading:
        """Bring MuJoCo's kinematics up to date: a step leaves them one step behind."""
        model, data = self.world.model, self.world.data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        return Heading(data.qpos[3:7])

    def _end(self, frame: Frame) -> str:
        """Return why the episode ends here; empty if it does not."""
        data = self.world.data
        w, x, y, z = data.qpos[3:7].tolist()
        if self.world.fall is not None or 1.0 - 2.0 * (x * x + y * y) < UPRIGHT:
            return "fell"
        place = data.xpos
        height = data.qpos[2] - min(place[foot, 2] for foot in self._feet) + self._ankle
        if height < self._low:
            return "fell"
        off = data.subtree_com[1] - frame.com
        return "lost" if off @ off > LOST**2 else ""
