"""Warnings on markers of the pelvis that are not on its spines, by symmetry, hips and standing.

Markers keep their distances on a pelvis that is not theirs, and a body follows them to the
millimetre. What shows them is the rest of the person: the lines from right to left through the
anterior spines, the posterior ones and the knees are level over whole strides, hip centres lie
below the spines, and both are where the standing trial has them.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.joint_distances import SegmentPoses, joint_centre, segment_of_leg
from plantigrade.kinematics.posture import leans
from plantigrade.kinematics.state import PointSet, body_paths
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.motion import Markers
from plantigrade.printable import listed
from plantigrade.spatial.conventions import facing, unit_vectors

MAX_TWIST = 6.0
"""Largest mean difference of the slopes from right to left of the spines, and of the knees [deg];
sound recordings have up to 3.0, a spine that is 5 cm low 11."""
MAX_SHIFT = 0.015
"""Largest mean shift of the markers of the pelvis on the body between standing and motion [m]; six
sound trials with a standing one have up to 0.009, belts that are 5 cm low 0.018 to 0.04."""
MIN_HIP_DEPTH = 0.16
"""Smallest depth of the hip centres below the anterior spines over the width between these [1];
people who walk, run and squat have 0.24 to 0.63, regressions 0.3."""
MAX_TILT_CHANGE = 12.0
"""Largest change of the mean lean of the pelvis from standing to motion without the trunk [deg];
seven sound trials have up to 9.2, markers of the sacrum that are 5 cm low 15 to 20."""
MAX_SIDEWAYS = 2.5
"""Largest slope to one side that pelvis, legs, shoulders and trunk share [deg]; sound recordings
have up to 0.4, but a child who turns 4 and one who stands askew 14."""
MIN_RISE = 0.02  # [m] smallest height between the feet by the slope that the feet can contradict
MAX_TURN = np.deg2rad(20.0)  # [rad] largest turn of the pelvis; people lean into turns
MIN_LINES = 3  # [1] lines from right to left that must share it, beside the trunk
MIN_HIP_RANGE = np.deg2rad(20.0)
"""Smallest range of the direction from hips to knees, seen from the pelvis, that shows the hip
centres [rad]; walks have 35 to 50 degrees."""


def spine_notes(
    markers: Markers, landmarks: Mapping[str, str | None], places: Sequence[Attachment]
) -> list[str]:
    """Return a sentence where markers of the spines do not fit each other, the knees or the hips.

    Args:
        landmarks: Marker → its landmark.
    """
    named = {mark: name for name, mark in landmarks.items() if mark and name in markers.names}
    slopes = {
        what: slope
        for mark, what in _LINES.items()
        if (slope := _slope(markers, named.get(f"{mark}_r"), named.get(f"{mark}_l"))) is not None
    }
    front, others = slopes.pop(_LINES["asis"], None), list(slopes.items())
    if front is None:
        return []
    # A lateral knee marker hangs on a leg that may be bent: it counts where no other line is known.
    if others and abs(front - others[0][1]) > MAX_TWIST:
        what, slope = others[0]
        return [
            f"the line of the anterior iliac spines slopes by {front - slope:+.0f}° on average "
            f"against that of the {what} ({'left' if front > slope else 'right'} side high): "
            "one of these markers is centimetres too high or too low, or another's; pelvis, "
            "hip flexion and adduction are wrong by as much."
        ]
    return _shallow_hips(markers, named, places)


def tilt_notes(
    human: Human, qpos: Float[Array, "n_frames nq"], standing: Float[Array, "n_standing nq"]
) -> list[str]:
    """Return a sentence where the pelvis is tilted against standing and the trunk is not.

    Args:
        standing: Poses of the standing trial; none without one.
    """
    if not len(standing):
        return []
    pelvis, trunk = (
        float(leans(human, qpos, mark)[:, 0].mean() - leans(human, standing, mark)[:, 0].mean())
        for mark in ("asis_r", "c7")
    )
    if abs(pelvis) <= MAX_TILT_CHANGE or trunk * pelvis > 0.5 * pelvis**2:
        return []
    return [
        f"the pelvis leans {abs(pelvis):.0f}° further {'forward' if pelvis > 0 else 'back'} than "
        "in the standing trial, the trunk does not: markers in front of the pelvis or behind it "
        "lie higher or lower than there; hip flexion is offset by as much."
    ]


def sideways_notes(
    markers: Markers,
    landmarks: Mapping[str, str | None],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> list[str]:
    """Return a sentence where pelvis, knees, shoulders and trunk slope alike to one side.

    Args:
        landmarks: Marker → its landmark.
    """
    named = {mark: name for name, mark in landmarks.items() if mark and name in markers.names}
    lines = ("asis", "psis", "knee_lateral", "acromion")  # feet that swing are not level
    slopes = [_slope(markers, named.get(f"{mark}_r"), named.get(f"{mark}_l")) for mark in lines]
    known = [slope for slope in slopes if slope is not None]
    if len(known) < MIN_LINES:
        return []
    # Left side high is a lean to the right.
    known.append(-float(leans(human, qpos, "c7")[:, 1].mean()))
    if min(map(abs, known)) <= MAX_SIDEWAYS or len({slope > 0 for slope in known}) > 1:
        return []
    x, y = facing(qpos[:, 3:7]).T
    heading = np.unwrap(np.arctan2(y, x))
    if np.ptp(heading) > MAX_TURN or _level_feet(markers, named, float(np.median(known))):
        return []
    return [
        f"pelvis, legs, shoulders and trunk all slope by about {np.median(np.abs(known)):.0f}° to "
        f"the {'right' if known[0] > 0 else 'left'}: the vertical axis of the file is probably "
        "tilted, and estimated forces and moments with it; calibrate the laboratory anew."
    ]


# Lines from right to left, those that say most first.
_LINES = {"asis": "", "psis": "posterior ones", "knee_lateral": "knees", "knee_joint": "knees"}


def _slope(markers: Markers, right: str | None, left: str | None) -> float | None:
    """Return the mean slope from a right to a left marker [deg]; None where it is not known."""
    if right is None or left is None:
        return None
    e = markers.positions[:, markers.index(left)] - markers.positions[:, markers.index(right)]
    e = e[np.isfinite(e[:, 0])]
    if not len(e):
        return None
    rise = np.arctan2(e[:, 2], np.linalg.norm(e[:, :2], axis=1))
    return float(np.rad2deg(rise.mean()))


def _level_feet(markers: Markers, named: Mapping[str, str], slope: float) -> bool:
    """Return whether standing feet are at one height, so that a slope [deg] is no floor's."""
    feet = [named.get(f"ankle_lateral_{side}") for side in SIDES]
    if None in feet:
        return False
    right, left = (markers.positions[:, markers.index(name)] for name in feet if name)
    if any(np.nanmax(x[:, 2]) - np.nanmin(x[:, 2]) > MIN_RISE for x in (left, right)):
        return False
    low = [float(np.nanmean(x[:, 2])) for x in (left, right)]
    apart = float(np.nanmedian(np.abs((left - right)[:, 1])))  # the person faces x
    rise = np.tan(np.deg2rad(slope)) * apart
    return abs(rise) > MIN_RISE and (low[0] - low[1]) / rise < 0.5


