"""The physical world: how many seconds of a person one core computes in a second, and on what.

A person of 66 coordinates on multi-segment feet, with all 32 spheres on the ground, holds the
posture. Times are the processor's.
"""

import time
from collections.abc import Iterator

import mujoco
import numpy as np

from experiments.table import Row, at_least, at_most
from plantigrade.control import Posture
from plantigrade.models import Human
from plantigrade.world import World

CONTROL_RATE = 30.0  # [1/s]
GOALS = {1800.0: 5.0, 300.0: 20.0}  # steps per second → seconds of a person in one of a core
N_REPEATS = 5
DURATION = 2.0  # [s]
RECORDING = 10.0  # of the loop [%]
PARTS = {
    "collisions": mujoco.mj_collision,
    "positions, with collisions and rows": mujoco.mj_fwdPosition,
    "velocities": mujoco.mj_fwdVelocity,
    "forces of contact": mujoco.mj_fwdConstraint,
}


def rows() -> Iterator[Row]:
    """Yield speed at the paper's rates, what recording costs, and where the time goes."""
    human = Human.create(1.50, 48.5, joints="66")
    for rate, goal in GOALS.items():
        world = World(human, rate=rate, control_rate=CONTROL_RATE, recording=False)
        kept = World(human, rate=rate, control_rate=CONTROL_RATE)
        in_turn = [(timed(world), timed(kept)) for _ in range(N_REPEATS)]
        spent, recorded = (min(times) for times in zip(*in_turn, strict=True))
        subject = f"66 coordinates, {rate:g} Hz, commands at {CONTROL_RATE:g} Hz"
        yield at_least(subject, "speed", DURATION / spent, goal, "times real time")
        share = 100.0 * max(recorded - spent, 0.0) / recorded
        yield at_most(subject, "recording, of the loop", share, RECORDING, "%")
        yield Row(
            subject, "one step, with its share of control", 1e6 * spent / (DURATION * rate), "µs"
        )
        yield from part_rows(subject, world)


def timed(world: World) -> float:
    """Return how long a posture is held for :data:`DURATION` [s]."""
    hold, state = Posture(), world.reset()
    hold(state)
    began = time.process_time()
    while world.time < DURATION - 0.5 / world.rate:
        state = world.step(hold(state))
    if world.fall is not None or world.diverged is not None:
        raise RuntimeError("the person who should stand fell: nothing was measured")
    return time.process_time() - began


def part_rows(subject: str, world: World) -> Iterator[Row]:
    """Yield the time of MuJoCo's parts of a step, in the state the world is in."""
    for name, part in PARTS.items():
        each = []
        for _ in range(200):
            began = time.process_time()
            part(world.model, world.data)
            each.append(time.process_time() - began)
        yield Row(subject, f"of a step: {name}", 1e6 * float(np.median(each)), "µs")
