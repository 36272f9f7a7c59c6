"""Foot progression: how far a foot points out of the direction of walking."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import PointSet
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmarks_of
from plantigrade.motion.cycles import PERCENT, cut_cycles, frames_near, normalise_cycles
from plantigrade.record import Record

MARKS = ("heel", "metatarsal_1_head", "metatarsal_5_head")
SHORTEST = 0.3
"""Way of the pelvis in a stride below which the person walks on the spot or on a belt [m]."""


def foot_line(record: Record, side: str) -> Float[Array, "n_frames 3"]:
    """Return the direction from the heel to the forefoot, world axes, unit length.

    Where heel and second metatarsal head carried markers it is the line between them, as in Plug-in
    Gait [Kadaba1990]_, as recorded: a body without torsion of its shanks cannot point its feet as
    people do. Else the middle of first and fifth metatarsal heads is the forefoot, by their markers
    or the body's own points.
    """
    for front in (("metatarsal_2_head",), MARKS[1:]):
        found = [marker_path(record, f"{mark}_{side}") for mark in (MARKS[0], *front)]
        seen = [each[0] for each in found if each is not None]
        if len(seen) == len(found):
            path = np.stack(seen, axis=1)
            break
    else:
        table = attachments(record.human)
        points = PointSet.of(record.human, [table[f"{mark}_{side}"] for mark in MARKS])
        path = points.path(record.motion.qpos)
    line = path[:, 1:].mean(axis=1) - path[:, 0]
    return line / np.linalg.norm(line, axis=1, keepdims=True)


def marker_path(record: Record, landmark: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return where a marker was recorded, gaps closed by the body's motion, and its place [m]."""
    markers, fitted = record.recorded_markers, record.fitted_markers
    if markers is None or fitted is None:
        return None
    name = landmarks_of(markers.names).get(landmark)
    if name is None:
        return None
    column = markers.index(name)
    place = fitted[:, column]
    off = markers.positions[:, column] - place
    known = np.isfinite(off[:, 0])
    if not known.any():
        return None
    frames = np.arange(len(off))
    off = np.stack([np.interp(frames, frames[known], x[known]) for x in off.T], axis=1)
    return place + off, place


def inward_angle(
    line: Float[Array, "n_frames 3"], side: str, way: Float[Array, " 2"]
) -> Float[Array, " n_frames"]:
    """Return the angle of a foot's line to the vertical plane through ``way`` [rad].

    It is positive inward. While the foot is flat it is the angle seen from above; while it stands
    on its tip, where the line has hardly an extent seen from above, it stays small. So clinical
    programs that turn the foot by pitch, roll and progression, in this order, have it too.
    """
    left = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    return (1.0 if side == "r" else -1.0) * np.arcsin(np.clip(line[:, :2] @ left, -1, 1))


def foot_progression(record: Record) -> dict[str, Float[Array, "n_cycles 101"]]:
    """Return the foot progression angle over every gait cycle [deg], positive inward.

    It is the angle between the line of the foot (:func:`foot_line`) and the vertical plane through
    the way of the pelvis in that stride; on a treadmill the forward axis takes the place of that
    way.

    Returns:
        ``foot_progression_r`` and ``foot_progression_l``, one row per cycle of that foot; empty
        where there is none.
    """
    motion = record.motion
    found: dict[str, np.ndarray] = {}
    for side in SIDES:
        cycles = cut_cycles(motion.events, side=side)
        if not cycles:
            continue
        line = foot_line(record, side)
        rows = []
        for cycle in cycles:
            start, stop = (
                int(np.argmin(np.abs(motion.time - t))) for t in (cycle.start, cycle.stop)
            )
            way = motion.qpos[stop, :2] - motion.qpos[start, :2]
            way = way if np.linalg.norm(way) > SHORTEST else np.array([1.0, 0.0])
            near = frames_near(motion.time, cycle)
            angle = np.rad2deg(inward_angle(line[near], side, way))
            rows += list(normalise_cycles(motion.time[near], angle, [cycle]))
        found[f"foot_progression_{side}"] = np.array(rows).reshape(-1, len(PERCENT))
    return found
