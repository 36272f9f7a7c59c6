"""BVH of any run: every joint where MuJoCo has it, for every joint set and foot."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.exchange.bones import RIGS, bones_of
from plantigrade.io import read
from plantigrade.models import JOINT_SETS, Human
from plantigrade.record import Record, Run
from tests.exchange import bvh_kinematics
from tests.exchange.moving import moving

AXES = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # file (x left, y up, z forward) to ours


def angle(a: np.ndarray, b: np.ndarray) -> float:
    """Return the angle between two rotations [deg]."""
    return float(np.degrees(np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1))))


@pytest.mark.parametrize("feet", ["rigid", "two-segment", "multi-segment"])
@pytest.mark.parametrize("joints", JOINT_SETS)
def test_joints_are_where_mujoco_has_them(joints, feet, tmp_path):
    human = Human.create(joints=joints, feet=feet)
    run, path = moving(human), tmp_path / "run.bvh"
    assert run.export(path) == ()
    nodes, frame_time, rows = bvh_kinematics.read(path)
    assert frame_time == pytest.approx(0.02)
    data, seen = mujoco.MjData(human.model), set()
    for qpos, row in zip(run.record.motion.qpos, rows, strict=True):
        data.qpos = qpos
        mujoco.mj_kinematics(human.model, data)
        found = bvh_kinematics.poses(nodes, row)
        for bone in bones_of(human):
            place, rotation = found[bone.name]
            body = data.body(bone.body)
            assert angle(AXES @ rotation @ AXES.T, body.xmat.reshape(3, 3)) < 0.1
            expected = body.xpos + body.xmat.reshape(3, 3) @ bone.position
            assert AXES @ place / 100 == pytest.approx(expected, abs=1e-3)
            if not bone.position.any():  # a body begins at this joint
                assert expected == pytest.approx(body.xpos)
                seen.add(bone.body)
    assert seen == set(human.body_names) - {"pelvis"}


def test_our_reader_reads_it_back(walk, tmp_path):
    path = tmp_path / "walk.bvh"
    walk.export(path)
    skeleton, human, motion = read(path).skeleton, walk.record.human, walk.record.motion
    assert skeleton.time - skeleton.time[0] == pytest.approx(motion.time - motion.time[0], abs=1e-4)
    data, bones = mujoco.MjData(human.model), bones_of(human)
    assert list(skeleton.names) == [bone.name for bone in sorted(bones, key=order(skeleton))]
    at = {name: k for k, name in enumerate(skeleton.names)}
    for frame in range(0, motion.n_frames, 20):
        data.qpos = motion.qpos[frame]
        mujoco.mj_kinematics(human.model, data)
        for bone in bones:
            rotation = data.body(bone.body).xmat.reshape(3, 3)
            expected = data.body(bone.body).xpos + rotation @ bone.position
            assert skeleton.positions[frame, at[bone.name]] == pytest.approx(expected, abs=1e-3)
            assert angle(skeleton.rotations[frame, at[bone.name]], rotation) < 0.1


def order(skeleton):
    """Return what sorts bones as a skeleton lists them."""
    return lambda bone: skeleton.names.index(bone.name)


def test_limbs_end_at_the_tips_of_the_body(tmp_path):
    human = Human.create(joints="66")
    run = moving(human)
    standing = np.tile(human.standing(), (2, 1))
    motion = replace(
        run.record.motion,
        time=np.array([0, 0.02]),
        qpos=standing,
        qvel=np.zeros((2, human.model.nv)),
    )
    still = Run(Record(human, motion), "fit")
    still.export(tmp_path / "still.bvh", unit="m")
    nodes, _, rows = bvh_kinematics.read(tmp_path / "still.bvh")
    found = bvh_kinematics.poses(nodes, rows[0])
    assert found["Head end"][0][1] == pytest.approx(human.height, abs=0.01)
    assert 0 < found["LeftToeBase end"][0][1] < 0.05
    assert found["LeftToeBase end"][0][2] > found["LeftToeBase"][0][2] + 0.02
    assert found["LeftHeel end"][0][2] < found["LeftFoot"][0][2]
    assert found["LeftFoot"][0][0] > 0 > found["RightFoot"][0][0]  # x to the left


@pytest.mark.parametrize("rig", RIGS)
def test_a_rig_has_the_same_bones_for_every_body(rig):
    """One mapping serves all: only the foot's own parts come and go."""
    plain = [
        tuple(b.name for b in bones_of(Human.create(joints=joints, feet="two-segment"), rig))
        for joints in JOINT_SETS
    ]
    assert len(set(plain)) == 1 and len(set(plain[0])) == len(plain[0])
    many = {b.name for b in bones_of(Human.create(feet="multi-segment"), rig)}
    assert many >= set(plain[0]) and (rig == "plantigrade" or many == set(plain[0]))
    bones = bones_of(Human.create(), rig)
    assert bones[0].parent == -1 and all(b.parent >= 0 for b in bones[1:])


def test_unit_and_rate(tmp_path):
    run = moving(Human.create(), n=11)
    rows = {}
    for unit in ("m", "cm"):
        run.export(tmp_path / f"{unit}.bvh", unit=unit, rate=25, rig="unreal")
        nodes, frame_time, rows[unit] = bvh_kinematics.read(tmp_path / f"{unit}.bvh")
        assert frame_time == pytest.approx(0.04) and len(rows[unit]) == 6
        assert nodes[0].name == "pelvis" and {"calf_l", "ball_r"} <= {n.name for n in nodes}
    assert rows["cm"][:, :3] == pytest.approx(100 * rows["m"][:, :3], abs=1e-3)
    for options, words in (
        ({"rig": "biped"}, "rig='biped' must be one of plantigrade, mixamo"),
        ({"unit": "ell"}, "unit='ell'"),
        ({"rate": 0.1}, "must lie between 1 and 1000"),
    ):
        with pytest.raises(ParameterError, match=words):
            run.export(tmp_path / "no.bvh", **options)
    assert not (tmp_path / "no.bvh").exists()
