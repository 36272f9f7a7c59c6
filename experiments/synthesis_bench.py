"""How fast and how surely motions come from tasks: cold, warm, from bad guesses, of many kinds.

Every motion is made by one thread, from its task to what the solver found, and judged by the
checker; a success is a motion that the solver calls solved and the checker calls ok. Times are
those of the processor: what a free core takes on the clock.
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.page import Grid, write_page
from experiments.synthesis_cases import PARTS, QUICK, QUICK_PARTS, Extent, Part
from experiments.synthesis_trial import brief, chosen_parts, failures, motion_rows
from experiments.table import ResultTable, Row, at_least, at_most

FILE, PAGE = "synthesis-bench.json", "synthesis-bench.html"

NOTES = (
    "",
    "How to read it: a motion counts as made if the solver says solved and the checker, on a grid "
    "ten times finer than the nodes, finds nothing out of its limits. Times are the processor's, "
    "of one thread, from the task (mesh, equations of the person, guess) to the motion, without "
    "the checker; a warm start has the equations of the person. 'clock' is what went by on this "
    "machine, whatever else it was doing. Loading is what the first motion of a process waits "
    "longer for derivatives that are on disk already. No compiler is used anywhere. Noise on a "
    "first guess is a sum of smooth waves on every coordinate "
    "(plantigrade.trajopt.guess.walk.with_noise), its size a root mean square. 'helped' counts "
    "motions whose first try failed: an easier problem then leads there, and starts from the "
    "task's own guess without the noise. 'costs' counts the different minima that guesses of a "
    "part led to (costs that differ by more than a thousandth).",
)


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
