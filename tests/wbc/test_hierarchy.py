"""Strict priorities: what a lower level may never do, and what is left where a level cannot be met.

Three yardsticks, none of which shares a line with the solver. The definition: the residuals of the
first levels do not depend on the levels below. The null-space formula of the paper (its Eq. 8),
with pseudo-inverses. And the optimality conditions of each level: what is left of its gradient
must be held by rows above, each pushing the way it can, found by non-negative least squares.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, nnls

from plantigrade.errors import ParameterError
from plantigrade.wbc import Level, solve_hierarchy

STRICT = 1e-6  # a lower level changes a higher level's residual by no more than this …
OPTIMAL = 1e-4  # … and each level's gradient vanishes to this, both for rows of size one


def wide(n, size=1e4):
    return {"lower": np.full(n, -float(size)), "upper": np.full(n, float(size))}


def size_of(level):
    return max(1.0, np.abs(level.matrix).max(initial=0.0))


def null_space_formula(levels, preferred):
    """Each task in the null space of all above it (Eq. 8, repeated), the preference in the rest."""
    n = len(preferred)
    x, projector = np.zeros(n), np.eye(n)
    for level in levels:
        J, e = level.matrix, level.lower
        gain = max(np.linalg.norm(J @ projector, 2), 1e-300)
        least = 1e-9 * np.linalg.norm(J) / gain  # what is left of a row that is held is rounding
        inside = np.linalg.pinv(J @ projector, rcond=least) if least < 1 else np.zeros(J.T.shape)
        x = x + projector @ inside @ (e - J @ x)
        projector = projector @ (np.eye(n) - inside @ (J @ projector))
    return x + projector @ (preferred - x)


def gradients_left(levels, lower, upper, x):
    """Return the rest of each level's gradient when all rows above push as they may [size of x].

    A level of least-squares violation :math:`r` is optimal when :math:`A^T r + C^T m = 0` with
    :math:`m \\ge 0` for the rows :math:`C` above that are at their limits (a row that had to be
    violated is at the limit it reached, and an equation pushes both ways).
    """
    pushes, left = [], []

    def at_limits(A, low, high):
        value, near = A @ x, 1e-6 * max(1.0, np.abs(x).max())
        length = np.linalg.norm(A, axis=1)
        there = length > 0
        A, value, length = A[there], value[there], length[there]
        up = value >= np.maximum(high[there], value) - near * length
        down = value <= np.minimum(low[there], value) + near * length
        pushes.extend((A[up] / length[up][:, None], -A[down] / length[down][:, None]))

    at_limits(np.eye(len(x)), lower, upper)
    for level in levels:
        scale = size_of(level)
        gradient = level.matrix.T @ level.residual(x) / scale**2
        C = np.vstack(pushes)
        left.append(nnls(C.T, -gradient, maxiter=100 + 50 * len(C))[1] if len(C) else gradient)
        # A violated row is held where it is: its limit has moved there.
        value = level.matrix @ x
        at_limits(level.matrix, np.minimum(level.lower, value), np.maximum(level.upper, value))
    return [float(np.linalg.norm(g)) for g in left]


@st.composite
def hierarchies(draw, inequalities=True, dependent=True):
    """One to four levels of any scale; rows may be zero, repeated, or contradict one another."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(2, 12))
    levels = []
    for _ in range(draw(st.integers(1, 4))):
        m = draw(st.integers(1, n))
        A, b = rng.normal(size=(m, n)), rng.normal(size=m)
        fault = draw(st.sampled_from(["none", "none", "repeat", "zero", "above", "contradict"]))
        if fault in ("repeat", "contradict") and m > 1:
            A[-1], b[-1] = A[0], b[0] + (fault == "contradict")
        if fault == "zero":
            A[0] = 0.0
        if fault == "above" and levels:
            A[0] = levels[-1].matrix[0] / max(1e-9, np.abs(levels[-1].matrix).max())
        scale = 10.0 ** draw(st.integers(-1, 3))
        low, high = scale * b, scale * b
        if inequalities:
            kind = rng.integers(0, 4, size=m)
            if not dependent:
                A += np.where(kind == 0, 0.0, 1.0)[:, None] * rng.normal(size=A.shape)
            low = np.where(kind == 1, -np.inf, low)
            high = np.where(kind == 2, np.inf, high + np.where(kind == 3, scale, 0.0))
        levels.append(Level(scale * A, low, high))
    return levels, draw(st.sampled_from([0.3, 2.0, 1e4]))


