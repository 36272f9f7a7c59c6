r"""Recovery steps: foot, place and time from the capture point.

A linear pendulum of height :math:`z` diverges from its centre of pressure :math:`p` with
:math:`\omega = \sqrt{g / z}`: the capture point :math:`\xi = c + \dot c / \omega` ([Pratt2006]_) is
after a time :math:`T` at

.. math:: \xi_T = p - s + (\xi + s - p)\, e^{\omega T} ,

with :math:`s = a / \omega^2` while something pushes with an acceleration :math:`a`.
As long as :math:`\xi` lies within the base of support, pressure there can bring the body to rest.
Once it has left it, nothing but a step can (or arms and trunk, for a little).

One step is not always enough. What remains of the way to the capture point after a step grows by
:math:`e^{\omega T}` until the next one ([Koolen2012]_: a person is *N-step capturable* where it
comes within reach after N steps). So feet, times and places are compared by what remains after
:data:`STEPS` steps, each as near to where it should be as the leg and the speed of the foot allow:
a push to the side is met with the foot on that side, the other follows, and the first goes out
again. A foot stays on its own side of the other: legs are solid.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY

DURATIONS = (0.22, 0.27, 0.33, 0.4)
"""How long a foot may be in the air [s]."""
FASTEST = 2.6
"""Mean speed of a foot in the air [m/s]."""
STRONGEST = 80.0
"""Its greatest acceleration over the ground [m/s²]."""
PAUSE = 0.04
"""Between two steps both feet stand so long [s]."""
HASTE = 7e-4
"""What a greater acceleration of a foot costs, by what remains of the way [s²]: it turns the
body."""
STEPS = 3
"""So many steps are looked ahead."""
OUTSIDE = -0.03
"""So far outside the support the capture point makes a step necessary [m]: it is not waited for to
leave. A foot can be lifted only while the other one still carries, and a push to the side takes the
load off the one that has to stand."""
AHEAD, BACK, ASIDE, APART = 1.0, 0.72, 1.05, 0.17
"""How far a foot may be before, behind and beside the other, and how far beside it must be, of the
length of a leg; the first three are half-axes of ellipses. (A leg that stands farther behind has
its hip at the stop, and pushes the body back over the other foot.)"""
REACH = 0.7
"""How far a foot may be from under the centre of mass when it lands, of the length of a leg."""
BEYOND = 0.12
"""So far beyond the capture point a foot is set, of the length of a leg: between two feet there is
more room than under one, and pushes go on. (None: four steps in place of one.)"""
NATURAL = 0.26
"""Feet that are closer side by side than this part of the length of a leg stand badly."""
UNDER = 0.05
"""So far around the middle of a sole the pressure can be [m]."""
LASTS = 0.3
"""A push that is felt is taken to go on so long [s]."""
LIFT = 0.06
"""Clearance of a foot in the air, of the length of a leg."""
LANDS = 0.05
"""So long after a step a foot carries [s]."""
FIXED = 0.25
"""The last part of a step, in which the place is no longer changed: a foot that is speeded up again
rises, too, and comes down late."""
LATE = 0.5
"""Speed at which a foot goes on down that has not met the ground in time [m/s]."""
EARLY = 0.8
"""From this part of a step on, a touch ends it."""


@dataclass(frozen=True, eq=False)
class Pendulum:
    """The state a plan starts from.

    Attributes:
        com: Centre of mass, over the ground [m].
        velocity: Its velocity [m/s].
        height: Of the centre of mass above the ground [m].
        feet: Middle of the sole of each foot, right first, over the ground [m].
        pressure: Where in each foot the pressure would best be, likewise [m].
        heading: Direction in which the person faces, over the ground.
        leg: Length of a leg [m].
        pushed: What pushes besides the ground, as an acceleration [m/s²].
        lasts: So long it is taken to go on [s].
        back: How far a foot may be behind the other, of the length of a leg.
    """

    com: Float[Array, " 2"]
    velocity: Float[Array, " 2"]
    height: float
    feet: Float[Array, "2 2"]
    pressure: Float[Array, "2 2"]
    heading: Float[Array, " 2"]
    leg: float
    pushed: Float[Array, " 2"] = field(default_factory=lambda: np.zeros(2))
    lasts: float = LASTS
    back: float = BACK

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
        miss: How far what both feet span is from where one should be, which is out of reach [m].
        remains: The same after the steps that follow.
        cost: How bad it is, beside others.
    """

    side: int
    place: Float[Array, " 2"]
    duration: float
    miss: float
    remains: float = 0.0
    cost: float = 0.0


