"""CasADi functions evaluated at many nodes at once.

A trajectory optimisation evaluates the same function at every node of a motion. CasADi's
interpreter does one operation of one node after the other; :class:`Batched` does each operation for
up to 64 nodes before the next one, with vector instructions that LLVM makes (it comes as a wheel,
no compiler is needed).

:func:`lifted` makes the numbers of a function an input, so that its derivatives are the same
functions for every person with the same joints: they are kept on disk, and nothing is
differentiated a second time.
"""

import hashlib
import io
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, no_type_check
from weakref import WeakValueDictionary

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.batched import code_cache as _code_cache
from plantigrade.batched import tables as _tables
from plantigrade.batched.llvm import Untranslatable, unavailable
from plantigrade.batched.vector_machine import Machine
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi

BACKENDS = ("vectors", "interpreter")


class Batched:
    """A CasADi function evaluated at many nodes at once.

    Inputs are arrays with one node a row; an output is an array of the nonzeros of CasADi's
    output, in CasADi's order (column by column), one node a row.

    Vectors round differently from the interpreter (a product and a sum are one operation), by some
    units in the last place of the largest numbers that meet in a sum.

    Args:
        function: The function; inputs must be dense columns. Or what makes it, called only if it
            is needed.
        key: Names the function, and all it is made from, among all others: what is worked out
            of it is then kept on disk, and used without making it.
        parameters: What the last input is, the same at every node; it is then not given in calls.
        backend: One of :data:`BACKENDS`; if not said, vectors where they can be had.

    Attributes:
        backend: What evaluates the function.
        reason: Why that is the interpreter; empty where it is not.

    Raises:
        ParameterError: If an input of the function is no dense column, or if vectors are asked for
            and cannot be had.

    Example:
        >>> import casadi as ca
        >>> x = ca.SX.sym("x", 2)
        >>> length = Batched(ca.Function("length", [x], [ca.norm_2(x)]))
        >>> length(np.array([[3.0, 4.0], [5.0, 12.0]]))[0].tolist()
        [[5.0], [13.0]]
    """

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
        self._lock = threading.Lock()
        self._machine: Machine | None = None
        self.reason = "" if backend != "interpreter" else "the interpreter was asked for"
        if not self.reason:
            self.reason = unavailable()
        if not self.reason:
            try:
                self._prepare(key)
            except Untranslatable as error:
                self.reason = str(error)
        if self.reason and backend == "vectors":
            raise ParameterError(f"vectors cannot be had: {self.reason}")
        self.backend = "interpreter" if self.reason else "vectors"
        if self._machine is None:
            self._signature = _Signature.of(self.function, parameters is not None)

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
        nonzeros = [len(rows) for rows, _ in self._signature.patterns]
        every = [np.arange(nnz) for nnz in nonzeros]
        outputs = tuple(np.empty((len(inputs[0]) if inputs else 0, nnz)) for nnz in nonzeros)
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
        """Write nonzeros of every output to where they belong in arrays given, at every node.

        Args:
            inputs: As for a call.
            outputs: An array an output, contiguous; what follows the node axis is seen as flat.
            places: For every output which nonzeros go to which flat places, each place once.
            add: Whether they are added to what is there.

        Raises:
            ParameterError: If an array is none that this function takes or fills.
        """
        columns, n = self._checked_inputs(inputs)
        targets = self._checked_outputs(n, outputs, places)
        if n == 0:
            return
        with self._lock:
            if self._machine is not None:
                self._machine(columns, targets, add)
                return
            for (array, source, place), values in zip(
                targets, self._interpret(columns, n), strict=True
            ):
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
        """Return flat outputs, sources and places that can be written to blindly."""
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

    # Machine ----------------------------------------------------------------------------------

    def _prepare(self, key: str) -> None:
        """Get a table from memory, from disk, or from the function; put it into a machine."""
        shared = self._parameters is not None
        tabled: _Tabled | None = None
        if key:
            name = f"{key} as table {_tables.VERSION}"
            tabled = _loaded.get(name) or _Tabled.from_bytes(_code_cache.read(name))
        if tabled is None:
            signature = _Signature.of(self.function, shared)
            program = _tables.Program.of(self.function, shared)
            n_given = len(self._parameters) if self._parameters is not None else 0
            table = _tables.tabulated(program, len(program.constants) + n_given)
            tabled = _Tabled(signature, np.array(program.constants, dtype=float), table)
            if key:
                _code_cache.write(name, tabled.to_bytes())
        if key:
            _loaded[name] = tabled
        given = np.zeros(0) if self._parameters is None else self._parameters
        self._machine = Machine(tabled.table, np.concatenate([tabled.constants, given]))
        self._tabled, self._signature = tabled, tabled.signature

    # Interpreter ------------------------------------------------------------------------------

    def _interpret(self, inputs: Sequence[Array], n: int) -> list[Array]:
        """Return nonzeros by CasADi's interpreter, node after node in one call."""
        if n not in self._mapped:
            mapped = self.function if n == 1 else self.function.map(n)
            self._mapped[n] = mapped, *mapped.buffer()
        _, buffer, run = self._mapped[n]
        if self._parameters is not None:
            inputs = [*inputs, np.tile(self._parameters, (n, 1))]
        outputs = [np.zeros((n, len(rows))) for rows, _ in self._signature.patterns]
        for i, x in enumerate(inputs):
            if x.size:
                buffer.set_arg(i, x.reshape(-1).data)
        for i, y in enumerate(outputs):
            if y.size:
                buffer.set_res(i, y.reshape(-1).data)
        run()
        return outputs


