r"""Where the swinging foot is to land: two laws behind one interface, and what is in reach.

Both laws ask what the recording has when its foot strikes, and put the foot where the mass, as it
will be then, goes on as the recorded one does. Undisturbed, they return the recorded place.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.planner import FootstepLimits, FootstepSettings, least_cost
from plantigrade.control.pendulum.landing_laws import LandingLaw, Strike, carried
from plantigrade.control.pendulum.swing import SwingSettings, detour_length

FOOTSTEPS = FootstepSettings(
    rates=(0.35, 0.5, 0.68, 0.85, 0.92, 1.0, 1.1, 1.25, 1.45, 1.7, 2.0, 2.5),
    offset_decay=0.85,
    max_step_length=1.3,
    max_step_width=1.0,
    crossover_length=0.3,
    crossover_width=-0.3,
    foot_speed_cost=1e4,
)
"""Footsteps of a pendulum: slowly where the foot is late, and wider, for the body goes down for
them."""
SWINGS = 70.0
"""Acceleration of a swinging foot, at most [m/s²]. A recorded step of 1.2 m in 0.4 s needs 40."""
STRETCHED, DROPS, DEEPEST = 1.1, 3.0, 0.25
"""A leg reaches so far from the hip, where the pelvis leans towards the foot [leg lengths]; as fast
the body can go down for it [m/s²], and so far at most [leg lengths]."""


@dataclass(frozen=True, eq=False)
class Landing:
    """Where and when the swinging foot is to land.

    Attributes:
        place: Where, within reach, world [m].
        free: Where the law has it [m].
        after: In how much time [s].
        rate: Rate of the recording at which that is.
        com: Where the mass will be then [m].
    """

    place: Float[Array, " 2"]
    free: Float[Array, " 2"]
    after: float
    rate: float
    com: Float[Array, " 2"]

    @property
    def short(self) -> float:
        """How far the place is from where the law has it [m]."""
        return float(np.linalg.norm(self.free - self.place))


@dataclass(frozen=True, kw_only=True)
class Reach(FootstepLimits):
    """Where a foot can land, and how soon it can be there.

    Attributes:
        speed: Of the foot now [m/s].
        hip: The hip of the swinging leg, beside the mass [m].
        high: Height of that hip above the ankle where the recording's foot lands [m].
        rises: How fast it rises [m/s].
        moved: How far the swinging foot is beside the recording now [m].
        moves: How fast it is led farther [m/s].
        reaction: How far the extrapolated centre goes along with the foot, by its distance.
        hips: Where it is at each time, from the standing foot along the axes [m].
        spans: How far from there the leg reaches on the ground then [m]; any distance if absent.
        may_cross: Whether the feet may cross; those of a walk that turns do not.
        stance_foot_size: Half axes of the ellipse around the other foot [leg lengths].
    """

    speed: Float[Array, " 2"]
    hip: Float[Array, " 2"]
    high: float
    rises: float
    moved: Float[Array, " 2"]
    moves: Float[Array, " 2"]
    reaction: float
    hips: Float[Array, "m 2"] | None = None
    spans: Float[Array, " m"] | None = None
    settings: FootstepSettings = FOOTSTEPS
    may_cross: bool = True
    stance_foot_size: tuple[float, float] = SwingSettings().stance_foot_size

    def at(self, mass: Float[Array, "m 2"], time: Float[Array, " m"]) -> "Reach":
        """Return the reach at some times: high above the ground a leg does not reach far.

        Without it a foot that was led far aside hung over the ground until the body had fallen.

        Args:
            mass: The mass then, from the standing foot [m].
            time: From now [s].
        """
        longest = STRETCHED * self.leg_length
        high = self.high + self.rises * time - 0.5 * DROPS * time**2
        high = np.maximum(high, longest - DEEPEST * self.leg_length)
        spans = np.sqrt(np.maximum(longest**2 - high**2, 0.0))
        return replace(self, hips=(mass + self.hip) @ self.axes, spans=spans)

    def made_up(
        self, offset: Float[Array, "m 2"], time: Float[Array, " m"], omega: float
    ) -> Float[Array, "m 2"]:
        r"""Return offsets that make up for what leading the leg there does to the mass, too.

        A leg that is led beside the recording by :math:`d` has the angular momentum
        :math:`m h \kappa \dot d` about the centre of mass. The ground gives it by a force that the
        mass feels, and takes it when the foot has arrived. The first counts for longer: in a time
        :math:`T` the extrapolated centre goes along with the foot by

        .. math:: \kappa \int_0^T \dot d \, e^{\omega (T - t)} dt
            - \frac{\kappa}{\omega} \dot d_0 e^{\omega T}
            \approx \kappa (d \, e^{\omega T / 2} - \frac{\dot d_0}{\omega} e^{\omega T}).

        Args:
            offset: Where the foot would have to land without it [m].
            time: In what time [s].
            omega: Root of gravity by height [1/s].
        """
        grown = np.exp(0.5 * omega * time)[:, None]
        by = self.reaction * grown
        return (offset - by * (self.moved + grown * self.moves / omega)) / (1.0 - by)

    def constrained(self, offset: Float[Array, "m 2"]) -> list[Float[Array, "m 2"]]:
        """Return offsets with the place in reach: beside the other foot, or across, at its ends.

        People who are pushed outward cross in front of the foot that stands or behind it,
        whichever is nearer.
        """
        place = (self.nominal + offset) @ self.axes
        far, widest = self.max_length, self.max_width
        past = self.settings.crossover_length * self.leg_length
        ahead = np.minimum(np.maximum(place[:, 0], -far), far)
        beside, across = (
            np.minimum(np.maximum(self.side * place[:, 1], least), widest)
            for least in (self.min_width, self.crossover_width)
        )
        ways = [(ahead, beside)]
        if self.may_cross:
            ways += [(np.maximum(ahead, past), across), (np.minimum(ahead, -past), across)]
        return [self._in_reach(np.stack([x, self.side * y], axis=1)) for x, y in ways]

    def _in_reach(self, place: Float[Array, "m 2"]) -> Float[Array, "m 2"]:
        """Return the offsets of places, no farther away than the leg reaches."""
        if self.hips is not None and self.spans is not None:
            away = place - self.hips
            far = np.sqrt((away * away).sum(axis=1))
            part = np.minimum(self.spans / np.maximum(far, 1e-9), 1.0)
            place = self.hips + part[:, None] * away
        return place @ self.axes.T - self.nominal

    def _around(self, offset: Float[Array, "m 2"]) -> Float[Array, " m"]:
        """Return by how much the ways around the other foot are longer than straight ones [m]."""
        outward = np.array([1.0, self.side])
        ahead, sideways = self.stance_foot_size
        size = self.leg_length * np.array([ahead, min(sideways, self.min_width / self.leg_length)])
        if size[1] <= 0.0:
            return np.zeros(len(offset))
        start, ends = (
            (self.nominal + x) @ self.axes * outward for x in (self.swing_offset, offset)
        )
        return detour_length(start, ends, size)

    def swing_cost(
        self, offset: Float[Array, "m 2"], left: Float[Array, " m"]
    ) -> Float[Array, " m"]:
        """Return what it costs that the foot would have to be faster than it can.

        It goes along a cubic, whose acceleration is greatest at its ends.

        Args:
            offset: Where it lands [m].
            left: In what time [s].
        """
        away = offset - self.swing_offset - 2.0 / 3.0 * left[:, None] * self.speed
        far = np.sqrt((away * away).sum(axis=1)) + self._around(offset)
        return self.settings.foot_speed_cost * np.maximum(far - SWINGS * left**2 / 6.0, 0.0) ** 2


def landing(
    law: LandingLaw,
    com: Float[Array, " 2"],
    velocity: Float[Array, " 2"],
    pivot: Float[Array, " 2"],
    stands: Float[Array, " 2"],
    left: float,
    strike: Strike,
    box: Reach,
) -> Landing:
    """Return where and when the swinging foot is to land.

    The mass is carried over the pivot to every time at which the foot could strike; the law says
    where it should. Of all times the one is taken after which this step and the next together are
    easiest, as in a replay (:func:`plantigrade.control.gait.planner.least_cost`).

    Args:
        law: Says where.
        com: The mass now [m].
        velocity: Its velocity [m/s].
        pivot: About which it falls until then [m].
        stands: The standing foot [m].
        left: Until the recording's foot strikes [s].
        strike: What the recording has then.
        box: Where and how soon the foot can land, beside the place of the recording's.
    """
    rates = box.rates
    time = left / rates
    there, speed = carried(com, velocity, pivot, strike.omega, time[:, None])
    free = law.place(there, speed, stands, strike)
    free = strike.lands + box.made_up(free - strike.lands, time, strike.omega)
    moved = stands - strike.stands
    box = box.at(there - stands, time)
    i, offset = least_cost(free - strike.lands, moved, left, box, strike.omega)
    place = strike.lands + offset
    return Landing(place, free[i], float(time[i]), float(rates[i]), there[i])
