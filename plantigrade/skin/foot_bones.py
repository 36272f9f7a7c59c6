"""The sixteen bones of a multi-segment foot as shapes: one smooth family over its capsules.

Physics sees capsules; a :class:`FootBone` is what people look at. Every bone is a closed tube about
a straight axis between two points of :mod:`plantigrade.models.feet`, whose width, height and
offset vary along it: metatarsals have a wide base, a waisted shaft and a round head, toes have the
knuckles of their phalanges, the tarsals a groove where two bones of a person are one solid here.
The calcaneus consists of two halves, as its solids do. Bones leave room for the soft tissue of the
sole: the lowest ones end above the bottom of their contact spheres.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.models.anthropometry import Dimensions
from plantigrade.models.feet import point, sphere_radius
from plantigrade.models.parts import MIRROR

if TYPE_CHECKING:
    from plantigrade.models.human import Human

RINGS, AROUND = 20, 16
"""Rings of a bone between its two poles, and corners of a ring. Chosen."""

End = Mapping[str, float] | str  # A point of the foot's table, or a mean of them by share
Station = tuple[float, float, float, float, float]
"""Share of the axis; offset to lateral and upward; half width and half height. The last four are
in radii of the contact spheres."""


@dataclass(frozen=True)
class _Form:
    """A bone of the left foot: its part, the ends of its axis, its stations."""

    name: str
    part: str
    start: End
    end: End
    stations: tuple[Station, ...]
    edges: float = 2.0  # exponent of the cross-section: 2 an ellipse, more a rounded box


@dataclass(frozen=True, eq=False)
class FootBone:
    """One bone of a foot, rigid on a body."""

    name: str  #: Name, with side
    part: str  #: Anatomical part that it belongs to, with side
    body: int  #: Index of its body in MuJoCo
    start: Float[Array, " 3"]  #: Proximal end of its axis, body frame [m]
    end: Float[Array, " 3"]  #: Distal end of its axis, body frame [m]
    vertices: Float[Array, "n 3"]  #: Vertices, body frame [m]: proximal pole, rings, distal pole
    faces: Int[Array, "n_faces 3"]  #: Triangles, outward by the right-hand rule


def _metatarsal(ray: int, base: tuple[float, float], head: tuple[float, float]) -> _Form:
    """Return a metatarsal; base and head are half width and half height in sphere radii."""
    (w0, h0), (w1, h1) = base, head
    shaft = 0.52 if ray == 1 else 0.36  # half width of the waist; the first one is the stoutest
    flare = 0.55 if ray == 5 else 0.0  # the tuberosity of the fifth, lateral of its base
    stations = (
        (-0.10, 0.25 * flare, 0.0, 0.80 * w0, 0.75 * h0),
        (-0.02, 0.45 * flare, 0.0, w0 + 0.35 * flare, h0),
        (0.10, 0.25 * flare, 0.02, 0.86 * w0, 0.86 * h0),
        (0.30, 0.0, 0.10, 1.12 * shaft, 1.30 * shaft),
        (0.52, 0.0, 0.14, shaft, 1.18 * shaft),
        (0.74, 0.0, 0.08, 1.06 * shaft, 1.30 * shaft),
        (0.90, 0.0, 0.0, 0.90 * w1, 0.88 * h1),
        (1.00, 0.0, 0.0, w1, h1),
        (1.09, 0.0, -0.03, 0.82 * w1, 0.84 * h1),
    )
    part = "lateral_metatarsal" if ray > 3 else "foot"
    return _Form(f"metatarsal_{ray}", part, f"base_{ray}", f"metatarsal_{ray}", stations, 2.3)


def _toe(ray: int, size: float) -> _Form:
    """Return a toe of two phalanges (the first) or three; ``size`` scales its girth."""
    knuckles = (0.58,) if ray == 1 else (0.50, 0.74)
    stations: list[Station] = [(0.15, 0.0, 0.02, 0.80 * size, 0.72 * size)]
    before = 0.20
    for k, knuckle in enumerate(knuckles):
        girth = size * (0.92 if k == 0 else 0.80)
        up = 0.16 * (1 - k)  # the toe is arched over its first knuckle
        stations += [
            (before + 0.04, 0.0, 0.03 + 0.5 * up * k, 0.86 * size * (1 - 0.1 * k), 0.74 * girth),
            ((before + knuckle) / 2, 0.0, up, 0.52 * girth, 0.48 * girth),
            (knuckle - 0.035, 0.0, up, 0.80 * girth, 0.66 * girth),
            (knuckle, 0.0, up, 0.68 * girth, 0.56 * girth),
            (knuckle + 0.035, 0.0, up, 0.78 * girth, 0.64 * girth),
        ]
        before = knuckle
    stations += [
        (0.55 * before + 0.45, 0.0, 0.02, 0.46 * size, 0.40 * size),
        (0.94, 0.0, -0.10, 0.60 * size, 0.44 * size),
        (1.06, 0.0, -0.14, 0.40 * size, 0.30 * size),
    ]
    part = "medial_phalanges" if ray < 4 else "lateral_phalanges"
    return _Form(f"toe_{ray}", part, f"metatarsal_{ray}", f"toe_{ray}", tuple(stations), 2.2)


def _calcaneus(side: str, sign: float) -> _Form:
    """Return half of the calcaneus: tuber behind, posterior facet, process before the cuboid.

    Args:
        side: ``"medial"`` or ``"lateral"``.
        sign: 1 if the half is lateral, else -1.
    """
    inward = -0.80 * sign  # the halves touch in the middle; their solids are farther apart
    shelf = 0.35 if sign < 0 else 0.0  # the sustentaculum, below the head of the talus
    stations = (
        (-0.17, 0.6 * inward, 0.70, 0.70, 1.00),
        (-0.06, 0.9 * inward, 0.78, 0.98, 1.50),
        (0.08, inward, 0.86, 1.00, 1.56),
        (0.32, inward, 1.08, 0.84, 1.34),
        (0.56, inward, 1.42, 0.82, 1.20),
        (0.78, inward - shelf, 1.70, 0.92 + shelf, 1.16),
        (0.95, inward - 1.2 * shelf, 1.58, 0.86 + shelf, 1.02),
        (1.15, 0.9 * inward, 1.24, 0.82, 0.86),
        (1.34, 0.75 * inward, 1.06, 0.72, 0.74),
    )
    front = f"heel_front_{side}"
    return _Form(f"calcaneus_{side}", "heel", f"heel_back_{side}", front, stations, 2.8)


_FORMS = (
    _metatarsal(1, (0.98, 1.35), (1.02, 0.92)),
    _metatarsal(2, (0.76, 1.15), (0.66, 0.80)),
    _metatarsal(3, (0.74, 1.12), (0.64, 0.78)),
    _metatarsal(4, (0.74, 0.86), (0.64, 0.78)),
    _metatarsal(5, (0.76, 0.78), (0.66, 0.78)),
    _toe(1, 1.12),
    _toe(2, 0.80),
    _toe(3, 0.76),
    _toe(4, 0.74),
    _toe(5, 0.74),
    _Form(
        "medial_tarsals",  # navicular, then medial cuneiform
        "foot",
        {"ankle": 0.42, "base_1": 0.58},
        "base_1",
        (
            (-0.12, 0.05, -0.35, 0.80, 0.75),
            (0.05, 0.05, -0.30, 1.15, 1.35),
            (0.24, -0.12, -0.22, 1.22, 1.42),
            (0.38, 0.0, -0.14, 0.86, 1.12),
            (0.50, 0.0, -0.08, 0.92, 1.20),
            (0.78, 0.0, 0.0, 0.94, 1.40),
            (0.94, 0.0, 0.0, 0.86, 1.28),
        ),
        3.0,
    ),
    _Form(
        "middle_tarsals",  # navicular, then intermediate and lateral cuneiform
        "foot",
        {"ankle": 0.44, "base_2": 0.28, "base_3": 0.28},
        {"base_2": 0.5, "base_3": 0.5},
        (
            (-0.12, 0.0, -0.30, 0.70, 0.75),
            (0.05, 0.0, -0.25, 1.05, 1.25),
            (0.24, 0.0, -0.18, 1.10, 1.28),
            (0.38, 0.0, -0.10, 0.88, 1.02),
            (0.52, 0.0, -0.04, 1.02, 1.12),
            (0.80, 0.0, 0.0, 1.10, 1.16),
            (0.96, 0.0, 0.0, 1.00, 1.02),
        ),
        3.0,
    ),
    _Form(
        "cuboid",
        "foot",
        {"heel_front_lateral": 0.45, "base_4": 0.25, "base_5": 0.30},
        {"base_4": 0.62, "base_5": 0.38},
        (
            (-0.30, -0.15, 0.95, 0.90, 0.72),
            (-0.12, -0.10, 0.86, 1.20, 1.02),
            (0.20, 0.0, 0.62, 1.22, 1.00),
            (0.50, 0.05, 0.42, 1.10, 0.86),
            (0.80, 0.05, 0.26, 1.08, 0.80),
            (0.98, 0.05, 0.18, 0.96, 0.68),
        ),
        3.0,
    ),
    _Form(
        "talus",  # posterior process, trochlea under the ankle, neck, head before the navicular
        "foot",
        {"ankle": 0.75, "heel": 0.25, "heel_back_medial": 0.1, "heel_back_lateral": 0.1,
         "base_1": -0.1, "base_3": -0.1},
        {"ankle": 0.40, "base_1": 0.34, "base_2": 0.26},
        (
            (-0.10, 0.0, 0.05, 0.55, 0.40),
            (0.04, 0.0, 0.12, 0.92, 0.86),
            (0.16, 0.0, 0.46, 1.24, 1.46),
            (0.36, 0.0, 0.60, 1.40, 1.82),
            (0.54, 0.0, 0.54, 1.34, 1.62),
            (0.70, 0.0, 0.20, 0.92, 0.94),
            (0.84, 0.0, 0.04, 1.00, 0.94),
            (0.98, 0.0, -0.05, 1.10, 1.04),
            (1.12, 0.0, -0.06, 0.88, 0.82),
        ),
        2.5,
    ),
    _calcaneus("medial", -1.0),
    _calcaneus("lateral", 1.0),
)  # fmt: skip
"""Names of the bones of a foot, without the side."""


def foot_bones(human: "Human") -> tuple[FootBone, ...]:
    """Return the bones of both feet, right first; none where a foot has no bones.

    Args:
        human: The person; bones exist for ``feet="multi-segment"`` only.
    """
    if human.feet != "multi-segment":
        return ()
    d, found = human.dimensions, []
    for side in SIDES:
        for form in _FORMS:
            part = f"{form.part}_{side}"
            body, offset = human.skeleton.parts[part]
            # Axes of all parts are parallel at rest: a part differs from the ankle by its origin.
            ankle = human.skeleton.origins[f"foot_{side}"]
            shift = offset - (human.skeleton.origins[part] - ankle)
            mirror = MIRROR if side == "r" else np.ones(3)
            vertices, faces = _surface(form, d)
            start, end = (_place(each, d) for each in (form.start, form.end))
            found.append(
                FootBone(
                    f"{form.name}_{side}",
                    part,
                    human.body(body),
                    start * mirror + shift,
                    end * mirror + shift,
                    vertices * mirror + shift,
                    faces if side == "l" else faces[:, ::-1],
                )
            )
    return tuple(found)


def _place(end: End, d: Dimensions) -> Array:
    """Return an end of an axis of the left foot, ankle frame [m]."""
    shares = {end: 1.0} if isinstance(end, str) else end
    return np.sum([share * point(name, d) for name, share in shares.items()], axis=0)


def _surface(form: _Form, d: Dimensions) -> tuple[Array, Array]:
    """Return vertices in the ankle frame of the left foot and faces of a bone."""
    from scipy.interpolate import PchipInterpolator

    start, end = _place(form.start, d), _place(form.end, d)
    radius = sphere_radius(d)
    along = end - start
    lateral = np.array([-along[1], along[0], 0.0])
    lateral /= np.linalg.norm(lateral)
    up = np.cross(along, lateral) / np.linalg.norm(along)
    stations = np.array(form.stations)
    low, high = stations[0, 0], stations[-1, 0]
    phase = np.pi * np.arange(RINGS + 2) / (RINGS + 1)
    share = low + (high - low) * (1 - np.cos(phase)) / 2  # denser at the ends
    aside, rise, width, height = PchipInterpolator(stations[:, 0], stations[:, 1:] * radius)(
        share
    ).T
    cap = _rounding(share, low, high, radius / float(np.linalg.norm(along)))
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    bulge = 2.0 / form.edges
    across = np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** bulge
    upward = np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** bulge
    centre = start + np.outer(share, along) + np.outer(aside, lateral) + np.outer(rise, up)
    ring = (
        centre[1:-1, None]
        + (cap * width)[1:-1, None, None] * across[:, None] * lateral
        + (cap * height)[1:-1, None, None] * upward[:, None] * up
    )
    vertices = np.concatenate([centre[:1], ring.reshape(-1, 3), centre[-1:]])
    return vertices, _faces()


def _rounding(share: Array, low: float, high: float, reach: float) -> Array:
    """Return the factor that rounds both ends of a bone over a length, 0 at the poles."""
    reach = min(0.6 * reach, (high - low) / 3)
    inward = np.clip(np.minimum(share - low, high - share) / reach, 0.0, 1.0)
    return np.sqrt(1.0 - (1.0 - inward) ** 2)


def _faces() -> Array:
    """Return the triangles of rings between two poles."""
    ring = np.arange(AROUND)
    after = (ring + 1) % AROUND
    first = [np.stack([np.zeros_like(ring), 1 + after, 1 + ring], axis=1)]
    for k in range(RINGS - 1):
        a, b = 1 + AROUND * k + ring, 1 + AROUND * k + after
        c, e = a + AROUND, b + AROUND
        first += [np.stack([a, b, c], axis=1), np.stack([b, e, c], axis=1)]
    last, pole = 1 + AROUND * (RINGS - 1), 1 + AROUND * RINGS
    first.append(np.stack([np.full_like(ring, pole), last + ring, last + after], axis=1))
    return np.concatenate(first)