@no_type_check  # nor of what it calls, a thousand times: shapes are checked in tests
def lifted(
    function: "casadi.Function",
) -> tuple["casadi.Function", Float[Array, " n_parameters"], str]:
    """Return a function whose numbers are its last input, these numbers, and what is left.

    Small whole and half numbers stay: they belong to the formula (and to its simplifications),
    not to a body. Every use of a number is an element of its own, since two numbers that are equal
    in one body need not be in another.

    Args:
        function: A function of SX symbols, or one that CasADi can expand to them.

    Returns:
        The function; its last input; a word that is the same for functions that differ in these
        numbers only.
    """
    import casadi as ca

    f = function if function.is_a("SXFunction") else function.expand()
    symbols = [ca.SX.sym(f.name_in(i), f.sparsity_in(i)) for i in range(f.n_in())]
    elements = [s.nonzeros() for s in symbols]
    outputs: list[list[Any]] = [[0.0] * f.nnz_out(i) for i in range(f.n_out())]
    register: dict[int, tuple[Any, Any]] = {}  # the expression, and what is hashed for it
    numbers: list[float] = []
    unknowns: list[Any] = []
    structure: list[tuple] = []
    for k in range(f.n_instructions()):
        operation, taken = f.instruction_id(k), f.instruction_input(k)
        made = f.instruction_output(k)
        if operation == ca.OP_CONST:
            number = float(f.instruction_constant(k))
            register[made[0]] = ca.SX(number), number
            continue
        if operation == ca.OP_INPUT:
            register[made[0]] = elements[taken[0]][taken[1]], ("input", *taken)
            continue
        if operation == ca.OP_OUTPUT:
            expression, meaning = register[taken[0]]
            if isinstance(meaning, float) and not _formal(meaning):
                expression, meaning = _lift(ca, meaning, numbers, unknowns)
            outputs[made[0]][made[1]] = expression
            structure.append((operation, *made, meaning))
            continue
        expressions, meanings = [], []
        for i in taken:
            expression, meaning = register[i]
            exponent = operation in (ca.OP_CONSTPOW, ca.OP_POW)
            if isinstance(meaning, float) and not _formal(meaning) and not exponent:
                expression, meaning = _lift(ca, meaning, numbers, unknowns)
            expressions.append(expression)
            meanings.append(meaning)
        make = ca.SX.binary if len(taken) == 2 else ca.SX.unary
        register[made[0]] = make(operation, *expressions), len(structure)
        structure.append((operation, *meanings))
    results = [
        ca.SX(f.sparsity_out(i), ca.vertcat(*each)) if each else ca.SX(f.sparsity_out(i))
        for i, each in enumerate(outputs)
    ]
    shapes = [s.dim(True) for s in symbols]
    made_of = (
        structure,
        shapes,
        [s.sparsity().get_triplet() for s in results],
        ca.CasadiMeta.version(),
    )
    symbols.append(ca.vertcat(*unknowns) if unknowns else ca.SX(0, 1))
    names = [*f.name_in(), "numbers"]
    lifting = ca.Function(f.name(), symbols, results, names, f.name_out())
    return lifting, np.array(numbers, dtype=float), _hash(made_of)


