"""Learned walks over rough ground: Fig. 10 of [Park2020]_."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults
from experiments.learned import FEET, Walk, in_words, last, learned_with, there
from experiments.measured import Measured
from experiments.page import Grid
from experiments.table import Row, at_least

DURATION, SEEDS, HEIGHTS = 20.0, 20, (1, 2, 3, 5)  # [s], fields of bumps, [cm]
HELD = 3  # [cm]
WALK = 18  # of twenty seeds should walk to the end
NOTES = (
    "",
    "Relief of random heights, up to so many centimetres high and low, smoothed over 15 cm, "
    "another field for every seed; after 12 m it ends at an edge down to level ground. 20 s. How "
    "high the relief was that policies learned on, of other seeds, is said above. In the paper "
    "the multi-segment foot walks on ±3 cm and the two-segment foot trips, without a count. The "
    "share has its 95 % interval (Wilson).",
)


def _cases(height: int, quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    cases = {}
    for foot in there():
        for seed in range(2 if quick else SEEDS):
            walk = Walk(foot=foot, ground=f"bumps:{height}", seed=seed)
            make = partial(last, walk, 5.0 if quick else DURATION)
            cases[f"rough/{foot}/{height}/{seed}"] = make
    return cases


def wilson(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share of k in n, from 0 to 1.

    Example:
        >>> tuple(round(x, 2) for x in wilson(18, 20))
        (0.7, 0.97)
    """
    z, p = 1.96, k / n
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return float((middle - half) / (1 + z * z / n)), float((middle + half) / (1 + z * z / n))


def _found(kept: KeptResults) -> Iterator[tuple[str, int, list[dict[str, Any]]]]:
    for foot in FEET:
        for height in HEIGHTS:
            found = kept.beginning(f"rough/{foot}/{height}/").values()
            good = [r for r in found if "error" not in r]
            if good:
                yield foot, height, good


def table(kept: KeptResults) -> Iterator[Grid]:
    """Return how many walked to the end."""
    lines = []
    for foot, height, found in _found(kept):
        stood = sum(r["stood"] for r in found)
        low, high = wilson(stood, len(found))
        times = [r["time"] for r in found]
        cells = [f"{stood} of {len(found)}", f"{100 * low:.0f}–{100 * high:.0f}"]
        cells += [f"{np.median(times):.1f}", f"{min(times):.1f}"]
        lines.append([f"{foot}, {height} cm", *cells])
    header = ("", "walked", "95 % interval", "median s", "least s")
    yield Grid("Walks over rough ground", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return how many walked; with the multi-segment foot on 3 cm it is held against a goal."""
    for foot in there():
        yield Row(foot, "learned on relief of", 100.0 * learned_with(foot, "terrain_m"), "cm")
    for foot, height, found in _found(kept):
        stood, n = sum(r["stood"] for r in found), len(found)
        what = f"{height} cm walked of {n}"
        if foot == "multi-segment" and height == HELD:
            yield at_least(foot, what, stood, WALK * n / SEEDS)
        else:
            yield Row(foot, what, stood)


EXPERIMENT = Measured(
    name="rough-walk",
    title="Learned walks over rough ground",
    parts={f"{h}-cm": partial(_cases, h) for h in HEIGHTS},
    usual=("3-cm",),
    brief=in_words,
    grids=table,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
