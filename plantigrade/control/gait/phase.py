"""The clock of a gait: its phase, which feet are in stance, and their offsets from the motion.

Feet land when they touch, sooner or later than planned. An early touchdown puts the foot in stance
at once, and the phase hurries after it. Where the ground is missing the phase waits and the foot
descends. Then the phase slowly returns to the time, and its mean rate is 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.reference import ReferenceTables
from plantigrade.control.gait.step import StepSettings
from plantigrade.control.gait.swing import SwingOffset, SwingOffsetSettings
from plantigrade.wbc.forces import ForceSettings
from plantigrade.wbc.tasks.contact import ContactSettings


@dataclass(frozen=True, kw_only=True)
class FootContactSettings:
    """When a foot touches, and which of its points do."""

    touchdown_load: float = LoadSettings.min_foot_load
    """Load from which a swing foot has touched down, and from which the position of a stance foot
    counts [body weights]; below it, recorded feet are in the air, too."""
    max_height: float = ContactSettings.touching_height
    """Height of a point of a stance foot above the ground up to which it touches [m]."""
    max_planned_height: float = ForceSettings.carrying_height
    """The same of a point that the motion has in contact [m]; as carries in strict orders."""
    unloaded_share: float = 0.25
    """Share of the load of both feet below which the rear foot is lifted in a recovery step [1]:
    waiting for its recorded lift-off took 70 to 90 ms, in which a fall to the side grew by a fifth.
    Chosen."""
    unloaded_time: float = 0.015
    """Time below that share after which the rear foot is lifted [s]: three ticks, because loads
    jump from tick to tick after a strike. Chosen."""
    transfer_time: float = StepSettings.load_transfer_duration
    """Time in double support after which the rear foot is lifted in a recovery step after a push,
    whatever it bears [s]; as in recovery steps from standing. Soles yield before they bear: a foot
    that had landed softly across the other took 0.1 s to unload the rear one, over which the body
    fell."""
    friction_fraction: float = 0.75
    """Part of the friction coefficient that a controller uses. Chosen (±20 %: deviation 29 %)."""


@dataclass(frozen=True, kw_only=True)
class GaitPhaseSettings:
    """The clock of a gait, and its contacts and swing feet."""

    contact: FootContactSettings = FootContactSettings()
    swing: SwingOffsetSettings = SwingOffsetSettings()
    min_touchdown_phase: float = 0.6
    """Part of a swing after which contact is a touchdown. Chosen (±20 %: deviation 11 %)."""
    early_rate: float = 1.5
    """Least rate of the phase after an early touchdown, and in double support after a recovery
    step. Chosen (±20 %: deviation 25 %)."""
    late_descent_speed: float = 0.5
    """Speed at which a foot descends that misses the ground, until the phase no longer waits for it
    [m/s]. Chosen (±20 %: deviation 7 %)."""
    max_wait: float = StepSettings().step_time
    """Time for which the phase waits for a foot [s]: that of the fastest recovery step."""
    stance_time: float = StepSettings.load_transfer_duration
    """Time constant of the offset of a stance foot [s], which settles while it takes its load."""
    rate_time: float = 0.02
    """Time constant of the rate of the phase [s]. Chosen (±20 %: deviation 7 %)."""
    return_rate: float = 0.2
    """Rate at which a walk returns to its time and to its path, and a lasting error of its speed is
    corrected [1/s]. Chosen (±20 %: deviation 17 %)."""
    max_recovery: float = 0.05
    """Greatest change of the rate for that. Chosen (±20 %: deviation 5 %)."""
    joint_damping: float = 0.012
    """Damping of the joints about the planned velocity, by their strength [s/rad]. Chosen (±20 %:
    deviation 7 %)."""

    def double_support_rate(self, recovery_share: float) -> float:
        """Return the phase rate in double support, by how much the step is a recovery."""
        return 1.0 + (self.early_rate - 1.0) * recovery_share


@dataclass
class Foot:
    """A foot of a gait."""

    side: str  #: Its side
    #: Number of its stance, or of the next one while it swings; None if there is none
    stance: int | None
    in_stance: bool = True  #: Whether it is in stance
    touchdown: float = -np.inf  #: Beginning of that stance, on the clock of the phase [s]
    lift_off: float = 0.0  #: Time of lift-off, likewise [s]
    #: Its offset from the motion while it swings
    swing: SwingOffset = field(default_factory=lambda: SwingOffset(np.zeros(2)))
    descent: float = 0.0  #: Descent below the motion, for missing ground [m]
    wait: float = 0.0  #: Time for which the phase has waited for it [s]
    early: bool = False  #: Whether it is in stance before its time
    unloaded: float = 0.0  #: Time without load after an early touchdown [s]
    recovering: bool = False  #: Whether it swings in a recovery step that the motion does not have

    @property
    def side_sign(self) -> float:
        """1 for the left foot, -1 for the right."""
        return 1.0 if self.side == "l" else -1.0


@dataclass(frozen=True)
class Touchdown:
    """A touchdown."""

    time: float  #: Time [s]
    side: str  #: Side of the foot
    #: Time before the planned touchdown on the clock of the phase, negative after it [s]
    early: float
    offset: Float[Array, " 3"]  #: Offset from the motion, world [m]
    axes: Float[Array, "2 2"]  #: Ahead and to the left then, as columns


class GaitState:
    """Phase, feet and their offsets.

    Args:
        weight: Weight of the person [N].
        phase: Time of the motion at the start [s].

    Attributes:
        phase: Time of the motion [s].
        rate: Its rate.
        feet: Right and left foot.
        touchdowns: All touchdowns since the start.
    """

    def __init__(
        self,
        reference: ReferenceTables,
        weight: float,
        phase: float = 0.0,
        settings: GaitPhaseSettings | None = None,
    ):
        self.reference, self.weight = reference, weight
        self.settings = settings or GaitPhaseSettings()
        self.phase, self.rate = phase, 1.0
        self._offsets = np.zeros((64, 3))
        self.touchdowns: list[Touchdown] = []
        self._unloaded_for = self._transfers_for = 0.0
        self.feet: list[Foot] = []
        schedule = reference.schedule
        for side in SIDES:
            foot = Foot(side, schedule.standing(side, phase))
            foot.swing = SwingOffset(np.zeros(2), self.settings.swing)
            if foot.stance is None:
                foot.in_stance, foot.touchdown = False, np.inf
                ahead = schedule.after(side, phase)
                if ahead is not None:
                    foot.stance, foot.touchdown = ahead
                    foot.lift_off = phase
            self.feet.append(foot)

    def offset(self, number: int) -> Array:
        """Return the offset of a stance from the motion [m]."""
        return self.offsets(number, 1)[0]

    def offsets(self, first: int, n: int) -> Float[Array, "n 3"]:
        """Return the offsets of successive stances from a number on; zero where unknown [m]."""
        while first + n > len(self._offsets):
            self._offsets = np.concatenate([self._offsets, np.zeros_like(self._offsets)])
        return self._offsets[first : first + n]

    @property
    def stance_feet(self) -> list[Foot]:
        """Stance feet."""
        return [foot for foot in self.feet if foot.in_stance]

    @property
    def single_support(self) -> tuple[Foot, Foot] | None:
        """The foot that swings and the one that stands; None where it is not one of each."""
        swing = [foot for foot in self.feet if not foot.in_stance and foot.stance is not None]
        stance = self.stance_feet
        return (swing[0], stance[0]) if len(swing) == len(stance) == 1 else None

    def newest_stance(self, first: int) -> int:
        """Return the greatest number of a stance that has begun; ``first`` if none has."""
        return max((f.stance for f in self.stance_feet if f.stance is not None), default=first)

    def load_offsets(self, seats: Array | None = None) -> tuple[int, Array, Array, Array]:
        """Return the offsets of all stances and their weights.

        Args:
            seats: Which stances of the schedule are on a seat, 1 or 0; none if absent.

        Returns:
            Number of the first stance that counts; weights of its offset and of those after it in
            the divergent component; these offsets [m]; load-weighted offset of the stance feet,
            world [m].
        """
        first, alpha, beta = self.reference.schedule.weights(self.phase)
        own = [f.stance - first for f in self.stance_feet if f.stance is not None]
        offsets = self.offsets(first, len(alpha))
        share = np.zeros(len(alpha))
        share[own] = alpha[own]
        if share.sum() < 1e-6:
            share[own] = 1.0
        seated = 0.0 if seats is None else float(alpha @ seats)
        return first, beta, offsets, share @ offsets / max(float(share.sum()) + seated, 1e-9)

    def update(
        self,
        time: float,
        step: float,
        load: Array,
        offset: Array,
        axes: Array,
        far: Sequence[bool] = (False, False),
        recovers: bool = False,
        pushed: bool = False,
    ) -> None:
        """Register touchdowns and lift-offs.

        Args:
            time: Now [s].
            step: Time since the last call [s].
            load: Load of each foot along the normal [N].
            offset: Offset of each foot from the motion now [m].
            axes: Ahead and to the left, as columns.
            far: Which feet are far from their footstep: before their time they only graze the
                ground.
            recovers: Whether this is a recovery step, in which an unloaded foot does not wait.
            pushed: Whether a push was felt not long ago; then a loaded one does not wait long.
        """
        schedule, unloaded = self.reference.schedule, self._unloaded(load, step, recovers, pushed)
        for i, foot in enumerate(self.feet):
            if foot.in_stance:
                assert foot.stance is not None
                if foot is unloaded:
                    self._lift(foot, offset[i, :2])
                    continue
                stop = schedule.stop(foot.stance, self.phase)
                foot.early = foot.early and self.phase < foot.touchdown
                bears = load[i] > self.settings.contact.touchdown_load * self.weight
                foot.unloaded = 0.0 if bears or not foot.early else foot.unloaded + step
                grazed = foot.unloaded >= self.settings.contact.unloaded_time - 1e-9
                if grazed and len(self.stance_feet) == len(self.feet):
                    self._swing_on(foot, offset[i, :2])
                elif not foot.early and self.phase >= stop:
                    self._lift(foot, offset[i, :2])
                elif bears:
                    own = self.offset(foot.stance)
                    own += step / self.settings.stance_time * (offset[i] - own)
                continue
            if foot.stance is None or foot.recovering:
                continue
            left = foot.touchdown - self.phase
            begun = 1.0 - left / max(foot.touchdown - foot.lift_off, 1e-3)
            touches = load[i] > self.settings.contact.touchdown_load * self.weight and (
                left <= 0.0 or (begun > self.settings.min_touchdown_phase and not far[i])
            )
            if touches or foot.wait > self.settings.max_wait:
                foot.in_stance, foot.early = True, left > 0.0
                self.offset(foot.stance)[:] = offset[i]
                late = left if left > 0.0 else -foot.wait
                at = np.array(offset[i])
                self.touchdowns.append(Touchdown(time, foot.side, float(late), at, axes))
                foot.descent = foot.wait = 0.0

    def _swing_on(self, foot: Foot, offset: Float[Array, " 2"]) -> None:
        """Let a foot go on that only grazed the ground before its time.

        Args:
            offset: Its offset from the motion now [m].
        """
        foot.in_stance, foot.early, foot.unloaded = False, False, 0.0
        foot.swing = SwingOffset(offset, self.settings.swing)

    def _unloaded(self, load: Array, step: float, recovers: bool, pushed: bool) -> Foot | None:
        """Return the rear foot of a recovery step once it is almost unloaded, or should be.

        Args:
            load: Vertical loads of the feet in stance [N].
            step: Time since the last call [s].
            recovers: Whether this is a recovery step.
            pushed: Whether a push was felt not long ago.
        """
        own = self.settings.contact
        stance = [f.stance for f in self.stance_feet if f.stance is not None]
        if not recovers or len(stance) < len(self.feet):
            self._unloaded_for = self._transfers_for = 0.0
            return None
        i = stance.index(min(stance))
        little = load[i] < own.unloaded_share * float(load.sum())
        self._unloaded_for = self._unloaded_for + step if little else 0.0
        self._transfers_for += step
        unloaded = self._unloaded_for >= own.unloaded_time - 1e-9
        late = pushed and self._transfers_for >= own.transfer_time - 1e-9
        return self.feet[i] if unloaded or late else None

    def _lift(self, foot: Foot, offset: Float[Array, " 2"]) -> None:
        """Let a foot swing from where it is: a leg that has crossed rolls off otherwise.

        Args:
            offset: Its offset from the motion now [m].
        """
        ahead = self.reference.schedule.after(foot.side, self.phase)
        foot.in_stance, foot.early, foot.lift_off = False, False, self.phase
        foot.swing = SwingOffset(offset, self.settings.swing)
        foot.stance, foot.touchdown = (None, np.inf) if ahead is None else ahead

    def advance(self, time: float, step: float, rate: float) -> None:
        """Advance the phase.

        Args:
            time: Now [s].
            step: Time until the next call [s].
            rate: Rate that the planner desires.
        """
        settings, most = self.settings, self.settings.max_recovery
        missing = [f for f in self.feet if not f.in_stance and self.phase >= f.touchdown]
        for foot in missing:
            foot.wait += step
            foot.descent = settings.late_descent_speed * foot.wait
        if missing:
            self.rate = 0.0
            return
        if any(f.early for f in self.feet):
            rate = max(rate, settings.early_rate)
        else:
            rate *= 1.0 - min(max(settings.return_rate * (self.phase - time), -most), most)
        self.rate += min(step / settings.rate_time, 1.0) * (rate - self.rate)
        ends = [f.touchdown for f in self.feet if not f.in_stance]
        self.phase = min([self.phase + step * self.rate, *[t for t in ends if t > self.phase]])
