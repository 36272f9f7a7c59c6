r"""The next footstep: that of the landing law, within the reach of leg and time."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.planner import FootstepLimits, least_cost
from plantigrade.control.gait.support import drawn_to
from plantigrade.control.pendulum.landing_laws import (
    LandingLaw,
    ReferenceTouchdown,
    linear_pendulum,
)
from plantigrade.control.pendulum.swing import bent_way, detours


@dataclass(frozen=True, kw_only=True)
class PlanSettings:
    """How a walk reaches its footsteps; values were chosen."""

    max_leg_length: float = 1.1
    """Greatest distance of hip and ankle, with the pelvis leant towards the foot [leg lengths]."""
    max_lowering: float = 0.2
    """Greatest lowering of the body for a far footstep [leg lengths]."""
    recovery_lowering: float = 0.07
    """Least lowering of the body in a recovery step, from its decision on [leg lengths]: lowered
    only once the foot was on its way, a body that rose from double support was up to 5 cm too high
    at touchdown, and the foot hung over the ground with a straight leg for 60 to 90 ms. A crouched
    walk, whose legs are always shorter than in standing by more than this, is not lowered: it fell.
    With 0.1 as many pushes are survived, but legs twice as long give way in walking."""
    min_lowering: float = 0.04
    """Extra reach of the legs of a walk before the body is lowered [leg lengths]: an undisturbed
    walk steps this much farther than the recording."""


@dataclass(frozen=True, eq=False)
class Footstep:
    """A planned footstep."""

    position: Float[Array, " 2"]  #: Within reach, world [m]
    unconstrained: Float[Array, " 2"]  #: Position by the landing law [m]
    time: float  #: To touchdown [s]
    rate: float  #: Rate of the phase until then
    com: Float[Array, " 2"]  #: Centre of mass at touchdown [m]
    crossing: int  #: 1 if it is across ahead of the stance foot, -1 behind it, else 0

    @property
    def shortening(self) -> float:
        """Distance from the position by the landing law [m]."""
        return float(np.linalg.norm(self.unconstrained - self.position))


@dataclass(frozen=True, kw_only=True)
class FootReach(FootstepLimits):
    """Where a foot can land, and how soon it can be there; ahead and to the left."""

    reach: PlanSettings  #: How far a leg reaches, and how much the body is lowered for it
    max_descent: float  #: Greatest downward acceleration of the body [m/s²]
    #: Half axes of the ellipse around the stance foot [m]
    clear_way: Float[Array, " 2"]
    hip: Float[Array, " 2"]  #: Hip of the swing leg, from the centre of mass [m]
    hip_height: float  #: Its height above the ankle at the reference's touchdown [m]
    hip_rise: float  #: Its vertical velocity [m/s]
    offset: Float[Array, " 2"]  #: Offset of the swing foot from the reference [m]
    offset_velocity: Float[Array, " 2"]  #: Its rate [m/s]
    leg_momentum: float  #: Angular momentum of a swing leg, as the person has it
    #: Whether the feet may cross; those of a walk that turns land in line at most
    may_cross: bool = True
    #: Way on which the foot is crossing already: 1 ahead of the stance foot, -1 behind it, else 0
    way_taken: int = 0
    #: Whether footsteps are no farther than the swing foot comes in time; otherwise those only cost
    #: more. In a walk that was not pushed the limit led to a fall on tiles of 8 cm
    in_time: bool = True
    #: Whether ways around the stance foot are judged by their acceleration, otherwise by their
    #: length. By acceleration, a walk with legs half as long that was not pushed fell
    by_acceleration: bool = True
    min_arrival_time: float = 0.0  #: Least time in which the path of a swing foot ends [s]
    times: Float[Array, " m"] | None = None  #: Times that are compared [s]
    hips: Float[Array, "m 2"] | None = None  #: Hip at each time, from the stance foot [m]
    #: Reach on the ground from there [m]; any distance if absent
    spans: Float[Array, " m"] | None = None

    def at(self, com: Float[Array, "m 2"], time: Float[Array, " m"]) -> "FootReach":
        """Return the reach at some times: a leg reaches less far from a high hip.

        Without it a foot that was led far aside hung over the ground until the body had fallen.

        Args:
            com: Centre of mass then, from the stance foot [m].
            time: From now [s].
        """
        longest = self.reach.max_leg_length * self.leg_length
        height = self.hip_height + self.hip_rise * time - 0.5 * self.max_descent * time**2
        height = np.maximum(height, longest - self.reach.max_lowering * self.leg_length)
        spans = np.sqrt(np.maximum(longest**2 - height**2, 0.0))
        return replace(self, times=time, hips=com + self.hip, spans=spans)

    def compensated(
        self, offset: Float[Array, "m 2"], time: Float[Array, " m"], omega: float
    ) -> Float[Array, "m 2"]:
        r"""Return offsets that compensate for the momentum of the leg on its way, too.

        A leg with a lateral offset :math:`d` from the reference has the angular momentum
        :math:`m h \kappa \dot d` about the centre of mass. The ground gives it by a force that the
        mass feels, and takes it when the foot has arrived. The first counts for longer: in a time
        :math:`T` the extrapolated centre goes along with the foot by

        .. math:: \kappa \int_0^T \dot d \, e^{\omega (T - t)} dt
            - \frac{\kappa}{\omega} \dot d_0 e^{\omega T}
            \approx \kappa (d \, e^{\omega T / 2} - \frac{\dot d_0}{\omega} e^{\omega T}).

        Args:
            offset: Offset of the footstep without it [m].
            time: To touchdown [s].
            omega: Root of gravity by height [1/s].
        """
        growth = np.exp(0.5 * omega * time)[:, None]
        part = self.leg_momentum * growth
        return (offset - part * (self.offset + growth * self.offset_velocity / omega)) / (
            1.0 - part
        )

    def constrained(self, offset: Float[Array, "m 2"]) -> list[Float[Array, "m 2"]]:
        """Return offsets within reach: on its own side, or across, ahead of the other or behind.

        People who are pushed outward cross in front of the stance foot or behind it, whichever is
        nearer. A foot that crosses keeps its way: planned anew at every tick, it went neither way.
        """
        position = (self.nominal + offset) @ self.axes
        far, past = self.max_length, self.settings.crossover_length * self.leg_length
        position[:, 0] = np.minimum(np.maximum(position[:, 0], -far), far)
        across = self.crossover_width if self.may_cross else min(0.0, self.min_width)
        ways = [(-far, far, self.min_width)]
        if self.way_taken >= 0:
            ways.append((past, np.inf, across))
        if self.may_cross and self.way_taken <= 0:
            ways.append((-np.inf, -past, across))
        return [self._in_reach(position, *way) for way in ways]

    def _in_reach(
        self, position: Float[Array, "m 2"], back: float, front: float, width: float
    ) -> Float[Array, "m 2"]:
        """Return the offsets of footsteps by one way, as far as leg and swing foot reach.

        Args:
            position: Footsteps, ahead of the stance foot and to the left [m].
            back: Least distance ahead by this way [m].
            front: Greatest one [m].
            width: Least lateral distance [m].
        """
        placed = self._limited(position, back, front, width) @ self.axes.T
        if self.times is None or self.hips is None or self.spans is None:
            return placed - self.nominal
        placed = drawn_to(placed, self.hips, self.spans[:, None])
        if not self.in_time:
            return placed - self.nominal
        time = np.maximum(self.times, self.min_arrival_time)[:, None]
        middle = self.nominal + self.swing_offset + 2.0 / 3.0 * time * self.foot_velocity
        placed = drawn_to(placed, middle, self.max_foot_acceleration * time**2 / 6.0)
        return self._limited(placed @ self.axes, back, front, width) @ self.axes.T - self.nominal

    def _limited(
        self, position: Float[Array, "m 2"], back: float, front: float, width: float
    ) -> Float[Array, "m 2"]:
        """Return the nearest footsteps by one way; arguments as for `_in_reach`."""
        ahead = np.minimum(np.maximum(position[:, 0], back), front)
        beside = np.minimum(np.maximum(self.side * position[:, 1], width), self.max_width)
        return np.stack([ahead, self.side * beside], axis=1)

    def crossing_way(self, offset: Float[Array, " 2"]) -> int:
        """Return the way by which a footstep is across: 1 ahead, -1 behind, 0 if it is not."""
        ahead, left = ((self.nominal + offset) @ self.axes).tolist()
        return 0 if self.side * left >= self.min_width - 1e-9 else 1 if ahead > 0.0 else -1

    def way(self, offset: Float[Array, "m 2"], left: Float[Array, " m"]) -> Float[Array, " m"]:
        """Return how far the swing foot has to be moved [m], beyond where it goes by itself.

        Around the stance foot it bends: what counts is the greatest acceleration on the way, as a
        distance from rest to rest; without a push, the length of the way.
        """
        straight = super().way(offset, left)
        size = np.minimum(self.clear_way, [np.inf, self.min_width])
        if size[1] <= 0.0:
            return straight
        outward = np.array([1.0, self.side])
        places = self.swing_offset, offset
        start, ends = ((self.nominal + x) @ self.axes * outward for x in places)
        velocity = self.foot_velocity @ self.axes * outward
        points, around = detours(start, ends, size)
        if not around.any():
            return straight
        first, then = points - start, ends - points
        if self.by_acceleration:
            bent = bent_way(first, then, velocity, left)
        else:
            long, far, near = (np.sqrt((x * x).sum(axis=1)) for x in (first, then, ends - start))
            bent = straight + long + far - near
        return np.where(around, bent, straight)


def next_footstep(
    law: LandingLaw,
    com: Float[Array, " 2"],
    velocity: Float[Array, " 2"],
    pivot: Float[Array, " 2"],
    stance_foot: Float[Array, " 2"],
    time: float,
    reference: ReferenceTouchdown,
    reach: FootReach,
) -> Footstep:
    """Return the next footstep.

    The law gives the footstep for every time at which the foot could touch down, with the mass on a
    linear pendulum until then. The planner takes the time with the least cost of this step and the
    next together (:func:`plantigrade.control.gait.planner.least_cost`).

    Args:
        com: The mass now [m].
        velocity: Its velocity [m/s].
        pivot: Pivot of the pendulum until touchdown [m].
        stance_foot: Position of the stance foot [m].
        time: To the reference's touchdown [s].
        reach: Limits of the footstep, as an offset from that of the reference.
    """
    times = time / reach.rates
    coms, speeds = linear_pendulum(com, velocity, pivot, reference.omega, times[:, None])
    offsets = law.footsteps(coms, speeds, stance_foot, reference) - reference.footstep
    free = reference.footstep + reach.compensated(offsets, times, reference.omega)
    reach = reach.at(coms - stance_foot, times)
    moved = stance_foot - reference.stance_foot
    i, offset = least_cost(free - reference.footstep, moved, time, reach, reference.omega)
    position, rate = reference.footstep + offset, float(reach.rates[i])
    crossing = reach.crossing_way(offset)
    return Footstep(position, free[i], float(times[i]), rate, coms[i], crossing)
