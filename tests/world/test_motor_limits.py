"""Motors keep to their strength in every step, and their law is that of stable PD with limits."""

import numpy as np
import pytest

from plantigrade.analyze.check import check
from plantigrade.contact.ground import Ground
from plantigrade.dynamics.muscle_speed import OMEGA_0, velocity_factor
from plantigrade.models import Human
from plantigrade.world import StablePD, World, standing_on

HUMAN = Human.create(1.7, 65.0, "female", "42", "two-segment")
LOW, HIGH = np.array(HUMAN.model.jnt_actfrcrange[1:]).T
H = 1.0 / 600.0
DROP = 0.25  # [m]


def landing(**options):
    """Return the record of somebody who drops on stiff legs, and what was asked for."""
    qpos = standing_on(HUMAN, Ground())
    target = qpos[7:].copy()
    qpos[2] += DROP
    world = World(HUMAN, rate=600.0, record_rate=600.0, qpos=qpos, **options)
    stiffness, damping = world.actuators.stiffness, world.actuators.damping
    record = world.simulate(lambda _: StablePD(target), 0.4)
    return record, target, stiffness, damping


def test_a_hard_strike_does_not_make_motors_stronger():
    """Without the part within the step an ankle gave three times its strength."""
    record, target, stiffness, damping = landing()
    motor = record.signals["world.motor"]
    use = motor / np.where(motor > 0, HIGH, -LOW)
    assert np.abs(use).max() == pytest.approx(1.0, abs=1e-3)
    motion = record.motion
    angles, rates, bend = motion.qpos[:, 7:], motion.qvel[:, 6:], motion.qacc[:, 6:]
    law = stiffness * (target - angles - H * rates) - damping * rates
    law -= H * (damping + H * stiffness) * bend
    np.testing.assert_allclose(motor, np.clip(law, LOW, HIGH), atol=2e-3 * HIGH.max())
    assert (np.abs(law) > 1.5 * np.maximum(HIGH, -LOW)).any()  # limits did act
    verdict = check(record)
    assert verdict.measures["root_force"].value < 0.05
    torque = record.qfrc_actuator[:, 6:]
    np.testing.assert_allclose(verdict.tau[:, 6:], torque, atol=0.01 * HIGH.max())

    loose = landing(exact_limits=False)[0].signals["world.motor"]
    assert np.abs(loose / np.where(loose > 0, HIGH, -LOW)).max() > 1.5


def test_where_no_limit_is_met_nothing_is_different():
    target = standing_on(HUMAN, Ground())[7:]
    found = []
    for exact in (True, False):
        world = World(HUMAN, rate=300.0, exact_limits=exact)
        found.append(world.simulate(lambda _: StablePD(target), 0.1).motion.qpos)
    np.testing.assert_array_equal(*found)


def test_limits_hold_while_torques_rise():
    record = landing(torque_rise=0.05)[0]
    motor = record.signals["world.motor"]
    assert np.abs(motor / np.where(motor > 0, HIGH, -LOW)).max() < 1.0 + 1e-3
    steps = np.abs(np.diff(motor, axis=0)) / np.maximum(HIGH, -LOW)
    assert steps.max() < 1.1 * 0.01 / 0.05  # from one control step to the next at most


def test_torques_fall_with_the_speed_of_their_joint():
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 1.0
    world = World(HUMAN, rate=600.0, record_rate=600.0, qpos=qpos, torque_speed=True)
    record = world.simulate(lambda _: StablePD(qpos[7:] + 1.0), 0.1)
    motor, rates = record.signals["world.motor"], record.motion.qvel[:, 6:]
    share = np.abs(motor / np.where(motor > 0, HIGH, -LOW))
    most = np.minimum(velocity_factor(np.sign(motor) * rates / OMEGA_0), 1.0)
    share, most = share[:-1], most[:-1]  # limits are not set anew for the last frame
    assert (share < most + 1e-3).all() and (share > most - 1e-3)[most < 0.5].any()
    np.testing.assert_array_equal(world.actuators.limits(np.zeros(len(LOW))), [LOW, HIGH])
