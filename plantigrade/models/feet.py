"""Interchangeable foot models: one box, two boxes with a toe hinge, or sixteen bones.

All three have the length, width and mass of one foot and contact the ground at points of the
multi-segment foot of [Park2020]_. The paper gives no coordinates; these are anatomically plausible
and put all four joints of a flat foot at the height of the contact spheres, as the paper's Eqs. 1-2
assume. The frame of a foot has its origin in the ankle joint centre; x points forward, y left;
points are tabulated for a left foot of 0.240 m length and 0.0585 m ankle height and scaled to the
person.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.data_files import toml_tree
from plantigrade.errors import ParameterError
from plantigrade.models.anthropometry import DE_LEVA, Dimensions
from plantigrade.models.parts import Inertia, Part, SoleSphere, Solid, block, combine, mirrored, rod

FEET = ("rigid", "two-segment", "multi-segment")

_LENGTH = 0.240  # [m] foot length of the table below
_WIDTH = 0.094  # [m] foot width of the table below
_ANKLE = 0.0585  # [m] ankle height of the table below
_RADIUS = 0.010  # [m] radius of a contact sphere on a foot of that length

_TREE = toml_tree("plantigrade.models", "feet.toml")
_POINTS: dict[str, list[float]] = _TREE["points"]
"""x forward, y lateral (left foot), z above the ground [m]; without z: resting on the ground."""


@dataclass(frozen=True)
class _Segment:
    """A segment of the multi-segment foot: joint, bones, and bone ends in ground contact."""

    name: str
    parent: str
    joint: str
    bones: tuple[tuple[str, str], ...]
    contacts: tuple[str, ...]


_SEGMENTS = tuple(
    _Segment(
        **{
            **each,
            "bones": tuple((a, b) for a, b in each["bones"]),
            "contacts": tuple(each["contacts"]),
        }
    )
    for each in _TREE["segments"]
)


def sphere_radius(d: Dimensions) -> float:
    """Return the radius of all bones and contact spheres [m]."""
    return _RADIUS * d.foot_length / _LENGTH


def point(name: str, d: Dimensions) -> np.ndarray:
    """Return a point of the left foot at rest, in the ankle frame [m].

    Args:
        name: Name in the table of this module (``"toe_1"``, ``"heel"``, ``"base_4"``, …).
    """
    x, y, *z = _POINTS[name]
    height = z[0] * d.ankle_height / _ANKLE if z else sphere_radius(d)
    return np.array(
        [x * d.foot_length / _LENGTH, y * d.foot_width / _WIDTH, height - d.ankle_height]
    )


def foot_parts(
    kind: str, d: Dimensions, sex: str, mass: float, full_sole: bool = False
) -> list[Part]:
    """Return the parts of both feet, parents first; the tibia is the parent of the first.

    The mass of the foot is de Leva's, distributed by volume. The rigid and the two-segment foot
    have seven of the sixteen contacts of the multi-segment foot, enough for gait; their base of
    support is 5 mm smaller at the lateral border. With a ``full_sole`` all feet have the same
    sixteen contacts and differ only in their joints.

    Args:
        kind: One of :data:`FEET`.
        sex: ``"female"`` or ``"male"``.
        mass: Body mass [kg].
        full_sole: Whether the foot has all sixteen contacts.
    """
    if kind not in FEET:
        raise ParameterError(f"feet is {kind!r}; allowed are {', '.join(FEET)}")
    mass *= DE_LEVA[sex]["foot"].mass
    if kind == "multi-segment":
        left = _multi_segment(d, sex, mass)
    else:
        sole, toes = (_FULL_SOLE, _ALL_TOES) if full_sole else (_SOLE, _TOES)
        left = (_rigid if kind == "rigid" else _two_segment)(d, sex, mass, sole, toes)
    right = [mirrored(p, p.name[:-1] + "r", p.parent[:-1] + "r") for p in left]
    return [*right, *left]


def _outline(d: Dimensions, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner of the box around spheres at ``names``, [m]."""
    r = sphere_radius(d)
    points = np.array([point(n, d) for n in names])
    return points.min(axis=0) - r, points.max(axis=0) + r


def _contacts(d: Dimensions, names: tuple[str, ...], segment: str, origin: np.ndarray):
    r = sphere_radius(d)
    return tuple(SoleSphere(n, point(n, d) - origin, r, segment) for n in names)


_SOLE = ("heel_back_medial", "heel_back_lateral", "metatarsal_1", "metatarsal_5")
_TOES = ("toe_1", "toe_3", "toe_5")
_ALL_TOES = tuple(f"toe_{i}" for i in range(1, 6))
_FULL_SOLE = tuple(c for s in _SEGMENTS for c in s.contacts if c not in _ALL_TOES)

