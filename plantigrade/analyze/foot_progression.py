"""Foot progression: angle of a foot to the direction of walking."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmarks_of
from plantigrade.motion.cycles import PERCENT, cut_cycles, frames_near, normalise_cycles
from plantigrade.motion.filters import bridged_gaps
from plantigrade.record import Record
from plantigrade.spatial.conventions import nearest_right_angle, rotation_matrix, unit_vectors

MARKS = ("heel", "metatarsal_1_head", "metatarsal_5_head")
MIN_DISPLACEMENT = 0.3
"""Displacement of the pelvis per stride below which the person walks on the spot or a belt [m]."""


def foot_line(record: Record, side: str) -> Float[Array, "n_frames 3"]:
    """Return the direction from the heel to the forefoot, world axes, unit length.

    If heel and second metatarsal head carried markers it is the recorded line between them, as in
    Plug-in Gait [Kadaba1990]_, because a body without tibial torsion cannot reproduce it. Otherwise
    the forefoot is the midpoint of the first and fifth metatarsal heads, of markers or of the body.
    """
    for front in (("metatarsal_2_head",), MARKS[1:]):
        found = [marker_path(record, f"{mark}_{side}") for mark in (MARKS[0], *front)]
        seen = [each[0] for each in found if each is not None]
        if len(seen) == len(found):
            path = np.stack(seen, axis=1)
            break
    else:
        if type(record.human) is not Human:  # a model of the person's own has no landmarks
            soles = sole_paths(record.human, record.motion.qpos)
            heel, ball = (soles.position[:, soles.of(side, part)] for part in ("heel", "ball"))
            return unit_vectors(ball.mean(axis=1) - heel.mean(axis=1))
        table = attachments(record.human)
        points = PointSet.of(record.human, [table[f"{mark}_{side}"] for mark in MARKS])
        path = points.path(record.motion.qpos)
    return unit_vectors(path[:, 1:].mean(axis=1) - path[:, 0])


def marker_path(record: Record, landmark: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return recorded, gap-filled and fitted paths of a landmark's marker [m]."""
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
    return place + bridged_gaps(off, known), place


def inward_angle(
    line: Float[Array, "n_frames 3"], side: str, way: Float[Array, " 2"]
) -> Float[Array, " n_frames"]:
    """Return the inward angle of a foot's line to the vertical plane through ``way`` [rad].

    For a flat foot it is the angle in the horizontal plane; for a foot on its tip it remains small.
    It equals that of clinical programs with rotations in the order pitch, roll, progression.
    """
    left = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    return (1.0 if side == "r" else -1.0) * np.arcsin(np.clip(line[:, :2] @ left, -1, 1))


def foot_progression(
    record: Record, *, side: str | None = None
) -> dict[str, Float[Array, "n_cycles 101"]]:
    """Return the foot progression angle over every gait cycle [deg], positive inward.

    It is the angle between the line of the foot (:func:`foot_line`) and the vertical plane through
    the displacement of the pelvis in that stride, or through the forward axis on a treadmill. Where
    a person walks backward or sideways, that plane is turned by two or one right angles to where
    the pelvis faces, so that toes that point outward are negative there, too.

    Args:
        side: Foot, ``"r"`` or ``"l"``; both if absent.

    Returns:
        ``foot_progression_r`` and ``foot_progression_l``, one row per cycle of that foot.
    """
    motion = record.motion
    found: dict[str, np.ndarray] = {}
    for own in SIDES if side is None else (side,):
        cycles = cut_cycles(motion.events, side=own)
        if not cycles:
            continue
        line = foot_line(record, own)
        rows = []
        for cycle in cycles:
            start, stop = (
                int(np.argmin(np.abs(motion.time - t))) for t in (cycle.start, cycle.stop)
            )
            way = motion.qpos[stop, :2] - motion.qpos[start, :2]
            way = way if np.linalg.norm(way) > MIN_DISPLACEMENT else np.array([1.0, 0.0])
            quats = motion.qpos[start : stop + 1, 3:7]
            way = nearest_right_angle(way, rotation_matrix(quats)[:, :2, 0].mean(axis=0))
            near = frames_near(motion.time, cycle)
            angle = np.rad2deg(inward_angle(line[near], own, way))
            rows += list(normalise_cycles(motion.time[near], angle, [cycle]))
        found[f"foot_progression_{own}"] = np.array(rows).reshape(-1, len(PERCENT))
    return found
