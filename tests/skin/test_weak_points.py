"""Where a linear skin is weakest: arms beside wide hips, deep knees, raised arms, fingers."""

import mujoco
import numpy as np
import pytest

from plantigrade import Human
from plantigrade.skin import Skin

ARM = ("shoulder", "humerus0", "humerus", "elbow", "ulna", "forearm", "radius", "hand", "fingers")


def poses(human: Human, **angles: float) -> tuple[np.ndarray, np.ndarray]:
    """Body poses of a person who stands but for some coordinates [deg]."""
    data = mujoco.MjData(human.model)
    data.qpos[:] = human.standing()
    for name, angle in angles.items():
        data.qpos[7 + human.hinge(name)] = np.radians(angle)
    mujoco.mj_kinematics(human.model, data)
    return data.xpos.copy(), data.xquat.copy()


def share_of(skin: Skin, stems: tuple[str, ...]) -> np.ndarray:
    """Weight of some bones of both sides at every vertex."""
    own = np.array([name[:-2] in stems for name in skin.surface.bone_names])
    return (skin.surface.weights * own[skin.surface.bones]).sum(axis=1)


def inside(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Which points are within a surface: winding number by solid angles (Van Oosterom)."""
    a, b, c = (vertices[faces[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(each, axis=2) for each in (a, b, c))
    triple = np.einsum("pfi,pfi->pf", a, np.cross(b, c))
    rest = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.arctan2(triple, rest).sum(axis=1) / (2 * np.pi) > 0.5


@pytest.mark.parametrize(
    ("height", "mass", "sex", "most"),
    [(1.74, 71.0, "male", 0.005), (1.65, 85.0, "female", 0.05), (1.55, 90.0, "female", 0.05)],
)
def test_hanging_arms_are_beside_the_body(height, mass, sex, most):
    """Share of the arms inside trunk and thighs; without room for them 0.4, 11 and 24 %."""
    human = Human.create(height, mass, sex)
    skin = Skin.of(human)
    vertices, arm = skin.posed(*poses(human)), share_of(skin, ARM)
    body = skin.faces[(arm < 0.02)[skin.faces].any(axis=1)]
    assert inside(vertices[arm > 0.98][::6], vertices, body).mean() <= most


def reversed_share(human: Human, skin: Skin, near: np.ndarray, **angles: float) -> float:
    """Share of an area whose triangles face against the bones that move them."""
    faces = skin.faces[near[skin.faces].all(axis=1)]

    def normals(vertices: np.ndarray) -> np.ndarray:
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        return np.cross(b - a, c - a)

    bodies = poses(human, **angles)
    turns = skin.motions(*bodies)[..., :3][skin.surface.bones]
    turn = np.einsum("nk,nkij->nij", skin.surface.weights, turns)[faces].mean(axis=1)
    before, after = normals(skin.resting.vertices), normals(skin.posed(*bodies))
    folded = np.einsum("nij,nj,ni->n", turn, before, after) < 0
    area = np.linalg.norm(before, axis=1)
    return float(area[folded].sum() / area.sum())


@pytest.mark.parametrize("angle", [110.0, 140.0])
def test_the_front_of_a_deeply_bent_knee_has_no_folds(angle):
    human = Human.create()
    skin = Skin.of(human)
    knee = skin.resting.position[skin.surface.bone_names.index("tibia_l")]
    away = skin.resting.vertices - knee
    front = (np.linalg.norm(away, axis=1) < 0.11) & (away[:, 0] > 0)
    assert reversed_share(human, skin, front, knee_angle_l=angle) < 1e-3


@pytest.mark.parametrize(
    ("angle", "most"), [(90.0, 0.0), (120.0, 0.005), (150.0, 0.03), (170.0, 0.06)]
)
def test_a_raised_arm_folds_little_of_the_shoulder(angle, most):
    """Where the clavicle is welded: above 120° the deltoid folds over the girdle."""
    human = Human.create()
    skin = Skin.of(human)
    joint = skin.resting.position[skin.surface.bone_names.index("humerus_l")]
    near = np.linalg.norm(skin.resting.vertices - joint, axis=1) < 0.11
    assert reversed_share(human, skin, near, arm_add_l=-angle) <= most


def test_fingers_are_flexed_as_at_rest():
    """The longest finger reaches less far than a stretched one, and more than a fist."""
    human = Human.create()
    skin = Skin.of(human)
    wrist = skin.resting.position[skin.surface.bone_names.index("hand_l")]
    fingers = skin.resting.vertices[share_of(skin, ("fingers",)) > 0.9]
    reach = np.linalg.norm(fingers[fingers[:, 1] > 0] - wrist, axis=1).max()
    assert 0.75 < reach / human.dimensions.hand < 0.97
