"""Operations of a CasADi function of SX symbols as arrays.

CasADi tells of one operation at a time, which takes longer than to make the derivatives of a body.
In the text of a function that CasADi stores, all of them stand in a row: sixteen bytes each, a
byte two letters. They are read from there where the first of them are found and the last agree with
what CasADi says, and asked for one by one where not.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float, Int

if TYPE_CHECKING:
    import casadi

COMPARED_OPERATIONS = 16  # operations at either end


@dataclass(frozen=True, eq=False)
class Instructions:
    """Operations of a function in their order."""

    operations: Int[Array, " n"]  #: CasADi's numbers of them
    #: Which operations made what each takes, -1 for none; of an input its number and element
    operands: Int[Array, "n 2"]
    #: Of an output its number and nonzero, of everything else nothing of use
    results: Int[Array, "n 2"]
    numbers: Float[Array, " n"]  #: Of constants; 0 of everything else

    @classmethod
    def of(cls, function: "casadi.Function") -> "Instructions":
        """Return the operations of an SX function."""
        import casadi as ca

        lines = _lines(function)
        operations = lines[:, 0].astype(np.int64)
        constant, output = operations == ca.OP_CONST, operations == ca.OP_OUTPUT
        inputs = operations == ca.OP_INPUT
        numbers = np.zeros(len(lines))
        numbers[constant] = lines[constant, 2:].copy().view(np.float64)[:, 0]
        # registers → latest operations that wrote to them
        n, at = len(lines), np.arange(len(lines))
        wrote = np.flatnonzero(~output)
        key = np.sort(lines[wrote, 1].astype(np.int64) * (n + 1) + wrote)
        operands = np.full((n, 2), -1)
        count = _operands(function, operations)
        for i in range(2):
            column = np.where(output, 2, 2 + i)
            reads = np.flatnonzero(count > i)
            asked = lines[reads, column[reads]].astype(np.int64) * (n + 1) + at[reads]
            operands[reads, i] = key[np.searchsorted(key, asked) - 1] % (n + 1)
        operands[inputs] = lines[inputs, 2:]
        results = lines[:, [1, 3]].astype(np.int64)
        return cls(operations, operands, results, numbers)


def _operands(function: "casadi.Function", operations: Array) -> Int[Array, " n"]:
    """Return the number of operands of each operation."""
    import casadi as ca

    count = np.zeros(int(operations.max(initial=0)) + 1, int)
    for operation, k in zip(*np.unique(operations, return_index=True), strict=True):
        if operation not in (ca.OP_INPUT, ca.OP_CONST):
            count[operation] = len(function.instruction_input(int(k)))
    return count[operations]


def _lines(function: "casadi.Function") -> Int[Array, "n 4"]:
    """Return four numbers for each operation: operation, register written, two that are read.

    The latter are the number and element of an input, or the halves of a constant's value; an
    output has its number, the register that is read, and its nonzero.
    """
    n = function.n_instructions()
    first = _asked(function, range(min(n, COMPARED_OPERATIONS)))
    last = _asked(function, range(max(n - COMPARED_OPERATIONS, 0), n))
    text = function.serialize()
    at = text.find(_as_text(first))
    if n and at >= 0 and len(text) >= at + 32 * n:
        letters = np.frombuffer(text[at : at + 32 * n].encode("ascii"), np.uint8) - ord("a")
        lines = (letters[::2] | letters[1::2] << 4).view("<i4").reshape(n, 4)
        if np.array_equal(lines[-len(last) :], last):
            return lines
    return _asked(function, range(n))


def _as_text(lines: Int[Array, "n 4"]) -> str:
    """Return operations as CasADi writes them: of each byte first the lower half."""
    bytes_ = np.ascontiguousarray(lines, "<i4").view(np.uint8).ravel()
    return (np.stack([bytes_ & 15, bytes_ >> 4], axis=1) + ord("a")).tobytes().decode("ascii")


def _asked(function: "casadi.Function", which: Iterable[int]) -> Int[Array, "n 4"]:
    """Return operations as :func:`_lines` does, asked for one by one."""
    import casadi as ca

    found = []
    for k in which:
        operation, results = function.instruction_id(k), function.instruction_output(k)
        operands = function.instruction_input(k)
        if operation == ca.OP_CONST:
            value = np.array([function.instruction_constant(k)]).view("<i4")
            found.append((operation, results[0], *value.tolist()))
        elif operation == ca.OP_OUTPUT:
            found.append((operation, results[0], operands[0], results[1]))
        else:
            found.append((operation, results[0], operands[0], operands[-1]))
    return np.array(found, dtype=np.int32).reshape(-1, 4)
