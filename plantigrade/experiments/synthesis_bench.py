"""How fast and how surely motions come from tasks: cold, warm, from bad guesses, of many kinds.

Every motion is made by one thread, from its task to what the solver found, and judged by the
checker; a success is a motion that the solver calls solved and the checker calls ok. Times are
those of the processor: what a free core takes on the clock.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.experiments.kept_results import KeptResults, Result
from plantigrade.experiments.page import Grid, write_page
from plantigrade.experiments.random_requests import Request, random_request
from plantigrade.experiments.synthesis_trial import (
    brief,
    chosen_parts,
    crude,
    failures,
    judge,
    load,
    motion_rows,
    outcome,
    solve,
    task_of,
    tried,
)
from plantigrade.experiments.table import ResultTable, Row, at_least, at_most
from plantigrade.models import Human
from plantigrade.synthesize.tasks.gait_parameters import gait_parameters
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.tasks.walking_plan import walk_plan
from plantigrade.synthesize.transcription.mesh import nodes_of

FILE, PAGE = "synthesis-bench.json", "synthesis-bench.html"
SPEED, DURATION = 1.3, 3.0  # of the walk [m/s], [s]
NODES, FINE_NODES = 61, 301
STEP_LENGTHS, SPEEDS = (0.3, 0.75), (0.4, 1.6)  # of random tasks [m], [m/s]
# Goals.
COLD, IPOPT, WARM, FINE = 4.0, 20.0, 0.5, 12.0  # [s]
REQUEST, LONGEST_REQUEST, REQUESTS_MADE = 3.0, 20.0, 0.98  # median, most [s]; share
OFTEN = 19  # of 20

NOTES = (
    "",
    "How to read it: a motion counts as made if the solver says solved and the checker, on a grid "
    "ten times finer than the nodes, finds nothing out of its limits. Times are the processor's, "
    "of one thread, from the task (mesh, equations of the person, guess) to the motion, without "
    "the checker; a warm start has the equations of the person. 'clock' is what went by on this "
    "machine, whatever else it was doing. Loading is what the first motion of a process waits "
    "longer for derivatives that are on disk already. No compiler is used anywhere. Noise on a "
    "first guess is a sum of smooth waves on every coordinate "
    "(plantigrade.synthesize.guess.walk.with_noise), its size a root mean square. 'helped' counts "
    "motions whose first try failed: an easier problem then leads there, and starts from the "
    "task's own guess without the noise. 'costs' counts the different minima that guesses of a "
    "part led to (costs that differ by more than a thousandth).",
)


@dataclass(frozen=True)
class Extent:
    """How much is measured: guesses of each size of noise (RMS, [rad]), random walks, requests.

    Nodes a second are the tasks' own if absent.
    """

    guesses: int = 20
    sizes: tuple[float, ...] = (0.05, 0.1, 0.2)
    random: int = 50
    requests: int = 200
    nodes_per_second: float | None = None
    steps: int = 4


QUICK = Extent(guesses=1, sizes=(0.05,), random=1, requests=1)
QUICK_PARTS = ("crude walk", "periodic", "sit-to-stand", "random periodic", "warm")


def run(
    *,
    parts: Sequence[str] = (),
    extent: Extent | None = None,
    quick: bool = False,
    out: Path | None = None,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Return the table of the parts (names of :data:`PARTS`), and of all that was measured before.

    Raises:
        ParameterError: If there is no such part.
    """
    extent = extent or (QUICK if quick else Extent())
    kept = KeptResults(out / FILE if out else None, say, anew=overwrite)
    for name in chosen_parts(parts, PARTS, QUICK_PARTS if quick else PARTS):
        for key, make in PARTS[name].cases(extent):
            kept.get(key, make, brief)
    shown = {n: kept.beginning(f"{n}/") for n in PARTS}
    rows = [row for n, found in shown.items() if found for row in rows_of(PARTS[n], found)]
    loading = kept.beginning("loading/")
    sheets = [summary(shown).text(), *([loading_grid(loading).text()] if loading else [])]
    if failed := failures(kept.results):
        lines = [f"{key}: {words}" for key, words in failed.items()]
        sheets.append("\n".join(["What failed, and why", *lines]))
    notes = [*NOTES, *kept.notes()]
    found = ResultTable("Motions from tasks: time and success", rows, notes, sheets)
    if out is not None:
        grids = (summary(shown), loading_grid(loading), every_motion(shown))
        write_page(out / PAGE, found, [grid.section() for grid in grids], kept)
    return found


# Parts --------------------------------------------------------------------------------------------

Case = tuple[str, Callable[[], dict[str, Any]]]
"""Key of a result, and what makes it."""


