"""Feet that no keypoint shows: flat on the ground while their ankle is still, else as in standing.

Some detectors (COCO) end at the ankle. In stance the ground gives what the camera does not: while
the ankle joint moves little the sole rests, and the shank tells the angle of the ankle.
"""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_rests import ContactFrames, point_speed
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.keypoints import shows_toes
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import even_clock, rate_of

MAX_ANKLE_SPEED = 0.45  # [m/s] of a standing foot: the shank turns over it, noise adds to it
MIN_TIME = 0.12  # [s] minimum duration of a flat foot
# [deg] standard deviation of the change of angles that puts the sole on the ground
SPREADS = {"ankle_angle": 30.0, "subtalar_angle": 8.0, "knee_angle": 1.0, "hip_flexion": 1.0}


def with_flat_feet(
    human: Human,
    names: Sequence[str],
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
) -> Float[Array, "n_frames nq"]:
    """Return the motion with unseen feet flat on the floor z = 0 while their ankles are still.

    A motion whose keypoints show the toes is unchanged.

    Args:
        time: Time of each frame [s].
    """
    if shows_toes(names) or len(qpos) < 4:
        return qpos
    time = even_clock(time)
    ankles = [human.skeleton.parts[f"foot_{side}"] for side in SIDES]
    path = PointSet(human, [b for b, _ in ankles], np.array([at for _, at in ankles])).path(qpos)
    way = moving_ground(time, path, path)
    rests = []
    for k, side in enumerate(SIDES):
        still = point_speed(time, path[:, k] - way) < MAX_ANKLE_SPEED
        for run in runs(still):
            if time[run.stop - 1] - time[run.start] > MIN_TIME:
                frames = run.start, run.stop
                rests += [ContactFrames(side, part, *frames) for part in ("heel", "ball", "toes")]
    if not rests:
        return qpos
    spread = {name: float(np.deg2rad(value)) for name, value in SPREADS.items()}
    return plant_feet(human, qpos, rate=rate_of(time), rests=rests, way=way, spread=spread)
