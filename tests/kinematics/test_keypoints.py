"""Keypoints of video: joint centres, noise of the file, a pelvis that they hardly show."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.video_recording import SETS, Video, as_video
from plantigrade.errors import FitError
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.keypoints import (
    bones_of_video,
    cutoff_for,
    floor_under,
    force_band_factor,
    levelled,
)
from plantigrade.kinematics.prepare import prepare
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.kinematics.unmeasured_toes import with_flat_feet
from plantigrade.models import Human, Person
from plantigrade.models.keypoints import are_keypoints
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmark_names
from plantigrade.motion import Markers, Recording
from plantigrade.spatial.conventions import about_axis, about_vertical

EXACT = {"noise": 0.0, "jitter": 0.0, "gaps": 0.0}


@pytest.fixture(scope="module")
def walk():
    """One stride of the textbook walk, as a fit."""
    human = Human.create(1.68, 62.0, "female")
    made = textbook_walk(human, rate=60.0, cycles=1)
    recording = Recording(Path("walk.c3d"))
    return Fit(human, made.time, made.qpos, recording, "markers")


@pytest.mark.parametrize("name", SETS)
def test_every_set_is_recognised(name):
    assert are_keypoints(SETS[name])
    assert all(landmark_names(SETS[name]).values())


def test_blazepose_names_are_joint_centres():
    known = landmark_names(["right_knee", "left_knee", "left_hip", "right_foot_index", "nose"])
    assert known["right_knee"] == "knee_joint_r"
    assert known["right_foot_index"] == "toe_tip_r"
    assert known["nose"] == "nose"


def test_the_noise_of_the_file_is_found(walk):
    for noise in (0.010, 0.025):
        markers = as_video(walk, Video(noise=noise, jitter=0.0)).markers
        assert bones_of_video(markers).noise == pytest.approx(noise / np.sqrt(3), rel=0.4)


def test_sagittal_angles_without_noise(walk):
    """Hips alone do not show the tilt of the pelvis; trunk and usual posture do, on the mean."""
    person = Person(height=walk.human.height, mass=walk.human.mass, sex=walk.human.sex)
    fit = fit_markers(as_video(walk, Video(rate=30.0, **EXACT)), person)
    for name, most in (("hip_flexion_r", 8.0), ("knee_angle_r", 3.0), ("ankle_angle_r", 4.0)):
        k = 7 + walk.human.hinge(name)
        true = np.interp(fit.time, walk.time, walk.qpos[:, k])
        error = np.rad2deg(np.sqrt(np.mean((fit.qpos[:, k] - true) ** 2)))
        assert error < most, name


def test_feet_that_no_keypoint_shows_stand_flat(walk):
    """COCO ends at the ankle: a standing foot is flat, and the shank tells the angle."""
    ankles = [7 + walk.human.hinge(f"ankle_angle_{side}") for side in "rl"]
    unseen = walk.qpos.copy()
    unseen[:, ankles] = 0.0
    found = with_flat_feet(walk.human, SETS["COCO"], walk.time, unseen)
    off = [np.median(np.abs(qpos - walk.qpos)[:, ankles]) for qpos in (unseen, found)]
    assert off[1] < 0.6 * off[0]
    seen = with_flat_feet(walk.human, SETS["HALPE_26"], walk.time, unseen)
    np.testing.assert_array_equal(seen, unseen)


def test_the_floor_is_found_from_the_feet(walk):
    """Cameras have no floor: the file's origin is half a metre off."""
    recording = as_video(walk, Video(rate=30.0))
    markers = replace(recording.markers, positions=recording.markers.positions + [0, 0, 0.5])
    assert floor_under(markers, walk.human) == pytest.approx(0.5, abs=0.015)


