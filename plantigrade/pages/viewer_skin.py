"""Skin and foot bones for the scripts of both viewers, moved by the poses of the bodies."""

import base64
from collections.abc import Collection
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.charts import theme
from plantigrade.models import Human
from plantigrade.skin import Skin, foot_bones
from plantigrade.skin.skin import IRIS_DEPTH
from plantigrade.skin.surface import GARMENT_STEP, weights_in_255ths

BONE_STEP = 1e-5  # [m] of the vertices of bones; 16 bits reach 0.33 m from the origin of a body


def skin_data(human: Human, assumed: Collection[str] = ()) -> dict[str, Any] | None:
    """Return what the page needs of a person's skin; None if the body has none.

    Args:
        assumed: Bodies that are drawn paler, because their motion is assumed.
    """
    if type(human) is not Human:
        return None
    skin = Skin.of(human)
    surface, resting = skin.surface, skin.resting
    low = resting.vertices.min(axis=0)
    step = np.ptp(resting.vertices, axis=0) / 65535
    bones, weights = weights_in_255ths(surface.bones, surface.weights)
    paler = [human.body(name) for name in assumed]
    pale = np.isin(skin.bones.body, paler)[surface.bones]
    marks = np.stack(
        [
            np.clip(np.round(surface.garments[:, 0] / GARMENT_STEP) + 128, 0, 255),
            np.clip(np.round(surface.garments[:, 1] / GARMENT_STEP) + 128, 0, 255),
            eye_marks(skin),
            np.round(255 * (pale * surface.weights).sum(axis=1)),
        ],
        axis=1,
    )
    shoulder = surface.bone_names.index("humerus_l")
    return {
        "low": low.round(6).tolist(),
        "step": step.tolist(),
        "vertices": _packed(np.round((resting.vertices - low) / step), "<u2"),
        "faces": _packed(surface.faces, "<u2"),
        "bones": _packed(bones, "u1"),
        "weights": _packed(weights, "u1"),
        "marks": _packed(marks, "u1"),
        "body": skin.bones.body.tolist(),
        "offset": skin.bones.offset.round(5).tolist(),
        "resting": _resting(skin).round(6).tolist(),
        "recipes": [list(recipe) for recipe in skin.bones.recipes],
        "shoulder": round(float(abs(skin.resting.position[shoulder, 1])), 4),
        "colours": theme.SKIN,
    }


def foot_data(human: Human) -> dict[str, Any] | None:
    """Return bones and contact points of the feet; None where the feet have no bones.

    Vertices are in steps of 1/100 mm in the frame of their body. All bones have the same faces;
    their corners are in reverse order on the right.
    """
    if type(human) is not Human or not (bones := foot_bones(human)):
        return None
    contacts = [
        (human.body(body.name), *(contact.position - [0.0, 0.0, contact.radius]))
        for body in human.skeleton.bodies
        for contact in body.contacts
    ]
    return {
        "body": [bone.body for bone in bones],
        "mirrored": [bone.name.endswith("_r") for bone in bones],
        "vertices": _packed(np.round(np.stack([b.vertices for b in bones]) / BONE_STEP), "<i2"),
        "faces": _packed(bones[-1].faces, "<u2"),
        "contacts": np.round(contacts, 5).tolist(),
        "step": BONE_STEP,
        "colour": theme.BONE,
    }


def eye_marks(skin: Skin) -> Int[Array, " n"]:
    """Return 0 for skin, 1 for the white of an eye, 2 for its iris."""
    forward = skin.resting.vertices[:, 0]
    eyes = forward[skin.eyes]
    iris = forward > eyes.min() + IRIS_DEPTH * np.ptp(eyes)
    return np.where(skin.eyes, 1 + iris, 0)


def _resting(skin: Skin) -> Float[Array, "n_bones 7"]:
    """Return position [m] and quaternion, scalar last, of every bone in the fitted surface."""
    from scipy.spatial.transform import Rotation

    quat = Rotation.from_matrix(skin.resting.rotation).as_quat()
    return np.concatenate([skin.resting.position, quat], axis=1)


def _packed(array: Array, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array.astype(kind)).tobytes()).decode("ascii")
