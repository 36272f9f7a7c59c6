"""Between what a solver moves and what rows see: linear maps against dense matrices."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.trajopt import Problem
from plantigrade.trajopt.transcription.linear_map import Transcription
from tests.trajopt.toys import cubic, shape

CASES = [
    (basis, turns, n)
    for basis in ("trigonometric", "polynomial")
    for turns, n in ((None, 4), (None, 11), ("mirror", 12), ("ring", 9), ("mirror", 5))
]


@pytest.fixture(params=CASES, ids=lambda c: f"{c[0]}-{c[1]}-{c[2]}")
def made(request):
    basis, turns, n = request.param
    return Transcription(shape(n, seed=n, basis=basis, turns=turns))


def maps(t: Transcription) -> tuple[np.ndarray, np.ndarray]:
    """The map of every node, column by column, (n_nodes, n_local, size), and what it adds."""
    d = t.local(np.zeros(t.size))
    return np.stack([t.local(e) - d for e in np.eye(t.size)], axis=2), d


def cost_of_steps_and_jerk(t: Transcription, x: np.ndarray) -> float:
    """Costs of steps of unknowns and of third derivatives, from the motion itself."""
    p = t.problem
    c, u = t.split(x)
    breaks = p.basis.breaks
    middle, width = (breaks[1:] + breaks[:-1]) / 2, np.diff(breaks)
    band = p.basis.band(middle, 3)
    third = np.einsum("ij,ijk->ik", band.values, p.continued(c, band.first[:, None] + np.arange(4)))
    total = 0.5 * np.sum(width[:, None] * p.jerk * third**2)
    if p.closure is not None:
        u = np.vstack([u, u[0, p.closure.u_source] * p.closure.u_sign])
    return float(total + 0.5 * np.sum(p.u_smooth * np.diff(u, axis=0) ** 2))


def test_rows_see_the_motion_of_the_problem(made):
    rng = np.random.default_rng(0)
    x = rng.normal(size=made.size)
    c, u = made.split(x)
    z = made.local(x)
    states = np.hstack(made.problem.states(c, made.problem.nodes))
    np.testing.assert_allclose(z[:, : 3 * made.nv], states, atol=1e-9 * np.abs(states).max())
    np.testing.assert_array_equal(z[:, 3 * made.nv :], u)


def test_velocity_and_acceleration_are_derivatives_of_the_motion(made):
    """Three-point differences of the coordinates beside inner nodes."""
    rng = np.random.default_rng(1)
    c, _ = made.split(rng.normal(size=made.size))
    t, h = made.problem.nodes[1:-1], 1e-4
    before, here, after = (made.problem.states(c, t + k * h)[0] for k in (-1, 0, 1))
    _, v, a = made.problem.states(c, t)
    np.testing.assert_allclose((after - before) / (2 * h), v, atol=1e-4 * np.abs(v).max())
    slack = 1e-2 * np.abs(a).max()
    np.testing.assert_allclose((after - 2 * here + before) / h**2, a, atol=slack)


def test_a_motion_that_goes_round_goes_on_as_its_closure_says():
    for turns in ("mirror", "ring"):
        p = shape(9, seed=3, basis="trigonometric", turns=turns)
        c = np.random.default_rng(3).normal(size=(p.basis.n_coefficients, 3))
        ends = np.array([p.basis.start, np.nextafter(p.basis.stop, 0.0)])
        for order, state in enumerate(p.states(c, ends)):
            k = p.closure
            on = state[0, k.source] * k.sign + (k.shift if order == 0 else 0.0)
            np.testing.assert_allclose(state[1], on, atol=1e-8 * max(1.0, np.abs(state).max()))


def test_join_and_split_are_inverse(made):
    rng = np.random.default_rng(2)
    x = rng.normal(size=made.size)
    c, u = made.split(x)
    np.testing.assert_array_equal(made.join(c, u), x)
    fixed = ~made.problem.u_active
    assert fixed.any() and not fixed.all()
    np.testing.assert_array_equal(u[fixed], made.problem.u_lower[fixed])
    free = made.problem.basis.n_coefficients * made.nv + int(made.problem.u_active.sum())
    assert made.size == free


def test_a_step_moves_what_the_map_says(made):
    T, _ = maps(made)
    dx = np.random.default_rng(4).normal(size=made.size)
    np.testing.assert_allclose(made.local_step(dx), T @ dx, atol=1e-9 * np.abs(T).max())


def test_the_gradient_is_the_adjoint_of_a_step(made):
    rng = np.random.default_rng(5)
    dx, g = rng.normal(size=made.size), rng.normal(size=(made.n_nodes, made.n_local))
    one, other = np.sum(g * made.local_step(dx)), made.gradient(g) @ dx
    assert one == pytest.approx(other, rel=1e-10)


def test_the_band_is_the_dense_matrix_and_no_wider_than_it(made):
    T, _ = maps(made)
    rng = np.random.default_rng(6)
    half = rng.normal(size=(made.n_nodes, made.n_local, made.n_local))
    H = half + half.transpose(0, 2, 1)
    dense = np.einsum("nia,nij,njb->ab", T, H, T)
    zero = np.zeros(made.size)
    still = made.smoothness(zero)[1]
    dense += np.stack([made.smoothness(e)[1] - still for e in np.eye(made.size)], axis=1)
    band = made.assemble((slice(k, k + 1), H[k : k + 1]) for k in range(made.n_nodes))
    assert band.shape == (made.half_band + 1, made.size)
    scale = 1e-12 * np.abs(dense).max()
    for i, diagonal in enumerate(band):
        np.testing.assert_allclose(diagonal[: made.size - i], np.diagonal(dense, -i), atol=scale)
        assert not diagonal[made.size - i :].any()
    reach = max(abs(i - j) for i, j in np.argwhere(np.abs(dense) > scale))
    assert reach == made.half_band


def test_steps_and_jerk_cost_what_the_motion_says(made):
    rng = np.random.default_rng(7)
    x, dx = rng.normal(size=(2, made.size))
    cost, gradient = made.smoothness(x)
    assert cost == pytest.approx(cost_of_steps_and_jerk(made, x), rel=1e-9)
    h = 1e-5  # quadratic: central differences are exact but for rounding
    slope = (
        cost_of_steps_and_jerk(made, x + h * dx) - cost_of_steps_and_jerk(made, x - h * dx)
    ) / (2 * h)
    assert gradient @ dx == pytest.approx(slope, rel=1e-6, abs=1e-6 * abs(cost))


def test_the_band_of_a_long_motion_is_no_wider_than_that_of_a_short_one():
    for turns in (None, "mirror"):
        widths = {
            Transcription(shape(n, seed=1, basis="polynomial", turns=turns)).half_band
            for n in (20, 40)
        }
        assert max(widths) - min(widths) <= 6  # free unknowns differ from node to node
        assert max(widths) < 45


def test_a_problem_without_unknowns_of_nodes():
    nodes = np.array([0.0, 0.2, 0.5, 0.6, 1.0])
    t = Transcription(Problem(cubic(nodes), nodes, ("x", "y"), ()))
    x = np.arange(float(t.size))
    c, u = t.split(x)
    assert u.shape == (5, 0) and t.size == c.size
    np.testing.assert_allclose(t.local(x), np.hstack(t.problem.states(c, nodes)), atol=1e-10)
    assert t.gradient(np.ones((5, 6))).shape == (t.size,)


def test_limits_of_unknowns_that_do_not_belong_together_are_refused():
    p = shape(6, seed=0, basis="polynomial", turns=None)
    with pytest.raises(ParameterError, match=r"u_smooth is \(6, 2\).*need \(5, 2\)"):
        replace(p, u_smooth=np.ones((6, 2)))
    crossed = p.u_upper.copy()
    crossed[4, 1] = p.u_lower[4, 1] - 1.0
    with pytest.raises(ParameterError, match=r"g at \d\.\d+ s must be at least .* and at most"):
        replace(p, u_upper=crossed)
