"""Persons who track a walk in several worlds at once, the basis of both environments."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State as BodyState
from plantigrade.learn.action import PAPER_GAINS, Action, Gains
from plantigrade.learn.disturbed import RandomPushes, Relief
from plantigrade.learn.mirror import Mirror, refuse_uneven
from plantigrade.learn.observation import Observation
from plantigrade.learn.reference import Frame, Reference
from plantigrade.learn.reward import LEAN_WEIGHTS, Reward, Weights
from plantigrade.learn.view import View
from plantigrade.models import Human
from plantigrade.options import shown
from plantigrade.record import Record, Run
from plantigrade.world import Disturbance, StablePD, World, on_ground
from plantigrade.world.batch_motors import BatchMotors
from plantigrade.world.grounds import ground_named, platform_named

RATE, CONTROL_RATE = 150.0, 30.0
"""Steps of the physics, and of the policy, by default [1/s]."""
SWEEPS = 10
"""Sweeps of the solver of contacts (PGS). Joints are then off by 0.03 rad/s in a decision, and a
blind policy falls when it fell; Newton's method to the end takes half as long again."""
FORMS = ("lean", "paper")
LOST, PUSHED = 0.6, 1.2
"""A centre of mass farther than this from its path is lost; where it is pushed off it [m]."""
LOW = 0.7
"""A pelvis lower than this has fallen, of its height in standing."""
UPRIGHT = 0.5
"""Cosine of the greatest angle between the pelvis' long axis and the vertical."""
FELL, ASTRAY, DIVERGED = "fell", "lost", "diverged"


@dataclass(frozen=True, kw_only=True, eq=False)
class Rules:
    """Rules of an episode.

    Attributes:
        reference: Whom and what to follow: a run (recorded and fitted, rebuilt, or synthesised),
            its folder, a :class:`~plantigrade.record.Record` or a
            :class:`~plantigrade.learn.reference.Reference`. The published mean walk on a person of
            66 coordinates if absent.
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
        terrain: Relief up to so high and so deep, another in every episode, on level ground; none
            if zero [m].
        pushes: Pushes up to so hard, from anywhere (:class:`RandomPushes`); none if zero [N].
        duration: Longest episode [s].
        rate: Steps of the physics per second, a whole multiple of ``control_rate`` [1/s].
        control_rate: Decisions per second [1/s].
        passive: Whether joints resist by themselves, as tissue does; the paper's do not.
        recording: Whether episodes are recorded; it costs a tenth.
        start: At which part of the stride every episode begins, from 0 to 1; random if absent.
        mirrored: Whether the second half of the stride is seen and done in a mirror, so that it is
            the first one again; in ``"lean"``, for a reference that is even to both sides.

    Raises:
        ParameterError: If a value is not allowed.
    """

    reference: str | Path | Run | Record | Reference | None = None
    form: str = "lean"
    gains: bool | None = None
    base: Gains | None = None
    weights: Weights | None = None
    reach: float | None = None
    ground: Ground | str = "flat"
    disturbances: Sequence[Disturbance] = ()
    terrain: float = 0.0
    pushes: float = 0.0
    duration: float = 10.0
    rate: float = RATE
    control_rate: float = CONTROL_RATE
    passive: bool = False
    recording: bool = False
    start: float | None = None
    mirrored: bool = False

    def __post_init__(self):
        """Refuse what cannot be."""
        if self.form not in FORMS:
            raise ParameterError(f"form={self.form!r} must be one of {', '.join(FORMS)}")
        if not self.duration > 0:
            raise ParameterError(f"duration={self.duration:g} s must be positive")
        if self.reach is not None and not 0.0 < self.reach < np.inf:
            raise ParameterError(f"reach={self.reach:g} rad must be positive")
        if self.mirrored and self.form != "lean":
            raise ParameterError("mirrored=True needs form='lean'")
        if self.terrain and self.ground != "flat":
            raise ParameterError("terrain and ground cannot be combined; give one")
        part_of_stride("start", self.start)

    def world(self, human: Human) -> World:
        """Return a world of such an episode."""
        ground = self.ground
        plate = platform_named(ground) if isinstance(ground, str) else None
        if isinstance(ground, str):
            ground = ground_named("flat" if plate else ground)
        if self.terrain:
            ground = Relief(self.terrain).ground()
        acting = [] if plate is None else [plate]
        acting += [RandomPushes(force=self.pushes)] if self.pushes else []
        world = World(
            human,
            ground,
            (*acting, *self.disturbances),
            rate=self.rate,
            control_rate=self.control_rate,
            passive=self.passive,
            recording=self.recording,
            exact_limits=False,
        )
        world.model.opt.solver = mujoco.mjtSolver.mjSOL_PGS
        world.model.opt.iterations = SWEEPS
        return world


