r"""Angles as defined by gait laboratories, where coordinates of the model differ.

The coordinate ``ankle_angle`` rotates one rigid foot against the shank, as a compromise of all
markers on both. A laboratory measures a line on each segment instead. Both are given, under
different names:

* ``ankle_dorsiflexion`` is the angle between the lines knee centre to ankle centre and ankle centre
  to second metatarsal head, in the shank's sagittal plane, less a right angle and the slope of the
  latter line on a flat sole, as in Plug-in Gait [Kadaba1990]_, [Davis1991]_. Knee and ankle centre
  are determined by the markers on epicondyles and malleoli, the metatarsal head by its marker. The
  angle therefore includes the midfoot, which adds several degrees at push-off when the arch flexes,
  and the soft tissue artefact at the knee. Missing markers are replaced by points of the body.
* ``hip_adduction_thigh`` and ``hip_rotation_thigh`` are those of a thigh rotated about its hip
  centre to fit its own markers alone, as in Plug-in Gait. The knee of the default body is a hinge,
  so ``hip_rotation`` is a compromise of thigh, shank and foot; that of the thigh's markers includes
  knee rotation and soft tissue artefact, in walking 10 to 15 degrees at the end of swing. They need
  two markers on the thigh.
* ``knee_adduction_markers`` and ``knee_rotation_markers`` are those of a shank that fits its own
  markers against that thigh, as in [GroodSuntay1983]_; the hinge of the default body excludes them.
  They need three markers on each segment. The axis of the hinge makes their mean zero, so only
  their changes are meaningful. They include several degrees of soft tissue artefact of the thigh in
  walking [Leardini2005]_.
* ``foot_progression`` is the angle between the line from the heel to the second metatarsal head
  (see :func:`plantigrade.analyze.foot_progression.foot_line`) and the vertical plane through the
  forward axis, positive inward.
* ``pelvis_tilt_plane`` and ``hip_flexion_plane`` are tilt and hip flexion of a pelvis defined by
  the plane through its iliac spines, positive forward: the coordinates ``pelvis_tilt`` (positive
  backward) and ``hip_flexion`` plus the constant :data:`plantigrade.models.anatomy.SPINE_PLANE`.

``ankle_dorsiflexion`` and ``foot_progression`` are zero in standing with vertical shanks and flat
feet that point forward.
"""

from weakref import WeakKeyDictionary

import numpy as np

from plantigrade.analyze.foot_progression import foot_line, inward_angle, marker_path
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import PointSet, body_paths
from plantigrade.models import Human
from plantigrade.models.anatomy import SPINE_PLANE
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Table
from plantigrade.motion.cycles import cut_cycles, normalise_cycles
from plantigrade.record import Record
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles

TOE = "metatarsal_2_head"
FORWARD = np.array([1.0, 0.0])  # direction in which a fitted person faces
RIGID_TOLERANCE = 1e-6  # [m] movement of a marker relative to its body
MIN_THIGH_MARKERS = 2  # minimum number of markers on a thigh, besides its hip centre
MIN_KNEE_MARKERS = 3  # minimum number of markers on thigh and shank
_FOUND: WeakKeyDictionary[Record, Table | None] = WeakKeyDictionary()
"""Angles of the records that are in use: figures, curves, report and tables of a run ask for the
same ones, and they take most of the time of its curves."""


def marker_angles(record: Record) -> Table | None:
    """Return the angles of this module for which markers were recorded [rad].

    The result is None if there are none, or the person is a model of their own, without landmarks.
    It is computed once for a record.
    """
    if record not in _FOUND:
        _FOUND[record] = _marker_angles(record)
    return _FOUND[record]


def _marker_angles(record: Record) -> Table | None:
    if record.recorded_markers is None or type(record.human) is not Human:
        return None
    table, columns_kept = laboratory_angles(record), []
    for i, name in enumerate(table.names):
        ankle = name.startswith("ankle_dorsiflexion")
        by_markers = "_thigh_" in name or "_markers_" in name
        if by_markers or (ankle and marker_path(record, f"{TOE}_{name[-1]}") is not None):
            columns_kept.append(i)
    if not columns_kept:
        return None
    return Table(
        tuple(table.names[i] for i in columns_kept), table.time, table.values[:, columns_kept]
    )


def laboratory_figures(record: Record) -> dict[str, float]:
    """Return range and extremes over the gait cycle of :func:`marker_angles` [deg].

    They are means over the cycles of each foot; the result is empty without gait.
    """
    table = marker_angles(record)
    found: dict[str, float] = {}
    if table is None:
        return found
    for name in table.names:
        side = name[-1]
        cycles = cut_cycles(record.motion.events, side=side)
        rows = normalise_cycles(table.time, np.rad2deg(table[name]), cycles)
        rows = rows[np.isfinite(rows).all(axis=1)]
        if len(rows):
            low, high = (float(f(rows, axis=1).mean()) for f in (np.min, np.max))
            for what, value in (("min", low), ("max", high), ("rom", high - low)):
                found[f"{name[:-2]}_{what}_{side}_deg"] = value
    return found


