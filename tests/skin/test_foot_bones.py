"""The bones of a foot: closed, with their ends at the joints, above the ground, mirror images."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade import Human
from plantigrade.models.feet import point, sphere_radius
from plantigrade.skin import foot_bones
from tests.models.presets import PRESETS, person

SIXTEEN = 16
MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def human() -> Human:
    return person("43", "multi-segment")


def standing(human: Human) -> dict[str, np.ndarray]:
    """Vertices of every bone while the person stands at the origin, world [m]."""
    data = mujoco.MjData(human.model)
    data.qpos[:] = human.standing()
    mujoco.mj_kinematics(human.model, data)
    return {bone.name: in_world(data, bone.body, bone.vertices) for bone in foot_bones(human)}


def in_world(data: mujoco.MjData, body: int, points: np.ndarray) -> np.ndarray:
    turn = Rotation.from_quat(data.xquat[body], scalar_first=True)
    return data.xpos[body] + turn.apply(points)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.cross(b - a, c - a)[:, 2] @ (a + b + c)[:, 2] / 6)


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_only_a_multi_segment_foot_has_bones_and_it_has_sixteen(preset):
    names = [bone.name for bone in foot_bones(person(*preset))]
    assert len(set(names)) == (2 * SIXTEEN if preset[1] == "multi-segment" else 0)


def test_every_bone_is_closed_and_has_a_volume(human):
    for bone in foot_bones(human):
        edges = np.concatenate([bone.faces[:, [i, (i + 1) % 3]] for i in range(3)])
        assert len(np.unique(edges, axis=0)) == len(edges)
        assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
        assert volume(bone.vertices, bone.faces) > 1e-6, bone.name


def test_the_bones_of_a_foot_have_the_volume_of_bones(human):
    """Less than the foot of the model, by its mass; the calcaneus is the largest of them."""
    found = {b.name: volume(b.vertices, b.faces) for b in foot_bones(human) if b.name[-1] == "l"}
    foot = sum(human.model.body_mass[human.body(b)] for b in {"foot_l", "heel_l", "toes_l"}
               if b in human.body_names) / 1000  # fmt: skip
    assert 0.15 * foot < sum(found.values()) < foot
    calcaneus = found["calcaneus_medial_l"] + found["calcaneus_lateral_l"]
    assert calcaneus > max(v for name, v in found.items() if "calcaneus" not in name)
    assert found["metatarsal_1_l"] == max(v for name, v in found.items() if "metatarsal" in name)


@pytest.mark.parametrize("ray", range(1, 6))
def test_metatarsals_and_toes_end_at_their_joints(human, ray):
    """The centre of a joint lies in the head of the metatarsal, and before the base of the toe."""
    d, vertices = human.dimensions, standing(human)
    ankle = human.skeleton.origins["foot_l"]
    shift = np.array([0.0, 0.0, d.ankle_height])  # the sole of the table is the ground
    origin = np.array([ankle[0], ankle[1], 0.0]) + human.standing()[:3] * [1, 1, 0]
    radius = sphere_radius(d)

    def distance(bone: str, name: str) -> float:
        at = origin + shift + point(name, d)
        return float(np.linalg.norm(vertices[bone] - at, axis=1).min())

    head, base, tip = f"metatarsal_{ray}", f"base_{ray}", f"toe_{ray}"
    for bone, name in ((f"metatarsal_{ray}_l", base), (f"metatarsal_{ray}_l", head),
                       (f"toe_{ray}_l", head), (f"toe_{ray}_l", tip)):  # fmt: skip
        assert distance(bone, name) < radius, (bone, name)
    length = np.ptp(vertices[f"metatarsal_{ray}_l"][:, 0])
    assert length == pytest.approx(point(head, d)[0] - point(base, d)[0], abs=2 * radius)


def test_shafts_are_thinner_than_heads_and_bases(human):
    for bone in foot_bones(human):
        if not bone.name.startswith("metatarsal"):
            continue
        axis = bone.end - bone.start
        along = (bone.vertices - bone.start) @ axis / (axis @ axis)
        away = np.linalg.norm(bone.vertices - bone.start - np.outer(along, axis), axis=1)
        middle = away[np.abs(along - 0.5) < 0.06].mean()
        ends = away[np.abs(along) < 0.06].mean(), away[np.abs(along - 0.98) < 0.05].mean()
        assert middle < 0.8 * min(ends), bone.name


@pytest.mark.parametrize(("height", "mass"), [(1.45, 40.0), (1.74, 71.0), (2.05, 110.0)])
def test_bones_stand_above_the_ground_and_under_the_ankle(height, mass):
    human = Human.create(height, mass, feet="multi-segment")
    vertices = standing(human)
    lowest = min(v[:, 2].min() for v in vertices.values())
    assert 0.0 < lowest < 0.5 * sphere_radius(human.dimensions)
    top = vertices["talus_l"][:, 2].max()
    assert human.dimensions.ankle_height < top < 1.3 * human.dimensions.ankle_height
    assert top == max(v[:, 2].max() for v in vertices.values())


def test_the_talus_rests_on_the_calcaneus_and_meets_the_navicular(human):
    vertices = standing(human)
    for other in ("calcaneus_medial_l", "calcaneus_lateral_l", "medial_tarsals_l"):
        gap = np.linalg.norm(vertices["talus_l"][:, None] - vertices[other][None], axis=2).min()
        assert gap < 0.005, other


def test_right_and_left_are_mirror_images(human):
    bones = {bone.name: bone for bone in foot_bones(human)}
    for name, bone in bones.items():
        if name.endswith("_l"):
            other = bones[f"{name[:-2]}_r"]
            np.testing.assert_allclose(other.vertices, bone.vertices * MIRROR, atol=1e-12)
            np.testing.assert_array_equal(other.faces, bone.faces[:, ::-1])


def test_toes_turn_with_their_segment(human):
    """Toes of an extended hinge rise; metatarsals and talus stay."""
    data = mujoco.MjData(human.model)
    data.qpos[:] = human.standing()
    data.qpos[7 + human.hinge("mtp_angle_l")] += 0.4
    mujoco.mj_kinematics(human.model, data)
    before = standing(human)
    moved = {
        bone.name: np.abs(in_world(data, bone.body, bone.vertices) - before[bone.name]).max()
        for bone in foot_bones(human)
    }
    assert moved["toe_1_l"] > 0.01
    assert moved["talus_l"] < 1e-12 and moved["metatarsal_2_l"] < 1e-12 and moved["toe_1_r"] < 1e-12
