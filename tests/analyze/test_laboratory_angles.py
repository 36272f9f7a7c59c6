"""Angles of gait laboratories: lines between markers, held against constructed feet."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.analyze.foot_progression import foot_line, foot_progression, inward_angle
from plantigrade.analyze.laboratory_angles import laboratory_angles, laboratory_figures
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import GaitEvent, Markers, Motion
from plantigrade.record import Record

MARKS = {"RKNE": "knee_lateral_r", "RANK": "ankle_lateral_r", "RTOE": "metatarsal_2_head_r"}
TIME = np.arange(101) / 100


@pytest.fixture(scope="module")
def human() -> Human:
    """An average person."""
    return Human.create()


def record(human: Human, ankle_deg, *, events=(), hide=()) -> Record:
    """Return a motion of the right ankle alone with markers that follow it exactly."""
    qpos = np.tile(human.standing(), (len(TIME), 1))
    qpos[:, 7 + human.hinge("ankle_angle_r")] = np.deg2rad(ankle_deg)
    table = attachments(human)
    places = [table[m] for m in MARKS.values()]
    points = PointSet(human, [p.body for p in places], np.array([p.position for p in places]))
    seen = points.path(qpos)
    motion = Motion(
        TIME, qpos, np.zeros((len(TIME), human.model.nv)), human.joint_names, events=events
    )
    names = tuple(n for n in MARKS if n not in hide)
    kept = [i for i, n in enumerate(MARKS) if n not in hide]
    markers = Markers(names, TIME, seen[:, kept].copy())
    return Record(human, motion, recorded_markers=markers, fitted_markers=seen[:, kept])


def shifted(given: Record, marker: str, by: np.ndarray) -> Record:
    """Return the record with one marker recorded elsewhere [m]."""
    from dataclasses import replace

    assert given.recorded_markers is not None
    positions = given.recorded_markers.positions.copy()
    positions[:, given.recorded_markers.index(marker)] += by
    return replace(given, recorded_markers=replace(given.recorded_markers, positions=positions))


def dorsiflexion(given: Record) -> np.ndarray:
    return np.rad2deg(laboratory_angles(given)["ankle_dorsiflexion_r"])


def test_a_rigid_foot_turns_as_its_ankle_does(human):
    angle = np.linspace(-20, 15, len(TIME))
    found = dorsiflexion(record(human, angle))
    # the ankle's axis is oblique, so a little less is seen from the side
    assert 31 < np.ptp(found) < 35
    np.testing.assert_allclose(found[np.abs(angle).argmin()], 0, atol=2.5)


def test_a_midfoot_that_bends_is_seen_by_the_toe_marker_alone(human):
    given = record(human, 0.0)
    d = human.dimensions
    assert given.recorded_markers is not None
    toe = given.recorded_markers.positions[0, 2]
    ankle = given.fitted_markers[0, 1]
    lower = shifted(given, "RTOE", np.array([0.0, 0.0, -0.02]))
    x, z = toe[0] - ankle[0], ankle[2] - toe[2]
    expected = np.rad2deg(np.arctan2(z + 0.02, x) - np.arctan2(z, x))
    np.testing.assert_allclose(dorsiflexion(given) - dorsiflexion(lower), expected, atol=0.6)
    assert 0.1 * d.foot_length < x


def test_the_shank_is_the_line_between_the_markers_of_knee_and_ankle(human):
    given = record(human, 0.0)
    forward = shifted(given, "RKNE", np.array([0.02, 0.0, 0.0]))
    shank = human.dimensions.shank
    expected = np.rad2deg(np.arctan2(0.02, shank))
    np.testing.assert_allclose(dorsiflexion(forward) - dorsiflexion(given), expected, rtol=0.1)
    outward = shifted(given, "RKNE", np.array([0.0, -0.02, 0.0]))
    np.testing.assert_allclose(dorsiflexion(outward), dorsiflexion(given), atol=0.3)


def test_markers_that_are_not_there_leave_the_body(human):
    angle = np.linspace(-20, 15, len(TIME))
    bare = record(human, angle, hide=tuple(MARKS))
    assert 31 < np.ptp(dorsiflexion(bare)) < 35
    assert laboratory_figures(bare) == {}
    gap = record(human, angle)
    assert gap.recorded_markers is not None
    gap.recorded_markers.positions[30:40, 2] = np.nan
    np.testing.assert_allclose(dorsiflexion(gap), dorsiflexion(record(human, angle)), atol=1e-9)


def test_a_thigh_that_turns_under_its_hinge_is_seen_by_its_own_markers(human):
    """The shank stays, so the body's hip does not turn; the markers of the thigh do."""
    marks = ("knee_lateral_r", "thigh_r", "ankle_lateral_r", "metatarsal_2_head_r")
    names = ("RKNE", "RTHI", "RANK", "RTOE")
    qpos = np.tile(human.standing(), (len(TIME), 1))
    wave = np.sin(2 * np.pi * TIME)
    qpos[:, 7 + human.hinge("hip_flexion_r")] = 0.4 * wave
    qpos[:, 7 + human.hinge("knee_angle_r")] = 0.5 + 0.4 * wave
    motion = Motion(TIME, qpos, np.zeros((len(TIME), human.model.nv)), human.joint_names)
    table = attachments(human)
    places = [table[m] for m in marks]
    points = PointSet(human, [p.body for p in places], np.array([p.position for p in places]))
    fitted = points.path(qpos)
    seen = fitted.copy()
    femur, turn = human.body("femur_r"), np.deg2rad(6) * np.sin(4 * np.pi * TIME)
    for k, state in enumerate(sweep(human, qpos)):
        hip, axis = state.origins[femur], state.rotations[femur][:, 2]
        for i in (0, 1):
            seen[k, i] += turn[k] * np.cross(axis, fitted[k, i] - hip)
    given = Record(
        human, motion, recorded_markers=Markers(names, TIME, seen), fitted_markers=fitted
    )
    found = laboratory_angles(given)
    np.testing.assert_allclose(found["hip_rotation_thigh_r"], turn, atol=np.deg2rad(0.3))
    np.testing.assert_allclose(found["hip_adduction_thigh_r"], 0, atol=np.deg2rad(0.3))
    assert "hip_rotation_thigh_l" not in found.names, "no marker on that thigh"


