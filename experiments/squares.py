"""Recorded walks led round the corners of a square, to the left and to the right."""

from pathlib import Path
from typing import Any

import numpy as np

from experiments.kept_results import Result
from experiments.walking import figures, recorded
from plantigrade.arrays import Array, Float
from plantigrade.control.gait.reference import period_of
from plantigrade.record import Record
from plantigrade.workflows.harness import walk
from plantigrade.workflows.walkers import Walker, walks_as
from plantigrade.world import Controller

PREFIX, SIDES = "square", {"left": 1.0, "right": -1.0}
SIDE, ROUND, SHORT = 4.0, 25.0, 8.0
"""Length of a side [m]; how long a walk lasts, and in the short form [s]."""
AGAIN = 4
"""So often it could go round in that time."""


def square(controller: str, path: Path, way: str, seconds: float) -> Result:
    """Return a recorded walk along a square; the speed is that along its own way."""
    one = walks_as(controller, recorded(path))
    if period_of(one.record)[0] is None or not one.controller().follow(_corners(way)):
        return {"left_out": "is walked once, or cannot be led"}
    found = walk(_round(one, way), duration=seconds)
    went = float(np.linalg.norm(np.diff(found.com[:, :2], axis=0), axis=1).sum())
    return {**figures(found, since=1.0), "speed": went / max(found.seconds, 1e-9)}


def _round(one: Walker, way: str) -> Walker:
    """Return somebody who is led along a square."""

    def make(_: Record) -> Controller:
        made = one.controller()
        made.follow(_corners(way))
        return made

    return Walker(one.record, make, one.name)


def _corners(way: str) -> Float[Array, "n 2"]:
    """Return the corners of a square, to be walked to in turn [m]."""
    corners = SIDE * np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]] * AGAIN)
    return corners * [1.0, SIDES[way]]


def cases(quick: bool, data: Path | None, names: tuple[str, ...]) -> dict[str, Any]:
    """Return what is to be measured: recordings of a folder, each to both sides."""
    if data is None:
        return {}
    seconds = SHORT if quick else ROUND
    return {
        f"{PREFIX} {way} {name}/{seconds:g} s": (square, (data / name, way, seconds))
        for name in (names[:1] if quick else names)
        for way in SIDES
        if (data / name).exists()
    }
