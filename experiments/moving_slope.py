"""Standing on a plate that sways, fore-aft and sideways, with every kind of foot.

Fig. 11 of [Park2020]_, which says without numbers that the two-segment foot wobbles more in the one
way and fails in the other.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults
from experiments.measured import Measured
from experiments.page import Grid
from experiments.standing import FORMULATIONS, ORDER, Standing, stand, stood_in_words
from experiments.table import Row, equal
from plantigrade.world import Tilting
from plantigrade.world.standing import COM_ALONG_SOLE

DURATION, PERIOD = 20.0, 4.0  # [s]
WAYS = {"fore-aft": 0.0, "lateral": np.pi / 2}
DEGREES = (10, 15)
NOTES = (
    "",
    "The plate is a body on joints, driven along a sine of 4 s that grows to its size in the first "
    "period. 'trunk' is how far the trunk leans from where it did at first, a root mean square "
    "over time; 'sway' is the same of the centre of mass over the ground.",
)


def _cases(way: str, quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    """Return every foot on every plate."""
    cases = {}
    for foot in ORDER:
        for degrees in DEGREES[:1] if quick else DEGREES:
            for name, direction in WAYS.items():
                amplitude = float(np.deg2rad(degrees))
                plate = Tilting(amplitude=amplitude, period=PERIOD, direction=direction)
                duration = 5.0 if quick else DURATION
                make = partial(stand, Standing(foot, way, ahead=COM_ALONG_SOLE), (plate,), duration)
                cases[f"{way}/{foot}/{name}/{degrees}"] = make
    return cases


def table(kept: KeptResults) -> Grid:
    """Return one line for every foot and plate."""
    header = ("", "stood", "trunk deg", "sway mm", "slip mm", "points", "fell at s")
    lines = []
    for key, r in kept.results.items():
        if "error" in r:
            continue
        way, foot, name, degrees = key.split("/")
        cells = [f"{way}, {foot}, {degrees} deg {name}", "yes" if r["stood"] else "no"]
        cells += [f"{r['wobble']:.2f}", f"{r['sway']:.1f}", f"{r['slip']:.1f}"]
        cells += ["-" if r["points"] is None else f"{r['points']:.1f}"]
        lines.append([*cells, "" if r["stood"] else f"{r['time']:.1f}"])
    return Grid("On a plate that sways in four seconds", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return how much trunks wobble, and whether all stood with the multi-segment foot."""
    for way in FORMULATIONS:
        for foot in ORDER:
            found = kept.beginning(f"{way}/{foot}/")
            good = {k: r for k, r in found.items() if "error" not in r}
            if not good:
                continue
            fell = sum(not r["stood"] for r in good.values())
            if foot == "multi-segment" and way != "posture":
                yield equal(f"{way} {foot}", "falls", fell, 0)
            else:
                yield Row(f"{way} {foot}", "falls", fell)
            for key, r in good.items():
                _, _, name, degrees = key.split("/")
                if r["stood"]:
                    yield Row(f"{way} {foot}", f"{degrees} deg {name} trunk", r["wobble"], "deg")


EXPERIMENT = Measured(
    name="moving-slope",
    title="Standing on a plate that sways",
    parts={way: partial(_cases, way) for way in ("torque", "hybrid", "posture")},
    usual=("torque", "hybrid"),
    shortly=("torque",),
    brief=stood_in_words,
    grids=lambda kept: (table(kept),),
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