@no_type_check
def _lift(ca: Any, number: float, numbers: list[float], unknowns: list[Any]) -> tuple[Any, str]:
    """Return a symbol for a number; note both."""
    numbers.append(number)
    unknowns.append(ca.SX.sym(f"c{len(unknowns)}"))
    return unknowns[-1], "number"


@no_type_check
def _formal(number: float) -> bool:
    return abs(number) <= 4.0 and 2.0 * number == round(2.0 * number)


def _hash(anything: Any) -> str:
    return hashlib.sha256(repr(anything).encode()).hexdigest()


@dataclass(frozen=True, eq=False)
class _Signature:
    """What a function takes and gives, without parameters."""

    name: str
    names: tuple[str, ...]
    sizes: tuple[int, ...]
    patterns: tuple[tuple[Array, Array], ...]

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool) -> "_Signature":
        for i in range(function.n_in()):
            if not (function.sparsity_in(i).is_dense() and function.size2_in(i) <= 1):
                raise ParameterError(
                    f"input {function.name_in(i)!r} of {function.name()!r} is "
                    f"{function.sparsity_in(i).dim(True)}; only dense columns are taken"
                )
        n = function.n_in() - shared
        triplets = [function.sparsity_out(i).get_triplet() for i in range(function.n_out())]
        return cls(
            function.name(),
            tuple(function.name_in(i) for i in range(n)),
            tuple(function.size1_in(i) for i in range(n)),
            tuple((np.array(r, dtype=np.int64), np.array(c, dtype=np.int64)) for r, c in triplets),
        )


@dataclass(frozen=True, eq=False)
class _Tabled:
    """A table with all that a call needs to know of the function."""

    signature: _Signature
    constants: Array
    table: _tables.Table

    def to_bytes(self) -> bytes:
        s, file = self.signature, io.BytesIO()
        arrays: dict[str, Any] = {}
        for i, (rows, columns) in enumerate(s.patterns):
            arrays |= {f"rows{i}": rows, f"columns{i}": columns, f"places{i}": self.table.places[i]}
        np.savez(
            file,
            name=np.array(s.name),
            names=np.array(s.names, dtype=str),
            sizes=np.array(s.sizes, dtype=np.int64),
            constants=self.constants,
            lines=self.table.lines,
            counts=np.array([len(s.patterns), self.table.n_places]),
            **arrays,
        )
        return file.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes | None) -> "_Tabled | None":
        if content is None:
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as x:
            n_outputs, n_places = x["counts"].tolist()
            patterns = tuple((x[f"rows{i}"], x[f"columns{i}"]) for i in range(n_outputs))
            places = tuple(x[f"places{i}"] for i in range(n_outputs))
            names, sizes = (tuple(x[each].tolist()) for each in ("names", "sizes"))
            signature = _Signature(str(x["name"]), names, sizes, patterns)
            return cls(
                signature, x["constants"], _tables.Table(x["lines"], n_places, sizes, places)
            )


_loaded: WeakValueDictionary[str, _Tabled] = WeakValueDictionary()
