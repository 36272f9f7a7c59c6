"""Toes and feet that no marker shows: as the ground under them has it, or as in standing.

Toes are bent by the ground, or like the neighbouring toes. Some video detectors (COCO) end at the
ankle: while an ankle joint moves little its sole rests, and the shank tells the angle of the ankle.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_rests import ContactFrames, point_speed
from plantigrade.kinematics.state import body_paths
from plantigrade.kinematics.unmeasured_joints import ankle_paths
from plantigrade.models import Human
from plantigrade.models.keypoints import shows_toes
from plantigrade.models.landmarks import Attachment
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import even_clock, rate_of

TOE_JOINTS = {
    "toes": "mtp_angle",
    "medial_phalanges": "mtp_angle",
    "lateral_phalanges": "mtp4_angle",
}
"""Part of the foot → the joint that bends it."""
MAX_ANKLE_SPEED = 0.45  # [m/s] of a standing foot: the shank turns over it, noise adds to it
MIN_TIME = 0.12  # [s] minimum duration of a flat foot
# [deg] standard deviation of the change of angles that puts the sole on the ground
SPREADS = {"ankle_angle": 30.0, "subtalar_angle": 8.0, "knee_angle": 1.0, "hip_flexion": 1.0}


def unseen_toes_follow(
    human: Human, places: Sequence[Attachment], qpos: Float[Array, "n_frames nq"]
) -> Float[Array, "n_frames nq"]:
    """Return the poses with toes that carry no marker bent like their neighbours that do.

    No marker moves by it: the toes are the last segments of the foot.
    """
    seen = {p.body for p in places}
    qpos = np.array(qpos)
    for side in SIDES:
        medial, lateral = f"medial_phalanges_{side}", f"lateral_phalanges_{side}"
        if lateral not in human.body_names or (medial in seen) == (lateral in seen):
            continue
        hinges = [7 + human.hinge(f"{joint}_angle_{side}") for joint in ("mtp", "mtp4")]
        known, unseen = hinges if medial in seen else hinges[::-1]
        qpos[:, unseen] = qpos[:, known]
    return qpos


def toes_on_ground(
    human: Human,
    places: Sequence[Attachment],
    qpos: Float[Array, "n_frames nq"],
    *,
    ground: Ground = LEVEL_GROUND,
) -> Float[Array, "n_frames nq"]:
    """Return the poses with toes that carry no marker bent as far as the ground bends them.

    They are straight in the air; where the foot comes up over them they stay on the ground.
    """
    seen = {p.body for p in places}
    qpos = np.array(qpos)
    for side in SIDES:
        toes = {f"{part}_{side}": f"{joint}_{side}" for part, joint in TOE_JOINTS.items()}
        toes = {part: joint for part, joint in toes.items() if part in human.body_names}
        if not toes or seen & set(toes):
            continue
        for part, joint in toes.items():
            qpos[:, 7 + human.hinge(joint)] = _bent(human, qpos, part, joint, ground)
    return qpos


def _bent(human: Human, qpos: np.ndarray, part: str, joint: str, ground: Ground) -> np.ndarray:
    """Return the least angle at which no point of the toes is below the ground [rad]."""
    body = next(b for b in human.skeleton.bodies if b.name == part)
    hinge = next(h for h in body.hinges if h.name == joint)
    angles = np.linspace(0.0, hinge.high, 31)
    turned = Rotation.from_rotvec(angles[:, None] * hinge.axis).as_matrix()
    spheres = np.array([c.position for c in body.contacts])
    radius = np.array([c.radius for c in body.contacts])
    places = body.position + np.einsum("aij,kj->aki", turned, spheres)  # in the parent
    parent = human.body(body.parent)
    origin, rotation = (path[:, 0] for path in body_paths(human, qpos, [parent]))
    if ground.steps:
        centres = origin[:, None, None] + np.einsum("fij,akj->faki", rotation, places)
        above = ground.above(centres)[..., 2]
    else:
        up = np.einsum("fij,i->fj", rotation, ground.normal)
        above = np.einsum("fi,aki->fak", up, places)
        above += (origin @ ground.normal - ground.height)[:, None, None]
    above = (above - radius).min(axis=2)
    clear = above >= 0.0
    first = np.where(clear.any(axis=1), clear.argmax(axis=1), above.argmax(axis=1))
    before, rows = np.maximum(first - 1, 0), np.arange(len(qpos))
    low, high = above[rows, before], above[rows, first]
    crossed = (low < 0) & (high > 0)
    share = np.where(crossed, -low / np.where(crossed, high - low, 1.0), 1.0)
    return angles[before] + share * (angles[first] - angles[before])


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
    path = ankle_paths(human, qpos)
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
