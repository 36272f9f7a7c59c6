"""Blender opens what is exported, and sees the bones where MuJoCo has them."""

import mujoco
import numpy as np
import pytest

from plantigrade.exchange.bones import bones_of
from plantigrade.models import Human
from tests.exchange.moving import moving

bpy = pytest.importorskip("bpy")

AXES = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
"""From axes of Blender (x left, y backward, z up) to ours."""


def skeleton():
    """Return the only skeleton of the scene."""
    (found,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    return found


def heads(frame: int) -> dict[str, np.ndarray]:
    """Return where every bone begins at a frame, in our axes."""
    bpy.context.scene.frame_set(frame)
    bpy.context.view_layer.update()
    armature = skeleton()
    bones = armature.pose.bones
    return {bone.name: AXES @ np.array(armature.matrix_world @ bone.head) for bone in bones}


def check(run, first: int, tolerance: float) -> None:
    """Compare all bones at all frames with MuJoCo, within ``tolerance`` [m]."""
    human = run.record.human
    data = mujoco.MjData(human.model)
    for frame, qpos in enumerate(run.record.motion.qpos):
        data.qpos = qpos
        mujoco.mj_kinematics(human.model, data)
        seen = heads(first + frame)
        for bone in bones_of(human):
            body = data.body(bone.body)
            expected = body.xpos + body.xmat.reshape(3, 3) @ bone.position
            assert seen[bone.name] == pytest.approx(expected, abs=tolerance)


@pytest.fixture
def run():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 50
    return moving(Human.create(joints="58", feet="multi-segment"))


@pytest.mark.slow
def test_blender_reads_a_scene(run, tmp_path):
    run.export(tmp_path / "run.glb", forces=False)
    assert bpy.ops.import_scene.gltf(filepath=str(tmp_path / "run.glb")) == {"FINISHED"}
    body = bpy.data.objects["body"]
    assert [modifier.object for modifier in body.modifiers] == [skeleton()]
    assert {"skin", "shirt"} <= {material.name for material in bpy.data.materials}
    check(run, 0, 1e-4)


@pytest.mark.slow
def test_blender_reads_a_skeleton(run, tmp_path):
    run.export(tmp_path / "run.bvh", unit="m")
    assert bpy.ops.import_anim.bvh(filepath=str(tmp_path / "run.bvh")) == {"FINISHED"}
    check(run, 1, 1e-3)
