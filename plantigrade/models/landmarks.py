"""Landmarks of the body for markers, from its lengths.

A landmark is given in the frame of a reference part in the zero pose and attached to the first
of its parts that moves on this body (a toe marker belongs to the toes of a foot with toes).
Positions are those of the marker's centre on the skin of an average adult, from [Rajagopal2016]_'s
marker set and the foot table of this package. They are initial values, refined for every person by
the fit within the stated spread.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.data_files import csv_rows
from plantigrade.models.anatomy import hip, shoulder
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


@dataclass(frozen=True)
class _Row:
    """A line of ``landmarks.csv``."""

    name: str
    sided: str
    reference: str
    base: str
    x: float
    y: float
    z: float
    length: str
    parts: str
    spread: str

    def landmark(self, d: Dimensions) -> Landmark:
        """Return the landmark of a person with these lengths, that of the right side."""
        parts = tuple(self.parts.split())
        return Landmark(self.reference, self._position(d), parts, _SPREADS[self.spread])

    def _position(self, d: Dimensions) -> np.ndarray:
        at = np.array([self.x, self.y, self.z])
        if self.length == "foot":
            place = point(self.base, d) * MIRROR + at * [d.foot_length, d.foot_width, 0.0]
            place[2] = self.z * d.ankle_height - d.ankle_height
            return place
        if self.length == "pelvis":
            ahead = MARKER_OFFSET if self.x >= 0 else -MARKER_OFFSET
            return at * [d.pelvis_depth, 0.5 * d.pelvis_width, d.pelvis_depth] + [ahead, 0, 0]
        offset = at * getattr(d, self.length) if self.length else at
        if not self.base:
            return offset
        joint = hip(d) if self.base == "hip" else shoulder(d)
        return (joint if self.sided else joint * [1, 0, 1]) + offset


_ROWS = csv_rows("plantigrade.models", "landmarks.csv", _Row)
_SPREADS = {
    "bone": BONE_SPREAD,
    "skin": SKIN_SPREAD,
    "vertebra": VERTEBRA_SPREAD,
    "loose": LOOSE_SPREAD,
    "joint": JOINT_CENTRE_SPREAD,
}


def landmarks(d: Dimensions) -> dict[str, Landmark]:
    """Return every landmark of a person with these lengths, sides as suffix ``_r`` and ``_l``."""
    found = {}
    for row in _ROWS:
        mark = row.landmark(d)
        if row.sided:
            found[f"{row.name}_r"] = mark
            found[f"{row.name}_l"] = replace(mark, position=MIRROR * mark.position)
        else:
            found[row.name] = mark
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
