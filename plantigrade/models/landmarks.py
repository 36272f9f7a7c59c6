"""Landmarks of the body for markers, from its lengths.

A landmark is given in the frame of a reference part in the zero pose and attached to the first
of its parts that moves on this body (a toe marker belongs to the toes of a foot with toes).
Positions are those of the marker's centre on the skin of an average adult, from [Rajagopal2016]_'s
marker set and the foot table of this package. They are initial values, refined for every person by
the fit within the stated spread.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.models.anatomy import SPINE_RISE, hip, shoulder
from plantigrade.models.anthropometry import Dimensions
from plantigrade.models.feet import point
from plantigrade.models.human import Human
from plantigrade.models.parts import MIRROR
from plantigrade.models.skeleton import build

# Standard deviation of a marker position about its landmark.
BONE_SPREAD = 0.012  # [m] on bone
SKIN_SPREAD = 0.025  # [m] on skin near bone
VERTEBRA_SPREAD = 0.04  # [m] on a vertebra, whose level is uncertain
LOOSE_SPREAD = 0.06  # [m] on soft tissue, placed by eye
# [m] a computed joint centre; functional methods and regressions find those of hip, knee and ankle
# to some millimetres [Harrington2007]_
JOINT_CENTRE_SPREAD = 0.005
# [m] distance of a marker's centre from the bone: radius, base and skin. It matters at the pelvis,
# where the hip joint centres are a regression on bony landmarks.
MARKER_OFFSET = 0.012


@dataclass(frozen=True)
class Landmark:
    """Position of a landmark and its uncertainty."""

    reference: str  #: Part in whose frame ``position`` is given, without side
    position: np.ndarray  #: Position for the right side, zero pose [m]
    parts: tuple[str, ...]  #: Parts it may move with, most distal first, without side
    spread: float  #: Standard deviation of the marker position about it [m]


@dataclass(frozen=True)
class Attachment:
    """A point fixed to a body."""

    body: str  #: Body name
    position: np.ndarray  #: In the body's frame [m]
    spread: float  #: Standard deviation of the marker position about it [m]


_PELVIS = ("pelvis",)
_BACK = ("abdomen",)
_THORAX = ("thorax", "lower_thorax", "abdomen")
_LOW_THORAX = ("lower_thorax", "abdomen")
_HEAD = ("head", "upper_neck", "lower_neck")
_THIGH, _SHANK = ("femur",), ("tibia",)
_UPPER_ARM, _FOREARM, _HAND = ("humerus",), ("radius", "ulna"), ("hand", "radius", "ulna")
_HIND = ("foot",)
_HEEL = ("heel", "foot")
_MEDIAL_TOES = ("medial_phalanges", "toes", "foot")
_LATERAL_TOES = ("lateral_phalanges", "toes", "foot")
_LATERAL_FOOT = ("lateral_metatarsal", "foot")


def _midline(d: Dimensions) -> dict[str, Landmark]:
    def pelvis(x, z, spread=BONE_SPREAD):
        place = np.array([x * d.pelvis_depth - MARKER_OFFSET, 0, z * d.pelvis_depth])
        return Landmark("pelvis", place, _PELVIS, spread)

    def trunk(x, z, parts, spread=SKIN_SPREAD):
        return Landmark("abdomen", np.array([x * d.trunk, 0, z * d.trunk]), parts, spread)

    return {
        "sacrum": pelvis(-1.0, SPINE_RISE),  # the middle of the posterior spines
        # means of both sides, as some detectors of keypoints compute them
        "hip_middle": Landmark("pelvis", hip(d) * [1, 0, 1], _PELVIS, BONE_SPREAD),
        "shoulder_middle": Landmark("abdomen", shoulder(d) * [1, 0, 1], _THORAX, BONE_SPREAD),
        "pubis": pelvis(-0.02, -0.45, SKIN_SPREAD),
        "l5": trunk(-0.24, -0.17, _BACK, VERTEBRA_SPREAD),
        "l3": trunk(-0.24, 0.02, _BACK, VERTEBRA_SPREAD),
        "t12": trunk(-0.26, 0.27, _BACK, VERTEBRA_SPREAD),
        "t10": trunk(-0.31, 0.42, _LOW_THORAX, VERTEBRA_SPREAD),
        "t8": trunk(-0.315, 0.57, _LOW_THORAX, VERTEBRA_SPREAD),
        "t6": trunk(-0.30, 0.73, _LOW_THORAX, VERTEBRA_SPREAD),
        "t4": trunk(-0.27, 0.87, _THORAX, VERTEBRA_SPREAD),
        "t2": trunk(-0.22, 0.99, _THORAX, VERTEBRA_SPREAD),
        "c7": trunk(-0.14, 1.08, _THORAX, BONE_SPREAD),
        "suprasternale": trunk(0.19, 0.885, _THORAX, BONE_SPREAD),
        "sternum": trunk(0.26, 0.66, _THORAX),
        "xiphoid": trunk(0.30, 0.45, _LOW_THORAX, VERTEBRA_SPREAD),
        "vertex": Landmark("lower_neck", np.array([0.17, 0, 1.02]) * d.head, _HEAD, SKIN_SPREAD),
        "forehead": Landmark("lower_neck", np.array([0.53, 0, 0.78]) * d.head, _HEAD, SKIN_SPREAD),
        "nose": Landmark("lower_neck", np.array([0.62, 0, 0.47]) * d.head, _HEAD, SKIN_SPREAD),
        "occiput": Landmark("lower_neck", np.array([-0.16, 0, 0.72]) * d.head, _HEAD, SKIN_SPREAD),
    }


def _right(d: Dimensions) -> dict[str, Landmark]:
    return _pelvis(d) | _leg(d) | _foot(d) | _trunk(d) | _arm(d) | _head(d)


def _pelvis(d: Dimensions) -> dict[str, Landmark]:
    half, depth = 0.5 * d.pelvis_width, d.pelvis_depth

    def pelvis(x, y, z, spread=BONE_SPREAD):
        off = MARKER_OFFSET if x >= 0 else -MARKER_OFFSET
        place = np.array([x * depth + off, -y * half, z * depth])
        return Landmark("pelvis", place, _PELVIS, spread)

    return {
        "asis": pelvis(0.0, 1.0, 0.0),
        "psis": pelvis(-1.0, 0.38, SPINE_RISE),
        # on a belt at the height of the spines, further out by its thickness; placed by eye
        "waist_front": pelvis(0.03, 1.0, 0.0, SKIN_SPREAD),
        "waist_back": pelvis(-1.03, 0.42, SPINE_RISE, SKIN_SPREAD),
        "iliac_crest": pelvis(-0.30, 1.24, 0.35, SKIN_SPREAD),
        "hip_joint": Landmark("pelvis", hip(d), _PELVIS, JOINT_CENTRE_SPREAD),
    }


def _limb(reference, parts, length, usual):
    """Return a factory of limb landmarks: forward, lateral, down, in limb lengths."""

    def place(x, y, z, spread=usual, parts=parts):
        return Landmark(reference, np.array([x, -y, -z]) * length, parts, spread)

    return place


def _leg(d: Dimensions) -> dict[str, Landmark]:
    thigh = _limb("femur", _THIGH, d.thigh, LOOSE_SPREAD)
    shank = _limb("tibia", _SHANK, d.shank, LOOSE_SPREAD)
    knee_half = 0.125 * d.thigh
    ankle_half = 0.082 * d.shank
    return {
        "trochanter": Landmark(
            "femur", np.array([-0.02 * d.thigh, -0.20 * d.thigh, 0]), _THIGH, SKIN_SPREAD
        ),
        "thigh_upper": thigh(0.10, 0.20, 0.35),
        "thigh_front": thigh(0.22, 0.04, 0.55),
        "thigh_rear": thigh(-0.06, 0.22, 0.60),
        "thigh": thigh(0.03, 0.22, 0.62),
        "knee_lateral": thigh(-0.01, knee_half / d.thigh, 0.985, BONE_SPREAD),
        "knee_medial": thigh(-0.01, -knee_half / d.thigh, 0.985, BONE_SPREAD),
        "patella": thigh(0.13, 0.0, 0.97, SKIN_SPREAD),
        "knee_joint": thigh(-0.011, -0.0043, 1.0, JOINT_CENTRE_SPREAD),
        # insertion of the biceps femoris in Rajagopal's model
        "fibula_head": shank(-0.05, 0.125, 0.105, SKIN_SPREAD),
        "tibial_tuberosity": shank(0.10, 0.01, 0.13, SKIN_SPREAD),
        "shank_upper": shank(0.02, 0.13, 0.25),
        "shank_front": shank(0.07, 0.03, 0.50, SKIN_SPREAD),
        "shank_rear": shank(-0.15, 0.10, 0.35),
        "shank": shank(-0.01, 0.12, 0.50),
        "ankle_lateral": shank(-0.035, ankle_half / d.shank, 0.975, BONE_SPREAD),
        "ankle_medial": shank(-0.005, -ankle_half / d.shank, 0.955, BONE_SPREAD),
        "ankle_joint": shank(-0.025, 0.0, 1.0, JOINT_CENTRE_SPREAD),
    }


def _foot(d: Dimensions) -> dict[str, Landmark]:
    lift = 0.35 * d.ankle_height

    def foot(name, parts, *, dx=0.0, dy=0.0, up=lift, spread=BONE_SPREAD):
        """Return a foot-table point at height ``up``, shifted by dx and dy (lateral)."""
        p = point(name, d) * MIRROR + np.array([dx * d.foot_length, -dy * d.foot_width, 0])
        p[2] = up - d.ankle_height
        return Landmark("foot", p, parts, spread)

    return {
        "heel": foot("heel_back_lateral", _HEEL, dx=-0.055, dy=-0.16, up=0.55 * d.ankle_height),
        "heel_upper": foot(
            "heel_back_lateral",
            _HEEL,
            dx=-0.055,
            dy=-0.16,
            up=0.75 * d.ankle_height,
            spread=SKIN_SPREAD,
        ),
        "heel_wand": foot(
            "heel_back_lateral",
            _HEEL,
            dx=-0.12,
            dy=-0.16,
            up=0.6 * d.ankle_height,
            spread=LOOSE_SPREAD,
        ),
        "heel_lateral": foot("heel_front_lateral", _HEEL, dx=-0.02, dy=0.12),
        "heel_medial": foot("heel_front_medial", _HEEL, dx=-0.02, dy=-0.12),
        "sustentaculum": foot(
            "heel_front_medial", _HEEL, dx=0.02, dy=-0.12, up=0.6 * d.ankle_height
        ),
        "navicular": foot(
            "base_1", _HIND, dx=-0.05, dy=-0.15, up=0.7 * d.ankle_height, spread=SKIN_SPREAD
        ),
        "midfoot": foot("base_3", _HIND, up=1.15 * d.ankle_height, spread=SKIN_SPREAD),
        "midfoot_lateral": foot("base_5", _LATERAL_FOOT, dy=0.1, spread=SKIN_SPREAD),
        "metatarsal_1_base": foot(
            "base_1", _HIND, dy=-0.05, up=0.95 * d.ankle_height, spread=SKIN_SPREAD
        ),
        "metatarsal_1_head": foot(
            "metatarsal_1", _HIND, dx=-0.02, dy=-0.10, up=0.5 * d.ankle_height
        ),
        "metatarsal_2_head": foot("metatarsal_2", _HIND, dx=-0.02, up=0.7 * d.ankle_height),
        "metatarsal_5_base": foot("base_5", _LATERAL_FOOT, dy=0.12),
        "metatarsal_5_head": foot("metatarsal_5", _LATERAL_FOOT, dx=-0.02, dy=0.10),
        "hallux": foot("toe_1", _MEDIAL_TOES, dx=-0.02, up=0.5 * d.ankle_height),
        "toe_tip": foot("toe_2", _MEDIAL_TOES, dx=0.03, up=0.4 * d.ankle_height),
        "toe_medial": foot("metatarsal_1", _MEDIAL_TOES, dx=0.03, dy=-0.06, spread=SKIN_SPREAD),
        "toe_lateral": foot("metatarsal_5", _LATERAL_TOES, dx=0.03, dy=0.06, spread=SKIN_SPREAD),
        "toe_5": foot("toe_5", _LATERAL_TOES, dx=-0.02, spread=SKIN_SPREAD),
    }


def _trunk(d: Dimensions) -> dict[str, Landmark]:
    s = shoulder(d)
    return {
        "acromion": Landmark(
            "abdomen", s + np.array([-0.03, 0.03, 0.155]) * d.trunk, _SHOULDER, SKIN_SPREAD
        ),
        "clavicle": Landmark(
            "abdomen", np.array([0.18, -0.075, 0.90]) * d.trunk, _THORAX, SKIN_SPREAD
        ),
        "scapula": Landmark(
            "abdomen", np.array([-0.31, -0.24, 0.80]) * d.trunk, _THORAX, LOOSE_SPREAD
        ),
        "shoulder_joint": Landmark("abdomen", s, _SHOULDER, BONE_SPREAD),
    }


def _arm(d: Dimensions) -> dict[str, Landmark]:
    upper_arm = _limb("humerus", _UPPER_ARM, d.upper_arm, LOOSE_SPREAD)
    forearm = _limb("ulna", _FOREARM, d.forearm, SKIN_SPREAD)
    hand = _limb("hand", _HAND, d.hand, SKIN_SPREAD)
    return {
        "upper_arm": upper_arm(0.05, 0.15, 0.60),
        "elbow_lateral": upper_arm(0.0, 0.12, 0.98, BONE_SPREAD),
        "elbow_medial": upper_arm(0.0, -0.16, 0.98, BONE_SPREAD),
        "elbow_joint": upper_arm(0.0, -0.03, 1.0, BONE_SPREAD),
        "elbow_rear": upper_arm(-0.16, 0.0, 1.0, SKIN_SPREAD),
        "forearm": forearm(0.0, 0.15, 0.50, LOOSE_SPREAD),
        "wrist_radial": forearm(0.0, 0.13, 0.98, BONE_SPREAD),
        "wrist_ulnar": forearm(0.0, -0.13, 0.98, BONE_SPREAD),
        "wrist": forearm(-0.11, 0.0, 0.98),
        "wrist_joint": forearm(0.0, 0.0, 1.0, BONE_SPREAD),
        "hand": hand(-0.10, 0.0, 0.44),
        "hand_radial": hand(-0.06, 0.18, 0.44),
        "hand_ulnar": hand(-0.06, -0.18, 0.42),
        "finger_tip": hand(0.0, 0.0, 1.0, parts=("fingers", *_HAND)),
    }


def _head(d: Dimensions) -> dict[str, Landmark]:
    def head(x, y, z, spread=SKIN_SPREAD):
        return Landmark("lower_neck", np.array([x, -y, z]) * d.head, _HEAD, spread)

    return {
        "head_front": head(0.44, 0.24, 0.64),
        "head_back": head(-0.10, 0.22, 0.64),
        "temple": head(0.32, 0.29, 0.62, LOOSE_SPREAD),
        "ear": head(0.17, 0.30, 0.52),
        "eye": head(0.50, 0.14, 0.57),
    }


_SHOULDER = ("clavicle", "thorax", "lower_thorax", "abdomen")


def landmarks(d: Dimensions) -> dict[str, Landmark]:
    """Return every landmark of a person with these lengths, sides as suffix ``_r`` and ``_l``."""
    found = dict(_midline(d))
    for name, mark in _right(d).items():
        found[f"{name}_r"] = mark
        found[f"{name}_l"] = replace(mark, position=MIRROR * mark.position)
    return found


_UNSIDED = {"pelvis", "abdomen", "lower_thorax", "thorax", "lower_neck", "upper_neck", "head"}


def attachments(human: Human, d: Dimensions | None = None) -> dict[str, Attachment]:
    """Return every landmark as a point fixed to one of the person's bodies.

    Args:
        human: The person; its joint set and feet decide which body carries a landmark.
        d: Lengths for the positions; by default the person's.
    """
    skeleton = human.skeleton
    if d is not None:
        skeleton = build(d, human.sex, human.mass, human.joints, human.feet)
    result = {}
    for name, mark in landmarks(d or human.dimensions).items():
        side = name[-2:] if name[-2:] in ("_r", "_l") else ""
        parts = (_sided(p, side) for p in mark.parts)
        part = next(p for p in parts if p in skeleton.parts)
        body, offset = skeleton.parts[part]
        shift = skeleton.origins[_sided(mark.reference, side)] - skeleton.origins[part]
        result[name] = Attachment(body, mark.position + shift + offset, mark.spread)
    return result


def _sided(part: str, side: str) -> str:
    return part if part in _UNSIDED else part + side
