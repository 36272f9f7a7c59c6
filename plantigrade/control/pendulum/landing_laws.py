r"""Landing laws: the next footstep of the linear pendulum, and that of [Tsai2010]_.

Both compare with the recording when its foot strikes, and put the foot where the mass, as it will
be then, goes on as the recorded one does. Undisturbed, they return the recorded footstep.

In single stance the mass swings over the foot and keeps its energy; when the other foot strikes,
the velocity along the new leg is lost. Angles of legs are from the vertical. (The printed text of
the paper lacks Eqs. 1 and 2, the pendulum's energy between two angles and its equation of motion.)
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY

BISECTIONS = 40  # of a landing angle: far below a micrometre of step
MAX_ANGLE = np.deg2rad(75.0)  # of a leg that strikes: where bisection begins

Numbers = float | Float[Array, "..."]


def linear_pendulum(
    position: Float[Array, "..."],
    velocity: Float[Array, "..."],
    pivot: Float[Array, "..."],
    omega: float,
    time: Numbers,
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    r"""Return position and velocity of the mass after a time, at constant height: closed form.

    .. math:: x(t) = p + (x - p) \cosh \omega t + \frac{\dot x}{\omega} \sinh \omega t

    The height of the mass of a walker changes by some centimetres only, the length of the leg by
    as much as that takes: the pendulum of variable length that keeps its height is linear.

    Args:
        position: Position of the mass, horizontal [m].
        velocity: Its velocity [m/s].
        pivot: Lower end of the leg [m].
        omega: Root of gravity by height [1/s].
        time: How much later [s].
    """
    c, s = np.cosh(omega * time), np.sinh(omega * time)
    off = position - pivot
    return pivot + off * c + velocity / omega * s, off * omega * s + velocity * c


def speed_after_strike(speed: Numbers, between: Numbers) -> Float[Array, "..."]:
    r"""Return the speed after the other leg has struck, :math:`V_2 = V_1 \cos\alpha` (Eq. 3).

    Args:
        speed: Before, across the old leg [m/s].
        between: Angle between the legs [rad].
    """
    return np.asarray(speed * np.cos(between))


def leg_length(
    height: Numbers, trailing: Numbers, leading: Numbers, slope: float = 0.0
) -> Float[Array, "..."]:
    r"""Return the length of a leg that strikes a slope (Eq. 8) [m].

    .. math:: r = L_y \frac{\sin(\pi/2 - \theta_{ST} - \theta_G)}
        {\cos\theta_{ST} \, \sin(\pi/2 - \theta_{SW1} + \theta_G)}

    by the law of sines in the triangle of both feet and the mass. (The printed text has lost its
    minus signs.)

    Args:
        height: Height of the mass over the stance foot [m].
        trailing: Angle of the stance leg, positive where the mass is ahead [rad].
        leading: Angle of the leg that strikes, positive where the foot is ahead [rad].
        slope: How far the ground rises that way [rad].
    """
    return np.asarray(
        height
        * np.sin(np.pi / 2 - trailing - slope)
        / (np.cos(trailing) * np.sin(np.pi / 2 - leading + slope))
    )


def energy_after_strike(
    speed: Numbers, trailing: Numbers, leading: Numbers, length: Numbers
) -> Float[Array, "..."]:
    r"""Return the energy after a strike: :math:`\frac12\omega_1^2 + \frac gr \cos\theta_1` [1/s²].

    By Eqs. 5 to 7 the pendulum has it at any later angle too,
    :math:`\frac12\omega_2^2 + \frac gr \cos\theta_2`.

    Args:
        speed: Speed of the mass before the strike [m/s].
        trailing: Angle of the leg that stood [rad].
        leading: Angle of the leg that strikes [rad].
        length: Length of that leg [m].
    """
    rate = speed_after_strike(speed, trailing + leading) / length
    return np.asarray(0.5 * rate**2 + GRAVITY / length * np.cos(leading))


def landing_angle(
    speed: Numbers, trailing: Numbers, height: float, energy: float, slope: float = 0.0
) -> Float[Array, "..."]:
    r"""Return the angle at which a leg must strike to leave a desired energy: Eqs. 5 to 8.

    The energy after a strike falls with its angle, so bisection finds the one that leaves it. (The
    paper names a Runge–Kutta method, which integrates and finds no roots.)

    Args:
        speed: Speed of the mass before the strike, in the direction of the step [m/s].
        trailing: Angle of the stance leg [rad].
        height: Height of the mass over the stance foot [m].
        energy: Desired :func:`energy_after_strike` [1/s²].
        slope: How far the ground rises that way [rad].

    Returns:
        The angle [rad]; zero where the mass is too slow for any, and at most :data:`MAX_ANGLE`.
    """
    speed, trailing = np.broadcast_arrays(
        np.asarray(speed, dtype=float), np.asarray(trailing, dtype=float)
    )
    low, high = np.zeros(speed.shape), np.full(speed.shape, MAX_ANGLE)
    high = np.clip(high, 0.0, np.maximum(np.pi / 2 - np.maximum(trailing, 0.0), 0.0))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        length = leg_length(height, trailing, middle, slope)
        more = energy_after_strike(speed, trailing, middle, length) > energy
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.asarray(0.5 * (low + high))


@dataclass(frozen=True, eq=False)
class ReferenceTouchdown:
    """The reference when its foot strikes; horizontal, ahead and to the left."""

    com: Float[Array, " 2"]  #: Centre of mass [m]
    com_velocity: Float[Array, " 2"]  #: Its velocity [m/s]
    height: float  #: Its height over the stance foot [m]
    stance_foot: Float[Array, " 2"]  #: Position of the stance foot [m]
    footstep: Float[Array, " 2"]  #: Position of the foot that strikes [m]
    omega: float  #: Root of gravity by height [1/s]
    #: Part of the stance foot in what the feet do to the pendulum from then on
    stance_weight: float = 0.0
    #: Part of the foot that strikes, and of those after it; the rest if absent
    later_weight: float = 1.0
    #: Part that the stance foot has in the reference, and here, lifted sooner, leaves to the other
    transferred: float = 0.0
    slope: tuple[float, float] = (0.0, 0.0)  #: How far the ground rises ahead and to the left [rad]


@runtime_checkable
class LandingLaw(Protocol):
    """The law of the next footstep."""

    def footsteps(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stance_foot: Float[Array, " 2"],
        reference: ReferenceTouchdown,
    ) -> Float[Array, "m 2"]:
        """Return footsteps for states of the mass at touchdown [m].

        Args:
            com: The mass at touchdown [m].
            velocity: Its velocity then [m/s].
            stance_foot: Position of the stance foot [m].
            reference: The reference at its touchdown.
        """
        ...


class DivergentLaw:
    r"""The foot is as far behind the extrapolated centre of mass as in the reference.

    :math:`\xi = x + \dot x / \omega` [Hof2005]_. A constant offset of the foot from it makes any
    walk of a linear pendulum stable in one step ([Hof2008]_). In double support the old stance foot
    still counts, with its weight. Where it is lifted sooner than in the reference, the part of its
    weight that is left over passes to the foot that strikes.
    """

    def footsteps(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stance_foot: Float[Array, " 2"],
        reference: ReferenceTouchdown,
    ) -> Float[Array, "m 2"]:
        """Return footsteps for states of the mass at touchdown [m]."""
        ref = reference
        error = com + velocity / ref.omega - ref.com - ref.com_velocity / ref.omega
        error = error - ref.stance_weight * (stance_foot - ref.stance_foot)
        error = error - ref.transferred * (ref.footstep - ref.stance_foot)
        return ref.footstep + error / ref.later_weight


@dataclass(frozen=True)
class EnergyLaw:
    r"""After the strike the mass has the energy that the reference has: Eqs. 5 to 8.

    The paper takes :math:`\theta_{SW2}` and :math:`V_{SW2}` from the recording; but a person
    pushes off and loses less than Eq. 3 says, so that Eq. 5 does not hold of any recording. Here
    the desired energy is that which Eqs. 5 to 7 leave of the recording's own strike, so that they
    return the recorded step. The equations know squares of speeds alone: if the mass moves the
    other way than the recorded one, the foot goes along with its extrapolated centre, from where it
    lands at no speed.

    In the frontal plane the mass swings out to the foot and back. Its energy fixes how near it
    comes, not when it is back, and steps come at the recording's times: nothing brings a swing that
    is late into step again, and walks with Eq. 5 in both planes fall sideways within seconds.
    Therefore the frontal plane is left to :class:`DivergentLaw`, unless ``frontal``.
    """

    frontal: bool = False  #: Whether Eq. 5 decides in the frontal plane, too, as in the paper.

    def footsteps(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stance_foot: Float[Array, " 2"],
        reference: ReferenceTouchdown,
    ) -> Float[Array, "m 2"]:
        """Return footsteps for states of the mass at touchdown [m]."""
        found = DivergentLaw().footsteps(com, velocity, stance_foot, reference)
        for i in range(1 + self.frontal):
            found[:, i] = _in_plane(com[:, i], velocity[:, i], stance_foot[i], reference, i)
        return found


def _in_plane(com, speed, stance_foot, ref: ReferenceTouchdown, i: int) -> Array:
    """Return the footstep along one axis [m]."""
    recorded, h = float(ref.com_velocity[i]), ref.height
    way = 1.0 if recorded >= 0.0 else -1.0
    ahead = way * float((ref.footstep - ref.com)[i])
    behind = way * float((ref.com - ref.stance_foot)[i])
    trailing, leading, slope = np.arctan2(behind, h), np.arctan2(ahead, h), way * ref.slope[i]
    length = leg_length(h, trailing, leading, slope)
    energy = float(energy_after_strike(abs(recorded), trailing, leading, length))
    now = np.arctan2(way * (com - stance_foot), h)
    angle = landing_angle(np.maximum(way * speed, 0.0), now, h, energy, slope)
    back = np.minimum(way * speed, 0.0) / ref.omega
    return com + way * (h * np.tan(angle) + back)


LAWS: dict[str, LandingLaw] = {
    "divergent": DivergentLaw(),
    "energy": EnergyLaw(),
    "energy-both": EnergyLaw(frontal=True),
}
"""Name of a law → the law."""
