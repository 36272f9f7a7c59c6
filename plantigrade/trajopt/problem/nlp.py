r"""A trajectory optimisation problem as arrays: constraints at nodes, their limits and costs.

Coordinates are a spline with coefficients :math:`c`; at every node :math:`t_k` they give
:math:`q, \dot q, \ddot q`, and unknowns :math:`u_k` (contact forces) belong to the node alone. A
:class:`~plantigrade.trajopt.problem.constraint_family.ConstraintFamily` is one function of
these, evaluated at every node alike; arrays hold the limits and costs of every row at every node:

.. math:: \min_{c, u} \sum_k \sum_r g_{kr} r_{kr} + \tfrac12 w_{kr} (r_{kr} - \bar r_{kr})^2
    + \tfrac12 \sum_k \sigma_k \lVert u_{k+1} - u_k \rVert^2
    \quad \text{with} \quad l_{kr} \le r_{kr} \le h_{kr}.

The exact Hessian of everything is :math:`\nabla^2 (\lambda^\top r) + J^\top W J` with
:math:`\lambda = y + g + w (r - \bar r)`: no function but the rows themselves is differentiated.
Because a spline has local support, node :math:`k` touches few coefficients, and every matrix of
the problem is banded (Eqs. 4 and 9 to 14 of [Zhakatayev2023]_).
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.splines.basis import Basis


@dataclass(frozen=True, eq=False)
class PeriodicClosure:
    """Periodic boundary condition: the next half-stride is the first, mirrored and translated.

    Coefficient ``n_coefficients + i`` of coordinate ``j`` is ``sign[j]`` times coefficient ``i`` of
    coordinate ``source[j]``. The translation is not part of the spline (trigonometric splines of
    odd degree cannot represent constants): it is added at a constant rate. Node unknowns continue
    in the same way. Without mirroring, the same class describes a full stride.
    """

    source: Int[Array, " n_coordinates"]  #: Coordinate that continues each one (n_coordinates,)
    sign: Float[Array, " n_coordinates"]  #: 1 or -1 (n_coordinates,)
    #: Translation in one period (n_coordinates,) [rad, m]; unchanged by mirroring, so that
    #: velocities are continuous
    shift: Float[Array, " n_coordinates"]
    u_source: Int[Array, " n_unknowns"]  #: As ``source``, for node unknowns (n_unknowns,)
    u_sign: Float[Array, " n_unknowns"]  #: 1 or -1 (n_unknowns,)


@dataclass(frozen=True, eq=False)
class Problem:
    """A trajectory optimisation problem, as solvers take it."""

    basis: Basis  #: The spline basis; periodic if there is a ``closure``
    nodes: Float[Array, " n_nodes"]  #: Times of the nodes [s]
    names: tuple[str, ...]  #: Names of the coordinates
    rows: tuple[ConstraintFamily, ...]  #: Constraints and costs
    u_names: tuple[str, ...] = ()  #: Names of the node unknowns
    #: Their lower limits (n_nodes, n_unknowns)
    u_lower: Float[Array, "n_nodes n_unknowns"] = field(default_factory=lambda: np.zeros((0, 0)))
    #: Their upper limits; where equal, the unknown is fixed there
    u_upper: Float[Array, "n_nodes n_unknowns"] = field(default_factory=lambda: np.zeros((0, 0)))
    #: Weight of the squared step of each unknown from a node to the next (n_nodes - 1, n_unknowns);
    #: (n_nodes, n_unknowns) with a closure
    u_smooth: Float[Array, "n_steps n_unknowns"] = field(default_factory=lambda: np.zeros((0, 0)))
    #: Periodic boundary condition; None for a motion that ends
    closure: PeriodicClosure | None = None
    #: Weight of the squared third derivative of each coordinate, integrated over time, which keeps
    #: the spline smooth between nodes (n_coordinates,); empty for none
    jerk: Float[Array, " n_coordinates"] = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self):
        n, names = len(self.nodes), {r.name for r in self.rows}
        if len(names) != len(self.rows):
            raise ParameterError("two families of rows have the same name")
        for r in self.rows:
            expected = (n, len(r.names))
            for what in ("lower", "upper", "weight", "target", "gain"):
                given = getattr(r, what).shape
                if given != expected:
                    raise ParameterError(
                        f"{what} of {r.name!r} is {given}; {n} nodes and {len(r.names)} rows need "
                        f"{expected}"
                    )
            self._check_order(r.names, r.lower, r.upper)
        if self.u_names:
            steps = n - (self.closure is None)
            for what, many in (("u_lower", n), ("u_upper", n), ("u_smooth", steps)):
                given, expected = getattr(self, what), (many, self.n_unknowns)
                if given.shape != expected and (what != "u_smooth" or given.size):
                    raise ParameterError(
                        f"{what} is {given.shape}; {n} nodes and {self.n_unknowns} unknowns need "
                        f"{expected}"
                    )
            self._check_order(self.u_names, self.u_lower, self.u_upper)
        if (self.closure is not None) != self.basis.periodic:
            raise ParameterError("a closure needs a periodic basis, and a periodic basis a closure")

    def _check_order(self, names: tuple[str, ...], lower: Array, upper: Array) -> None:
        """Refuse limits that leave no room."""
        if np.any(lower > upper):
            k, i = np.argwhere(lower > upper)[0]
            raise ParameterError(
                f"{names[i]} at {self.nodes[k]:.3f} s must be at least {lower[k, i]:g} and at most "
                f"{upper[k, i]:g}"
            )

    @property
    def n_unknowns(self) -> int:
        """Unknowns at each node, fixed ones included."""
        return len(self.u_names)

    @cached_property
    def u_active(self) -> Bool[Array, "n_nodes n_unknowns"]:
        """Which unknowns may move."""
        return self.u_lower < self.u_upper

    def part(self, rows: Collection[str] | None = None, *, costs: bool = True) -> "Problem":
        """Return the problem with the families of these names only, or without costs.

        Raises:
            ParameterError: If a name is not that of a family.
        """
        names = [r.name for r in self.rows]
        missing = sorted(set(rows or ()) - set(names))
        if missing:
            raise ParameterError(f"no rows {missing[0]!r}; there are {', '.join(names)}")
        chosen = tuple(r for r in self.rows if rows is None or r.name in rows)
        if costs:
            return replace(self, rows=chosen)
        chosen = tuple(replace(r, weight=0 * r.weight, gain=0 * r.gain, parts=()) for r in chosen)
        return replace(self, rows=chosen, u_smooth=0 * self.u_smooth, jerk=0 * self.jerk)

    def roughness(self) -> sparse.csr_matrix:
        r"""Return D with :math:`\tfrac12 \lVert D\, c \rVert^2` the cost of jerk.

        Coefficients are in rows of ``c``, one row after the other. The third derivative is taken
        in the middle of every piece; it is nearly constant there.
        """
        nv, n_c = len(self.names), self.basis.n_coefficients
        if not self.jerk.size:
            return sparse.csr_matrix((0, n_c * nv))
        breaks = self.basis.breaks
        band = self.basis.band((breaks[1:] + breaks[:-1]) / 2, 3)
        index = band.first[:, None] + np.arange(band.values.shape[1])
        lap, index = np.divmod(index, n_c) if self.closure is not None else (0 * index, index)
        root = np.sqrt(np.diff(breaks)[:, None] * self.jerk)  # (n_pieces, nv)
        every, k = np.arange(nv), self.closure
        source, sign = (every, np.ones(nv)) if k is None else (k.source, k.sign)
        turned = lap[:, :, None] > 0
        columns = index[:, :, None] * nv + np.where(turned, source, every)
        values = band.values[:, :, None] * root[:, None, :] * np.where(turned, sign, 1.0)
        rows = np.arange(len(root))[:, None, None] * nv + every
        rows = np.broadcast_to(rows, columns.shape)
        entries = values.ravel(), (rows.ravel(), columns.ravel())
        return sparse.csr_matrix(entries, shape=(len(root) * nv, n_c * nv))

    def states(
        self, c: Float[Array, "n_coefficients n_coordinates"], times: Float[Array, " n_times"]
    ) -> tuple[
        Float[Array, "n_times n_coordinates"],
        Float[Array, "n_times n_coordinates"],
        Float[Array, "n_times n_coordinates"],
    ]:
        """Return q, qd and qdd of coefficients at any times."""
        out = []
        for derivative in range(3):
            band = self.basis.band(times, derivative)
            columns = band.first[:, None] + np.arange(band.values.shape[1])
            drift = self.drift(times, derivative)
            out.append(np.einsum("ij,ijk->ik", band.values, self.continued(c, columns)) + drift)
        return out[0], out[1], out[2]

    def drift(
        self, times: Float[Array, " n_times"], derivative: int = 0
    ) -> Float[Array, "n_times n_coordinates"]:
        """Return what the closure adds to the spline at times: its shift at a constant rate."""
        out = np.zeros((len(times), len(self.names)))
        if self.closure is not None and derivative < 2:
            rate = self.closure.shift / self.basis.span
            out += rate if derivative else np.outer(times - self.basis.start, rate)
        return out

    def continued(
        self, c: Float[Array, "n_coefficients n_coordinates"], index: Int[Array, "..."]
    ) -> Float[Array, "... n_coordinates"]:
        """Return coefficients by index, those after the last by the closure."""
        if self.closure is None:
            return c[index]
        lap, i = np.divmod(index, len(c))
        k = self.closure
        once = k.sign * c[:, k.source]
        return np.where((lap > 0)[..., None], once[i], c[i])
