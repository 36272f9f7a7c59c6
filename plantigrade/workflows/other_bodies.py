"""Motions transferred to other bodies, and people with other legs or another strength."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.person import world_sites
from plantigrade.control.gait.reference import period_of, reference_of
from plantigrade.control.gait.schedule import StanceSchedule
from plantigrade.control.pendulum import walk_of
from plantigrade.errors import ParameterError
from plantigrade.kinematics.leg_inverse import LegInverse
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import lowpass
from plantigrade.record import Record

SOLES = 3.0
"""The pelvis of a walk brought over to another body is led up and down below this frequency [Hz];
at 6 Hz one walk would have had .1 to 1.5 times the weight on its feet, recorded with .7 to 1.3."""
LARGE, TOGETHER = 1.25, 6.0
"""Legs do not reach where feet are so many times as large for them as in the recording: knees would
bend twice as far; the whole body is led up and down then, below this frequency [Hz].
"""
LEGS = ("thigh", "shank")


def on_body(record: Record, human: Human, *, faster: float = 1.0) -> Record:
    """Return a motion transferred to another body: the same angles, dynamically similar.

    Lengths go by that of the leg and times by its root, so that the ratio of inertia to weight
    (Froude number) stays. The pelvis is led to where the feet are on the ground slowly, lest the
    body bounce, and the legs reach for the rest: soles are as high as recorded, and feet no
    nearer to each other than the hips are wide, lest long legs cross; feet that are large for their
    legs keep all angles. Forces are left out.

    Args:
        record: The motion, on level ground.
        human: The other person.
        faster: Time goes so many times faster.
    """
    motion, scale = record.motion, leg_of(human) / leg_of(record.human)
    names, values = record.human.to_coordinates(motion.qpos)
    values = values.copy()
    values[:, 3:6] *= scale
    qpos = human.from_coordinates(names, values)
    pace = float(np.sqrt(scale)) / faster
    time = pace * (motion.time - motion.time[0])
    own, other = human.dimensions.foot_length, record.human.dimensions.foot_length
    large = own / other > LARGE * scale
    qpos[:, 2] -= lowpass(time, lowest(human, qpos), cutoff=TOGETHER if large else SOLES)
    if not large:
        legs = _Legs.of(record.human, motion.qpos)
        wider = min(_Legs.of(human, qpos[:1]).hips / legs.hips, scale)
        qpos = _reached(human, qpos, scale * (legs.sole - record.ground.height), wider * legs.aside)
    events = tuple(replace(e, time=pace * (e.time - motion.time[0])) for e in motion.events)
    qvel = np.zeros((len(time), human.model.nv))
    moved = Motion(time, qpos, qvel, human.joint_names, events=events)
    return Record(human, moved, ground=replace(record.ground, height=0.0), notes=record.notes)


def walk_on_body(record: Record, human: Human) -> Record:
    """Return a closed walk transferred to another body, with the same foot contacts.

    As :func:`on_body`, which leads the lowest point to the ground; then whole feet are planted
    when they stand in the walk itself, so that none of another shape rocks or drags, and what each
    carries is taken from there, by weight.

    Args:
        record: The walk.
        human: The other person.

    Raises:
        ParameterError: If it has no stride that could be repeated.
    """
    walk = walk_of(record)
    period, advance = period_of(walk)
    if period is None:
        raise ParameterError("no stride of it nearly closes, so the walk cannot be repeated")
    motion, n = walk.motion, walk.motion.n_frames - 1
    reference = reference_of(walk)
    sides = [s.side for s in world_sites(walk)]
    on = [reference.at(float(t - motion.time[0])).contact > 0.5 for t in motion.time[:-1]]
    own = [np.array(sides) == side for side in SIDES]
    stance = np.array([[row[mine].any() for mine in own] for row in on])
    qpos = np.concatenate([motion.qpos[:-1], motion.qpos[:-1]])
    qpos[n:, :3] += advance
    time = np.concatenate([motion.time[:-1], motion.time[:-1] + period]) - motion.time[0]
    qvel = np.zeros((2 * n, record.human.model.nv))
    twice = Motion(time, qpos, qvel, record.human.joint_names)
    moved = on_body(replace(walk, motion=twice, contact_force=None), human).motion
    rate = (moved.n_frames - 1) / moved.duration
    planted = plant_feet(human, moved.qpos, np.concatenate([stance, stance]), rate=rate)
    cut = slice(n // 2, n // 2 + n + 1)  # away from both ends, where nothing is planted
    stride = Motion(
        moved.time[cut], planted[cut], np.zeros((n + 1, human.model.nv)), human.joint_names
    )
    found = walk_of(Record(human, stride, notes=walk.notes))
    phases = (np.linspace(0.0, 1.0, found.motion.n_frames) + (n // 2) / n) * period
    load = np.zeros((len(phases), 2, 3))
    load[:, :, 2] = found.weight * np.array([_shares(reference.schedule, p) for p in phases])
    return replace(found, signals={**found.signals, "estimated.force": load})


def _shares(schedule: StanceSchedule, phase: float) -> Float[Array, " 2"]:
    """Return what part of the load each foot has, right and left."""
    _, alpha, _ = schedule.weights(phase)
    sides = np.array([s.side for s in schedule.stances])
    return np.array([alpha[sides == side].sum() for side in SIDES])


@dataclass(frozen=True, eq=False)
class _Legs:
    """Where feet are in postures, right and left.

    Attributes:
        ankle: Place of the foot, world [m].
        turn: Its axes, as columns.
        sole: Height of its lowest point [m].
        aside: How far it is to the left of its hip [m].
        left: Where left is, for the pelvis.
        hips: How far the hips are apart [m].
    """

    ankle: Float[Array, "n 2 3"]
    turn: Float[Array, "n 2 3 3"]
    sole: Float[Array, "n 2"]
    aside: Float[Array, "n 2"]
    left: Float[Array, "n 3"]
    hips: float

    @classmethod
    def of(cls, human: Human, qpos: Float[Array, "n nq"]) -> "_Legs":
        state, still = State(human, qpos[0]), np.zeros(human.model.nv)
        feet, hips = (np.array([human.body(f"{b}_{s}") for s in SIDES]) for b in ("foot", "femur"))
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
        sole = np.stack([paths.position[:, paths.of(s), 2].min(axis=1) for s in SIDES], axis=1)
        return cls(ankle, turn, sole, np.einsum("nik,nk->ni", ankle - hip, left), left, apart)


def _reached(
    human: Human, qpos: Float[Array, "n nq"], sole: Float[Array, "n 2"], aside: Float[Array, "n 2"]
) -> Float[Array, "n nq"]:
    """Return postures whose soles are at heights and whose feet are so far beside their hips."""
    now = _Legs.of(human, qpos)
    ankle = now.ankle + (aside - now.aside)[:, :, None] * now.left[:, None]
    ankle[:, :, 2] += sole - now.sole
    return LegInverse(human).reach(qpos, ankle, now.turn).qpos


def leg_of(human: Human) -> float:
    """Return the length of a leg, hip to ankle [m]."""
    return float(human.dimensions.thigh + human.dimensions.shank)


def with_legs(human: Human, times: float) -> Human:
    """Return a person whose thighs and shanks are so many times as long; all else stays.

    Raises:
        ParameterError: If there can be no such person.
    """
    told = human.to_dict()
    lengths = {n: v * (times if n in LEGS else 1.0) for n, v in told["lengths"].items()}
    height = told["height"] + (times - 1.0) * leg_of(human)
    return Human.from_dict({**told, "height": height, "lengths": lengths, "soles": {}})


def as_strong(human: Human, times: float) -> Human:
    """Return a person whose joints are so many times as strong; they are not stored like that."""

    def stronger(found: re.Match[str]) -> str:
        most = " ".join(f"{times * float(x):.8g}" for x in found[1].split())
        return f'actuatorfrcrange="{most}"'

    if times == 1.0:
        return human
    return replace(human, xml=re.sub(r'actuatorfrcrange="([^"]*)"', stronger, human.xml))


def limits_of(human: Human) -> Mapping[str, tuple[float, float]]:
    """Return the greatest torques of the hinges of one leg and the trunk [N m]."""
    ranges = np.array(human.model.jnt_actfrcrange[1:])
    named = dict(zip(human.coordinates, ranges.tolist(), strict=True))
    return {
        n.removesuffix("_r"): (float(r[0]), float(r[1]))
        for n, r in named.items()
        if n.endswith("_r") or n.startswith("lumbar")
    }
