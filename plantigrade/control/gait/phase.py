"""Which foot stands, how far the motion is, where the feet are beside it: the clock of a replay.

Feet land when they touch, sooner or later than planned. An early touch makes the foot stand at
once; the phase then hurries after it. Where the ground is missing the phase waits and the foot is
let down. What the phase has gained or lost so it gives back slowly, so that its mean rate is 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.reference import Reference
from plantigrade.control.gait.swing import SwingOffset

TOUCH, LOADED = 0.035, 0.028
"""A foot touches, or its place is known, from this load on [body weights]."""
BEGUN = 0.6
"""Part of a swing after which a touch is a touchdown."""
HURRY = 1.5
"""Rate of the phase after an early touchdown."""
DOWN, LOWEST = 0.5, 0.12
"""A foot that misses the ground is let down so fast [m/s], and so far [m]."""
LONGEST = 0.3
"""So long the phase waits for a foot [s]."""
SETTLE, FOLLOW = 0.05, 0.02
"""Time constants: of the place of a standing foot, of the rate [s]."""
REGAIN, MOST = 0.3, 0.05
"""Rate at which the phase gives back what it gained [1/s], and the most that it gives."""
JUST = 0.006
"""A foot that is down early stands as it does so long after its touchdown [s]."""


@dataclass
class Foot:
    """A foot of a replay.

    Attributes:
        side: Its side.
        number: Of the stance it is in; of the next one while it swings; None if there is none.
        stands: Whether it does.
        touchdown: Of that stance, on the clock of the phase [s].
        lifted: When it left the ground, likewise [s].
        swing: Its offset while it swings.
        lowered: How far it was let down for a missing ground [m].
        waited: How long the phase has waited for it [s].
        early: Whether it stands before its time.
        caught: Whether it swings in a step that the motion does not have.
    """

    side: str
    number: int | None
    stands: bool
    touchdown: float = -np.inf
    lifted: float = 0.0
    swing: SwingOffset = field(default_factory=lambda: SwingOffset(np.zeros(2)))
    lowered: float = 0.0
    waited: float = 0.0
    early: bool = False
    caught: bool = False

    @property
    def left(self) -> float:
        """1 for the left foot, -1 for the right."""
        return 1.0 if self.side == "l" else -1.0


@dataclass(frozen=True)
class Touchdown:
    """What happened when a foot came down.

    Attributes:
        time: When [s].
        side: Which foot.
        early: How much sooner than planned on the clock of the phase, negative if later [s].
        offset: Where, beside the motion, world [m].
        axes: Ahead and to the left then, as columns.
    """

    time: float
    side: str
    early: float
    offset: Float[Array, " 3"]
    axes: Float[Array, "2 2"]


class Gait:
    """Phase, feet and their offsets.

    Attributes:
        phase: Time of the motion [s].
        rate: Its rate.
        feet: Right and left foot.
        touchdowns: All of them so far.
    """

    def __init__(self, reference: Reference, weight: float, phase: float = 0.0):
        self.reference, self.weight = reference, weight
        self.phase, self.rate = phase, 1.0
        self._offsets = np.zeros((64, 3))
        self.touchdowns: list[Touchdown] = []
        self.feet: list[Foot] = []
        schedule = reference.schedule
        for side in SIDES:
            number = schedule.standing(side, phase)
            if number is not None:
                self.feet.append(Foot(side, number, True))
                continue
            ahead = schedule.after(side, phase)
            foot = Foot(side, None, False, np.inf)
            if ahead is not None:
                foot.number, foot.touchdown = ahead
                foot.lifted = ahead[1] - SWING
            self.feet.append(foot)

    def offset(self, number: int) -> Array:
        """Return where a foot is in a stance, less where the motion has it [m]."""
        return self.offsets(number, 1)[0]

    def offsets(self, first: int, n: int) -> Float[Array, "n 3"]:
        """Return the offsets of stances from a number on; zero as long as nothing is known [m]."""
        while first + n > len(self._offsets):
            self._offsets = np.concatenate([self._offsets, np.zeros_like(self._offsets)])
        return self._offsets[first : first + n]

    @property
    def standing(self) -> list[Foot]:
        """Feet that stand."""
        return [foot for foot in self.feet if foot.stands]

    def carried(self, seats: Array | None = None) -> tuple[int, Array, Array, Array]:
        """Return what carries, and how far beside the motion.

        Args:
            seats: Which stances of the schedule are on a seat, 1 or 0; none if absent.

        Returns:
            Number of the first stance that counts; how much each one from it on moves the divergent
            component; their offsets [m]; how far the feet that stand are beside the motion, by
            their load, world [m].
        """
        first, alpha, beta = self.reference.schedule.weights(self.phase)
        own = [f.number - first for f in self.standing if f.number is not None]
        offsets = self.offsets(first, len(alpha))
        share = np.zeros(len(alpha))
        share[own] = alpha[own]
        if share.sum() < 1e-6:
            share[own] = 1.0
        seated = 0.0 if seats is None else float(alpha @ seats)
        return first, beta, offsets, share @ offsets / max(float(share.sum()) + seated, 1e-9)

    def look(
        self,
        time: float,
        step: float,
        load: Array,
        beside: Array,
        axes: Array,
        far: Sequence[bool] = (False, False),
    ) -> None:
        """Let feet land and leave.

        Args:
            time: Now [s].
            step: Since the last look [s].
            load: Of each foot along the normal [N].
            beside: Where each foot is, less where the motion has it now [m].
            axes: Ahead and to the left, as columns.
            far: Which feet are far from where they are to land: before their time they only graze
                the ground.
        """
        schedule = self.reference.schedule
        for i, foot in enumerate(self.feet):
            if foot.stands:
                assert foot.number is not None
                stop = schedule.stop(foot.number, self.phase)
                foot.early = foot.early and self.phase < foot.touchdown
                if not foot.early and self.phase >= stop:
                    self._lift(foot, beside[i, :2])
                elif load[i] > LOADED * self.weight:
                    own = self.offset(foot.number)
                    own += step / SETTLE * (beside[i] - own)
                continue
            if foot.number is None or foot.caught:
                continue
            left = foot.touchdown - self.phase
            begun = 1.0 - left / max(foot.touchdown - foot.lifted, 1e-3)
            touches = load[i] > TOUCH * self.weight and (
                left <= 0.0 or (begun > BEGUN and not far[i])
            )
            if touches or foot.waited > LONGEST:
                foot.stands, foot.early = True, left > 0.0
                self.offset(foot.number)[:] = beside[i]
                late = left if left > 0.0 else -foot.waited
                at = np.array(beside[i])
                self.touchdowns.append(Touchdown(time, foot.side, float(late), at, axes))
                foot.lowered = foot.waited = 0.0

    def _lift(self, foot: Foot, beside: Float[Array, " 2"]) -> None:
        """Let a foot swing from where it is: a leg that has crossed rolls off otherwise.

        Args:
            foot: The foot.
            beside: Where it is, less where the motion has it now [m].
        """
        ahead = self.reference.schedule.after(foot.side, self.phase)
        foot.stands, foot.early, foot.lifted = False, False, self.phase
        foot.swing = SwingOffset(beside)
        foot.number, foot.touchdown = (None, np.inf) if ahead is None else ahead

    def advance(self, time: float, step: float, wanted: float) -> None:
        """Move the phase on.

        Args:
            time: Now [s].
            step: Until the next look [s].
            wanted: Rate that the planner wants.
        """
        missing = [f for f in self.feet if not f.stands and self.phase >= f.touchdown]
        for foot in missing:
            foot.lowered = min(foot.lowered + DOWN * step, LOWEST)
            foot.waited += step
        if missing:
            self.rate = 0.0
            return
        if any(f.early for f in self.feet):
            wanted = max(wanted, HURRY)
        else:
            wanted *= 1.0 - min(max(REGAIN * (self.phase - time), -MOST), MOST)
        self.rate += min(step / FOLLOW, 1.0) * (wanted - self.rate)
        ends = [f.touchdown for f in self.feet if not f.stands]
        self.phase = min([self.phase + step * self.rate, *[t for t in ends if t > self.phase]])


SWING = 0.4
"""Length of a swing whose beginning is not known [s]."""
