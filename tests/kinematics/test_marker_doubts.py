"""Segments that no marker shows, and markers that slip, are named; skin and gait are not."""

import numpy as np
import pytest

from plantigrade.kinematics.marker_doubts import error_notes, slip_notes, twin_notes, unseen_notes
from plantigrade.models.markers import place_markers
from tests.kinematics.test_fit import NAMES, markers_of, walker

FOOT = ("RHEE", "RTOE", "RD5M")


@pytest.fixture(scope="module")
def walk():
    """Person, attachments, configurations and positions of a walk."""
    human, time, qpos = walker()
    placed = place_markers(NAMES, human)
    return human, [placed[n] for n in NAMES], time, qpos, markers_of(human, time, qpos).positions


@pytest.mark.parametrize(
    ("names", "segment"), [(FOOT, "right foot"), (("LASI", "RASI", "LPSI", "RPSI"), "pelvis")]
)
@pytest.mark.parametrize(("frames", "expected"), [(50, True), (10, False)])
def test_a_segment_without_markers_is_named_with_its_times(walk, names, segment, frames, expected):
    _, places, time, _, x = walk
    gap = x.copy()
    gap[60 : 60 + frames, [NAMES.index(n) for n in names]] = np.nan
    notes = unseen_notes(places, time, gap)
    assert len(notes) == expected
    assert all(segment in note and "0.60 to 1.09 s" in note for note in notes)


def test_one_marker_of_a_segment_is_enough(walk):
    _, places, time, _, x = walk
    gap = x.copy()
    gap[60:110, [NAMES.index(n) for n in FOOT[1:]]] = np.nan
    assert unseen_notes(places, time, gap) == []


def test_a_marker_that_slips_is_named(walk):
    human, places, time, qpos, x = walk
    assert slip_notes(human, NAMES, places, time, qpos, x) == []
    slipped = x.copy()
    slipped[90:, NAMES.index("RKNE"), 2] -= 0.03
    (note,) = slip_notes(human, NAMES, places, time, qpos, slipped)
    assert "RKNE" in note and "LKNE" not in note


def test_skin_that_moves_in_every_stride_is_no_slip(walk):
    human, places, time, qpos, x = walk
    skin = x.copy()
    skin[:, NAMES.index("RTHI"), 0] += 0.02 * np.sin(2 * np.pi * time / 0.4)
    assert slip_notes(human, NAMES, places, time, qpos, skin) == []


def test_a_marker_error_beyond_that_of_fits_is_named():
    assert error_notes(0.011) == [] and "27 mm" in error_notes(0.027)[0]


def test_a_part_of_a_step_shows_no_slip(walk):
    """Skin shifts within a step."""
    human, places, time, qpos, x = walk
    slipped = x.copy()
    slipped[90:, NAMES.index("RKNE"), 2] -= 0.03
    part = slice(65, 115)
    assert slip_notes(human, NAMES, places, time[part], qpos[part], slipped[part]) == []


def test_twins_on_other_segments_are_named():
    names = ["R.TH1", "L.TH1", "R.SH1", "L.SH1"]
    good = {"R.TH1": "femur_r", "L.TH1": "femur_l", "R.SH1": "tibia_r"}
    assert twin_notes(good, names) == []
    assert twin_notes({"R.TH1": "pelvis", "L.TH1": "pelvis"}, names) == []
    assert "R.TH1" in twin_notes({**good, "R.TH1": "pelvis"}, names)[0]
    assert "R.TH1" in twin_notes({**good, "R.TH1": "femur_l"}, names)[0]


def test_one_marker_of_a_cluster_on_another_segment_is_named():
    on = {f"R.TH{i}": "femur_r" for i in (1, 2, 3)} | {f"L.TH{i}": "femur_l" for i in (1, 2, 3)}
    wrong = on | {"R.TH1": "pelvis", "L.TH1": "pelvis"}
    (note,) = twin_notes(wrong, list(on))
    assert "R.TH1" in note and "L.TH1" in note and "R.TH2" not in note
    assert twin_notes(on, list(on)) == []
