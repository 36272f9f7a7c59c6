"""CasADi functions as tables of operations on memory slots, and these as bytes.

A table is what the machine of :mod:`plantigrade.batched.vector_machine` steps through. It depends
neither on the parameters of a body nor on the processor.

A product that is used once, in a sum or difference, is fused with it into one operation, rounded
once where the processor supports that.
"""

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np

from plantigrade.arrays import Array
from plantigrade.batched.llvm import Untranslatable
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi

VERSION = 1  # of tables: one of another version is not used
FETCHED = ("input", "constant")

ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
COMPARISONS = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
SQUARES = {"sq": "fmul", "twice": "fadd"}
_LIBRARY = (  # functions of one or two numbers from the C library: CasADi's name, its name there
    *((n, n) for n in ("exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh")),
    *((n, n) for n in ("tanh", "asinh", "acosh", "atanh", "expm1", "log1p", "erf", "floor")),
    *((n, n) for n in ("ceil", "pow", "fmod", "atan2", "hypot", "remainder", "fmin", "fmax")),
    ("constpow", "pow"),
)
LIBRARY_NAMES = tuple(dict.fromkeys(there for _, there in _LIBRARY))
CALLS = {name: LIBRARY_NAMES.index(there) for name, there in _LIBRARY}
_OTHERS = ("neg", "sqrt", "fabs", "inv", "sign", "copysign", "if_else_zero", "not", "and", "or")
PAIRS = {*ARITHMETIC, *COMPARISONS, "copysign", "if_else_zero", "and", "or"}
PAIRS |= {"pow", "fmod", "atan2", "hypot", "remainder", "fmin", "fmax", "constpow"}
KNOWN = {*ARITHMETIC, *COMPARISONS, *SQUARES, *CALLS, *_OTHERS}
FUSED = ("muladd", "mulsub", "submul")  # a b + c, a b - c, c - a b
NUMBERS = {name: i for i, name in enumerate((*sorted(KNOWN), *FUSED))}
_SAME = {"assign", "lift"}  # give their first operand
_COMMUTE = {"add", "mul", "eq", "ne", "fmin", "fmax", "hypot", "and", "or"}


@dataclass(frozen=True)
class Program:
    """Operations in order, each making one value that is never made again."""

    operations: list[str]  # CasADi's names, without ``OP_`` and in lower case
    # two numbers for each: the values it takes (-1: none); input and element of an ``"input"``; the
    # index of a ``"constant"``
    operands: list[tuple[int, int]]
    outputs: list[int]  # values of the nonzeros of every output, one output after the other
    constants: list[float]
    sizes: tuple[int, ...]  # lengths of the inputs
    nonzeros: tuple[int, ...]  # numbers of nonzeros of the outputs

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool = False) -> "Program":
        """Return the program of an SX function; equal operations on equal values are done once.

        Elements of a ``shared`` last input are constants, after those of the function.

        Raises:
            Untranslatable: If the function is not made of SX symbols or has an unknown operation.
        """
        import casadi as ca

        if not function.is_a("SXFunction"):
            raise Untranslatable(f"{function.name()!r} is a {function.class_name()}, not of SX")
        names = {getattr(ca, n): n[3:].lower() for n in dir(ca) if n.startswith("OP_")}
        sizes = tuple(function.nnz_in(i) for i in range(function.n_in()))
        nonzeros = tuple(function.nnz_out(i) for i in range(function.n_out()))
        starts = np.cumsum([0, *nonzeros]).tolist()
        operations: list[str] = []
        operands: list[tuple[int, int]] = []
        outputs, constants = [-1] * starts[-1], []
        register: dict[int, int] = {}
        known: dict[tuple[str, int, int], int] = {}
        for k in range(function.n_instructions()):
            name = names.get(function.instruction_id(k), "unknown")
            taken, made = function.instruction_input(k), function.instruction_output(k)
            if name == "output":
                outputs[starts[made[0]] + made[1]] = register[taken[0]]
                continue
            if name == "const":
                name, a, b = "constant", len(constants), -1
                constants.append(float(function.instruction_constant(k)))
            elif name == "input":
                a, b = taken
                if shared and a == len(sizes) - 1:
                    name, a, b = "constant", -1 - b, -1  # numbered below
            elif name in _SAME:
                register[made[0]] = register[taken[0]]
                continue
            elif name in KNOWN:
                a, b = register[taken[0]], register[taken[1]] if len(taken) > 1 else -1
                if b < a and name in _COMMUTE:
                    a, b = b, a
            else:
                raise Untranslatable(f"{function.name()!r} has the operation {name!r}")
            value = known.setdefault((name, a, b), len(operations))
            if value == len(operations):
                operations.append(name)
                operands.append((a, b))
            register[made[0]] = value
        if shared:
            sizes, n = sizes[:-1], len(constants)
            for i, (name, (a, b)) in enumerate(zip(operations, operands, strict=True)):
                if name == "constant" and a < 0:
                    operands[i] = n - 1 - a, b
        if -1 in outputs:
            raise Untranslatable(f"{function.name()!r} leaves nonzeros of outputs unset")
        return cls(operations, operands, outputs, constants, sizes, nonzeros)


