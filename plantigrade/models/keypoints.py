"""Keypoints of people in video: their names, and the landmarks that they stand for.

Detectors mark joint centres, not skin: ``RKnee`` of HALPE is the middle of the knee. The sets are
COCO and COCO-WholeBody, HALPE_26, BODY_25 and BODY_25B of OpenPose, BlazePose (MediaPipe), and
the names that Pose2Sim, Sports2D and OpenCap give them. A part with a side is spelled ``RHip``,
``right_hip``, ``RightHip``, ``rightHip`` or ``RIGHT_HIP``.
"""

import re
from collections.abc import Iterable

from plantigrade.data_files import spelling_tables

_SIDED, _MIDLINE = spelling_tables("keypoint_spellings.csv")
# Keypoints without a landmark: fingers, the outline of eyes and mouth, the upper neck.
_OTHER = re.compile(
    r"(thumb|index|middle|ring|pinky|mouth|upperneck|(left|right|[lr])eye(inner|outer))", re.I
)
_LEGS = ("hip_joint", "knee_joint", "ankle_joint")


def _spellings(words: str) -> set[str]:
    """Return the spellings of words in snake case: that, in blanks, camel case, both capitals."""
    parts = words.split("_")
    camel = "".join(part.capitalize() for part in parts)
    return {camel, camel[0].lower() + camel[1:], words, words.upper(), " ".join(parts)}


def _table() -> dict[str, str]:
    found = {n: mark for mark, every in _MIDLINE.items() for one in every for n in _spellings(one)}
    found |= {"CHip": "hip_middle", "midHip": "hip_middle", "MidHip": "hip_middle"}
    for mark, every in _SIDED.items():
        for words in every:
            camel = "".join(part.capitalize() for part in words.split("_"))
            for side in ("right", "left"):
                names = _spellings(f"{side}_{words}") | {f"{side[0].upper()}{camel}"}
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
