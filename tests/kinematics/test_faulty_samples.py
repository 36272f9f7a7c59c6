"""Labels that change within a recording, and samples that no camera measured."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade import io
from plantigrade.kinematics.faulty_samples import glued, without_faulty_samples
from plantigrade.kinematics.label_repair import with_continuous_labels
from plantigrade.kinematics.prepare import prepare
from plantigrade.models import Human, Person
from plantigrade.models.markers import landmark_names, place_markers
from plantigrade.motion import Markers, Recording
from tests.kinematics.test_fit import markers_of, walker

LEG = "THI KNE TIB ANK HEE TOE D5M".split()
HALF = 80


@pytest.fixture(scope="module")
def walk() -> Markers:
    return markers_of(*walker())


@pytest.fixture(scope="module")
def placed(walk):
    return place_markers(walk.names, Human.create(1.68, 62.0))


def columns(markers: Markers, names) -> list[int]:
    return [markers.index(n) for n in names]


def with_positions(markers: Markers, change) -> Markers:
    x = markers.positions.copy()
    change(x)
    return replace(markers, positions=x)


@pytest.mark.parametrize(
    "pairs",
    [
        [("LKNE", "RKNE")],
        [("LASI", "RASI")],
        [("RHEE", "RTOE")],
        [(f"L{n}", f"R{n}") for n in LEG],
        [("LKNE", "LANK"), ("LANK", "LTIB")],  # a cycle of three
    ],
)
@pytest.mark.parametrize("part", [slice(HALF, None), slice(0, 40), slice(60, 62), slice(50, 100)])
def test_labels_exchanged_in_a_part_are_put_back(walk, pairs, part):
    def exchanged(x):
        for a, b in pairs:
            i, j = columns(walk, (a, b))
            here, there = x[part, i].copy(), x[part, j].copy()
            x[part, i], x[part, j] = there, here

    back, notes = with_continuous_labels(with_positions(walk, exchanged))
    np.testing.assert_array_equal(back.positions, walk.positions)
    long = len(walk.time[part]) > 2
    assert len(notes) == long
    if long:
        assert all(name in notes[0] for pair in pairs for name in pair)


def recordings(data):
    return [*sorted(data.glob("c3d/*.c3d")), *sorted(data.glob("opensim/*/*.trc"))]


def test_recordings_of_laboratories_have_no_such_fault(data):
    """Fourteen laboratory recordings with their own gaps, noise and fills."""
    human = Human.create(1.72, 70.0)
    for path in recordings(data):
        markers = io.read(path).markers
        assert with_continuous_labels(markers)[1] == [], path
        there = place_markers(markers.names, human)
        assert without_faulty_samples(markers, there)[1] == [], path
        assert glued(markers, list(markers.names), landmark_names(markers.names)) == [], path


def left_out(markers: Markers, changed: Markers):
    """Samples of the changed markers that are missing though they were seen."""
    return np.isfinite(markers.positions[..., 0]) & ~np.isfinite(changed.positions[..., 0])


@pytest.mark.parametrize("name", ["RANK", "RKNE", "LASI"])
def test_a_marker_that_freezes_is_left_out(walk, placed, name):
    (i,) = columns(walk, [name])

    def freeze(x):
        x[HALF:, i] = x[HALF, i]

    wrong = with_positions(walk, freeze)
    found, (note,) = without_faulty_samples(wrong, placed)
    lost = left_out(wrong, found)
    assert lost[HALF + 1 :, i].all()
    assert lost.sum() == lost[:, i].sum()
    assert name in note


def test_a_gap_filled_by_a_straight_line_is_left_out(walk, placed):
    leg = columns(walk, [f"R{n}" for n in LEG])

    def fill(x):
        part = np.linspace(0, 1, 41)[:, None, None]
        x[60:101, leg] = (1 - part) * x[60, leg] + part * x[100, leg]

    wrong = with_positions(walk, fill)
    found, (note,) = without_faulty_samples(wrong, placed)
    assert left_out(wrong, found)[62:99, leg].all()
    assert left_out(wrong, found)[:60].sum() == 0
    assert "RKNE" in note


def test_repeated_frames_of_a_moving_person_are_left_out(walk, placed):
    def repeat(x):
        x[60:75] = x[60]

    found, (note,) = without_faulty_samples(with_positions(walk, repeat), placed)
    np.testing.assert_array_equal(np.flatnonzero(left_out(walk, found).all(axis=1)), range(61, 75))
    assert note.startswith("14 frames")


@pytest.mark.parametrize("dropped", [8, 30])
def test_of_a_recording_with_missing_frames_the_longest_part_is_kept(walk, placed, dropped):
    x = np.delete(walk.positions, np.arange(50, 50 + dropped), axis=0)
    cut = Markers(walk.names, walk.time[: len(x)], x)
    found, notes = without_faulty_samples(cut, placed)
    assert len(notes) == 1
    np.testing.assert_array_equal(
        np.isfinite(found.positions).all(axis=(1, 2)), np.arange(len(x)) >= 50
    )


def test_one_faulty_frame_is_no_cut(walk, placed):
    def jump(x):
        x[70] += 0.3

    wrong = with_positions(walk, jump)
    assert without_faulty_samples(wrong, placed)[1] == []


def test_a_person_at_rest_is_left_alone(walk, placed):
    still = replace(walk, positions=np.repeat(walk.positions[:1], len(walk.time), axis=0))
    assert without_faulty_samples(still, placed)[1] == []


@pytest.mark.parametrize(
    ("copy", "of", "gone"),
    [
        ("RKNE", "RTHI", {"RKNE", "RTHI"}),  # either may be wrong
        ("RANK", "RHEE", {"RANK", "RHEE"}),
        ("*12", "RHEE", {"*12"}),  # a trajectory that was not labelled
    ],
)
def test_two_markers_at_one_place(walk, copy, of, gone):
    others = walk.select([n for n in walk.names if n != copy])
    near = walk.positions[:, [walk.index(of)]] + 0.002
    positions = np.concatenate([others.positions, near], axis=1)
    both = Markers((*others.names, copy), walk.time, positions)
    assert set(glued(both, list(both.names), landmark_names(both.names))) == gone


def test_what_is_left_out_is_said(walk, tmp_path):
    """A fit gets the markers without the faults, with the sentences."""

    def spoil(x):
        i, j, k = columns(walk, ("LKNE", "RKNE", "RANK"))
        x[HALF:, i], x[HALF:, j] = x[HALF:, j].copy(), x[HALF:, i].copy()
        x[100:130, k] = x[100, k]

    wrong = Recording(tmp_path / "walk.c3d", with_positions(walk, spoil))
    ready = prepare(wrong, Person(height=1.68))
    assert [("LKNE" in n, "RANK" in n) for n in ready.notes[:2]] == [(True, False), (False, True)]
    assert np.isnan(ready.markers.positions[102:129, ready.markers.index("RANK")]).all()
