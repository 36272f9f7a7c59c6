"""The body in a world: it touches itself where it should, and energy and momentum add up."""

import numpy as np
import pytest

from plantigrade.analyze.check import check
from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import ContactSite
from plantigrade.control import passive
from plantigrade.models import FEET, JOINT_SETS, Human
from plantigrade.world import Torque, World, standing_on

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
PAIRS = {  # coordinates that bring two parts together [rad] → what then touches
    "leg and leg": ({"hip_adduction_r": 0.4, "hip_adduction_l": 0.4}, ("femur", "tibia")),
    "arm and trunk": ({"arm_add_r": 0.3, "elbow_flex_r": 0.5}, ("pelvis", "torso")),
    "foot and foot": ({"hip_rotation_r": 0.6, "hip_rotation_l": 0.6}, ("foot",)),
}


def touching(human: Human, qpos: np.ndarray) -> set[frozenset[str]]:
    """Return the pairs of bodies of a person that touch each other."""
    world = World(human, rate=300.0, qpos=qpos, recording=False)
    world.reset()
    owner = world.model.geom_bodyid[world.data.contact.geom]
    names = ["", *human.body_names]
    own = owner[(owner > 0).all(axis=1)]
    return {frozenset(names[b] for b in pair) for pair in own}


@pytest.mark.parametrize("joints", JOINT_SETS)
@pytest.mark.parametrize("feet", FEET)
def test_no_parts_of_a_standing_person_touch(joints, feet):
    human = Human.create(joints=joints, feet=feet)
    assert touching(human, standing_on(human, Ground())) == set()


@pytest.mark.parametrize("name", PAIRS)
def test_parts_of_the_body_stop_each_other(name):
    angles, parts = PAIRS[name]
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 0.5
    for coordinate, angle in angles.items():
        qpos[7 + HUMAN.hinge(coordinate)] += angle
    found = touching(HUMAN, qpos)
    assert any(body.startswith(parts) for pair in found for body in pair), found


def test_contact_with_itself_is_no_force_from_outside():
    """Legs that press against each other in the air: the body as a whole just falls."""
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 1.0
    torque = np.zeros(len(HUMAN.coordinates))
    for side in ("r", "l"):
        torque[HUMAN.hinge(f"hip_adduction_{side}")] = 40.0
    world = World(HUMAN, rate=600.0, qpos=qpos, passive=False)
    record = world.simulate(lambda state: Torque(torque), 0.25)
    assert world.data.ncon > 0 and record.contact_force is not None
    assert not record.contact_force.any()
    verdict = check(record)
    assert verdict.measures["root_force"].value < 0.05
    assert verdict.measures["root_moment"].value < 0.05


def test_energy_is_the_work_of_the_joints_and_momentum_the_impulse():
    """In the air, at every step of the physics; within what a step of 1/1800 s allows."""
    qpos = standing_on(HUMAN, Ground())
    qpos[2] += 1.0
    rng = np.random.default_rng(1)
    low, high = np.array(HUMAN.model.jnt_actfrcrange[1:]).T
    torque = 0.02 * rng.uniform(low, high)
    world = World(HUMAN, rate=1800.0, record_rate=200.0, qpos=qpos, passive=False)
    verdict = check(world.simulate(lambda state: Torque(torque), 0.05))
    assert verdict.measures["energy"].value < 2.0 and verdict.measures["momentum"].value < 0.5


def test_a_seat_carries_the_places_that_rest_on_it_and_nothing_else():
    """A board as high as the pelvis, through which the arms hang: it pushes the pelvis alone."""
    qpos = standing_on(HUMAN, Ground())
    radius = 0.05
    sites = [
        ContactSite(body="pelvis", position=(0.0, y, -0.1), radius=radius, name=f"seat_{side}")
        for side, y in (("r", -0.1), ("l", 0.1))
    ]
    top = float(qpos[2]) - 0.1 - radius
    places = [(float(qpos[0]), site.position[1], top) for site in sites]
    seats = tuple(Seat(site.name, place) for site, place in zip(sites, places, strict=True))
    world = World(HUMAN, Ground(seats=seats), rate=300.0, qpos=qpos, sites=sites)
    record = world.simulate(passive, 0.2)
    force = {s.name: record.contact_force[-1, i, 2] for i, s in enumerate(record.sites)}
    assert force["seat_r"] > 50.0 and force["seat_l"] > 50.0 and world.fall is None
    assert not [site.name for site in record.sites if site.part == "touch"]
    assert check(record).measures["root_force"].value < 0.05
