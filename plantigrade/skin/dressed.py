"""The skin with its garments as one mesh: hems cut into the triangles, a material for each.

Colours of vertices would fray a hem, so triangles are divided where a garment ends. A page that
colours every pixel needs none of this.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.skin.skin import IRIS_DEPTH, Skin

MATERIALS = ("skin", "shirt", "sleeve_r", "sleeve_l", "shorts_r", "shorts_l", "eye", "iris")
"""Materials of a dressed person; sleeves and shorts differ by side."""
ARM = ("shoulder", "humerus", "elbow", "ulna", "forearm", "radius")
"""How the names of the bones in a sleeve begin."""


@dataclass(frozen=True, eq=False)
class DressedMesh:
    """Triangles of a dressed person in the pose of the surface."""

    vertices: Float[Array, "n 3"]  #: Vertices, pelvis frame [m]
    bones: Int[Array, "n 4"]  #: The four bones of every vertex, by index
    weights: Float[Array, "n 4"]  #: Their weights, which add up to 1
    faces: Int[Array, "n_faces 3"]  #: Triangles, outward by the right-hand rule
    materials: Array  #: Material of every triangle, one of :data:`MATERIALS`

    def posed(self, motions: Float[Array, "n_bones 3 4"]) -> Float[Array, "n 3"]:
        """Return the vertices in the world, by linear blend skinning [m].

        Args:
            motions: What moves every bone (:meth:`plantigrade.skin.Skin.motions`).
        """
        blended = np.einsum("nk,nkij->nij", self.weights, motions[self.bones])
        return np.einsum("nij,nj->ni", blended[:, :, :3], self.vertices) + blended[:, :, 3]


@dataclass(frozen=True)
class _Mesh:
    """Triangles whose vertices may be divided: places, shares of all bones, garments."""

    vertices: Float[Array, "n 3"]
    shares: Float[Array, "n n_bones"]
    garments: Float[Array, "n 2"]
    faces: Int[Array, "n_faces 3"]


def dressed_mesh(skin: Skin) -> DressedMesh:
    """Return a skin with the hems of its garments cut into the triangles."""
    baked, vertices = skin.surface, skin.resting.vertices
    shares = np.zeros((len(vertices), len(baked.bone_names)))
    np.put_along_axis(shares, baked.bones, baked.weights, axis=1)
    mesh = _Mesh(vertices, shares, np.asarray(baked.garments, dtype=float), skin.faces)
    for garment in range(2):
        mesh = _cut(mesh, garment)
    materials = _materials(mesh, baked.bone_names, np.asarray(baked.eyes))
    return DressedMesh(mesh.vertices, *_four_bones(mesh.shares), mesh.faces, materials)


def _materials(mesh: _Mesh, bones: tuple[str, ...], eyes: Array) -> Array:
    """Return the material of every triangle."""
    eye = np.asarray((mesh.faces < len(eyes)).all(axis=1))
    eye[eye] = eyes[mesh.faces[eye]].all(axis=1)
    shirt, shorts = (mesh.garments[mesh.faces].sum(axis=1) > 0).T
    left = mesh.vertices[mesh.faces, 1].mean(axis=1) > 0
    most = np.array(bones)[mesh.shares[mesh.faces].sum(axis=1).argmax(axis=1)]
    sleeve = np.char.startswith(most[:, None], np.array(ARM)).any(axis=1)
    kinds = np.full(len(mesh.faces), "skin", dtype="U8")
    kinds[shirt] = "shirt"
    kinds[shirt & sleeve] = np.where(left, "sleeve_l", "sleeve_r")[shirt & sleeve]
    kinds[shorts] = np.where(left, "shorts_l", "shorts_r")[shorts]
    kinds[eye] = "eye"
    ahead = mesh.vertices[mesh.faces, 0].mean(axis=1)
    if eye.any():
        low, high = ahead[eye].min(), ahead[eye].max()
        kinds[eye & (ahead > low + IRIS_DEPTH * (high - low))] = "iris"
    return kinds


def _cut(mesh: _Mesh, garment: int) -> _Mesh:
    """Return the mesh with the triangles across a hem divided there."""
    level = mesh.garments[:, garment]
    inside = level > 0
    count = inside[mesh.faces].sum(axis=1)
    whole = mesh.faces[(count == 0) | (count == 3)]
    new: dict[tuple[int, int], int] = {}
    edges: list[tuple[int, int, float]] = []

    def divided(a: int, b: int) -> int:
        low, high = min(a, b), max(a, b)
        if (low, high) not in new:
            new[low, high] = len(level) + len(edges)
            edges.append((low, high, float(level[low] / (level[low] - level[high]))))
        return new[low, high]

    pieces = []
    for face in mesh.faces[(count == 1) | (count == 2)].tolist():
        lone = inside[face].sum() == 1
        k = next(k for k in range(3) if inside[face[k]] == lone)
        a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
        p, q = divided(a, b), divided(a, c)
        pieces += [[a, p, q], [p, b, c], [p, c, q]]
    if not edges:
        return mesh
    low, high, share = (np.array(column) for column in zip(*edges, strict=True))
    low, high, share = low.astype(int), high.astype(int), share[:, None]

    def extended(values: Array) -> Array:
        return np.concatenate([values, (1 - share) * values[low] + share * values[high]])

    garments = extended(mesh.garments)
    garments[len(level) :, garment] = 0.0
    faces = np.concatenate([whole, np.array(pieces)])
    return _Mesh(extended(mesh.vertices), extended(mesh.shares), garments, faces)


def _four_bones(shares: Float[Array, "n n_bones"]) -> tuple[Array, Array]:
    """Return the four greatest bones of every vertex and their weights, 1 in all."""
    bones = np.argsort(-shares, axis=1, kind="stable")[:, :4]
    kept = np.take_along_axis(shares, bones, axis=1)
    return bones, kept / kept.sum(axis=1, keepdims=True)
