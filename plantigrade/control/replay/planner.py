r"""Where and when the next foot lands: the divergent component of motion decides.

While one foot swings, the deviation of the divergent component from the motion grows about the
effective pivot of this step, and is known for the instant of touchdown. The next foot is put where
what is left then is just what the feet's offsets explain (:mod:`.offsets`), so that the motion goes
on from there undisturbed. A step taken sooner leaves less to explain.

Offsets are led back: of the stance after the next, the offset is planned to be :data:`BACK` times
that of the next, and so on, so that the person comes back onto the planned path.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float

RATES = np.array([0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0, 2.5])
"""Rates at which a step may be finished, of the motion's own."""
BACK = 0.85
"""What is left of an offset after a step."""
FORWARD, SIDEWAYS, SOONER = 0.16, 0.065, 36.0
"""Cost of a step: offsets along and across that cost 1 [leg lengths], and of ln(rate)²."""
FARTHEST, WIDEST, NARROWEST = 1.2, 0.75, 0.06
"""Limits of a landing place from the standing foot [leg lengths]: ahead, and to its side."""
OUTSIDE = 1e4
"""Cost of leaving the limits, per square metre."""


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
    """
    grown = np.exp(omega * left)
    pivot = (xi_touchdown - grown * xi_now) / (1.0 - grown)
    growth = np.exp(omega * left / rates)[:, None]
    deviation = growth * (xi - pivot - pivot_offset) + pivot + pivot_offset - xi_touchdown
    free = (deviation - standing_weight * standing_offset) / later_weight
    placed = box.clipped(free)
    moved = (free - standing_offset) @ box.axes
    beyond = ((free - placed) ** 2).sum(axis=1)
    cost = (moved / box.scale) ** 2 @ np.ones(2) + SOONER * np.log(rates) ** 2 + OUTSIDE * beyond
    best = int(np.argmin(cost))
    return Step(placed[best], free[best], float(rates[best]))


@dataclass(frozen=True)
class LandingBox:
    """Where the next foot may land, beside the one that stands.

    Attributes:
        axes: Ahead and to the left, as columns.
        nominal: Landing place of the motion from where the other foot really stands [m].
        side: 1 for the left foot, -1 for the right.
        leg: Length of the leg [m].
        narrowest: Least distance to the side [m].
    """

    axes: Float[Array, "2 2"]
    nominal: Float[Array, " 2"]
    side: float
    leg: float
    narrowest: float

    @property
    def scale(self) -> Float[Array, " 2"]:
        """Offsets that cost 1 [m]."""
        return self.leg * np.array([FORWARD, SIDEWAYS])

    def clipped(self, offset: Float[Array, "m 2"]) -> Float[Array, "m 2"]:
        """Return offsets with the place within its limits."""
        place = (self.nominal + offset) @ self.axes
        ahead = np.clip(place[:, 0], -FARTHEST * self.leg, FARTHEST * self.leg)
        aside = np.clip(self.side * place[:, 1], self.narrowest, WIDEST * self.leg)
        return np.stack([ahead, self.side * aside], axis=1) @ self.axes.T - self.nominal


class SwingOffset:
    """The offset of a swinging foot, led to that of its landing by a cubic, anew at every tick."""

    def __init__(self, offset: Float[Array, " 2"]):
        """Start where the foot left the ground."""
        self.offset, self.velocity = np.array(offset, dtype=float), np.zeros(2)
        self.acceleration = np.zeros(2)

    def lead(self, target: Float[Array, " 2"], left: float, step: float) -> None:
        """Go on for a time step, to be at rest at the target when the time left is over.

        The end is planned 20 ms early, and no sooner than in 50 ms.
        """
        T = max(left - 0.02, 0.05)
        a = (6.0 * (target - self.offset) - 4.0 * self.velocity * T) / T**2
        a *= min(1.0, FASTEST / max(float(np.linalg.norm(a)), 1e-9))
        self.acceleration = a
        self.offset = self.offset + step * self.velocity + 0.5 * step**2 * a
        self.velocity = self.velocity + step * a


FASTEST = 60.0
"""Acceleration of the offset [m/s²]."""
