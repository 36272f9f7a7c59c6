"""Hip rotation of Plug-in Gait, and the knee axis and thigh marker that it hangs on.

Plug-in Gait takes the rotation of the thigh from one marker on it: knee axis and knee centre lie in
the plane of hip centre, that marker and lateral epicondyle. Two faults follow, each with a test.

**The axis is turned.** Flexion is then seen as adduction in part, and adduction of the knee
correlates with its flexion (cross-talk). [Baker1999]_ turns the axis until adduction varies least;
the knee centre goes round the line from hip centre to epicondyle with it. The thigh's axes stay
fixed to the same three points, so the offset of hip rotation changes and its correlation hardly.

**The marker slides round the thigh.** Where medial epicondyles were recorded too, hip centre and
epicondyles define a thigh without it. While the foot stands and the knee is almost straight, the
knee hardly turns about the shank: a shank by its malleoli, which no marker of the thigh moves,
shows which of the two turns as the bone does.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from experiments.joint_centres import CENTRES, Paths
from experiments.stored_angles import our_angles
from experiments.table import Row, at_least, at_most
from plantigrade.analyze.foot_progression import marker_path
from plantigrade.analyze.gait_forces import STANCE_LOAD
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import body_paths

STRAIGHT = 25.0  # flexion below which a knee hardly turns about its shank [deg]
MAX_TURN = 60.0  # most that an axis is turned [deg]
MAX_CROSS_TALK = 0.1  # correlation that the correction may leave [1]
LEAST_R = 0.85  # of hip rotation with that of the epicondyles [1]
MARKS = tuple(f"{joint}_{end}" for joint in ("knee", "ankle") for end in ("lateral", "medial"))

COLUMNS = {
    "cross-talk": "knee adduction and flexion of Plug-in Gait, r",
    "adduction": "its adduction, range",
    "turn": "axis turned for least adduction by",
    "talk": "then r",
    "range": "then range",
    "stored": "hip rotation of the thigh against Plug-in Gait, r",
    "stored off": "RMSE against it",
    "corrected": "against it corrected, r",
    "corrected off": "RMSE against it corrected",
    "flexion": "knee flexion, ours less theirs, mean",
    "flexion corrected": "ours less theirs corrected, mean",
    "epicondyles": "against the epicondyles, r",
    "bone stored": "in stance, Plug-in Gait against the shank, r",
    "bone epicondyles": "in stance, epicondyles against the shank, r",
    "bone ours": "in stance, ours against the shank, r",
}
"""Figure → its quantity."""

_Paths = Float[Array, "n_frames 3"]
_Curve = Float[Array, " n_frames"]


@dataclass(frozen=True)
class Thigh:
    """A thigh by hip centre, knee centre and a point on the axis, and what its joints show."""

    rotation: _Curve  #: Internal rotation of the hip [deg]
    flexion: _Curve  #: Of the knee [deg]
    adduction: _Curve  #: Of the knee [deg]

    @property
    def cross_talk(self) -> float:
        """Correlation of adduction with flexion [1]."""
        return compare_curves(self.adduction, self.flexion).correlation


@dataclass(frozen=True)
class Leg:
    """What the angles of a thigh are computed from, in frames in which all is known.

    Attributes:
        pelvis: Axes of the pelvis.
        hip: Hip centre [m].
        ankle: Ankle centre [m].
        lateral: Marker on the lateral epicondyle [m].
        side: "r" or "l".
    """

    pelvis: Float[Array, "n_frames 3 3"]
    hip: _Paths
    ankle: _Paths
    lateral: _Paths
    side: str

    @property
    def sign(self) -> int:
        """1 on the right, -1 on the left."""
        return 1 if self.side == "r" else -1

    def thigh(self, knee: _Paths) -> Thigh:
        """Return the angles of the thigh with a knee centre [m]."""
        axes = self.segment(self.hip - knee, knee - self.lateral)
        line = np.einsum("nji,nj->ni", axes, _unit(knee - self.ankle))
        flexion, across = np.arctan2(line[:, 0], line[:, 2]), np.arcsin(line[:, 1])
        return Thigh(self.rotation(axes), *np.rad2deg([flexion, -self.sign * across]))

    def segment(self, up: _Paths, inward: _Paths) -> Float[Array, "n_frames 3 3"]:
        """Return the axes of a segment by its long axis and a direction towards the midline."""
        z = _unit(up)
        x = _unit(np.cross(self.sign * inward, z))
        return np.stack([x, np.cross(z, x), z], axis=2)

    def rotation(self, axes: Float[Array, "n_frames 3 3"]) -> _Curve:
        """Return the internal rotation of a segment relative to the pelvis [deg]."""
        turn = Rotation.from_matrix(np.swapaxes(self.pelvis, 1, 2) @ axes)
        return self.sign * turn.as_euler("YXZ", degrees=True)[:, 2]

    def turned(self, knee: _Paths, angle: float) -> _Paths:
        """Return a knee centre that went by an angle [deg] round the line hip to epicondyle [m]."""
        axis = _unit(self.hip - self.lateral)
        turn = Rotation.from_rotvec(np.deg2rad(angle) * axis)
        return self.lateral + turn.apply(knee - self.lateral)

    def least_adduction(self, knee: _Paths) -> float:
        """Return the turn of the knee centre after which adduction varies least [deg]."""
        found = minimize_scalar(
            lambda angle: np.var(self.thigh(self.turned(knee, angle)).adduction),
            bounds=(-MAX_TURN, MAX_TURN),
            method="bounded",
        )
        return float(found.x)


def knee_axis_rows(name: str, trial: Trial, theirs: Paths) -> list[Row]:
    """Return cross-talk of the stored knee axis, and hip rotation held against it and corrected.

    Args:
        name: Of the recording.
        trial: Our fit of it.
        theirs: Joint centres of Plug-in Gait in the axes of the fit [m].
    """
    angles, record = our_angles(trial), trial.record()
    rows: list[Row] = []
    for side in SIDES:
        centres = [path for c in CENTRES if (path := theirs.get(f"{c}_{side}")) is not None]
        paths = [marker_path(record, f"{mark}_{side}") for mark in MARKS]
        marks = [path[0] for path in paths if path is not None]
        ours = f"hip_rotation_thigh_{side}"
        if len(centres) < len(CENTRES) or paths[0] is None or ours not in angles.names:
            continue
        seen = np.isfinite(np.concatenate([*centres, marks[0]], axis=1)).all(axis=1)
        bodies = [record.human.body(each) for each in ("pelvis", f"tibia_{side}")]
        origins, axes = body_paths(record.human, record.motion.qpos, bodies)
        hip, knee, ankle = (path[seen] for path in centres)
        leg = Leg(axes[seen, 0], hip, ankle, marks[0][seen], side)
        flexion = angles[f"knee_angle_{side}"][seen]
        figures = _against_stored(leg, knee, angles[ours][seen], flexion)
        if len(marks) == len(MARKS):
            medial, *malleoli = (path[seen] for path in marks[1:])
            shank = leg.segment(
                origins[seen, 1] - np.mean(malleoli, axis=0), malleoli[1] - malleoli[0]
            )
            stands = _stands(trial, side)[seen]
            figures |= _against_epicondyles(leg, knee, medial, shank, stands, angles[ours][seen])
        rows += [_row(f"{name} {side}", each, value) for each, value in figures.items()]
    return rows


def _against_stored(leg: Leg, knee: _Paths, ours: _Curve, flexion: _Curve) -> dict[str, float]:
    """Return the figures against the stored thigh, as it is and with the axis turned."""
    turn = leg.least_adduction(knee)
    stored, corrected = leg.thigh(knee), leg.thigh(leg.turned(knee, turn))
    first, second = (compare_curves(ours, each.rotation) for each in (stored, corrected))
    return {
        "cross-talk": stored.cross_talk,
        "adduction": float(np.ptp(stored.adduction)),
        "turn": turn,
        "talk": corrected.cross_talk,
        "range": float(np.ptp(corrected.adduction)),
        "stored": first.correlation,
        "stored off": first.rmse,
        "corrected": second.correlation,
        "corrected off": second.rmse,
        "flexion": float(np.mean(flexion - stored.flexion)),
        "flexion corrected": float(np.mean(flexion - corrected.flexion)),
    }


def _against_epicondyles(
    leg: Leg, knee: _Paths, medial: _Paths, shank: np.ndarray, stands: np.ndarray, ours: _Curve
) -> dict[str, float]:
    """Return the figures against epicondyles, and of all against the shank where it stands."""
    free = leg.thigh((leg.lateral + medial) / 2)
    straight, bone = stands & (free.flexion < STRAIGHT), leg.rotation(shank)
    curves = {"stored": leg.thigh(knee).rotation, "epicondyles": free.rotation, "ours": ours}
    found = {"epicondyles": compare_curves(ours, free.rotation).correlation}
    for each, curve in curves.items():
        found[f"bone {each}"] = compare_curves(curve[straight], bone[straight]).correlation
    return found


def _stands(trial: Trial, side: str) -> np.ndarray:
    """Return the frames in which plates bear a foot."""
    if trial.forces is None:
        return np.zeros(len(trial.fit.time), bool)
    k, weight = SIDES.index(side), trial.record().weight
    return np.asarray(trial.forces.valid_side)[:, k] & (
        trial.forces.force[:, k, 2] > STANCE_LOAD * weight
    )


def _row(subject: str, figure: str, value: float) -> Row:
    quantity = COLUMNS[figure]
    if figure == "talk":
        return at_most(subject, quantity, abs(value), MAX_CROSS_TALK)
    if figure == "epicondyles":
        return at_least(subject, quantity, value, LEAST_R)
    degrees = ("adduction", "turn", "range", "flexion", "flexion corrected")
    unit = "deg" if figure in degrees or figure.endswith("off") else ""
    return Row(subject, quantity, value, unit)


def _unit(vectors: _Paths) -> _Paths:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
