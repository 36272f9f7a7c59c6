"""Loads that a person carries: rigid boxes on the back, around the waist, in hands, on the legs.

A load moves with the segment that carries it. It belongs to the masses of the model, and not to the
mass of the person, which strengths and body weights refer to.
"""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import MAX_LOAD, SIDES
from plantigrade.errors import ParameterError, known_names
from plantigrade.models.parts import Inertia, block, combine
from plantigrade.models.skeleton import Skeleton

REFERENCE_HEIGHT = 1.75  # [m] stature of the person whom the following lengths belong to
ON_TRUNK = {
    "back": ("thorax", (-0.2, 0.0, 0.1), (0.12, 0.15, 0.22)),
    "waist": ("pelvis", (-0.07, 0.0, 0.05), (0.12, 0.16, 0.06)),
}
ON_LIMBS = {
    "hand": ("hand", (0.0, 0.0, -0.12), (0.1, 0.1, 0.1)),
    "thigh": ("femur", (0.0, 0.0, -0.22), (0.09, 0.09, 0.08)),
    "shank": ("tibia", (0.0, 0.0, -0.21), (0.07, 0.07, 0.08)),
    "foot": ("foot", (0.05, 0.0, -0.03), (0.08, 0.05, 0.03)),
}
PLACES = ON_TRUNK | {
    f"{place}_{side}": (f"{part}_{side}", *box)
    for place, (part, *box) in ON_LIMBS.items()
    for side in SIDES
}
"""Place of a load → the part that carries it, its centre in the frame of that part, and its half
sizes along x, y and z [m]: a rucksack against the back, a belt, a box that hangs in a hand, sleeves
around the middle of thigh and shank, a weight on the instep."""


def check_loads(loads: Mapping[str, float]) -> None:
    """Refuse loads that cannot be carried."""
    for place, mass in loads.items():
        if place not in PLACES:
            raise ParameterError(f"no load on {place!r}; {known_names(place, list(PLACES))}")
        if not 0.0 <= mass <= MAX_LOAD:
            raise ParameterError(f"a load on {place} is 0 to {MAX_LOAD:g} kg, not {mass:g}")


def loaded(skeleton: Skeleton, loads: Mapping[str, float], height: float) -> dict[str, Inertia]:
    """Return the inertia of every body that carries a load, with the load, by name.

    Args:
        loads: Place, one of :data:`PLACES` → mass [kg].
        height: Stature [m].
    """
    found = {b.name: b.inertia for b in skeleton.bodies}
    changed = {}
    for place, mass in loads.items():
        body, at, half = load_box(skeleton, place, height)
        found[body] = changed[body] = combine([found[body], block(mass, at, half)])
    return changed


def load_box(
    skeleton: Skeleton, place: str, height: float
) -> tuple[str, Float[Array, " 3"], Float[Array, " 3"]]:
    """Return the body that carries a load, and centre and half sizes of its box there [m].

    Args:
        place: One of :data:`PLACES`.
        height: Stature [m].
    """
    part, centre, half = PLACES[place]
    body, origin = skeleton.parts[part]
    return body, origin + np.array(centre) * (height / REFERENCE_HEIGHT), np.array(half)
