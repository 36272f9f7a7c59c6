"""Banded quadratic programs, held against DAQP's active set."""

import daqp
import numpy as np
import pytest
import scipy.sparse as sp

from plantigrade.dynamics.quadratic import solve_quadratic
from plantigrade.errors import SolverError


def program(border, seed=0, n=40, m=60):
    """Return a random program whose matrix is a band with a border."""
    rng = np.random.default_rng(seed)
    A = np.eye(n) + np.diag(rng.normal(size=n - 1), 1) + np.diag(rng.normal(size=n - 3), 3)
    A[:30, n - border :] = rng.normal(size=(30, border))
    G = np.zeros((m, n))
    for i in range(m):
        G[i, i % (n - 2) : i % (n - 2) + 3] = rng.normal(size=3)
    return A.T @ A + 0.1 * np.eye(n), 3 * rng.normal(size=n), G, np.full(m, 0.2)


@pytest.mark.parametrize("border", [0, 3])
def test_the_optimum_is_that_of_an_active_set(border):
    P, q, G, h = program(border)
    found = solve_quadratic(sp.csr_array(P), q, sp.csr_array(G), h, border=border)
    exact = daqp.solve(P, q, G, h, np.full(len(h), -1e30), np.zeros(len(h), dtype=np.int32))[0]
    assert (found.slack < 1e-3).sum() > 3  # some limits hold
    np.testing.assert_allclose(found.x, exact, atol=1e-3)


def test_a_program_without_inequalities_is_one_linear_system():
    P, q, _, _ = program(3)
    found = solve_quadratic(sp.csr_array(P), q, sp.csr_array((0, len(q))), np.zeros(0), border=3)
    np.testing.assert_allclose(found.x, np.linalg.solve(P, -q), atol=1e-6)
    np.testing.assert_allclose(found.response(np.eye(len(q))), np.linalg.inv(P), atol=1e-6)


def test_from_the_optimum_of_another_program_fewer_steps_lead_to_the_same():
    P, q, G, h = program(3)
    arrays = sp.csr_array(P), q, sp.csr_array(G), h
    cold = solve_quadratic(*arrays, border=3)
    other = solve_quadratic(sp.csr_array(P), 1.05 * q, sp.csr_array(G), h, border=3)
    warm = solve_quadratic(*arrays, border=3, start=other)
    assert warm.steps < cold.steps
    np.testing.assert_allclose(warm.x, cold.x, atol=1e-3)


def test_contradictory_limits_have_no_solution():
    P, q, _, _ = program(0)
    G = np.zeros((2, len(q)))
    G[:, 0] = 1.0, -1.0
    with pytest.raises(SolverError, match="quadratic program"):
        solve_quadratic(sp.csr_array(P), q, sp.csr_array(G), np.array([-1.0, -1.0]))