@dataclass(frozen=True)
class Part:
    """One kind of measurement.

    Attributes:
        name: Of the part.
        words: What is measured.
        cases: Everything that is measured.
        seconds: Goal of the time of one motion [s].
        share: Goal of the share of motions that are made.
        most: Goal of the longest time, where it is another one [s].
    """

    name: str
    words: str
    cases: Callable[[Extent], Iterator[Case]]
    seconds: float
    share: float = OFTEN / 20
    most: float | None = None


def walk_of(human: Human, extent: Extent, *, duration: float = DURATION) -> MotionTask:
    """Return the walk from standing to standing that takes so long, at the speed it takes."""
    low, high = 0.5, 2.2  # the faster, the shorter
    for _ in range(20):
        speed = (low + high) / 2
        plan = walk_plan(human, gait_parameters(human, speed), steps=extent.steps)
        longer = plan.duration > duration
        low, high = (speed, high) if longer else (low, speed)
    told = {"speed": (low + high) / 2, "steps": extent.steps}
    return task_of("walk", human, told, extent.nodes_per_second)


def with_nodes(task: MotionTask, nodes: int) -> MotionTask:
    """Return a task on the coarsest even mesh of at least so many nodes."""
    nodes_per_second = task.nodes_per_second
    while len(nodes_of(task.plan, nodes_per_second)) < nodes:
        nodes_per_second += 0.5
    return replace(task, nodes_per_second=nodes_per_second)


def person() -> Human:
    """Return who does everything here: the average adult with 43 coordinates."""
    return Human.create(joints="43")


def trial(human: Human, task_of: Callable[[], MotionTask], **how: Any) -> dict[str, Any]:
    """Return what is kept of one motion; why, where there is no such motion."""

    def make() -> dict[str, Any]:
        timed = solve(human, task_of(), **how)
        return outcome(timed, judge(timed))

    return tried(make)


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


def named(name: str, **told: Any) -> Callable[[Human, Extent], MotionTask]:
    """Return what makes a task by name."""
    return lambda human, extent: task_of(name, human, told, extent.nodes_per_second)


def ipopt(extent: Extent) -> Iterator[Case]:
    """Yield the same walk by IPOPT."""
    human = person()
    yield from _two_guesses("ipopt", human, walk_of(human, extent), solver="ipopt")


def fine(extent: Extent) -> Iterator[Case]:
    """Yield the walk on many nodes."""
    human = person()
    yield from _two_guesses("fine", human, with_nodes(walk_of(human, extent), FINE_NODES))


def _two_guesses(part: str, human: Human, task: MotionTask, **how: Any) -> Iterator[Case]:
    for name, each in (("own guess", task), ("crude guess", crude(task))):
        yield f"{part}/{name}", partial(trial, human, lambda each=each: each, **how)


def random_walks(part: str, periodic: bool, extent: Extent) -> Iterator[Case]:
    """Yield walks of random step length and speed."""
    human = person()
    for seed in range(extent.random):
        length, speed = random_walk(seed)
        told: dict[str, Any] = {"speed": speed, "step_length": length}
        if periodic:
            told["periodic"] = True
        else:
            told["steps"] = min(max(2, round((DURATION - 1.0) * speed / length)), 8)
        make = partial(trial, human, partial(task_of, "walk", human, told))
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
            return trial(human, partial(task_of, asked.task, human, asked.told))

        yield f"requests/{seed}: {asked.words}", make


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
        told = {"speed": speed, "step_length": step, "periodic": periodic}
        told |= {} if periodic else {"steps": extent.steps}
        return task_of("walk", human, told, extent.nodes_per_second)

    @cache
    def first(periodic: bool) -> Any:
        return solve(human, walk(periodic)).solution

    def make(periodic: bool, speed: float, step: float | None) -> dict[str, Any]:
        return trial(human, lambda: walk(periodic, speed, step), warm=first(periodic))

    for kind, periodic in (("standing", False), ("periodic", True)):
        for name, speed, step in changes:
            yield f"warm/{kind}, {name}", partial(make, periodic, speed, step)


def _of_guesses(name: str, words: str, of: Callable[[Human, Extent], MotionTask]) -> Part:
    return Part(name, words, partial(guesses, name, of), COLD)


PARTS: dict[str, Part] = {
    p.name: p
    for p in (
        _of_guesses(
            "crude walk",
            "walk of 3 s from standing to standing, from a crude guess",
            lambda human, extent: crude(walk_of(human, extent)),
        ),
        _of_guesses("walk", "the same walk from its own guess", walk_of),
        Part("ipopt", "the same walk by IPOPT", ipopt, IPOPT, 1.0),
        Part("fine", f"the same walk on {FINE_NODES} nodes or more", fine, FINE, 1.0),
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
            COLD,
            1.0,
        ),
        Part(
            "random periodic",
            "periodic walks of random step and speed",
            partial(random_walks, "random periodic", True),
            COLD,
            1.0,
        ),
        Part(
            "requests",
            "random requests over all tasks, persons, feet and joints",
            requests,
            REQUEST,
            REQUESTS_MADE,
            LONGEST_REQUEST,
        ),
        Part("warm", "walks from one of a slightly different speed or step", warm, WARM, 1.0),
    )
}


