r"""Noise of keypoints, from lengths that should be constant.

The distance between the centres of two neighbouring joints is that of a bone. Its variance over a
recording is the sum of the variances of both centres along the bone, and neither motion nor a
constant offset of a centre adds to it:

.. math:: \operatorname{var} |x_a - x_b| = \sigma_a^2 + \sigma_b^2 .
"""

import numpy as np

from plantigrade.models.keypoints import KEYPOINTS
from plantigrade.motion import Markers

BONES = (("hip_joint", "knee_joint"), ("knee_joint", "ankle_joint"))
BONES += (("shoulder_joint", "elbow_joint"), ("elbow_joint", "wrist_joint"))
MIN_FRAMES = 10  # [1] minimum number of frames that show both ends of a bone
USUAL_NOISE = 0.010  # [m] where no bone is seen for long enough


def keypoint_noise(markers: Markers) -> float:
    """Return the standard deviation of a keypoint in each direction [m]."""
    at = {
        KEYPOINTS[n]: markers.positions[:, i] for i, n in enumerate(markers.names) if n in KEYPOINTS
    }
    variances = []
    for side in "rl":
        for ends in BONES:
            a, b = (at.get(f"{end}_{side}") for end in ends)
            if a is None or b is None:
                continue
            length = np.linalg.norm(a - b, axis=1)
            length = length[np.isfinite(length)]
            if len(length) >= MIN_FRAMES:
                spread = 1.4826 * np.median(np.abs(length - np.median(length)))
                variances.append(spread**2 / 2)
    return float(np.sqrt(np.median(variances))) if variances else USUAL_NOISE
