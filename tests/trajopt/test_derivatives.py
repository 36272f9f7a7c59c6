"""Derivatives of rows: against differences, and of a body with forces at its feet."""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from plantigrade.batched import BatchedFunction
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.errors import ParameterError
from plantigrade.trajopt.transcription.derivatives import NodeDerivatives
from tests.models.presets import person


def leg_rows(human):
    """Return moments of the right knee, ankle and toes, divided by the parameter."""
    body = SymbolicHuman(human)
    points = [s for s in foot_sites(human) if s.side == "r"]
    q, v, a = (ca.SX.sym(n, body.nv) for n in ("q", "v", "a"))
    u, p = ca.SX.sym("u", 3 * len(points)), ca.SX.sym("p", 1)
    tau = body.inverse_dynamics(points)(q, v, a, ca.reshape(u, 3, -1))
    rows = [body.names.index(n) for n in ("knee_angle_r", "ankle_angle_r", "mtp_angle_r")]
    return ca.Function("leg", [q, v, a, u, p], [tau[rows] / p])


def some_state(function, n, seed=0):
    rng = np.random.default_rng(seed)
    state = [rng.normal(size=(n, function.size1_in(i))) for i in range(5)]
    state[4] = 700.0 + state[4]
    return state


@pytest.fixture(scope="module", params=["vectors", "interpreter"])
def leg(request):
    if request.param == "vectors" and BatchedFunction.unavailable():
        pytest.skip(BatchedFunction.unavailable())
    return NodeDerivatives(leg_rows(person("42", "two-segment")), backend=request.param)


def test_derivatives_agree_with_differences(leg):
    state, step = some_state(leg.function, 3), 1e-5
    z = np.hstack(state[:4])
    rng = np.random.default_rng(1)
    lam = rng.normal(size=(3, leg.n_rows))
    along = rng.normal(size=(4, *z.shape))
    parts = np.cumsum([x.shape[1] for x in state[:3]])

    def at(z):
        return [*np.split(z, parts, axis=1), state[4]]

    r, J = leg.jacobian(*state)
    J, H = J.copy(), leg.hessian(lam, *state).copy()
    np.testing.assert_allclose(r, leg.values(*state), rtol=1e-12)
    for d in along:
        plus = leg.jacobian(*at(z + step * d))
        plus = plus[0], plus[1].copy()
        minus = leg.jacobian(*at(z - step * d))
        slope = (plus[0] - minus[0]) / (2 * step)
        np.testing.assert_allclose(
            np.einsum("nij,nj->ni", J, d), slope, atol=1e-6 * np.abs(slope).max()
        )
        slope = np.einsum("nij,ni->nj", plus[1] - minus[1], lam) / (2 * step)
        np.testing.assert_allclose(
            np.einsum("nij,nj->ni", H, d), slope, atol=1e-6 * np.abs(slope).max()
        )


def test_patterns_hold_all_there_is(leg):
    state = some_state(leg.function, 2)
    lam = np.ones((2, leg.n_rows))
    _, J = leg.jacobian(*state)
    H = leg.hessian(lam, *state)
    for array, (rows, columns) in ((J, leg.jacobian_pattern), (H, leg.hessian_pattern)):
        inside = np.zeros(array.shape[1:], dtype=bool)
        inside[rows, columns] = True
        assert not array[:, ~inside].any()
        assert inside.sum() == len(rows) < inside.size
    np.testing.assert_array_equal(H, H.transpose(0, 2, 1))


def test_a_hessian_is_added_if_requested(leg):
    for n in (1, 9):
        state = some_state(leg.function, n)
        lam = np.ones((n, leg.n_rows))
        H = leg.hessian(lam, *state)
        sum_ = np.arange(H.size, dtype=float).reshape(H.shape)
        want = sum_ + H
        assert leg.hessian(lam, *state, onto=sum_) is sum_
        np.testing.assert_array_equal(sum_, want)
    with pytest.raises(ParameterError, match="cannot be added to"):
        leg.hessian(lam, *state, onto=H[:, :-1, :-1])


def test_threads_do_not_share_arrays(leg):
    every = [some_state(leg.function, 7, seed) for seed in range(24)]
    lam = np.ones((7, leg.n_rows))

    def both(state):
        return leg.jacobian(*state)[1], leg.hessian(lam, *state)

    alone = [both(state) for state in every]
    with ThreadPoolExecutor(6) as pool:
        for ours, expected in zip(pool.map(both, every), alone, strict=True):
            for one, other in zip(ours, expected, strict=True):
                np.testing.assert_array_equal(one, other)


def test_a_small_function_is_interpreted_without_waiting(leg):
    symbols = [ca.SX.sym(n, 1) for n in ("q", "v", "a", "u", "p")]
    f = ca.Function("f", symbols, [0.3 * symbols[0] * symbols[3]])
    assert NodeDerivatives(f).backend == "interpreter"
    assert leg.function.n_instructions() > 300
    if not BatchedFunction.unavailable():
        assert NodeDerivatives(leg.function).backend == "vectors"


def test_a_function_without_unknowns_and_parameters_is_taken():
    q, v, a = (ca.SX.sym(n, 2) for n in "qva")
    f = ca.Function("f", [q, v, a, ca.SX(0, 1), ca.SX(0, 1)], [ca.sin(q[:1]) * v[1]])
    d, none = NodeDerivatives(f), np.zeros((3, 0))
    x = np.ones((3, 2))
    r, J = d.jacobian(x, x, x, none, none)
    assert r.shape == (3, 1) and J.shape == (3, 1, 6)
    np.testing.assert_allclose(J[:, 0, 0], np.cos(1.0))
    H = d.hessian(np.ones((3, 1)), x, x, x, none, none)
    np.testing.assert_allclose(H[:, 0, 3], np.cos(1.0))


def test_a_function_of_something_else_is_refused():
    x = ca.SX.sym("x", 2)
    with pytest.raises(ParameterError, match="must give one column from"):
        NodeDerivatives(ca.Function("f", [x], [x]))
