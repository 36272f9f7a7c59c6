"""A benchmark for any controller that walks: how hard it may be pushed, and a tour with punches.

One table a controller, ``--controller FILE.py:NAME`` for one from outside (docs/experiments.md).
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.push_map import FORCE, MASS, map_cases, maps, pictures, strengths
from experiments.table import Row
from experiments.walking import CONTROLLERS, runs, walking
from plantigrade.workflows.tour import WAYPOINTS, tour

TOURS, BEST = 10, 77.0
"""Tours, and the share that the best of the robot's policies completed [%]."""
NOTES = (
    "",
    "Pushes as in the experiment push-map: 0.4 s at the trunk, back to the gait within six "
    "seconds. A tour is twelve waypoints in 60 s, as far apart as 0.8 of the recorded speed asks "
    "for, with a punch on every way: up to 600 N × 0.08 s over the ground, at a random body, "
    "direction and time. Who follows no waypoints goes straight on. 34 policies of a humanoid "
    "robot were compared in this form in 2026: the best completed 77 %, many 0 to 5 %; its body, "
    "30 to 35 kg, is another, so that figures are not comparable but by form.",
)


def toured(controller: str, data: Path | None, seed: int, n: int) -> Result:
    """Return what became of a tour."""
    found = tour(walking(controller, data), seed, n=n)
    return {
        "completed": found.completed,
        "reached": found.reached,
        "of": n,
        "end": found.end,
        "seconds": found.seconds,
        "straight": found.straight,
        "punches": [list(p) for p in found.punches],
    }


def tour_cases(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    """Return tours from several seeds."""
    n, tours = (2, 1) if quick else (WAYPOINTS, TOURS)
    return {
        f"tour/{controller}/{n}/{seed}": partial(toured, controller, data, seed, n)
        for seed in range(1, tours + 1)
        for controller in controllers
    }


def _brief(result: Result) -> str:
    if "force" in result:
        return f"{result['force']:g} N"
    ended = "completed" if result["completed"] else result["end"]
    return f"{result['reached']} of {result['of']} waypoints, {ended}"


def tours(kept: KeptResults) -> dict[str, list[Result]]:
    """Return the tours by controller; whole ones if there are any."""
    found: dict[str, list[Result]] = {}
    for key, result in kept.beginning("tour/").items():
        if "error" not in result:
            found.setdefault(key.split("/", 1)[1].rsplit("/", 2)[0], []).append(result)
    return {
        name: [r for r in own if r["of"] == max(each["of"] for each in own)]
        for name, own in found.items()
    }


def tables(kept: KeptResults) -> Iterator[Grid]:
    """Return one table a controller."""
    pushed = {controller: found for (kind, controller), found in maps(kept).items()}
    gone = tours(kept)
    for name in sorted({*pushed, *gone}):
        lines = []
        if name in pushed:
            force = np.array([r["force"] for r in pushed[name].values()])
            feet = np.array([r["on_feet"] for r in pushed[name].values()])
            for words, size in (("back to the gait", force), ("on the feet", feet)):
                found = (float(size.min()), float(np.median(size)), float(size.max()))
                change = found[1] * FORCE / MASS
                cells = [f"{x:g} N" for x in found]
                lines.append(
                    [f"pushes of 0.4 s, {words}", *cells, f"{change:.2f} m/s", str(len(size))]
                )
        if name in gone:
            own = gone[name]
            reached = np.array([100.0 * r["reached"] / r["of"] for r in own])
            share = 100.0 * float(np.mean([r["completed"] for r in own]))
            cells = [f"{x:.0f} %" for x in (reached.min(), np.median(reached), reached.max())]
            way = "straight" if own[0]["straight"] else "with turns"
            lines.append([f"waypoints reached, tours {way}", *cells, "", str(len(own))])
            lines.append(["tours completed", "", f"{share:.0f} %", "", "", str(len(own))])
        yield Grid(name, ("", "worst", "median", "best", "median by mass", "cases"), lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return the figures of all controllers."""
    for (_, name), found in maps(kept).items():
        force = [float(r["force"]) for r in found.values()]
        yield Row(name, "push, worst", min(force), "N")
        yield Row(name, "push, median", float(np.median(force)), "N")
        yield Row(name, "push, best", max(force), "N")
    for name, own in tours(kept).items():
        share = 100.0 * float(np.mean([r["completed"] for r in own]))
        yield Row(name, "tours completed", share, "%", note=f"best of 34 policies: {BEST:g} %")
        reached = 100.0 * float(np.mean([r["reached"] / r["of"] for r in own]))
        yield Row(name, "waypoints reached", reached, "%")


def experiment(controllers: Sequence[str], data: Path | None) -> Measured:
    """Return the benchmark for some controllers."""
    return Measured(
        name="push-any-controller",
        title="Any controller, pushed while walking",
        parts={
            "map": partial(map_cases, controllers, data, "force", False),
            "tour": partial(tour_cases, controllers, data),
            "full map": partial(map_cases, controllers, data, "force", True),
        },
        usual=("map", "tour"),
        shortly=("map", "tour"),
        brief=_brief,
        grids=lambda kept: (*tables(kept), strengths()),
        rows=rows,
        notes=NOTES,
        pictures=pictures,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
