"""Joint sets: the bodies of four papers as presets over one anatomy.

=======  =========  ==================================================================
preset   moving     description
         segments
=======  =========  ==================================================================
``42``   19         hierarchical gait paper: 8 per arm, 7 per leg, 6 pelvis, 3 lower
                    back, 3 neck; native foot ``two-segment``
``43``   20         spline paper: abdomen, thorax and neck of 3 each, forearms of two
                    bones; native foot ``two-segment``
``58``   25         pendulum paper, the CMU skeleton: three joints in the back, three in
                    the neck, clavicles, ankles of 3 (its 30 joints count five that do
                    not move: two hips to the pelvis, thumbs and fingers, and the root);
                    native foot ``two-segment``
``66``   21         foot paper: twelve ball joints (as three hinges each) and 12 degrees
                    of freedom in each foot; native foot ``multi-segment``
=======  =========  ==================================================================

Each preset can be combined with each foot, which adds coordinates on each side: 0 for ``rigid``, 1
for ``two-segment``, 12 for ``multi-segment``.
"""

from dataclasses import dataclass

from plantigrade.errors import ParameterError

JOINT_SETS = ("42", "43", "58", "66")


@dataclass(frozen=True)
class MovingPart:
    """A moving part with its body and coordinates."""

    part: str  #: Name in the anatomy, without side
    body: str  #: Name of the body, without side
    coordinates: tuple[str, ...]  #: Coordinates without side, in order of rotation


def _spine(joint: str) -> tuple[str, ...]:
    """Return the three coordinates of a joint of the trunk or neck."""
    return tuple(f"{joint}_{c}" for c in ("extension", "bending", "rotation"))


_HIP = ("hip_flexion", "hip_adduction", "hip_rotation")
_LUMBAR, _THORAX, _NECK = _spine("lumbar"), _spine("thorax"), _spine("neck")
_ARM = ("arm_flex", "arm_add", "arm_rot")
_WRIST = ("wrist_flex", "wrist_dev")


def _legs(knee: tuple[str, ...], ankle: tuple[str, ...]) -> tuple[MovingPart, ...]:
    return (
        MovingPart("femur", "femur", _HIP),
        MovingPart("tibia", "tibia", knee),
        MovingPart("foot", "foot", ankle),
    )


_SAGITTAL_KNEE, _ANKLE_2 = ("knee_angle",), ("ankle_angle", "subtalar_angle")
_ANKLE_3 = (*_ANKLE_2, "ankle_rotation")

_PRESETS: dict[str, tuple[MovingPart, ...]] = {
    "42": (
        MovingPart("abdomen", "torso", _LUMBAR),
        MovingPart("lower_neck", "head", _NECK),
        MovingPart("humerus", "humerus", _ARM),
        MovingPart("ulna", "forearm", ("elbow_flex", "pro_sup")),
        MovingPart("hand", "hand", _WRIST),
        MovingPart("fingers", "fingers", ("fingers_flex",)),
        *_legs(_SAGITTAL_KNEE, _ANKLE_2),
    ),
    "43": (
        MovingPart("abdomen", "abdomen", _LUMBAR),
        MovingPart("lower_thorax", "thorax", _THORAX),
        MovingPart("lower_neck", "head", _NECK),
        MovingPart("humerus", "humerus", _ARM),
        MovingPart("ulna", "ulna", ("elbow_flex",)),
        MovingPart("radius", "radius", ("pro_sup",)),
        MovingPart("hand", "hand", _WRIST),
        *_legs(_SAGITTAL_KNEE, _ANKLE_2),
    ),
    "58": (
        MovingPart("abdomen", "abdomen", _LUMBAR),
        MovingPart("lower_thorax", "lower_thorax", _spine("lower_thorax")),
        MovingPart("thorax", "thorax", _THORAX),
        MovingPart("lower_neck", "lower_neck", _spine("lower_neck")),
        MovingPart("upper_neck", "upper_neck", _spine("upper_neck")),
        MovingPart("head", "head", _NECK),
        MovingPart("clavicle", "clavicle", ("clavicle_elevation", "clavicle_protraction")),
        MovingPart("humerus", "humerus", _ARM),
        MovingPart("ulna", "ulna", ("elbow_flex",)),
        MovingPart("radius", "radius", ("pro_sup",)),
        MovingPart("hand", "hand", _WRIST),
        *_legs(_SAGITTAL_KNEE, _ANKLE_3),
    ),
    "66": (
        MovingPart("abdomen", "torso", _LUMBAR),
        MovingPart("lower_neck", "head", _NECK),
        MovingPart("humerus", "humerus", _ARM),
        MovingPart("ulna", "forearm", ("elbow_flex", "elbow_adduction", "pro_sup")),
        *_legs(("knee_angle", "knee_adduction", "knee_rotation"), _ANKLE_3),
    ),
}

NATIVE_FEET = {**dict.fromkeys(("42", "43", "58"), "two-segment"), "66": "multi-segment"}

_FOOT_JOINTS: dict[str, tuple[MovingPart, ...]] = {
    "rigid": (),
    "two-segment": (MovingPart("toes", "toes", ("mtp_angle",)),),
    "multi-segment": tuple(
        MovingPart(part, part, tuple(f"{joint}_{c}" for c in ("angle", "inversion", "adduction")))
        for part, joint in (
            ("medial_phalanges", "mtp"),
            ("lateral_metatarsal", "cuboid"),
            ("lateral_phalanges", "mtp4"),
            ("heel", "heel"),
        )
    ),
}


def moving_parts(joints: str, feet: str) -> dict[str, MovingPart]:
    """Return the moving parts of a joint set with a kind of foot, by name of the part without side.

    Args:
        joints: One of :data:`JOINT_SETS`.
        feet: One of :data:`plantigrade.models.feet.FEET`.
    """
    if joints not in _PRESETS:
        raise ParameterError(f"joints is {joints!r}; allowed are {', '.join(JOINT_SETS)}")
    if feet not in _FOOT_JOINTS:
        raise ParameterError(f"feet is {feet!r}; allowed are {', '.join(_FOOT_JOINTS)}")
    return {m.part: m for m in (*_PRESETS[joints], *_FOOT_JOINTS[feet])}
