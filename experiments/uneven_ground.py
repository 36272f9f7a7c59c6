"""Standing on spheres, on domes under the arch and on bumps, with every kind of foot.

What Fig. 9 of [Park2020]_ shows, and fields of random bumps. Everybody starts with their soles laid
on the ground as closely as their foot can be (:func:`plantigrade.world.standing_on`).
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.measured import Measured
from experiments.page import Grid
from experiments.standing import FORMULATIONS, ORDER, Standing, stand, stood_in_words
from experiments.table import Row, at_least
from plantigrade.world.push_limits import PushTest

DURATION, SEEDS = 10.0, 20  # [s], fields of bumps
SHAPES = {"sphere:1": "sphere of 1 m", "sphere:0.5": "sphere of 0.5 m", "dome:2": "domes of 2 cm"}
BUMPS = "bumps:3"
SHARE = 90.0  # of the fields of bumps [%]
PUSHES = {"front": np.pi, "side": np.pi / 2, "back": 0.0}
PUSHED = ("sphere:1", "sphere:0.5", "dome:2")
STEP, WATCH = 2.5, 3.0  # of the forces of pushes [N], after a push [s]
NOTES = (
    "",
    "People of 1.50 m and 48.5 kg stand for ten seconds; all feet have the same sixteen contact "
    "points, outline and mass. 'points' is how many press with more than 1 N, 'slip' the farthest "
    "that one of them has moved since the first second. Bumps are up to 3 cm high and low, "
    "smoothed over 15 cm, another field for every seed. The paper shows its two-segment foot "
    "slip from a sphere, without numbers.",
)


def _cases(way: str, quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    """Return every foot on every ground."""
    cases = {}
    duration = 3.0 if quick else DURATION
    for foot in ORDER:
        for ground in SHAPES:
            standing = Standing(foot, way, ground)
            cases[f"{way}/{foot}/{ground}"] = partial(stand, standing, (), duration)
        for seed in range(2 if quick else SEEDS):
            standing = Standing(foot, way, BUMPS, seed=seed)
            cases[f"{way}/{foot}/{BUMPS}/{seed}"] = partial(stand, standing, (), duration)
    return cases


def _pushes(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    """Return pushes on these grounds."""
    return {
        f"pushes/{foot}/{ground}/{side}": partial(_limit, foot, ground, towards)
        for foot in ORDER
        for ground in (PUSHED[:1] if quick else PUSHED)
        for side, towards in PUSHES.items()
    }


def _limit(foot: str, ground: str, towards: float) -> dict[str, Any]:
    test = PushTest(situation=Standing(foot, "torque", ground), watch_time=WATCH)
    limit = test.limit(towards, step=STEP)
    return {"force": limit.force, "gaps": list(limit.gaps)}


def _brief(result: Result) -> str:
    return f"{result['force']:g} N" if "force" in result else stood_in_words(result)


def _on(kept: KeptResults, way: str, foot: str) -> Iterator[tuple[str, list[Result]]]:
    """Yield what was measured, by kind of ground."""
    for ground, words in (*SHAPES.items(), (BUMPS, "bumps of 3 cm")):
        found = kept.beginning(f"{way}/{foot}/{ground}")
        good = [r for r in found.values() if "error" not in r]
        if good:
            yield words, good


def table(kept: KeptResults) -> Grid:
    """Return one line for every foot, formulation and ground."""
    header = ("", "stood", "of", "slip mm", "most", "points", "trunk deg", "fell at s")
    lines = []
    for way in FORMULATIONS:
        for foot in ORDER:
            for words, found in _on(kept, way, foot):
                stood = [r for r in found if r["stood"]]
                fell = sorted(r["time"] for r in found if not r["stood"])
                cells = [f"{way}, {foot}, {words}", f"{len(stood)}", f"{len(found)}"]
                if stood:
                    slip, points, lean = (
                        np.array([r[name] for r in stood]) for name in ("slip", "points", "wobble")
                    )
                    cells += [f"{np.median(slip):.1f}", f"{slip.max():.1f}"]
                    cells += [f"{points.mean():.1f}", f"{np.median(lean):.2f}"]
                else:
                    cells += ["-"] * 4
                lines.append([*cells, f"{fell[0]:.1f}" if fell else ""])
    return Grid("Ten seconds on uneven ground", header, lines)


def push_grid(kept: KeptResults) -> Grid:
    """Return the largest pushes on these grounds."""
    lines = []
    for ground in PUSHED:
        for foot in ORDER:
            forces = [
                kept.results.get(f"pushes/{foot}/{ground}/{s}", {}).get("force") for s in PUSHES
            ]
            if all(f is not None for f in forces):
                lines.append([f"{SHAPES[ground]}, {foot}", *(f"{f:g}" for f in forces)])
                lines[-1].append(f"{sum(f or 0.0 for f in forces):g}")
    return Grid("Largest push there [N], torques", ("", *PUSHES, "sum"), lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return the share that stood; that of the multi-segment foot is held against a goal."""
    for way in FORMULATIONS:
        for foot in ORDER:
            for words, found in _on(kept, way, foot):
                share = 100.0 * float(np.mean([r["stood"] for r in found]))
                subject, what = f"{way} {foot}", f"{words} stood"
                goal = SHARE if "bumps" in words else 100.0
                if foot == "multi-segment" and way != "posture":
                    yield at_least(subject, what, share, goal, "%")
                else:
                    yield Row(subject, what, share, "%")
                points = [r["points"] for r in found if r["stood"]]
                if points:
                    yield Row(subject, f"{words} points", float(np.mean(points)))
    for key, result in kept.beginning("pushes/").items():
        if "error" not in result:
            _, foot, ground, side = key.split("/")
            yield Row(f"push {foot}", f"{SHAPES[ground]} {side}", result["force"], "N")


EXPERIMENT = Measured(
    name="uneven-ground",
    title="Standing on uneven ground",
    parts={way: partial(_cases, way) for way in ("torque", "hybrid", "posture")}
    | {"pushes": _pushes},
    usual=("torque",),
    brief=_brief,
    grids=lambda kept: (table(kept), push_grid(kept)),
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
