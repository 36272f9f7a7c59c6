"""Recorded walks along the path of a square, to the left and to the right."""

from pathlib import Path

import numpy as np

from experiments.cached_results import Result
from experiments.walk_trial import walk
from experiments.walkers import Walker, walks_as
from experiments.walking import figures, recorded
from plantigrade.arrays import Array, Float
from plantigrade.control.gait.reference import period_of
from plantigrade.record import Record
from plantigrade.world import Controller

PREFIX = "square"
"""First word of the names of these walks."""
TURN_SIGNS = {"left": 1.0, "right": -1.0}
"""Sense of rotation by the side to which a walk turns."""
SIDE_LENGTH = 4.0
"""Length of a side [m]."""
DURATION = 25.0
"""Duration of a walk [s]."""
N_ROUNDS = 4
"""Rounds of its path."""


def square(controller: str, data: Path, name: str, way: str, seconds: float) -> Result:
    """Return a recorded walk along a square; the speed is that along its path."""
    one = walks_as(controller, recorded(data / name))
    if period_of(one.record)[0] is None or not one.controller().follow(_corners(way)):
        return {"left_out": "is walked once, or cannot be led"}
    found = walk(_round(one, way), duration=seconds)
    went = float(np.linalg.norm(np.diff(found.com[:, :2], axis=0), axis=1).sum())
    return {**figures(found, since=1.0), "speed": went / max(found.seconds, 1e-9)}


def _round(one: Walker, way: str) -> Walker:
    """Return a walker that follows a square."""

    def make(_: Record) -> Controller:
        made = one.controller()
        made.follow(_corners(way))
        return made

    return Walker(one.record, make, one.name)


def _corners(way: str) -> Float[Array, "n 2"]:
    """Return the corners of a square in the order of the path [m]."""
    corners = SIDE_LENGTH * np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]] * N_ROUNDS)
    return corners * [1.0, TURN_SIGNS[way]]
