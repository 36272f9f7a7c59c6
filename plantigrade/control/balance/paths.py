r"""Paths of ankles and of the centre of mass through the frames of a script.

Between frames every number runs along a quintic through values, slopes and accelerations: at rest
where it turns or stays, with the slope of a monotone cubic where it goes on. From rest to rest that
is the path of least jerk.

Where no foot presses the centre of mass falls freely: it leaves the ground and meets it with the
speed :math:`g T / 2` of a flight of :math:`T` between equal heights, and with the acceleration
:math:`-g`, which is to say with no force. The acceleration at the bottom of the crouch before it,
and of the landing after it, is the one that needs the least force.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BPoly, PchipInterpolator

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError

N_SAMPLES = 60  # between two frames, where the force is looked at
N_ACCELERATIONS = 31  # tried at the bottom of a crouch
FORCE_TOLERANCE = 0.05  # [body weights] of a pull that is the quintic's, not the script's


@dataclass(frozen=True, kw_only=True)
class PathSettings:
    """Flights of scripts."""

    max_force: float = 3.0
    """Greatest ground force a script may need [body weights]. Jumps for height take 2 to 2.5."""
    max_crouch_acceleration: float = 1.5
    """Greatest acceleration tried at the bottom of a crouch [g]. Chosen."""
    heel_rise_powers: tuple[float, float] = (3.0, 12.0)
    """Least and greatest power of time by which a heel rises before a flight. Chosen."""


def through(
    at: Float[Array, " k"], values: Float[Array, "k m"], time: Float[Array, " n"]
) -> Float[Array, "n m"]:
    """Return values between frames.

    Args:
        at: Times of the frames [s].
        values: Their values.
        time: Times of the result [s].
    """
    return _quintic(at, values, _slopes(at, values), np.zeros_like(values))(time)


def _quintic(at: Array, values: Array, slopes: Array, accelerations: Array) -> BPoly:
    return BPoly.from_derivatives(at, np.stack([values, slopes, accelerations], axis=1))


def _slopes(at: Array, values: Array) -> Array:
    slopes = np.asarray(PchipInterpolator(at, values).derivative()(at))
    slopes[[0, -1]] = 0.0
    return slopes


def flights_of(flies: Bool[Array, " k"]) -> list[tuple[int, int]]:
    """Return the first and last frame of every flight.

    Args:
        flies: Whether the body flies from each frame to the next.
    """
    edges = np.flatnonzero(np.diff(np.r_[False, flies, False].astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def com_height(
    at: Float[Array, " k"],
    height: Float[Array, " k"],
    flights: list[tuple[int, int]],
    time: Float[Array, " n"],
    settings: PathSettings,
) -> Float[Array, " n"]:
    """Return the height of the centre of mass between frames, in flight that of a fall [m].

    Args:
        at: Times of the frames [s].
        height: Height in each; what is within a flight does not count [m].
        flights: First and last frame of every flight.
        time: Times of the result [s].
        settings: Limit of the force.

    Raises:
        ParameterError: If that needs a pull of the ground, or a push beyond the limit.
    """
    if not flights:
        return through(at, height[:, None], time)[:, 0]
    airborne = np.zeros(len(at), dtype=bool)
    for a, b in flights:
        airborne[a + 1 : b] = True
    keep = np.flatnonzero(~airborne)
    at, height = at[keep], height[keep]
    slopes, accelerations = _slopes(at, height), np.zeros(len(at))
    number = {int(k): i for i, k in enumerate(keep)}
    edges = [(number[a], number[b]) for a, b in flights]
    for a, b in edges:
        span = at[b] - at[a]
        mean = (height[b] - height[a]) / span
        slopes[[a, b]] = mean + 0.5 * GRAVITY * span, mean - 0.5 * GRAVITY * span
        accelerations[[a, b]] = -GRAVITY
    fall, bound = {a for a, _ in edges}, {i for pair in edges for i in pair}
    tried = np.linspace(0.0, settings.max_crouch_acceleration, N_ACCELERATIONS) * GRAVITY
    for turn in (i for a, b in edges for i in (a - 1, b + 1)):
        if 0 < turn < len(at) - 1 and turn not in bound:
            slopes[turn] = 0.0
            near = [k for k in (turn - 1, turn) if k not in fall]
            needed = []
            for acceleration in tried:
                accelerations[turn] = acceleration
                path = _quintic(at, height, slopes, accelerations)
                needed.append(max(float(np.abs(_between(path, at, k)).max()) for k in near))
            accelerations[turn] = tried[int(np.argmin(needed))]
    path = _quintic(at, height, slopes, accelerations)
    for k in range(len(at) - 1):
        if k in fall:
            continue
        force = 1.0 + _between(path, at, k) / GRAVITY
        if not (force.min() > -FORCE_TOLERANCE and force.max() <= settings.max_force):
            raise ParameterError(
                f"from {at[k]:g} to {at[k + 1]:g} s the ground would have to push with "
                f"{force.min():.1f} to {force.max():.1f} body weights, and it can with 0 to "
                f"{settings.max_force:g}: give the body more time or way before and after a flight"
            )
    return path(time)


def _between(path: BPoly, at: Array, k: int) -> Array:
    """Return accelerations from a frame to the next."""
    return path(np.linspace(at[k], at[k + 1], N_SAMPLES), 2)


def ankle_path(
    at: Float[Array, " k"],
    ankle: Float[Array, "k 3"],
    flights: list[tuple[int, int]],
    time: Float[Array, " n"],
    settings: PathSettings,
) -> Float[Array, "n 3"]:
    """Return the position of an ankle: along with the body in flight, rising late before it.

    Args:
        at: Times of the frames [s].
        ankle: Its position in each; in flight, from where the body has taken it [m].
        flights: First and last frame of every flight.
        time: Times of the result [s].
        settings: How late it rises.
    """
    out = through(at, ankle, time)
    for a, b in flights:
        span = at[b] - at[a]
        own = (time >= at[a]) & (time <= at[b])
        s = time[own] - at[a]
        out[own, 2] += 0.5 * GRAVITY * s * (span - s)
        speed = 0.5 * GRAVITY * span
        for i, j in ((a - 1, a), (b + 1, b)):
            if not 0 <= i < len(at) or ankle[j, 2] <= ankle[i, 2]:
                continue
            duration, up = abs(at[j] - at[i]), ankle[j, 2] - ankle[i, 2]
            own = (time >= min(at[i], at[j])) & (time <= max(at[i], at[j]))
            power = float(np.clip(speed * duration / up, *settings.heel_rise_powers))
            out[own, 2] = ankle[i, 2] + up * (np.abs(time[own] - at[i]) / duration) ** power
    return out
