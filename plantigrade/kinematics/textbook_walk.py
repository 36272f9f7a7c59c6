"""The textbook walk as a motion on a person, whose feet stand on the ground and do not slide.

The angles are published means (:mod:`plantigrade.models.textbook_gait`).
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.models import Human
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.motion import GaitEvent
from plantigrade.motion.filters import lowpass


@dataclass(frozen=True)
class TextbookWalk:
    """The walk on a person."""

    human: Human  #: The person
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    qpos: Float[Array, "n_frames nq"]  #: Configurations
    events: tuple[GaitEvent, ...]  #: Heel strikes and toe offs as the book has them
    speed: float  #: Walking speed [m/s]


def textbook_walk(
    human: Human, *, speed: float = 1.25, rate: float = 100.0, cycles: int = 3
) -> TextbookWalk:
    """Return so many strides of the published mean walk, on a person who stands on the ground.

    The speed is in m/s, the frames per second in Hz.
    """
    d = human.dimensions
    walk = textbook_gait(speed, d.thigh + d.shank + d.ankle_height, rate=rate, cycles=cycles)
    names = tuple(walk.coordinates)
    qpos = human.from_coordinates(names, np.stack([walk.coordinates[n] for n in names], axis=1))
    for _ in range(2):
        depth = lowest(human, qpos)
        qpos[:, 2] -= lowpass(walk.time, depth, cutoff=6.0)
    stance = np.stack([walk.stance(side) for side in ("r", "l")], axis=1)
    qpos = plant_feet(human, qpos, stance, rate=rate)
    events = [
        GaitEvent(float(t), side, kind)
        for table, kind in ((walk.heel_strikes, "heel_strike"), (walk.toe_offs, "toe_off"))
        for side, times in table.items()
        for t in times
    ]
    events.sort(key=lambda e: (e.time, e.side))
    return TextbookWalk(human, walk.time, qpos, tuple(events), speed)
