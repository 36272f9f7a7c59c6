r"""First and second derivatives of rows at all nodes, as dense arrays.

A function of a node is :math:`r(q, \dot q, \ddot q, u, p)`; with
:math:`z = (q, \dot q, \ddot q, u)` a solver asks for :math:`r`, :math:`\partial r / \partial z`
and :math:`\nabla_z^2 (\lambda^\top r)`. The last is the Jacobian of the gradient
:math:`(\partial r / \partial z)^\top \lambda`, whose lower triangle is enough.
"""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.batched import BatchedFunction
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi

_MAX_INTERPRETED = 300  # [1] maximum number of operations of an interpreted function
_VERSION = 1  # version of the derivatives below, to be increased with every change

States = Float[Array, "n_nodes nv"]
Given = Float[Array, "n_nodes _"]  # unknowns and parameters
Rows = Float[Array, "n_nodes n_rows"]
Jacobian = Float[Array, "n_nodes n_rows nz"]


class NodeDerivatives:
    """A function of a node with its derivatives, evaluated at all nodes at once.

    Derivatives are made when first needed: for a function of some thousand operations that takes a
    few seconds, or a tenth of one if they are found on disk. A function that differs in its numbers
    only, like that of a person of another height, finds them there.

    Args:
        backend: ``"vectors"`` or ``"interpreter"``; by default vectors where they are available
            (:mod:`plantigrade.batched`), and the interpreter for small functions.

    Attributes:
        function: CasADi function of columns (q, qd, qdd, u, p) ↦ rows (n_rows,).
        n_rows: Rows of the function, m.
        n_arguments: Length of z = (q, qd, qdd, u), nz.
    """

    def __init__(self, function: "casadi.Function", *, backend: str | None = None):
        if function.n_in() != 5 or function.n_out() != 1 or function.size2_out(0) != 1:
            raise ParameterError(
                f"{function.name()!r} must give one column from (q, qd, qdd, u, p); it has "
                f"{function.n_in()} inputs and {function.n_out()} outputs"
            )
        self.function = function
        self.n_rows: int = function.size1_out(0)
        self.n_arguments: int = sum(function.size1_in(i) for i in range(4))
        self._backend = backend

    @property
    def backend(self) -> str:
        """The evaluator: vectorised code or CasADi's interpreter."""
        return self._values.backend

    @cached_property
    def jacobian_pattern(self) -> tuple[Int[Array, " nnz"], Int[Array, " nnz"]]:
        """Rows and columns of dr/dz that can be other than zero."""
        return self._jacobian.pattern(1)

    @cached_property
    def hessian_pattern(self) -> tuple[Int[Array, " nnz"], Int[Array, " nnz"]]:
        """The same of the Hessian: the lower triangle, then the upper one."""
        i, j = self._hessian.pattern(0)
        off = i != j
        return np.concatenate([i, j[off]]), np.concatenate([j, i[off]])

    def values(self, q: States, v: States, a: States, u: Given, p: Given) -> Rows:
        """Return the rows."""
        return self._values(q, v, a, u, p)[0]

    def jacobian(
        self, q: States, v: States, a: States, u: Given, p: Given, *, out: Jacobian | None = None
    ) -> tuple[Rows, Jacobian]:
        """Return the rows and dr/dz.

        The latter is written to the contiguous array ``out`` if that is given: entries of the
        pattern are overwritten, all others left as they are.
        """
        r = np.empty((len(q), self.n_rows))
        shape = (len(q), self.n_rows, self.n_arguments)
        J = np.zeros(shape) if out is None else out
        if J.shape != shape:
            raise ParameterError(f"a Jacobian of shape {shape} does not fit into {J.shape}")
        rows = np.arange(self.n_rows)
        self._jacobian.scatter((q, v, a, u, p), (r, J), ((rows, rows), self._jacobian_places))
        return r, J

    def hessian(
        self,
        lam: Rows,
        q: States,
        v: States,
        a: States,
        u: Given,
        p: Given,
        *,
        onto: Float[Array, "n_nodes nz nz"] | None = None,
    ) -> Float[Array, "n_nodes nz nz"]:
        """Return the Hessian of lam'r, both triangles.

        It is added to the contiguous array ``onto`` if that is given, which is then returned.
        """
        shape = (len(q), self.n_arguments, self.n_arguments)
        H = np.zeros(shape) if onto is None else onto
        if H.shape != shape:
            raise ParameterError(f"a Hessian cannot be added to {H.shape}; it is {shape}")
        add = onto is not None
        self._hessian.scatter((lam, q, v, a, u, p), (H,), (self._hessian_places,), add=add)
        return H

    @cached_property
    def _values(self) -> BatchedFunction:
        return self._batched("values", lambda ca, symbols, z, r: (symbols, [r]))

    @cached_property
    def _jacobian(self) -> BatchedFunction:
        return self._batched(
            "jacobian", lambda ca, symbols, z, r: (symbols, [r, ca.jacobian(r, z)])
        )

    @cached_property
    def _hessian(self) -> BatchedFunction:
        def build(ca: Any, symbols: list[Any], z: Any, r: Any):
            lam = ca.SX.sym("lam", self.n_rows)
            gradient = ca.gradient(ca.dot(lam, r), z)
            return [lam, *symbols], [ca.tril(ca.jacobian(gradient, z))]

        return self._batched("hessian", build)

    def _batched(self, name: str, build: Callable) -> BatchedFunction:
        """Return a function made from symbols of all inputs, z and the rows."""

        def make() -> "casadi.Function":
            import casadi as ca

            function = source()
            symbols = function.sx_in()
            z, r = ca.vertcat(*symbols[:4]), ca.densify(function(*symbols))
            return ca.Function(name, *build(ca, symbols, z, r))

        source, numbers, structure = self._source
        key = f"{name} {_VERSION} of {structure}" if structure else ""
        return BatchedFunction(make, key=key, parameters=numbers, backend=self._backend)

    @cached_property
    def _source(self) -> "tuple[Callable[[], casadi.Function], Array | None, str]":
        """The function, its last input if its numbers were combined, and the remaining inputs."""
        f = self.function if self.function.is_a("SXFunction") else self.function.expand()
        if self._backend is None and (
            f.n_instructions() < _MAX_INTERPRETED or BatchedFunction.unavailable()
        ):
            self._backend = "interpreter"
        if self._backend == "interpreter":
            return lambda: f, None, ""
        return BatchedFunction.parametrised(f)

    @cached_property
    def _jacobian_places(self) -> tuple[Array, Array]:
        rows, columns = self.jacobian_pattern
        return _in_order(np.arange(len(rows)), rows * self.n_arguments + columns)

    @cached_property
    def _hessian_places(self) -> tuple[Array, Array]:
        i, j = self._hessian.pattern(0)
        source = np.concatenate([np.arange(len(i)), np.flatnonzero(i != j)])
        rows, columns = self.hessian_pattern
        return _in_order(source, rows * self.n_arguments + columns)


def _in_order(source: Int[Array, " n"], place: Int[Array, " n"]) -> tuple[Array, Array]:
    """Return them in the order of places: neighbours in memory are written together."""
    order = np.argsort(place)
    return source[order], place[order]


@lru_cache(maxsize=32)
def derivatives_of(function: "casadi.Function") -> NodeDerivatives:
    """Return the derivatives of a function, made at the first call and kept."""
    return NodeDerivatives(function)
