"""IPOPT on trajectory problems: derivatives, known optima, redundant rows, being stopped."""

import casadi as ca
import numpy as np
import pytest
from scipy import sparse

from plantigrade.errors import ParameterError
from plantigrade.trajopt import ConstraintFamily, PeriodicClosure, Problem
from plantigrade.trajopt.solvers.callbacks import functions_of
from plantigrade.trajopt.solvers.ipopt import run, solve
from plantigrade.trajopt.solvers.sparse_program import SparseProgram
from plantigrade.trajopt.splines.knots import clamped_knots, periodic_knots
from plantigrade.trajopt.splines.polynomial import PolynomialBasis


def inputs(nv: int, nu: int = 0) -> list:
    sizes = zip(("q", "qd", "qdd", "u", "p"), (nv, nv, nv, nu, 0), strict=True)
    return [ca.SX.sym(name, n) for name, n in sizes]


def rows(name: str, symbols: list, expression, n_nodes: int) -> ConstraintFamily:
    function = ca.Function(name, symbols, [expression])
    names = tuple(f"{name} {i}" for i in range(expression.shape[0]))
    return ConstraintFamily.free(name, function, names, n_nodes)


def mass_on_a_line(n: int = 21, *, twice: bool = False) -> Problem:
    """A mass goes from 0 to 1 in 1 s, from rest to rest, with the least sum of squared force."""
    nodes = np.linspace(0.0, 1.0, n)
    symbols = inputs(1, 1)
    q, qd, qdd, u, _ = symbols
    state = rows("state", symbols, ca.vertcat(q, qd), n)
    state.lower[0] = state.upper[0] = 0.0
    state.lower[-1] = state.upper[-1] = (1.0, 0.0)
    law = rows("law", symbols, ca.vertcat(u - qdd, *([3 * (u - qdd)] if twice else [])), n)
    law.lower[:] = law.upper[:] = 0.0
    force = rows("force", symbols, u, n)
    force.weight[:] = 1.0
    force.weight[[0, -1]] = 0.5  # the trapezoid of the integral
    limits = np.full((n, 1), 100.0)
    basis = PolynomialBasis(3, clamped_knots(nodes))
    smooth = np.zeros((n - 1, 1))
    return Problem(basis, nodes, ("x",), (state, law, force), ("f",), -limits, limits, smooth)


def pendulum(n: int = 9) -> Problem:
    """A problem with everything in it: nonlinear rows, costs of all kinds, unknowns, a closure."""
    nodes = np.linspace(0.0, 1.0, n + 1)[:-1]
    symbols = inputs(2, 2)
    q, qd, qdd, u, _ = symbols
    law = rows("law", symbols, ca.vertcat(qdd[0] + ca.sin(q[1]) * u[0], ca.cos(q[0]) * qd[1]), n)
    law.lower[:, 0] = law.upper[:, 0] = 0.1
    law.upper[:, 1] = 5.0
    cost = rows("cost", symbols, ca.vertcat(q[0] * q[1], qd[0] ** 2 + u[1]), n)
    cost.weight[:, 0], cost.target[:, 0], cost.gain[:, 1] = 2.0, 0.3, 0.7
    mirror = PeriodicClosure(
        np.array([1, 0]), np.array([1.0, -1.0]), np.array([0.5, 0.2]), np.array([1, 0]),
        np.array([-1.0, 1.0]),
    )  # fmt: skip
    limits = np.full((n, 2), 3.0)
    limits[2, 1] = 0.0  # fixed there
    basis = PolynomialBasis(3, periodic_knots(np.linspace(0.0, 1.0, n + 1)), periodic=True)
    return Problem(
        basis, nodes, ("a", "b"), (law, cost), ("f", "g"), -limits, limits, np.ones((n, 2)), mirror
    )


def test_derivatives_agree_with_differences():
    problem = pendulum()
    program = SparseProgram(problem, np.zeros((9, 2)))
    rng = np.random.default_rng(0)
    x, lam = rng.normal(size=program.n_variables), rng.normal(size=len(program.lower))
    n, h = program.n_variables, 1e-6
    shape = (n, n)

    def slope(x: np.ndarray) -> np.ndarray:
        """The gradient of the Lagrangian, the cost counted 0.7 times."""
        return 0.7 * program.gradient(x) + program.sparse_jacobian(x).T @ lam

    sides = [(x + h * e, x - h * e) for e in np.eye(n)]
    gradient = [(program.objective(a) - program.objective(b)) / (2 * h) for a, b in sides]
    jacobian = [(program.constraints(a) - program.constraints(b)) / (2 * h) for a, b in sides]
    hessian = [(slope(a) - slope(b)) / (2 * h) for a, b in sides]
    np.testing.assert_allclose(program.gradient(x), gradient, atol=1e-7)
    np.testing.assert_allclose(
        program.sparse_jacobian(x).toarray(), np.stack(jacobian, axis=1), atol=1e-7
    )
    upper = sparse.csr_array((program.hessian(x, 0.7, lam), program.hessian_pattern), shape=shape)
    np.testing.assert_allclose(upper.toarray(), np.triu(hessian), atol=1e-6)


