"""Coordinates of the joint sets: axis, range and strength.

Axes are those of the right side in our frames (x forward, y left, z up; Rajagopal's are x
forward, y up, z right) and follow [Rajagopal2016]_ where it has the coordinate; ankle and
subtalar axes are the oblique ones of [Inman1976]_ as in that model, and here all of them pass
through the ankle joint centre. The left axis is the mirror image, so a positive value means the
same movement on both sides.

Ranges are the possible range of a joint rather than its usual one, so that skin motion and errors
of joint centres do not drive a fit into a limit. Each row states the range it was widened from.

Strengths refer to a body mass of 73 kg and a stature of 1.74 m and scale with mass times stature,
as [Anderson2007]_ normalises them. They are those of strong people: the mean plus two standard
deviations (SD) where a study gives both. A moment beyond the limit is therefore impossible for a
person of that size. Sources other than [Anderson2007]_ are [Fice2014]_ (neck), [Goldmann2012]_
(toes), and [Jackson2010]_ and [Kentel2011]_ (arms) as tabulated in the muscle addon of RBDL
[Felis2017]_; ranges are from [Rajagopal2016]_ and [AAOS1965]_. An *estimate* rests on the stated
reasoning, without measurement.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Coordinate:
    """A rotational coordinate of a joint."""

    axis: tuple[float, float, float]  #: Axis of the right side in the zero pose, unit length
    low: float  #: Lower limit [rad]
    high: float  #: Upper limit [rad]
    range_source: str  #: Source of the limits
    weakest: float  #: Largest moment in the negative sense, a negative number [N m]
    strongest: float  #: Largest moment in the positive sense [N m]
    strength_source: str  #: Source of the moments

    def axis_of(self, side: str) -> np.ndarray:
        """Return the unit axis for side ``"r"``, ``"l"`` (mirrored) or ``""``."""
        a = np.array(self.axis)
        a = a / np.linalg.norm(a)
        return a * np.array([-1.0, 1.0, -1.0]) if side == "l" else a


def _c(axis, limits_deg, range_source, moments, strength_source) -> Coordinate:
    low, high = (float(v) for v in np.deg2rad(limits_deg))
    weakest, strongest = (float(v) for v in moments)
    return Coordinate(axis, low, high, range_source, weakest, strongest, strength_source)


# Sources of the ranges.
_MODEL = "Rajagopal 2016 (its .osim), widened by 5 to 15 deg"
_CLINIC = "AAOS 1965, widened by 5 to 30 deg"
_ARM = (
    "AAOS 1965, widened by up to 15 deg: elbow 150 and 10 beyond straight, forearm 80 each way "
    "from the thumb in front (90 from palms forward), wrist 80, 70, 30 and 20"
)
_CHAIN = "estimate: three rotations in series must reach every posture, which needs wider ranges"
_LAXITY = "estimate: passive play of the joint and the error of a one-axis knee, ankle or elbow"
_GIRDLE_PLAY = "estimate: textbook 45 deg up, 5 deg down, 15 to 30 deg to and fro, widened"
_SHARE = "estimate: a share of AAOS 1965's range for the whole trunk or neck"
_FOOT_PLAY = "estimate: no measurement exists for these lumped joints; wide enough for bare ground"

# Sources of the strengths.
_ANDERSON = "Anderson 2007, table 3, men of 18 to 25 years, isometric, mean + 2 SD"
_LENGTHENING = (
    "Anderson 2007, table 3, men of 18 to 25 years, mean + 2 SD; plantarflexion a quarter more "
    "(estimate), since in running its largest moment is that of a lengthening muscle"
)
_HIP_SIDE = "estimate: twice the 1 N m/kg of the abductors in one-legged stance and walking"
_HIP_TURN = "estimate: 1.1 to 1.2 N m/kg, below half the sagittal strength"
_SUBTALAR = "estimate: nearly twice the moment of body weight on the edge of the foot"
_LIGAMENTS = "estimate: carried by ligaments and bone, high enough for walking and landing"
_TOES = (
    "Goldmann 2012, toe flexors of men, mean + 2 SD is 26 N m; the rest (estimate) is passive "
    "tissue of bent toes"
)
_SOLE = "estimate: holds 1.5 body weights pressed on one end of the segment, with a margin"
_TRUNK = (
    "flexion 212 N m as tabled in RBDL's torque muscles; extension (estimate) twice that, bending "
    "and rotation (estimates) 3.4 and 1.5 N m/kg"
)
_NECK = "Fice 2014, isometric, men, mean + 2 SD"
_SHOULDER = "Jackson 2010 and Kentel 2011, athletes, as tabled in RBDL's torque muscles"
_GIRDLE = "estimate: transmits the moments of the shoulder"
_GRIP = "estimate: a 150 N pull at 0.1 m; opening half of that"

Y, Z, X = (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)

_BACK = (-210, 420), (-250, 250), (-110, 110)  # extension, bending, rotation [N m]
_HEAD = (-42, 73), (-50, 50), (-23, 23)

COORDINATES: dict[str, Coordinate] = {
    "hip_flexion": _c(Y, (-40, 130), _MODEL, (-323, 203), _ANDERSON),
    "hip_adduction": _c(X, (-55, 40), _MODEL, (-150, 150), _HIP_SIDE),
    "hip_rotation": _c(Z, (-55, 55), _MODEL, (-80, 90), _HIP_TURN),
    "knee_angle": _c((0.0, 0.9975, -0.0707), (-15, 155), _MODEL, (-303, 146), _ANDERSON),
    "knee_adduction": _c(X, (-15, 15), _LAXITY, (-120, 120), _LIGAMENTS),
    "knee_rotation": _c(Z, (-35, 35), _LAXITY, (-60, 60), _LIGAMENTS),
    "ankle_angle": _c((-0.105, -0.979, -0.174), (-60, 55), _MODEL, (-216, 54), _LENGTHENING),
    "subtalar_angle": _c((0.787, 0.121, 0.605), (-40, 40), _MODEL, (-60, 60), _SUBTALAR),
    "ankle_rotation": _c(Z, (-35, 35), _LAXITY, (-60, 60), _LIGAMENTS),
    "mtp_angle": _c(Y, (-50, 75), _CLINIC, (-40, 20), _TOES),
    "mtp_inversion": _c(X, (-20, 20), _FOOT_PLAY, (-20, 20), _SOLE),
    "mtp_adduction": _c(Z, (-20, 20), _FOOT_PLAY, (-20, 20), _SOLE),
    "mtp4_angle": _c(Y, (-50, 75), _CLINIC, (-40, 20), _TOES),
    "mtp4_inversion": _c(X, (-20, 20), _FOOT_PLAY, (-20, 20), _SOLE),
    "mtp4_adduction": _c(Z, (-20, 20), _FOOT_PLAY, (-20, 20), _SOLE),
    "cuboid_angle": _c(Y, (-25, 25), _FOOT_PLAY, (-60, 60), _SOLE),
    "cuboid_inversion": _c(X, (-25, 25), _FOOT_PLAY, (-40, 40), _SOLE),
    "cuboid_adduction": _c(Z, (-20, 20), _FOOT_PLAY, (-40, 40), _SOLE),
    "heel_angle": _c(Y, (-30, 30), _FOOT_PLAY, (-60, 60), _SOLE),
    "heel_inversion": _c(X, (-30, 30), _FOOT_PLAY, (-40, 40), _SOLE),
    "heel_adduction": _c(Z, (-25, 25), _FOOT_PLAY, (-40, 40), _SOLE),
    "lumbar_extension": _c(Y, (-90, 45), _CLINIC, _BACK[0], _TRUNK),
    "lumbar_bending": _c(X, (-45, 45), _CLINIC, _BACK[1], _TRUNK),
    "lumbar_rotation": _c(Z, (-60, 60), _CLINIC, _BACK[2], _TRUNK),
    "lower_thorax_extension": _c(Y, (-40, 30), _SHARE, _BACK[0], _TRUNK),
    "lower_thorax_bending": _c(X, (-30, 30), _SHARE, _BACK[1], _TRUNK),
    "lower_thorax_rotation": _c(Z, (-40, 40), _SHARE, _BACK[2], _TRUNK),
    "thorax_extension": _c(Y, (-40, 30), _SHARE, _BACK[0], _TRUNK),
    "thorax_bending": _c(X, (-30, 30), _SHARE, _BACK[1], _TRUNK),
    "thorax_rotation": _c(Z, (-40, 40), _SHARE, _BACK[2], _TRUNK),
    "lower_neck_extension": _c(Y, (-45, 45), _SHARE, _HEAD[0], _NECK),
    "lower_neck_bending": _c(X, (-30, 30), _SHARE, _HEAD[1], _NECK),
    "lower_neck_rotation": _c(Z, (-45, 45), _SHARE, _HEAD[2], _NECK),
    "upper_neck_extension": _c(Y, (-45, 45), _SHARE, _HEAD[0], _NECK),
    "upper_neck_bending": _c(X, (-30, 30), _SHARE, _HEAD[1], _NECK),
    "upper_neck_rotation": _c(Z, (-45, 45), _SHARE, _HEAD[2], _NECK),
    "neck_extension": _c(Y, (-75, 75), _CLINIC, _HEAD[0], _NECK),
    "neck_bending": _c(X, (-55, 55), _CLINIC, _HEAD[1], _NECK),
    "neck_rotation": _c(Z, (-90, 90), _CLINIC, _HEAD[2], _NECK),
    "clavicle_elevation": _c((-1.0, 0.0, 0.0), (-20, 50), _GIRDLE_PLAY, (-120, 120), _GIRDLE),
    "clavicle_protraction": _c(Z, (-40, 40), _GIRDLE_PLAY, (-120, 120), _GIRDLE),
    "arm_flex": _c(Y, (-120, 190), _CHAIN, (-127, 91), _SHOULDER),
    "arm_add": _c(X, (-190, 90), _CHAIN, (-95, 128), _SHOULDER),
    "arm_rot": _c(Z, (-160, 160), _CHAIN, (-44, 51), _SHOULDER),
    "elbow_flex": _c((0.226, -0.974, 0.022), (-10, 155), _ARM, (-70, 101), _SHOULDER),
    "elbow_adduction": _c(X, (-25, 25), _LAXITY, (-60, 60), _LIGAMENTS),
    "pro_sup": _c(Z, (-5, 180), _ARM, (-14, 13), _SHOULDER),
    "wrist_flex": _c(Y, (-75, 85), _ARM, (-16, 39), _SHOULDER),
    "wrist_dev": _c(X, (-25, 35), _ARM, (-24, 31), _SHOULDER),
    "fingers_flex": _c(Y, (-50, 100), _CLINIC, (-8, 15), _GRIP),
}

REFERENCE_MASS = 73.0  # [kg] body mass of the tabulated strengths
REFERENCE_HEIGHT = 1.74  # [m] stature of the tabulated strengths
