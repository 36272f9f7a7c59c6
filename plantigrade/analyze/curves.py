"""Curves over the gait cycle, from a record alone: angles, moments, powers, ground reactions."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion import Table
from plantigrade.motion.cycles import PERCENT, Cycle, cut_cycles, normalise_cycles
from plantigrade.record import Record
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, quaternion_to_pelvis_angles

GRAVITY = 9.81
AXES = ("forward", "left", "up")
PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "pelvis_tx", "pelvis_ty", "pelvis_tz")


@dataclass(frozen=True)
class GaitCurves:
    """Curves by name, one row per cycle of the curve's own side (the right side's for the midline).

    Attributes:
        percent: Percent of the gait cycle.
        cycles: The cycles of both feet, by start.
        angles: Coordinate → angle [degrees].
        moments: Coordinate → internal moment [N m/kg]; NaN where the force is not known.
        powers: Coordinate → power [W/kg].
        forces: ``forward_r``, ``left_r``, ``up_r``, … → ground reaction [body weights].
    """

    percent: Float[Array, " n_percent"]
    cycles: tuple[Cycle, ...]
    angles: dict[str, np.ndarray]
    moments: dict[str, np.ndarray]
    powers: dict[str, np.ndarray]
    forces: dict[str, np.ndarray]


def coordinates_of(record: Record) -> Table:
    """Return OpenSim's coordinates of a record [rad, m], pelvis first."""
    qpos = record.motion.qpos
    angles = quaternion_to_pelvis_angles(qpos[:, 3:7])
    values = np.hstack([angles, qpos[:, :3] @ OPENSIM_TO_WORLD, qpos[:, 7:]])
    return Table(PELVIS + tuple(record.motion.joint_names[1:]), record.motion.time, values)


def gait_curves(model: mujoco.MjModel, record: Record) -> GaitCurves:
    """Return the curves of a record over its gait cycles; empty where it has none.

    Args:
        model: The body, for its mass.
        record: What happened.
    """
    motion = record.motion
    cycles = cut_cycles(motion.events)
    mass = float(model.body_mass.sum())

    def over(values: np.ndarray, name: str) -> np.ndarray:
        side = side_of(name) or "r"
        rows = normalise_cycles(motion.time, values, [c for c in cycles if c.side == side])
        return rows[np.isfinite(rows).mean(axis=1) > 0.5] if len(rows) else rows

    table = coordinates_of(record)
    angles = {
        n: over(np.rad2deg(table.values[:, i]), n)
        for i, n in enumerate(table.names)
        if n not in PELVIS[3:]
    }
    moments, powers, forces = {}, {}, {}
    if record.qfrc_actuator is not None:
        for i, n in enumerate(motion.joint_names[1:], start=6):
            tau = known_above(model, record, n) * record.qfrc_actuator[:, i] / mass
            moments[n] = over(tau, n)
            powers[n] = over(tau * motion.qvel[:, i], n)
    if record.contact_force is not None:
        for side in ("r", "l"):
            mine = [k for k, s in enumerate(record.contact_side) if s == side]
            if not mine:
                continue
            total = record.contact_force[:, mine].sum(axis=1) * known(record, side)[:, None]
            for axis, label in enumerate(AXES):
                name = f"{label}_{side}"
                forces[name] = over(total[:, axis] / (mass * GRAVITY), name)
    return GaitCurves(PERCENT, cycles, angles, moments, powers, forces)


def known(record: Record, side: str | None) -> Float[Array, " n_frames"]:
    """Return 1 where the forces on a foot (on both where ``side`` is None) are known, else NaN."""
    return _known(record, [k for k, s in enumerate(record.contact_side) if side in (None, s)])


def known_above(model: mujoco.MjModel, record: Record, joint: str) -> Float[Array, " n_frames"]:
    """Return 1 where the forces that a joint's moment depends on are known, else NaN.

    They are those on the segments the joint moves: of a leg the forces under that leg, of trunk
    and arms none.

    Args:
        model: The body.
        record: What happened.
        joint: Name of the joint.
    """
    moved = int(model.joint(joint).bodyid[0])
    mine: list[int] = []
    for k, (segment, side) in enumerate(
        zip(record.contact_segment, record.contact_side, strict=True)
    ):
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{segment}_{side}")
        if body < 0:  # a record that does not name segments: by the side of the name
            if side_of(joint) in (None, side):
                mine.append(k)
            continue
        while body > moved:  # parents come before their children
            body = model.body_parentid[body]
        if body == moved:
            mine.append(k)
    return _known(record, mine)


def _known(record: Record, contacts: list[int]) -> Float[Array, " n_frames"]:
    table = record.contact_known
    if table is None:
        return np.ones(record.motion.n_frames)
    return np.where(table[:, contacts].all(axis=1), 1.0, np.nan)


def side_of(name: str) -> str | None:
    """Return ``"r"``, ``"l"`` or None for a name without side.

    Example:
        >>> side_of("knee_angle_r"), side_of("lumbar_extension")
        ('r', None)
    """
    return name[-1] if name[-2:] in ("_r", "_l") else None
