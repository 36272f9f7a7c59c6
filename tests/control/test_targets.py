"""Targets that may be set while a controller runs: knees, hips, where the weight is."""

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.control import Posture
from plantigrade.control.balance import Balance
from plantigrade.models import Human
from plantigrade.world import World, standing_on

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")


def test_a_bent_person_has_the_soles_on_the_ground_and_the_weight_over_them():
    flexion = {"knee_angle": 0.6, "hip_flexion": 0.7, "ankle_angle": -0.1}
    plain, bowed = (standing_on(HUMAN, Ground(), flexion=b) for b in (None, flexion))
    states = [World(HUMAN, recording=False, qpos=q).reset().body for q in (plain, bowed)]
    feet = [s.origins[HUMAN.body("foot_r")] for s in states]
    ahead = [s.com[0] - foot[0] for s, foot in zip(states, feet, strict=True)]
    assert ahead[0] == pytest.approx(ahead[1], abs=2e-3)
    assert feet[0][2] == pytest.approx(feet[1][2], abs=2e-3)
    assert states[1].com[2] < states[0].com[2] - 0.02
    up = [s.rotation(HUMAN.body("foot_r"))[2] for s in states]
    np.testing.assert_allclose(*up, atol=0.03)  # 1.5°: the axes of the ankles are oblique


def test_knees_bend_as_far_as_the_slider_says_and_the_person_stands():
    control = Posture(qpos=standing_on(HUMAN, Ground()))
    world = World(HUMAN, rate=300.0, recording=False)
    state = world.reset()
    knees, bow = control.targets[1:]
    knees.set(30.0)
    bow.set(10.0)
    before = state.body.com[2]
    while world.time < 1.5:
        state = world.step(control(state))
    angles = np.rad2deg(state.angles)
    assert angles[HUMAN.hinge("knee_angle_l")] == pytest.approx(30.0, abs=1.5)
    assert angles[HUMAN.hinge("hip_flexion_l")] == pytest.approx(25.0, abs=2.0)
    assert world.fall is None and state.body.com[2] < before - 0.01
    assert Posture().targets[1:] == ()  # of a motion, only the stiffness


@pytest.mark.slow
def test_the_weight_goes_where_the_sliders_of_balance_have_it():
    control = Balance()
    world = World(HUMAN, rate=300.0, control_rate=50.0, recording=False)
    state = world.reset()
    while world.time < 0.8:  # to where balance has it
        state = world.step(control(state))
    before = state.body.com
    ahead, left, _ = control.targets
    ahead.set(2.0)
    left.set(-5.0)
    while world.time < 2.4:
        state = world.step(control(state))
    moved = 100.0 * (state.body.com - before)
    np.testing.assert_allclose(moved[:2], [2.0, -5.0], atol=0.8)
    (drawn,) = control.drawings(state)
    np.testing.assert_allclose(drawn.points[0], state.body.com, atol=0.02)
    assert world.fall is None
