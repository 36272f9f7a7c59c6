"""One tick of a replay: how long the controller thinks, of the processor.

Quiet standing on both feet, every sphere of the soles carrying, is the most that a tick has to do;
a walk has one foot on the ground most of the time.
"""

import time
from collections.abc import Iterator

import numpy as np

from plantigrade.contact.ground import Ground
from plantigrade.control.replay import Replay
from plantigrade.experiments.table import Row, at_most
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.workflows.motions import synthesize
from plantigrade.world import World, standing_on

GOALS = {"43": 1.0, "66": 2.0}  # of a tick, by coordinates [ms]
FEET = {"43": "two-segment", "66": "multi-segment"}
TICKS, BLOCK = 400, 20


def rows() -> Iterator[Row]:
    """Yield the time of a tick in standing, and of a walk carried out."""
    for joints, goal in GOALS.items():
        human = Human.create(joints=joints, feet=FEET[joints])
        tick, _ = timed(standing(human))
        yield at_most(f"{joints} coordinates, standing", "tick", tick, goal, "ms")
    record = synthesize("walk", periodic=True).record
    tick, step = timed(record)
    yield at_most("43 coordinates, walking at 1.3 m/s", "tick", tick, GOALS["43"], "ms")
    yield Row("43 coordinates, walking at 1.3 m/s", "physics of a tick", step, "ms")


def standing(human: Human) -> Record:
    """Return two seconds of quiet standing, without forces."""
    n = 41
    qpos = np.tile(standing_on(human, Ground()), (n, 1))
    qvel = np.zeros((n, human.model.nv))
    return Record(human, Motion(np.linspace(0.0, 2.0, n), qpos, qvel, human.joint_names, qvel))


def timed(record: Record) -> tuple[float, float]:
    """Return how long a tick of the controller takes, and a step of its world [ms].

    Both are medians over blocks of ticks: other work of the machine lengthens some of them.
    """
    controller = Replay(record)
    world = World(
        record.human,
        record.ground,
        rate=controller.rate,
        control_rate=controller.control_rate,
        recording=False,
        qpos=record.motion.qpos[0],
        qvel=record.motion.qvel[0],
    )
    state = world.reset()
    spent = np.zeros((TICKS, 2))
    for i in range(TICKS):
        began = time.process_time()
        command = controller(state)
        thought = time.process_time()
        state = world.step(command)
        spent[i] = thought - began, time.process_time() - thought
    blocks = spent.reshape(-1, BLOCK, 2).mean(axis=1)
    tick, step = 1e3 * np.median(blocks, axis=0)
    return float(tick), float(step)
