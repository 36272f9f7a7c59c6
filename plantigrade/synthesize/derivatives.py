r"""First and second derivatives of rows at all nodes, as dense arrays.

A function of a node is :math:`r(q, \dot q, \ddot q, u, p)`; with
:math:`z = (q, \dot q, \ddot q, u)` a solver asks for :math:`r`, :math:`\partial r / \partial z`
and :math:`\nabla_z^2 (\lambda^\top r)`. The last is the Jacobian of the gradient
:math:`(\partial r / \partial z)^\top \lambda`, whose lower triangle is enough.
"""

from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.dynamics.compiled import Batched
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi


class Derivatives:
    """A function of a node with its derivatives, evaluated at all nodes at once.

    Attributes:
        function: CasADi function of columns (q, qd, qdd, u, p) ↦ rows (n_rows,).
        n_rows: Rows of the function, m.
        n_arguments: Length of z = (q, qd, qdd, u), nz.
        jacobian_pattern: Rows and columns that can be other than zero in dr/dz.
        hessian_pattern: The same for the Hessian, both triangles.

    Raises:
        ParameterError: If the function is not one of five dense columns with one column.
    """

    def __init__(self, function: "casadi.Function"):
        import casadi as ca

        if function.n_in() != 5 or function.n_out() != 1 or function.size2_out(0) != 1:
            raise ParameterError(
                f"{function.name()!r} must give one column from (q, qd, qdd, u, p); it has "
                f"{function.n_in()} inputs and {function.n_out()} outputs"
            )
        self.function = function
        self.n_rows: int = function.size1_out(0)
        sizes = [function.size1_in(i) for i in range(5)]
        self.n_arguments: int = sum(sizes[:4])
        symbols = [ca.SX.sym(function.name_in(i), n) for i, n in enumerate(sizes)]
        z, lam = ca.vertcat(*symbols[:4]), ca.SX.sym("lam", self.n_rows)
        r = ca.densify(function(*symbols))
        gradient = ca.gradient(ca.dot(lam, r), z)
        self._values = Batched(ca.Function("values", symbols, [r]))
        self._jacobian = Batched(ca.Function("jacobian", symbols, [r, ca.jacobian(r, z)]))
        lower = ca.tril(ca.jacobian(gradient, z))
        self._hessian = Batched(ca.Function("hessian", [lam, *symbols], [lower]))

        nz = self.n_arguments
        every = np.arange(self.n_rows)
        rows, columns = self.jacobian_pattern = self._jacobian.pattern(1)
        self._jacobian_places = (every, every), (np.arange(len(rows)), rows * nz + columns)
        i, j = self._hessian.pattern(0)
        off = np.flatnonzero(i != j)
        source = np.concatenate([np.arange(len(i)), off])
        self.hessian_pattern: tuple[Int[Array, " nnz"], Int[Array, " nnz"]] = (
            np.concatenate([i, j[off]]),
            np.concatenate([j, i[off]]),
        )
        self._hessian_places = ((source, self.hessian_pattern[0] * nz + self.hessian_pattern[1]),)
        self._kept: dict[tuple[str, int], Array] = {}

    def values(
        self,
        q: Float[Array, "n_nodes nv"],
        v: Float[Array, "n_nodes nv"],
        a: Float[Array, "n_nodes nv"],
        u: Float[Array, "n_nodes n_unknowns"],
        p: Float[Array, "n_nodes n_parameters"],
    ) -> Float[Array, "n_nodes n_rows"]:
        """Return the rows."""
        return self._values(q, v, a, u, p)[0]

    def jacobian(
        self,
        q: Float[Array, "n_nodes nv"],
        v: Float[Array, "n_nodes nv"],
        a: Float[Array, "n_nodes nv"],
        u: Float[Array, "n_nodes n_unknowns"],
        p: Float[Array, "n_nodes n_parameters"],
    ) -> tuple[Float[Array, "n_nodes n_rows"], Float[Array, "n_nodes n_rows nz"]]:
        """Return the rows and dr/dz; the latter's array is filled anew by the next call."""
        r = np.empty((len(q), self.n_rows))
        J = self._keep("jacobian", (len(q), self.n_rows, self.n_arguments))
        self._jacobian.scatter((q, v, a, u, p), (r, J), self._jacobian_places)
        return r, J

    def hessian(
        self,
        lam: Float[Array, "n_nodes n_rows"],
        q: Float[Array, "n_nodes nv"],
        v: Float[Array, "n_nodes nv"],
        a: Float[Array, "n_nodes nv"],
        u: Float[Array, "n_nodes n_unknowns"],
        p: Float[Array, "n_nodes n_parameters"],
    ) -> Float[Array, "n_nodes nz nz"]:
        """Return the Hessian of lam'r, symmetric; its array is filled anew by the next call."""
        H = self._keep("hessian", (len(q), self.n_arguments, self.n_arguments))
        self._hessian.scatter((lam, q, v, a, u, p), (H,), self._hessian_places)
        return H

    def _keep(self, name: str, shape: tuple[int, ...]) -> Array:
        """Return the array of zeros that is filled at every call with this many nodes."""
        if (name, shape[0]) not in self._kept:
            self._kept[name, shape[0]] = np.zeros(shape)
        return self._kept[name, shape[0]]