def assert_strict(levels, bounds, **options):
    whole = solve_hierarchy(levels, **bounds, **options)
    for k in range(1, len(levels)):
        alone = solve_hierarchy(levels[:k], **bounds, **options)
        for j in range(k):
            change = abs(whole.residuals[j] - alone.residuals[j])
            assert change <= STRICT * size_of(levels[j]), (j, k, change)
    return whole


@settings(max_examples=200, deadline=None)
@given(hierarchies())
def test_lower_levels_never_change_higher_residuals(problem):
    levels, size = problem
    whole = assert_strict(levels, wide(levels[0].matrix.shape[1], size))
    assert np.isfinite(whole.x).all()
    assert (np.abs(whole.x) <= size * (1 + 1e-6)).all()


@settings(max_examples=200, deadline=None)
@given(hierarchies(dependent=False))
def test_each_level_is_met_as_well_as_the_ones_above_allow(problem):
    levels, size = problem
    bounds = wide(levels[0].matrix.shape[1], size)
    solution = solve_hierarchy(levels, **bounds)
    for left in gradients_left(levels, **bounds, x=solution.x):
        assert left <= OPTIMAL * max(1.0, np.abs(solution.x).max())


@settings(max_examples=100, deadline=None)
@given(hierarchies(inequalities=False), st.integers(0, 2**32 - 1))
def test_equations_alone_give_the_null_space_formula(problem, seed):
    levels, _ = problem
    n = levels[0].matrix.shape[1]
    preferred = np.random.default_rng(seed).normal(size=n)
    solution = solve_hierarchy(levels, **wide(n, 1e9), preferred=preferred)
    expected = null_space_formula(levels, preferred)
    assert solution.exact and solution.iterations == 0
    np.testing.assert_allclose(solution.x, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("seed", [0, 3, 21])
def test_an_inequality_that_is_also_an_equation(seed):
    """Above the level that is missed: the solver stopped short of what it could reach."""
    rng = np.random.default_rng(seed)
    A, y = 100 * rng.normal(size=(8, 11)), 100 * rng.normal(size=8)
    A[-1], y[-1] = A[0], y[0]
    low, high = y.copy(), y + [100, np.inf, 100, 0, 100, 100, 0, 0]
    low[3] = -np.inf
    others = [Level.equation(rng.normal(size=(1, 11)), rng.normal(size=1)) for _ in range(2)]
    assert_strict([Level(A, low, high), *others], wide(11, 0.3))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_contradicting_rows_of_one_level_meet_in_the_middle(scale):
    level = Level.equation(scale * np.array([[1.0, 0.0], [1.0, 0.0]]), scale * np.array([1.0, 3.0]))
    below = Level.equation(np.array([[1.0, 1.0]]), np.array([7.0]))
    solution = solve_hierarchy([level, below], **wide(2), singular=1e-9)
    np.testing.assert_allclose(solution.x, [2.0, 5.0], atol=1e-9)
    assert solution.residuals[0] == pytest.approx(scale * 2**0.5)


def test_a_row_repeated_below_is_harmless_and_one_contradicted_below_is_lost():
    row = np.array([[1.0, 2.0, 3.0]])
    other = np.array([[0.0, 1.0, 0.0]])
    first = Level.equation(row, np.array([1.0]))
    again = Level.equation(np.vstack([row, other]), np.array([5.0, 2.0]))
    solution = solve_hierarchy([first, again], **wide(3))
    assert solution.residuals == pytest.approx((0.0, 4.0), abs=1e-12)
    assert (other @ solution.x).item() == pytest.approx(2.0, abs=1e-12)
    assert solution.ranks == (1, 1)


def test_a_nearly_singular_direction_is_left_to_the_levels_below():
    """A straight knee: what a task cannot move it does not ask for by moving everything else."""
    task = Level.equation(np.array([[1.0, 0.0], [0.0, 1e-3]]), np.array([1.0, 1.0]))
    below = Level.equation(np.array([[0.0, 1.0]]), np.array([0.25]))
    solution = solve_hierarchy([task, below], **wide(2, 1e6), singular=0.05)
    np.testing.assert_allclose(solution.x, [1.0, 0.25], atol=1e-9)
    exact = solve_hierarchy([task, below], **wide(2, 1e6))
    np.testing.assert_allclose(exact.x, [1.0, 1000.0], atol=1e-6)


def test_bounds_stand_above_all_levels():
    ask = Level.equation(np.eye(3), np.array([5.0, -5.0, 0.5]))
    lower, upper = np.array([-1.0, -2.0, -3.0]), np.array([1.0, 2.0, 3.0])
    solution = solve_hierarchy([ask], lower=lower, upper=upper)
    np.testing.assert_allclose(solution.x, [1.0, -2.0, 0.5], atol=1e-7)


def test_one_level_in_a_box_is_bounded_least_squares():
    rng = np.random.default_rng(2)
    for _ in range(10):
        A, b = 100.0 * rng.normal(size=(15, 8)), 100.0 * rng.normal(size=15)
        expected = lsq_linear(A, b, (-0.1, 0.1), method="bvls", tol=1e-14).x
        solution = solve_hierarchy([Level.equation(A, b)], **wide(8, 0.1))
        np.testing.assert_allclose(solution.x, expected, atol=1e-6)


@pytest.mark.parametrize("above", [0, 1, 2])
def test_inequalities_that_exclude_each_other_share_the_miss(above):
    """x >= 1 and x <= -1, at any level: as near to both as can be, and nothing above is touched."""
    n = 4
    impossible = Level(
        np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0]]),
        np.array([1.0, -np.inf]),
        np.array([np.inf, -1.0]),
    )
    others = [Level.equation(np.eye(n)[k : k + 1], np.array([float(k)])) for k in (1, 2, 3)]
    levels = [*others[:above], impossible, *others[above:]]
    solution = solve_hierarchy(levels, **wide(n))
    np.testing.assert_allclose(solution.x, [0.0, 1.0, 2.0, 3.0], atol=1e-6)
    assert solution.residuals[above] == pytest.approx(2**0.5, abs=1e-6)


