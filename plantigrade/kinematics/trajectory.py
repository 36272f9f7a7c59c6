"""A smooth vector function of time: value, velocity and acceleration."""

from bisect import bisect_right
from math import factorial

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

__all__ = ["Trajectory"]


class Trajectory:
    """A quintic spline through samples (of lower degree through few); one sample stays where it is.

    Beyond its ends it stays where it ended.

    Args:
        time: Time of each sample [s], increasing.
        values: The samples.
    """

    def __init__(self, time: Float[Array, " n"], values: Float[Array, "n dimension"]):
        from scipy.interpolate import make_interp_spline

        time, values = np.asarray(time, float), np.asarray(values, float)
        if len(time) != len(values) or not len(time):
            raise ParameterError(f"{len(time)} times for {len(values)} samples of a trajectory")
        if not np.isfinite(values).all() or not (np.diff(time) > 0).all():
            raise ParameterError("a trajectory needs finite samples at increasing times")
        self._first, self._last = float(time[0]), float(time[-1])
        degree = 5 if len(time) > 5 else 3 if len(time) > 3 else min(1, len(time) - 1)
        spline = make_interp_spline(time, values, k=degree) if degree else None
        starts = time[:1] if spline is None else np.unique(spline.t)[:-1]
        # For each piece, lowest power first: coefficients of value, velocity and acceleration side
        # by side, so that one row of powers gives all three.
        c = np.zeros((len(starts), degree + 1, 3, values.shape[1]))
        if spline is None:
            c[0, 0, 0] = values[0]
        else:
            for power, order in np.ndindex(degree + 1, 3):
                if power + order <= degree:
                    c[:, power, order] = spline(starts, nu=power + order) / factorial(power)
        self._starts, self._c = starts.tolist(), c.reshape(*c.shape[:2], -1)
        self._powers = np.arange(degree + 1.0)
        self._asked, self._rates = np.nan, np.zeros((3, values.shape[1]))

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
        rates = (u**self._powers @ self._c[piece]).reshape(3, -1)
        if inside != time:
            rates[1:] = 0.0
        rates.flags.writeable = False
        self._asked, self._rates = time, rates
        return rates
