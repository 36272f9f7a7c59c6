r"""A trajectory problem as one nonlinear program for the solvers that come with CasADi.

With :math:`x` all coefficients and all node unknowns that may move, everything a node sees is
linear in it, :math:`z_k = (q, \dot q, \ddot q, u)_k = T_k x + z_k^0`. A family of rows is one
function mapped over its nodes, so with the Jacobians :math:`J` and Hessians :math:`H` of all nodes
as blocks of a diagonal matrix

.. math:: \frac{\partial r}{\partial x} = J T, \qquad
    \nabla^2 L = T^\top \big( H(\lambda) + J^\top W J \big) T,
    \quad \lambda = y + g + w (r - \bar r):

two sparse products, and nothing but the rows is ever differentiated.

**Redundant equations.** A rigid sole that stands on four points has twelve equations of position
and six degrees of freedom. Solvers for equations want independent ones, so at every node the
equations that follow from the others are left out: the rank is that of their Jacobian by
:math:`z_k`, at a place moved a little at random so that no symmetric posture hides or feigns a
dependence. Linear equations are kept before others. What is left out still counts in
:meth:`Program.violation`.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse
from scipy.linalg import qr

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.synthesize.problem.nlp import ConstraintFamily, Problem

if TYPE_CHECKING:
    import casadi

_MOVED = 0.1  # how far from the guess ranks are looked at [rad, m, rad/s, m/s, …]
_RANK = 1e-7  # parts of a row smaller than this are rounding


@dataclass(frozen=True)
class Differentiated:
    """A node function with first and second derivatives.

    Attributes:
        value: (z, p) ↦ r.
        gradient: (z, p, lam) ↦ gradient of lam'r.
        jacobian: (z, p) ↦ dr/dz.
        hessian: (z, p, lam) ↦ upper triangle of the Hessian of lam'r, its diagonal halved.
        linear: Whether r is linear in z.
    """

    value: "casadi.Function"
    gradient: "casadi.Function"
    jacobian: "casadi.Function"
    hessian: "casadi.Function"
    linear: bool


_KEPT = 64
_differentiated: dict[Any, tuple[Any, Differentiated]] = {}


def differentiated(function: "casadi.Function") -> Differentiated:
    """Return a node function with its derivatives, which are made once in a process."""
    import casadi as ca

    key = hash(function)
    if key in _differentiated:
        return _differentiated[key][1]
    sizes = [function.size1_in(i) for i in range(5)]
    z, p = ca.SX.sym("z", sum(sizes[:4])), ca.SX.sym("p", sizes[4])
    r = ca.densify(function(*ca.vertsplit(z, np.cumsum([0, *sizes[:4]]).tolist()), p))
    lam = ca.SX.sym("lam", r.shape[0])
    J = ca.jacobian(r, z)
    gradient = ca.gradient(ca.dot(lam, r), z)
    H = ca.triu(ca.jacobian(gradient, z))
    H = H - ca.diag(ca.diag(H)) / 2
    made = Differentiated(
        ca.Function("value", [z, p], [r]),
        ca.Function("gradient", [z, p, lam], [gradient]),
        ca.Function("jacobian", [z, p], [J]),
        ca.Function("hessian", [z, p, lam], [H]),
        H.nnz() == 0,
    )
    if len(_differentiated) >= _KEPT:
        del _differentiated[next(iter(_differentiated))]
    _differentiated[key] = (function, made)  # the function is kept, so that its hash stays its own
    return made


@dataclass(frozen=True, eq=False)
class _Family:
    """Rows of one family that matter to a program.

    Attributes:
        rows: The family.
        made: Its function with derivatives.
        nodes: Nodes at which it has a limit or a cost.
        z: Places in all z that these nodes see, node after node.
        limited: Which of its rows (n_nodes n_rows, flat) are constraints, by index.
    """

    rows: ConstraintFamily
    made: Differentiated
    nodes: Int[Array, " n_nodes"]
    z: Int[Array, " n_z"]
    limited: Int[Array, " n_limited"]


class Program:
    """A :class:`Problem` as variables, objective and constraints.

    Attributes:
        problem: The problem.
        names: Names of the families that count.
        n_variables: Variables: coefficients, and unknowns that may move.
        n_fixed: Variables that an equation fixes by itself, as those of a first pose do; their
            bounds are equal.
        n_equations: Equations kept, besides those.
        n_inequalities: Rows with limits that are no equations.
        n_redundant: Equations left out because they follow from others.
        lower: Lower limits of the constraints.
        upper: Upper limits.
        bounds: Lower and upper bounds of the variables.

    Raises:
        ParameterError: If a name in ``rows`` is none of the problem's.
    """

    def __init__(
        self,
        problem: Problem,
        c0: Float[Array, "n_coefficients n_coordinates"],
        u0: Float[Array, "n_nodes n_unknowns"] | None = None,
        *,
        rows: Collection[str] | None = None,
        objective: bool = True,
    ):
        names = [r.name for r in problem.rows]
        missing = sorted(set(rows or ()) - set(names))
        if missing:
            raise ParameterError(f"no rows {missing[0]!r}; there are {', '.join(names)}")
        self.problem, self.objective = problem, objective
        self.names = tuple(n for n in names if rows is None or n in rows)
        self._nz = 3 * len(problem.names) + problem.n_unknowns
        self._T, self._z0 = _linear_map(problem)
        self._T: Any
        self.n_variables: int = self._T.shape[1]
        chosen = [r for r in problem.rows if rows is None or r.name in rows]
        kept = self._independent(chosen, self.pack(c0, u0))
        self.n_redundant = sum(int(r.equations.sum() - kept[r.name].sum()) for r in chosen)
        fixed = self._fixed(chosen, kept)
        self._families: list[_Family] = []
        for r in chosen:
            limited = r.inequalities | kept[r.name]
            costs = ((r.weight != 0) | (r.gain != 0)) & objective
            nodes = np.flatnonzero((limited | costs).any(axis=1))
            if len(nodes):
                z = (nodes[:, None] * self._nz + np.arange(self._nz)).ravel()
                flat = np.flatnonzero(limited[nodes])
                self._families.append(_Family(r, differentiated(r.function), nodes, z, flat))
        self.lower = self._limits("lower")
        self.upper = self._limits("upper")
        self.n_fixed = len(fixed)
        moving = np.ones(self.n_variables)
        moving[list(fixed)] = 0.0
        self._T_moving: Any = sparse.csr_matrix(self._T @ sparse.diags_array(moving))
        self._T_moving.eliminate_zeros()
        self.n_equations = int(np.sum(self.lower == self.upper))
        self.n_inequalities = len(self.lower) - self.n_equations
        free = problem.u_active
        n_c = self.n_variables - int(free.sum())
        self.bounds = (
            np.concatenate([np.full(n_c, -np.inf), problem.u_lower[free]]),
            np.concatenate([np.full(n_c, np.inf), problem.u_upper[free]]),
        )
        for i, value in fixed.items():
            self.bounds[0][i] = self.bounds[1][i] = value
        self._functions: dict[str, casadi.Function] = {}

    # Variables --------------------------------------------------------------------------------

    def pack(
        self,
        c: Float[Array, "n_coefficients n_coordinates"],
        u: Float[Array, "n_nodes n_unknowns"] | None = None,
    ) -> Float[Array, " n_variables"]:
        """Return the variables of coefficients and unknowns (zeros, if there are none given)."""
        shape = (self.problem.basis.n_coefficients, len(self.problem.names))
        if c.shape != shape:
            raise ParameterError(f"coefficients are {c.shape}; this problem has {shape}")
        if u is None:
            u = np.zeros((len(self.problem.nodes), self.problem.n_unknowns))
        if not (np.isfinite(c).all() and np.isfinite(u).all()):
            raise ParameterError("a guess must be finite")
        moving = u[self.problem.u_active] if self.problem.n_unknowns else np.zeros(0)
        return np.concatenate([c.ravel(), moving])

    def unpack(
        self, x: Float[Array, " n_variables"]
    ) -> tuple[Float[Array, "n_coefficients n_coordinates"], Float[Array, "n_nodes n_unknowns"]]:
        """Return coefficients and all unknowns, fixed ones included."""
        p = self.problem
        n_c = p.basis.n_coefficients * len(p.names)
        u = np.array(p.u_lower) if p.n_unknowns else np.zeros((len(p.nodes), 0))
        if p.n_unknowns:
            u[p.u_active] = x[n_c:]
        return np.array(x[:n_c]).reshape(-1, len(p.names)), u

    # Values -----------------------------------------------------------------------------------

    def values(self, x: Float[Array, " n_variables"]) -> dict[str, Float[Array, "n_nodes n_rows"]]:
        """Return every family of rows of the problem at every node."""
        z = (self._T @ x + self._z0).reshape(-1, self._nz)
        return {r.name: _mapped(differentiated(r.function).value, z, r) for r in self.problem.rows}

    def violation(self, x: Float[Array, " n_variables"]) -> tuple[float, str]:
        """Return by how much the worst row that counts is off its limits, and its words."""
        worst, words = 0.0, ""
        values = self.values(x)
        for r in self.problem.rows:
            if r.name not in self.names:
                continue
            v = values[r.name]
            off = np.maximum(np.maximum(r.lower - v, v - r.upper), 0.0)
            if off.size and not off.max() <= worst:  # NaN is the worst
                k, i = np.unravel_index(np.argmax(np.nan_to_num(off, nan=np.inf)), off.shape)
                worst = float(off[k, i])
                by = f"{worst * r.scale:.3g} {r.unit}" if r.unit else f"{worst:.3g}"
                words = f"{r.name} {r.names[i]} at {self.problem.nodes[k]:.3f} s by {by}"
        return worst, words

    # Functions for a solver -------------------------------------------------------------------

    def functions(self) -> dict[str, "casadi.Function"]:
        """Return ``f`` and ``g``, the gradient, the Jacobian and the Hessian of the Lagrangian.

        Names, inputs and outputs are those of CasADi's solvers: ``nlp_f``, ``nlp_g``,
        ``nlp_grad_f``, ``nlp_jac_g``, ``nlp_hess_l``; inputs are x and no parameters. Columns of
        variables that are fixed are left out of Jacobian and Hessian.
        """
        if self._functions:
            return self._functions
        import casadi as ca

        x, none = ca.MX.sym("x", self.n_variables), ca.MX.sym("p", 0)
        lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", len(self.lower))
        T = _constant(ca, self._T)
        z = ca.mtimes(T, x) + self._z0
        f, gradient, parts, jacobians = ca.MX(0), ca.MX(self.n_variables, 1), [], []
        all_z = len(self._z0)
        inner: Any = ca.MX(all_z, all_z)  # upper triangle of the Hessian by z, diagonal halved
        T_m = _constant(ca, self._T_moving)
        start = 0
        for family in self._families:
            n, r = len(family.nodes), family.rows
            m, T_f = len(r.names), _constant(ca, self._T[family.z])
            z_f, p_f = (
                ca.reshape(z[family.z.tolist()], self._nz, n),
                ca.DM(r.parameters[family.nodes].T),
            )
            value = ca.vec(family.made.value.map(n)(z_f, p_f))
            J = _blocks(ca, family.made.jacobian.map(n)(z_f, p_f), n)
            multiplier: Any = ca.MX.zeros(n * m)
            if len(family.limited):
                parts.append(value[family.limited.tolist()])
                T_j = _constant(ca, self._T_moving[family.z])
                jacobians.append(ca.mtimes(_rows(ca, J, family.limited), T_j))
                stop = start + len(family.limited)
                pick = sparse.csc_matrix(
                    (np.ones(stop - start), (family.limited, np.arange(stop - start))),
                    shape=(n * m, stop - start),
                )
                multiplier = ca.mtimes(_constant(ca, pick), lam_g[start:stop])
                start = stop
            weight, gain, target = (a[family.nodes].ravel() for a in (r.weight, r.gain, r.target))
            if self.objective and (np.any(weight) or np.any(gain)):
                off = value - target
                f = f + ca.dot(gain, value) + 0.5 * ca.dot(weight * off, off)
                slope = gain + weight * off
                down = family.made.gradient.map(n)(z_f, p_f, ca.reshape(slope, m, n))
                gradient = gradient + ca.mtimes(T_f.T, ca.vec(ca.densify(down)))
                multiplier = multiplier + lam_f * slope
                heavy = np.flatnonzero(weight)
                if len(heavy):
                    J_w = _rows(ca, J, heavy)
                    scaled = ca.mtimes(ca.diag(ca.DM(weight[heavy])), J_w)
                    square = ca.triu(ca.mtimes(J_w.T, scaled))
                    square = square - ca.diag(ca.diag(square)) / 2
                    inner = inner + _embedded(ca, lam_f * square, family.z, all_z)
            if not family.made.linear:
                H = family.made.hessian.map(n)(z_f, p_f, ca.reshape(multiplier, m, n))
                inner = inner + _embedded(ca, _blocks(ca, H, n), family.z, all_z)
        half = ca.mtimes(T_m.T, ca.mtimes(inner, T_m))
        hessian = ca.triu(half + half.T)
        if self.objective:
            D: Any
            D, d = _steps(self.problem, self._T, self._z0, self._nz)
            rough: Any = self.problem.roughness()
            rough.resize(rough.shape[0], D.shape[1])
            D = sparse.csr_matrix(sparse.vstack([D, rough]))
            d = np.concatenate([d, np.zeros(rough.shape[0])])
            if D.shape[0]:
                S = _constant(ca, D)
                off = ca.mtimes(S, x) + d
                f = f + 0.5 * ca.dot(off, off)
                gradient = gradient + ca.mtimes(S.T, off)
                hessian = hessian + lam_f * ca.triu(_constant(ca, D.T @ D))
        g = ca.vertcat(*parts) if parts else ca.MX(0, 1)
        jacobian = ca.vertcat(*jacobians) if jacobians else ca.MX(0, self.n_variables)
        gradient = ca.densify(gradient)
        inputs = [x, none], ["x", "p"]

        def hessian_of(matrix: Any):
            names = ["x", "p", "lam_f", "lam_g"], ["hess_gamma_x_x"]
            return [x, none, lam_f, lam_g], [matrix], *names

        made = {
            "nlp": ca.Function("nlp", [x, none], [f, g], ["x", "p"], ["f", "g"]),
            "nlp_f": ca.Function("nlp_f", inputs[0], [f], inputs[1], ["f"]),
            "nlp_g": ca.Function("nlp_g", inputs[0], [g], inputs[1], ["g"]),
            "nlp_grad_f": ca.Function(
                "nlp_grad_f", inputs[0], [f, gradient], inputs[1], ["f", "grad_f_x"]
            ),
            "nlp_jac_g": ca.Function(
                "nlp_jac_g", inputs[0], [g, jacobian], inputs[1], ["g", "jac_g_x"]
            ),
            "nlp_jac_fg": ca.Function(
                "nlp_jac_fg",
                inputs[0],
                [f, gradient.T, g, jacobian],
                inputs[1],
                ["f", "jac_f_x", "g", "jac_g_x"],
            ),
            "nlp_hess_l": ca.Function("nlp_hess_l", *hessian_of(hessian)),
            "nlp_hess_l_full": ca.Function("nlp_hess_l", *hessian_of(ca.triu2symm(hessian))),
        }
        self._functions = made
        return made

    # How it is made ---------------------------------------------------------------------------

    def _limits(self, which: str) -> Float[Array, " n_constraints"]:
        each = [getattr(f.rows, which)[f.nodes].ravel()[f.limited] for f in self._families]
        return np.concatenate(each) if each else np.zeros(0)

    def _fixed(
        self, chosen: Sequence[ConstraintFamily], kept: dict[str, Bool[Array, "n_nodes n_rows"]]
    ) -> dict[int, float]:
        """Return variables that linear equations fix one after the other; these are not kept."""
        waiting = []
        z = self._z0.reshape(-1, self._nz)
        for r in chosen:
            made = differentiated(r.function)
            if not (made.linear and kept[r.name].any()):
                continue
            value, J = _mapped(made.value, z, r), _mapped(made.jacobian, z, r)
            for k in np.flatnonzero(kept[r.name].any(axis=1)):
                rows = np.flatnonzero(kept[r.name][k])
                T = self._T[k * self._nz : (k + 1) * self._nz]
                A = sparse.csr_matrix(J[k][rows]) @ T
                for j, i in enumerate(rows):
                    part = slice(A.indptr[j], A.indptr[j + 1])
                    columns, entries = A.indices[part], A.data[part]
                    large = np.abs(entries) > _RANK * np.abs(entries).max(initial=0.0)
                    terms = dict(zip(columns[large].tolist(), entries[large].tolist(), strict=True))
                    waiting.append((r.name, k, i, terms, r.lower[k, i] - value[k, i]))
        fixed: dict[int, float] = {}
        found = True
        while found:
            found, later = False, []
            for name, k, i, terms, right in waiting:
                open_ = [c for c in terms if c not in fixed]
                if len(open_) != 1:
                    later.append((name, k, i, terms, right))
                    continue
                known = sum(terms[c] * fixed[c] for c in terms if c in fixed)
                fixed[open_[0]] = float((right - known) / terms[open_[0]])
                kept[name][k, i] = False
                found = True
            waiting = later
        return fixed

    def _independent(
        self, chosen: Sequence[ConstraintFamily], x: Float[Array, " n_variables"]
    ) -> dict[str, Bool[Array, "n_nodes n_rows"]]:
        """Return which equations of each family are kept."""
        z = (self._T @ x + self._z0).reshape(-1, self._nz)
        z = z + _MOVED * np.random.default_rng(0).standard_normal(z.shape)
        kept = {r.name: np.zeros(r.lower.shape, dtype=bool) for r in chosen}
        order = sorted(chosen, key=lambda r: not differentiated(r.function).linear)
        held = np.ones((len(z), self._nz), dtype=bool)  # parts of z that move with x
        if self.problem.n_unknowns:
            held[:, -self.problem.n_unknowns :] = self.problem.u_active
        jacobians = {
            r.name: _mapped(differentiated(r.function).jacobian, z, r)
            for r in order
            if r.equations.any()
        }
        for k in range(len(z)):
            space = np.zeros((self._nz, 0))  # orthonormal, spanned by the equations kept
            for r in order:
                rows = np.flatnonzero(r.equations[k])
                if not len(rows):
                    continue
                J = jacobians[r.name][k][rows] * held[k]
                size = np.linalg.norm(J, axis=1)
                J = J / np.maximum(size, 1e-300)[:, None]
                rest = J.T - space @ (space.T @ J.T)
                rest -= space @ (space.T @ rest)
                found: Any = qr(rest, mode="economic", pivoting=True)
                Q, R, pivots = found
                rank = int(np.sum(np.abs(np.diag(R)) > _RANK)) if R.size else 0
                kept[r.name][k, rows[pivots[:rank]]] = True
                space = np.hstack([space, Q[:, :rank]])
        return kept


def _mapped(function: "casadi.Function", z: Array, rows: ConstraintFamily) -> Array:
    """Return a node function at all nodes, nodes along the first axis."""
    n = len(z)
    out = function.map(n)(z.T, rows.parameters.T).full()
    split = np.stack(np.hsplit(out, n))
    return split[..., 0] if function.size2_out(0) == 1 else split


def _linear_map(problem: Problem) -> tuple[Any, Float[Array, " n"]]:
    """Return T and z0: what all nodes see, node after node, is T x + z0."""
    nv, n_u, n = len(problem.names), problem.n_unknowns, len(problem.nodes)
    nz, n_c = 3 * nv + n_u, problem.basis.n_coefficients
    rows, columns, values, z0 = [], [], [], np.zeros(n * nz)
    every = np.arange(nv)
    for derivative in range(3):
        band = problem.basis.band(problem.nodes, derivative)
        for k in range(n):
            at = k * nz + derivative * nv + every
            z0[at] += problem.drift(problem.nodes[k : k + 1], derivative)[0]
            for i, value in enumerate(band.values[k]):
                lap, index = divmod(int(band.first[k]) + i, n_c)
                if lap == 0 or problem.closure is None:
                    source, sign = every, np.ones(nv)
                else:
                    source, sign = problem.closure.source, problem.closure.sign
                rows.append(at)
                columns.append(index * nv + source)
                values.append(value * sign)
    if n_u:
        active = problem.u_active
        k, i = np.nonzero(active)
        rows.append(k * nz + 3 * nv + i)
        columns.append(n_c * nv + np.arange(len(k)))
        values.append(np.ones(len(k)))
        k, i = np.nonzero(~active)
        z0[k * nz + 3 * nv + i] = problem.u_lower[~active]
    n_x = n_c * nv + (int(problem.u_active.sum()) if n_u else 0)
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(entries, shape=(n * nz, n_x)), z0


def _steps(problem: Problem, T: Any, z0: Array, nz: int) -> tuple[Any, Float[Array, " n"]]:
    """Return D and d: the steps of node unknowns, by the roots of their weights, are D x + d."""
    n, n_u = len(problem.nodes), problem.n_unknowns
    if not n_u or not problem.u_smooth.size:
        return sparse.csr_matrix((0, T.shape[1])), np.zeros(0)
    place = np.arange(n)[:, None] * nz + 3 * len(problem.names) + np.arange(n_u)
    first, second, sign = place[:-1], place[1:], np.ones((n - 1, n_u))
    if problem.closure is not None and len(problem.u_smooth) == n:
        k = problem.closure
        first, second = place, np.vstack([second, place[0][k.u_source]])
        sign = np.vstack([sign, k.u_sign])
    root, sign = np.sqrt(problem.u_smooth).ravel(), sign.ravel()
    used = root > 0
    first, second, root, sign = first.ravel()[used], second.ravel()[used], root[used], sign[used]
    scale, sign = sparse.diags_array(root), sparse.diags_array(sign)
    D = sparse.csr_matrix(scale @ (sign @ T[second] - T[first]))
    return D, root * (sign @ z0[second] - z0[first])


def _constant(ca: Any, matrix: Any):
    compressed = sparse.csc_matrix(matrix)
    compressed.sum_duplicates()
    return ca.DM(compressed)


def _blocks(ca: Any, side_by_side: Any, n: int):
    """Return matrices that stand side by side as the blocks of a diagonal matrix."""
    width = side_by_side.shape[1] // n
    one = side_by_side[:, :width].sparsity()
    entries = ca.reshape(side_by_side.nz[:], side_by_side.nnz(), 1)
    return ca.MX(ca.diagcat(*([one] * n)), entries)


def _embedded(ca: Any, matrix: Any, places: Array, size: int):
    """Return a matrix as part of a larger one, its rows and columns at ``places``, in order."""
    rows, columns = (np.array(each) for each in matrix.sparsity().get_triplet())
    pattern = ca.Sparsity.triplet(size, size, places[rows].tolist(), places[columns].tolist())
    return ca.MX(pattern, ca.reshape(matrix.nz[:], matrix.nnz(), 1))


def _rows(ca: Any, matrix: Any, index: Array):
    """Return rows of a sparse matrix."""
    if len(index) == matrix.shape[0]:
        return matrix
    n = len(index)
    pick = sparse.csc_matrix((np.ones(n), (np.arange(n), index)), shape=(n, matrix.shape[0]))
    return ca.mtimes(_constant(ca, pick), matrix)
