"""CasADi functions as tables of operations on memory slots, and these as bytes.

A table is what the machine of :mod:`plantigrade.batched.vector_machine` steps through. It depends
neither on the parameters of a body nor on the processor.

A product that is used once, in a sum or difference, is fused with it into one operation, rounded
once where the processor supports that.
"""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np

from plantigrade.arrays import Array
from plantigrade.batched.instructions import Instructions
from plantigrade.batched.llvm import Untranslatable
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi

VERSION = 2  # of tables: one of another version is not used

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
INPUT, CONSTANT, _OUTPUT, _SAME, _UNKNOWN = -1, -2, -3, -4, -5  # numbers of what is no line
_OTHER = {"input": INPUT, "const": CONSTANT, "output": _OUTPUT, "assign": _SAME, "lift": _SAME}
_COMMUTE = {"add", "mul", "eq", "ne", "fmin", "fmax", "hypot", "and", "or"}


@dataclass(frozen=True, eq=False)
class Program:
    """Operations in order, each making one value that is never made again."""

    operations: np.ndarray  # numbers of lines; INPUT or CONSTANT
    # two numbers for each: its operands (-1: none); number and element of an input; the
    # index of a constant
    operands: np.ndarray
    outputs: np.ndarray  # values of the nonzeros of every output, one output after the other
    constants: np.ndarray
    sizes: tuple[int, ...]  # lengths of the inputs
    nonzeros: tuple[int, ...]  # numbers of nonzeros of the outputs

    def named(self) -> Iterator[tuple[str, int, int]]:
        """Yield operations by CasADi's names, without ``OP_`` and in lower case, and operands."""
        names = {number: name for name, number in NUMBERS.items()}
        names |= {INPUT: "input", CONSTANT: "constant"}
        for operation, (a, b) in zip(self.operations.tolist(), self.operands.tolist(), strict=True):
            yield names[operation], a, b

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool = False) -> "Program":
        """Return the program of an SX function; equal operations on equal values are done once.

        Elements of a ``shared`` last input are constants, after those of the function.
        """
        import casadi as ca

        if not function.is_a("SXFunction"):
            raise Untranslatable(f"{function.name()!r} is a {function.class_name()}, not of SX")
        does = Instructions.of(function)
        names = {getattr(ca, n): n[3:].lower() for n in dir(ca) if n.startswith("OP_")}
        kinds = np.full(max(names) + 1, _UNKNOWN)
        for number, name in names.items():
            kinds[number] = NUMBERS.get(name, _OTHER.get(name, _UNKNOWN))
        operations, taken = kinds[does.operations], does.operands.copy()
        if (operations == _UNKNOWN).any():
            name = names[int(does.operations[np.argmax(operations == _UNKNOWN)])]
            raise Untranslatable(f"{function.name()!r} has the operation {name!r}")
        sizes = tuple(function.nnz_in(i) for i in range(function.n_in()))
        nonzeros = tuple(function.nnz_out(i) for i in range(function.n_out()))
        constant = operations == CONSTANT
        constants = does.numbers[constant]
        taken[constant, 0] = np.arange(len(constants))
        if shared:
            given = (operations == INPUT) & (taken[:, 0] == len(sizes) - 1)
            taken[given, 0], operations[given] = len(constants) + taken[given, 1], CONSTANT
            sizes = sizes[:-1]
        taken[operations == CONSTANT, 1] = -1
        kept, value = _once(operations.tolist(), *taken.T.tolist())
        made = np.array(value)
        operands = taken[kept]
        line = operations[kept] >= 0
        operands[line] = np.where(operands[line] >= 0, made[operands[line]], -1)
        out = operations == _OUTPUT
        starts = np.cumsum([0, *nonzeros])
        outputs = np.full(starts[-1], -1)
        outputs[starts[does.results[out, 0]] + does.results[out, 1]] = made[taken[out, 0]]
        if (outputs < 0).any():
            raise Untranslatable(f"{function.name()!r} leaves nonzeros of outputs unset")
        return cls(operations[kept], operands, outputs, constants, sizes, nonzeros)


@no_type_check  # of hundreds of thousands of values
def _once(operations: list, first: list, second: list) -> tuple[list, list]:
    """Return the operations that first compute their value, and the values of all."""
    commute = {NUMBERS[name] for name in _COMMUTE}
    known, kept, value, size = {}, [], [-1] * len(operations), 0
    for k, (operation, a, b) in enumerate(zip(operations, first, second, strict=True)):
        if operation >= 0:
            a = value[a]
            if b >= 0:
                b = value[b]
                if b < a and operation in commute:
                    a, b = b, a
        elif operation == _OUTPUT:
            continue
        elif operation == _SAME:
            value[k] = value[a]
            continue
        value[k] = made = known.setdefault((operation, a, b), size)
        if made == size:
            kept.append(k)
            size += 1
    return kept, value


