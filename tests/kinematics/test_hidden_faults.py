"""Faults of markers that a body follows to the millimetre: symmetry, joints, standing show them."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.joint_distances import (
    SegmentPoses,
    joint_centre,
    late_notes,
    segment_of_leg,
)
from plantigrade.kinematics.knee_height import knee_notes
from plantigrade.kinematics.marker_doubts import scale_notes, vertical_scale
from plantigrade.kinematics.side_doubts import side_notes
from plantigrade.kinematics.spine_doubts import sideways_notes, spine_notes, tilt_notes
from plantigrade.kinematics.state import PointSet
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmark_names, landmarks_of, place_markers
from plantigrade.motion import Markers
from plantigrade.workflows.fit import load
from plantigrade.workflows.settings import FitSettings
from tests.kinematics.test_fit import NAMES, markers_of, walker

MARKS = landmark_names(NAMES)


@pytest.fixture(scope="module")
def walk():
    """Attachments and markers of a walk."""
    human, time, qpos = walker()
    placed = place_markers(NAMES, human)
    return human, [placed[n] for n in NAMES], markers_of(human, time, qpos), qpos


def moved(markers: Markers, names, by) -> Markers:
    x = markers.positions.copy()
    x[:, [markers.index(n) for n in names]] += by
    return replace(markers, positions=x)


def test_the_point_that_markers_keep_their_distance_to_is_the_joint(walk):
    human, places, markers, qpos = walk
    pelvis = [i for i, p in enumerate(places) if p.body == "pelvis"]
    thigh = [i for i, p in enumerate(places) if p.body == "femur_r"]
    segment = SegmentPoses.of(markers.positions[:, pelvis], 0)
    assert segment is not None
    centre, error = joint_centre(segment.seen_from_here(markers.positions[:, thigh]))
    hip = PointSet.of(human, [attachments(human)["hip_joint_r"]]).path(qpos)
    (true,) = segment.seen_from_here(hip)[0]
    assert error < 2e-3  # the markers have noise
    # The leg hardly turns to the sides, so the markers do not show where the joint lies along y.
    np.testing.assert_allclose(centre[[0, 2]], true[[0, 2]], atol=0.01)


@pytest.mark.parametrize("late", [5, -4])
@pytest.mark.parametrize("side", ["R", "L"])
def test_a_leg_with_a_clock_of_its_own_is_named_with_its_delay(walk, late, side):
    _, places, markers, _ = walk
    assert late_notes(places, markers.rate, markers.positions) == []
    x = markers.positions.copy()
    leg = [i for i, n in enumerate(markers.names) if n[0] == side and places[i].body != "pelvis"]
    leg = [i for i in leg if segment_of_leg(places[i].body)]
    x[:, leg] = np.roll(x[:, leg], late, axis=0)
    x[:5, leg] = x[-5:, leg] = np.nan
    notes = late_notes(places, markers.rate, x)
    word = "right" if side == "R" else "left"
    (note,) = notes
    assert word in note and ("later" if late > 0 else "earlier") in note
    (delay,) = re.findall(r"(\d+) ms", note)
    assert int(delay) == pytest.approx(abs(late) * 1000 / markers.rate, abs=3)


@pytest.mark.parametrize("scale", [0.87, 1.15])
def test_heights_of_another_scale_are_named(walk, scale):
    _, places, markers, _ = walk
    which = [i for i, p in enumerate(places) if p.body.startswith(("femur", "tibia"))]
    clusters, x = [places[i] for i in which], markers.positions[:, which]
    # Two markers a segment are too few pairs: the middle of both is a third.
    more = [0.5 * (x[:, i] + x[:, j]) for i, j in _mates(clusters)]
    places = [*clusters, *[clusters[i] for i, _ in _mates(clusters)]]
    x = np.concatenate([x, np.stack(more, axis=1)], axis=1)
    assert scale_notes(places, x) == []
    assert vertical_scale(places, x * [1, 1, scale]) == pytest.approx(scale, rel=0.01)
    assert len(scale_notes(places, x * [1, 1, scale])) == 1


def _mates(places):
    n = len(places)
    return [(i, j) for i in range(n) for j in range(i) if places[i].body == places[j].body]


@pytest.mark.parametrize("names", [("RASI",), ("LASI",), ("RPSI",)])
def test_one_spine_five_centimetres_low_is_named(walk, names):
    _, places, markers, _ = walk
    assert spine_notes(markers, MARKS, places) == []
    (note,) = spine_notes(moved(markers, names, [0, 0, -0.05]), MARKS, places)
    assert "slopes" in note


def test_a_belt_at_the_height_of_the_hips_is_named(walk):
    _, places, markers, _ = walk
    belt = [n for n in NAMES if (MARKS[n] or "").startswith(("asis", "psis", "sacrum"))]
    (note,) = spine_notes(moved(markers, belt, [0, 0, -0.08]), MARKS, places)
    assert "too low" in note


@pytest.mark.parametrize(
    ("name", "by", "said"),
    [
        ("RKNE", [0, 0, -0.05], "low"),
        ("LKNE", [0, 0, 0.05], "high"),
        ("LANK", [0, 0, 0.04], "high"),
        ("RHEE", [0, 0, 0.05], "high"),
        ("LHEE", [0.04, 0, 0], "far ahead"),
    ],
)
def test_a_marker_elsewhere_than_on_the_other_leg_is_named(walk, name, by, said):
    human, _, markers, qpos = walk
    known = landmarks_of(NAMES)
    assert side_notes(markers, known, human, qpos) == []
    (note,) = side_notes(moved(markers, [name], by), known, human, qpos)
    assert f"{name} is probably too {said}" in note or f"or {name} too {said}" in note


@pytest.mark.parametrize(("by", "said"), [(-0.045, "low"), (0.045, "high")])
def test_knee_markers_that_are_off_alike_on_both_legs_are_named(walk, by, said):
    human, places, markers, qpos = walk
    known = landmarks_of(NAMES)
    assert knee_notes(markers, known, places, human, qpos) == []
    x = markers.positions.copy()
    for name, side in (("RKNE", "r"), ("LKNE", "l")):
        hip = PointSet.of(human, [attachments(human)[f"hip_joint_{side}"]]).path(qpos)[:, 0]
        up = hip - x[:, markers.index(name)]
        x[:, markers.index(name)] += by * up / np.linalg.norm(up, axis=1, keepdims=True)
    (note,) = knee_notes(replace(markers, positions=x), known, places, human, qpos)
    assert f"too {said}" in note and "RKNE" in note and "LKNE" in note
    x[5:, markers.index("RKNE")] = np.nan  # seldom seen: nothing is known
    assert knee_notes(replace(markers, positions=x), known, places, human, qpos) == []


def test_legs_of_unequal_length_are_none_of_it(walk):
    """A shank that is 3 cm longer: knee and thigh are where they were, the ankle is lower."""
    human, _, markers, qpos = walk
    longer = moved(markers, ["RANK", "RHEE", "RTOE", "RD5M"], [0, 0, -0.03])
    assert side_notes(longer, landmarks_of(NAMES), human, qpos) == []


@pytest.mark.parametrize("degrees", [-6.0, 6.0])
def test_a_laboratory_that_is_tilted_to_one_side_is_named(walk, degrees):
    human, _, markers, qpos = walk
    assert sideways_notes(markers, MARKS, human, qpos) == []
    turn = Rotation.from_euler("x", degrees, degrees=True)
    other = replace(markers, positions=markers.positions @ turn.as_matrix().T)
    tilted = qpos.copy()
    there = turn * Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    tilted[:, :3] = turn.apply(qpos[:, :3])
    tilted[:, 3:7] = there.as_quat(scalar_first=True)
    (note,) = sideways_notes(other, MARKS, human, tilted)
    assert ("left" if degrees < 0 else "right") in note


@pytest.mark.parametrize(("degrees", "count"), [(6.0, 0), (16.0, 1), (-16.0, 1)])
def test_a_pelvis_that_stands_in_another_way_is_named(walk, degrees, count):
    """As where the markers on the sacrum are centimetres lower than in the standing trial."""
    human, _, _, qpos = walk
    turn = Rotation.from_euler("y", degrees, degrees=True)
    other = qpos.copy()
    there = Rotation.from_quat(qpos[:, 3:7], scalar_first=True) * turn
    other[:, 3:7] = there.as_quat(scalar_first=True)
    other[:, 7 + human.hinge("lumbar_extension")] += np.deg2rad(degrees)
    notes = tilt_notes(human, other, qpos[:1])
    assert len(notes) == count
    assert tilt_notes(human, other, qpos[:0]) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "said"), [("belt", "elsewhere"), ("trial", "elsewhere"), ("step", "bent"), ("", "")]
)
def test_standing_and_walking_contradict_each_other(data, fault, said):
    recording = load(data / "c3d" / "HC038A11.c3d", FitSettings())
    assert recording.markers is not None
    assert recording.static is not None and recording.static.markers is not None
    static, belt = recording.static, ["SACR", "LASI", "RASI"]
    if fault == "belt":
        static = replace(static, markers=moved(recording.static.markers, belt, [0, 0, -0.05]))
    if fault == "trial":
        low = moved(recording.markers, belt, [0, 0, -0.05])
        recording = replace(recording, markers=low)
    if fault == "step":
        one = recording.markers
        assert one is not None
        x = np.repeat(one.positions[135:136], 50, axis=0)
        static = replace(static, markers=Markers(one.names, one.time[:50], x))
    warnings = fit_markers(recording, static=static).warnings
    found = [w for w in warnings if "elsewhere on the body" in w or "knee is bent" in w]
    assert len(found) == bool(fault) and all(said in w for w in found)


@pytest.mark.slow
def test_recordings_of_laboratories_have_none_of_them(data):
    settings = FitSettings()
    for path in [*sorted(data.glob("c3d/*.c3d")), *sorted(data.glob("opensim/*/*.trc"))]:
        recording = load(path, settings)
        fit = fit_markers(recording, static=recording.static)
        words = ("elsewhere on the body", "knee is bent")
        assert [w for w in fit.warnings if any(word in w for word in words)] == [], path
        assert fit.doubts == (), path
