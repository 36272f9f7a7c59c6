"""The banded interior point against other solvers, known optima and what cannot be."""

from dataclasses import replace

import casadi as ca
import daqp
import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.trajopt import InteriorPoint, Options, PeriodicClosure, Problem
from plantigrade.trajopt.solvers import ipopt
from plantigrade.trajopt.solvers.interior_point import Multipliers
from plantigrade.trajopt.solvers.kkt import KKTSystem
from plantigrade.trajopt.solvers.slacks import Slacks
from plantigrade.trajopt.transcription.constraint_block import limits_of_unknowns
from plantigrade.trajopt.transcription.evaluation import Evaluation
from plantigrade.trajopt.transcription.linear_map import Transcription
from tests.trajopt.toys import cubic, inputs, mass_on_a_line, pendulum, rows, swing, uneven

FINE = Options(tolerance=1e-8, feasibility=1e-8)


def quadratic(seed: int, *, periodic: bool) -> Problem:
    """A convex quadratic problem with equations, inequalities, limits and a linear cost."""
    rng = np.random.default_rng(seed)
    ends = uneven(8, seed)
    nodes = ends[:-1] if periodic else ends
    n = len(nodes)
    symbols = inputs(2, 2)
    z = ca.vertcat(*symbols[:4])
    scale = np.array([1.0] * 2 + [0.3] * 2 + [0.02] * 2 + [1.0] * 2)

    def linear(name, m):
        return rows(name, symbols, ca.DM(rng.normal(size=(m, 8)) * scale) @ z, n)

    cost, equal, within = linear("cost", 4), linear("equal", 1), linear("within", 2)
    cost.weight[:] = rng.uniform(0.5, 2.0, cost.weight.shape)
    cost.target[:] = rng.normal(size=cost.target.shape)
    cost.gain[:] = rng.normal(size=cost.gain.shape)
    some = rng.random(n) < 0.6
    equal.lower[some] = equal.upper[some] = 0.3
    within.lower[:, 0], within.upper[:, 1] = -0.2, 0.2
    within.upper[::2, 0] = 0.4
    every = rows("every", symbols, ca.vertcat(symbols[0], symbols[3]), n)
    every.weight[:] = 0.05
    closure = None
    if periodic:
        closure = PeriodicClosure(
            np.array([1, 0]), np.array([1.0, -1.0]), np.zeros(2), np.array([1, 0]),
            np.array([1.0, -1.0]),
        )  # fmt: skip
    lower, upper = np.full((n, 2), -0.6), np.full((n, 2), 0.6)
    lower[2, 0] = upper[2, 0] = 0.1
    smooth = rng.uniform(0.1, 0.4, (n if periodic else n - 1, 2))
    return Problem(
        cubic(ends, periodic=periodic),
        nodes,
        ("a", "b"),
        (cost, equal, within, every),
        ("f", "g"),
        lower,
        upper,
        smooth,
        closure,
        np.array([1e-6, 2e-6]),
    )


def by_daqp(problem: Problem) -> np.ndarray:
    """The solution of a quadratic problem, from dense matrices."""
    t = Transcription(problem)
    z0 = t.local(np.zeros(t.size))
    T = np.stack([t.local(e) - z0 for e in np.eye(t.size)], axis=2)
    still = t.smoothness(np.zeros(t.size))[1]
    H = np.stack([t.smoothness(e)[1] - still for e in np.eye(t.size)], axis=1)
    g = still.copy()
    A, low, high, equal = [], [], [], []
    for r in problem.rows:
        J = np.array(r.function(*(np.zeros((n, 1)) for n in (2, 2, 2, 2, 0))))
        assert not J.any()
        J = np.array([np.array(r.function(*np.split(e, 4), [])).ravel() for e in np.eye(8)]).T
        for k in range(len(problem.nodes)):
            row, at = J @ T[k], J @ z0[k]
            H += row.T @ (r.weight[k][:, None] * row)
            g += row.T @ (r.gain[k] + r.weight[k] * (at - r.target[k]))
            A.append(row)
            low.append(r.lower[k] - at)
            high.append(r.upper[k] - at)
            equal.append(r.equations[k])
    free = problem.u_active
    unknown = T[:, 6:][free]
    A, low, high = np.vstack([*A, unknown]), np.concatenate(low), np.concatenate(high)
    low, high = np.append(low, problem.u_lower[free]), np.append(high, problem.u_upper[free])
    sense = np.append(5 * np.concatenate(equal), np.zeros(len(unknown))).astype(np.int32)
    bounded = np.isfinite(low) | np.isfinite(high)
    low, high = np.maximum(low, -1e30), np.minimum(high, 1e30)
    A, low, high, sense = (np.ascontiguousarray(x[bounded]) for x in (A, low, high, sense))
    x, _, flag, _ = daqp.solve(H, g, A, high, low, sense)
    assert flag > 0
    return x


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("periodic", [False, True])
def test_a_quadratic_problem_has_the_solution_of_a_dense_solver(seed, periodic):
    problem = quadratic(seed, periodic=periodic)
    t = Transcription(problem)
    result = InteriorPoint(problem, FINE).solve(np.zeros((problem.basis.n_coefficients, 2)))
    assert result.status == "solved"
    expected = t.local(by_daqp(problem))
    found = t.local(t.join(result.c, result.u))
    np.testing.assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())
    assert result.u[2, 0] == 0.1


