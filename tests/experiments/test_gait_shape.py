"""The shape of a gait against curves that are known: norms themselves, humps made by hand."""

import numpy as np
import pytest

from experiments.gait_shape import COMPARED_ANGLES, LEG, gait_shape, humps_of
from plantigrade.analyze import GaitCurves, agreement_with_norm, norms
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import PERCENT, Cycle

CYCLE = Cycle("r", 0.0, 1.0, toe_off=0.59, opposite_toe_off=0.1, opposite_heel_strike=0.5)


def normal_curves(speed_class="free", offset=0.0, **changes):
    """Return a gait whose curves are the norms, but for an offset of all angles."""

    def curve(name, more=0.0):
        band = norms.norm(name, speed_class)
        return np.interp(PERCENT, band.percent, band.mean)[None] + more

    angles = {n if n.startswith("pelvis") else f"{n}_r": curve(n, offset) for n in COMPARED_ANGLES}
    forces = {"up_r": curve("vertical_grf"), "forward_r": curve("anterior_grf")}
    powers = {"ankle_angle_r": curve("ankle_power")}
    tables = {"angles": angles, "moments": {}, "powers": powers, "forces": forces}
    return GaitCurves(PERCENT, (CYCLE,), **(tables | changes))


def test_norms_agree_with_themselves():
    shape = gait_shape(normal_curves())
    assert set(shape.agreement) == set(COMPARED_ANGLES)
    assert shape.rmse == pytest.approx(0.0, abs=1e-9)
    assert all(a.correlation == pytest.approx(1.0) for a in shape.agreement.values())


def test_an_offset_is_seen_raw_only():
    shape = gait_shape(normal_curves(offset=5.0))
    assert shape.rmse == pytest.approx(5.0)
    assert shape.rmse_offset_removed == pytest.approx(0.0, abs=1e-9)
    assert all(shape.agreement[n].correlation == pytest.approx(1.0) for n in LEG)


def test_children_at_free_speed_walk_as_textbooks_say():
    """Two humps around body weight, knee nearly straight in mid-stance, 60 degrees in swing."""
    shape = gait_shape(normal_curves())
    assert shape.humps is not None and shape.humps.two
    assert 1.0 < shape.humps.first < 1.3 and 1.0 < shape.humps.second < 1.3
    assert 0.6 < shape.humps.trough < 0.9
    assert shape.anterior[0] < -0.1 and shape.anterior[1] > 0.1
    assert shape.stance == pytest.approx(59.0)
    assert shape.knee_mid_stance < 20 and shape.knee_loading > shape.knee_mid_stance
    assert 52 < shape.knee_swing < 68
    assert shape.ankle_range >= 25 and shape.ankle_toe_off < 0 and shape.ankle_power > 1.5


def test_another_class_of_speed_is_further_away():
    slow = gait_shape(normal_curves("very_slow"), "free")
    assert slow.rmse > 2.0
    assert gait_shape(normal_curves("very_slow"), "very_slow").rmse < 1e-9


def test_one_row_per_cycle_is_averaged():
    curves = normal_curves()
    knee = curves.angles["knee_angle_r"]
    both = {**curves.angles, "knee_angle_r": np.vstack([knee + 3.0, knee - 3.0])}
    shape = gait_shape(normal_curves(angles=both))
    assert shape.agreement["knee_angle"].rmse == pytest.approx(0.0, abs=1e-9)


def test_without_forces_there_are_no_humps():
    shape = gait_shape(normal_curves(forces={}, powers={}))
    assert shape.humps is None and np.isnan(shape.anterior[0]) and np.isnan(shape.ankle_power)


def test_a_gait_without_a_cycle_is_refused():
    curves = normal_curves()
    without = GaitCurves(PERCENT, (), curves.angles, {}, {}, {})
    with pytest.raises(ParameterError, match="no complete gait cycle of the left foot"):
        gait_shape(without, side="l")


def test_humps_are_local_maxima():
    share = PERCENT / 60.0
    two = np.where(share < 1, np.sin(np.pi * share) + 0.35 * np.sin(3 * np.pi * share), 0.0)
    found = humps_of(PERCENT, two, 60.0)
    assert found.two and found.trough == pytest.approx(0.65, abs=1e-3)
    assert found.first == pytest.approx(found.second, abs=1e-6)
    one = np.where(share < 1, np.sin(np.pi * share), 0.0)
    found = humps_of(PERCENT, one, 60.0)
    assert not found.two and found.first == pytest.approx(1.0, abs=1e-2)


def test_a_ripple_is_no_hump():
    share = PERCENT / 60.0
    up = np.where(share < 1, np.minimum(2 * np.sin(np.pi * share), 1.0), 0.0)
    up = up + np.where((share > 0.3) & (share < 0.7), 0.002 * np.sin(20 * np.pi * share), 0.0)
    assert not humps_of(PERCENT, up, 60.0).two


def test_agreement_of_the_left_foot_mirrors_the_pelvis():
    band = norms.norm("pelvis_list", side="l")
    values = np.interp(PERCENT, band.percent, band.mean)
    assert agreement_with_norm(PERCENT, values, "pelvis_list", side="l").rmse < 1e-9
    assert agreement_with_norm(PERCENT, values, "pelvis_list", side="r").correlation < -0.99
