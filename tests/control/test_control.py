"""Springs: a posture that does not sag, a motion that is followed."""

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.control import Posture, Tracking
from plantigrade.control.posture import resting_torques
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.world import World, standing_on

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")


def test_a_posture_that_is_held_neither_sags_nor_sways():
    world = World(HUMAN, rate=300.0)
    record = world.simulate(Posture(), 1.5)
    moved = record.motion.qpos - record.motion.qpos[0]
    assert np.abs(moved[:, :3]).max() < 0.025 and np.abs(moved[:, 7:]).max() < np.deg2rad(1.0)
    assert abs(moved[-1, 2]) < 5e-4  # without torques of rest it sags by 2 mm
    assert np.abs(record.motion.qvel[-1]).max() < 0.02
    assert record.signals["controller.posture_error"].max() < 0.05


def test_the_torques_of_rest_carry_the_weight_before_the_ankles():
    qpos = standing_on(HUMAN, Ground())
    torque = resting_torques(HUMAN, Ground(), qpos)
    ankles = [torque[HUMAN.hinge(f"ankle_angle_{side}")] for side in ("r", "l")]
    ahead = HUMAN.mass * 9.81 * 0.05  # the weight, some 5 cm before the ankles
    assert -1.6 * ahead < sum(ankles) < -0.6 * ahead
    assert ankles[0] == pytest.approx(ankles[1], rel=0.05)


def test_nothing_is_carried_in_the_air():
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 0.5
    assert not resting_torques(HUMAN, Ground(), qpos).any()


def test_a_motion_is_followed_and_then_held():
    time = np.arange(0.0, 1.001, 0.01)
    qpos = np.tile(standing_on(HUMAN, Ground()), (len(time), 1))
    qvel = np.zeros((len(time), HUMAN.model.nv))
    elbow = HUMAN.hinge("elbow_flex_r")
    qpos[:, 7 + elbow] += 0.25 * (1 - np.cos(2 * np.pi * time))
    qvel[:, 6 + elbow] = 0.5 * np.pi * np.sin(2 * np.pi * time)
    motion = Motion(time + 3.0, qpos, qvel, HUMAN.joint_names)  # on a clock of its own
    world = World(HUMAN, rate=300.0, qpos=qpos[0])
    followed = world.simulate(Tracking(motion), 1.0).motion.qpos[:, 7 + elbow]
    np.testing.assert_allclose(followed, qpos[:, 7 + elbow], atol=0.03)
    angles, rates = Tracking(motion).at(2.0)
    assert np.array_equal(angles, qpos[-1, 7:]) and not rates.any()
