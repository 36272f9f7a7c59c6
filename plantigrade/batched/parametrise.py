"""Functions whose constants become an input, so that one compiled function serves every body."""

import hashlib
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.batched.instructions import Instructions

if TYPE_CHECKING:
    import casadi

# Roles of an operand that is no result of an operation.
_NONE, _NUMBER, _EXPONENT, _OF_FORMULA = -1, -2, -3, -100


def parametrised(
    function: "casadi.Function",
) -> tuple[Callable[[], "casadi.Function"], Float[Array, " n_parameters"], str]:
    """Return a function with its constants as last input, the constants, and a fingerprint.

    Small whole and half numbers stay: they belong to the formula (and to its simplifications),
    not to a body. Every use of a number becomes a parameter of its own, because two numbers that
    are equal in one body may differ in another.

    Args:
        function: A function of SX symbols, or one that CasADi can expand to SX.

    Returns:
        The maker of the function; the value of its last input; a fingerprint shared by all
        functions that differ in these numbers only.
    """
    import casadi as ca

    f = function if function.is_a("SXFunction") else function.expand()
    does = Instructions.of(f)
    operations, taken = does.operations, does.operands
    constant = operations == ca.OP_CONST
    exponents = np.isin(operations, (ca.OP_CONSTPOW, ca.OP_POW))
    used = (taken >= 0) & (operations != ca.OP_INPUT)[:, None]
    given = used & constant[taken]
    lifted = given & ~exponents[:, None] & ~_belong_to_formula(does.numbers)[taken]
    # operands: index of another operation among those that are not constants, or a constant
    place = np.cumsum(~constant) - 1
    meaning = np.where(used, place[taken], np.where(taken < 0, _NONE, taken))
    formula = np.where(_belong_to_formula(does.numbers), does.numbers, 0.0)
    meaning = np.where(given, _OF_FORMULA - (2 * formula[taken]).astype(int), meaning)
    meaning = np.where(given & exponents[:, None], _EXPONENT, meaning)
    meaning = np.where(lifted, _NUMBER, meaning)
    powers = does.numbers[taken[given & exponents[:, None]]]
    outputs = np.where((operations == ca.OP_OUTPUT)[:, None], does.results, 0)
    sparsities = [f.sparsity_in(i) for i in range(f.n_in())]
    sparsities += [f.sparsity_out(i) for i in range(f.n_out())]
    shapes = [(s.dim(True), s.get_triplet()) for s in sparsities]
    known = hashlib.sha256(repr((shapes, ca.CasadiMeta.version())).encode())
    for each in (operations[~constant], meaning[~constant], outputs[~constant], powers):
        known.update(np.ascontiguousarray(each).tobytes())
    numbers = does.numbers[taken[lifted]]
    return cache(lambda: _made(f, does, lifted)), numbers, known.hexdigest()


@no_type_check  # nor of what it calls, a thousand times: shapes are checked in tests
def _made(
    f: "casadi.Function", does: Instructions, lifted: Bool[Array, "n 2"]
) -> "casadi.Function":
    """Return a function with the lifted constants as its last input."""
    import casadi as ca

    symbols = [ca.SX.sym(f.name_in(i), f.sparsity_in(i)) for i in range(f.n_in())]
    elements = [s.nonzeros() for s in symbols]
    outputs: list[list[Any]] = [[0.0] * f.nnz_out(i) for i in range(f.n_out())]
    unknowns: list[Any] = []
    values: list[Any] = []
    steps = zip(does.operations.tolist(), does.operands.tolist(), lifted.tolist(), strict=True)
    for k, (operation, taken, own) in enumerate(steps):
        if operation == ca.OP_CONST:
            values.append(ca.SX(float(does.numbers[k])))
            continue
        if operation == ca.OP_INPUT:
            values.append(elements[taken[0]][taken[1]])
            continue
        operands = []
        for source, new in zip(taken, own, strict=True):
            if new:
                unknowns.append(ca.SX.sym(f"c{len(unknowns)}"))
                operands.append(unknowns[-1])
            elif source >= 0:
                operands.append(values[source])
        if operation == ca.OP_OUTPUT:
            i, j = does.results[k].tolist()
            outputs[i][j] = operands[0]
            values.append(None)
            continue
        make = ca.SX.binary if len(operands) == 2 else ca.SX.unary
        values.append(make(operation, *operands))
    results = [
        ca.SX(f.sparsity_out(i), ca.vertcat(*each)) if each else ca.SX(f.sparsity_out(i))
        for i, each in enumerate(outputs)
    ]
    symbols.append(ca.vertcat(*unknowns) if unknowns else ca.SX(0, 1))
    return ca.Function(f.name(), symbols, results, [*f.name_in(), "numbers"], f.name_out())


def _belong_to_formula(numbers: Float[Array, " n"]) -> Bool[Array, " n"]:
    return (np.abs(numbers) <= 4.0) & (2.0 * numbers == np.round(2.0 * numbers))
