"""Anatomy at the finest level: all parts of the body above the feet, from its lengths.

A joint set chooses which parts move (:mod:`plantigrade.models.joint_sets`); the others are
welded to their parents. In the zero pose all frames are parallel to the world axes, each origin is
the proximal joint of the part, and palms face forward, as in Rajagopal's model.
"""

from dataclasses import replace

import numpy as np

from plantigrade.models.anthropometry import (
    COM_FORWARD,
    DE_LEVA,
    PELVIS_COM_BEHIND,
    TORSO_COM_BEHIND,
    TRUNK_LANDMARKS,
    Dimensions,
)
from plantigrade.models.parts import Inertia, Part, Solid, block, combine, mirrored, rod

# Divisions of the trunk, heights above the lumbar joint as fractions of the trunk.
LOW_THORAX = {"male": 0.518, "female": 0.589}
MID_UPPER_TRUNK = 0.742
# 0.020 of stature below the acromion (de Leva's 10 % of the length from acromion to radiale), which
# is at 0.820 of stature in ANSUR II [Gordon2014]_.
SHOULDER_HEIGHT = 0.804
# Suprasternale in front of the lumbar joint, without skin, as a fraction of the trunk.
SUPRASTERNALE_FORWARD = 0.158
# Vertex in front of C7/T1 over the height of the head.
VERTEX_FORWARD = 0.17
# Divisions of the neck, heights above the joint under C7 as fractions of the head's length.
MID_NECK, UPPER_NECK = 0.22, 0.42
# Share of one shoulder girdle in the mass of de Leva's upper trunk: clavicle and scapula with the
# muscles that move with them, an estimate by volume.
GIRDLE_SHARE = 0.04
# Share of the neck in the mass of de Leva's head-and-neck segment: by volume of a cylinder.
NECK_SHARE = 0.17


SPINE_RISE = 0.05
"""Height of the posterior above the anterior iliac spines where the coordinate ``pelvis_tilt`` is
zero, as a fraction of the depth of the pelvis: that of Rajagopal's model (middle of the posterior
spines 9 mm above that of the anterior ones over a depth of 192 mm in its file [Rajagopal2016]_)."""

SPINE_PLANE = float(np.degrees(np.arctan(SPINE_RISE)))
"""Forward lean of the plane through the iliac spines where ``pelvis_tilt`` is zero [deg].

The clinical pelvic tilt (Plug-in Gait: the plane through the anterior spines and the middle of the
posterior ones against the horizontal, positive forward) is this minus ``pelvis_tilt``, and the
clinical hip flexion is ``hip_flexion`` plus this, for everybody: the spines define the pelvis.
"""

# L5/S1 behind the hip joint centres in the plane of the spines, as a fraction of the distance
# between the anterior spines: (0.335 - 0.095) of men and (0.340 - 0.139) of women.
LUMBAR_BEHIND_HIPS = 0.22


def hip(d: Dimensions) -> np.ndarray:
    """Return the right hip joint centre in the pelvis frame [m].

    The pelvis frame has its origin midway between the anterior superior iliac spines. The
    regression is that of [Harrington2007]_ (adults and children), whose axes lie in the plane of
    the iliac spines; the result is rotated into the pelvis frame.
    """
    back = 0.24 * d.pelvis_depth + 0.0099
    out = 0.33 * d.pelvis_width + 0.0073
    down = 0.30 * d.pelvis_width + 0.0109
    cos, sin = np.array([1.0, SPINE_RISE]) / np.hypot(1.0, SPINE_RISE)
    return np.array([-back * cos - down * sin, -out, back * sin - down * cos])


def lumbar(d: Dimensions) -> np.ndarray:
    """Return the lumbar joint in the pelvis frame [m].

    One joint represents the lumbar spine. Its height is that of [Rajagopal2016]_, about the third
    lumbar vertebra.
    """
    return np.array([-d.lumbar_depth, 0.0, hip(d)[2] + d.pelvis_height])


