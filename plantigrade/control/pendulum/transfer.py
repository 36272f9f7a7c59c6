"""Walks transferred to other bodies, with the contacts of their feet."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.person import world_sites
from plantigrade.control.gait.reference import period_of, reference_of
from plantigrade.control.gait.schedule import StanceSchedule
from plantigrade.control.pendulum import walk_of
from plantigrade.errors import ParameterError
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.transfer import transferred
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record


def transferred_walk(record: Record, human: Human) -> Record:
    """Return a closed walk transferred to another body, with the same foot contacts.

    After :func:`~plantigrade.kinematics.transfer.transferred`, whole feet are planted while they
    stand in the original walk, so that feet of another shape do not rock or slide. Each foot
    carries the share of the weight that it has there.
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
    moved = transferred(replace(walk, motion=twice, contact_force=None), human).motion
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
    """Return the load share of each foot, right and left."""
    _, alpha, _ = schedule.weights(phase)
    sides = np.array([s.side for s in schedule.stances])
    return np.array([alpha[sides == side].sum() for side in SIDES])
