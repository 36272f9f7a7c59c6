"""Skeleton: bodies assembled from anatomical parts according to a joint set."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.models.anatomy import body_parts, foot_position
from plantigrade.models.anthropometry import Dimensions
from plantigrade.models.coordinates import COORDINATES, REFERENCE_HEIGHT, REFERENCE_MASS
from plantigrade.models.feet import foot_parts
from plantigrade.models.joint_sets import moving_parts
from plantigrade.models.parts import Inertia, Part, SoleSphere, Solid, combine
from plantigrade.side_names import split_side


@dataclass(frozen=True)
class Hinge:
    """One coordinate of a body: name with side, unit axis, limits [rad] and torque range [N m]."""

    name: str
    axis: np.ndarray
    low: float
    high: float
    torque: tuple[float, float]


@dataclass(frozen=True)
class Body:
    """A moving segment with everything welded to it, in its own frame."""

    name: str  #: Name with side
    parent: str  #: Name of the parent body; empty for the pelvis
    position: np.ndarray  #: Origin in the parent body's frame, zero pose [m]
    hinges: tuple[Hinge, ...]  #: Coordinates, proximal first
    inertia: Inertia  #: Mass properties
    solids: tuple[Solid, ...]  #: Visual shapes
    contacts: tuple[SoleSphere, ...]  #: Contact points

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Names of the contact points in the model."""
        return tuple(f"contact_{c.segment}_{c.name}_{self.name[-1]}" for c in self.contacts)


@dataclass(frozen=True)
class Skeleton:
    """Bodies of one person and the position of each anatomical part in them."""

    bodies: tuple[Body, ...]  #: Parents first
    #: Part name → (body name, offset of the part's origin in the body's frame [m])
    parts: dict[str, tuple[str, np.ndarray]]
    origins: dict[str, np.ndarray]  #: Part name → origin in the pelvis frame, zero pose [m]

    def with_inertia(self, changed: Mapping[str, Inertia]) -> "Skeleton":
        """Return the skeleton with other mass properties of some bodies, by name."""
        bodies = (replace(b, inertia=changed.get(b.name, b.inertia)) for b in self.bodies)
        return replace(self, bodies=tuple(bodies))

    def with_contact_heights(self, offsets: Mapping[str, float]) -> "Skeleton":
        """Return the skeleton with contact points moved up, by name [m]."""

        def moved(body: Body) -> Body:
            named = zip(body.contact_names, body.contacts, strict=True)
            up = ((c, np.array([0.0, 0.0, offsets.get(name, 0.0)])) for name, c in named)
            return replace(
                body, contacts=tuple(replace(c, position=c.position + by) for c, by in up)
            )

        return replace(self, bodies=tuple(map(moved, self.bodies)))


def all_parts(
    d: Dimensions, sex: str, mass: float, feet: str, full_sole: bool = False
) -> list[Part]:
    """Return every part of the body, parents first."""
    feet_parts = [
        replace(p, position=foot_position(d)) if p.parent.startswith("tibia") else p
        for p in foot_parts(feet, d, sex, mass, full_sole)
    ]
    return [*body_parts(d, sex, mass), *feet_parts]


def build(
    d: Dimensions, sex: str, mass: float, joints: str, feet: str, full_sole: bool = False
) -> Skeleton:
    """Return the skeleton of a person, with fixed parts welded to their parents.

    Args:
        sex: ``"female"`` or ``"male"``.
        mass: Body mass [kg]; the bodies' masses add up to it exactly.
        full_sole: Whether the foot has contacts at every point of the sole
            (:func:`~plantigrade.models.feet.foot_parts`).
    """
    moving = moving_parts(joints, feet)
    parts = all_parts(d, sex, mass, feet, full_sole)
    share = mass / sum(p.inertia.mass for p in parts)
    home: dict[str, tuple[str, np.ndarray]] = {}
    origins: dict[str, np.ndarray] = {}
    frames: dict[str, tuple[str, np.ndarray, tuple[Hinge, ...]]] = {}
    members: dict[str, list[tuple[Part, np.ndarray]]] = {}
    for part in parts:
        plain, side = split_side(part.name)
        origins[part.name] = origins[part.parent] + part.position if part.parent else np.zeros(3)
        if part.parent and plain not in moving:
            body, offset = home[part.parent]
            home[part.name] = (body, offset + part.position)
        else:
            mover = moving.get(plain)
            body = _sided(mover.body, side) if mover else part.name
            parent, offset = home[part.parent] if part.parent else ("", np.zeros(3))
            hinges = tuple(
                _hinge(c, side, mass * d.height) for c in (mover.coordinates if mover else ())
            )
            frames[body] = (parent, offset + part.position, hinges)
            home[part.name] = (body, np.zeros(3))
            members[body] = []
        body, offset = home[part.name]
        members[body].append((part, offset))
    bodies = []
    for name, (parent, position, hinges) in frames.items():
        inertia = combine(p.inertia.scaled(share).shifted(o) for p, o in members[name])
        solids = tuple(_moved(s, o) for p, o in members[name] for s in p.solids)
        contacts = tuple(
            replace(c, position=c.position + o) for p, o in members[name] for c in p.contacts
        )
        bodies.append(Body(name, parent, position, hinges, inertia, solids, contacts))
    return Skeleton(_depth_first(bodies), home, origins)


def _depth_first(bodies: list[Body]) -> tuple[Body, ...]:
    """Return the bodies in the order in which MuJoCo numbers them."""
    children: dict[str, list[Body]] = {}
    for body in bodies:
        children.setdefault(body.parent, []).append(body)
    ordered: list[Body] = []
    stack = children[""][::-1]
    while stack:
        body = stack.pop()
        ordered.append(body)
        stack.extend(children.get(body.name, [])[::-1])
    return tuple(ordered)


def _sided(name: str, side: str) -> str:
    return f"{name}_{side}" if side else name


def _hinge(coordinate: str, side: str, mass_height: float) -> Hinge:
    c = COORDINATES[coordinate]
    factor = mass_height / (REFERENCE_MASS * REFERENCE_HEIGHT)
    return Hinge(
        _sided(coordinate, side),
        c.axis_of(side),
        c.low,
        c.high,
        (factor * c.weakest, factor * c.strongest),
    )


def _moved(solid: Solid, offset: np.ndarray) -> Solid:
    b = solid.b + offset if solid.kind == "capsule" else solid.b
    return replace(solid, a=solid.a + offset, b=b)
