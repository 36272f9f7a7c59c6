"""People of several sizes stand on their toes, and on plates that sway."""

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.control.balance import Balance, posture_reference, script_named, scripted
from plantigrade.models import Human
from plantigrade.world import Tilting, World, on_ground, standing_on

pytestmark = pytest.mark.slow
RATES = {"rate": 900.0, "control_rate": 90.0, "recording": False}


@pytest.mark.parametrize(("height", "mass"), [(1.45, 45.0), (1.7, 65.0), (1.95, 110.0)])
def test_people_of_all_sizes_stand_on_tiptoe(height, mass):
    human = Human.create(height, mass, "female", "66", "multi-segment")
    reference = scripted(human, script_named("tiptoe"))
    world = World(human, **RATES)
    state = world.reset(qpos=on_ground(human, world.ground, reference.motion.qpos[0]))
    controller, heel = Balance(reference), [s.name.startswith("heel") for s in world.sites]
    lifted = 0.0
    while world.time < float(reference.time[-1]) + 1.0 and world.fall is None:
        state = world.step(controller(state))
        if state.contact_force[heel, 2].sum() < 0.01 * human.mass * GRAVITY:
            lifted += 1.0 / world.control_rate
    assert world.fall is None
    assert lifted > 8.0


@pytest.mark.parametrize("direction", [0.0, np.pi / 2])
def test_people_stand_on_a_plate_that_sways(direction):
    human = Human.create(1.5, 48.5, "female", "66", "multi-segment")
    plate = Tilting(amplitude=np.deg2rad(15.0), period=4.0, direction=direction)
    world = World(human, disturbances=(plate,), **RATES)
    state = world.reset(qpos=standing_on(human, world.ground))
    controller = Balance(posture_reference(world, np.array(state.qpos)))
    lean = 0.0
    while world.time < 8.0 and world.fall is None:
        state = world.step(controller(state))
        lean = max(lean, float(np.arccos(state.body.rotation(human.trunk)[2, 2])))
    assert world.fall is None
    assert lean < np.deg2rad(20.0)
