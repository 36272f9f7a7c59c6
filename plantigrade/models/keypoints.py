"""Keypoints of people in video: their names, and the landmarks that they stand for.

Detectors mark joint centres, not skin: ``RKnee`` of HALPE is the middle of the knee. The sets are
COCO and COCO-WholeBody, HALPE_26, BODY_25 and BODY_25B of OpenPose, BlazePose (MediaPipe), and
the names that Pose2Sim, Sports2D and OpenCap give them. A part with a side is spelled ``RHip``,
``right_hip``, ``RightHip``, ``rightHip`` or ``RIGHT_HIP``.
"""

import re
from collections.abc import Iterable

_JOINTS = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
# Part of the body, words separated by blanks → landmark without side
_SIDED = {
    **{joint: f"{joint}_joint" for joint in _JOINTS},
    "heel": "heel",
    "big toe": "hallux",
    "foot index": "toe_tip",
    "small toe": "toe_5",
    "ear": "ear",
    "eye": "eye",
}
_MIDLINE = {
    "hip": "hip_middle",
    "mid hip": "hip_middle",
    "c hip": "hip_middle",
    "pelvis": "hip_middle",
    "neck": "shoulder_middle",
    "nose": "nose",
    "head": "vertex",
    "head top": "vertex",
}
# Keypoints without a landmark: fingers, the outline of eyes and mouth, the upper neck.
_OTHER = re.compile(
    r"(thumb|index|middle|ring|pinky|mouth|upperneck|(left|right|[lr])eye(inner|outer))", re.I
)
_LEGS = ("hip_joint", "knee_joint", "ankle_joint")


def _spellings(words: str) -> set[str]:
    """Return the spellings of some words: snake case, camel case, both capitals."""
    parts = words.split()
    camel = "".join(part.capitalize() for part in parts)
    snake = "_".join(parts)
    return {camel, camel[0].lower() + camel[1:], snake, snake.upper(), words}


def _table() -> dict[str, str]:
    found = {name: mark for words, mark in _MIDLINE.items() for name in _spellings(words)}
    found |= {"CHip": "hip_middle", "midHip": "hip_middle", "MidHip": "hip_middle"}
    for words, mark in _SIDED.items():
        camel = "".join(part.capitalize() for part in words.split())
        for side in ("right", "left"):
            names = _spellings(f"{side} {words}") | {f"{side[0].upper()}{camel}"}
            found |= {name: f"{mark}_{side[0]}" for name in names}
    return found


KEYPOINTS: dict[str, str] = _table()
"""Keypoint name → landmark, with its side."""


def are_keypoints(names: Iterable[str]) -> bool:
    """Return whether these are keypoints of a video: the joint centres of both legs by name.

    Example:
        >>> are_keypoints("RHip LHip RKnee LKnee RAnkle LAnkle Neck".split())
        True
        >>> are_keypoints("RASI LASI RKNE LKNE".split())
        False
    """
    marks = {KEYPOINTS.get(name) for name in names}
    return {f"{joint}_{side}" for joint in _LEGS for side in "rl"} <= marks


def shows_toes(names: Iterable[str]) -> bool:
    """Return whether keypoints show the front of a foot; COCO's end at the ankles."""
    return any(KEYPOINTS.get(name, "").startswith(("hallux", "toe")) for name in names)


def is_without_landmark(name: str) -> bool:
    """Return whether a keypoint shows a part that this package does not follow, as a finger."""
    return name not in KEYPOINTS and _OTHER.search(re.sub(r"[ _]", "", name)) is not None
