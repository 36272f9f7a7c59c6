r"""The inverted pendulum of [Tsai2010]_: a mass on a leg, in one vertical plane.

Angles are from the vertical. In single stance the mass swings over the foot and keeps its energy;
when the other foot strikes, what moves along the new leg is lost. The printed text of the paper
lacks Eqs. 1 and 2; they are the pendulum's energy between two angles, and its equation of motion.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY

ROUNDS = 40
"""Bisections of a landing angle: far below a micrometre of step."""
STEEPEST = np.deg2rad(75.0)
"""Greatest angle of a leg that strikes."""


def swung(
    rate: float | Float[Array, "..."],
    start: float | Float[Array, "..."],
    end: float | Float[Array, "..."],
    length: float | Float[Array, "..."],
) -> Float[Array, "..."]:
    r"""Return how fast a pendulum passes an angle, from how fast it passed another (Eq. 1).

    .. math:: \omega_e^2 = \omega_s^2 + 2 \frac{g}{r} (\cos\theta_s - \cos\theta_e)

    Args:
        rate: Angular rate at the start [rad/s].
        start: Angle there [rad].
        end: Angle in question [rad].
        length: Of the leg [m].

    Returns:
        The angular rate [rad/s]; NaN where the pendulum turns back before.
    """
    squared = np.square(rate) + 2 * GRAVITY / length * (np.cos(start) - np.cos(end))
    return np.asarray(np.sqrt(np.where(squared >= 0.0, squared, np.nan)))


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


def lost(mass: float, speed: float, between: float) -> float:
    r"""Return the energy that a strike takes, :math:`\frac m2 (V_1 \sin\alpha)^2` (Eq. 4) [J].

    Args:
        mass: Of the body [kg].
        speed: Before, across the old leg [m/s].
        between: Angle between the legs [rad].
    """
    return 0.5 * mass * float(speed * np.sin(between)) ** 2


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
        The angle [rad]; zero where the mass is too slow for any, and at most :data:`STEEPEST`.
    """
    speed, trailing = np.broadcast_arrays(
        np.asarray(speed, dtype=float), np.asarray(trailing, dtype=float)
    )
    low, high = np.zeros(speed.shape), np.full(speed.shape, STEEPEST)
    high = np.clip(high, 0.0, np.maximum(np.pi / 2 - np.maximum(trailing, 0.0), 0.0))
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        length = leg_length(height, trailing, middle, slope)
        more = energy(speed, trailing, middle, length) > goal
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.asarray(0.5 * (low + high))
