import json

import numpy as np
import pytest

from plantigrade.analyze import norm, speed_class
from plantigrade.analyze.norms import SPEED_CLASSES, names
from plantigrade.errors import ParameterError


def test_signs_and_sizes_of_normal_walking():
    knee = norm("knee_angle_r")
    assert knee.unit == "deg" and 65 <= knee.percent[np.argmax(knee.mean)] <= 75
    assert 50 < np.ptp(knee.mean) < 65
    ankle = norm("ankle_angle_moment")  # plantarflexors, in late stance
    assert ankle.mean.min() < -1.0 and 40 < ankle.percent[np.argmin(ankle.mean)] < 55
    assert norm("hip_flexion_moment").mean[:10].min() < -0.4  # extensors take the load
    assert norm("knee_angle_moment").mean[4:8].min() < -0.2  # extensors hold the knee
    assert norm("ankle_power").mean.max() > 2.0
    assert norm("anterior_grf").mean[5] < 0 < norm("anterior_grf").mean[25]  # braking, then push
    assert norm("pelvis_tilt").mean.max() < 0  # leaning forward
    vertical = norm("vertical_grf").mean
    assert 1.0 < vertical.max() < 1.3 and np.abs(vertical[35:]).max() < 0.02


def test_every_curve_and_class():
    for name in names():
        for speed in SPEED_CLASSES:
            band = norm(name, speed)
            assert len(band.mean) == len(band.sd) == len(band.percent) == 51
            assert (band.sd >= 0).all()
    free, fast = (norm("ankle_power", s).mean.max() for s in ("free", "very_fast"))
    assert fast > free
    np.testing.assert_array_equal(
        norm("pelvis_list", side="l").mean, -norm("pelvis_list", side="r").mean
    )


def test_speed_classes():
    assert [speed_class(v, 0.9) for v in (0.4, 0.9, 1.25, 1.6, 2.1)] == list(SPEED_CLASSES)
    with pytest.raises(ParameterError, match="positive"):
        speed_class(1.0, 0.0)


def test_unknown_names():
    with pytest.raises(ParameterError, match="knee_angle"):
        norm("elbow")
    with pytest.raises(ParameterError, match="very_slow"):
        norm("knee_angle", "brisk")


def test_against_the_source(data):
    path = data / "normative" / "schwartz2008" / "Schwartz2008.json"
    table = json.loads(path.read_text())["Schwartz2008"]["Free"]["KneeAngles"]["X"]
    band = norm("knee_angle")
    for (percent, low, high), p, mean, sd in zip(
        table, band.percent, band.mean, band.sd, strict=True
    ):
        assert percent == p
        assert (low + high) / 2 == pytest.approx(mean, abs=0.051)
        assert (high - low) / 2 == pytest.approx(sd, abs=0.051)
