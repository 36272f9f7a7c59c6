"""The minimum-jerk curve passes postures at their velocities."""

import numpy as np
from scipy.integrate import quad
from scipy.interpolate import BPoly

from plantigrade.kinematics.state import BodyState
from plantigrade.ordered_tasks.forces import curve_through, least_jerk_accelerations
from tests.models.presets import person

TIME = np.array([0.0, 0.12, 0.4, 0.55, 0.7])


def test_the_curve_passes_every_posture_at_its_velocity():
    human, rng = person("42", "two-segment"), np.random.default_rng(1)
    postures = np.tile(human.standing(), (5, 1))
    postures[:, 7:] += 0.2 * rng.normal(size=postures[:, 7:].shape)
    postures[:, 3:7] += 0.1 * rng.normal(size=(5, 4))
    postures[:, 3:7] /= np.linalg.norm(postures[:, 3:7], axis=1, keepdims=True)
    postures[2, 3:7] *= -1  # the same posture
    velocities = rng.normal(size=(5, human.model.nv))
    time, curve = curve_through(human, TIME, postures, velocities, interval=0.005)
    for t, posture, velocity in zip(TIME, postures, velocities, strict=True):
        k = int(np.argmin(np.abs(time - t)))
        assert abs(time[k] - t) < 1e-9
        there = BodyState(human, curve.qpos[k])
        np.testing.assert_allclose(there.difference(posture), 0.0, atol=1e-9)
        np.testing.assert_allclose(curve.qvel[k], velocity, atol=2e-2)


def test_a_motion_of_constant_acceleration_is_reproduced():
    value, rate = 1.5 * TIME[:, None] ** 2 - TIME[:, None], 3.0 * TIME[:, None] - 1.0
    np.testing.assert_allclose(least_jerk_accelerations(TIME, value, rate), 3.0, atol=1e-9)


def test_no_other_accelerations_give_less_jerk():
    rng = np.random.default_rng(2)
    value, rate = rng.normal(size=(5, 1)), rng.normal(size=(5, 1))
    best = least_jerk_accelerations(TIME, value, rate)

    def jerk(bend: np.ndarray) -> float:
        curve = BPoly.from_derivatives(TIME, np.stack([value, rate, bend], axis=1))
        third = curve.derivative(3)
        ends = zip(TIME[:-1].tolist(), TIME[1:].tolist(), strict=True)
        return sum(quad(lambda t: float(third(t)[0] ** 2), a, b)[0] for a, b in ends)

    least = jerk(best)
    for k in range(5):
        for step in (-1.0, 1.0):
            assert jerk(best + step * np.eye(5)[:, k : k + 1]) > least
