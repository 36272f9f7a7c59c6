"""The foot pose controller: one foot in one tick, and many frames at once, in processor time."""

import time
from collections.abc import Iterator

import numpy as np

from experiments.table import Row, at_most
from plantigrade.contact.ground import Ground
from plantigrade.contact.relief import Bump
from plantigrade.kinematics.foot_pose import SEGMENTS, FootPoser, marks
from plantigrade.models import Human

MAX_FOOT_TIME = 50.0  # one foot [us]
N_FRAMES = 200
N_ROUNDS = 20
N_REPEATS = 5
GROUNDS = {
    "level ground": Ground(),
    "on a sphere": Ground(height=-0.5, bumps=(Bump((0.05, 0.0, -0.5), 0.5),)),
}


def rows() -> Iterator[Row]:
    """Yield what one foot costs, all segments marked and on tiptoe."""
    poser = FootPoser(Human.create(1.50, 48.5, joints="66"), "r")
    poses = {"all marked": (SEGMENTS, poser.standing), "tiptoe": (SEGMENTS[2:], 0.095)}
    for what, ground in GROUNDS.items():
        for pose, (names, height) in poses.items():
            for frames in (1, N_FRAMES):
                quantity = "one tick" if frames == 1 else f"a frame of {frames}"
                spent = 1e6 * per_foot(poser, names, height, ground, frames)
                yield at_most(
                    f"foot pose, {what}", f"{pose}, {quantity}", spent, MAX_FOOT_TIME, "us"
                )


def per_foot(poser: FootPoser, names, height: float, ground: Ground, frames: int) -> float:
    """Return the least time of some rounds, for each frame [s]."""
    ankle = np.tile([0.0, 0.0, height], (frames, 1))
    facing, marked = np.tile(np.eye(3), (frames, 1, 1)), np.tile(marks(*names), (frames, 1))
    poser.pose(ankle, facing, marked, ground)
    times = []
    for _ in range(N_REPEATS):
        start = time.process_time()
        for _ in range(N_ROUNDS):
            poser.pose(ankle, facing, marked, ground)
        times.append((time.process_time() - start) / (N_ROUNDS * frames))
    return min(times)