def test_the_least_force_from_rest_to_rest_falls_linearly():
    """The least squared force from 0 to 1 is 6 - 12 t."""
    problem = mass_on_a_line(41)
    result = InteriorPoint(problem, FINE).solve(np.zeros((43, 1)))
    assert result.status == "solved"
    q, _, force = problem.states(result.c, problem.nodes)
    t = problem.nodes
    np.testing.assert_allclose(force[2:-2, 0], (6.0 - 12.0 * t)[2:-2], atol=0.02)
    np.testing.assert_allclose(force[:, 0], 6.0 - 12.0 * t, atol=0.1)  # weighed half at the ends
    np.testing.assert_allclose(q[:, 0], 3 * t**2 - 2 * t**3, atol=1e-3)
    np.testing.assert_allclose(result.u, force, atol=1e-7)
    assert result.history[-1].objective == pytest.approx(40 * 6.0, rel=1e-2)  # half of 12, 40 steps


def test_a_limit_on_force_makes_it_bang_bang_at_the_ends():
    """With |f| ≤ 4.2 the way takes nearly the least time there is, 2 / sqrt(4.2) of 1 s."""
    problem = mass_on_a_line(41)
    limits = np.full((41, 1), 4.2)
    result = InteriorPoint(replace(problem, u_lower=-limits, u_upper=limits), FINE).solve(
        np.zeros((43, 1))
    )
    assert result.success
    f, t = result.u[:, 0], problem.nodes
    assert np.abs(f).max() <= 4.2 + 1e-8
    assert f[t < 0.3].min() > 4.15 and f[t > 0.7].max() < -4.15
    y, low, high = result.multipliers.rows["limits of unknowns"][:, :, 0]
    early, late = t < 0.3, t > 0.7
    assert (high[early] > 1e-3).all() and (low[early] < 1e-5).all()
    assert (low[late] > 1e-3).all() and (high[late] < 1e-5).all()
    np.testing.assert_allclose(y, high - low, atol=1e-6)  # pushes away from the limit


def test_a_multiplier_is_what_a_limit_costs():
    """The nearest place to 2 that is at most 1: dropping the limit a little gains as much."""
    n, nodes = 4, np.linspace(0.0, 1.0, 4)
    symbols = inputs(1)
    for sign in (1.0, -1.0):
        place = rows("place", symbols, symbols[0], n)
        place.weight[:], place.target[:] = 3.0, 2.0 * sign
        place.upper[:], place.lower[:] = (1.0, np.inf)[sign < 0], (-np.inf, -1.0)[sign < 0]
        problem = Problem(cubic(nodes), nodes, ("x",), (place,))
        result = InteriorPoint(problem, FINE).solve(np.zeros((6, 1)))
        assert result.success and result.u.shape == (4, 0)
        np.testing.assert_allclose(problem.states(result.c, nodes)[0], sign, atol=1e-6)
        y, low, high = result.multipliers.rows["place"][:, :, 0]
        pushing, other = (high, low) if sign > 0 else (low, high)
        np.testing.assert_allclose(pushing, 3.0, atol=1e-5)  # slope of 3/2 (x - 2)² at 1
        np.testing.assert_allclose(other, 0.0, atol=1e-8)
        np.testing.assert_allclose(y, 3.0 * sign, atol=1e-5)


