"""Segments that no marker shows, and markers that slip, are named; skin and gait are not."""

import numpy as np
import pytest

from plantigrade.kinematics.marker_doubts import error_notes, slip_notes, unseen_notes
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
    human, places, _, qpos, x = walk
    assert slip_notes(human, NAMES, places, qpos, x) == []
    slipped = x.copy()
    slipped[90:, NAMES.index("RKNE"), 2] -= 0.03
    (note,) = slip_notes(human, NAMES, places, qpos, slipped)
    assert "RKNE" in note and "LKNE" not in note


def test_skin_that_moves_in_every_stride_is_no_slip(walk):
    human, places, time, qpos, x = walk
    skin = x.copy()
    skin[:, NAMES.index("RTHI"), 0] += 0.02 * np.sin(2 * np.pi * time / 0.4)
    assert slip_notes(human, NAMES, places, qpos, skin) == []


def test_a_marker_error_beyond_that_of_fits_is_named():
    assert error_notes(0.011) == [] and "27 mm" in error_notes(0.027)[0]
