"""Fixtures of the tests of walks."""

import numpy as np
import pytest

from plantigrade.control.pendulum import walk_of
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import World


@pytest.fixture(scope="session")
def walk():
    """The textbook walk of a person, a stride of it closed."""
    human = Human.create(1.7, 65.0, "female", "42", "two-segment")
    textbook = textbook_walk(human, speed=1.2, rate=60.0, cycles=2)
    rest = np.zeros((len(textbook.time), human.model.nv))
    motion = Motion(textbook.time, textbook.qpos, rest, human.joint_names, events=textbook.events)
    return walk_of(Record(human, motion))


@pytest.fixture(scope="session")
def world_of(walk):
    """Makes the world in which a controller walks the textbook walk."""

    def made(controller) -> World:
        return World(
            walk.human,
            walk.ground,
            rate=controller.rates.physics,
            control_rate=controller.rates.control,
            recording=False,
            qpos=walk.motion.qpos[0],
            qvel=walk.motion.qvel[0],
        )

    return made
