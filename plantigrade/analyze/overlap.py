"""Overlap of body parts that are not connected by a joint, and of body parts with the ground."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.side_names import split_side

SOLID_GROUP = 1  # Geom group of the solids of the body

CAPSULE_SHARES = np.linspace(-1.0, 1.0, 5)
"""Places along the axis of a capsule that are compared with the ground [half lengths]; between them
only the edge of a tread could enter."""

TRUNK_BODIES = (
    "pelvis",
    "abdomen",
    "torso",
    "lower_thorax",
    "thorax",
    "lower_neck",
    "upper_neck",
    "neck",
)
TRUNK_BODIES += ("head", "clavicle")
BELLY_BODIES = ("abdomen", "torso")
SHOULDER_BODIES = ("torso", "lower_thorax", "thorax", "clavicle", "lower_neck")


@dataclass(frozen=True)
class Overlap:
    """Depth of pairs of bodies in each other."""

    names: tuple[str, ...]  #: Names of the pairs, as ``"tibia_r in tibia_l"``
    depth: Float[Array, "n_frames n_pairs"]  #: Depth, negative if separate [m]


def may_overlap(human: Human, one: str, two: str) -> bool:
    """Return whether the solids of two bodies may overlap.

    These are bodies of one joint, those of the trunk with neck, head and girdles, of a foot with
    its shank, the upper arm with the trunk near its shoulder, and the thigh with the soft belly.
    """
    if one == two:
        return True
    parents = {b.name: b.parent for b in human.skeleton.bodies}
    if parents[one] == two or parents[two] == one:
        return True
    (a, side_a), (b, side_b) = split_side(one), split_side(two)
    if a in TRUNK_BODIES and b in TRUNK_BODIES:
        return True
    for limb, near in (("humerus", SHOULDER_BODIES), ("femur", BELLY_BODIES)):
        if limb in (a, b) and (b if a == limb else a) in near:
            return True
    return side_a == side_b and _of_foot(parents, one) and _of_foot(parents, two)


def _of_foot(parents: dict[str, str], body: str) -> bool:
    """Return whether a body is a shank or a descendant of one."""
    while body and not body.startswith("tibia"):
        body = parents[body]
    return bool(body)


def overlap(
    human: Human,
    position: Float[Array, "n_frames n_bodies 3"],
    rotation: Float[Array, "n_frames n_bodies 3 3"],
) -> Overlap:
    """Return the depth of bodies in each other, pair by pair.

    Args:
        position: Origins of the bodies, the world first [m].
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


def overlap_along(human: Human, qpos: Float[Array, "n_frames nq"]) -> Overlap:
    """Return the depth of bodies in each other in configurations."""
    every = range(human.model.nbody)
    return overlap(human, *body_paths(human, qpos, every))


def ground_overlap(
    human: Human,
    position: Float[Array, "n_frames n_bodies 3"],
    rotation: Float[Array, "n_frames n_bodies 3 3"],
    ground: Ground,
) -> Overlap:
    """Return the depth of bodies in the ground, apart from the feet, whose soles stand on it.

    Args:
        position: Origins of the bodies, the world first [m].
        ground: The ground, at rest.
    """
    model = human.model
    parents = {b.name: b.parent for b in human.skeleton.bodies}
    depth: dict[str, Array] = {}
    turn = np.empty(9)
    for g in np.flatnonzero(model.geom_group == SOLID_GROUP):
        name = human.body_names[int(model.geom_bodyid[g]) - 1]
        if _of_foot(parents, parents[name]):
            continue
        body = int(model.geom_bodyid[g])
        mujoco.mju_quat2Mat(turn, model.geom_quat[g])
        R = rotation[:, body] @ turn.reshape(3, 3)
        centre = position[:, body] + rotation[:, body] @ model.geom_pos[g]
        low = centre[:, None] - _lowest(model, int(g), R, ground.normal)
        deep = (ground.under(low) - low @ ground.normal).max(axis=1)
        depth[name] = np.maximum(depth.get(name, -np.inf), deep)
    names = tuple(f"{name} in the ground" for name in depth)
    return Overlap(names, np.stack(list(depth.values()), axis=1))


def _lowest(
    model: mujoco.MjModel, geom: int, R: Float[Array, "n 3 3"], up: Float[Array, " 3"]
) -> Float[Array, "n k 3"]:
    """Return vectors from candidates for the lowest point of a solid to its centre, world [m]."""
    size, local = model.geom_size[geom], up @ R  # the normal in the axes of the solid
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
        axis = CAPSULE_SHARES[:, None] * [0.0, 0.0, size[1]]
        return axis @ R.swapaxes(1, 2) + size[0] * up
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        support = size**2 * local / np.linalg.norm(size * local, axis=1, keepdims=True)
        return support[:, None] @ R.swapaxes(1, 2)
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    return (signs * size) @ R.swapaxes(1, 2)


def _pairs(human: Human) -> tuple[Array, Array, Array, tuple[str, ...]]:
    """Return pairs of geoms that must not overlap, with index and name of their pair of bodies."""
    model = human.model
    geoms = [g for g in range(model.ngeom) if model.geom_group[g] == SOLID_GROUP]
    names: dict[str, int] = {}
    found = []
    for i, a in enumerate(geoms):
        for b in geoms[i + 1 :]:
            one, two = (human.body_names[int(model.geom_bodyid[g]) - 1] for g in (a, b))
            if not may_overlap(human, one, two):
                found.append((a, b, names.setdefault(f"{one} in {two}", len(names))))
    table = np.array(found, int).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2], tuple(names)