def test_casadi_is_given_the_same_derivatives():
    program = SparseProgram(pendulum(), np.zeros((9, 2)))
    rng = np.random.default_rng(2)
    x, lam = rng.normal(size=program.n_variables), rng.normal(size=len(program.lower))
    half, full = (functions_of(program, symmetric=s)["nlp_hess_l"] for s in (False, True))
    upper, both = (np.array(f(x, [], 0.7, lam)) for f in (half, full))
    np.testing.assert_array_equal(both, both.T)
    np.testing.assert_array_equal(np.triu(both), upper)
    f, gradient, g, J = (
        np.array(y) for y in functions_of(program, symmetric=True)["nlp_jac_fg"](x, [])
    )
    assert f == program.objective(x)
    np.testing.assert_array_equal(gradient[0], program.gradient(x))
    np.testing.assert_array_equal(g[:, 0], program.constraints(x))
    np.testing.assert_array_equal(J, program.sparse_jacobian(x).toarray())


def test_rows_see_what_the_problem_says_a_spline_is():
    problem = pendulum()
    program = SparseProgram(problem, np.zeros((9, 2)))
    rng = np.random.default_rng(1)
    x = rng.normal(size=program.n_variables)
    c, u = program.unpack(x)
    q, qd, qdd = problem.states(c, problem.nodes)
    law = np.column_stack([qdd[:, 0] + np.sin(q[:, 1]) * u[:, 0], np.cos(q[:, 0]) * qd[:, 1]])
    np.testing.assert_allclose(program.constraints(x), law.ravel(), atol=1e-10)
    assert u[2, 1] == 0.0
    np.testing.assert_array_equal(program.pack(c, u), x)
    steps = np.diff(np.vstack([u, (u[0] * [-1, 1])[[0, 1]]]), axis=0)
    assert problem.closure is not None
    steps[-1] = problem.closure.u_sign * u[0][problem.closure.u_source] - u[-1]
    cost = np.sum((q[:, 0] * q[:, 1] - 0.3) ** 2) + 0.7 * np.sum(qd[:, 0] ** 2 + u[:, 1])
    assert program.objective(x) == pytest.approx(cost + 0.5 * np.sum(steps**2))


def test_the_least_force_from_rest_to_rest_falls_linearly():
    """The least squared force from 0 to 1 is 6 - 12 t."""
    problem = mass_on_a_line()
    result = solve(problem, np.zeros((23, 1)))
    assert result.success and result.violation < 1e-6
    q, _, force = problem.states(result.c, problem.nodes)
    expected = 6.0 - 12.0 * problem.nodes
    np.testing.assert_allclose(force[1:-1, 0], expected[1:-1], atol=0.05)
    np.testing.assert_allclose(force, result.u, atol=1e-6)
    assert q[10, 0] == pytest.approx(0.5, abs=1e-6)  # symmetric


def test_redundant_equations_are_left_out_and_still_judged():
    plain, doubled = mass_on_a_line(), mass_on_a_line(twice=True)
    one, two = solve(plain, np.zeros((23, 1))), solve(doubled, np.zeros((23, 1)))
    assert two.program.n_redundant == 21
    assert two.program.n_equations == one.program.n_equations == 21
    np.testing.assert_allclose(two.c, one.c, atol=1e-6)
    contradictory = mass_on_a_line(twice=True)
    contradictory.rows[1].lower[7, 1] = contradictory.rows[1].upper[7, 1] = 0.5
    result = solve(contradictory, np.zeros((23, 1)))
    assert result.violation > 0.1  # whichever of the two is kept, the other is off
    assert "law" in result.worst and "0.350 s" in result.worst


def test_ends_are_fixed_exactly():
    program = SparseProgram(mass_on_a_line(), np.zeros((23, 1)))
    assert program.n_fixed == 4  # two coefficients at either end
    c = solve(mass_on_a_line(), np.zeros((23, 1))).c
    np.testing.assert_array_equal(c[[0, 1, -2, -1], 0], (0.0, 0.0, 1.0, 1.0))


def test_a_callback_stops_it_at_the_best_point_seen():
    seen = []

    def stop(progress) -> bool:
        seen.append(progress)
        return progress.number >= 2

    result = solve(pendulum(), np.full((9, 2), 0.3), callback=stop)
    assert not result.success and result.status == "stopped"
    assert len(seen) == 3
    least = min(p.violation for p in seen)
    assert result.violation <= max(least, 1e-6) * (1 + 1e-6)


def test_ctrl_c_stops_it():
    def interrupt(progress) -> bool:
        if progress.number == 1:
            raise KeyboardInterrupt
        return False

    result = solve(pendulum(), np.full((9, 2), 0.3), callback=interrupt)
    assert result.status == "stopped" and np.isfinite(result.c).all()


def test_without_objective_only_the_constraints_count():
    result = solve(mass_on_a_line().part(["state"], costs=False), np.zeros((23, 1)))
    assert result.success and result.objective == 0.0
    assert result.program.n_equations == 0 and result.violation < 1e-9


def test_another_solver_finds_the_same():
    quiet = {name: False for name in ("print_header", "print_iteration", "print_status")}
    qp = {"qpsol": "qrqp", "qpsol_options": {"print_iter": False, "print_header": False}}
    guess = np.zeros((23, 1))
    program = SparseProgram(mass_on_a_line(), guess)
    result = run("sqpmethod", {**quiet, **qp}, program, guess)
    assert result.success
    np.testing.assert_allclose(result.c, solve(mass_on_a_line(), np.zeros((23, 1))).c, atol=1e-5)


def test_what_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="no rows 'wings'; there are state, law, force"):
        mass_on_a_line().part(["wings"])
    with pytest.raises(ParameterError, match=r"\(5, 1\); this problem has \(23, 1\)"):
        solve(mass_on_a_line(), np.zeros((5, 1)))
    with pytest.raises(ParameterError, match="finite"):
        solve(mass_on_a_line(), np.full((23, 1), np.nan))