@pytest.mark.parametrize("side", ["r", "l"])
def test_a_knee_that_turns_about_another_axis_is_seen_by_the_markers_of_both_segments(human, side):
    """The body's knee is a hinge; further rotation of its markers is reported, not lost."""
    marks = ("knee_lateral", "knee_medial", "thigh", "ankle_lateral", "ankle_medial", "shank")
    names = ("KNE", "KNM", "THI", "ANK", "MED", "TIB")
    qpos = np.tile(human.standing(), (len(TIME), 1))
    wave = np.sin(2 * np.pi * TIME)
    qpos[:, 7 + human.hinge(f"hip_flexion_{side}")] = 0.4 * wave
    qpos[:, 7 + human.hinge(f"knee_angle_{side}")] = 0.5 + 0.4 * wave
    qpos[:, 7 + human.hinge(f"ankle_angle_{side}")] = 0.1 * wave
    motion = Motion(TIME, qpos, np.zeros((len(TIME), human.model.nv)), human.joint_names)
    table = attachments(human)
    places = [table[f"{m}_{side}"] for m in marks]
    fitted = PointSet.of(human, places).path(qpos)
    tibia, sign = human.body(f"tibia_{side}"), 1 if side == "r" else -1
    inward, varus = (np.deg2rad(a) * np.sin(4 * np.pi * TIME + b) for a, b in ((8, 0), (4, 1)))
    turns = Rotation.from_euler("XZ", sign * np.stack([varus, inward], axis=1)).as_matrix()
    tilt = np.arctan2(*human.model.joint(f"knee_angle_{side}").axis[[2, 1]])
    hinge = Rotation.from_euler("X", tilt).as_matrix()
    turns = hinge @ turns @ hinge.T
    seen = fitted.copy()
    for k, state in enumerate(sweep(human, qpos)):
        knee, axes = state.origins[tibia], state.rotations[tibia]
        local = (fitted[k, 3:] - knee) @ axes
        seen[k, 3:] = knee + local @ turns[k].T @ axes.T
    tags = tuple(side.upper() + n for n in names)
    given = Record(human, motion, recorded_markers=Markers(tags, TIME, seen), fitted_markers=fitted)
    found = laboratory_angles(given)
    np.testing.assert_allclose(found[f"knee_rotation_markers_{side}"], inward, atol=1e-3)
    np.testing.assert_allclose(found[f"knee_adduction_markers_{side}"], varus, atol=1e-3)
    fewer = Record(
        human,
        motion,
        recorded_markers=Markers(tags[:5], TIME, seen[:, :5]),
        fitted_markers=fitted[:, :5],
    )
    assert not [n for n in laboratory_angles(fewer).names if "_markers_" in n], "two on the shank"


