r"""Recovery steps: which foot, where to and when, from the capture point alone.

A linear pendulum of height :math:`z` diverges from its centre of pressure :math:`p` with
:math:`\omega = \sqrt{g / z}`: the capture point :math:`\xi = c + \dot c / \omega` ([Pratt2006]_) is
after a time :math:`T` at

.. math:: \xi_T = p - s + (\xi + s - p)\, e^{\omega T} ,

with :math:`s = a / \omega^2` while something pushes with an acceleration :math:`a`.
As long as :math:`\xi` lies within the base of support, pressure there can bring the body to rest.
Once it has left it, nothing but a step can (or arms and trunk, for a little). The foot that is set
down is to stand a little beyond :math:`\xi_T`; that of the two whose reach comes nearest is lifted,
and its landing place is planned anew at every tick, for a push may still go on. A foot stays on its
own side of the other: legs are solid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY

DURATIONS = (0.22, 0.27, 0.33, 0.4)
"""How long a foot may be in the air [s]."""
FASTEST = 2.2
"""Mean speed of a foot in the air [m/s]."""
OUTSIDE = -0.03
"""So far outside the support the capture point makes a step necessary [m]: it is not waited for to
leave. A foot can be lifted only while the other one still carries, and a push to the side takes the
load off the one that has to stand."""
AHEAD, BACK, ASIDE, APART = 0.85, 0.7, 0.8, 0.17
"""How far a foot may be before, behind and beside the other, and how far beside it must be, of the
length of a leg."""
BEYOND = 0.12
"""So far beyond the capture point a foot is set, of the length of a leg: between two feet there is
more room than under one, and pushes go on. (None: four steps in place of one.)"""
LIFT = 0.06
"""Clearance of a foot in the air, of the length of a leg."""
LATE = 0.5
"""Speed at which a foot goes on down that has not met the ground in time [m/s]."""
EARLY = 0.5
"""From this part of a step on, a touch ends it."""


@dataclass(frozen=True, eq=False)
class Pendulum:
    """What a plan starts from.

    Attributes:
        com: Centre of mass, over the ground [m].
        velocity: Its velocity [m/s].
        height: Of the centre of mass above the ground [m].
        feet: Middle of the sole of each foot, right first, over the ground [m].
        pressure: Where in each foot the pressure would best be, likewise [m].
        heading: Direction in which the person faces, over the ground.
        leg: Length of a leg [m].
        pushed: What pushes besides the ground, as an acceleration [m/s²].
    """

    com: Float[Array, " 2"]
    velocity: Float[Array, " 2"]
    height: float
    feet: Float[Array, "2 2"]
    pressure: Float[Array, "2 2"]
    heading: Float[Array, " 2"]
    leg: float
    pushed: Float[Array, " 2"] = field(default_factory=lambda: np.zeros(2))

    @property
    def omega(self) -> float:
        """Rate at which it diverges [1/s]."""
        return float(np.sqrt(GRAVITY / self.height))

    @property
    def capture_point(self) -> Float[Array, " 2"]:
        """Where it could come to rest, did nothing push it [m]."""
        return self.com + self.velocity / self.omega

    @property
    def shift(self) -> Float[Array, " 2"]:
        """How far pressure has to be beyond the capture point while the push lasts [m]."""
        return self.pushed / self.omega**2


@dataclass(frozen=True, eq=False)
class Step:
    """A step.

    Attributes:
        side: Which foot is set, 0 for the right one, 1 for the left one.
        place: Where the middle of its sole comes down, over the ground [m].
        duration: When, from now on [s].
        miss: How far it is from where it should be, which is out of reach [m].
    """

    side: int
    place: Float[Array, " 2"]
    duration: float
    miss: float


def plan_step(now: Pendulum, sides: Sequence[int] = (0, 1)) -> Step:
    """Return the best step: the foot and the time that come nearest to the capture point.

    Of times that come within a centimetre of each other the earlier one.

    Args:
        now: The pendulum.
        sides: Which feet can be lifted.
    """
    found = [
        step
        for side in sides
        for time in DURATIONS
        if (step := planned(now, side, time)) is not None
    ]
    return min(found, key=lambda step: (round(step.miss, 2), step.duration))


def planned(now: Pendulum, side: int, time: float, *, moving: bool = False) -> Step | None:
    """Return where a foot has to be set a time from now.

    Args:
        now: The pendulum.
        side: Which foot.
        time: When [s].
        moving: Whether it is in the air already; then it is not asked how fast it must be.

    Returns:
        The step; None where the foot would have to be too fast and another time is to be tried.
    """
    other = 1 - side
    pivot = now.pressure[other]
    grows = np.exp(now.omega * time)
    wanted = pivot - now.shift + (now.capture_point + now.shift - pivot) * grows
    away = wanted - pivot
    beyond = wanted + BEYOND * now.leg * away / max(float(np.linalg.norm(away)), 1e-9)
    place = within_reach(now, side, beyond)
    travel = float(np.linalg.norm(place - now.feet[side]))
    if not moving and travel > FASTEST * time and time < DURATIONS[-1]:
        return None
    return Step(side, place, time, float(np.linalg.norm(beyond - place)))


def within_reach(now: Pendulum, side: int, place: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """Return the nearest place that a foot reaches, on its own side of the other foot."""
    ahead = now.heading
    left = np.array([-ahead[1], ahead[0]])
    sign = -1.0 if side == 0 else 1.0
    off = place - now.feet[1 - side]
    x = np.clip(off @ ahead, -BACK * now.leg, AHEAD * now.leg)
    y = np.clip(sign * (off @ left), APART * now.leg, ASIDE * now.leg)
    return now.feet[1 - side] + x * ahead + sign * y * left


@dataclass(frozen=True, eq=False)
class Swing:
    """A foot in the air.

    Attributes:
        step: The step, its duration from lifting on.
        begin: When the foot was lifted [s].
    """

    step: Step
    begin: float

    def part(self, time: float) -> float:
        """Return how much of it is over, 1 when the foot is to touch."""
        return (time - self.begin) / self.step.duration

    def replanned(self, now: Pendulum, time: float) -> "Swing":
        """Return the same step to where the foot is needed now; as it is in its last tenth."""
        left = self.step.duration - (time - self.begin)
        if left < 0.1 * self.step.duration:
            return self
        new = planned(now, self.step.side, left, moving=True)
        assert new is not None
        return replace(self, step=replace(self.step, place=new.place, miss=new.miss))

    def asked(
        self,
        time: float,
        place: Float[Array, " 3"],
        velocity: Float[Array, " 3"],
        ground: float,
        leg: float,
    ) -> Float[Array, " 3"]:
        """Return the acceleration of the foot that brings it there [m/s²].

        Over the ground by the cubic from where it is, in height along a parabola.

        Args:
            time: Now [s].
            place: Where the middle of its sole is [m].
            velocity: Its velocity [m/s].
            ground: Height at which it lands [m].
            leg: Length of a leg [m].
        """
        left = max(self.step.duration - (time - self.begin) - 0.02, 0.04)
        level = (6 * (self.step.place - place[:2]) - 4 * velocity[:2] * left) / left**2
        u = float(np.clip(self.part(time), 0.0, 1.0))
        late = max(time - self.begin - self.step.duration, 0.0)
        high = LIFT * leg * 4 * u * (1 - u) + ground - LATE * late
        rise = LIFT * leg * 4 * (1 - 2 * u) / self.step.duration if u < 1 else -LATE
        up = 600.0 * (high - place[2]) + 45.0 * (rise - velocity[2])
        return np.clip(np.array([*level, up]), -80.0, 80.0)