# Tables -------------------------------------------------------------------------------------------


def rows_of(part: Part, found: dict[str, Result]) -> Iterator[Row]:
    """Return what a part is held against."""
    good = sum(bool(r["good"]) for r in found.values())
    yield Row(part.name, "motions", len(found))
    yield at_least(part.name, "made, share", good / len(found), part.share)
    times = _of(found, "cpu")
    if len(times):
        yield at_most(part.name, "time, median", float(np.median(times)), part.seconds, "s")
        most = part.seconds if part.most is None else part.most
        yield at_most(part.name, "time, most", float(times.max()), most, "s")
        yield Row(part.name, "iterations, median", float(np.median(_of(found, "iterations"))))
    for key, result in found.items():
        yield from motion_rows(key, result)


def summary(shown: dict[str, dict[str, Result]]) -> Grid:
    """Return one line for every part and every size of noise."""
    header = ("", "made", "goal", "median s", "most s", "goal", "clock", "iterations", "most")
    header += ("nodes", "helped", "costs")
    lines = []
    for name, found in shown.items():
        groups: dict[str, dict[str, Result]] = {}
        for key, result in found.items():
            inner = key.split("/", 1)[1]
            kind = inner.split("/")[0] if inner.startswith("no") else ""
            groups.setdefault(kind, {})[key] = result
        for kind, group in groups.items():
            lines.append(_line(PARTS[name], kind, group))
    return Grid("Time and success", header, lines)


def loading_grid(found: dict[str, Result]) -> Grid:
    """Return how much longer the first motion of a process takes."""
    lines = [
        [PARTS[key.split("/", 1)[1]].words, f"{r['cpu']:.2f}", f"{r['wall']:.2f}"]
        for key, r in found.items()
    ]
    return Grid("Loading derivatives from disk", ("", "s", "clock"), lines)


def every_motion(shown: dict[str, dict[str, Result]]) -> Grid:
    """Return one line for every motion."""
    lines = []
    for found in shown.values():
        for key, r in found.items():
            if "error" in r:
                lines.append([key, "no", *["-"] * 6])
                continue
            stages = ", ".join(f"{s['name']} {s['iterations']}" for s in r["stages"])
            lines.append(
                [
                    key, "yes" if r["good"] else "no", f"{r['cpu']:.2f}", f"{r['wall']:.2f}",
                    str(r["nodes"]), str(r["iterations"]), f"{r['objective']:.4g}", stages,
                ]
            )  # fmt: skip
    header = ("", "made", "s", "clock", "nodes", "iterations", "cost", "stages and iterations")
    return Grid("Every motion", header, lines)


def _line(part: Part, kind: str, group: dict[str, Result]) -> list[str]:
    good, times = sum(bool(r["good"]) for r in group.values()), _of(group, "cpu")
    label = f"{part.words}{', ' + kind if kind else ''}{' rad' if kind.startswith('noise') else ''}"
    least = int(np.ceil(part.share * len(group) - 1e-9))
    cells = [label, f"{good} of {len(group)}", f"{least}"]
    if not len(times):
        return [*cells, *["-"] * 9]
    iterations, nodes = _of(group, "iterations"), _of(group, "nodes")
    helped = sum(
        len(stages) > 1 and stages[0]["status"] not in ("solved", "acceptable")
        for stages in (r.get("stages", ()) for r in group.values())
    )
    return [
        *cells, f"{np.median(times):.2f}", f"{times.max():.2f}", f"{part.seconds:g}",
        f"{np.median(_of(group, 'wall')):.2f}", f"{np.median(iterations):.0f}",
        f"{iterations.max():.0f}", f"{nodes.min():.0f}-{nodes.max():.0f}", f"{helped}",
        f"{minima(_of(group, 'objective'))}" if kind else "",
    ]  # fmt: skip


def minima(costs: np.ndarray) -> int:
    """Return how many different costs there are, to a thousandth.

    Example:
        >>> minima(np.array([1.0, 1.0004, 1.2]))
        2
    """
    ordered = np.sort(costs)
    return 1 + int(np.sum(np.diff(ordered) > 1e-3 * np.abs(ordered[1:]))) if len(costs) else 0


def _of(found: dict[str, Result], name: str) -> np.ndarray:
    return np.array([r[name] for r in found.values() if r.get(name) is not None], float)
