r"""Where and when the next foot lands: the divergent component of motion decides.

While one foot swings, the deviation of the divergent component from the motion grows about the
effective pivot of this step, and is known for the instant of touchdown. The next foot is put where
what is left then is just what the feet's offsets explain
(:mod:`plantigrade.control.gait.offsets`), so that the motion goes on from there undisturbed. A step
taken sooner leaves less to explain.

What a step within the limits misses is not lost: the step after it, of the other foot, has room on
the other side. So of all rates the one is taken after which the two steps together are easiest:
pushed outward, a person sets the foot down sooner and near, and catches the rest with the next.

Offsets are led back: of the stance after the next, the offset is planned to be :data:`BACK` times
that of the next, and so on, so that the person comes back onto the planned path.
"""

from dataclasses import dataclass
from functools import cached_property
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float

RATES = np.array([0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0])
"""Rates at which a step may be finished, of the motion's own."""
BACK = 0.75
"""What is left of an offset after a step."""
FORWARD, SIDEWAYS, SOONER = 0.16, 0.065, 36.0
"""Cost of a step: offsets along and across that cost 1 [leg lengths], and of ln(rate)²."""
FARTHEST, WIDEST = 1.2, 0.75
"""Limits of a landing place from the standing foot [leg lengths]: ahead, and to its side."""
CROSSES, CROSSED = 0.35, -0.04
"""A foot that lands so far ahead of the other may cross over, to this place beside it; likewise."""
OUTSIDE = 1e4
"""Cost of leaving the limits, per square metre."""
LATER, NEXT = 0.3, 0.08
"""Cost of what the step after the next has to make up, by that of the next; how much wider than
the narrowest that step is planned [leg lengths]."""
SPEED, HASTY = 4.5, 2e3
"""Mean speed of a swinging foot, at most [leg lengths/s]; cost of what it falls short [1/m²]."""
HURRIED, MISSED = 0.75, (0.04, 0.16)
"""With both feet on the ground the phase runs so much faster where the divergent component is
missed by that much: not at all, and fully [m]."""
AGAIN = 0.35
"""So long after a step the next one can land [s]."""


def hurried(error: Float[Array, " 2"]) -> float:
    """Return the rate at which the weight goes over to the other foot.

    Args:
        error: By how much the divergent component is missed [m].
    """
    return 1.0 + HURRIED * min(max(hypot(*error) - MISSED[0], 0.0) / (MISSED[1] - MISSED[0]), 1.0)


@dataclass(frozen=True)
class Step:
    """A step to be taken.

    Attributes:
        offset: Of the place from that of the motion, world [m].
        free: The same without limits [m].
        rate: At which it is taken, of the motion's own.
    """

    offset: Float[Array, " 2"]
    free: Float[Array, " 2"]
    rate: float


def decayed(weights: Float[Array, " k"], back: float = BACK) -> float:
    """Return the weight of stances that follow one another, offsets led back from one to the next.

    Args:
        weights: Weights of the next stance and all after it.
        back: What is left of an offset from one to the next.
    """
    return float(weights @ back ** np.arange(len(weights)))


def next_step(
    xi: Float[Array, " 2"],
    xi_now: Float[Array, " 2"],
    xi_touchdown: Float[Array, " 2"],
    omega: float,
    left: float,
    pivot_offset: Float[Array, " 2"],
    standing_offset: Float[Array, " 2"],
    standing_weight: float,
    later_weight: float,
    box: "LandingBox",
    rates: Float[Array, " m"] = RATES,
    grows: float = 1.0,
) -> Step:
    r"""Return place and rate of the next step.

    With the effective pivot :math:`\bar p` of the motion itself and :math:`T` the time left,

    .. math:: \delta\xi_{td} = e^{\omega T / r} (\xi - \bar p - o) + \bar p + o - \xi_{ref}(td),
        \quad o_{next} = (\delta\xi_{td} - \beta_{st} o_{st}) / \beta_{later} .

    Args:
        xi: Divergent component, world [m].
        xi_now: That of the motion now.
        xi_touchdown: That of the motion at touchdown.
        omega: Rate of the pendulum [1/s].
        left: Time until the motion's touchdown [s].
        pivot_offset: Of the centre of pressure, by the feet that stand now [m].
        standing_offset: Of the feet that still stand after touchdown, weighted [m].
        standing_weight: Their weight at touchdown.
        later_weight: That of the next stance and those after it.
        box: Where the foot may land.
        rates: To choose from.
        grows: By how much what this step misses has grown when the next one lands.
    """
    grown = np.exp(omega * left)
    pivot = (xi_touchdown - grown * xi_now) / (1.0 - grown)
    growth = np.exp(omega * left / rates)[:, None]
    deviation = growth * (xi - pivot - pivot_offset) + pivot + pivot_offset - xi_touchdown
    free = (deviation - standing_weight * standing_offset) / later_weight
    best, placed = easiest(free, standing_offset, left, box, rates, grows)
    return Step(placed, free[best], float(rates[best]))


