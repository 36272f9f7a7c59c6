"""A fitted skin: its surface, and its pose from those of the bodies."""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.skin.bones import Bones
from plantigrade.skin.fitting import RestingSkin, resting_skin
from plantigrade.skin.surface import Surface, baked_surface

if TYPE_CHECKING:
    from plantigrade.models.human import Human

BODY_DENSITY = 1010.0  # [kg/m³] density of the whole body, lungs half full
BUILD_RANGE = (-0.2, 3.4)
"""Builds that are extrapolated without folds; beyond, girth is scaled. Found by looking."""
IRIS_DEPTH = 0.82  # Share of an eye's depth, from behind, at which its iris begins. Chosen.
VOLUME_TOLERANCE = 1e-4  # Relative error of the volume

N_KEPT_SKINS = 8  # Chosen: pages, pictures and films of one person fit it once.
_KNOWN: dict[tuple, "Skin"] = {}


@dataclass(frozen=True, eq=False)
class Skin:
    """The surface of a person; every bone is rigid, as glTF and graphics cards want it."""

    surface: Surface  #: Faces, weights and garments
    bones: Bones  #: What its bones ride on
    resting: RestingSkin  #: Vertices and bones in the pose of the surface
    #: 0 for thin, 1 average, 2 full, 3 fat: at which it encloses the mass of the person
    build: float

    @staticmethod
    def of(human: "Human", age: str = "young") -> "Skin":
        """Return the skin of a person: lengths of the skeleton, volume of the mass.

        Args:
            age: ``"young"`` or ``"old"``.
        """
        key = human.xml, human.dimensions, human.height, human.mass, human.sex, age
        while key not in _KNOWN:
            if len(_KNOWN) >= N_KEPT_SKINS:
                _KNOWN.pop(next(iter(_KNOWN)))
            _KNOWN[key] = _fitted(human, age)
        return _KNOWN[key]

    @property
    def faces(self) -> Int[Array, "n_faces 3"]:
        """Triangles, outward by the right-hand rule."""
        return self.surface.faces

    @property
    def eyes(self) -> Bool[Array, " n"]:
        """Which vertices belong to an eye."""
        return self.surface.eyes

    def motions(
        self, xpos: Float[Array, "*time n_bodies 3"], xquat: Float[Array, "*time n_bodies 4"]
    ) -> Float[Array, "*time n_bones 3 4"]:
        """Return what moves every bone from the pose of the surface to that of the bodies.

        Args:
            xpos: Positions of all bodies in the world [m].
            xquat: Their orientations, scalar first.
        """
        position, rotation = self.bones.poses(xpos, xquat)
        turned = rotation @ np.swapaxes(self.resting.rotation, -1, -2)
        moved = position - np.einsum("...ij,...j->...i", turned, self.resting.position)
        return np.concatenate([turned, moved[..., None]], axis=-1)

    def posed(
        self, xpos: Float[Array, "n_bodies 3"], xquat: Float[Array, "n_bodies 4"]
    ) -> Float[Array, "n 3"]:
        """Return the vertices in the world, by linear blend skinning [m].

        Args:
            xpos: Positions of all bodies in the world [m].
            xquat: Their orientations, scalar first.
        """
        motions = self.motions(xpos, xquat)[self.surface.bones]
        blended = np.einsum("nk,nkij->nij", self.surface.weights, motions)
        return np.einsum("nij,nj->ni", blended[:, :, :3], self.resting.vertices) + blended[:, :, 3]


def _fitted(human: "Human", age: str) -> Skin:
    from scipy.optimize import brentq

    surface = baked_surface()
    bones = Bones.of(human, surface.bone_names)
    desired = human.mass / BODY_DENSITY

    @cache  # the search asks for its ends again, and so does what follows for where it ended
    def resting(build: float, girth: float) -> RestingSkin:
        return resting_skin(surface, human, bones, build, girth, age)

    @cache
    def excess(build: float, girth: float = 1.0) -> float:
        return enclosed_volume(resting(build, girth).vertices, surface.faces) / desired - 1.0

    low, high = BUILD_RANGE
    build, girth = low, 1.0
    if excess(low) < 0.0 < excess(high):
        build = float(brentq(excess, low, high, xtol=1e-3, rtol=VOLUME_TOLERANCE))  # pyright: ignore
    elif excess(high) <= 0.0:
        build = high
    while abs(off := excess(build, girth)) > VOLUME_TOLERANCE:
        girth /= np.sqrt(1.0 + off)
    return Skin(surface, bones, resting(build, girth), build)


def enclosed_volume(vertices: Float[Array, "n 3"], faces: Int[Array, "n_faces 3"]) -> float:
    """Return the volume within a closed surface [m³].

    Args:
        vertices: Its vertices [m].
        faces: Triangles, outward by the right-hand rule.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
