"""Limbs as capsules and spheres: what of a leg and an arm may meet another part of the body."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.models.loads import load_box
from plantigrade.models.parts import Solid

# [1] radius of a rod relative to half the height of a box whose edge it covers
EDGE_FACTOR = float(np.sqrt(2.0))
MAX_SPHERE_SPACING = 0.025
"""Maximum distance between spheres along an edge of a foot relative to stature [1]; a shank between
them is then about 3 mm closer than computed."""
MEDIAL_DEPTH = 0.012  # [m] depth of the most medial bone considered next to the other foot


@dataclass(frozen=True)
class Rod:
    """A capsule on a body: two ends in the body's frame and a radius [m]."""

    body: str
    a: Float[Array, "3"]
    b: Float[Array, "3"]
    radius: float

    def points(self, count: int) -> list["Rod"]:
        """Return spheres along it, both ends among them."""
        along = np.linspace(0.0, 1.0, count)
        places = [self.a + x * (self.b - self.a) for x in along]
        return [Rod(self.body, p, p, self.radius) for p in places]

    @property
    def distal_half(self) -> "Rod":
        """The part from its middle to its second end."""
        return Rod(self.body, (self.a + self.b) / 2, self.b, self.radius)


def leg_rods(human: Human, side: str) -> tuple[Rod, Rod, list[Rod]]:
    """Return thigh, shank, and what of a foot is next to the other leg."""
    solids = {b.name: b.solids for b in human.skeleton.bodies}
    thigh, shank = (
        _rods(f"{n}_{side}", solids[f"{n}_{side}"], side)[0] for n in ("femur", "tibia")
    )
    feet = []
    for name in _below(human, f"foot_{side}"):
        rods = _rods(name, solids[name], side)
        feet += [(rod, _offset(human, name)) for rod in rods]
    inward = 1.0 if side == "r" else -1.0

    def medial(rod: Rod, offset: Array) -> float:
        return float(max(inward * (offset[1] + x[1]) for x in (rod.a, rod.b)) + rod.radius)

    places = [(medial(rod, offset), rod) for rod, offset in feet]
    by_body: dict[str, float] = {}
    for reach, rod in places:
        by_body[rod.body] = max(reach, by_body.get(rod.body, -np.inf))
    most = max(by_body.values())
    kept = [
        rod
        for reach, rod in places
        if reach > by_body[rod.body] - MEDIAL_DEPTH and by_body[rod.body] > most - 3 * MEDIAL_DEPTH
    ]
    return thigh, shank, kept


def arm_spheres(human: Human, side: str, *, corners: bool = False) -> list[Rod]:
    """Return spheres along an arm; of a hand its end, middle and edges, or all its corners."""
    out: list[Rod] = []
    for name in _below(human, f"humerus_{side}"):
        solids = next(b.solids for b in human.skeleton.bodies if b.name == name)
        for solid in solids:
            if solid.kind == "capsule":  # an upper arm from its middle on: it begins in the trunk
                rod = Rod(name, solid.a, solid.b, solid.radius)
                out += rod.points(7)[3:] if name.startswith("humerus") else rod.points(3)
                continue
            half, thick = solid.b, float(min(solid.b))
            if corners:
                places = [solid.a + half * signs for signs in product((-1.0, 1.0), repeat=3)]
                out += [Rod(name, p, p, 0.0) for p in places]
                continue
            for y in (-1.0, 0.0, 1.0):  # a hand is flat
                place = solid.a + np.array([0.0, y * (half[1] - thick), thick - half[2]])
                out.append(Rod(name, place, place, thick))
    return out


def load_spheres(human: Human, side: str) -> list[Rod]:
    """Return the largest sphere within the box of a load in a hand; none for an empty hand."""
    place = f"hand_{side}"
    if not human.loads.get(place, 0.0):
        return []
    body, centre, half = load_box(human.skeleton, place, human.height)
    return [Rod(body, centre, centre, float(min(half)))]


def free_arm_rods(human: Human, side: str) -> list[Rod]:
    """Return capsules of an arm from the middle of the upper arm on.

    That of a hand is as thick as the hand is wide.
    """
    solids, out = {b.name: b.solids for b in human.skeleton.bodies}, []
    for name in _below(human, f"humerus_{side}"):
        for s in solids[name]:
            if s.kind == "capsule":
                whole = Rod(name, s.a, s.b, s.radius)
                out.append(whole.distal_half if name.startswith("humerus") else whole)
            else:
                _, y, z = s.b
                along = np.array([0.0, 0.0, z - y / 2])
                out.append(Rod(name, s.a - along, s.a + along, float(y)))
    return out


def sphere_count(human: Human, rod: Rod) -> int:
    """Return how many spheres along a rod leave nothing between them."""
    return 1 + int(
        np.ceil(float(np.linalg.norm(rod.b - rod.a)) / (MAX_SPHERE_SPACING * human.height) - 1e-9)
    )


def _rods(name: str, solids: Sequence[Solid], side: str) -> list[Rod]:
    """Return capsules as they are, and of boxes the edge that faces the other leg."""
    out, inward = [], 1.0 if side == "r" else -1.0
    for solid in solids:
        if solid.kind == "capsule":
            out.append(Rod(name, solid.a, solid.b, solid.radius))
        else:
            x, y, z = solid.b
            aside = np.array([0.0, inward * (y - z), 0.0])
            ahead = np.array([x - z, 0.0, 0.0])
            radius = EDGE_FACTOR * float(z)
            out.append(Rod(name, solid.a + aside - ahead, solid.a + aside + ahead, radius))
    return out


def _below(human: Human, body: str) -> list[str]:
    """Return a body and all that hang on it."""
    found = [body]
    for b in human.skeleton.bodies:
        if b.parent in found:
            found.append(b.name)
    return found


def _offset(human: Human, body: str) -> Float[Array, "3"]:
    """Return where a body's origin is in the pelvis frame, zero pose [m]."""
    bodies = {b.name: b for b in human.skeleton.bodies}
    out = np.zeros(3)
    while bodies[body].parent:
        out = out + bodies[body].position
        body = bodies[body].parent
    return out
