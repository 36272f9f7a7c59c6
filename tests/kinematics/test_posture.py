"""A fitted body stands as its person stands: pelvis, lumbar joint, trunk, head, arms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.posture import lean_figures, leans, posture_figures
from plantigrade.models import Human
from plantigrade.models.anatomy import SPINE_PLANE, hip, lumbar, usual_lumbar_depth
from plantigrade.motion import Markers
from plantigrade.spatial.conventions import xyzw_to_wxyz
from plantigrade.workflows.fit import fit_trial
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker

TILT = 14.0  # forward, of the model's pelvis [deg]


def tilted(tilt: float = TILT, *, still: bool = False):
    """A walker, or somebody standing, whose pelvis tilts forward below an upright trunk."""
    human, time, qpos = walker()
    if still:
        qpos = np.tile(human.standing(), (20, 1))
        time = time[:20]
    lean = np.deg2rad(tilt)
    for name in ("hip_flexion_r", "hip_flexion_l", "lumbar_extension"):
        qpos[:, 7 + human.hinge(name)] += lean
    half = lean / 2
    qpos[:, 3:7] = [np.cos(half), 0, np.sin(half), 0]
    return human, time, qpos


@pytest.fixture(scope="module")
def fitted():
    """Somebody with a tilted pelvis, with a standing trial."""
    human, time, qpos = tilted()
    static = recording(markers_of(*tilted(still=True)))
    return human, qpos, fit_markers(recording(markers_of(human, time, qpos)), static=static)


def test_a_standing_trial_does_not_straighten_the_pelvis(fitted):
    human, qpos, fit = fitted
    assert fit.metrics["pelvis_tilt_plane_mean_deg"] == pytest.approx(TILT + SPINE_PLANE, abs=1.5)
    for side in "rl":
        i = 7 + human.hinge(f"hip_flexion_{side}")
        assert np.rad2deg(np.mean(fit.qpos[:, i] - qpos[:, i])) == pytest.approx(0, abs=2.5), side


def test_the_trunk_above_it_stands(fitted):
    _, _, fit = fitted
    assert abs(fit.metrics["trunk_lean_standing_deg"]) < 3
    assert abs(fit.metrics["neck_lean_mean_deg"]) < 5
    usual = usual_lumbar_depth(fit.human.dimensions)
    assert fit.human.dimensions.lumbar_depth == pytest.approx(usual, abs=0.015)
    assert 20 < fit.metrics["lumbar_behind_hips_mm"] < 70


def test_a_pelvis_without_posterior_markers_is_noted(fitted):
    human, time, qpos = tilted()
    assert not any("back of the pelvis" in w for w in fitted[2].warnings)
    bare = [n for n in NAMES if n not in ("LPSI", "RPSI")]
    fit = fit_markers(recording(markers_of(human, time, qpos, names=bare)))
    assert any("back of the pelvis" in w for w in fit.warnings)


def renamed(names: dict[str, str]):
    """Fit the tilted walker with other names for some markers."""
    whole = markers_of(*tilted())
    return fit_markers(recording(replace(whole, names=tuple(names.get(n, n) for n in whole.names))))


def test_markers_on_a_belt_show_the_pelvis(fitted):
    """Names of the CMU data base: the tilt is that of the spines, and the belt is said."""
    waist = {"LASI": "LFWT", "RASI": "RFWT", "LPSI": "LBWT", "RPSI": "RBWT"}
    fit = renamed({n: waist.get(n, n) for n in NAMES})
    tilt, spines = (f.metrics["pelvis_tilt_plane_mean_deg"] for f in (fit, fitted[2]))
    assert tilt == pytest.approx(spines, abs=1.5)
    assert any("on a belt" in w for w in fit.warnings)
    assert not any("unknown names" in w for w in fit.warnings)


def test_a_pelvis_without_known_markers_is_the_first_note():
    fit = renamed({"LASI": "X1", "RASI": "X2", "LPSI": "X3", "RPSI": "X4", "SACR": "X5"})
    assert "no marker has the name of a landmark of the pelvis" in fit.warnings[0]
    assert len(fit.warnings[0]) < 400


def test_a_slanting_head_band_does_not_bend_the_neck():
    """Seven centimetres higher in front than behind is 25 degrees of the band."""
    human, time, qpos = walker()
    markers = markers_of(human, time, qpos)
    x = markers.positions.copy()
    for names, rise in ((("LFHD", "RFHD"), 0.035), (("LBHD", "RBHD"), -0.035)):
        x[:, [NAMES.index(n) for n in names]] += [0, 0, rise]
    fit = fit_markers(recording(Markers(markers.names, time, x)))
    neck = fit.qpos[:, 7 + human.hinge("neck_extension")]
    assert abs(np.rad2deg(neck.mean())) < 3


@pytest.mark.parametrize("degrees", [-20.0, 35.0])
def test_leans_of_a_known_posture(degrees):
    """Where the pelvis faces counts, not where the laboratory's axes point."""
    human = Human.create(1.7, 65.0)
    qpos = np.tile(human.standing(), (3, 1))
    qpos[:, 7 + human.hinge("lumbar_extension")] = -np.deg2rad(degrees)
    for heading in (0.0, 1.2, 3.0):
        qpos[:, 3:7] = [np.cos(heading / 2), 0, 0, np.sin(heading / 2)]
        np.testing.assert_allclose(leans(human, qpos, "c7")[:, 0], degrees, atol=1e-9)
        np.testing.assert_allclose(leans(human, qpos, "asis_r"), 0.0, atol=1e-9)