def part_of_stride(name: str, part: Any) -> float | None:
    """Return the phase at which an episode starts, or None if it is random.

    Raises:
        ParameterError: If it is no number from 0 to 1.
    """
    if part is None:
        return None
    if not isinstance(part, Real) or not 0.0 <= float(part) <= 1.0:
        raise ParameterError(f"{name}={shown(part)} must be a part of a stride, from 0 to 1")
    return float(part)


class Form:
    """Observations and actions of a policy under given rules.

    Args:
        human: The person.
        rules: The rules.

    Attributes:
        action: Which numbers of an action are what.
        observation: Likewise of what is seen.
    """

    def __init__(self, human: Human, rules: Rules):
        lean = rules.form == "lean"
        self.action = Action(
            human,
            rules.base or (Gains() if lean else PAPER_GAINS),
            all_joints=not lean,
            variable=not lean if rules.gains is None else rules.gains,
            reach=(0.6 if lean else 1.0) if rules.reach is None else rules.reach,
            lead=lean,
        )
        self.observation = Observation(human, lean=lean)
        self._mirror = Mirror(human, self.action) if rules.mirrored else None

    def seen(
        self, view: View, frame: Frame, phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n size"]:
        """Return what is seen.

        Args:
            view: The persons.
            frame: Where they should be.
            phase: Part of the stride that has passed.
        """
        seen = self.observation.of(view, frame, phase)
        if self._mirror is not None:
            late = phase >= 0.5
            seen[late] = self._mirror.seen(seen[late])
        return seen

    def meant(
        self, action: Float[np.ndarray, "n k"], phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n k"]:
        """Return what actions mean that were decided at some phase: within ±1, of their own side.

        Raises:
            ParameterError: If there is not a row of finite numbers for everybody.
        """
        bounded = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        persons, size = len(phase), len(self.action)
        if bounded.shape != (persons, size) or not np.isfinite(bounded).all():
            raise ParameterError(f"an action must be {size} finite numbers, for {persons} persons")
        if self._mirror is not None:
            late = phase >= 0.5
            bounded[late] = self._mirror.done(bounded[late])
        return bounded


class Following:
    """Persons in worlds of their own, all tracking one reference.

    Args:
        rules: Rules of an episode.
        n: How many persons.

    Attributes:
        reference: What they follow.
        worlds: Their worlds.
        form: What they see and do.
        weights: What they are rewarded for.
        action: Which numbers of an action are what.
        observation: Likewise of what is seen.
    """

    def __init__(self, rules: Rules, n: int = 1):
        lean = rules.form == "lean"
        self.rules, self.reference = rules, Reference.of(rules.reference)
        human = self.reference.human
        self.worlds = tuple(rules.world(human) for _ in range(n))
        if rules.mirrored:
            refuse_uneven(self.reference)
        self.form = Form(human, rules)
        self.action, self.observation = self.form.action, self.form.observation
        self.weights = rules.weights or (LEAN_WEIGHTS if lean else Weights())
        self._reward = Reward(self.reference, self.weights)
        self._motors = BatchMotors(self.worlds)
        self._view = View(human, [(w.model, w.data) for w in self.worlds])
        rest = BodyState(human, human.standing())
        self._feet = np.array([human.body(f"foot_{side}") for side in SIDES]) - 1
        self._ankle = min(float(rest.origin(f"foot_{side}")[2]) for side in SIDES)
        self._low = LOW * float(human.standing()[2])
        self._begin, self._rising = np.zeros(n), np.zeros(n)
        self._relief = Relief(rules.terrain) if rules.terrain else None
        self._lost = PUSHED if rules.pushes else LOST
        self._same = not self.action.joints and not rules.passive
        ground = self.worlds[0].ground
        self._even = ground == Ground(friction=ground.friction)

    @property
    def settled(self) -> Rules:
        """The rules, with all that they leave to their form."""
        action = self.action
        return replace(
            self.rules,
            reference=self.reference,
            gains=bool(action.joints),
            base=action.gains,
            reach=action.reach,
        )

    @property
    def time(self) -> Float[Array, " n"]:
        """Time on the clock of the reference [s]."""
        return self._begin + [world.time for world in self.worlds]

    @property
    def phase(self) -> Float[Array, " n"]:
        """Which part of the stride has passed, from 0 to 1."""
        return np.asarray(self.reference.phase(self.time))

    def begin(self, which: Sequence[int], parts: Sequence[float], seeds: Sequence[int]) -> None:
        """Put some persons on the reference.

        Args:
            which: Which of them.
            parts: Where on the stride each begins, from 0 to 1.
            seeds: Seeds of their worlds.
        """
        for i, part, seed in zip(which, parts, seeds, strict=True):
            world, self._begin[i] = self.worlds[i], part * self.reference.period
            frame = self.reference.at(float(self._begin[i]))
            qpos = frame.qpos.copy()
            if self._even:
                qpos[2] += frame.depth
            else:
                if self._relief is not None:
                    self._relief.lay(world, int(seed))
                qpos = on_ground(self.reference.human, world.ground, qpos)
            world.reset(int(seed), qpos=qpos, qvel=frame.qvel)
            if self._same:
                stiffness, damping = self.action.fixed
                command = StablePD(qpos[7:], stiffness=stiffness, damping=damping)
                world.actuators.command(command, world.data)
        self._view.look(which)
        self._rising[list(which)] = self._view.rising[list(which)]

    def seen(self) -> Float[np.ndarray, "n size"]:
        """Return what the persons see."""
        time = self.time
        phase = np.asarray(self.reference.phase(time))
        return self.form.seen(self._view, self.reference.at(time), phase)

    def step(
        self, action: Float[np.ndarray, "n k"]
    ) -> tuple[Float[Array, " n"], list[str], Any, dict[str, Float[Array, " n"]]]:
        """Let decisions act, held for one control step.

        Returns:
            Rewards; why each episode has ended, empty if it has not; whether each is over without
            that; the terms of the rewards.

        Raises:
            ParameterError: If there is not a row of finite numbers for everybody.
        """
        time = self.time
        bounded = self.form.meant(action, np.asarray(self.reference.phase(time)))
        time = time + 1.0 / self.worlds[0].control_rate
        frame = self.reference.at(time)
        self._move(bounded, frame)
        whole = [i for i, world in enumerate(self.worlds) if world.diverged is None]
        self._view.look(whole)
        rising = self._view.rising
        force = 1.0 + (rising - self._rising) * self.worlds[0].control_rate / GRAVITY
        self._rising = rising
        phase = np.asarray(self.reference.phase(time))
        rewards, terms = self._reward.of(self._view, frame, phase, force)
        ends = self._ends(frame)
        rewards = np.where([end == DIVERGED for end in ends], 0.0, rewards)
        over = time - self._begin >= self.rules.duration - 1e-9
        if not self.reference.cyclic:
            over |= time >= self.reference.period
        return rewards, ends, over & [not end for end in ends], terms

    def _move(self, action: Float[Array, "n k"], frame: Any) -> None:
        target, lead = self.action.targets(action, frame), self.action.lead
        rates = frame.qvel[:, 6:]
        if self._same:
            stiffness, damping = self.action.fixed
            force = stiffness * target
            if lead:
                force += damping * rates
            for world, each in zip(self.worlds, force, strict=True):
                world.actuators.set_force(world.data, each)
                world.repeat_command()
            return
        stiffness, damping = self.action.gains_of(action)
        force = stiffness * target
        if lead:
            force += damping * rates
        self._motors.command(self._view.angles, force, stiffness, damping)
        for world in self.worlds:
            world.repeat_command()

    def _ends(self, frame: Any) -> list[str]:
        """Return why episodes end here; empty where they do not."""
        view = self._view
        x, y = view.quat[:, 1], view.quat[:, 2]
        down = 1.0 - 2.0 * (x * x + y * y) < UPRIGHT
        height = view.place[:, 0, 2] - view.place[:, self._feet, 2].min(axis=1) + self._ankle
        down |= height < self._low
        off = view.com - frame.com
        lost = np.einsum("ij,ij->i", off, off) > self._lost**2
        ends = []
        for world, fell, astray in zip(self.worlds, down.tolist(), lost.tolist(), strict=True):
            if world.diverged is not None:
                ends.append(DIVERGED)
            elif fell or world.fall is not None:
                ends.append(FELL)
            else:
                ends.append(ASTRAY if astray else "")
        return ends