def usual_lumbar_depth(d: Dimensions) -> float:
    """Return the mean distance of the lumbar joint behind the anterior iliac spines [m].

    [DumasWojtusch2018]_ give L5/S1 and hip joint centres relative to the iliac spines; the result
    is the mean of men and women. The lumbar spine is perpendicular to the plane of the iliac
    spines, which leans forward by :data:`SPINE_PLANE`.
    """
    behind = LUMBAR_BEHIND_HIPS * d.pelvis_width
    cos, sin = np.array([1.0, SPINE_RISE]) / np.hypot(1.0, SPINE_RISE)
    return float(-hip(d)[0] + (behind - d.pelvis_height * sin) / cos)


def shoulder(d: Dimensions) -> np.ndarray:
    """Return the right shoulder joint centre from the lumbar joint, zero pose [m]."""
    return np.array([0.01 * d.trunk, -0.5 * d.shoulder_width, SHOULDER_HEIGHT * d.trunk])


def neck(d: Dimensions) -> np.ndarray:
    """Return the joint under C7 from the lumbar joint, zero pose [m]."""
    return np.array([0.06 * d.trunk, 0.0, d.trunk])


def _part(name, parent, position, inertia, kind, a, b, radius=0.0) -> Part:
    """Return a part drawn as one solid."""
    solid = Solid(kind, np.array(a, dtype=float), np.array(b, dtype=float), radius)
    return Part(name, parent, position, inertia, (solid,))


def _principal(mass, com, gyration, length) -> Inertia:
    """Return an Inertia from radii of gyration about x, y and z (relative to the length)."""
    return Inertia(
        mass, np.asarray(com, float), mass * np.diag([(g * length) ** 2 for g in gyration])
    )


def _halves(whole: Inertia, length: float) -> tuple[Inertia, Inertia]:
    """Divide a segment across its vertical axis into two halves of equal mass and length."""
    quarter = np.array([0.0, 0.0, length / 4])
    own = whole.tensor / 2 - whole.mass / 2 * (length / 4) ** 2 * np.diag([1.0, 1.0, 0.0])
    return (
        Inertia(whole.mass / 2, whole.com - quarter, own),
        Inertia(whole.mass / 2, whole.com + quarter, own),
    )


def body_parts(d: Dimensions, sex: str, mass: float) -> list[Part]:
    """Return all parts except the feet, parents first.

    Args:
        sex: ``"female"`` or ``"male"``.
        mass: Body mass [kg].
    """
    parts = [*_trunk(d, sex, mass), *_head(d, sex, mass)]
    for part in [*_arm(d, sex, mass), *_leg(d, sex, mass)]:
        parent = part.parent if part.parent in ("pelvis", "thorax") else part.parent + "_l"
        parts.append(mirrored(part, part.name + "_l", parent))
        right = parent.removesuffix("_l") + ("_r" if parent.endswith("_l") else "")
        parts.append(replace(part, name=part.name + "_r", parent=right))
    return parts


def torso(d: Dimensions, sex: str, mass: float) -> tuple[Inertia, Inertia]:
    """Return the middle and the upper trunk, shoulder girdles included, from the lumbar joint.

    Heights, masses and shape are those of [deLeva1996]_. The distance of both behind the
    suprasternale is that of the whole torso in [Dumas2007]_.
    """
    rise = d.pelvis_height + d.trunk
    marks = {name: share * rise - d.pelvis_height for name, share in TRUNK_LANDMARKS[sex].items()}
    end, above = neck(d), marks["suprasternale"]
    lean = end[0] / end[2]
    front = SUPRASTERNALE_FORWARD * d.trunk - TORSO_COM_BEHIND[sex] * rise

    def part(name: str, top: str, bottom: str) -> Inertia:
        p, length = DE_LEVA[sex][name], marks[top] - marks[bottom]
        z = marks[top] - p.com * length
        return _principal(mass * p.mass, [front - lean * (above - z), 0, z], p.gyration, length)

    return (
        part("middle_trunk", "xiphoid", "omphalion"),
        part("upper_trunk", "suprasternale", "xiphoid"),
    )


