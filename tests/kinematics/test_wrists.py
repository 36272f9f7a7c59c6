"""Wrist markers under each other's label are found by where the thumb can be."""

import numpy as np
import pytest

from plantigrade.io import read
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.wrists import MIN_PRONATION_SINE, exchanged_wrists, thumb_side
from plantigrade.models.markers import landmark_names
from plantigrade.motion import Markers
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker


def arms(pronation: float, elbow: float, noise: float = 0.003) -> Markers:
    """A walker with this pronation of both forearms and flexion of the elbows [deg]."""
    human, time, qpos = walker(40)
    for side in "rl":
        for name, angle in (("pro_sup", pronation), ("elbow_flex", elbow)):
            qpos[:, 7 + human.hinge(f"{name}_{side}")] = np.deg2rad(angle)
    return markers_of(human, time, qpos, noise=noise)


def renamed(markers: Markers, *pairs: tuple[str, str]) -> Markers:
    other = {a: b for a, b in pairs} | {b: a for a, b in pairs}
    return Markers(tuple(other.get(n, n) for n in markers.names), markers.time, markers.positions)


WRISTS = (("LWRA", "LWRB"), ("RWRA", "RWRB"))


@pytest.mark.parametrize("elbow", [5, 30, 90, 130])
@pytest.mark.parametrize("pronation", [15, 60, 90, 120, 165])
def test_no_posture_of_an_arm_is_taken_for_an_exchange(pronation, elbow):
    markers = arms(pronation, elbow)
    marks = landmark_names(markers.names)
    assert not exchanged_wrists(markers, marks)
    label = {mark: name for name, mark in marks.items() if mark}
    for side in "rl":
        expected = np.sin(np.deg2rad(pronation))
        assert thumb_side(markers, label, side) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize("pronation", [45, 90, 135])
def test_an_exchange_is_found_on_its_side(pronation):
    markers = arms(pronation, 25)
    for pair in WRISTS:
        wrong = renamed(markers, pair)
        assert exchanged_wrists(wrong, landmark_names(wrong.names)).cycles == [pair]


def test_without_wrist_markers_nothing_is_said():
    markers = arms(90, 25)
    bare = markers.select([n for n in markers.names if "WR" not in n])
    assert not exchanged_wrists(bare, landmark_names(bare.names))


def test_it_is_corrected_with_a_note():
    human, time, qpos = walker()
    qpos[:, [7 + human.hinge(f"pro_sup_{s}") for s in "rl"]] = np.deg2rad(100)
    right = markers_of(human, time, qpos, names=NAMES)
    fit = fit_markers(recording(renamed(right, *WRISTS)))
    assert any("RWRA and RWRB" in w and "corrected" in w for w in fit.warnings)
    for side in "rl":
        found = np.rad2deg(fit.qpos[:, 7 + human.hinge(f"pro_sup_{side}")].mean())
        assert found == pytest.approx(100, abs=8)
    assert fit.metrics["arms_at_stop_pct"] == 0


TRIALS = {
    "c3d/HC032A03.c3d": False,
    "c3d/HC038A11.c3d": True,  # against its own standing trial and HC038A27
    "c3d/HC038A01.c3d": False,
    "c3d/HC038A27.c3d": False,
    "opensim/opencap_subject4/squats1.trc": False,
    "opensim/gait2392_subject01/subject01_walk1.trc": False,
    "opensim/running_subject04/run200.trc": False,
}


@pytest.mark.parametrize("name", TRIALS)
def test_recordings(data, name):
    markers = read(data / name).markers
    assert markers is not None
    marks = landmark_names(markers.names)
    label = {mark: n for n, mark in marks.items() if mark}
    sines = [thumb_side(markers, label, side) for side in "rl"]
    assert (max(sines) < 2 * MIN_PRONATION_SINE) if TRIALS[name] else (min(sines) > 0)
