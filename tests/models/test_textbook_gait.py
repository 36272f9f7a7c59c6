import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.models.textbook_gait import textbook_gait

SPEEDS = [0.5, 1.0, 1.25, 1.6, 2.1]


def exact(speed, frames=100):
    """A walk sampled so that a stride is a whole, even number of frames."""
    stride_time = textbook_gait(speed, 0.9).stride_time
    return textbook_gait(speed, 0.9, rate=frames / stride_time, cycles=3)


@pytest.mark.parametrize("speed", SPEEDS)
def test_periodic_and_symmetric(speed):
    gait = exact(speed)
    assert len(gait.time) == 301
    for name, values in gait.coordinates.items():
        once, again = values[:200], values[100:300]
        travel = gait.stride_length if name == "pelvis_tx" else 0.0
        np.testing.assert_allclose(again - once, travel, atol=1e-9, err_msg=name)
        if name.endswith("_r"):
            left = gait.coordinates[f"{name[:-2]}_l"]
            np.testing.assert_allclose(left[50:250], values[:200], atol=1e-9, err_msg=name)
    for name, sign in (
        ("pelvis_tilt", 1),
        ("pelvis_list", -1),
        ("pelvis_rotation", -1),
        ("lumbar_extension", 1),
        ("lumbar_bending", -1),
        ("pelvis_tz", -1),
    ):
        values = gait.coordinates[name]
        np.testing.assert_allclose(values[50:250], sign * values[:200], atol=1e-9, err_msg=name)


def test_published_ranges_at_free_speed():
    c = {k: np.rad2deg(v) for k, v in exact(1.25).coordinates.items()}
    for name, low, high in (
        ("knee_angle_r", 54, 65),
        ("hip_flexion_r", 35, 48),
        ("ankle_angle_r", 25, 35),
        ("mtp_angle_r", 20, 40),
        ("pelvis_rotation", 5, 20),
        ("arm_flex_r", 20, 40),
    ):
        assert low <= np.ptp(c[name]) <= high, name
    assert c["knee_angle_r"].min() > -2
    # Arm against leg, trunk against pelvis.
    assert np.corrcoef(c["arm_flex_r"], c["hip_flexion_r"])[0, 1] < -0.5
    assert np.corrcoef(c["lumbar_rotation"], c["pelvis_rotation"])[0, 1] < -0.5


def test_events_and_stance():
    gait = exact(1.25)
    assert gait.heel_strikes["r"][0] == 0
    assert gait.heel_strikes["l"][0] == pytest.approx(gait.stride_time / 2)
    assert gait.stance("r")[:10].all() and not gait.stance("r")[70]
    assert (gait.stance("l") | gait.stance("r")).all()
    assert np.mean(gait.stance("r")[:100]) == pytest.approx(gait.foot_off, abs=0.011)
    assert gait.stride_length / gait.stride_time == pytest.approx(1.25)


def test_faster_is_longer_and_quicker():
    walks = [textbook_gait(v, 0.9) for v in SPEEDS]
    assert np.all(np.diff([w.stride_length for w in walks]) > 0)
    assert np.all(np.diff([w.cadence for w in walks]) > 0)
    assert np.all(np.diff([w.foot_off for w in walks]) < 0)


def test_bad_input():
    with pytest.raises(ParameterError, match="not a walking speed"):
        textbook_gait(4.0, 0.9)
    with pytest.raises(ParameterError, match="leg_length"):
        textbook_gait(1.0, 90.0)
