"""What is known of a posture before any keypoint of a video is seen.

Keypoints are joint centres. They leave two things open: the tilt of the pelvis, of which only the
line through the hips is seen, and the turn of a straight leg or arm about itself. And they are
noisy: one centimetre of noise turns a foot by several degrees. The prior is the usual posture of
people, weighed against the noise of the file.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.keypoints import BonesOfVideo
from plantigrade.models import Human
from plantigrade.side_names import split_side

# [rad] usual angle and its standard deviation, by coordinate without its side. Angles are those of
# standing and, of the forearm, of hanging arms; the lumbar extension of three people who walk is 2°
# on the mean. Deviations are chosen about the size of the motion within a walk (hip rotation 3° to
# 7°), not the difference between people: with that of the lumbar joint, above 10°, the pelvis would
# follow the noise. Those of ankle and toes gave the smallest ankle errors of three people as video.
USUAL_ANGLES = {
    "lumbar_extension": (0.0, 0.05),
    "hip_rotation": (0.0, 0.09),
    "hip_adduction": (0.0, 0.15),
    "ankle_angle": (0.0, 0.2),
    "subtalar_angle": (0.0, 0.08),
    "mtp_angle": (0.1, 0.4),
    "pro_sup": (1.4, 0.3),
    "wrist_flex": (0.0, 0.2),
    "wrist_dev": (0.0, 0.1),
}


@dataclass(frozen=True)
class PosturePrior:
    """Usual posture, its spread, and the noise of the keypoints against which it is weighed."""

    rest: Float[Array, " n_hinges"]  #: Usual angle of each hinge [rad]
    spread: Float[Array, " n_hinges"]  #: Its standard deviation [rad]; infinite without a prior
    noise: float  #: Standard deviation of a keypoint in each direction [m]
    lengths: Mapping[str, float]  #: Lengths of bones that the video shows [m]

    @classmethod
    def of(cls, human: Human, video: BonesOfVideo) -> "PosturePrior":
        """Return the prior of a person."""
        rest = human.standing()[7:].copy()
        spread = np.full(len(rest), np.inf)
        for i, name in enumerate(human.coordinates):
            plain, _ = split_side(name)
            if plain in USUAL_ANGLES:
                rest[i], spread[i] = USUAL_ANGLES[plain]
        return cls(rest, spread, video.noise, video.lengths)

    def set_on(self, solver: InverseKinematics) -> None:
        """Let inverse kinematics weigh its points against this prior."""
        solver.rest = self.rest
        solver.posture = np.maximum(solver.posture, (self.noise / self.spread) ** 2)
