"""Polynomial B-splines."""

import numpy as np
from scipy.interpolate import BSpline

from plantigrade.arrays import Array, Float, Int
from plantigrade.trajopt.splines.basis import Basis, Side


class PolynomialBasis(Basis):
    r"""Polynomial B-splines, on :meth:`scipy.interpolate.BSpline.design_matrix`.

    Functions are positive inside their support, sum to one, and reproduce polynomials up to the
    degree. Derivatives are analytic,

    .. math:: \dot N_{l,\gamma} = \gamma \left( \frac{N_{l,\gamma-1}}{t_{l+\gamma} - t_l}
        - \frac{N_{l+1,\gamma-1}}{t_{l+\gamma+1} - t_{l+1}} \right),

    applied again for higher ones, and zero past the degree ([deBoor1978]_).
    """

    def evaluate(
        self, times: Float[Array, " n_times"], derivative: int, side: Side
    ) -> tuple[Float[Array, "n_times order"], Int[Array, " n_times"]]:
        """Return the non-zero functions and the first of them, see :meth:`Basis.evaluate`."""
        if side == "left":  # SciPy looks from the right: turn time round
            values, last = self._from_right(-times, -self.knots[::-1], derivative)
            n_functions = len(self.knots) - self.degree - 1
            first = n_functions - 1 - self.degree - last
            return (-1.0) ** derivative * values[:, ::-1], first
        return self._from_right(times, self.knots, derivative)

    def unity(self) -> Float[Array, " n_coefficients"]:
        """Return the coefficients of the constant 1, which are ones."""
        return np.ones(self.n_coefficients)

    def _from_right(
        self, times: Float[Array, " n_times"], knots: Float[Array, " n_knots"], derivative: int
    ) -> tuple[Float[Array, "n_times order"], Int[Array, " n_times"]]:
        """Return values seen from the right, and the first function, on the knots given."""
        if not len(times):  # SciPy wants one
            return np.zeros((0, self.degree + 1)), np.zeros(0, dtype=np.int64)
        dropped = min(derivative, self.degree)
        lowest = self.degree - dropped
        inner = knots[dropped : len(knots) - dropped]  # the functions lost are zero on the span
        table = BSpline.design_matrix(times, inner, lowest)
        values = table.data.reshape(len(times), lowest + 1)
        first = table.indices.reshape(len(times), lowest + 1)[:, 0].astype(np.int64)
        if derivative > self.degree:
            return np.zeros((len(times), self.degree + 1)), first
        for degree in range(lowest + 1, self.degree + 1):
            # function l of the lower degree starts at knot l; the first of a row, one after `first`
            left = first[:, None] + np.arange(1, degree + 1) + (self.degree - degree)
            slope = degree * values / (knots[left + degree] - knots[left])
            values = np.zeros((len(times), degree + 1))
            values[:, 1:] += slope
            values[:, :-1] -= slope
        return values, first
