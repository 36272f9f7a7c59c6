"""CasADi functions evaluated at many nodes at once, with vector instructions.

CasADi's interpreter does one operation of one node of a motion after the other;
:class:`BatchedFunction` does each for up to 64 nodes before the next one, with vector instructions
made by LLVM, which comes as a wheel and needs no compiler.
"""

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.batched import code_cache, tables
from plantigrade.batched.llvm import Untranslatable, unavailable
from plantigrade.batched.parametrise import parametrised
from plantigrade.batched.tables import Signature, StoredTable
from plantigrade.batched.vector_machine import Machine
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi

BACKENDS = ("vectors", "interpreter")
_loaded: WeakValueDictionary[str, StoredTable] = WeakValueDictionary()


class BatchedFunction:
    """A CasADi function evaluated at many nodes at once.

    Inputs are arrays with one node per row; an output is an array of the nonzeros of CasADi's
    output, in CasADi's order (column by column), one node per row. Any number of threads may call
    the same function at the same time.

    The vector backend rounds differently from the interpreter (a product and a sum are one
    operation), by a few units in the last place of the largest terms of a sum.

    Args:
        function: The function, with dense columns as inputs; or a callable that makes it, called
            only when it is needed.
        key: Identifies the function and everything it is made from. With a key, the translated
            function is stored on disk and found there without making the function again.
        parameters: Value of the last input, the same at every node; calls then leave it out.
        backend: One of :data:`BACKENDS`; by default vectors where they are available.

    Attributes:
        backend: What evaluates the function.
        reason: Why that is the interpreter; empty if it is not.

    Raises:
        ParameterError: If an input is not a dense column, or if vectors are requested and not
            available.

    Example:
        >>> import casadi as ca
        >>> x = ca.SX.sym("x", 2)
        >>> length = BatchedFunction(ca.Function("length", [x], [ca.norm_2(x)]))
        >>> length(np.array([[3.0, 4.0], [5.0, 12.0]]))[0].tolist()
        [[5.0], [13.0]]
    """

    unavailable = staticmethod(unavailable)
    parametrised = staticmethod(parametrised)

    def __init__(
        self,
        function: "casadi.Function | Callable[[], casadi.Function]",
        *,
        key: str = "",
        parameters: Float[Array, " n_parameters"] | None = None,
        backend: str | None = None,
    ):
        import casadi as ca

        if backend not in (*BACKENDS, None):
            raise ParameterError(f"{backend=} must be one of {', '.join(BACKENDS)}")
        self._function = function if isinstance(function, ca.Function) else None
        self._make: Callable[[], Any] = (lambda: function) if self._function else function  # type: ignore
        self._parameters = parameters
        self._mapped: dict[int, tuple[Any, Any, Any]] = {}
        self._interpreting = threading.Lock()
        self._machine: Machine | None = None
        self.reason = "" if backend != "interpreter" else "the interpreter was requested"
        if not self.reason:
            self.reason = unavailable()
        if not self.reason:
            try:
                self._translate(key)
            except Untranslatable as error:
                self.reason = str(error)
        if self.reason and backend == "vectors":
            raise ParameterError(f"vectors are not available: {self.reason}")
        self.backend = "interpreter" if self.reason else "vectors"
        if self._machine is None:
            self._signature = Signature.of(self.function, parameters is not None)

    @property
    def function(self) -> "casadi.Function":
        """The function itself; parameters, if there are any, are its last input."""
        if self._function is None:
            self._function = self._make()
        return self._function

    def pattern(self, output: int) -> tuple[Int[Array, " nnz"], Int[Array, " nnz"]]:
        """Return rows and columns of the nonzeros of an output, in their order."""
        return self._signature.patterns[output]

    def __call__(self, *inputs: Float[Array, "n_nodes _"]) -> tuple[Float[Array, "n_nodes _"], ...]:
        """Return the nonzeros of every output at every node."""
        every = [np.arange(len(rows)) for rows, _ in self._signature.patterns]
        n = len(inputs[0]) if inputs else 0
        outputs = tuple(np.empty((n, len(each))) for each in every)
        self.scatter(inputs, outputs, [(each, each) for each in every])
        return outputs

    def scatter(
        self,
        inputs: Sequence[Float[Array, "n_nodes _"]],
        outputs: Sequence[Float[Array, "n_nodes ..."]],
        places: Sequence[tuple[Int[Array, " _"], Int[Array, " _"]]],
        *,
        add: bool = False,
    ) -> None:
        """Write the nonzeros of every output to given indices of given arrays, at every node.

        Args:
            inputs: As for a call.
            outputs: A contiguous array per output; what follows the node axis is taken as flat.
            places: For every output, which nonzeros go to which flat places, each place once.
            add: Whether to add to the arrays instead of overwriting them.

        Raises:
            ParameterError: If an array does not fit the function.
        """
        columns, n = self._checked_inputs(inputs)
        targets = self._checked_outputs(n, outputs, places)
        if n == 0:
            return
        if self._machine is not None:
            self._machine(columns, targets, add)
            return
        found = self._interpret(columns, n)
        for (array, source, place), values in zip(targets, found, strict=True):
            values = values[:, source]
            array[:, place] = array[:, place] + values if add else values

    def _checked_inputs(self, inputs: Sequence[Array]) -> tuple[list[Array], int]:
        """Return contiguous inputs and the number of nodes."""
        what = self._signature
        if len(inputs) != len(what.sizes):
            raise ParameterError(f"{what.name!r} takes {len(what.sizes)} inputs, not {len(inputs)}")
        n = len(inputs[0]) if inputs else 0
        for x, name, size in zip(inputs, what.names, what.sizes, strict=True):
            if x.shape != (n, size):
                raise ParameterError(
                    f"input {name!r} of {what.name!r} is {x.shape}; {n} nodes need {(n, size)}"
                )
        return [np.ascontiguousarray(x, dtype=float) for x in inputs], n

    def _checked_outputs(
        self, n: int, outputs: Sequence[Array], places: Sequence[tuple[Array, Array]]
    ) -> list[tuple[Array, Array, Array]]:
        """Return flat outputs, sources and places that machine code may write to unchecked."""
        patterns = self._signature.patterns
        if not len(outputs) == len(places) == len(patterns):
            raise ParameterError(f"{self._signature.name!r} has {len(patterns)} outputs")
        targets = []
        for y, (source, place), (rows, _) in zip(outputs, places, patterns, strict=True):
            source, place = (np.ascontiguousarray(each, np.int64) for each in (source, place))
            fine = y.dtype == float and y.flags.c_contiguous and y.flags.writeable and len(y) == n
            if not fine or len(source) != len(place):
                raise ParameterError(
                    f"{n} nodes need contiguous arrays of float64 with {n} rows, and a place for "
                    f"every source; an array has the shape {y.shape}"
                )
            width = y.size // n if n else 0
            for each, limit in ((source, len(rows)), (place, width)):
                if n and len(each) and not (each.min() >= 0 and each.max() < limit):
                    raise ParameterError(f"sources and places must be at least 0, below {limit}")
            targets.append((y.reshape(n, width), source, place))
        return targets

    def _translate(self, key: str) -> None:
        """Get the table from memory, from disk, or from the function, and load it."""
        shared = self._parameters is not None
        given = np.zeros(0) if self._parameters is None else self._parameters
        stored: StoredTable | None = None
        if key:
            name = f"{key} as table {tables.VERSION}"
            stored = _loaded.get(name) or StoredTable.from_bytes(code_cache.read(name))
        if stored is None:
            signature = Signature.of(self.function, shared)
            program = tables.Program.of(self.function, shared)
            table = tables.tabulated(program, len(program.constants) + len(given))
            stored = StoredTable(signature, program.constants, table)
            if key:
                code_cache.write(name, stored.to_bytes())
        if key:
            _loaded[name] = stored
        self._machine = Machine(stored.table, np.concatenate([stored.constants, given]))
        self._stored, self._signature = stored, stored.signature  # kept, so that _loaded finds it

    def _interpret(self, inputs: Sequence[Array], n: int) -> list[Array]:
        """Return nonzeros by CasADi's interpreter, node after node in one call."""
        if self._parameters is not None:
            inputs = [*inputs, np.tile(self._parameters, (n, 1))]
        outputs = [np.zeros((n, len(rows))) for rows, _ in self._signature.patterns]
        with self._interpreting:  # a buffer holds the arrays of one call
            if n not in self._mapped:
                mapped = self.function if n == 1 else self.function.map(n)
                self._mapped[n] = mapped, *mapped.buffer()
            _, buffer, run = self._mapped[n]
            for i, x in enumerate(inputs):
                if x.size:
                    buffer.set_arg(i, x.reshape(-1).data)
            for i, y in enumerate(outputs):
                if y.size:
                    buffer.set_res(i, y.reshape(-1).data)
            run()
        return outputs
