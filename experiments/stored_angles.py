"""Angles of a fit beside those stored with the recording: Plug-in Gait's, OpenSim's.

Two conventions of one rotation differ by a constant where their segments' axes do, so each angle is
held against the stored one in five figures: Pearson's r, the root mean square difference as it is
and without the mean difference, the difference of the ranges of motion, and the mean difference.

Plug-in Gait turns hip and pelvis in the order of our coordinates (flexion, adduction, rotation;
tilt, obliquity, rotation), so they are compared directly; ``pelvis_tilt_plane`` and
``hip_flexion_plane`` have its definition of the pelvis, too. Its ankle is the angle between the
shank and the line from the ankle joint centre to the toe marker, however much the foot bends
between them; beside the coordinate ``ankle_angle`` it is therefore held against
``ankle_dorsiflexion`` of :mod:`plantigrade.analyze.laboratory_angles`, which is defined in the same
way. Its hip turns as the thigh's markers do, so ``hip_rotation_thigh`` stands beside
``hip_rotation``, which a hinge of a knee shares with shank and foot.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.table import Row, at_least, sheet, text_of, within
from plantigrade.analyze.curves import coordinates_of
from plantigrade.analyze.laboratory_angles import laboratory_angles
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import Trial
from plantigrade.constants import SIDES
from plantigrade.motion import Recording, Table
from plantigrade.spatial.conventions import (
    PELVIS,
    pelvis_angles_to_quaternion,
    quaternion_to_pelvis_angles,
    wxyz_to_xyzw,
    xyzw_to_wxyz,
)

FIGURES = {
    "r": "",
    "RMSE": "deg",
    "RMSE without offset": "deg",
    "range, ours less theirs": "deg",
    "bias": "deg",
}
"""Figures of an agreement and their units."""
LEAST_MOTION = 2.0
"""Range below which a stored angle is locked or noise and nothing is held against it [deg]."""
MIN_COMMON_FRAMES = 20
"""Frames that both must have."""

# Goals by source and angle: least r, most RMSE, without offset, difference of ranges, bias [deg].
_FRONTAL = {
    "hip_adduction": (0.95, 3, None, None, None),
    "hip_rotation": (0.85, 5, None, None, None),
}
_GOALS: dict[str, dict[str, tuple[float | None, ...]]] = {
    "Plug-in Gait": {
        "pelvis_tilt_plane": (None, 3, None, None, None),
        "hip_flexion": (0.95, 5, None, None, None),
        "hip_flexion_plane": (None, None, None, None, 2.5),
        **_FRONTAL,
        "knee_angle": (0.95, None, None, None, 2.5),
        "ankle_angle": (0.95, None, None, None, None),
        **{f"{angle}_thigh": limits for angle, limits in _FRONTAL.items()},
        "ankle_dorsiflexion": (0.98, None, 2, 3, None),
    },
    "OpenSim": {
        **_FRONTAL,
        # its zeros are those of a scaled generic model, so a bias is shown and no more
        **dict.fromkeys(("hip_flexion", "knee_angle", "ankle_angle"), (None, None, 3, None, None)),
    },
}
# Our angle → Plug-in Gait's output, its column, and its sign on the right and on the left side.
_PLUG_IN_GAIT = {
    "pelvis_tilt": ("PelvisAngles", 0, -1, -1),
    "pelvis_tilt_plane": ("PelvisAngles", 0, 1, 1),
    "pelvis_list": ("PelvisAngles", 1, -1, 1),
    "pelvis_rotation": ("PelvisAngles", 2, 1, -1),
    "hip_flexion": ("HipAngles", 0, 1, 1),
    "hip_flexion_plane": ("HipAngles", 0, 1, 1),
    "hip_adduction": ("HipAngles", 1, 1, 1),
    "hip_rotation": ("HipAngles", 2, 1, 1),
    "hip_adduction_thigh": ("HipAngles", 1, 1, 1),
    "hip_rotation_thigh": ("HipAngles", 2, 1, 1),
    "knee_angle": ("KneeAngles", 0, 1, 1),
    "knee_adduction_markers": ("KneeAngles", 1, 1, 1),
    "knee_rotation_markers": ("KneeAngles", 2, 1, 1),
    "ankle_angle": ("AnkleAngles", 0, 1, 1),
    "ankle_dorsiflexion": ("AnkleAngles", 0, 1, 1),
    "foot_progression": ("FootProgressAngles", 2, 1, 1),
    "arm_flex": ("ShoulderAngles", 0, 1, 1),
    "arm_add": ("ShoulderAngles", 1, -1, -1),
    "arm_rot": ("ShoulderAngles", 2, 1, 1),
    "elbow_flex": ("ElbowAngles", 0, 1, 1),
}
# OpenSim's coordinates that are shown beside ours; the same names.
_OPENSIM = (
    *PELVIS[:3],
    *("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle"),
    *("subtalar_angle", "arm_flex", "arm_add", "arm_rot", "elbow_flex", "pro_sup"),
)


@dataclass(frozen=True)
class Agreement:
    """Agreement of one of our angles with a stored one.

    Attributes:
        angle: Our name of it, with its side.
        source: Whose the stored one is.
        values: Figures in the order of :data:`FIGURES`.
    """

    angle: str
    source: str
    values: tuple[float, float, float, float, float]

    def rows(self, subject: str, note: str = "", goals: bool = True) -> list[Row]:
        """Return the figures as rows, those with a goal held against it."""
        found = []
        angle = self.angle.removesuffix("_r").removesuffix("_l")
        limits = _GOALS[self.source].get(angle, (None,) * len(FIGURES))
        for (what, unit), value, limit in zip(FIGURES.items(), self.values, limits, strict=True):
            name = f"{self.angle} against {self.source}{note}, {what}"
            limit = limit if goals else None
            held = at_least if what == "r" else within
            found.append(held(subject, name, value, limit, unit))
        return found


def agreement(angle: str, source: str, ours: np.ndarray, theirs: np.ndarray) -> Agreement | None:
    """Return how two curves [deg] agree; None where the stored one is missing or hardly moves."""
    both = np.isfinite(ours) & np.isfinite(theirs)
    a, b = ours[both], theirs[both]
    if len(a) <= MIN_COMMON_FRAMES or np.ptp(b) < LEAST_MOTION:
        return None
    span = float(np.ptp(a) - np.ptp(b))
    found = compare_curves(a, b)
    error = found.rmse, found.rmse_offset_removed
    values = found.correlation, *error, span, found.mean_difference
    return Agreement(angle, source, values)


def our_angles(trial: Trial) -> Table:
    """Return coordinates and clinical angles of a trial as a user gets them, filtered [deg]."""
    record = trial.record()
    tables = [coordinates_of(record), laboratory_angles(record)]
    names = [n for t in tables for n in t.names]
    values = np.hstack([t.values for t in tables])
    return Table(tuple(names), record.motion.time, np.rad2deg(values))


def against_plug_in_gait(trial: Trial, recording: Recording) -> Iterator[Agreement]:
    """Compare all planes with the angles that Plug-in Gait stored in the file."""
    ours, markers = our_angles(trial), recording.markers
    assert markers is not None
    for angle, (output, column, *signs) in _PLUG_IN_GAIT.items():
        for side, sign in zip(SIDES, signs, strict=True):
            name = angle if angle in ours.names else f"{angle}_{side}"
            stored = recording.outputs.get(side.upper() + output)
            if stored is None or name not in ours.names or (name == angle and side == "l"):
                continue
            theirs = sign * on_clock(markers.time, stored[:, column], ours.time)
            found = agreement(name, "Plug-in Gait", ours[name], theirs)
            if found is not None:
                yield found


def against_opensim(trial: Trial, theirs: Table) -> Iterator[Agreement]:
    """Compare all planes with OpenSim's coordinates [rad] of the same trial."""
    ours, theirs = our_angles(trial), turned(theirs, trial.fit.heading)
    for angle in _OPENSIM:
        for name in (angle, *(f"{angle}_{side}" for side in SIDES)):
            if name not in ours.names or name not in theirs.names:
                continue
            a, b = shared(ours, theirs, name)
            found = agreement(name, "OpenSim", a, np.rad2deg(b))
            if found is not None:
                yield found