@dataclass(frozen=True, eq=False)
class ProgramTable:
    """A program in the format of the machine."""

    # number of lines; then for each the operation, the place of its result and three places of
    # operands (unused ones 0); int32
    lines: np.ndarray
    n_places: int  # places of memory; those of inputs come first, those of constants follow
    sizes: tuple[int, ...]  # lengths of the inputs
    places: tuple[np.ndarray, ...]  # places of the nonzeros of every output; int64


def tabulated(program: Program, n_constants: int) -> ProgramTable:
    """Return the table of a program with so many constants.

    A place is free again after the last use of what it holds; the one freed last is used first,
    because it is still in the processor's cache.
    """
    operations, (a, b) = program.operations.copy(), program.operands.T
    n = len(operations)
    computed = operations >= 0
    used = [a[computed], b[computed & (b >= 0)], program.outputs]
    uses = np.bincount(np.concatenate(used), minlength=n)
    # products that are fused with their use
    sums = np.isin(operations, (NUMBERS["add"], NUMBERS["sub"]))
    single = (operations == NUMBERS["mul"]) & (uses == 1)
    first = sums & single[a]
    second = sums & ~first & single[b]
    taken = np.stack([a, b, np.full(n, -1)], axis=1)
    taken[first] = np.stack([a[a[first]], b[a[first]], b[first]], axis=1)
    taken[second] = np.stack([a[b[second]], b[b[second]], a[second]], axis=1)
    merged = np.zeros(n, dtype=bool)
    merged[a[first]] = merged[b[second]] = True
    plus = operations == NUMBERS["add"]
    operations[first] = np.where(plus, NUMBERS["muladd"], NUMBERS["mulsub"])[first]
    operations[second] = np.where(plus, NUMBERS["muladd"], NUMBERS["submul"])[second]
    lines = np.flatnonzero(computed & ~merged)
    taken = taken[lines]
    here = taken >= 0
    last = np.full(n, -1)
    last[taken[here]] = np.broadcast_to(lines[:, None], taken.shape)[here]  # the latest stays
    last[program.outputs] = n
    ends = here & computed[taken] & (last[taken] == lines[:, None])
    ends[:, 1] &= taken[:, 1] != taken[:, 0]
    ends[:, 2] &= (taken[:, 2] != taken[:, 0]) & (taken[:, 2] != taken[:, 1])
    starts = np.cumsum([0, *program.sizes])
    place = np.where(operations == CONSTANT, starts[-1] + a, -1)
    inputs = operations == INPUT
    place[inputs] = starts[a[inputs]] + b[inputs]
    n_places = _placed(lines, ends.sum(axis=1), taken[ends], place, int(starts[-1]) + n_constants)
    rows = np.column_stack([operations[lines], place[lines], np.where(here, place[taken], 0)])
    parts = np.split(place[program.outputs], np.cumsum(program.nonzeros)[:-1])
    return ProgramTable(
        np.concatenate([[len(lines)], rows.ravel()]).astype(np.int32),
        n_places,
        program.sizes,
        tuple(parts) if program.nonzeros else (),
    )


@no_type_check  # of hundreds of thousands of values
def _placed(lines, counts, ended, place, n_places) -> int:
    """Assign memory slots to values, reusing free ones; return the number of slots."""
    where, free, ending = place.tolist(), [], iter(ended.tolist())
    for k, count in zip(lines.tolist(), counts.tolist(), strict=True):
        if count:
            for _ in range(count - 1):
                free.append(where[next(ending)])
            where[k] = where[next(ending)]
        elif free:
            where[k] = free.pop()
        else:
            where[k] = n_places
            n_places += 1
    place[:] = where
    return n_places


@dataclass(frozen=True, eq=False)
class Signature:
    """Inputs and outputs of a function, without its parameters."""

    name: str
    names: tuple[str, ...]  # of inputs
    sizes: tuple[int, ...]  # of inputs
    patterns: tuple[tuple[Array, Array], ...]  # rows and columns of the nonzeros of every output

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool) -> "Signature":
        """Return the signature of a function; a ``shared`` last input holds parameters."""
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
    """A table with the signature of its function."""

    signature: Signature  #: Inputs and outputs
    constants: Array  #: Constants of the table, parameters excluded
    table: ProgramTable  #: The operations

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
            return cls(signature, x["constants"], ProgramTable(x["lines"], n_places, sizes, places))