def test_an_inequality_above_binds_and_one_below_yields():
    ask = Level.equation(np.array([[1.0, 1.0]]), np.array([4.0]))
    cap = Level(np.eye(2), np.full(2, -np.inf), np.full(2, 1.0))
    above = solve_hierarchy([cap, ask], **wide(2))
    np.testing.assert_allclose(above.x, [1.0, 1.0], atol=1e-7)
    below = solve_hierarchy([ask, cap], **wide(2))
    np.testing.assert_allclose(below.x, [2.0, 2.0], atol=1e-6)
    assert above.residuals == pytest.approx((0.0, 2.0), abs=1e-6)
    assert below.residuals == pytest.approx((0.0, 2**0.5), abs=1e-6)


def test_the_freedom_that_is_left_goes_to_the_preference_in_its_metric():
    """Where an impact leaves freedom, the velocity changes by an impulse of the rows alone."""
    rng = np.random.default_rng(4)
    root = rng.normal(size=(6, 6))
    M, J, before = root @ root.T + np.eye(6), rng.normal(size=(2, 6)), rng.normal(size=6)
    stop = Level.equation(J, np.zeros(2))
    after = solve_hierarchy([stop], **wide(6), preferred=before, metric=M).x
    impulse = -np.linalg.solve(J @ np.linalg.solve(M, J.T), J @ before)
    np.testing.assert_allclose(after, before + np.linalg.solve(M, J.T @ impulse), atol=1e-9)
    bent = solve_hierarchy([stop], **wide(6, 0.2), preferred=before, metric=M)
    assert not bent.exact
    assert np.abs(J @ bent.x).max() < 1e-6
    other = lsq_linear(
        np.vstack([1e5 * J, np.linalg.cholesky(M).T]),
        np.concatenate([np.zeros(2), np.linalg.cholesky(M).T @ before]),
        (-0.2, 0.2),
        method="bvls",
        tol=1e-14,
    ).x
    np.testing.assert_allclose(bent.x, other, atol=1e-5)


