"""The paper's formulation: what it asks for, and that it stands."""

import numpy as np
import pytest

from plantigrade.control.balance import Hybrid
from plantigrade.models import Human
from plantigrade.world import Push, Tilting, World

SMALL = Human.create(1.5, 48.5, "female", "66", "multi-segment")


def simulated(duration, disturbance):
    """Return the world after so long, and the record."""
    world = World(SMALL, disturbances=(disturbance,), rate=900.0, control_rate=30.0)
    return world, world.simulate(Hybrid(), duration)


@pytest.fixture(scope="module")
def pushed():
    return simulated(1.2, Push(force=40.0, duration=0.4, time=0.2))


def test_it_stands_and_is_pushed_and_stands(pushed):
    world, record = pushed
    error = record.signals["controller.com_error"]
    assert world.fall is None and 0.005 < np.nanmax(error) < 0.1 and error[-2] < 0.02
    low, high = SMALL.model.jnt_actfrcrange[1:].T
    motor = record.signals["world.motor"]
    assert ((motor > 0.9 * low) & (motor < 0.9 * high)).all()  # what it takes, a person has
    assert not record.signals["controller.joints_beyond_strength"][:-1].any()


def test_joints_have_the_commanded_accelerations(pushed):
    world, _ = pushed
    controller, state = Hybrid(), world.reset()
    for _ in range(6):
        command = controller(state)
        before = state.rates.copy()
        state = world.step(command)
    got = (state.rates - before) * 30.0
    np.testing.assert_allclose(got, command.acceleration, atol=0.1)


def test_the_feet_are_held_where_the_constraint_has_more_rows_than_they_can_move(pushed):
    """24 rows for 18 degrees of freedom a foot; what it leaves is small all the same."""
    _, record = pushed
    assert np.nanmax(record.signals["controller.support_residual"]) < 0.05


def test_it_goes_with_a_platform_that_sways():
    platform = Tilting(amplitude=np.deg2rad(10.0), period=2.0, direction=np.pi / 2)
    world, record = simulated(1.0, platform)
    tilt = np.rad2deg(record.signals["ground.place"][:, 3])
    assert world.fall is None and np.abs(tilt).max() > 2.0
    assert world.reset().body.rotation("torso")[2, 2] > 0.99
