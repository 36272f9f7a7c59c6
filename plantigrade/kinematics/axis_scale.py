r"""Whether the vertical of a recording has the scale of its horizontal axes.

Markers on one segment keep their distance while it turns. Where heights are multiplied by
:math:`s`, what is constant is :math:`h^2 + z^2 / s^2`, with the horizontal distance :math:`h` and
the recorded vertical one :math:`z` of two markers: their squares fall on a line of slope
:math:`-1 / s^2`, whatever the distance.
"""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.leg_segments import segment_of_leg
from plantigrade.models.landmarks import Attachment

MAX_SCALE_ERROR = 0.07
"""Largest deviation of the vertical scale from 1; sound recordings of walking, running, squats and
jumps have up to 0.03, from skin that moves with the joints."""
MIN_TURN = 0.08
"""Smallest standard deviation of the squared vertical distance over the squared distance [1]; that
of a thigh in walking is about 0.1, of a shank 0.2."""
MIN_PAIRS = 6  # [1] number of pairs of markers that turn enough
MIN_FRAMES = 30  # [1] number of frames with both


def scale_notes(
    places: Sequence[Attachment], samples: Float[Array, "n_frames n_markers 3"]
) -> list[str]:
    """Return a sentence where lengths of thighs and shanks change with their inclination.

    Args:
        samples: Positions of the markers [m]; NaN where not seen.
    """
    scale = vertical_scale(places, samples)
    if scale is None or abs(scale - 1) <= MAX_SCALE_ERROR:
        return []
    return [
        f"heights are {scale:.2f} times what they should be beside the horizontal distances: "
        "thighs and shanks change their lengths as they lean; the unit or the calibration "
        "of one axis is wrong, and so are lengths, mass and angles."
    ]


def vertical_scale(
    places: Sequence[Attachment], samples: Float[Array, "n_frames n_markers 3"]
) -> float | None:
    """Return the scale of the vertical to that of the horizontal axes; None where unknown [1]."""
    segments = [segment_of_leg(p.body) for p in places]
    found = []
    for i, j in zip(*np.triu_indices(len(places), 1), strict=True):
        if segments[i] != segments[j] or not segments[i].endswith(("thigh", "shank")):
            continue
        apart = samples[:, i] - samples[:, j]
        apart = apart[np.isfinite(apart[:, 0])]
        h2, z2 = (apart[:, :2] ** 2).sum(axis=1), apart[:, 2] ** 2
        if len(apart) < MIN_FRAMES or z2.std() < MIN_TURN * (h2 + z2).mean():
            continue
        slope = -float(np.cov(h2, z2)[0, 1] / z2.var(ddof=1))
        found.append(slope)
    if len(found) < MIN_PAIRS or (middle := float(np.median(found))) <= 0:
        return None
    return middle**-0.5