@pytest.mark.parametrize("strength", [4.0, 12.0])
def test_a_pendulum_swings_up_as_ipopt_has_it(strength):
    """With 4 N m it must gain height by swinging; both solvers from one guess."""
    problem = pendulum(strength=strength)
    ours = InteriorPoint(problem, FINE).solve(*swing(problem))
    theirs = ipopt.solve(problem, *swing(problem))
    assert ours.status == "solved" and theirs.success
    assert ours.history[-1].objective == pytest.approx(theirs.objective, rel=1e-4)
    one, other = (problem.states(c, problem.nodes)[0] for c in (ours.c, theirs.c))
    np.testing.assert_allclose(one, other, atol=2e-2)
    if strength < 9.81:
        assert one.min() < -0.2  # it goes the other way first


def test_redundant_equations_are_solved_like_others():
    fine = replace(FINE, tolerance=1e-7)
    one = InteriorPoint(mass_on_a_line(), fine).solve(np.zeros((23, 1)))
    two = InteriorPoint(mass_on_a_line(twice=True), fine).solve(np.zeros((23, 1)))
    assert one.success and two.success
    np.testing.assert_allclose(two.c, one.c, atol=1e-6)


def contradictory() -> Problem:
    """The mass shall be right of 0.8 and left of 0.3 at one instant."""
    problem = mass_on_a_line()
    symbols = inputs(1, 1)
    side = rows("side", symbols, ca.vertcat(symbols[0], symbols[0]), 21)
    side.lower[10, 0], side.upper[10, 1] = 0.8, 0.3
    return replace(problem, rows=(*problem.rows, side))


def test_what_cannot_be_is_no_success_and_names_the_worst_row():
    problem = contradictory()
    result = InteriorPoint(problem, replace(FINE, iterations=60)).solve(np.zeros((23, 1)))
    assert not result.success
    last = result.history[-1]
    assert last.violation > 1e-3
    place = problem.states(result.c, problem.nodes[10:11])[0][0, 0]
    off = max(0.8 - place, place - 0.3)
    assert off >= 0.25 - 1e-9  # whichever way it goes
    assert last.worst.endswith(" s") and last.worst.split()[0] in ("side", "law", "state")
    assert np.isfinite(result.c).all() and np.isfinite(result.u).all()
    least = min(i.violation for i in result.history)  # it gives back the best it has seen
    assert violation(problem, result) <= 10 * least + 1e-12


def violation(problem: Problem, result) -> float:
    """The largest violation of a row by a result."""
    q, v, a = problem.states(result.c, problem.nodes)
    worst = 0.0
    for r in problem.rows:
        values = np.array(r.function.map(len(q))(q.T, v.T, a.T, result.u.T, r.parameters.T)).T
        worst = max(worst, float(np.max(np.maximum(r.lower - values, values - r.upper))))
    return worst


@pytest.mark.parametrize("answer", (True, False))
def test_a_nearly_feasible_point_is_shown_once_and_may_be_the_end(answer):
    shown = []

    def pause(c, u):
        shown.append((c.shape, u.shape))
        return answer

    problem = pendulum()
    c, u = swing(problem)
    result = InteriorPoint(problem).solve(c, u, pause=pause)
    assert shown == [(c.shape, u.shape)]
    assert (result.status == "paused") == answer and result.success != answer
    assert all(it.violation > 1e-3 for it in result.history[:-1]) or not answer


def test_progress_is_called_every_iteration_and_stops_at_the_best():
    problem, seen = pendulum(), []

    def stop(iterate) -> bool:
        seen.append(iterate)
        return iterate.number >= 6

    result = InteriorPoint(problem).solve(*swing(problem), progress=stop)
    assert result.status == "stopped" and not result.success
    assert [i.number for i in seen] == list(range(7)) and tuple(seen) == result.history
    least = min(i.violation for i in seen)
    assert violation(problem, result) == pytest.approx(least, abs=1e-6)


def test_ctrl_c_while_it_tells_stops_it():
    def interrupt(iterate) -> None:
        if iterate.number == 2:
            raise KeyboardInterrupt

    problem = pendulum()
    result = InteriorPoint(problem).solve(*swing(problem), progress=interrupt)
    assert result.status == "stopped" and len(result.history) == 3


