"""Motions brought to where the feet can carry them."""

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance import MotionReference, feasible_motion
from plantigrade.control.balance.feasible import feasible_path
from plantigrade.control.gait.support import beyond
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run
from plantigrade.workflows.simulate import simulate
from plantigrade.world import on_ground

SOLE = np.array([[-0.1, -0.05, 0.0], [-0.1, 0.05, 0.0], [0.15, -0.05, 0.0], [0.15, 0.05, 0.0]])


def pressures(time, com):
    """Return where the pressure of a pendulum is."""
    step = time[1] - time[0]
    bend = np.diff(com, 2, axis=0) / step**2
    inner = com[1:-1]
    return inner[:, :2] - (inner[:, 2:] / (GRAVITY + bend[:, 2:])) * bend[:, :2]


def swaying(amplitude):
    """Return a person who sways at 0.5 Hz forward and back [m], and the support below."""
    time = np.arange(400) / 100.0
    com = np.zeros((400, 3))
    com[:, 0], com[:, 2] = 0.02 + amplitude * np.sin(np.pi * time), 1.0
    return time, com, np.tile(SOLE, (400, 1, 1)), np.ones((400, 4), dtype=bool)


def test_a_motion_that_the_feet_carry_is_left_as_it_is():
    time, com, spheres, contact = swaying(0.02)
    path = feasible_path(time, com, spheres, contact)
    assert np.abs(path - com)[50:-50].max() < 1e-3


def test_one_they_do_not_carry_has_its_pressure_inside_and_changes_no_more_than_that():
    time, com, spheres, contact = swaying(0.12)
    path = feasible_path(time, com, spheres, contact)
    before, after = pressures(time, com), pressures(time, path)
    outside = max(beyond(SOLE[:, :2], p) for p in before)
    assert outside > 0.05
    assert max(beyond(SOLE[:, :2], p) for p in after) < 0.0
    assert np.abs(path - com).max() < outside + 0.02
    assert np.array_equal(path[:, 2], com[:, 2])


def test_without_contact_and_of_two_frames_the_path_stays():
    time, com, spheres, contact = swaying(0.12)
    assert np.abs(feasible_path(time, com, spheres, ~contact) - com).max() < 1e-3
    two = feasible_path(time[:2], com[:2], spheres[:2], contact[:2])
    assert np.array_equal(two, com[:2])


def test_postures_follow_and_the_feet_stay():
    human = Human.create()
    qpos = np.tile(human.standing(), (40, 1))
    motion = Motion(np.arange(40) / 50.0, qpos, np.zeros((40, human.model.nv)), human.joint_names)
    contact = np.tile([site.side == "l" for site in contact_sites(human)], (40, 1))
    asked = MotionReference(human, motion, contact)
    moved = MotionReference(human, feasible_motion(human, asked), contact)
    left = asked.spheres[0][contact[0], :2]
    assert beyond(left, asked.com[0, :2]) > 0.03  # on the left foot alone this posture falls
    assert max(beyond(left, com[:2]) for com in moved.com) < 0.0
    assert np.abs(moved.spheres - asked.spheres).max() < 0.003
    assert np.abs(moved.com[:, 2] - asked.com[:, 2]).max() < 0.01


@pytest.mark.parametrize("controller", ["balance", "hybrid"])
def test_a_run_of_one_frame_is_a_posture_that_is_held(controller):
    human = Human.create(joints="42")
    qpos = on_ground(human, Ground(), human.standing())[None]
    motion = Motion(np.zeros(1), qpos, np.zeros((1, human.model.nv)), human.joint_names)
    run = simulate(Run(Record(human, motion), "reproduce"), controller=controller, duration=0.05)
    assert run.ok
    assert np.allclose(run.record.motion.qpos[-1, 7:], qpos[0, 7:], atol=0.07)  # soles yield


@pytest.mark.slow
def test_a_recorded_balance_on_one_leg_is_held(data):
    recording = data / "cmu_asfamc" / "49_18.amc"
    run = simulate(recording, controller="balance", feet="two-segment", duration=2.5)
    assert run.ok
    assert any("carry" in note for note in run.record.notes)
