r"""Offset and time of the next footstep from the divergent component of motion.

During a swing the deviation of the divergent component from the motion grows about the effective
pivot of this step, so that it is known for the instant of touchdown. The next foot steps where the
deviation left then is just what the offsets of the feet explain
(:mod:`plantigrade.control.gait.divergent`), so that the motion goes on from there undisturbed. A
step taken sooner leaves less to explain.

The step after the next, of the other foot, corrects the error that a step within the limits leaves:
it has room on the other side. The planner takes the rate with the least cost of both steps
together: pushed outward, a person sets the foot down sooner and near, and corrects the rest with
the next.

Offsets decay: the stance after the next is planned with :attr:`FootstepSettings.offset_decay` times
the offset of the next, and so on, so that the person comes back onto the planned path.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.gait.divergent import effective_pivot
from plantigrade.control.gait.step import StepSettings
from plantigrade.control.gait.swing import SwingOffsetSettings

LIMIT_COST = 1e4  # [1/m²] of leaving limits, or what a swing foot lacks: far above all others


@dataclass(frozen=True, kw_only=True)
class FootstepSettings:
    """Limits and costs of the footsteps of a gait; costs are relative to those of offsets."""

    rates: tuple[float, ...] = (0.35, 0.5, 0.68, 0.85, 0.92, 1.0, 1.1, 1.25, 1.45, 1.7, 2.0, 2.5)
    """Rates of the phase until touchdown that the planner compares, slow ones for a foot that is
    late. Chosen (±20 %: 0.9 s)."""
    offset_decay: float = 0.85
    """Part of a footstep's offset that is left after the next step. Chosen (±20 %: deviation 14
    %)."""
    forward_scale: float = 0.16
    """Offset ahead or behind that costs 1 [leg lengths]. Chosen (±20 %: 0.7 s)."""
    lateral_scale: float = 0.065
    """Offset to the side that costs 1 [leg lengths]. Chosen (±20 %: 1.3 s)."""
    rate_cost: float = 36.0
    """Cost of ln(rate)². Chosen (±20 %: deviation 5 %)."""
    max_step_length: float = 2.0 * StepSettings.max_leg_extension
    """Greatest distance of a footstep ahead of or behind the stance foot [leg lengths]: both legs
    extended as in recovery steps."""
    max_step_width: float = StepSettings.max_step
    """Greatest lateral distance of a footstep from the stance foot [leg lengths]; as of recovery
    steps."""
    crossover_length: float = SwingOffsetSettings.passing_length
    """Step length from which the foot may cross over in front of the other [leg lengths]; as in
    passing it."""
    crossover_width: float = -SwingOffsetSettings.passing_length
    """Least step width of a crossover step, negative beyond the other foot [leg lengths]; as far as
    a foot is ahead that crosses over."""
    next_step_cost: float = 0.3
    """Cost of what the step after the next has to make up, by that of the next: with 1, a turn to
    and fro began with a step of 49 cm to the side, with 0.3 of 36 cm."""

    @property
    def next_step_time(self) -> float:
        """Least time from one touchdown to the next [s]; that of the fastest recovery step."""
        return StepSettings().step_time

    def lasting_room(self, omega: float) -> float:
        """Return the room of all steps to come, by that of the next [1].

        A step that comes later counts for less, as errors grow until then ([Koolen2012]_).

        Args:
            omega: Root of gravity by height [1/s].
        """
        return 1.0 / (1.0 - float(np.exp(-omega * self.next_step_time)))

    def split(
        self, first: int, weights: Float[Array, " k"], number: int
    ) -> tuple[Bool[Array, " k"], float]:
        """Return which stances, numbered from ``first`` on, come before one; weight of the others.

        The offsets of these decay from one to the next.
        """
        before = np.arange(first, first + len(weights)) < number
        later = weights[~before]
        return before, float(later @ self.offset_decay ** np.arange(len(later)))


@dataclass(frozen=True)
class StepAdjustment:
    """How a step differs from that of the motion."""

    offset: Float[Array, " 2"]  #: Offset of its footstep, world [m]
    unconstrained: Float[Array, " 2"]  #: The offset without limits [m]
    rate: float  #: Rate of the phase until touchdown


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
    limits: "FootstepLimits",
) -> StepAdjustment:
    r"""Return offset and rate of the next step.

    With the effective pivot :math:`\bar p` of the motion itself and :math:`T` the time left,

    .. math:: \delta\xi_{td} = e^{\omega T / r} (\xi - \bar p - o) + \bar p + o - \xi_{ref}(td),
        \quad o_{next} = (\delta\xi_{td} - \beta_{st} o_{st}) / \beta_{later} .

    Args:
        xi: Divergent component, world [m].
        xi_now: That of the motion now.
        xi_touchdown: That of the motion at touchdown.
        omega: Rate of the pendulum [1/s].
        left: Time until the motion's touchdown [s].
        pivot_offset: Offset of the centre of pressure by the stance feet [m].
        standing_offset: Weighted offset of the feet that still stand after touchdown [m].
        later_weight: Weight of the next stance and those after it.
    """
    growth = float(np.exp(omega * left))
    pivot = effective_pivot(xi_now, xi_touchdown, growth)
    growth = np.exp(omega * left / limits.rates)[:, None]
    deviation = growth * (xi - pivot - pivot_offset) + pivot + pivot_offset - xi_touchdown
    offsets = (deviation - standing_weight * standing_offset) / later_weight
    best, offset = least_cost(offsets, standing_offset, left, limits, omega)
    return StepAdjustment(offset, offsets[best], float(limits.rates[best]))


def least_cost(
    offsets: Float[Array, "m 2"],
    standing_offset: Float[Array, " 2"],
    left: float,
    limits: "FootstepLimits",
    omega: float,
) -> tuple[int, Float[Array, " 2"]]:
    """Return the rate of least cost, by its index, and the offset within the limits.

    Args:
        offsets: Desired offset at each rate [m].
        standing_offset: Offset of the stance foot [m].
        left: Time until the motion's touchdown [s].
        omega: Rate of the pendulum, at which what a step misses grows until the next [1/s].
    """
    settings, rates = limits.settings, limits.rates
    growth = float(np.exp(omega * settings.next_step_time))
    moved = (offsets - standing_offset) @ (limits.axes / limits.scale)
    effort = (moved * moved).sum(axis=1) + settings.rate_cost * np.log(rates) ** 2
    ways = limits.constrained(offsets)
    tried, n = np.concatenate(ways), len(ways)  # all ways at once: calls cost more than numbers
    missed = growth * (np.tile(offsets, (n, 1)) - tried)
    later = limits.next_step_cost(missed) + limits.swing_cost(tried, np.tile(left / rates, n))
    cost = np.tile(effort, n) + later
    best = int(np.argmin(cost))
    return best % len(rates), tried[best]


@dataclass(frozen=True)
class FootstepLimits:
    """Limits of the next footstep, from the stance foot."""

    axes: Float[Array, "2 2"]  #: Ahead and to the left, as columns
    nominal: Float[Array, " 2"]  #: Footstep of the motion, from where the stance foot really is [m]
    side: float  #: 1 for the left foot, -1 for the right
    leg_length: float  #: Length of the leg [m]
    min_width: float  #: Least step width [m]
    swing_offset: Float[Array, " 2"]  #: Offset at which the foot would land where it is now [m]
    settings: FootstepSettings = FootstepSettings()  #: Limits and costs
    max_foot_acceleration: float = np.inf  #: Greatest acceleration of the swing foot [m/s²]
    #: Room ahead or behind of all steps to come, by that of the next one
    lasting_room: float = 1.0
    #: Velocity of the swing foot, on the way to its footstep [m/s]
    foot_velocity: Float[Array, " 2"] = field(default_factory=lambda: np.zeros(2))

    @cached_property
    def rates(self) -> Float[Array, " m"]:
        """Rates of the phase that are compared."""
        return np.array(self.settings.rates)

    @property
    def crossover_width(self) -> float:
        """Least width of a crossover step [m]."""
        return min(self.settings.crossover_width * self.leg_length, self.min_width)

    @property
    def max_length(self) -> float:
        """Greatest step length [m]."""
        return self.settings.max_step_length * self.leg_length

    @property
    def max_width(self) -> float:
        """Greatest step width [m]."""
        return self.settings.max_step_width * self.leg_length

    @cached_property
    def scale(self) -> Float[Array, " 2"]:
        """Offsets that cost 1 [m]."""
        return self.leg_length * np.array(
            [self.settings.forward_scale, self.settings.lateral_scale]
        )

    def constrained(self, offset: Float[Array, "m 2"]) -> list[Float[Array, "m 2"]]:
        """Return offsets within the limits, one way or more."""
        position = (self.nominal + offset) @ self.axes
        ahead = _clipped(position[:, 0], -self.max_length, self.max_length)
        crosses = ahead > self.settings.crossover_length * self.leg_length
        nearest = np.where(crosses, self.crossover_width, self.min_width)
        width = _clipped(self.side * position[:, 1], nearest, self.max_width)
        return [np.stack([ahead, self.side * width], axis=1) @ self.axes.T - self.nominal]

    def next_step_cost(self, missed: Float[Array, "m 2"]) -> Float[Array, " m"]:
        """Return the cost of what the step after this one, of the other foot, must make up.

        Args:
            missed: Its offset for what this step misses [m].
        """
        settings, missed = self.settings, missed @ self.axes
        width = self.min_width - self.side * missed[:, 1]
        over = width - _clipped(width, self.min_width, self.max_width)
        # Half a step longer than the motion's is all that one step has ahead.
        room = 0.5 * self.max_length * self.lasting_room
        over = over**2 + np.maximum(np.abs(missed[:, 0]) - room, 0.0) ** 2
        missed /= self.scale
        return settings.next_step_cost * (missed * missed).sum(axis=1) + LIMIT_COST * over

    def swing_cost(
        self, offset: Float[Array, "m 2"], left: Float[Array, " m"]
    ) -> Float[Array, " m"]:
        """Return the cost of footsteps that the swing foot does not reach in time.

        It goes along a cubic, whose acceleration is greatest at its ends.

        Args:
            offset: Offset of the footstep [m].
            left: Time until touchdown [s].
        """
        missed = self.way(offset, left) - self.max_foot_acceleration * left**2 / 6.0
        return LIMIT_COST * np.maximum(missed, 0.0) ** 2

    def way(self, offset: Float[Array, "m 2"], left: Float[Array, " m"]) -> Float[Array, " m"]:
        """Return how far the swing foot has to be moved [m], beyond where it goes by itself.

        Arguments as for `swing_cost`.
        """
        away = offset - self.swing_offset - 2.0 / 3.0 * left[:, None] * self.foot_velocity
        return np.sqrt((away * away).sum(axis=1))


def _clipped(x: Array, low: Array | float, high: float) -> Array:
    """Return numbers between limits; ``np.clip`` is slower."""
    return np.minimum(np.maximum(x, low), high)
