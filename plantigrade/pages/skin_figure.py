"""A dressed person in motion, cut into parts whose outlines pictures draw."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.models import Human
from plantigrade.pages.camera import Camera
from plantigrade.pages.scene import assumed_bodies
from plantigrade.pages.silhouette import silhouettes
from plantigrade.record import Record
from plantigrade.side_names import split_side
from plantigrade.skin import Skin
from plantigrade.skin.dressed import DressedMesh, dressed_mesh

SHARED = 0.15
"""Weight of a part's bones from which a triangle belongs to it; neighbours overlap. Chosen."""

KEPT = 2  # people whose triangles are kept: one run draws the same person a dozen times


@dataclass(frozen=True)
class DrawnPart:
    """A part of the body with an outline of its own."""

    name: str  #: Its name
    limb: str  #: Limb whose rim it shares
    bones: tuple[str, ...]  #: How the names of its bones begin
    materials: tuple[str, ...]  #: Materials of its triangles
    count: int  #: Control points of its outline
    garment: bool = False  #: Whether it covers other parts

    @property
    def side(self) -> str:
        """``"r"``, ``"l"``, or empty for the middle."""
        return split_side(self.name)[1]

    @property
    def is_foot(self) -> bool:
        """Whether it is a foot."""
        return self.name.startswith("foot")


HEAD_BONES = ("head", "upper_neck", "lower_neck", "thorax", "clavicle_r", "clavicle_l")
FOOT_BONE_NAMES = ("foot", "heel", "lateral_metatarsal", "medial_phalanges", "lateral_phalanges")


def _both(
    name: str, limb: str, bones: tuple[str, ...], material: str, count: int
) -> list[DrawnPart]:
    return [
        DrawnPart(
            f"{name}_{side}",
            f"{limb}_{side}",
            tuple(f"{bone}_{side}" for bone in bones),
            (material if material == "skin" else f"{material}_{side}",),
            count,
            material != "skin",
        )
        for side in "rl"
    ]


PARTS = (
    DrawnPart("head", "trunk", HEAD_BONES, ("skin", "eye", "iris"), 34),
    DrawnPart("shirt", "trunk", (), ("shirt",), 36, garment=True),
    *_both("shorts", "leg", (), "shorts", 26),
    *_both("thigh", "leg", ("femur0", "femur", "knee"), "skin", 18),
    *_both("shank", "leg", ("knee", "tibia"), "skin", 20),
    *_both("foot", "leg", FOOT_BONE_NAMES, "skin", 22),
    *_both("sleeve", "arm", (), "sleeve", 24),
    *_both("upper_arm", "arm", ("humerus", "elbow", "ulna"), "skin", 16),
    *_both("forearm", "arm", ("ulna", "forearm", "radius"), "skin", 16),
    *_both("hand", "arm", ("hand", "fingers"), "skin", 26),
)
"""Parts of a dressed person."""


