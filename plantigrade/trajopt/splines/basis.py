r"""A spline basis: collocation matrices of its functions and their derivatives.

A coordinate :math:`q` is a sum of basis functions :math:`N_l` of degree :math:`\gamma` with
coefficients :math:`c_l`,

.. math:: q(t) = \sum_{l=0}^{n-1} N_l(t)\, c_l, \quad
    \dot q(t) = \sum_l \dot N_l(t)\, c_l, \quad \ddot q(t) = \sum_l \ddot N_l(t)\, c_l,

(Eq. 4 of [Zhakatayev2023]_, whose text writes :math:`N` and :math:`\dot N` for
:math:`\dot N` and :math:`\ddot N`). At any time :math:`\gamma + 1` consecutive functions are
non-zero, so the collocation matrix, which maps coefficients to samples, has that many entries per
row.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.trajopt.splines.knots import TIME_TOLERANCE, require_knots

Side = Literal["left", "right"]
MAX_CACHED = 64  # [1] maximum number of matrices cached by a basis


@dataclass(frozen=True, eq=False)
class BandedMatrix:
    """The non-zero entries of a collocation matrix, row by row."""

    values: Float[Array, "n_times order"]  #: Entries, the leftmost function first [1/s^derivative]
    #: Coefficient of the first entry of each row; the others follow it, wrapping round if the basis
    #: is periodic
    first: Int[Array, " n_times"]
    n_coefficients: int  #: Number of columns

    @property
    def columns(self) -> Int[Array, "n_times order"]:
        """Coefficient of each entry."""
        order = np.arange(self.values.shape[1])
        return (self.first[:, None] + order) % self.n_coefficients

    @cached_property
    def matrix(self) -> sparse.csr_array:
        """The matrix, ``(n_times, n_coefficients)``, with sorted indices, read-only."""
        n_times, order = self.values.shape
        starts = np.arange(0, (n_times + 1) * order, order)
        entries = (self.values.ravel(), self.columns.ravel(), starts)
        matrix = sparse.csr_array(entries, shape=(n_times, self.n_coefficients), copy=True)
        matrix.sort_indices()
        for part in (matrix.data, matrix.indices, matrix.indptr):
            part.flags.writeable = False
        return matrix


class Basis(ABC):
    r"""Spline basis on a knot vector; subclasses evaluate its functions.

    Two bases of one kind on the same knots are equal. Matrices are computed once for each set of
    times and cached; they are shared and read-only.

    Attributes:
        degree: Degree :math:`\gamma`; order less one.
        knots: Knots :math:`t_0 \le \dots \le t_{n + \gamma}` [s], read-only.
        periodic: Whether the spline repeats after ``span``; its coefficients then wrap round.
    """

    def __init__(self, degree: int, knots: Float[Array, " n_knots"], *, periodic: bool = False):
        require_knots(knots, degree, periodic=periodic)
        self.degree, self.periodic = int(degree), periodic
        self.knots = np.array(knots, dtype=float)
        self.knots.flags.writeable = False
        self._bands: dict[tuple[bytes, int, Side], BandedMatrix] = {}

    @abstractmethod
    def evaluate(
        self, times: Float[Array, " n_times"], derivative: int, side: Side
    ) -> tuple[Float[Array, "n_times order"], Int[Array, " n_times"]]:
        """Return the non-zero functions at times within the span, and the index of the first.

        At a knot they are those of a side, at ``start`` and ``stop`` of the inner one. Values are
        in 1/s^derivative; indices are among all ``len(knots) - degree - 1``, before wrapping.
        """

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients of one coordinate."""
        return len(self.knots) - self.degree - 1 - self.degree * self.periodic

    @property
    def start(self) -> float:
        """Start of the interval on which the spline is defined [s]."""
        return float(self.knots[self.degree])

    @property
    def stop(self) -> float:
        """End of that interval [s]; one period after the start if the basis is periodic."""
        return float(self.knots[len(self.knots) - self.degree - 1])

    @property
    def span(self) -> float:
        """Length of that interval [s]."""
        return self.stop - self.start

    @property
    def breaks(self) -> Float[Array, " n_breaks"]:
        """Breakpoints: distinct knots from start to stop [s]."""
        knots = np.unique(self.knots)
        return knots[(knots >= self.start) & (knots <= self.stop)]

    def band(
        self, times: Float[Array, " n_times"], derivative: int = 0, *, side: Side = "right"
    ) -> BandedMatrix:
        """Return the non-zero entries of :meth:`matrix`, which explains the arguments."""
        key = (np.asarray(times, dtype=float).tobytes(), int(derivative), side)
        if key not in self._bands:
            if derivative != int(derivative) or derivative < 0:
                raise ParameterError(f"{derivative=} must be a whole number, 0 or more")
            if side not in ("left", "right"):
                raise ParameterError(f"{side=} must be 'left' or 'right'")
            inside = self._within(np.asarray(times, dtype=float), side)
            values, first = self.evaluate(inside, int(derivative), side)
            if self.periodic:
                first = first % self.n_coefficients
            values.flags.writeable = first.flags.writeable = False
            if len(self._bands) >= MAX_CACHED:  # the oldest goes
                del self._bands[next(iter(self._bands))]
            self._bands[key] = BandedMatrix(values, first, self.n_coefficients)
        return self._bands[key]

    def matrix(
        self, times: Float[Array, " n_times"], derivative: int = 0, *, side: Side = "right"
    ) -> sparse.csr_array:
        r"""Return the collocation matrix :math:`B_{jl} = N_l^{(d)}(t_j)`.

        Every row stores ``degree + 1`` entries, zeros included, so that sparsity patterns do not
        depend on values.

        Args:
            times: Times :math:`t_j` [s]; unrestricted if the basis is periodic.
            derivative: Order :math:`d` of the derivative by time.
            side: Side from which a knot is approached: derivatives jump there from order
                ``degree + 1 - multiplicity`` on. The last time is always approached from the left,
                the first from the right.

        Returns:
            ``(n_times, n_coefficients)`` [1/s^derivative], read-only.

        Raises:
            ParameterError: If a time lies outside the span or the derivative is not a whole number.
        """
        return self.band(times, derivative, side=side).matrix

    def fit(
        self,
        times: Float[Array, " n_times"],
        values: Float[Array, "n_times ..."],
        *,
        smoothing: float = 0.0,
    ) -> Float[Array, "n_coefficients ..."]:
        r"""Return the coefficients that fit samples best, by least squares.

        .. math:: \min_c \; \sum_j \left(q(t_j) - q_j\right)^2 + \lambda \int \ddot q(t)^2 \, dt

        Args:
            times: Sample times :math:`t_j` [s].
            values: Samples :math:`q_j`, coordinates along the later axes.
            smoothing: Weight :math:`\lambda` [s^3]; a small one determines coefficients that the
                samples do not.
        """
        if len(values) != len(times) or not np.isfinite(values).all():
            raise ParameterError(
                f"{len(values)} samples at {len(times)} times: give one each, all finite"
            )
        if not smoothing >= 0:
            raise ParameterError(f"{smoothing=} [s^3] must not be negative")
        rows = self.matrix(times).toarray()
        targets = values.reshape(len(values), -1)
        if smoothing:
            nodes, weights = self._quadrature()
            bent = np.sqrt(smoothing * weights)[:, None] * self.matrix(nodes, 2).toarray()
            rows = np.vstack([rows, bent])
            targets = np.vstack([targets, np.zeros((len(bent), targets.shape[1]))])
        coefficients, _, rank, _ = np.linalg.lstsq(rows, targets)
        if rank < self.n_coefficients:
            raise ParameterError(
                f"{len(times)} samples settle {rank} of {self.n_coefficients} coefficients: "
                "give more samples, fewer knots, or smoothing > 0"
            )
        return coefficients.reshape(-1, *values.shape[1:])

    def unity(self) -> Float[Array, " n_coefficients"]:
        """Return the coefficients of the constant 1, or of its best approximation."""
        times, _ = self._quadrature()
        return self.fit(times, np.ones(len(times)))

    def __eq__(self, other: object) -> bool:
        """Two bases are equal if they are of one kind, on the same knots."""
        return isinstance(other, Basis) and self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def __repr__(self) -> str:
        kind = "periodic, " if self.periodic else ""
        return (
            f"{type(self).__name__}(degree {self.degree}, {kind}"
            f"{self.n_coefficients} coefficients, {self.start:g} to {self.stop:g} s)"
        )

    def _identity(self) -> tuple[Hashable, ...]:
        return (type(self), self.degree, self.periodic, self.knots.tobytes())

    def _within(self, times: Float[Array, " n_times"], side: Side) -> Float[Array, " n_times"]:
        """Return times wrapped or clipped to the span; raise where they lie outside."""
        if times.ndim != 1 or not np.isfinite(times).all():
            raise ParameterError("times must be in one row, all of them finite [s]")
        if self.periodic:
            if side == "right":
                return self.start + np.mod(times - self.start, self.span)
            return self.stop - np.mod(self.stop - times, self.span)
        slack = TIME_TOLERANCE * self.span
        outside = times[(times < self.start - slack) | (times > self.stop + slack)]
        if len(outside):
            raise ParameterError(
                f"time {outside[0]:g} s lies outside the spline, which is for {self.start:g} to "
                f"{self.stop:g} s"
            )
        return np.clip(times, self.start, self.stop)

    def _quadrature(self) -> tuple[Float[Array, " n_times"], Float[Array, " n_times"]]:
        """Return Gauss points of every piece and their weights, both [s]."""
        points, weights = np.polynomial.legendre.leggauss(self.degree + 4)
        half = np.diff(self.breaks)[:, None] / 2
        middle = self.breaks[:-1, None] + half
        return (middle + half * points).ravel(), (half * weights).ravel()