def test_who_waddles_leans_to_the_sides_and_not_ahead():
    human = Human.create(1.7, 65.0)
    qpos = np.tile(human.standing(), (40, 1))
    roll = np.deg2rad(8.0) * np.sin(np.linspace(0.0, 2 * np.pi, 41)[:-1])
    qpos[:, 3], qpos[:, 4] = np.cos(roll / 2), -np.sin(roll / 2)  # positive: to the left
    np.testing.assert_allclose(leans(human, qpos, "c7")[:, 1], np.rad2deg(roll), atol=1e-9)
    figures = lean_figures(human, qpos)
    assert figures["trunk_sideways_rms_deg"] == pytest.approx(8.0 / np.sqrt(2.0))
    assert figures["neck_sideways_rms_deg"] == pytest.approx(8.0 / np.sqrt(2.0))
    assert figures["trunk_lean_mean_deg"] == pytest.approx(0.0, abs=1e-9)
    lies = human.standing()[None].copy()
    back, side = np.deg2rad(88.0), np.deg2rad(3.0)  # nearly on the back, a little to the left
    turn = Rotation.from_euler("xy", [-side, -back]).as_quat()
    lies[0, 3:7] = xyzw_to_wxyz(turn)
    assert abs(leans(human, lies, "c7")[0, 1]) < 4.0


def test_an_arm_at_its_stop_is_counted():
    human, _, qpos = walker(40)
    assert posture_figures(human, qpos)["arms_at_stop_pct"] == 0
    qpos[:10, 7 + human.hinge("elbow_flex_l")] = human.limits[0][human.hinge("elbow_flex_l")]
    assert posture_figures(human, qpos)["arms_at_stop_pct"] == pytest.approx(25)


def test_the_lumbar_joint_is_behind_the_hips_as_published():
    """Dumas and Wojtusch 2018: 20 % (women) to 24 % (men) of the pelvic width, in the plane."""
    d = Human.create(1.75, 70.0).dimensions
    at = lumbar(replace(d, lumbar_depth=usual_lumbar_depth(d))) - hip(d)
    plane = np.deg2rad(SPINE_PLANE)
    behind = -(at[0] * np.cos(plane) - at[2] * np.sin(plane))
    assert 0.201 < behind / d.pelvis_width < 0.240


PEOPLE = {"HC032A03": "settled on", "HC038A11": "reported", "HC038A27": "reported"}


@pytest.mark.slow
@pytest.mark.parametrize("name", PEOPLE)
def test_people_stand_as_plug_in_gait_says(data, name):
    raw, trial = fit_trial(data / "c3d" / f"{name}.c3d")
    fit, figures = trial.fit, trial.figures
    assert raw.markers is not None
    seen = np.isin(raw.markers.time, fit.time)
    tilt = np.nanmean(raw.outputs["LPelvisAngles"][seen, 0])
    assert figures["pelvis_tilt_plane_mean_deg"] == pytest.approx(tilt, abs=3)
    for side in "rl":
        theirs = np.nanmean(raw.outputs[f"{side.upper()}HipAngles"][seen, 0])
        column = 7 + fit.human.hinge(f"hip_flexion_{side}")
        assert np.rad2deg(fit.qpos[:, column].mean()) == pytest.approx(theirs, abs=5), side
    assert 20 < figures["lumbar_behind_hips_mm"] < 70
    assert abs(figures["trunk_lean_standing_deg"]) < 8
    assert abs(figures["neck_lean_mean_deg"]) < 12
    assert figures["marker_rms_mean_mm"] < 6
    assert figures["arms_at_stop_pct"] < 5
