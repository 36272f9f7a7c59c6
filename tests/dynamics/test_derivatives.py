"""Velocities and accelerations of motions."""

import mujoco
import numpy as np
import pytest

from plantigrade.dynamics.derivatives import differentiate
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from tests.dynamics.movement import movement

HUMAN = Human.create(1.74, 71.0)


def test_closed_form_motion():
    t, qpos, qvel, qacc = movement(HUMAN)
    d = differentiate(HUMAN, t, qpos, None)
    inside = slice(5, -5)
    np.testing.assert_allclose(d.qvel[inside], qvel[inside], atol=1e-5)
    np.testing.assert_allclose(d.qacc[inside], qacc[inside], atol=2e-3)


def test_agrees_with_mujocos_tangent_space():
    t, qpos, *_ = movement(HUMAN, dt=0.002)
    d = differentiate(HUMAN, t, qpos, None)
    between = np.empty(HUMAN.model.nv)
    for f in (20, 100, 150):
        mujoco.mj_differentiatePos(HUMAN.model, between, 0.004, qpos[f - 1], qpos[f + 1])
        np.testing.assert_allclose(d.qvel[f], between, atol=3e-4)


def test_sign_of_the_quaternion_does_not_matter():
    t, qpos, *_ = movement(HUMAN)
    flipped = qpos.copy()
    flipped[::3, 3:7] *= -1
    a, b = (differentiate(HUMAN, t, q, 6.0) for q in (qpos, flipped))
    np.testing.assert_allclose(np.abs(a.qpos[:, 3:7]), np.abs(b.qpos[:, 3:7]), atol=1e-12)
    np.testing.assert_allclose(a.qacc, b.qacc, atol=1e-9)


def test_turning_the_world_turns_nothing_but_the_world():
    t, qpos, *_ = movement(HUMAN)
    rng = np.random.default_rng(1)
    qpos = qpos + 1e-3 * rng.normal(size=qpos.shape)
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    turned = qpos.copy()
    quat = np.array([0.5, -0.5, 0.5, 0.5])
    for f in range(len(turned)):
        mujoco.mju_mulQuat(turned[f, 3:7], quat, qpos[f, 3:7])
        mujoco.mju_rotVecQuat(turned[f, :3], qpos[f, :3], quat)
    a, b = (differentiate(HUMAN, t, q, 6.0) for q in (qpos, turned))
    np.testing.assert_allclose(a.qvel[:, 3:], b.qvel[:, 3:], atol=1e-8)
    np.testing.assert_allclose(a.qacc[:, 3:], b.qacc[:, 3:], atol=1e-6)


def test_filter_takes_noise_out_and_leaves_motion_and_its_ends():
    t, qpos, _, qacc = movement(HUMAN, n=401, dt=0.005)
    noisy = qpos.copy()
    noisy[:, 7:] += 1e-3 * np.random.default_rng(2).normal(size=noisy[:, 7:].shape)
    d = differentiate(HUMAN, t, noisy, 6.0)
    unfiltered = differentiate(HUMAN, t, noisy, None)
    error = np.sqrt(np.mean((d.qacc - qacc)[:, 6:] ** 2))
    assert error < 0.02 * np.sqrt(np.mean((unfiltered.qacc - qacc)[:, 6:] ** 2))
    # A reflection alone would take the acceleration of the first frame to nothing.
    d = differentiate(HUMAN, t, qpos, 6.0)
    end = np.linalg.norm((d.qacc - qacc)[[0, -1], 6:])
    assert end < 0.6 * np.linalg.norm(qacc[[0, -1], 6:])
    assert np.abs((d.qacc - qacc)[80:-80, 6:]).max() < 0.1 * np.abs(qacc[:, 6:]).max()


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_few_frames_of_steady_motion(n):
    t = 0.01 * np.arange(n)
    qpos = np.tile(HUMAN.standing(), (n, 1))
    qpos[:, 0] = 1.3 * t
    d = differentiate(HUMAN, t, qpos, None)
    np.testing.assert_allclose(d.qvel[:, 0], 1.3 if n > 1 else 0.0)
    np.testing.assert_allclose(d.qacc, 0.0, atol=1e-8)


def test_missing_values_are_refused():
    t, qpos, *_ = movement(HUMAN, n=20)
    qpos[7, 9] = np.nan
    with pytest.raises(ParameterError, match="frame 7"):
        differentiate(HUMAN, t, qpos, None)
    with pytest.raises(ParameterError, match="shape"):
        differentiate(HUMAN, t, qpos[:, :-1], None)
