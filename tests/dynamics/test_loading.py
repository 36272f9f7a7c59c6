"""When feet and seat carry, from the motion alone: postures and flights whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import seat_sites
from plantigrade.dynamics.loading import SEAT, find_loading, leaves_the_ground
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Motion
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    pelvis_angles_to_quaternion,
)
from plantigrade.trajopt.tasks.chair import seated_posture

TIME = np.arange(60) / 50.0


@pytest.fixture(scope="module")
def human() -> Human:
    return Human.create(height=1.75, mass=70.0)


def of(found, side):
    return [c for c in found.contacts if side in (c.side, c.region)]


def at_rest(human: Human, qpos: np.ndarray) -> Motion:
    nv = human.model.nv
    still = np.zeros((len(qpos), nv))
    return Motion(TIME, qpos, still, human.joint_names, still)


def standing(human: Human) -> np.ndarray:
    qpos = np.tile(human.standing(), (len(TIME), 1))
    qpos[:, 2] -= lowest(human, qpos[:1])
    return qpos


def kneeling_up(human: Human, qpos: np.ndarray, knee: float) -> np.ndarray:
    """Return the motion with the right foot drawn up by its knee [rad] in the middle of it."""
    out = qpos.copy()
    out[20:40, 7 + human.hinge("knee_angle_r")] = knee
    out[20:40, 7 + human.hinge("hip_flexion_r")] = knee
    return out


def test_standing_feet_carry_all_the_time(human):
    found = find_loading(human, at_rest(human, standing(human)))
    for spans in (of(found, side) for side in SIDES):
        assert [(s.start, s.stop, s.begins, s.ends) for s in spans] == [(0.0, 1.18, False, False)]
    assert not found.walks
    assert not found.flies
    assert found.supports == ()


def test_a_foot_held_up_beside_a_standing_one_carries_nothing(human):
    found = find_loading(human, at_rest(human, kneeling_up(human, standing(human), 1.0)))
    before, after = of(found, "r")
    assert (before.begins, before.ends, after.begins, after.ends) == (False, True, True, False)
    assert before.stop == pytest.approx(0.39, abs=0.02)
    assert after.start == pytest.approx(0.79, abs=0.02)
    assert len(of(found, "l")) == 1


def test_a_foot_lifted_between_its_events_carries_nothing_there(human):
    """A kick, or a foot that is put on a rung: gait events know it as one stance."""
    motion = at_rest(human, kneeling_up(human, standing(human), 1.0))
    events = (GaitEvent(0.1, "r", "heel_strike"), GaitEvent(1.1, "r", "toe_off"))
    before, after = of(find_loading(human, replace(motion, events=events)), "r")
    assert before.rolls and before.begins and before.ends and after.ends
    assert before.stop == pytest.approx(0.39, abs=0.02)
    assert after.start == pytest.approx(0.79, abs=0.02)
    flat = replace(at_rest(human, standing(human)), events=events)
    (whole,) = of(find_loading(human, flat), "r")
    assert (whole.start, whole.stop) == (before.start, after.stop)


def test_a_jump_is_timed_by_its_soles(human):
    qpos = standing(human)
    flight = np.maximum(0.0, 2.0 * (TIME - 0.4) - 0.5 * 9.81 * (TIME - 0.4) ** 2)
    qpos[:, 2] += np.where(TIME > 0.4, flight, 0.0)
    assert leaves_the_ground(TIME, sole_paths(human, qpos))
    assert not leaves_the_ground(TIME, sole_paths(human, standing(human)))
    found = find_loading(human, at_rest(human, qpos))
    assert found.flies
    for spans in (of(found, side) for side in SIDES):
        assert [s.stop for s in spans] == [pytest.approx(0.4, abs=0.015), 1.18]
        assert spans[1].start == pytest.approx(0.4 + 4.0 / 9.81, abs=0.015)


def test_feet_on_a_box_carry_and_fall_without(human):
    qpos = standing(human)
    fall = 0.3 - 0.5 * 9.81 * np.maximum(TIME - 0.6, 0.0) ** 2
    qpos[:, 2] += np.maximum(fall, 0.0)
    found = find_loading(human, at_rest(human, qpos))
    for spans in (of(found, side) for side in SIDES):
        assert [s.begins for s in spans] == [False, True]
        assert 0.58 < spans[0].stop < 0.68
        assert spans[1].start == pytest.approx(0.6 + np.sqrt(0.6 / 9.81), abs=0.01)


def seated(human: Human) -> np.ndarray:
    q = seated_posture(human, 0.45)
    root = OPENSIM_TO_WORLD @ q[3:6]
    quat = pelvis_angles_to_quaternion(q[None, :3])[0]
    return np.tile(np.concatenate([root, quat, q[6:]]), (len(TIME), 1))


def test_a_seat_carries_a_sitting_person_until_the_ischia_rise(human):
    qpos = seated(human)
    qpos[40:, 2] += 0.5 * (TIME[40:] - TIME[39])
    found = find_loading(human, at_rest(human, qpos))
    (span,) = of(found, SEAT)
    assert (span.start, span.begins, span.ends) == (0.0, False, True)
    assert span.stop == pytest.approx(TIME[39] + 0.03 / 0.5, abs=0.01)
    assert [each.body for each in found.supports] == ["pelvis"]


def test_feet_below_the_centre_of_mass_need_no_seat(human):
    assert find_loading(human, at_rest(human, seated(human))).supports
    qpos = seated(human)
    for side in SIDES:  # shanks drawn back under the thighs
        qpos[:, 7 + human.hinge(f"knee_angle_{side}")] += 0.9
        qpos[:, 7 + human.hinge(f"ankle_angle_{side}")] += 0.9
    assert find_loading(human, at_rest(human, qpos)).supports == ()


def test_the_ischia_are_below_the_hips(human):
    right, left = seat_sites(human)
    hip = human.model.body_pos[human.body("femur_r")]
    assert right.position[2] < hip[2] - 0.03
    assert right.position[1] == -left.position[1] < 0.0
