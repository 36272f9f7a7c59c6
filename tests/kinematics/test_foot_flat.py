"""From heel strike to the whole foot on the ground: a forefoot that falls at a known time."""

import numpy as np
import pytest

from plantigrade.kinematics.contacts import DOWN_HEIGHT, foot_flat_time

TIME = np.arange(0.0, 1.0, 0.01)
SPEED = 0.5  # of the falling forefoot [m/s]


def falling(lands: float, level: float = 0.0) -> np.ndarray:
    """Height of a forefoot that lands at a time [s] and stays at a level [m]."""
    return level + np.clip(SPEED * (lands - TIME), 0.0, None)


@pytest.mark.parametrize("level", [0.0, -0.006, 0.01])
def test_it_is_when_the_forefoot_is_near_its_level(level):
    """Soles that sink or hover by some millimetres change nothing."""
    found = foot_flat_time(TIME, falling(0.3, level), [0.2])
    assert found == pytest.approx(0.1 - DOWN_HEIGHT / SPEED, abs=1e-9)


def test_it_is_the_mean_over_strikes_and_zero_for_a_foot_put_down_flat():
    height = falling(0.3)
    flat = 0.5 * (0.1 - DOWN_HEIGHT / SPEED)
    assert foot_flat_time(TIME, height, [0.2, 0.5]) == pytest.approx(flat, abs=1e-9)


def test_a_stance_that_is_not_seen_is_left_out():
    assert np.isnan(foot_flat_time(TIME, falling(0.3), [-0.1, 0.9]))
    assert np.isnan(foot_flat_time(TIME, falling(0.3), []))
