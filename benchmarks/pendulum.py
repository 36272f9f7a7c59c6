"""Walking by a pendulum: 20 ms of simulated time, and what takes them.

A textbook walk of a person of 43 coordinates is carried out at the controller's own rates, with
commands that hold for 5 ms, which is its own tick, for 10 and for 20 ms; soles are looked at every
5 ms, with a tick of 20 ms every 10. Filter is the look at the soles, phase and the plan of the
step; tracking the desired motion of the body; program the torques and forces for it; physics all
that the world does. The paper took 13.55 ms, on a machine of 2008.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from experiments.table import Row, at_most
from plantigrade.control.pendulum import Pendulum, PendulumSettings, walk_of
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import World

GOALS: dict[float, float | None] = {
    0.005: 6.0,
    0.010: None,
    0.020: 2.0,
}  # tick [s] → median of 20 ms of simulated time [ms]
MAX_TAIL_RATIO = 2.0  # 99th percentile by the median
SPAN = 0.02  # [s] of walking whose computing is timed at once
DURATION = 6.0  # [s] of the walk
PARTS = ("filter", "tracking", "program", "physics")


def rows() -> Iterator[Row]:
    """Yield what 20 ms of a walk take, at three ticks, in all and in parts."""
    record = walk()
    for tick, goal in GOALS.items():
        spent, programs, falls = walked(record, tick)
        subject = f"pendulum, 43 coordinates, tick of {1e3 * tick:g} ms"
        whole = spent.sum(axis=1)
        middle = float(np.median(whole))
        if goal is None:
            yield Row(subject, "20 ms, median", middle, "ms")
        else:
            yield at_most(subject, "20 ms, median", middle, goal, "ms")
        yield Row(subject, "fastest twentieth", float(np.percentile(whole, 5)), "ms")
        yield at_most(subject, "99th percentile by the median",
                      float(np.percentile(whole, 99)) / middle, MAX_TAIL_RATIO, "")  # fmt: skip
        for name, part in zip(PARTS, spent.T, strict=True):
            yield Row(subject, f"of it: {name}", float(np.median(part)), "ms")
        yield Row(subject, "programs in 20 ms, mean", programs, "")
        yield Row(subject, f"falls in {DURATION:g} s", falls, "")


def walk() -> Record:
    """Return the textbook walk, a stride of it closed."""
    human = Human.create(1.75, 75.0, joints="43", feet="two-segment")
    textbook = textbook_walk(human, speed=1.1, rate=60.0, cycles=2)
    rest = np.zeros((len(textbook.time), human.model.nv))
    return walk_of(
        Record(human, Motion(textbook.time, textbook.qpos, rest, human.joint_names,
                             events=textbook.events))
    )  # fmt: skip


def walked(record: Record, tick: float) -> tuple[np.ndarray, float, int]:
    """Return what each 20 ms took, in parts [ms], programs in each, and how often they fell.

    After a fall the walk starts again, so that walking alone is timed.
    """
    controller, motion = Pendulum(record, settings=PendulumSettings(tick=tick)), record.motion
    world = World(
        record.human,
        record.ground,
        rate=controller.rates.physics,
        control_rate=controller.rates.control,
        recording=False,
        qpos=motion.qpos[0],
        qvel=motion.qvel[0],
    )
    own = round(SPAN * controller.rates.control)
    looks, programs, falls, lasted = [], 0, 0, 0.0
    while lasted < DURATION:
        state, clocks = world.reset(), {"command": 0.0, "program": 0.0}
        controller = Pendulum(record, settings=PendulumSettings(tick=tick))
        _clock(controller, "_command", "command", clocks)
        state = world.step(controller(state))  # the first one also makes ready
        _clock(controller.program, "solve", "program", clocks)
        seen = []
        while world.fall is None and world.diverged is None and lasted + world.time < DURATION:
            clocks.update(command=0.0, program=0.0)
            began = time.process_time()
            command = controller(state)
            decided = time.process_time()
            state = world.step(command)
            done = time.process_time()
            programs += clocks["program"] > 0.0
            tracking = clocks["command"] - clocks["program"]
            whole = decided - began
            seen.append([whole - clocks["command"], tracking, clocks["program"], done - decided])
        falls += world.fall is not None or world.diverged is not None
        lasted += world.time
        looks += seen[: len(seen) // own * own]
    spans = np.array(looks).reshape(-1, own, len(PARTS))
    return 1e3 * spans.sum(axis=1), programs / len(spans), falls


def _clock(owner: Any, method: str, name: str, clocks: dict[str, float]) -> None:
    """Let a method add its time to a clock [s]."""
    inner: Callable[..., Any] = getattr(owner, method)

    def timed(*arguments, **options):
        began = time.process_time()
        answer = inner(*arguments, **options)
        clocks[name] += time.process_time() - began
        return answer

    setattr(owner, method, timed)
