"""Standing on a plate that sways, fore-aft and sideways, with every kind of foot.

Fig. 11 of [Park2020]_, which says without numbers that the two-segment foot wobbles more in the one
way and fails in the other.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.experiments.kept_results import KeptResults
from plantigrade.experiments.page import Grid, write_page
from plantigrade.experiments.standing import (
    FORMULATIONS,
    ORDER,
    ROOMS,
    Standing,
    stand,
    stood_in_words,
)
from plantigrade.experiments.synthesis_trial import chosen_parts
from plantigrade.experiments.table import ResultTable, Row, equal
from plantigrade.world import Tilting
from plantigrade.world.start import PRESSURE

FILE, PAGE = "moving-slope.json", "moving-slope.html"
DURATION, PERIOD = 20.0, 4.0  # [s]
WAYS = {"fore-aft": 0.0, "lateral": np.pi / 2}
DEGREES = (10, 15)
PARTS = ("torque", "hybrid", "posture")
NOTES = (
    "",
    "The plate is a body on joints, driven along a sine of 4 s that grows to its size in the first "
    "period. 'trunk' is how far the trunk leans from where it did at first, a root mean square "
    "over time; 'sway' is the same of the centre of mass over the ground.",
)


def run(
    *,
    parts: Sequence[str] = (),
    quick: bool = False,
    out: Path | None = None,
    overwrite: bool = False,
    jobs: int = 1,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Return the table of the parts, which are formulations, and of all that was measured before.

    Raises:
        ParameterError: If there is no such part.
    """
    kept = KeptResults(out / FILE if out else None, say, anew=overwrite, rooms=ROOMS)
    cases: dict[str, Callable[[], dict[str, Any]]] = {}
    for part in chosen_parts(parts, PARTS, ("torque", "hybrid")[: 1 if quick else 2]):
        cases |= dict(_cases(part, quick))
    kept.get_all(cases, stood_in_words, jobs=jobs)
    grid = table(kept)
    errors = [f"{k}: {r['error']}" for k, r in kept.results.items() if "error" in r]
    notes = [*NOTES, *errors, *kept.notes()]
    found = ResultTable("Standing on a plate that sways", list(rows(kept)), notes, [grid.text()])
    if out is not None:
        write_page(out / PAGE, found, [grid.section()], kept)
    return found


def _cases(way: str, quick: bool) -> Iterator[tuple[str, Callable[[], dict[str, Any]]]]:
    """Yield every foot on every plate."""
    for foot in ORDER:
        for degrees in DEGREES[:1] if quick else DEGREES:
            for name, direction in WAYS.items():
                amplitude = float(np.deg2rad(degrees))
                plate = Tilting(amplitude=amplitude, period=PERIOD, direction=direction)
                duration = 5.0 if quick else DURATION
                make = partial(stand, Standing(foot, way, ahead=PRESSURE), (plate,), duration)
                yield f"{way}/{foot}/{name}/{degrees}", make


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
