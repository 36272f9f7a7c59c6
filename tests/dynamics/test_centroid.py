"""Centre of mass, momentum, zero-moment point, centre of pressure."""

import numpy as np

from plantigrade.dynamics.centroid import centroid, zero_moment_point
from plantigrade.models import Human
from tests.dynamics.movement import movement

HUMAN = Human.create(1.74, 71.0)
G = np.array([0.0, 0.0, -9.81])


def test_momentum_against_finite_differences():
    t, qpos, qvel, qacc = movement(HUMAN, dt=0.001)
    c = centroid(HUMAN, qpos, qvel, qacc)
    inside = slice(2, -2)
    d = lambda x: np.gradient(x, t, axis=0)[inside]  # noqa: E731
    np.testing.assert_allclose(d(c.com), c.com_vel[inside], atol=1e-5)
    force = HUMAN.mass * (d(c.com_vel) - G)
    np.testing.assert_allclose(force, c.force[inside], atol=0.02)
    np.testing.assert_allclose(d(c.angular_momentum), c.moment[inside], atol=0.02)


def test_without_accelerations_the_rest_is_the_same():
    _, qpos, qvel, qacc = movement(HUMAN, n=5)
    a, b = centroid(HUMAN, qpos, qvel), centroid(HUMAN, qpos, qvel, qacc)
    assert a.force is None and a.zmp is None
    np.testing.assert_allclose(a.com_vel, b.com_vel)
    np.testing.assert_allclose(a.angular_momentum, b.angular_momentum, atol=1e-12)


def test_standing_still_the_zero_moment_point_is_under_the_centre_of_mass():
    qpos, still = HUMAN.standing()[None], np.zeros((1, HUMAN.model.nv))
    c = centroid(HUMAN, qpos, still, still)
    np.testing.assert_allclose(c.zmp[0], [*c.com[0, :2], 0.0], atol=1e-12)


def test_sliding_pelvis_moves_it_as_the_inverted_pendulum_says():
    qpos, still = HUMAN.standing()[None], np.zeros((1, HUMAN.model.nv))
    push = still.copy()
    push[0, 0], push[0, 1] = 1.5, -0.7
    c = centroid(HUMAN, qpos, still, push, ground=0.1)
    expected = c.com[0, :2] - (c.com[0, 2] - 0.1) / 9.81 * push[0, :2]
    np.testing.assert_allclose(c.zmp[0, :2], expected, atol=1e-12)


def test_no_zero_moment_point_in_flight():
    qpos, still = HUMAN.standing()[None], np.zeros((1, HUMAN.model.nv))
    fall = still.copy()
    fall[0, 2] = -9.81
    assert np.isnan(centroid(HUMAN, qpos, still, fall).zmp).all()


def test_zero_moment_point_is_the_centre_of_pressure_of_the_same_wrench():
    rng = np.random.default_rng(0)
    force = rng.normal(size=(6, 4, 3)) * 20 + [0, 0, 200]
    point = rng.normal(size=(6, 4, 3)) * 0.3
    point[..., 2] = 0.0
    about = rng.normal(size=(6, 3))
    moment = np.cross(point - about[:, None], force).sum(axis=1)
    total = force.sum(axis=1)
    a = zero_moment_point(total, moment, about, 0.0, min_force=1.0)
    load = force[..., 2:]
    np.testing.assert_allclose(a, (load * point).sum(1) / load.sum(1), atol=1e-12)
