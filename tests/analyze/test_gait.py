import numpy as np
import pytest

from plantigrade.analyze import gait_measures
from plantigrade.motion import GaitEvent
from tests.motion.walkers import walker


@pytest.mark.parametrize("belt", [False, True])
@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_made_walker(belt, heading):
    time, heel, toe, _, truth = walker(
        speed=1.2, stride_time=1.1, stance=0.62, cycles=8, belt=belt, heading=heading
    )
    events = [GaitEvent(*row) for row in truth if 0 <= row[0] <= time[-1] - 0.3]
    m = gait_measures(time, heel, toe, events)
    assert m.treadmill is belt
    assert m.belt_speed == pytest.approx(1.2 * belt, abs=0.02)
    assert m.speed.mean == pytest.approx(1.2, rel=0.02)
    assert m.cadence.mean == pytest.approx(120 / 1.1, rel=1e-6)
    assert m.step_width.mean == pytest.approx(0.12, abs=0.005)
    assert m.double_support.mean == pytest.approx(24.0, abs=0.1)
    for side in "lr":
        assert m.stride_length[side].mean == pytest.approx(1.32, rel=0.02)
        assert m.step_length[side].mean == pytest.approx(0.66, rel=0.03)
        assert m.stance[side].mean == pytest.approx(62.0, abs=0.1)
    flat = m.metrics()
    assert flat["walking_speed_m_s"] == m.speed.mean
    assert ("belt_speed_m_s" in flat) is belt
    assert all(np.isfinite(v) for v in flat.values())


def test_nothing_known():
    m = gait_measures(np.arange(100) / 100, np.zeros((100, 2, 3)), np.ones((100, 2, 3)), ())
    assert np.isnan(m.speed.mean) and m.speed.count == 0
    assert "walking_speed_m_s" not in m.metrics()


def test_a_runner_flies():
    time, heel, toe, _, truth = walker(speed=3.5, stride_time=0.7, stance=0.36, cycles=8, runs=True)
    events = [GaitEvent(*row) for row in truth if 0 <= row[0] <= time[-1] - 0.3]
    m = gait_measures(time, heel, toe, events)
    assert m.running and not m.treadmill and m.double_support.count == 0
    flat = m.metrics()
    assert "walking_speed_m_s" not in flat and flat["running"] is True
    assert flat["running_speed_m_s"] == pytest.approx(3.5, rel=0.02)
    for side in "lr":
        assert flat[f"contact_time_{side}_s"] == pytest.approx(0.36 * 0.7)
        assert flat[f"flight_time_{side}_s"] == pytest.approx(0.14 * 0.7)
        assert flat[f"duty_factor_{side}_ratio"] == pytest.approx(0.36)


def test_feet_that_seem_to_share_a_velocity_are_no_treadmill():
    """A runner's feet roll on through their short stances, at 0.3 m/s here."""
    time, heel, toe, _, truth = walker(speed=3.5, stride_time=0.7, stance=0.36, cycles=8, runs=True)
    roll = np.stack([0.3 * time, 0 * time, 0 * time], axis=1)[:, None]
    m = gait_measures(time, heel + roll, toe + roll, [GaitEvent(*row) for row in truth])
    assert not m.treadmill and m.speed.mean == pytest.approx(3.8, rel=0.02)
