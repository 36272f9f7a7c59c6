"""The surface with the lengths of a person, and the pose of every bone in it.

The surface keeps the pose of its origin, arms out and elbows bent, because linear skinning is best
about the middle of what joints do. Each bone maps its surroundings: limbs are stretched along and
across their bone, trunk and head follow the levels of hips, shoulders, neck and vertex, a foot
follows heel, ankle, balls and toes. A vertex is the weighted mean of the maps of its bones.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models.feet import point, sphere_radius
from plantigrade.skin.bones import Bones, completed
from plantigrade.skin.surface import MIRRORED, Surface
from plantigrade.spatial.conventions import axes_along

if TYPE_CHECKING:
    from plantigrade.models.anatomy import Dimensions
    from plantigrade.models.human import Human

HIP_OFFSET, WAIST_OFFSET, SHOULDER_OFFSET = 0.022, -0.006, 0.008  # [statures]
NECK_OFFSET, HEAD_OFFSET = -0.012, 0.008  # [statures]
"""How far the surface is moved against the joints at these levels, positive backward at hips and
shoulders, forward elsewhere. With them it is 13 mm RMS off the skin landmarks of
:mod:`plantigrade.models.landmarks`, whose points stand off 12 mm; without them 22 mm."""
SHOULDER_BLEND = (-0.05, 0.06)
"""Levels about the neck between which girth gives way to stature for breadth [m]. Chosen."""
ANKLE_MARGIN = 0.02  # How far below the ankle the surface is all foot [m]. Chosen.
ARM_CLEARANCE = 0.025
"""Distance before hanging arms from which trunk and thighs get narrower [m]. Chosen: mass goes
forward and back instead of through the arms."""
NARROWING_DEPTH = (0.10, 0.22)
"""Distance below the shoulders over which this begins [m]. Chosen."""
ARM_ABDUCTION = 0.14
"""Abduction of a hanging arm, as in :meth:`plantigrade.models.Human.standing` [rad]."""
TRUNK_BONES = ("pelvis", "abdomen", "lower_thorax", "thorax", "lower_neck", "upper_neck", "head")
LIMB_PARTS = ("femur", "tibia", "foot", "clavicle", "humerus", "ulna", "hand", "fingers")

ARM_BONES = (
    "shoulder",
    "humerus0",
    "humerus",
    "elbow",
    "ulna",
    "forearm",
    "radius",
    "hand",
    "fingers",
)

Map = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class RestingSkin:
    """A surface with the lengths of a person."""

    vertices: Float[Array, "n 3"]  #: Its vertices, pelvis frame [m]
    position: Float[Array, "n_bones 3"]  #: Origin of every bone in it [m]
    turns: Float[Array, "n_bones 3 3"]  #: Orientation of bones in it, in that of the zero pose
    recipes: tuple[
        tuple[int, int, int, int], ...
    ]  #: How those between two bones are made from them

    @cached_property
    def rotation(self) -> Float[Array, "n_bones 3 3"]:
        """Orientation of every bone in it, in that of the zero pose."""
        return completed(self.turns, self.recipes)


@dataclass(frozen=True, eq=False)
class _Shape:
    """Person, blended surface and scales that all parts of the fit use."""

    human: "Human"
    vertices: Array
    joints: Mapping[str, Array]
    girth: float

    @property
    def dimensions(self) -> "Dimensions":
        return self.human.dimensions

    @property
    def lowest(self) -> float:
        return float(self.vertices[:, 2].min())

    @property
    def highest(self) -> float:
        return float(self.vertices[:, 2].max())

    @property
    def stature(self) -> float:
        """Stature of the surface before it is scaled [m]."""
        return self.highest - self.lowest

    @property
    def scale(self) -> float:
        """Factor to the stature of the person."""
        return self.human.height / self.stature

    @property
    def breadth(self) -> float:
        """Factor across the limbs."""
        return self.girth * self.scale

    def origin(self, part: str) -> Array:
        return np.asarray(self.human.skeleton.origins[part], dtype=float)

    @property
    def hip(self) -> Array:
        """Left hip in the surface: those of its rig are too far apart and too far forward."""
        x, _, z = self.joints["l-upper-leg"]
        lateral = self.origin("femur_l")[1] / self.breadth
        return np.array([x + HIP_OFFSET * self.stature, lateral, z])

    @property
    def shoulder(self) -> Array:
        """Left shoulder in the surface."""
        return self.joints["l-shoulder"] + [SHOULDER_OFFSET * self.stature, 0.0, 0.0]


def resting_skin(
    surface: Surface, human: "Human", bones: Bones, build: float, girth: float, age: str
) -> RestingSkin:
    """Return the surface with the lengths of a person.

    Args:
        build: From thin to fat, see :mod:`plantigrade.skin.surface`.
        girth: Factor across the limbs, besides that of the stature.
        age: ``"young"`` or ``"old"``.
    """
    vertices, joints = surface.blended(human.sex, build, age)
    shape = _Shape(human, vertices, joints, girth)
    placed = _trunk(shape)
    for side, mirrored in (("_l", np.ones(3)), ("_r", MIRRORED)):
        trunk = placed["thorax"][2]
        parts = {**_arm(shape, mirrored, trunk), **_leg(shape, mirrored)}
        placed |= {name + side: pose for name, pose in parts.items()}
    poses = [placed[name] for name in surface.bone_names]
    places, turns = (np.array([pose[k] for pose in poses]) for k in range(2))
    maps = {id(mapping): mapping for _, _, mapping in poses}  # bones share them
    number = {each: k for k, each in enumerate(maps)}
    mapped = np.stack([mapping(vertices) for mapping in maps.values()])
    own = np.array([number[id(mapping)] for _, _, mapping in poses])[surface.bones]
    rows = np.arange(len(vertices))[:, None]
    fitted = np.einsum("nk,nkd->nd", surface.weights, mapped[own, rows])
    fitted = _beside_arms(fitted, surface, placed)
    return RestingSkin(fitted, places, turns, bones.resting_recipes)


def _beside_arms(vertices: Array, surface: Surface, placed: Mapping[str, tuple]) -> Array:
    """Return the surface with trunk and thighs between arms that hang."""
    arms = [name[:-2] in ARM_BONES for name in surface.bone_names]
    on_arm = (surface.weights * np.array(arms)[surface.bones]).sum(axis=1)
    shoulder, elbow = placed["humerus_l"][0], placed["ulna_l"][0]
    axis = (elbow - shoulder) / _length(elbow - shoulder)
    upper = surface.weights[:, 0] * (surface.bones[:, 0] == surface.bone_names.index("humerus_l"))
    away = vertices[upper > 0.5] - shoulder
    radius = float(np.linalg.norm(away - np.outer(away @ axis, axis), axis=1).mean())
    below = shoulder[2] - vertices[:, 2]
    limit = shoulder[1] + np.tan(ARM_ABDUCTION) * below - radius
    free = limit - ARM_CLEARANCE
    over = np.maximum(np.abs(vertices[:, 1]) - free, 0.0)
    narrowed = over - ARM_CLEARANCE * np.tanh(over / ARM_CLEARANCE)
    share = np.clip((below - NARROWING_DEPTH[0]) / np.ptp(NARROWING_DEPTH), 0.0, 1.0) * (1 - on_arm)
    y = vertices[:, 1] - np.sign(vertices[:, 1]) * share * narrowed
    return np.stack([vertices[:, 0], y, vertices[:, 2]], axis=1)


def _trunk(shape: _Shape) -> dict[str, tuple[Array, Array, Map]]:
    """Return the poses of trunk, neck and head, and the one map that they share.

    Height is piecewise linear through hips, shoulders, the joint under C7 and the vertex, so that
    the stature is exact; forward offsets follow the same levels.
    """
    human, joints, scale, breadth = shape.human, shape.joints, shape.scale, shape.breadth
    hip, shoulder, neck = shape.hip, shape.shoulder, joints["neck"]
    femur, humerus = shape.origin("femur_l"), shape.origin("humerus_l")
    sole = shape.origin("foot_l")[2] - human.dimensions.ankle_height
    lower_neck = shape.origin("lower_neck")
    levels = np.array([hip[2], shoulder[2], neck[2], shape.highest])
    heights = np.array([femur[2], humerus[2], lower_neck[2], sole + human.height])
    at_hip, at_shoulder = femur[0] - breadth * hip[0], humerus[0] - breadth * shoulder[0]
    at_neck = lower_neck[0] - scale * neck[0]
    waist, head = (hip[2] + shoulder[2]) / 2, neck[2] + 0.6 * (shape.highest - neck[2])
    shift_levels = np.array([hip[2], waist, shoulder[2], neck[2], head])
    shifts = np.array(
        [
            at_hip,
            (at_hip + at_shoulder) / 2 + WAIST_OFFSET * human.height,
            at_shoulder,
            at_neck + NECK_OFFSET * human.height,
            at_neck + HEAD_OFFSET * human.height,
        ]
    )
    blend = neck[2] + np.array(SHOULDER_BLEND)

    def mapping(x: Array) -> Array:
        z = np.interp(x[:, 2], levels, heights)
        z += scale * (np.minimum(x[:, 2] - levels[0], 0.0) + np.maximum(x[:, 2] - levels[3], 0.0))
        wide = np.interp(x[:, 2], blend, [breadth, scale])
        forward = wide * x[:, 0] + np.interp(x[:, 2], shift_levels, shifts)
        return np.stack([forward, wide * x[:, 1], z], axis=1)

    return {name: (shape.origin(name), np.eye(3), mapping) for name in TRUNK_BONES}


def _arm(shape: _Shape, side: Array, trunk: Map) -> dict[str, tuple[Array, Array, Map]]:
    """Return the poses and maps of one arm, by bone."""
    d = shape.dimensions
    joint = {name: centre * side for name, centre in shape.joints.items()}
    origin = {part: shape.origin(f"{part}_l") * side for part in LIMB_PARTS}
    lateral, down = np.array([0.0, side[1], 0.0]), np.array([0.0, 0.0, -1.0])
    shoulder, elbow, wrist = shape.shoulder * side, joint["l-elbow"], joint["l-hand"]
    upper, fore, palm = elbow - shoulder, wrist - elbow, joint["l-finger-3-1"] - wrist
    zero_upper = origin["ulna"] - origin["humerus"]
    bend, zero_bend = np.cross(upper, fore), np.cross(zero_upper, [1.0, 0.0, 0.0])
    thumb = joint["l-finger-2-1"] - joint["l-finger-5-1"]
    along = _stretch(upper, _length(zero_upper) / _length(upper), shape.breadth)
    along_fore = _stretch(fore, d.forearm / _length(fore), shape.breadth)
    at_shoulder = origin["humerus"]
    at_elbow = at_shoulder + along @ upper
    at_wrist = at_elbow + along_fore @ fore
    finger = joint["l-finger-3-4"] - joint["l-finger-3-1"]
    hand_size = np.eye(3) * d.hand / (_length(palm) + _length(finger))
    upper_arm = _turn(upper, bend, zero_upper, zero_bend)
    ulna, radius = _turn(fore, bend, down, zero_bend), _turn(fore, thumb, down, lateral)
    hand = _turn(palm, thumb, down, lateral)
    upper_map = _linear(shoulder, at_shoulder, along)
    fore_map = _linear(elbow, at_elbow, along_fore)
    hand_map = _linear(wrist, at_wrist, hand_size)
    at_fingers = at_wrist + hand @ (origin["fingers"] - origin["hand"])
    return {
        "clavicle": (origin["clavicle"], np.eye(3), trunk),
        **{
            bone: (at_shoulder, upper_arm, upper_map)
            for bone in ("shoulder", "humerus0", "humerus")
        },
        **dict.fromkeys(("elbow", "ulna"), (at_elbow, ulna, fore_map)),
        **dict.fromkeys(("forearm", "radius"), (at_elbow, radius, fore_map)),
        "hand": (at_wrist, hand, hand_map),
        "fingers": (at_fingers, hand, hand_map),
    }


def _leg(shape: _Shape, side: Array) -> dict[str, tuple[Array, Array, Map]]:
    """Return the poses and maps of one leg with its foot, by bone."""
    origin = {part: shape.origin(f"{part}_l") * side for part in LIMB_PARTS}
    lateral = np.array([0.0, side[1], 0.0])
    hip, knee = shape.hip * side, shape.joints["l-knee"] * side
    ankle = shape.joints["l-ankle"] * side
    thigh, shank = knee - hip, ankle - knee
    zero_thigh, zero_shank = origin["tibia"] - origin["femur"], origin["foot"] - origin["tibia"]
    along = _stretch(thigh, _length(zero_thigh) / _length(thigh), shape.breadth)
    along_shank = _stretch(shank, _length(zero_shank) / _length(shank), shape.breadth)
    at_knee = origin["femur"] + along @ thigh
    at_ankle = at_knee + along_shank @ shank
    femur = _turn(thigh, lateral, zero_thigh, lateral)
    tibia = _turn(shank, lateral, zero_shank, lateral)
    thigh_map = _linear(hip, origin["femur"], along)
    shank_map = _linear(knee, at_knee, along_shank)
    return {
        **dict.fromkeys(("hip", "femur0", "femur"), (origin["femur"], femur, thigh_map)),
        **dict.fromkeys(("knee", "tibia"), (at_knee, tibia, shank_map)),
        **_foot(shape, side, at_ankle),
    }


def _foot(shape: _Shape, side: Array, at_ankle: Array) -> dict[str, tuple[Array, Array, Map]]:
    """Return the poses and the map of one foot: piecewise along it, the sole on the ground."""
    d, ankle = shape.dimensions, shape.joints["l-ankle"]
    radius = sphere_radius(d)
    toes = np.array([point(f"toe_{i}", d) for i in range(1, 6)])
    balls = np.array([point(f"metatarsal_{i}", d) for i in range(1, 6)])
    medial, lateral = balls[:, 1].min() - radius, balls[:, 1].max() + radius
    heel, tip = point("heel_back_medial", d)[0] - radius, toes[:, 0].max() + radius
    own = shape.vertices[
        (shape.vertices[:, 2] < ankle[2] - ANKLE_MARGIN) & (shape.vertices[:, 1] > 0)
    ]
    own_low, own_high = own.min(axis=0), own.max(axis=0)
    across = (lateral - medial) / (own_high[1] - own_low[1])
    own_ball = np.mean([shape.joints[f"l-toe-{i}-1"][0] for i in (1, 2, 3)])
    own_along = np.array([own_low[0], ankle[0], own_ball, own_high[0]])
    along = np.array([heel, 0.0, balls[:3, 0].mean(), tip])
    own_levels, levels = np.array([shape.lowest, ankle[2]]), np.array([-d.ankle_height, 0.0])
    scale, breadth = shape.scale, shape.breadth

    def mapping(x: Array) -> Array:
        own = x * side
        beyond = own[:, 0] - np.clip(own[:, 0], own_along[0], own_along[-1])
        forward = np.interp(own[:, 0], own_along, along) + breadth * beyond
        aside = across * (own[:, 1] - (own_low[1] + own_high[1]) / 2) + (medial + lateral) / 2
        up = np.interp(own[:, 2], own_levels, levels)
        up += scale * np.maximum(own[:, 2] - own_levels[1], 0.0)
        return at_ankle + np.stack([forward, aside, up], axis=1) * side

    origins, suffix = shape.human.skeleton.origins, "_l" if side[1] > 0 else "_r"
    foot, found = origins[f"foot{suffix}"], {}
    for bone in ("foot", "heel", "lateral_metatarsal", "medial_phalanges", "lateral_phalanges"):
        part = "toes" if "phalanges" in bone and f"toes{suffix}" in origins else bone
        at = np.asarray(origins.get(f"{part}{suffix}", foot), dtype=float)
        found[bone] = (at_ankle + at - foot, np.eye(3), mapping)
    return found


def _length(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def _linear(origin: Array, place: Array, matrix: Array) -> Map:
    """Return a map that brings a point to a place and is linear about it."""
    return lambda x: place + (x - origin) @ matrix.T


def _stretch(along: Array, length: float, breadth: float) -> Array:
    """Return the matrix that scales along a direction and across it."""
    u = along / np.linalg.norm(along)
    return breadth * np.eye(3) + (length - breadth) * np.outer(u, u)


def _turn(along: Array, other: Array, zero_along: Array, zero_other: Array) -> Array:
    """Return the rotation that brings two directions of the zero pose to those of the surface."""
    return axes_along(along, other) @ axes_along(zero_along, zero_other).T