@dataclass(frozen=True, eq=False)
class Table:
    """A program as the machine reads it."""

    # number of lines; then for each the operation, the place of its result and three places of
    # operands (unused ones 0); int32
    lines: np.ndarray
    n_places: int  # places of memory; those of inputs come first, those of constants follow
    sizes: tuple[int, ...]  # lengths of the inputs
    places: tuple[np.ndarray, ...]  # places of the nonzeros of every output; int64


@no_type_check  # of hundreds of thousands of values
def tabulated(program: Program, n_constants: int) -> Table:
    """Return the table of a program with so many constants.

    A place is free again after the last use of what it holds; the one freed last is used first,
    because it is still in the processor's cache.
    """
    operations, operands = program.operations, program.operands
    n = len(operations)
    uses, last = [0] * n, [-1] * n
    for k, (a, b) in enumerate(operands):
        if operations[k] not in FETCHED:
            uses[a] += 1
            if b >= 0:
                uses[b] += 1
    for value in program.outputs:
        uses[value] += 1
    taken = [()] * n
    merged = bytearray(n)  # products that are done where they are used
    names = list(operations)
    for k, (name, (a, b)) in enumerate(zip(operations, operands, strict=True)):
        if name in FETCHED:
            continue
        if name in ("add", "sub"):
            if operations[a] == "mul" and uses[a] == 1 and not merged[a]:
                merged[a], taken[k] = 1, (*operands[a], b)
                names[k] = "muladd" if name == "add" else "mulsub"
                continue
            if operations[b] == "mul" and uses[b] == 1 and not merged[b]:
                merged[b], taken[k] = 1, (*operands[b], a)
                names[k] = "muladd" if name == "add" else "submul"
                continue
        taken[k] = (a,) if b < 0 else (a, b)
    for k in range(n):
        if not merged[k]:
            for value in taken[k]:
                last[value] = k
    for value in program.outputs:
        last[value] = n
    starts = np.cumsum([0, *program.sizes]).tolist()
    place, free, n_places = [-1] * n, [], starts[-1] + n_constants
    lines = [0]
    for k, name in enumerate(names):
        if name == "input":
            a, b = operands[k]
            place[k] = starts[a] + b
        elif name == "constant":
            place[k] = starts[-1] + operands[k][0]
        elif not merged[k]:
            values = taken[k]
            at = [place[v] for v in values]
            for v in set(values):
                if last[v] == k and names[v] not in FETCHED:
                    free.append(place[v])
            if not free:
                free.append(n_places)
                n_places += 1
            place[k] = free.pop()
            at += [0] * (3 - len(at))
            lines += (NUMBERS[name], place[k], *at)
    lines[0] = (len(lines) - 1) // 5
    outputs = np.array([place[v] for v in program.outputs], dtype=np.int64)
    parts = np.split(outputs, np.cumsum(program.nonzeros)[:-1]) if program.nonzeros else []
    return Table(np.array(lines, dtype=np.int32), n_places, program.sizes, tuple(parts))


@dataclass(frozen=True, eq=False)
class Signature:
    """Inputs and outputs of a function, without its parameters."""

    name: str
    names: tuple[str, ...]  # of inputs
    sizes: tuple[int, ...]  # of inputs
    patterns: tuple[tuple[Array, Array], ...]  # rows and columns of the nonzeros of every output

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool) -> "Signature":
        """Return the signature of a function; a ``shared`` last input holds parameters.

        Raises:
            ParameterError: If an input is not a dense column.
        """
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
class StoredTable:
    """A table with everything a call has to know about the function.

    Attributes:
        signature: Inputs and outputs.
        constants: Constants of the table, parameters excluded.
        table: The operations.
    """

    signature: Signature
    constants: Array
    table: Table

    def to_bytes(self) -> bytes:
        """Return it as an npz archive."""
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
    def from_bytes(cls, content: bytes | None) -> "StoredTable | None":
        """Return it from an npz archive; None from None."""
        if content is None:
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as x:
            n_outputs, n_places = x["counts"].tolist()
            patterns = tuple((x[f"rows{i}"], x[f"columns{i}"]) for i in range(n_outputs))
            places = tuple(x[f"places{i}"] for i in range(n_outputs))
            names, sizes = (tuple(x[each].tolist()) for each in ("names", "sizes"))
            signature = Signature(str(x["name"]), names, sizes, patterns)
            return cls(signature, x["constants"], Table(x["lines"], n_places, sizes, places))
