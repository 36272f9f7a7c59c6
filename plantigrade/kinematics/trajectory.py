"""A vector that moves smoothly: value, velocity and acceleration at any time."""

from bisect import bisect_right
from math import factorial

import numpy as np
from scipy.interpolate import make_interp_spline

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError


class Trajectory:
    """A quintic spline through samples (of lower degree through few); one sample stays where it is.

    Beyond its ends it stays where it ended.

    Args:
        time: Time of each sample [s], increasing.
        values: The samples.
    """

    def __init__(self, time: Float[Array, " n"], values: Float[Array, "n dimension"]):
        time, values = np.asarray(time, float), np.asarray(values, float)
        if len(time) != len(values) or not len(time):
            raise ParameterError(f"{len(time)} times for {len(values)} samples of a trajectory")
        if not np.isfinite(values).all() or not (np.diff(time) > 0).all():
            raise ParameterError("a trajectory needs finite samples at increasing times")
        self._first, self._last = float(time[0]), float(time[-1])
        degree = 5 if len(time) > 5 else 3 if len(time) > 3 else min(1, len(time) - 1)
        if degree == 0:
            x, c = time[:1], values[:1, None]
        else:
            spline = make_interp_spline(time, values, k=degree)
            x = np.unique(spline.t)[:-1]
            falling = range(degree, -1, -1)
            c = np.stack([spline(x, nu=k) / factorial(k) for k in falling], axis=1)
        self._c = c  # (n_pieces, degree + 1, dimension), highest power first
        power = np.arange(degree, -1, -1)
        self._factors = np.array([np.ones_like(power), power, power * (power - 1)], dtype=float)
        self._powers = np.maximum(power - [[0], [1], [2]], 0)  # of value, velocity, acceleration
        self._starts = x.tolist()  # of the pieces
        self._asked, self._rates = np.nan, np.zeros((3, c.shape[2]))

    @classmethod
    def fixed(cls, value: Float[Array, " dimension"]) -> "Trajectory":
        """Return the trajectory that stays at one value."""
        return cls(np.zeros(1), np.asarray(value, float)[None])

    def __call__(self, time: float) -> Float[Array, "3 dimension"]:
        """Return value, velocity and acceleration at a time [s], one row each; read only."""
        if time == self._asked:
            return self._rates
        inside = min(max(time, self._first), self._last)
        piece = max(bisect_right(self._starts, inside) - 1, 0)
        u = inside - self._starts[piece]
        rates = (self._factors * u**self._powers) @ self._c[piece]
        if inside != time:
            rates[1:] = 0.0
        rates.flags.writeable = False
        self._asked, self._rates = time, rates
        return rates