def _trunk(d: Dimensions, sex: str, mass: float) -> list[Part]:
    h, low, middle, upper = hip(d), lumbar(d), *torso(d, sex, mass)
    p, marks = DE_LEVA[sex]["lower_trunk"], TRUNK_LANDMARKS[sex]
    rise = d.pelvis_height + d.trunk
    back = PELVIS_COM_BEHIND[sex] * d.pelvis_width
    pelvis = _principal(
        mass * p.mass,
        [-back, 0, h[2] + (1 - p.com) * marks["omphalion"] * rise],
        p.gyration,
        marks["lower_trunk"] * rise,
    )
    length = (marks["suprasternale"] - marks["xiphoid"]) * rise
    upper_low, upper_high = _halves(upper, length)
    at = np.array([0.04 * d.trunk, 0, LOW_THORAX[sex] * d.trunk])
    high = np.array([0.03 * d.trunk, 0, MID_UPPER_TRUNK * d.trunk])
    wide, deep = 0.5 * d.shoulder_width, 0.5 * d.pelvis_depth
    return [
        _part(
            "pelvis", "", np.zeros(3), pelvis, "ellipsoid",
            [1.15 * h[0], 0, h[2] + 0.45 * d.pelvis_height],
            [0.95 * deep, 0.62 * d.pelvis_width, 0.75 * d.pelvis_height],
        ),
        _part(
            "abdomen", "pelvis", low, middle, "ellipsoid",
            [0.05 * d.trunk, 0, 0.22 * d.trunk],
            [1.15 * deep, 0.78 * wide, 0.36 * d.trunk],
        ),
        _part(
            "lower_thorax", "abdomen", at, upper_low.shifted(-at), "ellipsoid",
            np.array([-0.02 * d.trunk, 0, 0.62 * d.trunk]) - at,
            [1.15 * deep, 0.92 * wide, 0.34 * d.trunk],
        ),
        _part(
            "thorax", "lower_thorax", high - at,
            upper_high.scaled(1 - 4 * GIRDLE_SHARE).shifted(-high),  # half the mass, two girdles
            "capsule",
            shoulder(d) * np.array([1, 0.85, 1]) - high,
            shoulder(d) * np.array([1, -0.85, 1]) - high,
            0.24 * wide,
        ),
    ]  # fmt: skip


def _head(d: Dimensions, sex: str, mass: float) -> list[Part]:
    p = DE_LEVA[sex]["head"]
    root = neck(d) - np.array([0.03 * d.trunk, 0, MID_UPPER_TRUNK * d.trunk])
    length = 0.889 * d.head  # de Leva's vertex to cervicale, his mean lengths
    z = d.head - p.com * length
    x = VERTEX_FORWARD * z + COM_FORWARD[sex]["head"] * d.head
    whole = _principal(mass * p.mass, [x, 0, z], p.gyration, length)
    radius = 0.20 * d.head
    lower = np.array([0.06 * d.head, 0, MID_NECK * d.head])
    upper = np.array([0.13 * d.head, 0, UPPER_NECK * d.head])
    pieces = []
    for a, b in ((np.zeros(3), lower), (lower, upper)):
        m = whole.mass * NECK_SHARE / 2
        rise = b[2] - a[2]
        across = m * (3 * radius**2 + rise**2) / 12
        pieces.append(Inertia(m, (a + b) / 2, np.diag([across, across, m * radius**2 / 2])))
    # The skull is the difference between de Leva's segment and the neck.
    both = combine(pieces)
    m = whole.mass - both.mass
    com = (whole.mass * whole.com - both.mass * both.com) / m
    skull_zero = combine([*pieces, Inertia(m, com, np.zeros((3, 3)))])
    skull = Inertia(m, com, np.diag(np.diag(whole.tensor - skull_zero.tensor)))
    face = np.array([0.19 * d.head, 0, 0.60 * d.head]) - upper
    origin = np.zeros(3)
    neck_low, neck_high = pieces[0], pieces[1].shifted(-lower)
    size = [0.365 * d.head, 0.285 * d.head, 0.40 * d.head]
    return [
        _part("lower_neck", "thorax", root, neck_low, "capsule", origin, lower, radius),
        _part(
            "upper_neck", "lower_neck", lower, neck_high, "capsule", origin, upper - lower, radius
        ),
        _part("head", "upper_neck", upper - lower, skull.shifted(-upper), "ellipsoid", face, size),
    ]


