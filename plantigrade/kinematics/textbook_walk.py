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

__all__ = ["TextbookWalk", "textbook_walk"]

ADULT_SPREAD = {"hip_flexion": 7.0, "hip_adduction": 2.2, "hip_rotation": 5.0, "knee_angle": 3.0,
                "ankle_angle": 1.5, "subtalar_angle": 8.0, "mtp_angle": 10.0}  # fmt: skip
"""Standard deviation of the change of each joint angle that keeps the feet on the ground [deg]:
about the smallest between adults in the cycle [Fukuchi2018]_; chosen by eye for joints of feet."""


@dataclass(frozen=True)
class TextbookWalk:
    """The walk on a person."""

    human: Human  #: The person
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    qpos: Float[Array, "n_frames nq"]  #: Configurations
    events: tuple[GaitEvent, ...]  #: Heel strikes and toe offs as the book has them
    speed: float  #: Walking speed [m/s]


def textbook_walk(
    human: Human, *, speed: float = 1.25, rate: float = 100.0, cycles: int = 3, adult: bool = False
) -> TextbookWalk:
    """Return so many strides of the published mean walk, on a person who stands on the ground.

    The speed is in m/s, the frames per second in Hz; ``adult`` selects the mean of adults instead
    of that of children.
    """
    d = human.dimensions
    leg = d.leg_length
    walk = textbook_gait(speed, leg, rate=rate, cycles=cycles, adult=adult)
    names = tuple(walk.coordinates)
    qpos = human.from_coordinates(names, np.stack([walk.coordinates[n] for n in names], axis=1))
    for _ in range(2):
        depth = lowest(human, qpos)
        qpos[:, 2] -= lowpass(walk.time, depth, cutoff=6.0)
    stance = np.stack([walk.stance(side) for side in ("r", "l")], axis=1)
    spread = {n: float(np.deg2rad(v)) for n, v in ADULT_SPREAD.items()} if adult else None
    qpos = plant_feet(human, qpos, stance, rate=rate, spread=spread)
    events = [
        GaitEvent(float(t), side, kind)
        for table, kind in ((walk.heel_strikes, "heel_strike"), (walk.toe_offs, "toe_off"))
        for side, times in table.items()
        for t in times
    ]
    events.sort(key=lambda e: (e.time, e.side))
    return TextbookWalk(human, walk.time, qpos, tuple(events), speed)
