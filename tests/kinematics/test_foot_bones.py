"""Feet without bones get them from the ground: toes that press lie on it, and nothing jumps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from plantigrade.kinematics.foot_bones import (
    EDGE,
    FLAT,
    NONE,
    TIPS,
    TOES,
    ankle_angles,
    foot_path,
    on_feet_with_bones,
    pressing,
    with_bones,
)
from plantigrade.kinematics.foot_pose import MAX_TOE_BEND, FootPoser
from plantigrade.kinematics.ground_normal import hinge_angles, hinge_turn
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, contact_metrics, find_rests
from plantigrade.kinematics.state import BodyState
from plantigrade.kinematics.textbook_recording import textbook_walk
from tests.models.presets import person

BODY = person("66", "multi-segment")
RATE = 100.0
INNER = ("mtp", "cuboid", "heel")


@pytest.fixture(scope="module")
def walk():
    """A walk on stiff feet: time, poses and what rests."""
    made = textbook_walk(BODY, cycles=1)
    qpos = made.qpos.copy()
    qpos[:, [7 + i for i, c in enumerate(BODY.coordinates) if c.startswith(INNER)]] = 0.0
    return np.arange(len(qpos)) / RATE, qpos, find_rests(sole_paths(BODY, qpos), RATE)


def hinge(qpos, name):
    return qpos[:, 7 + BODY.hinge(name)]


def test_a_walk_on_stiff_feet_gets_toes_that_bend(walk):
    bony, figures = with_bones(BODY, *walk)
    bend = hinge(bony, "mtp_angle_r").max()
    assert np.deg2rad(20) < bend <= MAX_TOE_BEND + 0.03  # where two poses are mixed, a little more
    assert figures["ankle_out_of_reach_max_mm"] < 30


@pytest.mark.slow
def test_feet_with_bones_are_planted_with_less_to_bend(walk):
    time, qpos, rests = walk
    bony, _ = with_bones(BODY, time, qpos, rests)
    planted, stiff = (plant_feet(BODY, q, rate=RATE, rests=rests) for q in (bony, qpos))
    assert sole_paths(BODY, planted).penetration.max() < 0.004
    for name in ("mtp_angle_r", "mtp4_angle_r"):
        bent = [
            np.abs(hinge(x, name) - hinge(y, name)) for x, y in ((planted, bony), (stiff, qpos))
        ]
        assert bent[0].mean() < bent[1].mean()


@pytest.mark.slow
@pytest.mark.parametrize("feet", ["rigid", "two-segment"])
def test_a_motion_on_feet_without_bones_goes_over_to_feet_with_bones(feet):
    made = textbook_walk(person("42", feet), cycles=1)
    human, qpos, figures = on_feet_with_bones(made.human, made.time, made.qpos)
    assert human.feet == "multi-segment" and human.mass == made.human.mass
    paths = sole_paths(human, qpos)
    assert paths.penetration.max() < 0.005
    rests = find_rests(paths, RATE)
    before = find_rests(sole_paths(made.human, made.qpos), RATE)
    assert {(r.side, r.region) for r in before} <= {(r.side, r.region) for r in rests}
    drift = contact_metrics(paths, rests, np.zeros((len(qpos), 3)))
    assert drift["foot_drift_max_mm"] < 15
    for name in ("hip_flexion_r", "knee_angle_r", "arm_flex_l"):
        one, other = qpos[:, 7 + human.hinge(name)], hinge_of(made, name)
        assert np.sqrt(np.mean((one - other) ** 2)) < np.deg2rad(4)
    assert figures["ankle_out_of_reach_max_mm"] < 40


def hinge_of(made, name):
    return made.qpos[:, 7 + made.human.hinge(name)]


def test_no_joint_jumps_where_what_presses_changes(walk):
    time, qpos, rests = walk
    bony, _ = with_bones(BODY, time, qpos, rests)
    rate = np.abs(np.diff(bony[:, 7:], axis=0)) * RATE
    assert np.rad2deg(rate.max()) < 1500
    own = [7 + i for i, c in enumerate(BODY.coordinates) if c.startswith(INNER)]
    fine = np.abs(np.diff(bony[:, own], n=2, axis=0)).max()
    assert np.rad2deg(fine) < 4, "per frame of 10 ms, twice differenced"


def test_what_the_recording_shows_stays(walk):
    time, qpos, rests = walk
    qpos = qpos.copy()
    qpos[:, 7 + BODY.hinge("mtp_angle_r")] = 0.1
    bony, _ = with_bones(BODY, time, qpos, rests, known=("mtp_angle_r",), turns=False)
    same = [c for c in BODY.coordinates if not c.startswith(INNER)] + ["mtp_angle_r"]
    for name in same:
        np.testing.assert_array_equal(hinge(bony, name), hinge(qpos, name))
    assert hinge(bony, "mtp_angle_l").max() > 0.2
    np.testing.assert_array_equal(bony[:, :7], qpos[:, :7])


def test_what_presses_follows_from_rests_and_the_ankles_height():
    rests = [
        ContactFrames("r", "heel", 1, 6),
        ContactFrames("r", "ball", 3, 8),
        ContactFrames("r", "toes", 3, 9),
    ]
    rests += [ContactFrames("l", "heel", 0, 10)]
    height = np.array([0.1, 0.1, 0.1, 0.05, 0.05, 0.08, 0.1, 0.1, 0.1, 0.1])
    found = pressing(rests, "r", height, 0.06)
    assert found.tolist() == [NONE, EDGE, EDGE, FLAT, FLAT, TOES, TOES, TOES, TOES, NONE]


def test_a_foot_that_rises_over_its_toes_bends_them_then_rolls_onto_their_tips():
    poser, n = FootPoser(BODY, "r"), 101
    time = np.linspace(0, 1, n)
    height = poser.standing + np.linspace(0, 0.12, n)
    ankle = np.stack([np.zeros(n), np.zeros(n), height], axis=1)
    level = np.tile(np.eye(3), (n, 1, 1))
    path = foot_path(poser, time, ankle, level, level, np.full(n, TOES))
    assert path.pressing[0] == TOES and path.pressing[-1] == TIPS
    bend = path.angles[:, poser.coordinates.index("mtp_angle_r")]
    assert bend.max() == pytest.approx(MAX_TOE_BEND, abs=0.02) and (np.diff(bend[:50]) > 0).all()
    pitch = -np.arcsin(path.rotation[:, 2, 0])
    assert (np.diff(pitch) > 0).all() and np.diff(pitch, n=2).max() < 0.004
    assert np.abs(path.shift).max() < 1e-9


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-0.6, 0.6), min_size=3, max_size=3), st.sampled_from("rl"))
def test_hinges_of_foot_and_ankle_are_found_again(angles, side):
    sign = 1.0 if side == "r" else -1.0
    angles = np.array([angles])
    np.testing.assert_allclose(hinge_angles(hinge_turn(angles, sign), sign), angles, atol=1e-12)
    q = BODY.standing()
    for c, a in zip(("ankle_angle", "subtalar_angle", "ankle_rotation"), angles[0], strict=True):
        q[7 + BODY.hinge(f"{c}_{side}")] = a
    for c, a in zip(("heel_angle", "heel_inversion", "heel_adduction"), angles[0], strict=True):
        q[7 + BODY.hinge(f"{c}_{side}")] = a
    state = BodyState(BODY, q)
    shank, foot = state.rotation(f"tibia_{side}")[None], state.rotation(f"foot_{side}")[None]
    np.testing.assert_allclose(ankle_angles(BODY, side, shank, foot), angles, atol=1e-6)
    heel = foot[0].T @ state.rotation(f"heel_{side}")
    np.testing.assert_allclose(hinge_turn(angles, sign)[0], heel, atol=1e-12)


def test_two_hinges_come_as_near_as_they_can():
    human = person("42", "multi-segment")
    target = Rotation.from_euler("zyx", [0.1, 0.3, 0.05]).as_matrix()[None]
    found = ankle_angles(human, "r", np.eye(3)[None], target)
    q = human.standing()
    index = [7 + human.hinge(c) for c in ("ankle_angle_r", "subtalar_angle_r")]

    def off(angles):
        q[index] = angles
        state = BodyState(human, q)
        turned = state.rotation("tibia_r").T @ state.rotation("foot_r")
        return Rotation.from_matrix(target[0] @ turned.T).magnitude()

    assert off(found[0]) < 0.15
    for step in ([1e-3, 0], [-1e-3, 0], [0, 1e-3], [0, -1e-3]):
        assert off(found[0]) <= off(found[0] + step)
