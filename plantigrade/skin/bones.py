"""Bones of the skin: which part each one rides on, and the ones between two parts.

A bone takes its pose from an anatomical part of the skeleton, so that one surface serves every
joint set and every foot: a part that a body lacks is welded to its parent there. Linear skinning
alone wrings a forearm and thins a deeply bent knee. Three bones a side therefore turn half-way
between their neighbours, and two leave out the twist about the limb's long axis, which then
spreads along the upper arm and the thigh. The shoulder turns by a third of the upper arm's swing,
as the shoulder blade does; half of it folds the deltoid over the girdle.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import rotation_matrix

if TYPE_CHECKING:
    from plantigrade.models.human import Human

UNTWISTED, HALF_WAY, THIRD = 1, 2, 3
"""How a bone's orientation follows from two others: without twist, or by a share of the angle."""
PART_OF = {
    "shoulder": "humerus",
    "humerus0": "humerus",
    "elbow": "ulna",
    "forearm": "radius",
    "hip": "femur",
    "femur0": "femur",
    "knee": "tibia",
}
"""Part that gives the position of a bone between two parts."""


@dataclass(frozen=True, eq=False)
class Bones:
    """The bones of a skin on the bodies of a person."""

    body: Int[Array, " n_bones"]  #: Body that each bone rides on, by its index in MuJoCo
    offset: Float[Array, "n_bones 3"]  #: Its origin in the frame of this body [m]
    #: How orientations between two bones are made, in this order: what it is, the bone, and the two
    #: it follows from
    recipes: tuple[tuple[int, int, int, int], ...]
    #: The same in the pose of the surface, where the forearm is not one part, and the shoulder is
    #: half-way, for hanging arms without folds
    resting_recipes: tuple[tuple[int, int, int, int], ...]

    @staticmethod
    def of(human: "Human", names: tuple[str, ...]) -> "Bones":
        """Return bones by their names on a person."""
        parts = [_part(human, name) for name in names]
        at = {name: i for i, name in enumerate(names)}
        recipes, shoulders, whole_forearm = [], [], []
        for s in ("_l", "_r"):
            if _part(human, "ulna" + s)[0] == _part(human, "radius" + s)[0]:
                whole_forearm.append((UNTWISTED, "ulna" + s, "humerus" + s, "radius" + s))
            recipes += [
                (UNTWISTED, "humerus0" + s, "thorax", "humerus" + s),
                (UNTWISTED, "femur0" + s, "pelvis", "femur" + s),
                (HALF_WAY, "forearm" + s, "ulna" + s, "radius" + s),
                (HALF_WAY, "elbow" + s, "humerus" + s, "ulna" + s),
                (HALF_WAY, "knee" + s, "femur" + s, "tibia" + s),
                (HALF_WAY, "hip" + s, "pelvis", "femur0" + s),
            ]
            shoulders.append(("shoulder" + s, "thorax", "humerus0" + s))

        def by_index(rows):
            return tuple((kind, at[to], at[a], at[b]) for kind, to, a, b in rows)

        return Bones(
            body=np.array([human.body(body) for body, _ in parts]),
            offset=np.array([offset for _, offset in parts]),
            recipes=by_index(whole_forearm + recipes + [(THIRD, *row) for row in shoulders]),
            resting_recipes=by_index(recipes + [(HALF_WAY, *row) for row in shoulders]),
        )

    def poses(
        self, xpos: Float[Array, "*time n_bodies 3"], xquat: Float[Array, "*time n_bodies 4"]
    ) -> tuple[Float[Array, "*time n_bones 3"], Float[Array, "*time n_bones 3 3"]]:
        """Return positions [m] and orientations of the bones in the world.

        Args:
            xpos: Positions of all bodies in the world [m].
            xquat: Their orientations, scalar first.
        """
        rotation = rotation_matrix(xquat)[..., self.body, :, :]
        position = xpos[..., self.body, :] + np.einsum("...ij,...j->...i", rotation, self.offset)
        return position, completed(rotation, self.recipes)


def completed(
    rotation: Float[Array, "*time n_bones 3 3"], recipes: tuple[tuple[int, int, int, int], ...]
) -> Float[Array, "*time n_bones 3 3"]:
    """Return orientations with those between two bones made from them."""
    rotation = rotation.copy()
    for kind, to, first, second in recipes:
        relative = np.swapaxes(rotation[..., first, :, :], -1, -2) @ rotation[..., second, :, :]
        turned = _untwisted(relative) if kind == UNTWISTED else _share(relative, 1.0 / kind)
        rotation[..., to, :, :] = rotation[..., first, :, :] @ turned
    return rotation


def _part(human: "Human", bone: str) -> tuple[str, np.ndarray]:
    """Return body and offset of the part that a bone rides on; parts of the toes may be one."""
    stem, _ = split_side(bone)
    side = bone.removeprefix(stem)
    parts, name = human.skeleton.parts, PART_OF.get(stem, stem) + side
    if name not in parts and "phalanges" in stem and "toes" + side in parts:
        name = "toes" + side
    return parts[name if name in parts else "foot" + side]


def _share(rotation: Array, share: float) -> Array:
    """Return rotations by a share of their angle."""
    from scipy.spatial.transform import Rotation

    vector = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_rotvec()
    return Rotation.from_rotvec(share * vector).as_matrix().reshape(rotation.shape)


def _untwisted(rotation: Array) -> Array:
    """Return the swing S of rotations S T, T about z."""
    from scipy.spatial.transform import Rotation

    whole = Rotation.from_matrix(rotation.reshape(-1, 3, 3))
    twist = whole.as_quat() * [0.0, 0.0, 1.0, 1.0]
    twist[np.linalg.norm(twist, axis=1) < 1e-9] = [0.0, 0.0, 0.0, 1.0]
    return (whole * Rotation.from_quat(twist).inv()).as_matrix().reshape(rotation.shape)
