"""Motions transferred to other bodies: the same angles, dynamically similar."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.leg_inverse import LegInverse
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import lowpass
from plantigrade.record import Record
from plantigrade.spatial.conventions import less_tilted

PELVIS_CUTOFF = 3.0
"""Low-pass of the correction of the pelvis' height [Hz]: at 6 Hz the feet of one walk would carry
0.1 to 1.5 times the weight; recorded were 0.7 to 1.3."""
MAX_FOOT_RATIO = 1.25
"""Ratio of foot to leg length, over that of the recording, above which feet roll less: heels are
raised by no more than that times what the length of the leg says. Feet that were large for their
legs threw the body up and down with up to 17 m/s², farther than gravity can. Chosen."""


def transferred(record: Record, human: Human, *, faster: float = 1.0) -> Record:
    """Return a motion transferred to another body: the same angles, dynamically similar.

    Lengths scale with that of the leg and times with its square root, so that the Froude number
    stays. A slow correction of the pelvis brings the feet to the ground without bouncing; inverse
    kinematics of the legs corrects the rest: soles are as high as recorded, and the distance of the
    feet is at least that of the hips, so that long legs do not cross. Feet that are large for their
    legs roll less. Forces are left out.
    """
    motion, scale = record.motion, leg_length(human) / leg_length(record.human)
    names, values = record.human.to_coordinates(motion.qpos)
    values = values.copy()
    values[:, 3:6] *= scale
    qpos = human.from_coordinates(names, values)
    time_scale = float(np.sqrt(scale)) / faster
    time = time_scale * (motion.time - motion.time[0])
    own, other = human.dimensions.foot_length, record.human.dimensions.foot_length
    roll = MAX_FOOT_RATIO * scale * other / own
    if roll < 1.0:
        qpos = _rolled(human, qpos, roll)
    qpos[:, 2] -= lowpass(time, lowest(human, qpos), cutoff=PELVIS_CUTOFF)
    legs = _Legs.of(record.human, motion.qpos)
    wider = min(_Legs.of(human, qpos[:1]).hips / legs.hips, scale)
    qpos = _reached(human, qpos, scale * (legs.sole - record.ground.height), wider * legs.aside)
    events = tuple(replace(e, time=time_scale * (e.time - motion.time[0])) for e in motion.events)
    qvel = np.zeros((len(time), human.model.nv))
    moved = Motion(time, qpos, qvel, human.joint_names, events=events)
    return Record(human, moved, ground=replace(record.ground, height=0.0), notes=record.notes)


def leg_length(human: Human) -> float:
    """Return the length of a leg, hip to ankle [m]."""
    return float(human.dimensions.thigh + human.dimensions.shank)


@dataclass(frozen=True, eq=False)
class _Legs:
    """Feet in a sequence of postures, right and left."""

    ankle: Float[Array, "n 2 3"]  #: Position of the foot, world [m]
    turn: Float[Array, "n 2 3 3"]  #: Axes of the foot, as columns
    sole: Float[Array, "n 2"]  #: Height of its lowest point [m]
    aside: Float[Array, "n 2"]  #: Lateral offset from its hip, to the left [m]
    left: Float[Array, "n 3"]  #: Direction to the left of the pelvis, world
    hips: float  #: Distance of the hips [m]

    @classmethod
    def of(cls, human: Human, qpos: Float[Array, "n nq"]) -> "_Legs":
        state, still = BodyState(human, qpos[0]), np.zeros(human.model.nv)
        feet, hips = (np.array(human.both(bone)) for bone in ("foot", "femur"))
        ankle, hip = np.zeros((2, len(qpos), 2, 3))
        turn, left = np.zeros((len(qpos), 2, 3, 3)), np.zeros((len(qpos), 3))
        for k, posture in enumerate(qpos):
            state = state.moved_to(posture, still)
            ankle[k], hip[k] = state.origins[feet], state.origins[hips]
            turn[k] = state.rotations[feet]
            left[k, :2] = (hip[k, 1] - hip[k, 0])[:2]
        left /= np.linalg.norm(left, axis=1)[:, None]
        apart = float(np.linalg.norm(hip[0, 1] - hip[0, 0]))
        paths = sole_paths(human, qpos)
        sole = np.stack([paths.lowest(s) for s in SIDES], axis=1)
        return cls(ankle, turn, sole, np.einsum("nik,nk->ni", ankle - hip, left), left, apart)


def _rolled(human: Human, qpos: Float[Array, "n nq"], part: float) -> Float[Array, "n nq"]:
    """Return postures whose feet, and toes in them, are tilted by a part of what they were."""
    now, out = _Legs.of(human, qpos), qpos.copy()
    turn = np.array([[less_tilted(R, 1.0 - part) for R in feet] for feet in now.turn])
    toes = [i for i, name in enumerate(human.coordinates) if name.startswith("mtp")]
    out[:, 7 + np.array(toes, dtype=int)] *= part
    return LegInverse(human).reach(out, now.ankle, turn)


def _reached(
    human: Human, qpos: Float[Array, "n nq"], sole: Float[Array, "n 2"], aside: Float[Array, "n 2"]
) -> Float[Array, "n nq"]:
    """Return postures with given heights of the soles [m] and lateral offsets of the feet [m]."""
    now = _Legs.of(human, qpos)
    ankle = now.ankle + (aside - now.aside)[:, :, None] * now.left[:, None]
    ankle[:, :, 2] += sole - now.sole
    return LegInverse(human).reach(qpos, ankle, now.turn)
