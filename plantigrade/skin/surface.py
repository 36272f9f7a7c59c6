"""The baked surface: sixteen bodies of one mesh, its bones, weights and garments.

The file holds the left half; it is mirrored when read. Bodies differ by sex, age and build; a build
of 0 is thin, 1 average, 2 full, 3 fat (body mass indices of 12, 19, 22 and 33 kg/m² for women, 14,
21, 23 and 40 kg/m² for men). Axes are x forward, y left, z up.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int

SEXES, AGES, N_BUILDS = ("female", "male"), ("young", "old"), 4
"""Order of the baked bodies: sex, age, build."""
MIRRORED = np.array([1.0, -1.0, 1.0])  # Factors that map a point to the other side
GARMENT_STEP = 0.002  # [m] step in which the distance to a hem is stored


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface of a dressed person, and the bones that move it."""

    bodies: Float[Array, "n_bodies n 3"]  #: Vertices of every body [m]
    faces: Int[Array, "n_faces 3"]  #: Triangles, outward by the right-hand rule
    bone_names: tuple[str, ...]  #: Names of the bones
    bones: Int[Array, "n 4"]  #: The four bones of every vertex, by index
    weights: Float[Array, "n 4"]  #: Their weights, which add up to 1
    eyes: Bool[Array, " n"]  #: Which vertices belong to an eye
    garments: Float[Array, "n 2"]  #: Distance inside the shirt and the shorts, negative outside [m]
    #: Joint centres of the left side and the middle, of every body [m]
    joints: Mapping[str, Float[Array, "n_bodies 3"]]

    def blended(
        self, sex: str, build: float, age: str = "young"
    ) -> tuple[Float[Array, "n 3"], dict[str, Float[Array, " 3"]]]:
        """Return vertices and joint centres of one person [m].

        Args:
            sex: ``"female"`` or ``"male"``.
            build: 0 for thin, 1 average, 2 full, 3 fat; beyond these it is extrapolated.
            age: ``"young"`` or ``"old"``.
        """
        first = (SEXES.index(sex) * len(AGES) + AGES.index(age)) * N_BUILDS
        lower = int(np.clip(np.floor(build), 0, N_BUILDS - 2))
        share = np.zeros(len(self.bodies))
        share[first + lower], share[first + lower + 1] = lower + 1 - build, build - lower
        joints = {name: share @ centre for name, centre in self.joints.items()}
        return np.tensordot(share, self.bodies, 1), joints


def weights_in_255ths(
    bones: Int[Array, "n 4"], weights: Float[Array, "n 4"]
) -> tuple[Int[Array, "n 4"], Int[Array, "n 4"]]:
    """Return bones and their weights as bytes: 255 in all, and bone 0 where there is no weight."""
    whole = np.rint(255 * weights).astype(int)
    whole[np.arange(len(whole)), weights.argmax(axis=1)] += 255 - whole.sum(axis=1)
    return np.where(whole > 0, bones, 0), whole


@cache
def baked_surface() -> Surface:
    """Return the surface of the package."""
    with resources.files("plantigrade.skin").joinpath("surface.npz").open("rb") as file:
        baked = dict(np.load(file))
    # Bodies are stored as differences from one to the next, in 16-bit steps.
    words = np.cumsum(baked["delta"].astype(np.int64), axis=0) % 65536
    half = words.transpose(0, 2, 1) * baked["step"] + baked["low"]
    seam = baked["seam"]
    half[:, seam, 1] = 0.0
    n, faces = half.shape[1], baked["faces"].astype(int)
    twin = np.where(seam, np.arange(n), n + np.cumsum(~seam) - 1)
    names = tuple(str(name) for name in baked["bone_names"])
    bones, weights = _both_sides(names, baked["bones"].astype(int), baked["weights"] / 255.0, seam)
    joints = zip(baked["names"], baked["joints"].transpose(1, 0, 2), strict=True)
    return Surface(
        bodies=np.concatenate([half, half[:, ~seam] * MIRRORED], axis=1),
        faces=np.concatenate([faces, twin[faces][:, ::-1]]),
        bone_names=names,
        bones=bones,
        weights=weights,
        eyes=np.concatenate([baked["eye"], baked["eye"][~seam]]).astype(bool),
        garments=GARMENT_STEP * np.concatenate([baked["cloth"], baked["cloth"][~seam]]),
        joints={str(name): centres.astype(float) for name, centres in joints},
    )


def _both_sides(
    names: tuple[str, ...], bones: Array, weights: Array, seam: Array
) -> tuple[Array, Array]:
    """Return bones and weights of both sides; on the seam they are the mean of both."""
    other = {"_l": "_r", "_r": "_l"}
    swap = np.array(
        [names.index(name[:-2] + other[name[-2:]]) if name[-2:] in other else i
         for i, name in enumerate(names)]
    )  # fmt: skip
    rows = np.flatnonzero(seam)
    dense = np.zeros((len(rows), len(names)))
    np.put_along_axis(dense, bones[rows], weights[rows], 1)
    even = (dense + dense[:, swap]) / 2
    top = np.argsort(-even, axis=1, kind="stable")[:, :4]
    share = np.take_along_axis(even, top, 1)
    mirrored = swap[bones[~seam]], weights[~seam]
    bones, weights = bones.copy(), weights.copy()
    bones[rows], weights[rows] = top, share / share.sum(axis=1, keepdims=True)
    return np.concatenate([bones, mirrored[0]]), np.concatenate([weights, mirrored[1]])
