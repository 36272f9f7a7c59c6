r"""Whether the knee markers sit at the height of the knees' axes, on both legs.

A knee marker that is low makes a long thigh and a short shank, and lies below the point about which
the shank turns, to which its markers keep their distances
(:func:`plantigrade.kinematics.joint_distances.joint_centre`). Either alone may be of a person's
proportions or of the skin. Their mean, weighted by what each has shown of people, is the estimate.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES
from plantigrade.kinematics.joint_distances import (
    MIN_SEEN,
    SegmentPoses,
    joint_centre,
    seen_markers,
)
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion import Markers

USUAL_RATIO = -0.03
"""Natural logarithm of thigh (hip centre to knee marker) over shank (knee to ankle marker) [1].
Eight people have -0.08 to 0.14, children the lowest; 0.01 are 2 mm of the marker."""
USUAL_CENTRE = -0.021
"""Height of the point about which the shank turns above the knee marker, along the thigh [m]: mean
of seven recordings with a standard deviation of 8 mm."""
CENTRE_WEIGHT = 0.7  # [1] weight of the centre in the estimate, by the inverse variances
MIN_KNEE_RANGE = np.deg2rad(40.0)  # [rad] minimum flexion that shows the centre; walks have 60°
MAX_HEIGHT = 0.027
"""Largest mean distance of the knee markers from their usual height [m]. Settled on 18 recordings
of 8 people with -0.010 to 0.025; 20 of 12 others have -0.018 to 0.013."""


def knee_notes(
    markers: Markers,
    landmarks: Mapping[str, str],
    places: Sequence[Attachment],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> list[str]:
    """Return a sentence where both knee markers sit too low or too high.

    Args:
        markers: The markers that were fitted.
        landmarks: Landmark → marker.
        places: Attachments of the markers.
        human: The scaled person.
        qpos: The motion.
    """
    low = _lowness(markers, landmarks, places, human, qpos)
    if low is None or not abs(low) > MAX_HEIGHT:
        return []
    names = [landmarks[f"knee_lateral_{side}"] for side in SIDE_NAMES]
    way, lengths = ("low", ("long", "short")) if low > 0 else ("high", ("short", "long"))
    return [
        f"the knee markers {names[0]} and {names[1]} sit about {1e3 * abs(low):.0f} mm too {way}: "
        f"thighs are {lengths[0]} and shanks {lengths[1]}, and the shanks turn about points "
        f"{'above' if low > 0 else 'below'} the markers; knee and ankle angles are some degrees "
        "off."
    ]


def _lowness(
    markers: Markers,
    landmarks: Mapping[str, str],
    places: Sequence[Attachment],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> float | None:
    """Return how far below their usual height the knee markers sit, mean of both sides [m].

    None where a marker is missing or seldom seen, or the knees bend too little.
    """
    found = []
    for side, name in SIDE_NAMES.items():
        knee, ankle = (landmarks.get(f"{joint}_lateral_{side}") for joint in ("knee", "ankle"))
        if knee is None or ankle is None:
            return None
        x, ends = markers.positions, [markers.index(knee), markers.index(ankle)]
        if np.isfinite(x[:, ends, 0]).mean(axis=0).min() < MIN_SEEN:
            return None
        if np.ptp(qpos[:, 7 + human.hinge(f"knee_angle_{side}")]) < MIN_KNEE_RANGE:
            return None
        hip = PointSet.of(human, [attachments(human)[f"hip_joint_{side}"]]).path(qpos)
        thigh = SegmentPoses.of(
            np.concatenate([x[:, seen_markers(places, x, f"{name} thigh")], hip], 1)
        )
        shank = x[:, seen_markers(places, x, f"{name} shank")]
        if thigh is None or not shank.shape[1]:
            return None
        centre = joint_centre(thigh.seen_from_here(shank))[0]
        on_knee = x[:, ends[:1]]
        up = np.nanmean(thigh.seen_from_here(hip) - thigh.seen_from_here(on_knee), axis=0)[0]
        at = np.nanmean(thigh.seen_from_here(on_knee), axis=0)[0]
        above = float((centre - at) @ up / np.linalg.norm(up))
        lengths = [
            float(np.nanmean(np.linalg.norm(end - on_knee[:, 0], axis=1)))
            for end in (hip[:, 0], x[:, ends[1]])
        ]
        ratio = 0.5 * np.mean(lengths) * (np.log(lengths[0] / lengths[1]) - USUAL_RATIO)
        found.append(CENTRE_WEIGHT * (above - USUAL_CENTRE) + (1 - CENTRE_WEIGHT) * ratio)
    return float(np.mean(found))
