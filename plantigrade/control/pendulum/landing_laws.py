r"""Landing laws: where the swing foot is to step, by the linear pendulum or that of [Tsai2010]_.

Both compare with the recording when its foot strikes, and put the foot where the mass, as it will
be then, goes on as the recorded one does. Undisturbed, they return the recorded footstep.

In single stance the mass swings over the foot and keeps its energy; when the other foot strikes,
the velocity along the new leg is lost. Angles are from the vertical.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY

BISECTIONS = 40  # of a landing angle: far below a micrometre of step
MAX_ANGLE = np.deg2rad(75.0)  # of a leg that strikes: where bisection begins


def carried(
    place: Float[Array, "..."],
    velocity: Float[Array, "..."],
    pivot: Float[Array, "..."],
    omega: float,
    time: float | Float[Array, "..."],
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    r"""Return where the mass is after a time, and how fast, at constant height: closed form.

    .. math:: x(t) = p + (x - p) \cosh \omega t + \frac{\dot x}{\omega} \sinh \omega t

    The height of the mass of a walker changes by some centimetres only, the length of the leg by
    as much as that takes: the pendulum of variable length that keeps its height is linear.

    Args:
        place: Of the mass, horizontal [m].
        velocity: Its velocity [m/s].
        pivot: Where the leg stands [m].
        omega: Root of gravity by height [1/s].
        time: How much later [s].
    """
    c, s = np.cosh(omega * time), np.sinh(omega * time)
    off = place - pivot
    return pivot + off * c + velocity / omega * s, off * omega * s + velocity * c


def struck(
    speed: float | Float[Array, "..."], between: float | Float[Array, "..."]
) -> Float[Array, "..."]:
    r"""Return the speed after the other leg has struck, :math:`V_2 = V_1 \cos\alpha` (Eq. 3).

    Args:
        speed: Before, across the old leg [m/s].
        between: Angle between the legs [rad].
    """
    return np.asarray(speed * np.cos(between))


def leg_length(
    height: float | Float[Array, "..."],
    trailing: float | Float[Array, "..."],
    leading: float | Float[Array, "..."],
    slope: float = 0.0,
) -> Float[Array, "..."]:
    r"""Return how long the leg is that strikes a slope (Eq. 8) [m].

    .. math:: r = L_y \frac{\sin(\pi/2 - \theta_{ST} - \theta_G)}
        {\cos\theta_{ST} \, \sin(\pi/2 - \theta_{SW1} + \theta_G)}

    by the law of sines in the triangle of both feet and the mass. (The printed text has lost its
    minus signs.)

    Args:
        height: Of the mass over the foot that stands [m].
        trailing: Angle of the leg that stands, positive where the mass is ahead [rad].
        leading: Angle of the leg that strikes, positive where the foot is ahead [rad].
        slope: How far the ground rises that way [rad].
    """
    return np.asarray(
        height
        * np.sin(np.pi / 2 - trailing - slope)
        / (np.cos(trailing) * np.sin(np.pi / 2 - leading + slope))
    )


def energy(
    speed: float | Float[Array, "..."],
    trailing: float | Float[Array, "..."],
    leading: float | Float[Array, "..."],
    length: float | Float[Array, "..."],
) -> Float[Array, "..."]:
    r"""Return what a strike leaves: :math:`\frac12\omega_1^2 + \frac gr \cos\theta_1` [1/s²].

    By Eqs. 5 to 7 it is what the pendulum has at any later angle too,
    :math:`\frac12\omega_2^2 + \frac gr \cos\theta_2`.

    Args:
        speed: Of the mass before the strike [m/s].
        trailing: Angle of the leg that stood [rad].
        leading: Angle of the leg that strikes [rad].
        length: Of that leg [m].
    """
    rate = struck(speed, trailing + leading) / length
    return np.asarray(0.5 * rate**2 + GRAVITY / length * np.cos(leading))


def strike_angle(
    speed: float | Float[Array, "..."],
    trailing: float | Float[Array, "..."],
    height: float,
    goal: float,
    slope: float = 0.0,
) -> Float[Array, "..."]:
    r"""Return at which angle a leg must strike to leave a wanted energy: Eqs. 5 to 8.

    What a strike leaves falls with its angle, so bisection finds the one that leaves the goal. (The
    paper names a Runge–Kutta method, which integrates and finds no roots.)

    Args:
        speed: Of the mass before the strike, in the direction of the step [m/s].
        trailing: Angle of the leg that stands [rad].
        height: Of the mass over the foot that stands [m].
        goal: What :func:`energy` is to be [1/s²].
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
        more = energy(speed, trailing, middle, length) > goal
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.asarray(0.5 * (low + high))