def test_time_is_up():
    problem = pendulum()
    result = InteriorPoint(problem, Options(seconds=0.0)).solve(*swing(problem))
    assert result.status == "stopped" and len(result.history) == 1
    few = InteriorPoint(problem, Options(iterations=3)).solve(*swing(problem))
    assert few.status == "too many iterations" and len(few.history) == 4


def test_a_warm_start_takes_fewer_iterations():
    first = pendulum()
    cold = InteriorPoint(first).solve(*swing(first))
    other = pendulum(duration=4.05)
    again = InteriorPoint(other).solve(*swing(other))
    warm = InteriorPoint(other).solve(cold.c, cold.u, cold.multipliers)
    assert cold.success and again.success and warm.success
    assert len(warm.history) < len(again.history) / 2
    assert warm.history[-1].objective == pytest.approx(again.history[-1].objective, rel=1e-2)


def test_multipliers_on_other_nodes_push_as_much_per_time():
    rng = np.random.default_rng(0)
    before, after = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 41)
    values = 0.1 * np.ones((3, 11, 2)) * rng.uniform(1.0, 2.0, (3, 1, 2))
    moved = Multipliers({"law": values}).moved(before, after).rows["law"]
    assert moved.shape == (3, 41, 2)
    np.testing.assert_allclose(moved, values[:, :1] / 4 * np.ones((1, 41, 1)))
    same = Multipliers({"law": values}).moved(before, before.copy()).rows["law"]
    np.testing.assert_array_equal(same, values)


def test_a_recentred_step_is_the_newton_step_towards_other_products():
    problem = quadratic(3, periodic=False)
    limits = limits_of_unknowns(problem)
    assert limits is not None
    e = Evaluation(problem, (*problem.rows, limits))
    slacks = [Slacks(block) for block in e.blocks]
    kkt = KKTSystem(e, slacks, 1e-8)
    x = np.random.default_rng(3).normal(size=e.t.size)
    e.linearise(x)
    for s in slacks:
        s.start(0.01, 0.01, None)
    assert kkt.factorise(x)
    gaps = [s.gap(s.block.r, s.s) for s in slacks]
    changes = [np.where(s.limited, 0.04, 0.0) for s in slacks]
    found, expected = kkt.recentred(kkt.step(x, gaps, 0.01), changes), kkt.step(x, gaps, 0.05)
    np.testing.assert_allclose(found.x, expected.x, atol=1e-5)  # equations are kept to that
    for one, other in ((found.s, expected.s), (found.y, expected.y), (found.z, expected.z)):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-4)


def test_maps_of_equations_alone_are_those_of_all_rows_where_they_are_equations():
    problem = quadratic(3, periodic=False)
    limits = limits_of_unknowns(problem)
    assert limits is not None
    e = Evaluation(problem, (*problem.rows, limits))
    rng = np.random.default_rng(4)
    dx = rng.normal(size=e.t.size)
    e.linearise(dx)
    equations = [b.equations for b in e.blocks]
    assert any(each.any() for each in equations) and not all(each.all() for each in equations)
    some, every = e.push_forward(dx, equations=True), e.push_forward(dx)
    for own, a, b in zip(equations, some, every, strict=True):
        np.testing.assert_array_equal(a[own], b[own])
    weights = [np.where(own, rng.normal(size=own.shape), 0.0) for own in equations]
    np.testing.assert_allclose(
        e.pull_back(weights, equations=True), e.pull_back(weights), atol=1e-12
    )


def test_one_solver_solves_again():
    """Nothing of the first run is left in the second."""
    problem = pendulum()
    solver = InteriorPoint(problem)
    one = solver.solve(*swing(problem))
    solver.solve(np.zeros((43, 1)), progress=lambda i: i.number > 4)
    two = solver.solve(*swing(problem))
    np.testing.assert_array_equal(one.c, two.c)
    assert len(one.history) == len(two.history)


def test_a_guess_that_is_none_is_refused():
    problem = mass_on_a_line()
    with pytest.raises(ParameterError, match=r"\(5, 1\); this problem has \(23, 1\)"):
        InteriorPoint(problem).solve(np.zeros((5, 1)))
    with pytest.raises(ParameterError, match="finite"):
        InteriorPoint(problem).solve(np.full((23, 1), np.nan))