@pytest.mark.parametrize(
    ("tilt", "removed"), [(-3.0, True), (0.0, False), (2.0, True), (8.0, False)]
)
def test_a_floor_that_the_calibration_tilts_is_made_level(tilt, removed):
    """About the axis across the way, whatever its direction; what is steeper is a ramp."""
    human = Human.create(1.68, 62.0, "female")
    made = textbook_walk(human, rate=60.0, cycles=3)
    recording = as_video(Fit(human, made.time, made.qpos, Recording(Path("walk.c3d")), "markers"),
                         Video(noise=0.010))  # fmt: skip
    right = recording.markers.positions @ about_vertical(0.7).T
    across = about_vertical(0.7) @ [0.0, 1.0, 0.0]
    turn = about_axis(across, np.radians([-tilt]))[0]  # up along the way for positive ones
    found, notes = levelled(replace(recording.markers, positions=right @ turn.T))
    np.testing.assert_allclose(found.positions, right if removed else right @ turn.T, atol=0.025)
    assert len(notes) == removed
    if notes:
        said = float(re.search(r"([+-][0-9.]+)°", notes[0])[1])
        assert said == pytest.approx(tilt, abs=0.4)


def test_more_noise_gets_a_lower_low_pass():
    cutoffs = [cutoff_for(noise) for noise in (0.001, 0.005, 0.010, 0.030)]
    assert cutoffs == sorted(cutoffs, reverse=True)
    assert cutoffs[0] == 6.0 and cutoffs[-1] == 4.0


def test_keypoints_of_one_camera_are_refused(walk):
    """Sports2D writes a plane: depth is one number for all frames."""
    recording = as_video(walk, Video(rate=30.0, gaps=0.0))
    positions = recording.markers.positions.copy()
    positions[..., 1] = 0.3
    plane = replace(recording, markers=replace(recording.markers, positions=positions))
    with pytest.raises(FitError, match="2-D"):
        fit_markers(plane)


AUGMENTED = {
    "r.ASIS_study": "asis_r", "L.ASIS_study": "asis_l", "r.PSIS_study": "psis_r",
    "L.PSIS_study": "psis_l", "C7_study": "c7", "r_shoulder_study": "acromion_r",
    "L_shoulder_study": "acromion_l", "r_knee_study": "knee_lateral_r",
    "L_knee_study": "knee_lateral_l", "r_mknee_study": "knee_medial_r",
    "L_mknee_study": "knee_medial_l", "r_ankle_study": "ankle_lateral_r",
    "L_ankle_study": "ankle_lateral_l", "r_mankle_study": "ankle_medial_r",
    "L_mankle_study": "ankle_medial_l", "r_calc_study": "heel_r", "L_calc_study": "heel_l",
    "r_toe_study": "metatarsal_2_head_r", "L_toe_study": "metatarsal_2_head_l",
    "r_5meta_study": "metatarsal_5_head_r", "L_5meta_study": "metatarsal_5_head_l",
    "RHJC_study": "hip_joint_r", "LHJC_study": "hip_joint_l",
}  # fmt: skip
"""Markers that OpenCap's network computes from keypoints → landmark."""


@pytest.mark.parametrize("suffix", ["_study", ""])
def test_markers_computed_from_keypoints_are_used_instead_of_them(walk, suffix):
    video = as_video(walk, Video(rate=30.0, noise=0.05))
    table = attachments(walk.human)
    path = PointSet.of(walk.human, [table[mark] for mark in AUGMENTED.values()]).path(walk.qpos)
    frames = np.searchsorted(walk.time, video.markers.time - 1e-9)
    names = tuple(name.replace("_study", suffix) for name in AUGMENTED)
    assert list(landmark_names(names).values()) == list(AUGMENTED.values())
    both = np.concatenate([video.markers.positions, path[frames]], axis=1)
    markers = Markers(video.markers.names + names, video.markers.time, both)
    trial = prepare(replace(video, markers=markers))
    assert set(trial.names) == set(names) and trial.video is None
    assert "keypoint" in trial.ignored["RHip"]


def test_noise_and_unseen_feet_widen_the_bands_of_forces():
    factors = [force_band_factor(noise, SETS["HALPE_26"]) for noise in (0.0, 0.005, 0.010, 0.015)]
    assert factors[0] == factors[1] == 1.0
    assert factors[3] > factors[2] > 1.0
    assert force_band_factor(0.010, SETS["COCO"]) > factors[2]
