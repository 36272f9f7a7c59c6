"""Trunk, head and arms that no marker shows follow the legs, and are said to be assumed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plantigrade.analyze import analyse
from plantigrade.constants import GRAVITY
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.kinematics.unmeasured_joints import PARTS, follow_the_legs, leg_swing
from plantigrade.models import Human, Person
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.motion import Markers, Recording, Table
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles, xyzw_to_wxyz
from plantigrade.workflows.fit import fit_recording, load
from plantigrade.workflows.settings import FitSettings
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker

UPPER = tuple(name for every in PARTS.values() for name in every)
LEG_NAMES = tuple(
    n for n in NAMES if n[1:] in "ASI PSI THI KNE KNM TIB ANK MED HEE TOE D5M".split()
)


@cache
def person(joints: str = "42") -> Human:
    return Human.create(1.74, 70.0, joints=joints)


def book(human: Human, speed: float, cycles: int = 3):
    """Return the textbook walk, its time and poses."""
    d = human.dimensions
    walk = textbook_gait(speed, d.thigh + d.shank + d.ankle_height, cycles=cycles)
    names = tuple(walk.coordinates)
    qpos = human.from_coordinates(names, np.stack([walk.coordinates[n] for n in names], axis=1))
    return walk, walk.time, qpos


def shown(human: Human, hidden=UPPER) -> np.ndarray:
    """Return which hinges are seen where those are hidden."""
    return np.array(
        [c.removesuffix("_r").removesuffix("_l") not in hidden for c in human.coordinates]
    )


def trunk_angles(human: Human, qpos) -> np.ndarray:
    """Return tilt, list and rotation of the part of the trunk that carries the arms [deg]."""
    from scipy.spatial.transform import Rotation

    body = human.skeleton.parts["thorax"][0]
    turned = Rotation.from_matrix(np.array([s.rotation(body) for s in sweep(human, qpos)]))
    return np.rad2deg(quaternion_to_pelvis_angles(xyzw_to_wxyz(turned.as_quat())))


def angle(human: Human, qpos, name: str) -> np.ndarray:
    return np.rad2deg(qpos[:, 7 + human.hinge(name)])


@pytest.mark.parametrize("speed", [0.7, 1.25, 1.8])
@pytest.mark.parametrize("seconds", [0.8, 3.0])
def test_phase_and_speed_of_the_legs_are_those_of_the_walk(speed, seconds):
    human = person()
    walk, time, qpos = book(human, speed)
    n = min(len(time), round(100 * seconds))
    legs = leg_swing(human, time[:n], qpos[:n], shown(human))
    phase = 2 * np.pi * time[:n] / walk.stride_time
    assert np.rad2deg(np.abs(legs.phase - phase)).max() < 14  # 4 % of the cycle
    d = human.dimensions
    true = speed / np.sqrt(GRAVITY * (d.thigh + d.shank + d.ankle_height))
    assert legs.speed.mean() == pytest.approx(true, rel=0.1)
    assert not legs.runs


def test_the_phase_of_one_leg_is_enough():
    human = person()
    walk, time, qpos = book(human, 1.25)
    one = np.array(qpos)
    left = [7 + k for k, c in enumerate(human.coordinates) if c.endswith("_l")]
    one[:, left] = human.standing()[left]
    seen = shown(human) & np.array([not c.endswith("_l") for c in human.coordinates])
    phase = leg_swing(human, time, one, seen).phase
    assert np.rad2deg(np.abs(phase - 2 * np.pi * time / walk.stride_time)).max() < 20


def test_a_bouncing_pelvis_is_that_of_a_runner():
    human = person()
    walk, time, qpos = book(human, 1.8)
    qpos[:, 2] += 0.04 * np.cos(4 * np.pi * time / walk.stride_time)
    assert leg_swing(human, time, qpos, shown(human)).runs


@pytest.mark.parametrize("joints", ["42", "43", "58", "66"])
def test_hidden_joints_follow_and_seen_ones_stay(joints):
    human = person(joints)
    walk, time, qpos = book(human, 1.25)
    seen = shown(human)
    welded = np.array(qpos)
    welded[:, 7:][:, ~seen] = human.standing()[7:][~seen]
    made = follow_the_legs(human, time, welded, seen)
    assert np.array_equal(made[:, 7:][:, seen], welded[:, 7:][:, seen])
    assert np.array_equal(made[:, :7], welded[:, :7])
    trunk = trunk_angles(human, made)
    # ranges in the room of adults [Chung2010]_, tilt 4.0 ± 1.8, lean 3.3 ± 1.4, rotation 6.9 ± 2.9
    assert np.all(np.ptp(trunk, axis=0) > [1.5, 2.0, 4.0])
    assert np.all(np.ptp(trunk, axis=0) < [5.8, 4.7, 9.8])
    assert np.abs(trunk.mean(axis=0) - [-2, 0, 0]).max() < 1.0
    for side, shift in (("r", 0.0), ("l", 0.5)):
        swing = angle(human, made, f"arm_flex_{side}")
        assert 25 < np.ptp(swing) < 40
        strike = (time / walk.stride_time + shift) % 1 < 0.02
        assert swing[strike].max() < np.quantile(swing, 0.2)  # the arm is back as its foot lands


def test_the_trunk_of_another_joint_set_turns_alike():
    turns = []
    for joints in ("42", "43", "58"):
        human = person(joints)
        _, time, qpos = book(human, 1.25)
        turns.append(trunk_angles(human, follow_the_legs(human, time, qpos, shown(human))))
    assert np.abs(turns[1] - turns[0]).max() < 0.2 and np.abs(turns[2] - turns[0]).max() < 0.2


def test_where_legs_stand_still_the_trunk_is_upright_and_the_arms_hang():
    human = person()
    time = np.arange(100) / 100
    qpos = np.tile(human.standing(), (100, 1))
    tilt = np.deg2rad(12.0)
    qpos[:, 3], qpos[:, 5] = np.cos(tilt / 2), np.sin(tilt / 2)  # the pelvis leans forward
    made = follow_the_legs(human, time, qpos, shown(human))
    assert np.abs(np.ptp(made, axis=0)).max() < 1e-9
    assert trunk_angles(human, made)[0] == pytest.approx([-2, 0, 0], abs=1e-6)
    assert angle(human, made, "arm_flex_r")[0] == pytest.approx(-5.0)
    assert 5 < angle(human, made, "elbow_flex_r")[0] < 20


def test_the_trunk_bends_forward_with_the_hips_and_is_upright_in_sitting():
    human = person()
    time, tilt = np.arange(90) / 100, np.deg2rad(np.repeat([0.0, 30.0, -30.0], 30))
    qpos = np.tile(human.standing(), (90, 1))
    qpos[:, 3], qpos[:, 5] = np.cos(tilt / 2), np.sin(tilt / 2)
    for side in "rl":
        qpos[30:, 7 + human.hinge(f"knee_angle_{side}")] = 1.5
    trunk = trunk_angles(human, follow_the_legs(human, time, qpos, shown(human)))[:, 0]
    assert trunk[[15, 45, 75]] == pytest.approx([-2, -32, -2], abs=0.5)


def test_arms_swing_more_in_faster_walking():
    human = person()
    ranges = []
    for speed in (0.7, 1.25, 1.8):
        _, time, qpos = book(human, speed)
        made = follow_the_legs(human, time, qpos, shown(human))
        ranges.append(np.ptp(angle(human, made, "arm_flex_r")))
    assert ranges[0] + 5 < ranges[1] < ranges[2] - 5


def test_arms_hang_from_a_trunk_that_markers_show():
    human = person()
    time = np.arange(60) / 100
    qpos = np.tile(human.standing(), (60, 1))
    qpos[:, 7 + human.hinge("lumbar_extension")] = np.deg2rad(-32)
    made = follow_the_legs(human, time, qpos, shown(human, PARTS["arms"]))
    assert np.array_equal(
        angle(human, made, "lumbar_extension"), angle(human, qpos, "lumbar_extension")
    )
    assert angle(human, made, "arm_flex_l")[0] == pytest.approx(-5 + 30, abs=0.1)


@pytest.fixture(scope="module")
def lower_body():
    """A walker fitted from the markers of pelvis and legs, one of unknown name beside the hip."""
    human, time, qpos = walker()
    known = markers_of(human, time, qpos, names=LEG_NAMES)
    hip = PointSet(human, ["pelvis"], np.array([[-0.02, 0.09, -0.08]])).path(qpos)
    names = (*known.names, "HJC")
    return human, qpos, fit_markers(
        recording(Markers(names, time, np.concatenate([known.positions, hip], axis=1)))
    )  # fmt: skip


def test_without_markers_on_it_the_upper_body_moves_and_is_called_assumed(lower_body):
    human, qpos, fit = lower_body
    assert {"lumbar_rotation", "neck_extension", "arm_flex_r", "elbow_flex_l"} <= set(fit.assumed)
    assert not {"hip_flexion_r", "knee_angle_l", "ankle_angle_r"} & set(fit.assumed)
    assert any("the trunk, the head and the arms" in w and "assumed" in w for w in fit.warnings)
    for side in "rl":
        name = f"arm_flex_{side}"
        ours, true = angle(human, fit.qpos, name), angle(human, qpos, name)
        assert np.ptp(ours) > 15 and np.corrcoef(ours, true)[0, 1] > 0.8
    assert not [name for name in fit.metrics if name.startswith(("trunk_", "neck_", "arms_"))]
    assert "pelvis_tilt_plane_mean_deg" in fit.metrics
    trial = analyse(fit)
    assert trial.figures["assumed_joints"] == list(fit.assumed)
    assert tuple(trial.record().signals["assumed.joints"]) == fit.assumed


def test_no_marker_is_put_on_a_body_of_which_nothing_is_seen(lower_body):
    _, _, fit = lower_body
    assert fit.attached == {"HJC": "pelvis"}


def test_with_markers_on_the_whole_body_no_part_is_assumed():
    human, time, qpos = walker(60)
    fit = fit_markers(recording(markers_of(human, time, qpos)))
    assert not any("assumed" in w for w in fit.warnings)
    assert not {n for n in fit.assumed if n.removesuffix("_r").removesuffix("_l") in UPPER}


def test_joint_angles_of_legs_alone_get_arms(tmp_path):
    human = person()
    walk, time, _ = book(human, 1.25)
    names = tuple(n for n in walk.coordinates if n.startswith(("hip", "knee", "ankle", "pelvis_t")))
    table = Table(names, time, np.stack([walk.coordinates[n] for n in names], axis=1))
    fit = fit_coordinates(Recording(tmp_path / "legs.mot", coordinates=table), Person(height=1.74))
    assert np.ptp(angle(fit.human, fit.qpos, "arm_flex_r")) > 20
    assert "arm_flex_r" in fit.assumed and "hip_flexion_r" not in fit.assumed
    assert any("no column of the file shows" in w for w in fit.warnings)


@pytest.fixture(scope="module")
def pair(data):
    """A recorded walk: whole, and with the markers of trunk, head and arms removed."""
    settings = FitSettings()
    whole = load(data / "c3d" / "HC032A03.c3d", settings)
    fit = fit_recording(whole, settings)
    assert fit.markers is not None
    low = ("pelvis", "femur", "tibia", "foot", "toes")
    place = zip(fit.markers.names, fit.places, strict=True)
    kept = [name for name, at in place if at.body.startswith(low)]

    def cut(recording):
        found = [recording.markers.index(n) for n in kept if n in recording.markers.names]
        names = tuple(recording.markers.names[i] for i in found)
        markers = Markers(names, recording.markers.time, recording.markers.positions[:, found])
        return replace(recording, markers=markers)

    legs = replace(cut(whole), static=cut(whole.static) if whole.static else None)
    return analyse(fit), analyse(fit_recording(legs, settings))


@pytest.mark.slow
def test_a_walk_whose_upper_body_is_removed_stays_nearly_the_same(pair):
    whole, legs = pair
    assert len(whole.motion.time) == len(legs.motion.time)
    share = legs.figures["residual_force_rms_share"]
    welded = np.array(legs.fit.qpos)
    hidden = [7 + legs.fit.human.hinge(name) for name in legs.fit.assumed]
    welded[:, hidden] = legs.fit.human.standing()[hidden]
    before = analyse(replace(legs.fit, qpos=welded)).figures["residual_force_rms_share"]
    assert share < 0.08 and share < 0.75 * before
    com = [
        np.array([s.com for s in sweep(t.fit.human, t.motion.qpos)]) for t in (whole, legs)
    ]  # fmt: skip
    away = com[1] - com[0]
    assert (away - away.mean(axis=0)).std(axis=0).max() < 0.006  # the path; the place is posture's
    for name, r, rms in (
        ("lumbar_bending", 0.85, 5), ("lumbar_rotation", 0.85, 5),
        ("arm_flex_r", 0.9, 10), ("arm_flex_l", 0.9, 10),
        ("elbow_flex_r", 0.7, 8), ("elbow_flex_l", 0.7, 8),
    ):  # fmt: skip
        a, b = (angle(t.fit.human, t.motion.qpos, name) for t in (whole, legs))
        assert np.corrcoef(a, b)[0, 1] > r, name
        assert (a - b).std() < rms, name