def test_violations_of_one_level_weigh_alike_in_any_metric():
    """Bounds stop a task half-way: where it stops is least squares in its rows alone."""
    M = np.diag([1.0, 100.0])
    levels = [Level.equation(np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), np.full(3, 5.0))]
    plain = solve_hierarchy(levels, **wide(2, 1.0))
    weighed = solve_hierarchy(levels, **wide(2, 1.0), metric=M)
    np.testing.assert_allclose(weighed.x, plain.x, atol=1e-6)
    caps = [Level(np.array([[1.0, 0.0], [1.0, 2.0]]), np.full(2, -np.inf), np.array([-9.0, -9.0]))]
    box = {"lower": np.full(2, -1.0), "upper": np.full(2, 1.0)}
    for metric in (None, M):
        solution = solve_hierarchy(caps, **box, metric=metric)
        np.testing.assert_allclose(solution.x, [-1.0, -1.0], atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_levels_that_can_all_be_met_leave_the_preference_to_the_last_digit(seed):
    """Only equations and active bounds push a value off its preference."""
    rng = np.random.default_rng(seed)
    n, (m, k) = 10, rng.integers(1, 5, size=2)
    inside, size = rng.uniform(-0.8, 0.8, size=n), 1.0
    first, second, cap = (rng.normal(size=(rows, n)) for rows in (m, 2, k))
    room = rng.uniform(0.0, 0.3, size=k)
    levels = [
        Level(cap, np.full(k, -np.inf), cap @ inside + room),
        Level.equation(np.vstack([first, first[:1]]), np.append(first @ inside, first[0] @ inside)),
        Level.equation(second, second @ inside),
    ]
    preferred = rng.normal(size=n) * 3.0
    x = solve_hierarchy(levels, **wide(n, size), preferred=preferred).x
    assert max(np.abs(level.residual(x)).max() for level in levels) < 1e-9
    assert np.abs(x).max() < size + 1e-9
    reached = [sign * np.eye(n)[sign * x > size - 1e-9] for sign in (1.0, -1.0)]
    reached.append(cap[cap @ x > levels[0].upper - 1e-9])
    pushes = np.vstack([*reached, first, -first, second, -second])
    assert nnls(pushes.T, preferred - x, maxiter=1000)[1] < 1e-9


def test_no_level_at_all_is_the_preference_within_the_bounds():
    solution = solve_hierarchy([], **wide(3, 1.0), preferred=np.array([0.5, 2.0, -3.0]))
    np.testing.assert_allclose(solution.x, [0.5, 1.0, -1.0], atol=1e-7)


@pytest.mark.parametrize(
    ("level", "message"),
    [
        (Level(np.zeros((2, 3)), np.zeros(2), np.zeros(2), "heel"), "heel has a matrix of shape"),
        (Level(np.full((1, 2), np.nan), np.zeros(1), np.zeros(1)), "level 0 holds a value"),
        (Level(np.zeros((1, 2)), np.array([np.nan]), np.zeros(1)), "level 0 holds a value"),
        (Level(np.zeros((1, 2)), np.ones(1), np.zeros(1)), "lower bound above its upper"),
    ],
)
def test_bad_levels_are_named(level, message):
    with pytest.raises(ParameterError, match=message):
        solve_hierarchy([level], **wide(2))


def test_crossed_bounds_are_refused():
    with pytest.raises(ParameterError, match="not crossed"):
        solve_hierarchy([], lower=np.ones(2), upper=np.zeros(2))
