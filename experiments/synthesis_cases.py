"""The motions that ``synthesis-bench`` generates, and their goals."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np

from experiments.random_requests import Request, random_request
from experiments.synthesis_trial import check_motion, crude, load, outcome, solve, task_of
from plantigrade.models import Human
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.walking_plan import walk_plan
from plantigrade.trajopt.transcription.mesh import nodes_of

SPEED = 1.3  # [m/s] of the walk
DURATION = 3.0  # [s] of the walk
N_NODES = 61  # of its mesh
N_FINE_NODES = 301  # of its fine mesh
STEP_LENGTHS = (0.3, 0.75)  # [m] range of random tasks
SPEEDS = (0.4, 1.6)  # [m/s] range of random tasks
# Goals.
MAX_COLD_TIME = 4.0  # [s] from the guess
MAX_IPOPT_TIME = 20.0  # [s] of Ipopt
MAX_WARM_TIME = 0.5  # [s] from an earlier solution
MAX_FINE_TIME = 12.0  # [s] on the fine mesh
MAX_MEDIAN_REQUEST_TIME = 3.0  # [s] of random requests, median
MAX_REQUEST_TIME = 20.0  # [s] of random requests, worst
MIN_REQUEST_SHARE = 0.98  # [1] of random requests that are solved
STAIR = 10.0  # [s]
MIN_SOLVED_OF_20 = 19  # guesses of 20 that lead to the solution
STAIR_TREADS = (2, 3, 4, 5, 6)
STAIR_RISES = (0.1, 0.2)  # [m] range
STAIR_SPEEDS = (0.5, 1.0)  # [m/s] range


@dataclass(frozen=True)
class Extent:
    """Size of the benchmark: guesses of each size of noise (RMS, [rad]), motions of other parts.

    Nodes per second are the tasks' own if absent.
    """

    guesses: int = 20
    sizes: tuple[float, ...] = (0.05, 0.1, 0.2)
    random: int = 50
    requests: int = 200
    stairs: int = 40
    nodes_per_second: float | None = None
    steps: int = 4


QUICK_EXTENT = Extent(guesses=1, sizes=(0.05,), random=1, requests=1, stairs=2)
QUICK_PARTS = ("crude walk", "periodic", "sit-to-stand", "random periodic", "warm")

Case = tuple[str, Callable[[], dict[str, Any]]]
"""Key of a result, and what makes it."""


@dataclass(frozen=True)
class Part:
    """One kind of measurement.

    Attributes:
        name: Name of the part.
        title: What is measured.
        cases: Returns all cases.
        seconds: Goal of the time of one motion [s].
        share: Goal of the share of solved motions.
        most: Goal of the longest time, if it is another one [s].
    """

    name: str
    title: str
    cases: Callable[[Extent], Iterator[Case]]
    seconds: float
    share: float = MIN_SOLVED_OF_20 / 20
    most: float | None = None


def walk_of(human: Human, extent: Extent) -> MotionTask:
    """Return the walk from standing to standing that takes :data:`DURATION`."""
    low, high = 0.5, 2.2  # the faster, the shorter
    for _ in range(20):
        speed = (low + high) / 2
        plan = walk_plan(human, gait_parameters(human, speed), steps=extent.steps)
        longer = plan.duration > DURATION
        low, high = (speed, high) if longer else (low, speed)
    options = {"speed": (low + high) / 2, "steps": extent.steps}
    return task_of("walk", human, options, extent.nodes_per_second)


def with_nodes(task: MotionTask, nodes: int) -> MotionTask:
    """Return a task on the coarsest even mesh of at least so many nodes."""
    nodes_per_second = task.nodes_per_second
    while len(nodes_of(task.plan, nodes_per_second)) < nodes:
        nodes_per_second += 0.5
    return replace(task, nodes_per_second=nodes_per_second)


def person() -> Human:
    """Return the person of the benchmark: the average adult with 43 coordinates."""
    return Human.create(joints="43")


def trial(human: Human, task_of: Callable[[], MotionTask], **options: Any) -> dict[str, Any]:
    """Return the result of one motion."""
    timed = solve(human, task_of(), **options)
    return outcome(timed, check_motion(timed))


def guesses(part: str, of: Callable[[Human, Extent], MotionTask], extent: Extent) -> Iterator[Case]:
    """Yield a task from its own guess and from worse ones."""
    human = person()
    task = of(human, extent)
    made = partial(trial, human, lambda: task)
    yield f"loading/{part}", partial(load, human, task)
    yield f"{part}/no noise", made
    for size in extent.sizes:
        for seed in range(extent.guesses):
            yield f"{part}/noise {size:g}/{seed}", partial(made, noise=size, seed=seed)


def named(name: str, **options: Any) -> Callable[[Human, Extent], MotionTask]:
    """Return what makes a task by name."""
    return lambda human, extent: task_of(name, human, options, extent.nodes_per_second)


def ipopt(extent: Extent) -> Iterator[Case]:
    """Yield the same walk by IPOPT."""
    human = person()
    yield from _two_guesses("ipopt", human, walk_of(human, extent), solver="ipopt")


def fine(extent: Extent) -> Iterator[Case]:
    """Yield the walk on many nodes."""
    human = person()
    yield from _two_guesses("fine", human, with_nodes(walk_of(human, extent), N_FINE_NODES))


def _two_guesses(part: str, human: Human, task: MotionTask, **how: Any) -> Iterator[Case]:
    for name, each in (("own guess", task), ("crude guess", crude(task))):
        yield f"{part}/{name}", partial(trial, human, lambda each=each: each, **how)


def random_walks(part: str, periodic: bool, extent: Extent) -> Iterator[Case]:
    """Yield walks of random step length and speed."""
    human = person()
    for seed in range(extent.random):
        length, speed = random_walk(seed)
        options: dict[str, Any] = {"speed": speed, "step_length": length}
        if periodic:
            options["periodic"] = True
        else:
            options["steps"] = min(max(2, round((DURATION - 1.0) * speed / length)), 8)
        make = partial(trial, human, partial(task_of, "walk", human, options))
        yield f"{part}/{seed}: {length:.2f} m at {speed:.2f} m/s", make


def random_walk(seed: int) -> tuple[float, float]:
    """Return a random step length [m] and speed [m/s]."""
    rng = np.random.default_rng(seed)
    return float(rng.uniform(*STEP_LENGTHS)), float(rng.uniform(*SPEEDS))


def requests(extent: Extent) -> Iterator[Case]:
    """Yield random requests."""
    for seed in range(extent.requests):
        asked = random_request(seed)

        def make(asked: Request = asked) -> dict[str, Any]:
            human = asked.human
            return trial(human, partial(task_of, asked.task, human, asked.options))

        yield f"requests/{seed}: {asked.title}", make


def stairs(extent: Extent) -> Iterator[Case]:
    """Yield stairs up and down: every number of treads, least and largest rises and speeds."""
    human = person()
    every = list(product(STAIR_TREADS, STAIR_RISES, STAIR_SPEEDS, (1.0, -1.0)))
    for k in np.linspace(0, len(every) - 1, extent.stairs).round().astype(int):
        treads, rise, speed, sign = every[k]
        levels = [round(sign * rise * (i + 1), 3) for i in range(treads)]
        options = {"speed": speed, "steps": treads + 1, "heights": (*levels, levels[-1])}
        make = partial(trial, human, partial(task_of, "walk", human, options))
        yield f"stairs/{treads} treads of {sign * rise:+.2f} m at {speed:g} m/s", make


def warm(extent: Extent) -> Iterator[Case]:
    """Yield motions from one much like them: a speed or a step that was changed a little."""
    human = person()
    length = gait_parameters(human, SPEED).step_length
    changes = (
        ("speed +5 %", 1.05 * SPEED, None),
        ("speed -5 %", 0.95 * SPEED, None),
        ("step +5 %", SPEED, 1.05 * length),
        ("step -5 %", SPEED, 0.95 * length),
        ("step +5 cm", SPEED, length + 0.05),
        ("step -5 cm", SPEED, length - 0.05),
    )

    def walk(periodic: bool, speed: float = SPEED, step: float | None = None) -> MotionTask:
        options = {"speed": speed, "step_length": step, "periodic": periodic}
        options |= {} if periodic else {"steps": extent.steps}
        return task_of("walk", human, options, extent.nodes_per_second)

    @cache
    def first(periodic: bool) -> Any:
        return solve(human, walk(periodic)).solution

    def make(periodic: bool, speed: float, step: float | None) -> dict[str, Any]:
        return trial(human, lambda: walk(periodic, speed, step), warm=first(periodic))

    for kind, periodic in (("standing", False), ("periodic", True)):
        for name, speed, step in changes:
            yield f"warm/{kind}, {name}", partial(make, periodic, speed, step)


def _of_guesses(name: str, words: str, of: Callable[[Human, Extent], MotionTask]) -> Part:
    return Part(name, words, partial(guesses, name, of), MAX_COLD_TIME)


PARTS: dict[str, Part] = {
    p.name: p
    for p in (
        _of_guesses(
            "crude walk",
            "walk of 3 s from standing to standing, from a crude guess",
            lambda human, extent: crude(walk_of(human, extent)),
        ),
        _of_guesses("walk", "the same walk from its own guess", walk_of),
        Part("ipopt", "the same walk by IPOPT", ipopt, MAX_IPOPT_TIME, 1.0),
        Part("fine", f"the same walk on {N_FINE_NODES} nodes or more", fine, MAX_FINE_TIME, 1.0),
        _of_guesses(
            "periodic", "periodic walk at 1.3 m/s", named("walk", periodic=True, speed=SPEED)
        ),
        *(
            _of_guesses(name, name.replace("-", " "), named(name))
            for name in ("sit-to-stand", "side-step", "jump")
        ),
        Part(
            "random",
            "walks of random step and speed, from standing to standing",
            partial(random_walks, "random", False),
            MAX_COLD_TIME,
            1.0,
        ),
        Part(
            "random periodic",
            "periodic walks of random step and speed",
            partial(random_walks, "random periodic", True),
            MAX_COLD_TIME,
            1.0,
        ),
        Part(
            "requests",
            "random requests over all tasks, persons, feet and joints",
            requests,
            MAX_MEDIAN_REQUEST_TIME,
            MIN_REQUEST_SHARE,
            MAX_REQUEST_TIME,
        ),
        Part("stairs", "stairs up and down, from standing to standing", stairs, STAIR, 1.0),
        Part(
            "warm", "walks from one of a slightly different speed or step", warm, MAX_WARM_TIME, 1.0
        ),
    )
}