def _shallow_hips(
    markers: Markers, named: Mapping[str, str], places: Sequence[Attachment]
) -> list[str]:
    """Return a sentence where the thighs turn about points at the height of the spines."""
    spines = [named[m] for m in _SPINES if m in named]
    spine = markers.select(spines).positions
    pelvis = SegmentPoses.of(spine, 0)
    if pelvis is None or "asis_r" not in named or "asis_l" not in named:
        return []
    middle = pelvis.seen_from_here(spine).mean(axis=0)
    at = dict(zip(spines, middle, strict=True))
    right, left = at[named["asis_r"]], at[named["asis_l"]]
    back = np.mean([at[n] for n in spines if n not in (named["asis_r"], named["asis_l"])], axis=0)
    width = float(np.linalg.norm(left - right))
    up = np.cross((right + left) / 2 - back, left - right)
    up = up / np.linalg.norm(up)
    depths = []
    for thigh in ("right thigh", "left thigh"):
        own = [i for i, p in enumerate(places) if segment_of_leg(p.body) == thigh]
        p = pelvis.seen_from_here(markers.positions[:, own])
        seen = np.isfinite(p[..., 0]).all(axis=1)
        if not own or seen.sum() < len(p) // 2:
            return []
        centre, _ = joint_centre(p[seen])
        arm = p[seen].mean(axis=1) - centre
        arm /= np.linalg.norm(arm, axis=1, keepdims=True)
        along = arm @ unit_vectors(arm.mean(axis=0))
        if 2 * np.arccos(np.clip(along, -1, 1)).max() < MIN_HIP_RANGE:
            return []
        depths.append(float(((right + left) / 2 - centre) @ up))
    depth = float(np.mean(depths))
    if depth > MIN_HIP_DEPTH * width:
        return []
    return [
        f"the thighs turn about points {1e3 * depth:.0f} mm below the markers of the anterior "
        f"iliac spines, usually {1e3 * 0.3 * width:.0f}: these markers, or all of the pelvis, are "
        "too low; thighs come out too short, and hip angles some degrees off."
    ]


_SPINES = ("asis_r", "asis_l", "psis_r", "psis_l", "sacrum")


def standing_notes(
    human: Human,
    places: Sequence[Attachment],
    names: Sequence[str],
    qpos: Float[Array, "n_frames nq"],
    samples: Float[Array, "n_frames n_markers 3"],
    standing: Bool[Array, " n_frames"],
) -> list[str]:
    """Return a sentence where the pelvis carries its markers elsewhere in a standing trial.

    Args:
        qpos: Poses of the frames used to scale it.
        samples: Positions of the markers in these frames [m]; NaN where not seen.
        standing: Frames of a standing trial.
    """
    own = [i for i, p in enumerate(places) if p.body == "pelvis"]
    if not own or not standing.any() or standing.all():
        return []
    off = samples[:, own] - PointSet.of(human, [places[i] for i in own]).path(qpos)
    axes = body_paths(human, qpos, [human.body("pelvis")])[1][:, 0]
    local = np.einsum("nji,nmj->nmi", axes, off)
    shifts = np.array(
        [_mean(local[~standing, k]) - _mean(local[standing, k]) for k in range(len(own))]
    )
    sizes = np.linalg.norm(shifts, axis=1)
    known = np.isfinite(sizes)
    if not known.any() or sizes[known].mean() <= MAX_SHIFT:
        return []
    worst = sorted(np.flatnonzero(known), key=lambda k: -sizes[k])
    return [
        f"markers of the pelvis lie up to {1e3 * sizes[worst[0]]:.0f} mm elsewhere on the body "
        f"than in the standing trial ({listed([names[own[k]] for k in worst], 4)}): a belt or "
        "a marker slipped between the two, or was put on anew; hip and pelvis angles are "
        "wrong by some degrees."
    ]


def _mean(x: Float[Array, "n 3"]) -> Float[Array, " 3"]:
    seen = x[np.isfinite(x[:, 0])]
    return seen.mean(axis=0) if len(seen) else np.full(3, np.nan)
