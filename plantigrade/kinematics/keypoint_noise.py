r"""Noise of keypoints, from lengths that should be constant.

The distance between the centres of two neighbouring joints is that of a bone. Its variance over a
recording is the sum of the variances of both centres along the bone, and neither motion nor a
constant offset of a centre adds to it:

.. math:: \operatorname{var} |x_a - x_b| = \sigma_a^2 + \sigma_b^2 .
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.models.keypoints import KEYPOINTS
from plantigrade.motion import Markers

# Ends of a bone → its length among those of the body
BONES = {
    ("hip_joint", "knee_joint"): "thigh",
    ("knee_joint", "ankle_joint"): "shank",
    ("shoulder_joint", "elbow_joint"): "upper_arm",
    ("elbow_joint", "wrist_joint"): "forearm",
}
PER_DEVIATION = 1.4826  # [1] standard deviation over median absolute deviation, normal noise
MIN_FRAMES = 10  # [1] minimum number of frames that show both ends of a bone
USUAL_NOISE = 0.010  # [m] where no bone is seen for long enough


@dataclass(frozen=True)
class BonesOfVideo:
    """What the keypoints of a video tell of bones."""

    noise: float  #: Standard deviation of a keypoint in each direction [m]
    lengths: Mapping[str, float]  #: Median lengths, by name of the dimension [m]


def bones_of_video(markers: Markers) -> BonesOfVideo:
    """Return noise and lengths of bones of the keypoints of a video."""
    columns = {KEYPOINTS.get(name): i for i, name in enumerate(markers.names)}
    at = {mark: markers.positions[:, i] for mark, i in columns.items()}
    variances, found = [], {}
    for side in "rl":
        for ends, dimension in BONES.items():
            a, b = (at.get(f"{end}_{side}") for end in ends)
            if a is None or b is None:
                continue
            length = np.linalg.norm(a - b, axis=1)
            length = length[np.isfinite(length)]
            if len(length) >= MIN_FRAMES:
                spread = PER_DEVIATION * np.median(np.abs(length - np.median(length)))
                variances.append(spread**2 / 2)
                found.setdefault(dimension, []).append(float(np.median(length)))
    noise = float(np.sqrt(np.median(variances))) if variances else USUAL_NOISE
    return BonesOfVideo(noise, {name: float(np.mean(each)) for name, each in found.items()})
