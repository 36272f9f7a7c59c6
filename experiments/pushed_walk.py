"""Pushes that a learned walk withstands: Fig. 12 of [Park2020]_, and from all around."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.learned import FEET, Walk, last, learned_with, there
from experiments.measured import Measured
from experiments.page import Grid
from experiments.table import Row, at_least
from plantigrade.world import Push

WHEN, LONG, WATCH = 2.0, 0.4, 5.0  # a push begins, lasts, and is watched until after [s]
STEP, MOST = 20.0, 300.0  # [N]
SIDES = {"left": 270, "right": 90}
ROUND = {"front": 180, "front left": 225, "left": 270, "back left": 315, "back": 0,
         "back right": 45, "right": 90, "front right": 135}  # fmt: skip
"""Where a push comes from → direction of its force [deg]."""
PHASES = (0.0, 0.25, 0.5, 0.75)
PAPER, GOAL = 80.0, 150.0  # side push withstood: least, and mean over the stride [N]
NOTES = (
    "",
    "A push at the upper trunk for 0.4 s after two seconds of walking, in steps of 20 N until the "
    "first fall within five seconds; at four instants of the stride. How hard the policies were "
    "pushed while learning, at other times and from anywhere, is said above. "
    "Directions say where it comes from. The paper pushes a walker by 40 and 60 N in its Fig. 12: "
    "two-segment feet fall at 60 N, multi-segment feet do not; the goal is 80 N.",
)


def limit(walk: Walk, degrees: float) -> dict[str, Any]:
    """Return the greatest force withstood of those tried from the least on [N]."""
    force = 0.0
    while force < MOST:
        push = Push(
            force=force + STEP, duration=LONG, direction=float(np.deg2rad(degrees)), time=WHEN
        )
        if not last(walk, WHEN + WATCH, (push,))["stood"]:
            break
        force += STEP
    return {"force": force}


def _cases(ways: dict[str, int], quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    return {
        f"push/{foot}/{name}/{begin}": partial(limit, Walk(foot=foot, begin=begin), degrees)
        for foot in there()
        for name, degrees in (list(ways.items())[:1] if quick else ways.items())
        for begin in PHASES[: 1 if quick else None]
    }


def _forces(kept: KeptResults, foot: str, name: str) -> list[float]:
    found = kept.beginning(f"push/{foot}/{name}/").values()
    return [r["force"] for r in found if "force" in r]


def table(kept: KeptResults) -> Iterator[Grid]:
    """Return least and mean of what is withstood over the instants of the stride."""
    lines = []
    for name in ROUND:
        cells = []
        for foot in FEET:
            forces = _forces(kept, foot, name)
            cells.append(f"{min(forces):.0f} / {np.mean(forces):.0f}" if forces else "-")
        if set(cells) != {"-"}:
            lines.append([name, *cells])
    yield Grid("Pushes withstood, least / mean over the stride [N]", ("", *FEET), lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return what is withstood from the sides, held against the paper's goal, and all around."""
    for foot in there():
        yield Row(foot, "learned with pushes up to", learned_with(foot, "pushes_n"), "N")
    for foot in FEET:
        sides = [f for name in SIDES for f in _forces(kept, foot, name)]
        if sides:
            least, mean = min(sides), float(np.mean(sides))
            if foot == "multi-segment":
                yield at_least(foot, "side push, least", least, PAPER, "N")
                yield at_least(foot, "side push, mean", mean, GOAL, "N")
            else:
                yield Row(foot, "side push, least", least, "N")
                yield Row(foot, "side push, mean", mean, "N")
        every = [f for name in ROUND for f in _forces(kept, foot, name)]
        if len(every) > len(sides):
            yield Row(foot, "all around, mean", float(np.mean(every)), "N")


def _brief(result: Result) -> str:
    return f"{result['force']:g} N"


EXPERIMENT = Measured(
    name="pushed-walk",
    title="Pushed learned walks",
    parts={"sides": partial(_cases, SIDES), "round": partial(_cases, ROUND)},
    usual=("sides",),
    brief=_brief,
    grids=table,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
