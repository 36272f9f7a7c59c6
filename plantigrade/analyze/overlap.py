"""How deep parts of the body are inside each other: solids that do not meet at a joint."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.models.skeleton import split_side

SOLID = 1
"""Group of the geoms that are solids of the body."""

TRUNK = ("pelvis", "abdomen", "torso", "lower_thorax", "thorax", "lower_neck", "upper_neck", "neck")
TRUNK += ("head", "clavicle")
BELLY = ("abdomen", "torso")
SHOULDER = ("torso", "lower_thorax", "thorax", "clavicle", "lower_neck")


@dataclass(frozen=True)
class Overlap:
    """How deep pairs of bodies are inside each other."""

    names: tuple[str, ...]  #: Of the pairs: ``"tibia_r in tibia_l"``
    depth: Float[Array, "n_frames n_pairs"]  #: Depth, negative where they are apart [m]


def meet(human: Human, one: str, two: str) -> bool:
    """Return whether two bodies belong together, so that their solids may overlap.

    These are bodies of one joint, those of the trunk with neck, head and girdles, of a foot with
    its shank, the upper arm with the trunk about its shoulder, and the thigh with the belly: they
    touch where somebody bends down, and both are soft.
    """
    if one == two:
        return True
    parents = {b.name: b.parent for b in human.skeleton.bodies}
    if parents[one] == two or parents[two] == one:
        return True
    (a, side_a), (b, side_b) = split_side(one), split_side(two)
    if a in TRUNK and b in TRUNK:
        return True
    for limb, near in (("humerus", SHOULDER), ("femur", BELLY)):
        if limb in (a, b) and (b if a == limb else a) in near:
            return True
    return side_a == side_b and _of_foot(parents, one) and _of_foot(parents, two)


def _of_foot(parents: dict[str, str], body: str) -> bool:
    """Return whether a body is a shank or hangs on one."""
    while body and not body.startswith("tibia"):
        body = parents[body]
    return bool(body)


def overlap(
    human: Human,
    position: Float[Array, "n_frames n_bodies 3"],
    rotation: Float[Array, "n_frames n_bodies 3 3"],
) -> Overlap:
    """Return how deep bodies are inside each other, pair by pair.

    Args:
        human: The person.
        position: Origins of the bodies, the world first [m].
        rotation: Their rotations.
    """
    model = human.model
    first, second, pair, names = _pairs(human)
    depth = np.full((len(position), len(names)), -np.inf)
    data = mujoco.MjData(model)
    carrier = model.geom_bodyid
    turn = np.empty((model.ngeom, 9))
    for g in range(model.ngeom):
        mujoco.mju_quat2Mat(turn[g], model.geom_quat[g])
    own = turn.reshape(-1, 3, 3)
    centre = position[:, carrier] + np.einsum("ngij,gj->ngi", rotation[:, carrier], model.geom_pos)
    room = np.linalg.norm(centre[:, first] - centre[:, second], axis=2)
    near = room < model.geom_rbound[first] + model.geom_rbound[second]
    for f in np.flatnonzero(near.any(axis=1)):
        data.geom_xpos[:] = centre[f]
        data.geom_xmat[:] = np.matmul(rotation[f, carrier], own).reshape(-1, 9)
        for k in np.flatnonzero(near[f]):
            away = mujoco.mj_geomDistance(model, data, int(first[k]), int(second[k]), 0.01, None)
            depth[f, pair[k]] = max(depth[f, pair[k]], -away)
    return Overlap(names, depth)


def _pairs(human: Human) -> tuple[Array, Array, Array, tuple[str, ...]]:
    """Return geoms that must not overlap, which pair of bodies each belongs to, and its name."""
    model = human.model
    geoms = [g for g in range(model.ngeom) if model.geom_group[g] == SOLID]
    names: dict[str, int] = {}
    found = []
    for i, a in enumerate(geoms):
        for b in geoms[i + 1 :]:
            one, two = (human.body_names[int(model.geom_bodyid[g]) - 1] for g in (a, b))
            if not meet(human, one, two):
                found.append((a, b, names.setdefault(f"{one} in {two}", len(names))))
    table = np.array(found, int).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2], tuple(names)
