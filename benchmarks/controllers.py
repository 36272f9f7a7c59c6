"""One tick of the controllers that keep a person on the feet, of the processor.

Quiet standing on both feet, every sphere of the soles carrying, is the most that a tick of either
has to do while nothing happens; a walk has one foot on the ground most of the time. Pushed, forces
reach their limits and the program takes more than one step. A tick that a user's own script has is
timed in a process of its own, where nobody has limited the threads of BLAS.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np

from experiments.table import Row, at_most
from plantigrade.contact.ground import Ground
from plantigrade.control.balance import Balance
from plantigrade.control.replay import Replay
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.workflows.motions import synthesize
from plantigrade.world import Command, Controller, Push, State, World, standing_on

GOALS = {"43": 1.0, "66": 2.0}  # of a replay's tick, by coordinates [ms]
# Goals
MAX_TICK_TIME = 1.0  # [ms] median
MAX_SLOW_TICK_TIME = 3.0  # [ms] 99th percentile
MAX_WALK_TIME = 1.5  # [s] of a walk of SECONDS
FEET = {"43": "two-segment", "66": "multi-segment"}
SECONDS = 3.0
PUSHED = Push(force=60.0, duration=0.4, time=1.0)
SCRIPT = "from benchmarks.controllers import alone; alone()"
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def rows() -> Iterator[Row]:
    """Yield the time of a tick in standing, pushed, and of a walk carried out."""
    for joints, goal in GOALS.items():
        record = standing(person(joints))
        ticks, _ = replayed(record)
        yield at_most(f"replay, {joints} coordinates, standing", *median(ticks), goal, "ms")
    record = synthesize("walk", periodic=True).record
    ticks, whole = replayed(record)
    subject = "replay, 43 coordinates, walking at 1.3 m/s"
    yield at_most(subject, *median(ticks), GOALS["43"], "ms")
    yield at_most(subject, f"{SECONDS:g} s of it, physics included", whole, MAX_WALK_TIME, "s")
    for what, acts in {"standing": (), "pushed": (PUSHED,)}.items():
        world = World(person("66"), None, acts, control_rate=100.0, recording=False)
        ticks, _ = timed(Balance(), world)
        subject = f"balance, 66 coordinates, {what}"
        yield at_most(subject, *median(ticks), MAX_TICK_TIME, "ms")
        yield at_most(
            subject, "99th percentile", float(np.percentile(ticks, 99)), MAX_SLOW_TICK_TIME, "ms"
        )
    yield at_most("balance, 66 coordinates, World.simulate of a script", "tick, median",
                  in_a_script(), MAX_TICK_TIME, "ms")  # fmt: skip


def person(joints: str) -> Human:
    """Return the person who is timed."""
    return Human.create(joints=joints, feet=FEET[joints])


def standing(human: Human) -> Record:
    """Return two seconds of quiet standing, without forces."""
    n = 41
    qpos = np.tile(standing_on(human, Ground()), (n, 1))
    qvel = np.zeros((n, human.model.nv))
    return Record(human, Motion(np.linspace(0.0, 2.0, n), qpos, qvel, human.joint_names, qvel))


def median(ticks: np.ndarray) -> tuple[str, float]:
    """Return the middle one, named."""
    return "tick, median", float(np.median(ticks))


def clocked(controller: Callable[[State], Command], ticks: list[float]) -> Controller:
    """Return a controller that keeps how long each of its ticks takes [ms]."""

    def tick(state: State) -> Command:
        began = time.process_time()
        command = controller(state)
        ticks.append(1e3 * (time.process_time() - began))
        return command

    return tick


def timed(controller: Callable[[State], Command], world: World) -> tuple[np.ndarray, float]:
    """Return how long ticks of a controller take [ms], and the whole of the simulation [s]."""
    ticks: list[float] = []
    act, state, began = clocked(controller, ticks), world.reset(), time.process_time()
    while world.time < SECONDS - 0.5 / world.rate:
        state = world.step(act(state))
    return np.array(ticks[1:]), time.process_time() - began  # the first one also makes ready


def replayed(record: Record) -> tuple[np.ndarray, float]:
    """Return how long ticks of a replay take [ms], and the whole of it [s]."""
    controller = Replay(record)
    world = World(
        record.human,
        record.ground,
        rate=controller.rates.physics,
        control_rate=controller.rates.control,
        recording=False,
        qpos=record.motion.qpos[0],
        qvel=record.motion.qvel[0],
    )
    return timed(controller, world)


def in_a_script() -> float:
    """Return the median tick in a process that knows nothing of threads [ms]."""
    free = {name: value for name, value in os.environ.items() if name not in THREAD_VARIABLES}
    command = [sys.executable, "-c", SCRIPT]
    return float(subprocess.run(command, env=free, capture_output=True, check=True).stdout)


def alone() -> None:
    """Print the median tick of a world that simulates by itself [ms]."""
    ticks: list[float] = []
    world = World(person("66"), control_rate=100.0)
    world.simulate(clocked(Balance(), ticks), SECONDS)
    print(np.median(ticks[1:]))
