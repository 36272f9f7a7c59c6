"""Every coordinate the joint sets use: its axis, its range and the strength behind it.

Axes are those of the right side in our frames (x forward, y left, z up; Rajagopal's are x
forward, y up, z right) and follow [Rajagopal2016]_ where it has the coordinate; ankle and
subtalar axes are the oblique ones of [Inman1976]_ as in that model. The left axis is the mirror
image, so a positive value means the same movement on both sides.

Ranges are physiological limits, wide enough for walking, sitting, jumping and reaching.
Strengths are peak voluntary moments of adults for a body mass of 73 kg and a stature of 1.74 m
and scale with mass times stature; each row names its source.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Coordinate:
    """One rotation of a joint.

    Attributes:
        axis: Axis of the right side in the zero pose, unit length.
        low: Lower limit [rad].
        high: Upper limit [rad].
        weakest: Largest moment in the negative sense, a negative number [N m].
        strongest: Largest moment in the positive sense [N m].
        source: Where the strength comes from.
    """

    axis: tuple[float, float, float]
    low: float
    high: float
    weakest: float
    strongest: float
    source: str

    def axis_of(self, side: str) -> np.ndarray:
        """Return the unit axis for side ``"r"``, ``"l"`` (mirrored) or ``""``."""
        a = np.array(self.axis)
        a = a / np.linalg.norm(a)
        return a * np.array([-1.0, 1.0, -1.0]) if side == "l" else a


def _c(axis, low_deg, high_deg, weakest, strongest, source) -> Coordinate:
    return Coordinate(
        axis, float(np.deg2rad(low_deg)), float(np.deg2rad(high_deg)), weakest, strongest, source
    )


_ANDERSON = "Anderson 2007"  # isometric and isokinetic maxima of hip, knee and ankle, young men
_RAJAGOPAL = "Rajagopal 2016"  # torque actuators of its arms and joints without muscles
_MCGILL = "McGill 1994"  # trunk and neck, isometric, young men
_PAPER = "Park 2020"  # foot joints: peak moments seen in walking with that foot, tripled

Y, Z, X = (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)

COORDINATES: dict[str, Coordinate] = {
    "hip_flexion": _c(Y, -40, 130, -260, 190, _ANDERSON),
    "hip_adduction": _c(X, -55, 40, -150, 150, _ANDERSON),
    "hip_rotation": _c(Z, -55, 55, -80, 90, _ANDERSON),
    "knee_angle": _c((0.0, 0.9975, -0.0707), -15, 155, -250, 130, _ANDERSON),
    "knee_adduction": _c(X, -15, 15, -120, 120, _ANDERSON),
    "knee_rotation": _c(Z, -35, 35, -60, 60, _ANDERSON),
    "ankle_angle": _c((-0.105, -0.979, -0.174), -60, 45, -220, 60, _ANDERSON),
    "subtalar_angle": _c((0.787, 0.121, 0.605), -40, 40, -60, 60, _ANDERSON),
    "ankle_rotation": _c(Z, -35, 35, -60, 60, _ANDERSON),
    "mtp_angle": _c(Y, -45, 75, -40, 40, _PAPER),
    "mtp_inversion": _c(X, -20, 20, -20, 20, _PAPER),
    "mtp_adduction": _c(Z, -20, 20, -20, 20, _PAPER),
    "mtp4_angle": _c(Y, -45, 75, -40, 40, _PAPER),
    "mtp4_inversion": _c(X, -20, 20, -20, 20, _PAPER),
    "mtp4_adduction": _c(Z, -20, 20, -20, 20, _PAPER),
    "cuboid_angle": _c(Y, -25, 25, -60, 60, _PAPER),
    "cuboid_inversion": _c(X, -25, 25, -40, 40, _PAPER),
    "cuboid_adduction": _c(Z, -20, 20, -40, 40, _PAPER),
    "heel_angle": _c(Y, -30, 30, -60, 60, _PAPER),
    "heel_inversion": _c(X, -30, 30, -40, 40, _PAPER),
    "heel_adduction": _c(Z, -25, 25, -40, 40, _PAPER),
    "lumbar_extension": _c(Y, -90, 45, -210, 400, _MCGILL),
    "lumbar_bending": _c(X, -45, 45, -250, 250, _MCGILL),
    "lumbar_rotation": _c(Z, -60, 60, -110, 110, _MCGILL),
    "lower_thorax_extension": _c(Y, -40, 30, -210, 400, _MCGILL),
    "lower_thorax_bending": _c(X, -30, 30, -250, 250, _MCGILL),
    "lower_thorax_rotation": _c(Z, -40, 40, -110, 110, _MCGILL),
    "thorax_extension": _c(Y, -40, 30, -210, 400, _MCGILL),
    "thorax_bending": _c(X, -30, 30, -250, 250, _MCGILL),
    "thorax_rotation": _c(Z, -40, 40, -110, 110, _MCGILL),
    "lower_neck_extension": _c(Y, -45, 45, -40, 60, _MCGILL),
    "lower_neck_bending": _c(X, -30, 30, -40, 40, _MCGILL),
    "lower_neck_rotation": _c(Z, -45, 45, -20, 20, _MCGILL),
    "upper_neck_extension": _c(Y, -45, 45, -40, 60, _MCGILL),
    "upper_neck_bending": _c(X, -30, 30, -40, 40, _MCGILL),
    "upper_neck_rotation": _c(Z, -45, 45, -20, 20, _MCGILL),
    "neck_extension": _c(Y, -75, 75, -40, 60, _MCGILL),
    "neck_bending": _c(X, -55, 55, -40, 40, _MCGILL),
    "neck_rotation": _c(Z, -90, 90, -20, 20, _MCGILL),
    "clavicle_elevation": _c((-1.0, 0.0, 0.0), -20, 50, -120, 120, _RAJAGOPAL),
    "clavicle_protraction": _c(Z, -40, 40, -120, 120, _RAJAGOPAL),
    "arm_flex": _c(Y, -120, 190, -110, 110, _RAJAGOPAL),
    "arm_add": _c(X, -190, 90, -110, 110, _RAJAGOPAL),
    "arm_rot": _c(Z, -160, 160, -60, 60, _RAJAGOPAL),
    "elbow_flex": _c((0.226, -0.974, 0.022), -15, 160, -60, 80, _RAJAGOPAL),
    "elbow_adduction": _c(X, -25, 25, -60, 60, _RAJAGOPAL),
    "pro_sup": _c(Z, -20, 180, -15, 15, _RAJAGOPAL),
    "wrist_flex": _c(Y, -80, 85, -10, 20, _RAJAGOPAL),
    "wrist_dev": _c(X, -35, 45, -15, 15, _RAJAGOPAL),
    "fingers_flex": _c(Y, -30, 100, -8, 15, _RAJAGOPAL),
}

REFERENCE_MASS, REFERENCE_HEIGHT = 73.0, 1.74  # of the strengths [kg, m]