def laboratory_angles(record: Record) -> Table:
    """Return the angles of this module over time [rad].

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
        columns.append(inward_angle(line, side, FORWARD))
        segment_angles = _segments_of_markers(record, side)
        for stem, pair in segment_angles.items():
            names += [f"{n}_{side}" for n in stem]
            columns += [*pair]
    return Table(tuple(names), record.motion.time, np.stack(columns, axis=1))


def _segments_of_markers(
    record: Record, side: str
) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Return adduction and rotation [rad] of hip and knee by segments that fit their own markers.

    The thigh is rotated about its hip centre, the shank about the mean of its markers, by least
    squares of the marker errors. A joint with too few markers is omitted.
    """
    markers, fitted = record.recorded_markers, record.fitted_markers
    if markers is None or fitted is None:
        return {}
    bodies = [record.human.body(n) for n in ("pelvis", f"femur_{side}", f"tibia_{side}")]
    parents = record.human.model.body_parentid
    bodies += np.flatnonzero(parents == bodies[2]).tolist()
    origins, axes = body_paths(record.human, record.motion.qpos, bodies)
    on = np.array([_fixed_on(fitted, origins[:, k], axes[:, k]) for k in range(len(bodies))])
    alone = on & (on.sum(axis=0) == 1)  # excludes markers of a joint that never moves
    mine, low = alone[1], alone[2]
    if mine.sum() < MIN_THIGH_MARKERS:
        return {}
    off = np.nan_to_num(markers.positions - fitted)
    pelvis, thigh, shank = (axes[:, k] for k in range(3))
    hip = origins[:, 1, None]
    thigh = _turned(thigh, fitted[:, mine] - hip, off[:, mine])
    found = {("hip_adduction_thigh", "hip_rotation_thigh"): _frontal(pelvis, thigh, side)}
    if min(mine.sum(), low.sum()) >= MIN_KNEE_MARKERS:
        arms = fitted[:, low] - fitted[:, low].mean(axis=1, keepdims=True)
        shank = _turned(shank, arms, off[:, low] - off[:, low].mean(axis=1, keepdims=True))
        knee = ("knee_adduction_markers", "knee_rotation_markers")
        hinge = _about(record.human.model.joint(f"knee_angle_{side}").axis)
        found[knee] = _frontal(thigh @ hinge, shank @ hinge, side)
    return found


def _fixed_on(points, origin, axes) -> np.ndarray:
    """Return which points are fixed on a body during the whole motion."""
    local = np.einsum("nji,nmj->nmi", axes, points - origin[:, None])
    return np.max(np.ptp(local, axis=0), axis=1) < RIGID_TOLERANCE


def _turned(axes, arms, off) -> np.ndarray:
    """Return axes rotated so that ``arms`` fit ``arms + off`` in the least-squares sense."""
    u, _, vt = np.linalg.svd(np.einsum("nmi,nmj->nij", arms + off, arms))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    return u @ vt @ axes


def _about(axis: np.ndarray) -> np.ndarray:
    """Return axes whose second is ``axis`` and whose first is as close as possible to x."""
    up = np.cross([1.0, 0.0, 0.0], axis)
    up /= np.linalg.norm(up)
    return np.stack([np.cross(axis, up), axis, up], axis=1)


def _frontal(above, below, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Return adduction and internal rotation relative to the segment above [rad]."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(np.swapaxes(above, 1, 2) @ below)
    _, adduction, rotation = turn.as_euler("YXZ").T
    sign = 1.0 if side == "r" else -1.0
    return sign * adduction, sign * rotation


def _dorsiflexion(record: Record, side: str) -> Float[Array, " n_frames"]:
    human, qpos = record.human, record.motion.qpos
    toe = attachments(human)[f"{TOE}_{side}"]
    origin = np.zeros(3)
    points = PointSet(
        human, [f"tibia_{side}", f"foot_{side}", toe.body], np.array([origin, origin, toe.position])
    )
    knee, joint, tip = np.swapaxes(points.path(qpos), 0, 1)
    bodies = [human.body(f"{name}_{side}") for name in ("femur", "tibia", "foot")]
    thigh, shank, foot = np.moveaxis(body_paths(human, qpos, bodies)[1], 1, 0)
    knee, _ = _carried(record, knee, thigh[..., 1], "knee", side)
    ankle, ankle_place = _carried(record, joint, shank[..., 1], "ankle", side)
    tip, tip_place = marker_path(record, f"{TOE}_{side}") or (tip, tip)
    up = knee - ankle
    forward = np.cross(shank[..., 1], up)
    line = tip - ankle
    along, above = (
        (line * axis).sum(axis=1) / np.linalg.norm(axis, axis=1) for axis in (forward, up)
    )
    # in the zero pose the axes of shank and foot are parallel and the sole is flat
    places = ((foot, tip_place), (shank, ankle_place))
    ball, heel = (np.einsum("nji,nj->ni", axes, x - joint).mean(axis=0) for axes, x in places)
    flat = ball - heel
    return np.arctan2(above, along) - np.arctan2(flat[2], flat[0])


def _carried(record: Record, centre, across, joint: str, side: str):
    """Return a joint centre at the height of its lateral and medial markers [m].

    The first result is by recorded markers, the second by fitted ones; ``across`` is the direction
    from the centre to the markers.
    """
    found = []
    for place in ("lateral", "medial"):
        marker = marker_path(record, f"{joint}_{place}_{side}")
        if marker is not None:
            recorded, fitted = marker
            inward = ((centre - fitted) * across).sum(axis=1, keepdims=True) * across
            found.append((recorded + inward, fitted + inward))
    return np.mean(found, axis=0) if found else (centre, centre)
