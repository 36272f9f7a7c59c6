"""Operations of CasADi's functions as arrays: as listed one by one, and run again by hand."""

import casadi as ca
import numpy as np
import pytest

from plantigrade.batched import instructions
from plantigrade.batched.instructions import Instructions
from tests.batched.test_batched_function import EVERYTHING


def functions():
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    y = ca.vertcat(ca.sin(x[0]) * p[0] + 7.25 * x[1] - x[2] ** 2, x[0], p[1] / x[1], -0.0, np.inf)
    many = ca.jacobian(ca.cumsum(ca.sin(ca.repmat(x, 20, 1)) * 0.3), x)
    return (
        ca.Function("f", [x, p], [y, x]),
        ca.Function("many", [x, p], [many, p]),
        ca.Function("one", [x], [x[1]]),
        ca.Function("none", [x], [ca.SX(2, 2)]),
        EVERYTHING,
    )


@pytest.mark.parametrize("f", functions(), ids=lambda f: f.name())
def test_instructions_read_from_the_text_equal_those_of_the_interface(f, monkeypatch):
    read = Instructions.of(f)
    monkeypatch.setattr(instructions, "_as_text", lambda lines: "not there")
    asked = Instructions.of(f)
    for name in ("operations", "operands", "results", "numbers"):
        np.testing.assert_array_equal(getattr(read, name), getattr(asked, name))
    assert len(read.operations) == f.n_instructions()


def test_most_are_read_from_the_text(monkeypatch):
    """CasADi still writes them as it did."""
    asked, each = [], instructions._asked
    monkeypatch.setattr(instructions, "_asked", lambda f, k: asked.extend(k) or each(f, k))
    f = functions()[1]
    Instructions.of(f)
    assert len(asked) == 2 * instructions.COMPARED_OPERATIONS < f.n_instructions()


def test_steps_give_what_the_function_gives():
    f, given = functions()[0], ([0.3, 0.8, -1.2], [0.5, 2.0])
    does, values, out = Instructions.of(f), [], [np.zeros(5), np.zeros(3)]
    for operation, taken, made, number in zip(
        does.operations, does.operands, does.results, does.numbers, strict=True
    ):
        operands = [ca.SX(values[i]) for i in taken if i >= 0] if len(values) else []
        if operation == ca.OP_INPUT:
            values.append(given[taken[0]][taken[1]])
        elif operation == ca.OP_CONST:
            values.append(float(number))
        elif operation == ca.OP_OUTPUT:
            out[made[0]][made[1]] = values[taken[0]]
            values.append(0.0)
        else:
            make = ca.SX.binary if len(operands) == 2 else ca.SX.unary
            values.append(float(make(int(operation), *operands)))
    for ours, theirs in zip(out, f(*given), strict=True):
        np.testing.assert_allclose(ours, np.array(theirs)[:, 0])
