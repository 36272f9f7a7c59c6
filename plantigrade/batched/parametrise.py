"""A function whose numbers become an input, so that one compiled function serves every body."""

import hashlib
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np

from plantigrade.arrays import Array, Float

if TYPE_CHECKING:
    import casadi


@no_type_check  # nor of what it calls, a thousand times: shapes are checked in tests
def parametrised(
    function: "casadi.Function",
) -> tuple["casadi.Function", Float[Array, " n_parameters"], str]:
    """Return a function that takes its numbers as a last input, the numbers, and a fingerprint.

    Small whole and half numbers stay: they belong to the formula (and to its simplifications),
    not to a body. Every use of a number becomes a parameter of its own, because two numbers that
    are equal in one body may differ in another.

    Args:
        function: A function of SX symbols, or one that CasADi can expand to SX.

    Returns:
        The function; the value of its last input; a fingerprint shared by all functions that differ
        in these numbers only.
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

    def lifted(expression: Any, meaning: Any) -> tuple[Any, Any]:
        """Return a symbol for a number that does not belong to the formula."""
        if not isinstance(meaning, float) or _belongs_to_formula(meaning):
            return expression, meaning
        numbers.append(meaning)
        unknowns.append(ca.SX.sym(f"c{len(unknowns)}"))
        return unknowns[-1], "number"

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
            expression, meaning = lifted(*register[taken[0]])
            outputs[made[0]][made[1]] = expression
            structure.append((operation, *made, meaning))
            continue
        exponent = operation in (ca.OP_CONSTPOW, ca.OP_POW)
        given = [register[i] if exponent else lifted(*register[i]) for i in taken]
        expressions, meanings = zip(*given, strict=True)
        make = ca.SX.binary if len(taken) == 2 else ca.SX.unary
        register[made[0]] = make(operation, *expressions), len(structure)
        structure.append((operation, *meanings))
    results = [
        ca.SX(f.sparsity_out(i), ca.vertcat(*each)) if each else ca.SX(f.sparsity_out(i))
        for i, each in enumerate(outputs)
    ]
    shapes = [s.dim(True) for s in symbols]
    patterns = [s.sparsity().get_triplet() for s in results]
    made_of = (structure, shapes, patterns, ca.CasadiMeta.version())
    fingerprint = hashlib.sha256(repr(made_of).encode()).hexdigest()
    symbols.append(ca.vertcat(*unknowns) if unknowns else ca.SX(0, 1))
    names = [*f.name_in(), "numbers"]
    made = ca.Function(f.name(), symbols, results, names, f.name_out())
    return made, np.array(numbers, dtype=float), fingerprint


@no_type_check
def _belongs_to_formula(number: float) -> bool:
    return abs(number) <= 4.0 and 2.0 * number == round(2.0 * number)