def turned(table: Table, heading: float) -> Table:
    """Return OpenSim's coordinates with the pelvis turned about the vertical by ``heading``."""
    from scipy.spatial.transform import Rotation

    angles = [n for n in PELVIS[:3] if n in table.names]
    if len(angles) < 3 or not heading:
        return table
    columns = [table.names.index(n) for n in angles]
    quat = pelvis_angles_to_quaternion(table.values[:, columns])
    about = Rotation.from_euler("z", heading) * Rotation.from_quat(wxyz_to_xyzw(quat))
    values = table.values.copy()
    values[:, columns] = quaternion_to_pelvis_angles(xyzw_to_wxyz(about.as_quat()))
    return Table(table.names, table.time, values)


def agreement_sheet(title: str, rows: Sequence[Row]) -> str:
    """Return the agreements among the rows as a wide table: a line per angle and trial."""
    found: dict[tuple[str, str], dict[str, float | None]] = {}
    for row in rows:
        name, figure = _divided(row.quantity)
        if figure:
            found.setdefault((row.subject, name), {})[figure] = row.value
    lines, last = [], ""
    for (subject, name), values in found.items():
        if subject != last:
            lines.append((subject, *[""] * len(FIGURES)))
            last = subject
        lines.append(
            (f"  {name}", *(text_of(values.get(f), 3 if f == "r" else 1) for f in FIGURES))
        )
    return sheet(title, ("", *FIGURES), lines)


def _divided(quantity: str) -> tuple[str, str]:
    """Return the angle and the figure of a row; no figure where the row is of another kind."""
    for figure in sorted(FIGURES, key=len, reverse=True):
        name = quantity.removesuffix(f", {figure}")
        if name != quantity and " against " in name and " moment " not in name:
            return name, figure
    return quantity, ""


def shared(a: Table, b: Table, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a column of both tables on the clock of the second, where both have it."""
    inside = (b.time >= a.time[0]) & (b.time <= a.time[-1])
    return np.interp(b.time[inside], a.time, a[column]), b[column][inside]


def on_clock(clock: np.ndarray, values: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return a signal at the samples of another clock that lie on it; NaN elsewhere."""
    index = np.rint(np.interp(times, clock, np.arange(len(clock)))).astype(int)
    return np.where(np.abs(clock[index] - times) < 1e-3, values[index], np.nan)
