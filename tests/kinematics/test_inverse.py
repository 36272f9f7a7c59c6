"""Inverse kinematics: the bounded step against SciPy's, known poses, limits and gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from plantigrade.kinematics.inverse import InverseKinematics, bounded_step, track
from plantigrade.kinematics.state import PointSet, integrate
from plantigrade.models.landmarks import attachments
from tests.models.presets import PRESETS, person, random_state


@given(seed=st.integers(0, 10_000), n=st.integers(7, 24), wide=st.floats(0.01, 3.0))
@settings(max_examples=150, deadline=None)
def test_the_bounded_step_is_the_bounded_minimum(seed, n, wide):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n + 5, n))
    b = rng.normal(size=n + 5)
    low = -wide * rng.uniform(size=n - 6)
    high = wide * rng.uniform(size=n - 6)
    step = bounded_step(A.T @ A, A.T @ b, low, high)
    infinite = np.full(6, np.inf)
    theirs = lsq_linear(
        A, b, (np.concatenate([-infinite, low]), np.concatenate([infinite, high])), tol=1e-14
    )
    assert (step[6:] >= low - 1e-9).all() and (step[6:] <= high + 1e-9).all()
    cost = 0.5 * np.sum((A @ step - b) ** 2)
    assert cost <= theirs.cost + 1e-9
    np.testing.assert_allclose(step, theirs.x, atol=2e-5)


def test_a_step_on_a_closed_range_does_not_move():
    """Limits that meet (a hinge at its stop, no room) are obeyed."""
    H, g = np.eye(8), np.ones(8)
    step = bounded_step(H, g, np.array([0.0, -1.0]), np.array([0.0, 0.5]))
    np.testing.assert_allclose(step, [1, 1, 1, 1, 1, 1, 0, 0.5])


def where(points, qpos):
    """Where points are in one posture."""
    return points.path(qpos[None])[0]


def landmark_solver(human, every=1):
    places = attachments(human)
    names = list(places)[::every]
    points = PointSet(
        human, [places[n].body for n in names], np.array([places[n].position for n in names])
    )
    return points, InverseKinematics(points, tolerance=1e-9, max_iterations=300)


def gentle_state(human, rng):
    """A pose well inside the limits, turned any way about the vertical."""
    q, _ = random_state(human, rng)
    low, high = human.limits
    rest = human.standing()[7:]
    q[7:] = np.clip(rest + 0.25 * (q[7:] - rest), low + 0.01, high - 0.01)
    heading = rng.uniform(-np.pi, np.pi)
    q[3:7] = np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)
    return q


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_a_known_pose_is_found_again(preset):
    """From a start that stands at the right heading, without noise: to the millimetre."""
    human = person(*preset)
    points, solver = landmark_solver(human)
    solver.posture[:] = 1e-12
    rng = np.random.default_rng(0)
    for _ in range(3):
        q = gentle_state(human, rng)
        start = human.standing()
        start[:7] = q[:7]
        found = solver.solve(where(points, q), start)
        assert np.nanmax(found.residual) < 1e-3
        np.testing.assert_allclose(where(points, found.qpos), where(points, q), atol=1e-3)


def test_limits_hold_though_the_markers_ask_for_more():
    """Markers of a knee bent far backwards: the answer stays in range, at the limit."""
    human = person("42", "two-segment")
    points, solver = landmark_solver(human)
    knee = human.hinge("knee_angle_r")
    q = human.standing()
    q[7 + knee] = human.limits[0, knee] - 0.5
    found = solver.solve(where(points, q), human.standing())
    low, high = human.limits
    assert (found.qpos[7:] >= low).all() and (found.qpos[7:] <= high).all()
    assert found.qpos[7 + knee] == pytest.approx(low[knee], abs=1e-6)
    assert np.nanmax(found.residual) > 0.05


@given(seed=st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_limits_hold_for_any_markers(seed):
    human = person("42", "rigid")
    points, _ = landmark_solver(human)
    solver = InverseKinematics(points)
    rng = np.random.default_rng(seed)
    x = where(points, human.standing()) + 0.4 * rng.normal(size=(len(points.body), 3))
    found = solver.solve(x, human.standing())
    low, high = human.limits
    assert (found.qpos[7:] >= low).all() and (found.qpos[7:] <= high).all()
    assert np.linalg.norm(found.qpos[3:7]) == pytest.approx(1.0)


def test_it_is_a_minimum():
    """No nearby pose within the limits has a lower cost (checked by a general minimiser)."""
    human = person("42", "rigid")
    points, solver = landmark_solver(human, every=3)
    rng = np.random.default_rng(3)
    x = where(points, gentle_state(human, rng)) + 0.01 * rng.normal(size=(len(points.body), 3))
    start = human.standing()
    found = solver.solve(x, start)
    low, high = human.limits

    def cost(step):
        q = integrate(human.model, found.qpos, step)
        posture = q[7:] - solver.rest
        return float(np.sum((x - where(points, q)) ** 2) + solver.posture @ posture**2)

    bounds = [(-0.1, 0.1)] * 6 + list(zip(low - found.qpos[7:], high - found.qpos[7:], strict=True))
    best = minimize(cost, np.zeros(human.model.nv), method="L-BFGS-B", bounds=bounds)
    assert best.fun >= cost(np.zeros(human.model.nv)) * (1 - 1e-4)


def test_gaps_are_left_out_and_their_limbs_held_by_posture():
    human = person("42", "two-segment")
    points, solver = landmark_solver(human)
    q = gentle_state(human, np.random.default_rng(1))
    x = where(points, q)
    names = list(attachments(human))
    lost = [i for i, n in enumerate(names) if points.body[i] == human.body("hand_r")]
    x[lost] = np.nan
    start = human.standing()
    start[:7] = q[:7]
    found = solver.solve(x, start)
    assert np.isnan(found.residual[lost]).all()
    assert np.isfinite(found.qpos).all()
    seen = np.setdiff1d(np.arange(len(x)), lost)
    assert np.max(found.residual[seen]) < 0.01
    wrist = human.hinge("wrist_flex_r")
    assert found.qpos[7 + wrist] == pytest.approx(human.standing()[7 + wrist], abs=0.02)


def test_a_marker_without_one_of_its_coordinates_is_a_gap():
    human = person("42", "rigid")
    points, solver = landmark_solver(human)
    q = gentle_state(human, np.random.default_rng(6))
    x = where(points, q)
    x[3, 1] = np.nan
    start = human.standing()
    start[:7] = q[:7]
    found = solver.solve(x, start)
    assert np.isnan(found.residual[3])
    assert np.nanmax(found.residual) < 0.005


def test_no_marker_at_all_leaves_the_pose_where_it_was():
    human = person("42", "rigid")
    points, solver = landmark_solver(human)
    x = np.full((len(points.body), 3), np.nan)
    found = solver.solve(x, human.standing())
    np.testing.assert_allclose(found.qpos, human.standing(), atol=1e-6)


def test_weights_decide_between_markers_that_disagree():
    human = person("42", "rigid")
    local = np.array([[0.1, 0.0, 0.0], [0.1, 0.0, 0.0]])
    points = PointSet(human, ["pelvis", "pelvis"], local)
    x = where(points, human.standing())
    x[1] += [0.0, 0.0, 0.04]
    found = InverseKinematics(points, np.array([3.0, 1.0])).solve(x, human.standing())
    assert where(points, found.qpos)[0, 2] - x[0, 2] == pytest.approx(0.01, abs=1e-5)


def test_a_movement_is_tracked_through_a_full_turn_and_gaps():
    human = person("42", "two-segment")
    points, _ = landmark_solver(human)
    solver = InverseKinematics(points)
    n = 120
    time = np.linspace(0, 1.2, n)
    qpos = np.tile(human.standing(), (n, 1))
    heading = 2 * np.pi * time / 1.2
    qpos[:, 3], qpos[:, 6] = np.cos(heading / 2), np.sin(heading / 2)
    qpos[:, 7 + human.hinge("knee_angle_r")] = 0.6 - 0.5 * np.cos(5 * time)
    qpos[:, 7 + human.hinge("hip_flexion_l")] = 0.5 * np.sin(5 * time)
    x = points.path(qpos)
    rng = np.random.default_rng(0)
    x[rng.uniform(size=x.shape[:2]) < 0.2] = np.nan
    x[60:63] = np.nan  # nothing seen at all
    found, residual = track(solver, x, qpos[0])
    seen = np.isfinite(x[:, :, 0])
    assert np.isnan(residual[~seen]).all()
    assert np.nanpercentile(residual, 95) < 0.004
    knee = 7 + human.hinge("knee_angle_r")
    frames = np.r_[0:60, 63:n]
    assert np.abs(found[frames, knee] - qpos[frames, knee]).max() < np.deg2rad(2.0)


def test_a_hidden_arm_and_a_hidden_body_go_straight_from_where_they_were_to_where_they_are():
    """An elbow that bends evenly while nobody sees it is found bent evenly, frames gone or not."""
    human = person("42", "rigid")
    points, solver = landmark_solver(human)
    n, elbow = 40, 7 + human.hinge("elbow_flex_r")
    qpos = np.tile(human.standing(), (n, 1))
    qpos[:, elbow] = np.linspace(0.4, 1.6, n)
    qpos[:, 0] = np.linspace(0.0, 0.8, n)
    measured = points.path(qpos)
    below = points.moved[:, 0, 6 + human.hinge("elbow_flex_r")] > 0
    measured[15:25, below] = np.nan
    measured[30:33] = np.nan
    measured[33, 2:] = np.nan  # two points do not tell where a body is
    found, residual = track(solver, measured, qpos[0])
    np.testing.assert_allclose(found[:, elbow], qpos[:, elbow], atol=2e-3)
    np.testing.assert_allclose(found[:, 0], qpos[:, 0], atol=2e-3)
    assert np.isnan(residual[30:33]).all() and np.nanmax(residual) < 2e-3