def plan_step(now: Pendulum, sides: Sequence[int] = (0, 1)) -> Step:
    """Return the best step: the one that leaves the smallest error after the steps that follow.

    Args:
        now: The pendulum.
        sides: Which feet can be lifted.
    """
    found = [planned(now, side, time) for side in sides for time in DURATIONS]
    return min(found, key=lambda each: each.cost)


def planned(
    now: Pendulum,
    side: int,
    time: float,
    *,
    flies: bool = False,
    velocity: Float[Array, " 2"] | None = None,
) -> Step:
    """Return where a foot is to be set a time from now.

    Args:
        now: The pendulum.
        side: Which foot.
        time: When [s].
        flies: Whether it is in the air already: one place alone is looked at then, the nearest to
            where it should be.
        velocity: Of a foot in the air, over the ground; only what it can reach from there is
            taken [m/s].
    """
    other = 1 - side
    pivot, lasts = now.pressure[other], now.lasts
    after = time + LANDS
    capture, com = _moved(now, pivot, now.capture_point, now.com, after, lasts)
    wanted = _beyond(capture, pivot, now.leg) + _rests(now, lasts - after)
    if flies:
        places = within_reach(now, side, wanted[None])
        if velocity is not None:
            glides = now.feet[side] + velocity * time * 2 / 3
            places = _near(places, glides, STRONGEST * time**2 / 6)
    else:
        places = within_reach(now, side, np.vstack([wanted, now.feet[other] + _grid(now, side)]))
        places = _near(places, now.feet[side], min(FASTEST * time, STRONGEST * time**2 / 6))
    places = _near(places, com, REACH * now.leg)
    places = within_reach(now, side, places)
    first = _left(wanted, now.feet[other], places)
    feet = np.empty((len(places), 2, 2))
    feet[:, side], feet[:, other] = places, now.feet[other]
    left, remains, foot, passed = capture, first, side, after
    for _ in range(STEPS - 1):
        more = lasts - passed
        stays = feet[:, foot]
        aims = np.broadcast_to(left + _rests(now, more), places.shape)
        pivots = stays + _near(aims - stays, np.zeros(2), UNDER)
        left, _ = _moved(now, pivots, left, left, DURATIONS[0] + PAUSE + LANDS, more)
        passed += DURATIONS[0] + PAUSE + LANDS
        aim = _beyond(left, pivots, now.leg) + _rests(now, lasts - passed)
        foot = 1 - foot
        next_to = _near(_within(stays, now, foot, aim), feet[:, foot], FASTEST * DURATIONS[0])
        feet[:, foot] = _within(stays, now, foot, next_to)
        # Who is captured needs no further step.
        remains = np.where(remains < 1e-9, 0.0, _left(aim, stays, feet[:, foot]))
    strained = max(float(np.linalg.norm(com - now.feet[other])) - REACH * now.leg, 0.0)
    aside = np.abs((places - now.feet[other]) @ _axes(now)[1])
    cost = remains + 0.5 * first + 0.2 * np.linalg.norm(places - wanted, axis=1) + strained
    cost += 0.5 * np.maximum(NATURAL * now.leg - aside, 0.0) + 0.3 * time
    if not flies:
        cost += HASTE * 6 * np.linalg.norm(places - now.feet[side], axis=1) / time**2
    k = int(cost.argmin())
    return Step(side, places[k], time, float(first[k]), float(remains[k]), float(cost[k]))


