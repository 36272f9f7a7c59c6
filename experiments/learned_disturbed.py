"""Learned walks over rough ground and under pushes: Fig. 10 and Fig. 12 of [Park2020]_."""

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.learned import (
    FEET,
    Walk,
    available_feet,
    cases_of,
    endure,
    summary,
    training_value,
)
from experiments.specification import Specification
from experiments.table import Row, at_least
from plantigrade.world import Push

# Rough ground -------------------------------------------------------------------------------------

DURATION = 20.0
"""Duration of a walk [s]."""
QUICK_DURATION = 5.0
"""Duration of a walk in the short form [s]."""
N_SEEDS = 20
"""Number of fields of bumps."""
HEIGHTS = (1, 2, 3, 5)
"""Heights of bumps [cm]."""
GOAL_HEIGHT = 3
"""Height of bumps with a goal [cm]."""
MIN_COMPLETED = 18
"""Goal: number of completed walks of :data:`N_SEEDS`."""


def rough_walks(foot: str, height: int, quick: bool, n: int = N_SEEDS) -> dict:
    """Return walks over several fields of bumps, by their seed."""
    duration = QUICK_DURATION if quick else DURATION
    return {
        str(seed): partial(endure, Walk(foot=foot, ground=f"bumps:{height}", seed=seed), duration)
        for seed in range(2 if quick else n)
    }


def _rough(height: int, quick: bool) -> Cases:
    return cases_of(
        "rough",
        lambda foot: {f"{height}/{k}": c for k, c in rough_walks(foot, height, quick).items()},
    )


def wilson(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of k in n, from 0 to 1.

    Example:
        >>> tuple(round(x, 2) for x in wilson(18, 20))
        (0.7, 0.97)
    """
    z, p = 1.96, k / n
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return float((middle - half) / (1 + z * z / n)), float((middle + half) / (1 + z * z / n))


def rough_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the number of completed walks; the multi-segment foot on 3 cm has a goal."""
    for foot in available_feet():
        yield Row(foot, "learned on relief of", 100.0 * training_value(foot, "terrain_m"), "cm")
    for foot in FEET:
        for height in HEIGHTS:
            if found := cached.select("rough", foot, height).values():
                stood, n = sum(r["stood"] for r in found), len(found)
                goal = MIN_COMPLETED * n / N_SEEDS if height == GOAL_HEIGHT else None
                goal = goal if foot == FEET[0] else None
                yield at_least(foot, f"{height} cm walked of {n}", stood, goal)
                low, high = wilson(stood, n)
                yield Row(foot, f"{height} cm, 95 % interval from", 100.0 * low, "%")
                yield Row(foot, f"{height} cm, 95 % interval to", 100.0 * high, "%")
                times = [r["time"] for r in found]
                yield Row(foot, f"{height} cm, duration, median", float(np.median(times)), "s")
                yield Row(foot, f"{height} cm, duration, least", min(times), "s")


ROUGH = Specification(
    name="rough-walk",
    title="Learned walks over rough ground",
    parts={f"{h}-cm": partial(_rough, h) for h in HEIGHTS},
    default_parts=(f"{GOAL_HEIGHT}-cm",),
    summary=summary,
    rows=rough_rows,
    notes=(
        "",
        "Relief of random heights, up to the given height above and below zero, smoothed over "
        "15 cm, another field for every seed; after 12 m it ends at an edge down to level ground. "
        "20 s. The height of the relief that policies learned on, with other seeds, is a figure of "
        "its own. In the paper the multi-segment foot walks on ±3 cm and the two-segment foot "
        "trips, without a count. The share has its 95 % interval (Wilson).",
    ),
)

# Pushes -------------------------------------------------------------------------------------------

PUSH_TIME = 2.0
"""Start of a push [s]."""
PUSH_DURATION = 0.4
"""Duration of a push [s]."""
WATCH_TIME = 5.0
"""Time on the feet after which a push counts as withstood [s]."""
FORCE_STEP = 20.0
"""Distance of the tried forces [N]."""
MAX_FORCE = 300.0
"""Greatest force that is tried [N]."""
PUSH_SIDES = {"front": 180, "front left": 225, "left": 270, "back left": 315, "back": 0,
         "back right": 45, "right": 90, "front right": 135}  # fmt: skip
"""Where a push comes from → direction of its force [deg]."""
SIDES = {name: PUSH_SIDES[name] for name in ("left", "right")}
PUSH_PHASES = (0.0, 0.25, 0.5, 0.75)
MIN_SIDE_PUSH = 80.0
"""Goal of the least side push over the stride [N], that of the paper."""
MEAN_SIDE_PUSH = 150.0
"""Goal of the mean side push over the stride [N]."""


def limit(walk: Walk, degrees: float) -> Result:
    """Return the greatest force withstood, tried in steps from the least on [N]."""
    force, direction = 0.0, float(np.deg2rad(degrees))
    while force < MAX_FORCE:
        push = Push(
            force=force + FORCE_STEP, duration=PUSH_DURATION, direction=direction, time=PUSH_TIME
        )
        if not endure(walk, PUSH_TIME + WATCH_TIME, (push,))["stood"]:
            break
        force += FORCE_STEP
    return {"force": force}


def pushed_walks(foot: str, directions: Mapping[str, int], quick: bool) -> dict:
    """Return push limits from several directions at several phases of the stride."""
    return {
        f"{name}/{begin}": partial(limit, Walk(foot=foot, begin=begin), degrees)
        for name, degrees in directions.items()
        for begin in PUSH_PHASES[: 1 if quick else None]
    }


def _pushed(directions: Mapping[str, int], quick: bool) -> Cases:
    some = dict(list(directions.items())[:1]) if quick else directions
    return cases_of("push", lambda foot: pushed_walks(foot, some, quick))


def _forces(cached: CachedResults, foot: str, *names: str) -> list[float]:
    return [r["force"] for name in names for r in cached.select("push", foot, name).values()]


def push_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the force withstood from the sides, with the paper's goal, and from all around."""
    for foot in available_feet():
        yield Row(foot, "learned with pushes up to", training_value(foot, "pushes_n"), "N")
    for foot in FEET:
        sides, every = _forces(cached, foot, *SIDES), _forces(cached, foot, *PUSH_SIDES)
        if sides:
            least, mean = (MIN_SIDE_PUSH, MEAN_SIDE_PUSH) if foot == FEET[0] else (None, None)
            yield at_least(foot, "side push, least", min(sides), least, "N")
            yield at_least(foot, "side push, mean", float(np.mean(sides)), mean, "N")
        for name in PUSH_SIDES:
            if forces := _forces(cached, foot, name):
                yield Row(foot, f"push from {name}, least", min(forces), "N")
                yield Row(foot, f"push from {name}, mean", float(np.mean(forces)), "N")
        if len(every) > len(sides):
            yield Row(foot, "all around, mean", float(np.mean(every)), "N")


PUSHED = Specification(
    name="pushed-walk",
    title="Pushed learned walks",
    parts={"sides": partial(_pushed, SIDES), "round": partial(_pushed, PUSH_SIDES)},
    default_parts=("sides",),
    rows=push_rows,
    notes=(
        "",
        "A push at the upper trunk for 0.4 s after two seconds of walking, in steps of 20 N until "
        "the first fall within five seconds; at four phases of the stride. The force of the pushes "
        "in training, at other times and from any direction, is a figure of its own. Directions "
        "are those from which a push comes. The paper pushes a walker by 40 and 60 N in its Fig. "
        "12: two-segment feet fall at 60 N, multi-segment feet do not; the goal is 80 N.",
    ),
)
