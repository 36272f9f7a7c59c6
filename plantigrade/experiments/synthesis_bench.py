"""How fast and how surely motions come from tasks: cold, warm, from bad guesses, of many kinds.

Every motion is made by one thread, from its task to what the solver found, and judged by the
checker; a success is a motion that the solver calls solved and the checker calls ok. Times are
those of the processor: what a free core takes on the clock.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.experiments.kept_results import KeptResults, Result
from plantigrade.experiments.page import Grid, write_page
from plantigrade.experiments.synthesis_trial import (
    crude,
    judge,
    load,
    motion_rows,
    outcome,
    solve,
    tried,
    why,
)
from plantigrade.experiments.table import ResultTable, Row, at_least, at_most

if TYPE_CHECKING:
    from plantigrade.models import Human
    from plantigrade.synthesize.tasks.task import MotionTask

FILE, PAGE = "synthesis-bench.json", "synthesis-bench.html"
SPEED, STEPS, DURATION = 1.3, 4, 3.0  # of the walk [m/s], [1], [s]
NODES, FINE_NODES = 61, 301
GUESSES, SIZES = 20, (0.05, 0.1, 0.2)  # noise of guesses, root mean square [rad]
RANDOM = 50
STEP_LENGTHS, SPEEDS = (0.3, 0.75), (0.4, 1.6)  # of random tasks [m], [m/s]
# Goals.
COLD, IPOPT, WARM, FINE = 4.0, 20.0, 0.5, 12.0  # [s]
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
    """How much is measured.

    Attributes:
        guesses: First guesses of each size of noise.
        sizes: Sizes of noise [rad].
        random: Random tasks.
        nodes_per_second: Nodes a second; the tasks' own if absent.
        steps: Steps of the walk.
    """

    guesses: int = GUESSES
    sizes: tuple[float, ...] = SIZES
    random: int = RANDOM
    nodes_per_second: float | None = None
    steps: int = STEPS


QUICK = Extent(guesses=1, sizes=(0.05,), random=1)
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
    """Return the table of the parts, and of all that was measured before.

    Args:
        parts: Names of :data:`PARTS`; all if empty, :data:`QUICK_PARTS` of a short form.
        extent: How much is measured; 20 guesses of three sizes and 50 random tasks if absent.
        quick: One guess and one random task instead.
        out: Folder where results are kept and the page is written; those that are there are not
            measured again.
        overwrite: They are.
        say: Called with one line per motion as it is made.

    Raises:
        ParameterError: If there is no such part.
    """
    extent = extent or (QUICK if quick else Extent())
    for part in parts:
        if part not in PARTS:
            raise ParameterError(f"no part {part!r}; there are {', '.join(PARTS)}")
    kept = KeptResults(out / FILE if out else None, say, anew=overwrite)
    for name in parts or (QUICK_PARTS if quick else PARTS):
        PARTS[name].measure(kept, extent)
    shown = {n: kept.beginning(f"{n}/") for n in PARTS}
    rows = [row for n, found in shown.items() if found for row in rows_of(PARTS[n], found)]
    failed = {k: why(r) for k, r in kept.results.items() if not r.get("good", True)}
    loading = kept.beginning("loading/")
    sheets = [summary(shown).text(), *([loading_grid(loading).text()] if loading else [])]
    if failed:
        lines = [f"{key}: {words}" for key, words in failed.items()]
        sheets.append("\n".join(["What failed, and why", *lines]))
    notes = [*NOTES, *filter(None, [kept.note()])]
    found = ResultTable("Motions from tasks: time and success", rows, notes, sheets)
    if out is not None:
        sections = [g(x).section() for g, x in (
            (summary, shown), (loading_grid, loading), (every_motion, shown)
        )]  # fmt: skip
        write_page(out / PAGE, found, sections, left_out=failed, provenance=kept.provenance())
        say(f"{out / PAGE}")
    return found


# Parts --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Part:
    """One kind of measurement.

    Attributes:
        name: Of the part.
        words: What is measured.
        measure: Makes what is not there yet.
        seconds: Goal of the time of one motion [s].
        share: Goal of the share of motions that are made.
    """

    name: str
    words: str
    measure: Callable[[KeptResults, Extent], None]
    seconds: float
    share: float = OFTEN / 20


def walk_of(human: "Human", extent: Extent, *, duration: float = DURATION) -> "MotionTask":
    """Return the walk from standing to standing that takes so long, at the speed it takes."""
    from plantigrade.synthesize.tasks.gait_parameters import gait_parameters
    from plantigrade.synthesize.tasks.registry import make_task
    from plantigrade.synthesize.tasks.walking_plan import walk_plan

    low, high = 0.5, 2.2  # the faster, the shorter
    for _ in range(20):
        speed = (low + high) / 2
        plan = walk_plan(human, gait_parameters(human, speed), steps=extent.steps)
        longer = plan.duration > duration
        low, high = (speed, high) if longer else (low, speed)
    task = make_task("walk", human, {"speed": (low + high) / 2, "steps": extent.steps})
    return (
        task
        if extent.nodes_per_second is None
        else replace(task, nodes_per_second=extent.nodes_per_second)
    )


def with_nodes(task: "MotionTask", nodes: int) -> "MotionTask":
    """Return a task on the coarsest even mesh of at least so many nodes."""
    from plantigrade.synthesize.transcription.mesh import nodes_of

    nodes_per_second = task.nodes_per_second
    while len(nodes_of(task.plan, nodes_per_second)) < nodes:
        nodes_per_second += 0.5
    return replace(task, nodes_per_second=nodes_per_second)


def person() -> "Human":
    """Return who does everything here: the average adult with 43 coordinates."""
    from plantigrade.models import Human

    return Human.create(joints="43")


def trial(human: "Human", task: "MotionTask", **how: Any) -> dict[str, Any]:
    """Return what is kept of one motion."""

    def make() -> dict[str, Any]:
        timed = solve(human, task, **how)
        return outcome(timed, judge(timed))

    return tried(make)


WORDS = "good {good}, {status} in {iterations} iterations, {cpu:.1f} s ({wall:.1f} s on the clock)"


def one(kept: KeptResults, key: str, make: Callable[[], dict[str, Any]]) -> Result:
    """Return a result, and say how it went."""
    found = key in kept.results
    result = kept.get(key, make)
    if not found:
        kept.say("    " + (why(result) if not result.get("good", True) else WORDS.format(**result)))
    return result


def guesses(part: str, task_of: Callable[["Human", Extent], "MotionTask"]):
    """Return what measures a task from its own guess and from worse ones."""

    def measure(kept: KeptResults, extent: Extent) -> None:
        human = person()
        task = task_of(human, extent)
        if (key := f"loading/{part}") not in kept.results:
            kept.get(key, lambda: load(human, task))
        one(kept, f"{part}/no noise", lambda: trial(human, task))
        for size in extent.sizes:
            for seed in range(extent.guesses):
                make = partial(trial, human, task, noise=size, seed=seed)
                one(kept, f"{part}/noise {size:g}/{seed}", make)

    return measure


def named(name: str, **parameters: Any) -> Callable[["Human", Extent], "MotionTask"]:
    """Return what makes a task by name."""

    def make(human: "Human", extent: Extent) -> "MotionTask":
        from plantigrade.synthesize.tasks.registry import make_task

        task = make_task(name, human, parameters)
        return (
            task
            if extent.nodes_per_second is None
            else replace(task, nodes_per_second=extent.nodes_per_second)
        )

    return make


def ipopt(kept: KeptResults, extent: Extent) -> None:
    """Measure the same walk by IPOPT, from its guess and the crude one."""
    human = person()
    task = walk_of(human, extent)
    for name, each in (("own guess", task), ("crude guess", crude(task))):
        one(kept, f"ipopt/{name}", partial(trial, human, each, solver="ipopt"))


def fine(kept: KeptResults, extent: Extent) -> None:
    """Measure the walk on many nodes."""
    human = person()
    task = with_nodes(walk_of(human, extent), FINE_NODES)
    for name, each in (("own guess", task), ("crude guess", crude(task))):
        one(kept, f"fine/{name}", partial(trial, human, each))


def random_walks(part: str, *, periodic: bool):
    """Return what measures walks of random step length and speed."""

    def measure(kept: KeptResults, extent: Extent) -> None:
        human = person()
        for seed in range(extent.random):
            length, speed = random_walk(seed)
            key = f"{part}/{seed}: {length:.2f} m at {speed:.2f} m/s"
            one(kept, key, partial(_random_trial, human, length, speed, periodic))

    return measure


def _random_trial(human: "Human", length: float, speed: float, periodic: bool) -> dict[str, Any]:
    """Return what is kept of a walk; why, where there is no such walk."""
    return tried(lambda: trial(human, _walk(human, length, speed, periodic)))


def random_walk(seed: int) -> tuple[float, float]:
    """Return a random step length [m] and speed [m/s]."""
    rng = np.random.default_rng(seed)
    return float(rng.uniform(*STEP_LENGTHS)), float(rng.uniform(*SPEEDS))


def _walk(human: "Human", length: float, speed: float, periodic: bool) -> "MotionTask":
    from plantigrade.synthesize.tasks.registry import make_task

    if periodic:
        return make_task("walk", human, {"speed": speed, "step_length": length, "periodic": True})
    steps = max(2, round((DURATION - 1.0) * speed / length))
    told = {"speed": speed, "step_length": length, "steps": min(steps, 8)}
    return make_task("walk", human, told)


def warm(kept: KeptResults, extent: Extent) -> None:
    """Measure motions from one much like them: a speed or a step that was changed a little."""
    from plantigrade.synthesize.tasks.gait_parameters import gait_parameters
    from plantigrade.synthesize.tasks.registry import make_task

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
    for kind, periodic in (("standing", False), ("periodic", True)):

        def task_of(
            speed: float, step: float | None = None, periodic: bool = periodic
        ) -> "MotionTask":
            told = {"speed": speed, "step_length": step, "periodic": periodic}
            task = make_task("walk", human, told | {"steps": extent.steps})
            return (
                task
                if extent.nodes_per_second is None
                else replace(task, nodes_per_second=extent.nodes_per_second)
            )

        keys = [f"warm/{kind}, {name}" for name, _, _ in changes]
        if all(key in kept.results for key in keys):
            continue
        first = solve(human, task_of(SPEED)).solution
        for key, (_, speed, step) in zip(keys, changes, strict=True):
            one(kept, key, partial(trial, human, task_of(speed, step), warm=first))


PARTS: dict[str, Part] = {
    p.name: p
    for p in (
        Part(
            "crude walk",
            "walk of 3 s from standing to standing, from a crude guess",
            guesses("crude walk", lambda h, e: crude(walk_of(h, e))),
            COLD,
        ),
        Part(
            "walk",
            "the same walk from its own guess",
            guesses("walk", walk_of),
            COLD,
        ),
        Part("ipopt", "the same walk by IPOPT", ipopt, IPOPT, 1.0),
        Part("fine", f"the same walk on {FINE_NODES} nodes or more", fine, FINE, 1.0),
        Part(
            "periodic",
            "periodic walk at 1.3 m/s",
            guesses("periodic", named("walk", periodic=True, speed=SPEED)),
            COLD,
        ),
        *(
            Part(n, n.replace("-", " "), guesses(n, named(n)), COLD)
            for n in ("sit-to-stand", "side-step", "jump")
        ),
        Part(
            "random",
            "walks of random step and speed, from standing to standing",
            random_walks("random", periodic=False),
            COLD,
            1.0,
        ),
        Part(
            "random periodic",
            "periodic walks of random step and speed",
            random_walks("random periodic", periodic=True),
            COLD,
            1.0,
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
    times = _times(found)
    if len(times):
        yield at_most(part.name, "time, median", float(np.median(times)), part.seconds, "s")
        yield at_most(part.name, "time, most", float(times.max()), part.seconds, "s")
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
    good, times = sum(bool(r["good"]) for r in group.values()), _times(group)
    label = f"{part.words}{', ' + kind if kind else ''}{' rad' if kind.startswith('noise') else ''}"
    least = int(np.ceil(part.share * len(group) - 1e-9))
    cells = [label, f"{good} of {len(group)}", f"{least}"]
    if not len(times):
        return [*cells, *["-"] * 9]
    iterations, nodes = _of(group, "iterations"), _of(group, "nodes")
    helped = sum(len(r["stages"]) > 1 and _rescued(r) for r in group.values() if "stages" in r)
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


def _rescued(result: Result) -> bool:
    """Whether the first stage failed."""
    return result["stages"][0]["status"] not in ("solved", "acceptable")


def _times(found: dict[str, Result]) -> np.ndarray:
    return _of(found, "cpu")


def _of(found: dict[str, Result], name: str) -> np.ndarray:
    return np.array([r[name] for r in found.values() if r.get(name) is not None], float)