@dataclass(frozen=True, eq=False)
class Strike:
    """What the recording has when its foot strikes; world axes, horizontal.

    Attributes:
        com: The mass [m].
        velocity: Its velocity [m/s].
        height: Its height over the standing foot [m].
        stands: The standing foot [m].
        lands: The foot that strikes [m].
        axes: Ahead and to the left, as columns.
        omega: Root of gravity by height [1/s].
        kept: How much the standing foot still moves the pendulum, of what all feet do.
        later: How much the foot that lands does, with those after it; the rest if absent.
        slope: How far the ground rises along each axis [rad].
    """

    com: Float[Array, " 2"]
    velocity: Float[Array, " 2"]
    height: float
    stands: Float[Array, " 2"]
    lands: Float[Array, " 2"]
    axes: Float[Array, "2 2"]
    omega: float
    kept: float = 0.0
    later: float = 1.0
    slope: tuple[float, float] = (0.0, 0.0)


@runtime_checkable
class LandingLaw(Protocol):
    """Where a foot is to land."""

    def place(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stands: Float[Array, " 2"],
        strike: Strike,
    ) -> Float[Array, "m 2"]:
        """Return landing places for states of the mass at the strike.

        Args:
            com: The mass when the foot strikes [m].
            velocity: Its velocity then [m/s].
            stands: The standing foot [m].
            strike: What the recording has then.
        """
        ...


class DivergentLaw:
    r"""The extrapolated centre of mass is to be as far ahead of the foot as in the recording.

    :math:`\xi = x + \dot x / \omega` [Hof2005]_. A constant offset of the foot from it makes any
    walk of a linear pendulum stable in one step ([Hof2008]_). While both feet stand, the old one
    carries on for a part ``kept`` of what the pendulum still feels of it.
    """

    def place(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stands: Float[Array, " 2"],
        strike: Strike,
    ) -> Float[Array, "m 2"]:
        """Return landing places for states of the mass at the strike."""
        off = com + velocity / strike.omega - strike.com - strike.velocity / strike.omega
        off = (off - strike.kept * (stands - strike.stands)) / strike.later
        return strike.lands + off


@dataclass(frozen=True)
class EnergyLaw:
    r"""After the strike the mass is to have the energy that the recorded one has: Eqs. 5 to 8.

    The paper takes :math:`\theta_{SW2}` and :math:`V_{SW2}` from the recording; but a person
    pushes off and loses less than Eq. 3 says, so that Eq. 5 does not hold of any recording. Here
    the goal is what Eqs. 5 to 7 leave of the recording's own strike, so that they return the
    recorded step. The equations know squares of speeds alone: of a mass that moves the other way
    than the recorded one, the foot goes along with its extrapolated centre, from where it lands at
    no speed.

    In the frontal plane the mass swings out to the foot and back. Its energy fixes how near it
    comes, not when it is back, and steps come at the recording's times: nothing brings a swing that
    is late into step again, and walks with Eq. 5 in both planes fall sideways within seconds.
    Therefore the frontal plane is left to :class:`DivergentLaw`, unless ``frontal``.

    Attributes:
        frontal: Whether Eq. 5 decides in the frontal plane, too, as in the paper.
    """

    frontal: bool = False

    def place(
        self,
        com: Float[Array, "m 2"],
        velocity: Float[Array, "m 2"],
        stands: Float[Array, " 2"],
        strike: Strike,
    ) -> Float[Array, "m 2"]:
        """Return landing places for states of the mass at the strike."""
        along = DivergentLaw().place(com, velocity, stands, strike) @ strike.axes
        for i, axis in enumerate(strike.axes.T):
            if i == 0 or self.frontal:
                along[:, i] = _in_plane(
                    com @ axis,
                    velocity @ axis,
                    float(stands @ axis),
                    strike,
                    axis,
                    strike.slope[i],
                )
        return along @ strike.axes.T


def _in_plane(com, speed, stands: float, strike: Strike, axis, slope: float) -> Array:
    """Return the landing place along one axis."""
    own = float(strike.velocity @ axis)
    way = 1.0 if own >= 0.0 else -1.0
    h = strike.height
    ahead = way * float((strike.lands - strike.com) @ axis)
    behind = way * float((strike.com - strike.stands) @ axis)
    trailing, leading = np.arctan2(behind, h), np.arctan2(ahead, h)
    tilt = way * slope
    goal = float(energy(abs(own), trailing, leading, leg_length(h, trailing, leading, tilt)))
    now = np.arctan2(way * (com - stands), h)
    with_it = np.maximum(way * speed, 0.0)
    angle = strike_angle(with_it, now, h, goal, tilt)
    back = np.minimum(way * speed, 0.0) / strike.omega
    return com + way * (h * np.tan(angle) + back)


LAWS: dict[str, LandingLaw] = {
    "divergent": DivergentLaw(),
    "energy": EnergyLaw(),
    "energy-both": EnergyLaw(frontal=True),
}
"""Name of a law → the law."""