def test_figures_are_of_whole_cycles(human):
    angle = np.where(TIME < 0.1, 40.0, 10 * np.sin(2 * np.pi * TIME))
    strikes = tuple(GaitEvent(t, "r", "heel_strike") for t in (0.15, 0.95))
    found = laboratory_figures(record(human, angle, events=strikes))
    assert set(found) == {f"ankle_dorsiflexion_{w}_r_deg" for w in ("min", "max", "rom")}
    assert 17 < found["ankle_dorsiflexion_rom_r_deg"] < 21


@pytest.mark.parametrize("side", ["r", "l"])
def test_foot_progression_is_true_of_a_flat_foot_and_calm_on_its_tip(human, side):
    """Seen from above, a foot on its tip would point anywhere."""
    qpos = np.tile(human.standing(), (2, 1))
    inward = np.deg2rad(12) * (1 if side == "r" else -1)
    qpos[:, 3], qpos[:, 6] = np.cos(inward / 2), np.sin(inward / 2)
    flat = Record(
        human, Motion(np.arange(2.0), qpos, np.zeros((2, human.model.nv)), human.joint_names)
    )
    ahead = np.array([1.0, 0.0])
    straight = foot_line(flat, side)
    angle = np.rad2deg(inward_angle(straight, side, ahead))
    qpos[:, 3:7] = human.standing()[3:7]
    neutral = np.rad2deg(inward_angle(foot_line(flat, side), side, ahead))
    assert 11 < (angle - neutral)[0] < 13
    line = np.array([[0.02, 0.05, -1.0]]) / np.linalg.norm([0.02, 0.05, -1.0])
    assert abs(np.rad2deg(inward_angle(line, side, ahead))[0]) < 3


@pytest.mark.parametrize("way", [0.0, 90.0, -90.0, 180.0, 20.0, 200.0])
def test_toes_point_outward_whichever_way_a_person_walks(human, way):
    strikes = tuple(GaitEvent(t, side, "heel_strike") for side in "rl" for t in (0.0, 1.0))
    qpos = np.tile(human.standing(), (len(TIME), 1))
    angle = np.deg2rad(way)
    qpos[:, :2] += TIME[:, None] * [np.cos(angle), np.sin(angle)]
    for side in "rl":
        qpos[:, 7 + human.hinge(f"hip_rotation_{side}")] = np.deg2rad(-8.0)
    velocity = np.zeros((len(TIME), human.model.nv))
    motion = Motion(TIME, qpos, velocity, human.joint_names, events=strikes)
    found = foot_progression(Record(human, motion))
    aside = 20.0 if way in (20.0, 200.0) else 0.0  # the way itself is oblique there
    assert found["foot_progression_r"].mean() == pytest.approx(-8.0 - aside, abs=2.0)
    assert found["foot_progression_l"].mean() == pytest.approx(-8.0 + aside, abs=2.0)


@pytest.mark.parametrize("front", [("RTOE",), ("RD1M", "RD5M")])
def test_foot_progression_is_that_of_the_line_between_the_markers(human, front):
    """Markers that point outwards on a foot that does not: as with a shank that is twisted."""
    table = attachments(human)
    worn = {"RHEE": "heel_r", "RTOE": "metatarsal_2_head_r"}
    worn |= {"RD1M": "metatarsal_1_head_r", "RD5M": "metatarsal_5_head_r"}
    names = ("RHEE", *front)
    outwards = np.array([0.0, -0.03, 0.0])
    places = [table[worn[name]].position + outwards * (name != "RHEE") for name in names]
    qpos = np.tile(human.standing(), (2, 1))
    seen = PointSet(human, ["foot_r"] * len(names), np.array(places)).path(qpos)
    motion = Motion(np.arange(2.0), qpos, np.zeros((2, human.model.nv)), human.joint_names)
    given = Record(
        human, motion, recorded_markers=Markers(names, motion.time, seen), fitted_markers=seen
    )
    line = seen[0, 1:].mean(axis=0) - seen[0, 0]
    np.testing.assert_allclose(foot_line(given, "r")[0], line / np.linalg.norm(line), atol=1e-12)
    bare = Record(human, motion)
    turned = inward_angle(foot_line(bare, "r"), "r", np.array([1.0, 0.0]))
    ours = inward_angle(foot_line(given, "r"), "r", np.array([1.0, 0.0]))
    assert ours[0] < turned[0]
    np.testing.assert_array_equal(foot_line(given, "l"), foot_line(bare, "l"))