def _limb(mass, p, end: np.ndarray, forward: float = 0.0) -> Inertia:
    """Return a limb from the origin to its distal joint at ``end``, with an anterior offset."""
    length = -end[2]
    com = p.com * end + forward * length * np.array([1.0, 0.0, 0.0])
    return _principal(mass * p.mass, com, p.gyration, length)


def _arm(d: Dimensions, sex: str, mass: float) -> list[Part]:
    """Return the right arm; names without side."""
    table = DE_LEVA[sex]
    at_thorax = np.array([0.03 * d.trunk, 0, MID_UPPER_TRUNK * d.trunk])
    s = shoulder(d)
    sternum = np.array([0.16 * d.trunk, -0.1 * d.shoulder_width, 0.88 * d.trunk])
    elbow = np.array([0.0, 0.03 * d.upper_arm, -d.upper_arm])
    girdle = GIRDLE_SHARE * mass * table["upper_trunk"].mass
    upper = _limb(mass, table["upper_arm"], elbow)
    lower = _limb(mass, table["forearm"], np.array([0.0, 0.0, -d.forearm]))
    palm_length = 0.46 * d.hand  # wrist to third metacarpal head, de Leva's lengths
    knuckles = np.array([0, 0, -palm_length])
    tip = np.array([0, 0, -(d.hand - palm_length)])
    palm_half = np.array([0.11 * palm_length, 0.42 * palm_length, 0.5 * palm_length])
    finger_half = np.array([0.09 * palm_length, 0.40 * palm_length, -0.5 * tip[2]])
    # Palm and fingers are blocks that share de Leva's mass and preserve the centre of mass.
    hand = table["hand"]
    middle = knuckles[2] + tip[2] / 2
    share = (-hand.com * palm_length - knuckles[2] / 2) / (middle - knuckles[2] / 2)
    palm = block((1 - share) * mass * hand.mass, knuckles / 2, palm_half)
    fingers = block(share * mass * hand.mass, np.array([0, 0, middle]), finger_half)
    origin, half, wrist = np.zeros(3), [0, 0, -0.5 * d.forearm], [0, 0, -0.97 * d.forearm]
    thick = 0.06 * d.shoulder_width
    collar = rod(girdle, origin, s - sternum, thick)
    # the scapula lies as far behind as the clavicle lies in front
    level = torso(d, sex, mass)[1].com[0] - sternum[0]
    collar = replace(collar, com=np.array([level, *collar.com[1:]]))
    return [
        _part(
            "clavicle", "thorax", sternum - at_thorax, collar, "capsule", origin, s - sternum, thick
        ),
        _part(
            "humerus", "clavicle", s - sternum, upper, "capsule", origin, elbow, 0.15 * d.upper_arm
        ),
        _part(
            "ulna", "humerus", elbow, lower.scaled(0.5), "capsule", origin, half, 0.14 * d.forearm
        ),
        _part(
            "radius", "ulna", origin, lower.scaled(0.5), "capsule", half, wrist, 0.11 * d.forearm
        ),
        _part(
            "hand", "radius", np.array([0, 0, -d.forearm]), palm, "box", knuckles * 0.5, palm_half
        ),
        _part(
            "fingers", "hand", knuckles, fingers.shifted(-knuckles), "box", tip * 0.5, finger_half
        ),
    ]


def _leg(d: Dimensions, sex: str, mass: float) -> list[Part]:
    """Return the right leg above the foot; names without side. Offsets from [Rajagopal2016]_."""
    table = DE_LEVA[sex]
    knee = np.array([-0.011 * d.thigh, -0.0043 * d.thigh * -1, -d.thigh])
    ankle, origin = foot_position(d), np.zeros(3)
    thigh = _limb(mass, table["thigh"], knee)
    shank = _limb(mass, table["shank"], ankle, COM_FORWARD[sex]["shank"])
    calf = min(0.105 * d.shank, 0.75 * d.ankle_height)  # limited to stay above the ground
    return [
        _part("femur", "pelvis", hip(d), thigh, "capsule", origin, knee, 0.155 * d.thigh),
        _part("tibia", "femur", knee, shank, "capsule", origin, ankle, calf),
    ]


def foot_position(d: Dimensions) -> np.ndarray:
    """Return the ankle joint centre in the tibia frame [m]."""
    return np.array([-0.025 * d.shank, 0.0, -d.shank])