def easiest(
    free: Float[Array, "m 2"],
    standing_offset: Float[Array, " 2"],
    left: float,
    box: "LandingBox",
    rates: Float[Array, " m"] = RATES,
    grows: float = 1.0,
) -> tuple[int, Float[Array, " 2"]]:
    """Return which of some steps is the easiest, with the one after it, and its place in reach.

    Args:
        free: Offset by rate, without limits [m].
        standing_offset: Of the foot that stands [m].
        left: Time until the motion's touchdown [s].
        box: Where the foot may land.
        rates: At which the steps are taken.
        grows: By how much what a step misses has grown when the next one lands.
    """
    moved = (free - standing_offset) @ (box.axes / box.scale)
    effort = (moved * moved).sum(axis=1) + SOONER * np.log(rates) ** 2
    placed = np.stack(box.places(free))
    cost = np.stack(
        [
            effort + box.after(grows * (free - each)) + box.hasty(each, left / rates)
            for each in placed
        ]
    )
    way, best = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return int(best), placed[way, best]


@dataclass(frozen=True)
class LandingBox:
    """Where the next foot may land, beside the one that stands.

    Attributes:
        axes: Ahead and to the left, as columns.
        nominal: Landing place of the motion from where the other foot really stands [m].
        side: 1 for the left foot, -1 for the right.
        leg: Length of the leg [m].
        narrowest: Least distance to the side [m].
        here: Offset at which the foot would land where it is now [m].
        farthest: Reach ahead or behind [leg lengths].
        widest: Reach to the side, likewise.
        crosses: A foot that lands so far ahead of the other may cross over.
        over: To this place beside it.
    """

    axes: Float[Array, "2 2"]
    nominal: Float[Array, " 2"]
    side: float
    leg: float
    narrowest: float
    here: Float[Array, " 2"]
    farthest: float = FARTHEST
    widest: float = WIDEST
    crosses: float = CROSSES
    over: float = CROSSED

    @property
    def crossed(self) -> float:
        """Place beside the other foot of one that crosses over in front of it, at most [m]."""
        return min(self.over * self.leg, self.narrowest)

    @cached_property
    def scale(self) -> Float[Array, " 2"]:
        """Offsets that cost 1 [m]."""
        return self.leg * np.array([FORWARD, SIDEWAYS])

    def places(self, offset: Float[Array, "m 2"]) -> list[Float[Array, "m 2"]]:
        """Return offsets with the place within its limits, one way or more."""
        place = (self.nominal + offset) @ self.axes
        ahead = _within(place[:, 0], -self.farthest * self.leg, self.farthest * self.leg)
        nearest = np.where(ahead > self.crosses * self.leg, self.crossed, self.narrowest)
        aside = _within(self.side * place[:, 1], nearest, self.widest * self.leg)
        return [np.stack([ahead, self.side * aside], axis=1) @ self.axes.T - self.nominal]

    def after(self, missed: Float[Array, "m 2"]) -> Float[Array, " m"]:
        """Return what it costs that the step after this one, of the other foot, must make up.

        Args:
            missed: By how much it must land elsewhere than planned [m].
        """
        aside = missed @ self.axes
        width = self.narrowest + NEXT * self.leg - self.side * aside[:, 1]
        over = width - _within(width, self.narrowest, self.widest * self.leg)
        over = over**2 + np.maximum(np.abs(aside[:, 0]) - 0.5 * self.farthest * self.leg, 0.0) ** 2
        aside /= self.scale
        return LATER * (aside * aside).sum(axis=1) + OUTSIDE * over

    def hasty(self, offset: Float[Array, "m 2"], left: Float[Array, " m"]) -> Float[Array, " m"]:
        """Return what it costs that the foot would have to be faster than it can.

        Args:
            offset: Where it lands [m].
            left: In what time [s].
        """
        away = offset - self.here
        far = np.sqrt((away * away).sum(axis=1))
        return HASTY * np.maximum(far - SPEED * self.leg * left, 0.0) ** 2


def _within(x: Array, low: Array | float, high: float) -> Array:
    """Return numbers between limits; ``np.clip`` takes its time."""
    return np.minimum(np.maximum(x, low), high)
