"""Time and success of synthesis from tasks: cold, warm, from bad guesses, of many kinds.

Every motion is solved by one thread and checked by the checker; a success is a motion that the
solver calls solved and the checker calls ok. Times are those of the processor: what a free core
takes on the clock.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.specification import Specification
from experiments.synthesis_cases import PARTS, QUICK_EXTENT, QUICK_PARTS, Extent, Part
from experiments.synthesis_trial import failure_remarks, motion_rows, summary
from experiments.table import Row, at_least, at_most

NOTES = (
    "",
    "A motion counts as made if the solver says solved and the checker, on a grid ten times finer "
    "than the nodes, finds nothing out of its limits. Times are the processor's, of one thread, "
    "from the task (mesh, equations of the person, guess) to the motion, without the checker; a "
    "warm start has the equations of the person. 'clock' is the wall-clock time on this machine, "
    "whatever else it was doing. Loading is the additional time of the first motion of a process, "
    "for derivatives that are on disk already. No compiler is used anywhere. Noise on a first "
    "guess is a sum of smooth waves on every coordinate "
    "(plantigrade.trajopt.guess.walk.with_noise), its size a root mean square. 'helped' counts "
    "motions whose first try failed: an easier problem then leads there, and starts from the "
    "task's own guess without the noise. 'costs' counts the different minima that guesses of a "
    "part led to (costs that differ by more than a thousandth).",
)


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of all parts, also for each size of noise, and of all motions."""
    for name, part in PARTS.items():
        found = cached.select(name, failed=True)
        if not found:
            continue
        yield from part_rows(part, found)
        groups: dict[str, dict[str, Result]] = {}
        for key, result in found.items():
            if (kind := key.split("/")[1]).startswith("noise"):
                groups.setdefault(kind, {})[key] = result
        for kind, group in groups.items():
            yield from part_rows(part, group, f"{name}, {kind} rad")
        for key, result in found.items():
            yield from motion_rows(key, result)
    for key, result in cached.select("loading").items():
        yield Row(f"loading, {key.split('/')[1]}", "time", result["cpu"], "s")
        yield Row(f"loading, {key.split('/')[1]}", "clock, time", result["wall"], "s")


def part_rows(part: Part, found: dict[str, Result], subject: str = "") -> Iterator[Row]:
    """Return success and time of the motions of a part; of a subject without goals."""
    good, goals = sum(bool(r.get("good")) for r in found.values()), not subject
    subject = subject or part.name
    yield Row(subject, "motions", len(found))
    yield at_least(subject, "made, share", good / len(found), part.share if goals else None)
    times, iterations, costs = (_values(found, name) for name in ("cpu", "iterations", "objective"))
    if not len(times):
        return
    most = part.seconds if part.most is None else part.most
    limit, longest = (part.seconds, most) if goals else (None, None)
    yield at_most(subject, "time, median", float(np.median(times)), limit, "s")
    yield at_most(subject, "time, most", float(times.max()), longest, "s")
    yield Row(subject, "clock, time, median", float(np.median(_values(found, "wall"))), "s")
    yield Row(subject, "iterations, median", float(np.median(iterations)))
    yield Row(subject, "iterations, most", float(iterations.max()))
    first_failed = (
        len(stages) > 1 and stages[0]["status"] not in ("solved", "acceptable")
        for stages in (r.get("stages", ()) for r in found.values())
    )
    yield Row(subject, "helped", sum(first_failed))
    yield Row(subject, "costs", minima(costs))


def minima(costs: np.ndarray) -> int:
    """Return the number of different costs, to a thousandth.

    Example:
        >>> minima(np.array([1.0, 1.0004, 1.2]))
        2
    """
    ordered = np.sort(costs)
    return 1 + int(np.sum(np.diff(ordered) > 1e-3 * np.abs(ordered[1:]))) if len(costs) else 0


def _values(found: dict[str, Result], name: str) -> np.ndarray:
    return np.array([r[name] for r in found.values() if r.get(name) is not None], float)


def experiment(extent: Extent | None = None) -> Specification:
    """Return the experiment; its size is that of the long or the short form if none is given."""

    def cases(part: Part, quick: bool) -> Cases:
        return dict(part.cases(extent or (QUICK_EXTENT if quick else Extent())))

    return Specification(
        name="synthesis-bench",
        title="Motions from tasks: time and success",
        parts={name: partial(cases, part) for name, part in PARTS.items()},
        quick_parts=QUICK_PARTS,
        summary=lambda r: summary(r) if "stages" in r else f"{r['cpu']:.2f} s",
        rows=rows,
        notes=NOTES,
        remarks=failure_remarks,
    )


EXPERIMENT = experiment()
