"""Cross-talk of a knee axis, and what takes it away."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from experiments.knee_axis import MAX_CROSS_TALK, Leg

N = 80


@pytest.fixture(params=["r", "l"])
def leg(request):
    """A leg that swings from the hip, rotates and bends its knee, and its knee centre."""
    phase = np.linspace(0, 2 * np.pi, N)[:, None]
    sign = 1 if request.param == "r" else -1
    swing = Rotation.from_euler("Y", -25 * np.sin(phase), degrees=True)
    thigh = swing * Rotation.from_euler("Z", sign * 8 * np.cos(phase), degrees=True)
    bend = Rotation.from_euler("Y", 30 - 30 * np.cos(phase), degrees=True)
    hip = np.zeros((N, 3))
    knee = thigh.apply([0, 0, -0.4])
    ankle = knee + (thigh * bend).apply([0, 0, -0.4])
    lateral = knee + thigh.apply([0, -sign * 0.05, 0])
    pelvis = np.broadcast_to(np.eye(3), (N, 3, 3))
    return Leg(pelvis, hip, ankle, lateral, request.param), knee, 8 * np.cos(phase)[:, 0]


def test_a_right_axis_has_no_cross_talk(leg):
    own, knee, rotation = leg
    found = own.thigh(knee)
    assert np.ptp(found.adduction) < 1e-6
    assert found.flexion.min() == pytest.approx(0.0, abs=1e-6)
    assert found.flexion.max() == pytest.approx(60.0, abs=0.1)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-6)


def test_a_turned_axis_is_found_and_turned_back(leg):
    own, knee, rotation = leg
    wrong = own.turned(knee, 20.0)
    found = own.thigh(wrong)
    assert abs(found.cross_talk) > 0.9 and np.ptp(found.adduction) > 5
    assert abs(np.mean(found.rotation - rotation)) > 10
    turn = own.least_adduction(wrong)
    assert turn == pytest.approx(-20.0, abs=0.1)
    corrected = own.thigh(own.turned(wrong, turn))
    assert np.ptp(corrected.adduction) < MAX_CROSS_TALK
    np.testing.assert_allclose(corrected.rotation, rotation, atol=0.2)


def test_turning_the_axis_changes_the_offset_and_not_the_course(leg):
    own, knee, rotation = leg
    found = own.thigh(own.turned(knee, 20.0))
    assert np.corrcoef(found.rotation, rotation)[0, 1] > 0.99
