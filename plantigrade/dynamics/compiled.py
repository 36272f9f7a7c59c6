"""CasADi functions evaluated at many nodes at once.

A trajectory optimisation evaluates the same function at every node of a motion. :class:`Batched`
does that for arrays whose rows are nodes, without a copy in between.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi


class Batched:
    """A CasADi function evaluated at many nodes at once.

    Inputs are arrays with one node a row; an output is an array of the nonzeros of CasADi's
    output, in CasADi's order (column by column), one node a row.

    Attributes:
        function: The function; inputs must be dense columns.
        backend: What evaluates it: ``"interpreter"``, CasADi's own.

    Raises:
        ParameterError: If an input of the function is no dense column.

    Example:
        >>> import casadi as ca
        >>> x = ca.SX.sym("x", 2)
        >>> length = Batched(ca.Function("length", [x], [ca.norm_2(x)]))
        >>> length(np.array([[3.0, 4.0], [5.0, 12.0]]))[0].tolist()
        [[5.0], [13.0]]
    """

    def __init__(self, function: "casadi.Function"):
        for i in range(function.n_in()):
            if not (function.sparsity_in(i).is_dense() and function.size2_in(i) <= 1):
                raise ParameterError(
                    f"input {function.name_in(i)!r} of {function.name()!r} is "
                    f"{function.sparsity_in(i).dim(True)}; only dense columns are taken"
                )
        self.function = function
        self.backend = "interpreter"
        self._sizes = tuple(function.size1_in(i) for i in range(function.n_in()))
        self._nonzeros = tuple(function.nnz_out(i) for i in range(function.n_out()))
        self._mapped: dict[int, tuple[Any, Any, Any]] = {}

    def pattern(self, output: int) -> tuple[Int[Array, " nnz"], Int[Array, " nnz"]]:
        """Return rows and columns of the nonzeros of an output, in their order."""
        sparsity = self.function.sparsity_out(output)
        rows, columns = sparsity.get_triplet()
        return np.array(rows, dtype=int), np.array(columns, dtype=int)

    def __call__(self, *inputs: Float[Array, "n_nodes _"]) -> tuple[Float[Array, "n_nodes _"], ...]:
        """Return the nonzeros of every output at every node."""
        columns, n = self._checked(inputs)
        outputs = tuple(np.zeros((n, nnz)) for nnz in self._nonzeros)
        if n:
            self._interpret(columns, outputs, n)
        return outputs

    def scatter(
        self,
        inputs: Sequence[Float[Array, "n_nodes _"]],
        outputs: Sequence[Float[Array, "n_nodes ..."]],
        places: Sequence[tuple[Int[Array, " _"], Int[Array, " _"]]],
    ) -> None:
        """Write nonzeros of every output to where they belong in arrays given, at every node.

        Args:
            inputs: As for a call.
            outputs: An array an output, contiguous; what follows the node axis is seen as flat.
            places: For every output which nonzeros go to which flat places.
        """
        for array, values, (source, place) in zip(outputs, self(*inputs), places, strict=True):
            array.reshape(len(array), -1)[:, place] = values[:, source]

    def _checked(self, inputs: Sequence[Array]) -> tuple[list[Array], int]:
        """Return contiguous inputs and the number of nodes."""
        if len(inputs) != len(self._sizes):
            raise ParameterError(
                f"{self.function.name()!r} takes {len(self._sizes)} inputs, not {len(inputs)}"
            )
        n = len(inputs[0]) if inputs else 0
        for i, (x, size) in enumerate(zip(inputs, self._sizes, strict=True)):
            if x.shape != (n, size):
                raise ParameterError(
                    f"input {self.function.name_in(i)!r} of {self.function.name()!r} is {x.shape}; "
                    f"{n} nodes need {(n, size)}"
                )
        return [np.ascontiguousarray(x, dtype=float) for x in inputs], n

    def _interpret(self, inputs: Sequence[Array], outputs: Sequence[Array], n: int) -> None:
        """Fill outputs by CasADi's interpreter, node after node in one call."""
        if n not in self._mapped:
            mapped = self.function if n == 1 else self.function.map(n)
            buffer, run = mapped.buffer()
            self._mapped[n] = mapped, buffer, run
        _, buffer, run = self._mapped[n]
        for i, x in enumerate(inputs):
            if x.size:
                buffer.set_arg(i, x.reshape(-1).data)
        for i, y in enumerate(outputs):
            if y.size:
                buffer.set_res(i, y.reshape(-1).data)
        run()