def _moved(
    now: Pendulum, pivot: Array, capture: Array, com: Array, time: float, lasts: float
) -> tuple[Array, Array]:
    """Return capture point and centre of mass a time from now, while the push lasts and after."""
    pushed = min(max(lasts, 0.0), time)
    for part, shift in ((pushed, now.shift), (time - pushed, np.zeros(2))):
        grows, centre = np.exp(now.omega * part), pivot - shift
        # c' = omega (xi - c): what it was decays, what diverges draws it along.
        com = centre + (com - centre) / grows + 0.5 * (grows - 1 / grows) * (capture - centre)
        capture = centre + (capture - centre) * grows
    return capture, com


def _rests(now: Pendulum, lasts: float) -> Float[Array, " 2"]:
    """Return how much farther than the capture point a foot has to be for the rest of a push."""
    return now.shift * (1.0 - np.exp(-now.omega * max(lasts, 0.0)))


def _grid(now: Pendulum, side: int) -> Float[Array, "k 2"]:
    """Return places beside the other foot among which the best is looked for."""
    x = now.leg * np.linspace(-now.back, AHEAD, 8)
    y = now.leg * np.linspace(APART, ASIDE, 6)
    ahead, left = _axes(now)
    sign = -1.0 if side == 0 else 1.0
    return (x[:, None, None] * ahead + sign * y[None, :, None] * left).reshape(-1, 2)


def _axes(now: Pendulum) -> tuple[Array, Array]:
    return now.heading, np.array([-now.heading[1], now.heading[0]])


def _near(places: Array, middle: Array, most: float) -> Array:
    """Return places, drawn to a circle about a middle where they are outside of it."""
    off = places - middle
    far = np.linalg.norm(off, axis=-1, keepdims=True)
    return middle + off * np.minimum(1.0, most / np.maximum(far, 1e-9))


def _beyond(capture: Array, pivot: Array, leg: float) -> Array:
    """Return where a foot is best set for a capture point: a little beyond it."""
    away = capture - pivot
    far = np.linalg.norm(away, axis=-1, keepdims=True)
    return capture + BEYOND * leg * away / np.maximum(far, 1e-9)


def _left(wanted: Array, stands: Array, place: Array) -> Array:
    """Return how far where a foot should be is from what two feet span."""
    along = place - stands
    part = ((wanted - stands) * along).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-9)
    nearest = stands + np.clip(part, 0.0, 1.0)[..., None] * along
    return np.maximum(np.linalg.norm(wanted - nearest, axis=-1) - UNDER, 0.0)


def within_reach(now: Pendulum, side: int, place: Float[Array, "*k 2"]) -> Float[Array, "*k 2"]:
    """Return the nearest place that a foot reaches, on its own side of the other foot."""
    return _within(now.feet[1 - side], now, side, place)


def _within(stands: Array, now: Pendulum, side: int, place: Array) -> Array:
    ahead, left = _axes(now)
    sign = -1.0 if side == 0 else 1.0
    off = place - stands
    x, y = off @ ahead, np.maximum(sign * (off @ left), APART * now.leg)
    aside = (y - APART * now.leg) / ((ASIDE - APART) * now.leg)
    size = np.hypot(x / (np.where(x > 0, AHEAD, now.back) * now.leg), aside)
    shrink = 1.0 / np.maximum(size, 1.0)
    y = APART * now.leg + (y - APART * now.leg) * shrink
    return stands + (x * shrink)[..., None] * ahead + sign * y[..., None] * left


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

    def replanned(
        self, now: Pendulum, time: float, velocity: Float[Array, " 2"] | None = None
    ) -> "Swing":
        """Return the same step to where the foot is needed now; as it is in its last part.

        Args:
            now: The pendulum.
            time: Now [s].
            velocity: Of the foot over the ground; without it any place within reach of the leg is
                taken [m/s].
        """
        left = self.step.duration - (time - self.begin)
        if left < FIXED * self.step.duration:
            return self
        new = planned(now, self.step.side, left, flies=True, velocity=velocity)
        return replace(self, step=replace(new, duration=self.step.duration))

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
        return np.clip(np.array([*level, up]), -STRONGEST, STRONGEST)
