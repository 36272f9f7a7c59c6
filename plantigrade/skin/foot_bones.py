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
from plantigrade.data_files import toml_tree
from plantigrade.models.anthropometry import Dimensions
from plantigrade.models.feet import point, sphere_radius
from plantigrade.models.parts import MIRROR

if TYPE_CHECKING:
    from plantigrade.models.human import Human

N_RINGS = 20
"""Rings of a bone between its two poles. Chosen."""
N_RING_CORNERS = 16
"""Corners of a ring. Chosen."""

End = Mapping[str, float] | str  # A point of the foot's table, or a mean of them by share


@dataclass(frozen=True)
class _Form:
    """A bone of the left foot: its part, the ends of its axis, its stations."""

    name: str
    part: str
    start: End
    end: End
    edges: float  # exponent of the cross-section: 2 an ellipse, more a rounded box
    # Share of the axis; offset to lateral and upward, half width and half height in radii of the
    # contact spheres
    stations: list[list[float]]


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


_FORMS = tuple(_Form(**row) for row in toml_tree("plantigrade.skin", "foot_bones.toml")["bones"])


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
    phase = np.pi * np.arange(N_RINGS + 2) / (N_RINGS + 1)
    share = low + (high - low) * (1 - np.cos(phase)) / 2  # denser at the ends
    aside, rise, width, height = PchipInterpolator(stations[:, 0], stations[:, 1:] * radius)(
        share
    ).T
    cap = _rounding(share, low, high, radius / float(np.linalg.norm(along)))
    turn = 2 * np.pi * np.arange(N_RING_CORNERS) / N_RING_CORNERS
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
    ring = np.arange(N_RING_CORNERS)
    after = (ring + 1) % N_RING_CORNERS
    first = [np.stack([np.zeros_like(ring), 1 + after, 1 + ring], axis=1)]
    for k in range(N_RINGS - 1):
        a, b = 1 + N_RING_CORNERS * k + ring, 1 + N_RING_CORNERS * k + after
        c, e = a + N_RING_CORNERS, b + N_RING_CORNERS
        first += [np.stack([a, b, c], axis=1), np.stack([b, e, c], axis=1)]
    last, pole = 1 + N_RING_CORNERS * (N_RINGS - 1), 1 + N_RING_CORNERS * N_RINGS
    first.append(np.stack([np.full_like(ring, pole), last + ring, last + after], axis=1))
    return np.concatenate(first)
