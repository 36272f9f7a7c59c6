"""Fixtures of the tests of walks."""

import pytest

from plantigrade.control.pendulum import walk_of
from plantigrade.models import Human
from plantigrade.world import World
from tests.textbook import walk_record


@pytest.fixture(scope="session")
def walk():
    """The textbook walk of a person, a stride of it closed."""
    human = Human.create(1.7, 65.0, "female", "42", "two-segment")
    return walk_of(walk_record(human, speed=1.2, rate=60.0, cycles=2))


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
