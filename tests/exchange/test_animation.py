"""glTF of any run: a file that follows the format's rules and moves as MuJoCo does."""

import json
import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from plantigrade.errors import ParameterError
from plantigrade.exchange.animation import COLOURS
from plantigrade.exchange.bones import bones_of
from plantigrade.models import Human
from plantigrade.skin import Skin
from tests.exchange.moving import moving

AXES = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # file (x left, y up, z forward) to ours
NUMBERS = {5126: "<f4", 5121: "u1", 5123: "<u2", 5125: "<u4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """A binary file, read after the specification and with nothing of the package."""

    def __init__(self, path: Path):
        raw = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", raw)
        assert (magic, version, length) == (b"glTF", 2, len(raw))
        size, kind = struct.unpack_from("<I4s", raw, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.json = json.loads(raw[20 : 20 + size])
        rest, kind = struct.unpack_from("<I4s", raw, 20 + size)
        assert kind == b"BIN\0" and rest % 4 == 0 and 28 + size + rest == len(raw)
        self.content = raw[28 + size :]
        assert self.json["buffers"] == [{"byteLength": rest}]

    def array(self, index: int) -> np.ndarray:
        """Return an accessor's numbers."""
        entry = self.json["accessors"][index]
        view = self.json["bufferViews"][entry["bufferView"]]
        form, width = NUMBERS[entry["componentType"]], WIDTHS[entry["type"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == entry["count"] * width * np.dtype(form).itemsize
        assert view["byteOffset"] + view["byteLength"] <= len(self.content)
        flat = np.frombuffer(self.content, form, entry["count"] * width, view["byteOffset"])
        return flat.reshape(-1, width)

    def world(self, frame: int) -> dict[str, np.ndarray]:
        """Return the transform of every node at a frame of the animation, (4, 4)."""
        nodes = [dict(node) for node in self.json["nodes"]]
        animation = self.json["animations"][0]
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            target = channel["target"]
            nodes[target["node"]][target["path"]] = self.array(sampler["output"])[frame]
        found: dict[str, np.ndarray] = {}

        def visit(index: int, above: np.ndarray) -> None:
            node, own = nodes[index], np.eye(4)
            turn = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
            own[:3, :3] = turn * np.asarray(node.get("scale", [1, 1, 1]))
            own[:3, 3] = node.get("translation", [0, 0, 0])
            found[node["name"]] = above @ own
            for child in node.get("children", []):
                visit(child, above @ own)

        for index in self.json["scenes"][0]["nodes"]:
            visit(index, np.eye(4))
        return found

    def skinned(self, frame: int) -> np.ndarray:
        """Return the vertices of the skinned mesh at a frame, in file axes [m]."""
        world, skin = self.world(frame), self.json["skins"][0]
        inverse = self.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).swapaxes(1, 2)
        names = [self.json["nodes"][joint]["name"] for joint in skin["joints"]]
        matrices = np.array([world[n] for n in names]) @ inverse
        found = []
        for primitive in self.primitives("body"):
            attributes = primitive["attributes"]
            places = self.array(attributes["POSITION"])
            bones = self.array(attributes["JOINTS_0"])
            weights = self.array(attributes["WEIGHTS_0"]) / 255
            blended = np.einsum("vk,vkij->vij", weights, matrices[bones])
            found.append(np.einsum("vij,vj->vi", blended[:, :3, :3], places) + blended[:, :3, 3])
        return np.concatenate(found)

    def primitives(self, name: str) -> list[dict]:
        """Return the primitives of a mesh."""
        return next(mesh for mesh in self.json["meshes"] if mesh["name"] == name)["primitives"]


def check_rules(file: Glb) -> None:
    """Check what Khronos' validator calls errors, of all that such a file can do wrong."""
    tree = file.json
    assert tree["asset"]["version"] == "2.0"
    children = [child for node in tree["nodes"] for child in node.get("children", [])]
    assert len(set(children)) == len(children)  # each below one node
    assert not set(children) & set(tree["scenes"][0]["nodes"])
    for node in tree["nodes"]:
        if "rotation" in node:
            assert np.linalg.norm(node["rotation"]) == pytest.approx(1, abs=5e-3)
    for index, entry in enumerate(tree["accessors"]):
        values = file.array(index)
        assert np.isfinite(values).all()
        if "min" in entry:
            assert values.min(axis=0) == pytest.approx(entry["min"], abs=0)
            assert values.max(axis=0) == pytest.approx(entry["max"], abs=0)
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = {name: file.array(k) for name, k in primitive["attributes"].items()}
            count = len(attributes["POSITION"])
            assert "min" in tree["accessors"][primitive["attributes"]["POSITION"]]
            assert {len(values) for values in attributes.values()} == {count}
            indices = file.array(primitive["indices"])
            assert len(indices) % 3 == 0 and indices.max() < count
            assert np.linalg.norm(attributes["NORMAL"], axis=1) == pytest.approx(1, abs=5e-4)
            assert 0 <= primitive["material"] < len(tree["materials"])
            if "JOINTS_0" in attributes:
                weights, joints = attributes["WEIGHTS_0"].astype(int), attributes["JOINTS_0"]
                assert (weights.sum(axis=1) == 255).all() and (joints[weights == 0] == 0).all()
                assert joints.max() < len(tree["skins"][0]["joints"])
    for animation in tree["animations"]:
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            clock, output = file.array(sampler["input"]), file.array(sampler["output"])
            assert clock[0] == 0 and (np.diff(clock[:, 0]) > 0).all() and len(output) == len(clock)
            assert "min" in tree["accessors"][sampler["input"]]
            if channel["target"]["path"] == "rotation":
                assert np.linalg.norm(output, axis=1) == pytest.approx(1, abs=1e-5)
                assert ((output[1:] * output[:-1]).sum(axis=1) > 0).all()  # the short way
        targets = [tuple(channel["target"].values()) for channel in animation["channels"]]
        assert len(set(targets)) == len(targets)


@pytest.mark.parametrize(
    ("joints", "feet"), [("42", "rigid"), ("43", "two-segment"), ("58", "multi-segment")]
)
def test_bones_and_solids_move_as_in_mujoco(joints, feet, tmp_path):
    human = Human.create(joints=joints, feet=feet)
    run, path = moving(human), tmp_path / "run.glb"
    assert run.export(path, solids=True) == ()
    file, data = Glb(path), mujoco.MjData(human.model)
    check_rules(file)
    drawn = human.model.geom_group == 1
    for frame, qpos in enumerate(run.record.motion.qpos):
        data.qpos = qpos
        mujoco.mj_kinematics(human.model, data)
        world = file.world(frame)
        for bone in bones_of(human):
            body = data.body(bone.body)
            place = AXES @ world[bone.name][:3, 3]
            turn = body.xmat.reshape(3, 3)
            assert place == pytest.approx(body.xpos + turn @ bone.position, abs=1e-5)
            assert AXES @ world[bone.name][:3, :3] == pytest.approx(turn, abs=1e-5)
        vertices = file.skinned(frame) @ AXES.T
        middles = data.geom_xpos[drawn]
        for end in (vertices.min(axis=0), vertices.max(axis=0)):
            assert np.abs(end - middles).min(axis=0).max() < 0.25
        capsule = next(g for g in np.flatnonzero(drawn) if human.model.geom_type[g] == 3)
        radius, half = human.model.geom_size[capsule][:2]
        ends = data.geom_xpos[capsule] + np.outer(
            [-half, half], data.geom_xmat[capsule].reshape(3, 3)[:, 2]
        )
        away = np.abs(np.linalg.norm(vertices[:, None] - ends, axis=2) - radius)
        assert (away < 1e-4).sum() > 50  # of its round ends


@pytest.mark.parametrize(
    ("joints", "feet", "rig"),
    [("42", "two-segment", "plantigrade"), ("58", "multi-segment", "mixamo")],
)
def test_the_skin_moves_as_the_skin_of_the_package(joints, feet, rig, tmp_path):
    human = Human.create(joints=joints, feet=feet)
    run, path = moving(human, n=3), tmp_path / "run.glb"
    assert run.export(path, rig=rig) == ()
    file, data, skin = Glb(path), mujoco.MjData(human.model), Skin.of(human)
    check_rules(file)
    names = [file.json["materials"][p["material"]]["name"] for p in file.primitives("body")]
    assert set(names) == set(COLOURS)
    for frame, qpos in enumerate(run.record.motion.qpos):
        data.qpos = qpos
        mujoco.mj_kinematics(human.model, data)
        vertices = cKDTree(file.skinned(frame) @ AXES.T)
        away, _ = vertices.query(skin.posed(data.xpos, data.xquat))
        assert away.max() < 1e-3 and away.mean() < 1e-4


def test_garments_end_where_the_skin_says(tmp_path):
    """A hem is a line: no triangle lies on both of its sides."""
    human = Human.create()
    run, path = moving(human, n=2), tmp_path / "run.glb"
    run.export(path)
    file, skin = Glb(path), Skin.of(human)
    tree = cKDTree(skin.resting.vertices)
    shown = {}
    for primitive in file.primitives("body"):
        places = file.array(primitive["attributes"]["POSITION"])
        away, nearest = tree.query(places)
        own = nearest[away < 1e-6]  # the others are new, on a hem
        name = file.json["materials"][primitive["material"]]["name"]
        shown[name] = skin.surface.garments[own]
    assert (shown["shorts_r"][:, 1] >= 0).all() and (shown["shorts_l"][:, 1] >= 0).all()
    assert (shown["skin"] <= 0).all()
    assert (shown["sleeve_l"][:, 0] >= 0).all()


def test_ground_reactions_point_as_they_push(walk, tmp_path):
    path = tmp_path / "walk.glb"
    assert walk.export(path, forces=True, rate=25) == ()
    file, record = Glb(path), walk.record
    check_rules(file)
    clock = file.array(file.json["animations"][0]["samplers"][0]["input"])[:, 0]
    assert np.diff(clock) == pytest.approx(1 / 25, rel=0.1)
    foot, checked = record.foot("r"), 0
    for frame, instant in enumerate(clock):
        k = int(np.argmin(np.abs(record.motion.time - record.motion.time[0] - instant)))
        size = np.linalg.norm(foot.force[k]) / record.weight
        arrow = file.world(frame)["ground_reaction_r"]
        along = AXES @ arrow[:3, 2]
        if size < 0.1:
            assert np.linalg.norm(along) < 0.1
            continue
        assert along == pytest.approx(0.6 * foot.force[k] / record.weight, abs=0.01)
        assert AXES @ arrow[:3, 3] == pytest.approx(foot.centre_of_pressure[k], abs=1e-3)
        checked += 1
    assert checked > 10


def test_a_motion_that_cannot_be_drawn_is_refused(tmp_path):
    run = moving(Human.create())
    (note,) = run.export(tmp_path / "run.glb", forces=True)
    assert "no ground reactions" in note
    for options, words in (
        ({"rig": "biped"}, "rig='biped' must be one of"),
        ({"rate": 0}, "must lie between 1 and 1000"),
    ):
        with pytest.raises(ParameterError, match=words):
            run.export(tmp_path / "no.glb", **options)
    assert not (tmp_path / "no.glb").exists()


def test_trimesh_reads_it(walk, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    walk.export(tmp_path / "walk.glb")
    scene = trimesh.load(tmp_path / "walk.glb")
    assert any(name.startswith("body") for name in scene.geometry)