@dataclass(frozen=True, eq=False)
class SkinFigure:
    """The skin of a person, cut into parts, in motion."""

    skin: Skin  #: The skin
    human: Human  #: The person
    mesh: DressedMesh  #: Its triangles, dressed
    positions: Float[Array, "n nbody 3"]  #: World position of each body in each frame [m]
    quats: Float[Array, "n nbody 4"]  #: World rotation of each body, ``wxyz``
    pale: frozenset[str] = frozenset()  #: Bodies that are drawn paler

    @staticmethod
    def of(
        human: Human,
        positions: Float[Array, "n nbody 3"],
        quats: Float[Array, "n nbody 4"],
        pale: Collection[str] = (),
    ) -> "SkinFigure":
        """Return the figure of a person whose bodies are where they are given."""
        skin = Skin.of(human)
        return SkinFigure(skin, human, _dressed(skin), positions, quats, frozenset(pale))

    def frames(self, part: slice) -> "SkinFigure":
        """Return some of its frames."""
        return replace(self, positions=self.positions[part], quats=self.quats[part])

    @cached_property
    def vertices(self) -> Float[Array, "n n_vertices 3"]:
        """Vertices in the world in each frame [m]."""
        motions = self.skin.motions(self.positions, self.quats)
        return np.array([self.mesh.posed(each) for each in motions])

    def faces(self, part: DrawnPart) -> Int[Array, "n_faces 3"]:
        """Return the triangles of a part."""
        used, corners = _triangles(self.skin, self.mesh, part)
        return used[corners]

    def is_pale(self, part: DrawnPart) -> bool:
        """Return whether most of a part rides on bodies that are drawn paler."""
        if not self.pale:
            return False
        bodies = {self.human.body(name) for name in self.pale}
        riding = np.isin(self.skin.bones.body, list(bodies))
        used, _ = _triangles(self.skin, self.mesh, part)
        share = (self.mesh.weights[used] * riding[self.mesh.bones[used]]).sum(axis=1)
        return float(share.mean()) > 0.5

    def outlines(
        self, part: DrawnPart, centre: Float[Array, "n 3"], camera: Camera, grain: float
    ) -> tuple[Float[Array, "n count 2"], float]:
        """Return the outline of a part in every frame, and its mean distance towards the reader.

        Args:
            centre: Point at which the camera looks in each frame, world [m].
            grain: Step of the grid on which the outline is found [m].
        """
        used, corners = _triangles(self.skin, self.mesh, part)
        vertices = self.vertices[:, used] - centre[:, None]
        return outlines_of(vertices, corners, camera, part.count, grain)


@lru_cache(maxsize=KEPT)
def _dressed(skin: Skin) -> DressedMesh:
    return dressed_mesh(skin)


@lru_cache(maxsize=KEPT)
def _shares(skin: Skin, mesh: DressedMesh) -> Float[Array, "n_faces n_bones"]:
    """Return the weight of each bone in each triangle."""
    dense = np.zeros((len(mesh.vertices), len(skin.surface.bone_names)))
    np.put_along_axis(dense, mesh.bones, mesh.weights, axis=1)
    return dense[mesh.faces].mean(axis=1)


@lru_cache(maxsize=KEPT * len(PARTS))
def _triangles(
    skin: Skin, mesh: DressedMesh, part: DrawnPart
) -> tuple[Int[Array, " n_used"], Int[Array, "n_faces 3"]]:
    """Return the vertices that a part uses, and its triangles, which count among these."""
    own = np.isin(mesh.materials, part.materials)
    if part.bones:
        names = np.array(skin.surface.bone_names)
        own &= _shares(skin, mesh)[:, np.isin(names, part.bones)].sum(axis=1) > SHARED
    used, corners = np.unique(mesh.faces[own], return_inverse=True)
    return used, corners.reshape(-1, 3)


def skin_of(
    record: Record, positions: Float[Array, "n nbody 3"], quats: Float[Array, "n nbody 4"]
) -> SkinFigure | None:
    """Return the skin of the person of a record; None where the body is no person's.

    Args:
        positions: World position of each body in each frame [m].
        quats: World rotation of each body, ``wxyz``.
    """
    if type(record.human) is not Human:
        return None
    return SkinFigure.of(record.human, positions, quats, assumed_bodies(record))


def outlines_of(
    vertices: Float[Array, "n n_vertices 3"],
    faces: Int[Array, "n_faces 3"],
    camera: Camera,
    count: int,
    grain: float,
) -> tuple[Float[Array, "n count 2"], float]:
    """Return the outline of a moving surface in every frame, and how near it is on average [m].

    Args:
        vertices: Vertices relative to what the camera looks at, in every frame [m].
        count: Control points of the outline.
        grain: Step of the grid on which the outline is found [m].
    """
    found = silhouettes(camera.project(vertices), faces, count, grain)
    return found, float((vertices @ camera.towards).mean())
