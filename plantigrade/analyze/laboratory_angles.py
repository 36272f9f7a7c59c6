r"""Angles as gait laboratories define them, where a coordinate of the model is another thing.

The coordinate ``ankle_angle`` turns one rigid foot against the shank, as far as all markers on both
agree. A laboratory measures a line on each segment instead. Both are given, under different names:

* ``ankle_dorsiflexion`` is the angle between the lines knee centre to ankle centre and ankle centre
  to second metatarsal head, in the shank's sagittal plane, less a right angle and the slope of the
  latter line on a flat sole, as in Plug-in Gait [Kadaba1990]_, [Davis1991]_. Knee centre and ankle
  centre are where the markers on epicondyles and malleoli carry them, the metatarsal head is where
  its marker is. So it holds what ankle and midfoot bend together; at push-off, when the arch
  flexes, it is several degrees more than the ankle alone, and it holds the sliding of the knee's
  skin. Where one of these markers was not recorded the body's own point takes its place.
* ``foot_progression`` is the angle between the line from the heel to the second metatarsal head
  (see :func:`plantigrade.analyze.foot_progression.foot_line`) and the vertical plane through the
  forward axis, positive inward.
* ``pelvis_tilt_plane`` and ``hip_flexion_plane`` are tilt and hip flexion of a pelvis defined by
  the plane through its iliac spines, positive forward: the coordinates ``pelvis_tilt`` (positive
  backward) and ``hip_flexion`` but for :data:`plantigrade.models.anatomy.SPINE_PLANE`, the same for
  everybody.

The first two are zero where the person stands with vertical shanks on flat feet that point ahead.
"""

import numpy as np

from plantigrade.analyze.foot_progression import foot_line, inward_angle, marker_path
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models.anatomy import SPINE_PLANE
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Table
from plantigrade.motion.cycles import cut_cycles, normalise_cycles
from plantigrade.record import Record
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles

TOE = "metatarsal_2_head"
AHEAD = np.array([1.0, 0.0])  # where a fitted person faces


def shows_ankle(record: Record) -> bool:
    """Return whether markers were recorded that show the ankle otherwise than the body does."""
    return any(marker_path(record, f"{TOE}_{side}") is not None for side in SIDES)


def laboratory_figures(record: Record) -> dict[str, float]:
    """Return range of motion and extremes of ``ankle_dorsiflexion`` in the gait cycle [deg].

    Means over the cycles of each foot; nothing where no marker of the forefoot was recorded, or
    nobody walks.
    """
    if not shows_ankle(record):
        return {}
    table, found = laboratory_angles(record), {}
    for side in SIDES:
        name = f"ankle_dorsiflexion_{side}"
        cycles = cut_cycles(record.motion.events, side=side)
        rows = normalise_cycles(table.time, np.rad2deg(table[name]), cycles)
        rows = rows[np.isfinite(rows).all(axis=1)]
        if len(rows):
            low, high = (float(f(rows, axis=1).mean()) for f in (np.min, np.max))
            found[f"ankle_dorsiflexion_min_{side}_deg"] = low
            found[f"ankle_dorsiflexion_max_{side}_deg"] = high
            found[f"ankle_dorsiflexion_rom_{side}_deg"] = high - low
    return found


def laboratory_angles(record: Record) -> Table:
    """Return the angles of the module over time [rad], those of the legs of both sides.

    Flexion, dorsiflexion, forward tilt and internal rotation are positive.
    """
    plane = np.deg2rad(SPINE_PLANE)
    motion = record.motion
    names = ["pelvis_tilt_plane"]
    columns = [plane - quaternion_to_pelvis_angles(motion.qpos[:, 3:7])[:, 0]]
    for side in SIDES:
        names += [f"{n}_{side}" for n in ("hip_flexion_plane", "ankle_dorsiflexion")]
        names.append(f"foot_progression_{side}")
        line = foot_line(record, side)
        columns += [motion[f"hip_flexion_{side}"] + plane, _dorsiflexion(record, side)]
        columns.append(inward_angle(line, side, AHEAD))
    return Table(tuple(names), record.motion.time, np.stack(columns, axis=1))


def _dorsiflexion(record: Record, side: str) -> Float[Array, " n_frames"]:
    human, qpos = record.human, record.motion.qpos
    toe = attachments(human)[f"{TOE}_{side}"]
    points = PointSet(
        human,
        [f"tibia_{side}", f"foot_{side}", toe.body],
        np.array([np.zeros(3), np.zeros(3), toe.position]),
    )
    knee, ankle, tip = np.swapaxes(points.path(qpos), 0, 1)
    axes = np.array([state.rotations for state in sweep(human, qpos)])
    thigh, shank = (axes[:, human.body(f"{name}_{side}"), :, 1] for name in ("femur", "tibia"))
    knee = _carried(record, knee, thigh, "knee", side)
    ankle = _carried(record, ankle, shank, "ankle", side)
    tip = _seen(record, f"{TOE}_{side}", tip)
    up = knee - ankle
    forward = np.cross(shank, up)
    line = tip - ankle
    along, above = (
        (line * axis).sum(axis=1) / np.linalg.norm(axis, axis=1) for axis in (forward, up)
    )
    _, heel, ball = points.path(human.standing()[None])[0]
    flat = ball - heel
    return np.arctan2(above, along) - np.arctan2(flat[2], flat[0])


def _carried(record: Record, centre, across, joint: str, side: str) -> Float[Array, "n 3"]:
    """Return a joint centre at the height of its lateral and medial markers, as they move [m].

    ``across`` is the direction in which the markers lie beside the centre.
    """
    found = []
    for place in ("lateral", "medial"):
        marker = marker_path(record, f"{joint}_{place}_{side}")
        if marker is not None:
            recorded, fitted = marker
            inward = ((centre - fitted) * across).sum(axis=1, keepdims=True)
            found.append(recorded + inward * across)
    return np.mean(found, axis=0) if found else centre


def _seen(record: Record, landmark: str, point) -> Float[Array, "n 3"]:
    """Return where the marker of a landmark was recorded, or else the body's own point [m]."""
    marker = marker_path(record, landmark)
    return point if marker is None else marker[0]
