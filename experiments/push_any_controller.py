"""A benchmark for any walking controller: push limits, and a tour with punches.

One column for each controller, ``--controller FILE.py:NAME`` for one from outside
(docs/experiments-control.md).
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Result
from experiments.push_map import FORCE_DURATION, map_cases, maps, mass_of, pictures, strengths
from experiments.specification import Cases, Specification
from experiments.table import Row
from experiments.tour import N_WAYPOINTS, guest_tour, tour
from experiments.walkers import guest_named
from experiments.walking import CONTROLLERS, runs, walking

N_TOURS = 10
"""Number of tours."""
N_MANY_TOURS = 500
"""Number of tours of the long part: a share of 85 % then has a 95 % interval of ±3 %."""
BEST_ROBOT_SHARE = 77.0
"""Share of tours that the best of the robot's policies completed [%]."""
NOTES = (
    "",
    "Pushes as in the experiment push-map: 0.4 s at the trunk, back to the gait within six "
    "seconds. A tour is twelve waypoints in 60 s, as far apart as 0.8 of the recorded speed asks "
    "for, with a punch on every way: up to 600 N × 0.08 s over the ground, at a random body, "
    "direction and time. Controllers without waypoints go straight on. 34 policies of a humanoid "
    "robot were compared in this form in 2026: the best completed 77 %, many 0 to 5 %; its body, "
    "30 to 35 kg, is another, so that figures are not comparable but by form.",
)


def toured(controller: str, data: Path | None, seed: int, n: int) -> Result:
    """Return the outcome of a tour."""
    guest = guest_named(controller)
    found = guest_tour(guest, seed, n=n) if guest else tour(walking(controller, data), seed, n=n)
    return {
        "completed": found.completed,
        "reached": found.reached,
        "of": n,
        "end": found.end,
        "seconds": found.seconds,
        "straight": found.straight,
        "punches": [list(p) for p in found.punches],
    }


def tour_cases(controllers: Sequence[str], data: Path | None, tours: int, quick: bool) -> Cases:
    """Return tours from several seeds."""
    n, tours = (2, 1) if quick else (N_WAYPOINTS, tours)
    return {
        f"tour/{controller}/{n}/{seed}": partial(toured, controller, data, seed, n)
        for seed in range(1, tours + 1)
        for controller in controllers
    }


def _summary(result: Result) -> str:
    if "force" in result:
        return f"{result['force']:g} N"
    ended = "completed" if result["completed"] else result["end"]
    return f"{result['reached']} of {result['of']} waypoints, {ended}"


def tours(cached: CachedResults) -> dict[str, list[Result]]:
    """Return the tours by controller; whole ones if there are any."""
    found: dict[str, list[Result]] = {}
    for key, result in cached.select("tour").items():
        found.setdefault(key.split("/", 1)[1].rsplit("/", 2)[0], []).append(result)
    return {
        name: [r for r in own if r["of"] == max(each["of"] for each in own)]
        for name, own in found.items()
    }


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of all controllers."""
    for (_, name), found in maps(cached).items():
        for key, words in (("force", "push"), ("on_feet", "push, on the feet")):
            force = [float(r[key]) for r in found.values()]
            yield Row(name, f"{words}, worst", min(force), "N")
            yield Row(name, f"{words}, median", float(np.median(force)), "N")
            yield Row(name, f"{words}, best", max(force), "N")
            change = float(np.median(force)) * FORCE_DURATION / mass_of(found)
            yield Row(name, f"{words}, median by mass", change, "m/s")
        yield Row(name, "pushes", len(found))
        yield Row(name, "body mass", mass_of(found), "kg")
        if "speed" in (one := next(iter(found.values()))):
            yield Row(name, "speed of the walk", float(one["speed"]), "m/s")
    for name, own in tours(cached).items():
        share = 100.0 * float(np.mean([r["completed"] for r in own]))
        yield Row(
            name, "tours completed", share, "%", note=f"best of 34 policies: {BEST_ROBOT_SHARE:g} %"
        )
        reached = [100.0 * r["reached"] / r["of"] for r in own]
        yield Row(name, "waypoints reached", float(np.mean(reached)), "%")
        yield Row(name, "waypoints reached, worst", min(reached), "%")
        yield Row(name, "waypoints reached, best", max(reached), "%")
        yield Row(name, "tours with turns", float(not own[0]["straight"]))
        yield Row(name, "tours", len(own))


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the benchmark for some controllers."""
    return Specification(
        name="push-any-controller",
        title="Any controller, pushed while walking",
        parts={
            "map": partial(map_cases, controllers, data, "force", False),
            "tour": partial(tour_cases, controllers, data, N_TOURS),
            "500 tours": partial(tour_cases, controllers, data, N_MANY_TOURS),
            "full map": partial(map_cases, controllers, data, "force", True),
        },
        default_parts=("map", "tour"),
        summary=_summary,
        grids=lambda _: (strengths(),),
        rows=rows,
        notes=NOTES,
        pictures=pictures,
    )


run = runs(experiment, guests=True)
EXPERIMENT = experiment(CONTROLLERS, None)
