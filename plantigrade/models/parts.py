"""Parts of a body: solids, inertias and their combination."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float

Vector = Float[Array, "3"]


@dataclass(frozen=True)
class Solid:
    """A visual shape in the frame of its part."""

    #: ``"capsule"`` (from ``a`` to ``b``), ``"box"`` or ``"ellipsoid"`` (centre ``a``, half sizes
    #: ``b``)
    kind: str
    a: Vector  #: First point or centre [m]
    b: Vector  #: Second point or half sizes [m]
    radius: float = 0.0  #: Radius of a capsule [m]


@dataclass(frozen=True)
class SoleSphere:
    """A contact sphere of the sole."""

    name: str  #: Name without the side
    position: Vector  #: Centre in the frame of its part [m]
    radius: float  #: Radius [m]
    segment: str  #: Foot segment


@dataclass(frozen=True)
class Inertia:
    """Mass, centre of mass and inertia about it, in one frame."""

    mass: float  #: Mass [kg]
    com: Vector  #: Centre of mass [m]
    tensor: Float[Array, "3 3"]  #: Inertia about the centre of mass, axes of the frame [kg m^2]

    def shifted(self, offset: Vector) -> "Inertia":
        """Return the inertia in a frame with its origin at ``-offset``."""
        return Inertia(self.mass, self.com + offset, self.tensor)

    def scaled(self, factor: float) -> "Inertia":
        """Return the inertia of the same shape with ``factor`` times the mass."""
        return Inertia(self.mass * factor, self.com, self.tensor * factor)


def combine(pieces: Iterable[Inertia]) -> Inertia:
    """Return the inertia of rigidly connected parts in one frame (parallel axis theorem)."""
    pieces = [p for p in pieces if p.mass > 0]
    mass = sum(p.mass for p in pieces)
    if not pieces:
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
    com = np.sum([p.mass * p.com for p in pieces], axis=0) / mass
    tensor = np.zeros((3, 3))
    for p in pieces:
        d = p.com - com
        tensor += p.tensor + p.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Inertia(float(mass), com, tensor)


def rod(mass: float, a: Vector, b: Vector, radius: float) -> Inertia:
    """Return the inertia of a solid cylinder from ``a`` to ``b`` with the ends of a capsule.

    Each end counts as a third of the radius in length, which preserves the volume of the capsule.
    """
    axis = b - a
    length = float(np.linalg.norm(axis))
    u = axis / length
    full = length + 2 * radius * 2 / 3
    along = 0.5 * mass * radius**2
    across = mass * (3 * radius**2 + full**2) / 12
    return Inertia(mass, (a + b) / 2, across * np.eye(3) + (along - across) * np.outer(u, u))


def block(mass: float, centre: Vector, half_sizes: Vector) -> Inertia:
    """Return the inertia of a solid box."""
    x2, y2, z2 = (2 * half_sizes) ** 2
    return Inertia(mass, centre, np.diag([y2 + z2, x2 + z2, x2 + y2]) * mass / 12)


@dataclass(frozen=True)
class Part:
    """One piece of the anatomy; parts without a movable joint are welded to their parent."""

    name: str  #: Name, with side suffix
    parent: str  #: Name of the parent part; empty for the pelvis
    #: Origin in the parent's frame in the zero pose [m]; all frames are parallel in this pose
    position: Vector
    inertia: Inertia  #: Mass properties in its own frame
    solids: tuple[Solid, ...] = ()  #: Visual shapes
    contacts: tuple[SoleSphere, ...] = ()  #: Contact spheres


MIRROR = np.array([1.0, -1.0, 1.0])


def mirrored(part: Part, name: str, parent: str) -> Part:
    """Return the part of the other side, mirrored in y."""
    m = np.diag(MIRROR)
    solids = [
        replace(s, a=MIRROR * s.a, b=MIRROR * s.b if s.kind == "capsule" else s.b)
        for s in part.solids
    ]
    return Part(
        name,
        parent,
        MIRROR * part.position,
        Inertia(part.inertia.mass, MIRROR * part.inertia.com, m @ part.inertia.tensor @ m),
        tuple(solids),
        tuple(replace(c, position=MIRROR * c.position) for c in part.contacts),
    )