Names = tuple[str, ...]


def _rigid(d: Dimensions, sex: str, mass: float, sole: Names, toes: Names) -> list[Part]:
    p = DE_LEVA[sex]["foot"]
    low, high = _outline(d, (*_SOLE, *_TOES))
    length = d.foot_length
    com = np.array([low[0] + p.com * length, (low[1] + high[1]) / 2, -0.6 * d.ankle_height])
    sagittal, transverse, longitudinal = p.gyration
    # de Leva's longitudinal axis of the foot runs from heel to toe; the sagittal one is vertical.
    tensor = np.diag([longitudinal**2, transverse**2, sagittal**2]) * mass * length**2
    return [
        Part(
            "foot_l",
            "tibia_l",
            np.zeros(3),
            Inertia(mass, com, tensor),
            _sole_solids(d, low, high),
            _contacts(d, (*sole, *toes), "foot", np.zeros(3)),
        )
    ]


def _sole_solids(d: Dimensions, low: np.ndarray, high: np.ndarray) -> tuple[Solid, ...]:
    """Return a box on the ground, 0.4 ankle heights tall, and the instep above it."""
    half = (high - low) / 2
    half[2] = 0.2 * d.ankle_height
    centre = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, half[2] - d.ankle_height])
    r = 0.45 * d.ankle_height
    front = np.array([0.45 * high[0], centre[1], -0.6 * d.ankle_height])
    return (
        Solid("box", centre, half),
        Solid("capsule", np.array([0.0, 0.0, -0.1 * d.ankle_height]), front, r),
    )


def _two_segment(d: Dimensions, sex: str, mass: float, sole: Names, toes: Names) -> list[Part]:
    low, high = _outline(d, _SOLE)
    hinge = np.array([point("metatarsal_1", d)[0], 0.0, sphere_radius(d) - d.ankle_height])
    high[0] = hinge[0]
    toe_low, toe_high = _outline(d, _TOES)
    toe_low[0] = hinge[0]
    toe_half = (toe_high - toe_low) / 2
    toe_half[2] = sphere_radius(d)
    toe_centre = (toe_low + toe_high) / 2 - hinge
    hind_solids = _sole_solids(d, low, high)
    box = hind_solids[0]
    # The hindfoot is a sole with a wedge above it: its volume is that of a box 0.55 ankles tall.
    hind_half = box.b * np.array([1, 1, 0.55 / 0.4])
    hind_centre = np.array([box.a[0], box.a[1], hind_half[2] - d.ankle_height])
    volumes = np.array([np.prod(hind_half), np.prod(toe_half)])
    masses = mass * volumes / volumes.sum()
    return [
        Part(
            "foot_l",
            "tibia_l",
            np.zeros(3),
            block(masses[0], hind_centre, hind_half),
            hind_solids,
            _contacts(d, sole, "foot", np.zeros(3)),
        ),
        Part(
            "toes_l",
            "foot_l",
            hinge,
            block(masses[1], toe_centre, toe_half),
            (Solid("box", toe_centre, toe_half),),
            _contacts(d, toes, "toes", hinge),
        ),
    ]


def _multi_segment(d: Dimensions, sex: str, mass: float) -> list[Part]:
    r = sphere_radius(d)
    lengths = [
        np.linalg.norm(point(b, d) - point(a, d)) for s in _SEGMENTS for a, b in s.bones
    ]  # equal radii, so volume is proportional to length
    per_metre = float(mass / sum(lengths))
    part_name = {s.name: f"{s.name}_l" for s in _SEGMENTS} | {"medial_metatarsal": "foot_l"}
    origin = {s.name: point(s.joint, d) for s in _SEGMENTS} | {"medial_metatarsal": np.zeros(3)}
    parts = []
    for s in _SEGMENTS:
        o = origin[s.name]
        ends = [(point(a, d) - o, point(b, d) - o) for a, b in s.bones]
        parent_origin = origin[s.parent] if s.parent else np.zeros(3)
        parts.append(
            Part(
                part_name[s.name],
                part_name[s.parent] if s.parent else "tibia_l",
                o - parent_origin if s.parent else np.zeros(3),
                combine(rod(per_metre * float(np.linalg.norm(b - a)), a, b, r) for a, b in ends),
                tuple(Solid("capsule", a, b, r) for a, b in ends),
                _contacts(d, s.contacts, s.name, o),
            )
        )
    return parts
