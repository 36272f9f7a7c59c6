"""Parts of the body inside each other: what the checker finds, and whom it blames."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade import check
from plantigrade.analyze.overlap import ground_overlap, may_overlap, overlap
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.models import Human
from tests.analyze.bodies import having
from tests.analyze.standing import standing_record


def depth(human, **hinges):
    """Return the deepest pair of bodies in standing with some hinges set, and how deep [mm]."""
    qpos = human.standing()
    for name, angle in hinges.items():
        qpos[7 + human.hinge(name)] = angle
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    found = overlap(human, data.xpos[None], data.xmat.reshape(1, -1, 3, 3))
    k = int(np.argmax(found.depth[0]))
    return found.names[k], 1000.0 * found.depth[0, k]


@pytest.mark.parametrize(("height", "mass", "sex"), [(1.5, 48, "female"), (1.95, 105, "male")])
def test_nothing_is_inside_anything_in_quiet_standing(height, mass, sex):
    for joints in ("42", "43"):
        human = Human.create(height, mass, sex, joints=joints)
        assert depth(human)[1] < 0.0


def test_arms_in_hips_and_crossed_legs_are_found():
    human = Human.create()
    where, deep = depth(human, arm_add_l=0.1)
    assert where.endswith("_l") or "_l in" in where
    assert deep > 15.0
    where, deep = depth(human, hip_adduction_r=0.35)
    assert {"r", "l"} == {where[-1], where.split(" in ")[0][-1]}
    assert deep > 10.0


def test_what_meets_at_a_joint_may_overlap_and_nothing_else():
    human = Human.create(joints="58", feet="multi-segment")
    assert may_overlap(human, "femur_r", "pelvis")
    assert may_overlap(human, "heel_r", "tibia_r")
    assert may_overlap(human, "humerus_l", "lower_thorax")
    assert not may_overlap(human, "tibia_r", "tibia_l")
    assert not may_overlap(human, "heel_r", "tibia_l")
    assert not may_overlap(human, "humerus_l", "abdomen")
    assert not may_overlap(human, "hand_r", "femur_r")


def test_a_record_is_judged_only_where_it_says_that_bodies_are_solid():
    record = standing_record()
    qpos = record.motion.qpos.copy()
    qpos[:, 7 + record.human.hinge("arm_add_r")] = 0.15
    inside = having(record, qpos=qpos)
    loose = check(inside)
    assert loose.measures["overlap"].value > 10.0
    assert not loose.measures["overlap"].bad
    solid = check(having(inside, limits=replace(inside.limits, overlap=0.0)))
    assert solid.measures["overlap"].bad
    assert any("mm deep" in words for words in solid.sentences())
    assert (
        not check(having(record, limits=replace(record.limits, overlap=0.0)))
        .measures["overlap"]
        .bad
    )


def fallen(human, n=8):
    """Return positions and rotations of a person who lies in the ground at random, and MuJoCo's
    own depth of each body, name → (n,) [m]."""
    rng, data, model = np.random.default_rng(2), mujoco.MjData(human.model), human.model
    floor = model.geom("floor").id
    position, rotation, depth = [], [], {}
    for _ in range(n):
        data.qpos[:] = human.standing()
        data.qpos[2] = rng.uniform(0.0, 0.5)
        data.qpos[3:7] = rng.normal(size=4)
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
        mujoco.mj_kinematics(model, data)
        position.append(data.xpos.copy())
        rotation.append(data.xmat.reshape(-1, 3, 3).copy())
        deepest = {}
        for g in np.flatnonzero(model.geom_group == 1):
            name = model.body(int(model.geom_bodyid[g])).name
            away = mujoco.mj_geomDistance(model, data, int(g), floor, 5.0, None)
            deepest[name] = max(deepest.get(name, -np.inf), -away)
        for name, deep in deepest.items():
            depth.setdefault(name, []).append(deep)
    return np.array(position), np.array(rotation), depth


def test_depths_in_the_ground_are_those_of_mujoco():
    human = Human.create()
    position, rotation, depth = fallen(human)
    found = ground_overlap(human, position, rotation, Ground())
    assert "hand_r in the ground" in found.names and "pelvis in the ground" in found.names
    assert not any(name.startswith(("foot", "toes")) for name in found.names)
    for name, deep in zip(found.names, found.depth.T, strict=True):
        np.testing.assert_allclose(deep, depth[name.removesuffix(" in the ground")], atol=1e-4)


def test_treads_and_slopes_are_ground_too():
    human = Human.create()
    position, rotation, _ = fallen(human, 2)
    level = ground_overlap(human, position, rotation, Ground()).depth
    raised = Ground(steps=(GroundStep(-50.0, 0.2),))
    np.testing.assert_allclose(
        ground_overlap(human, position, rotation, raised).depth, level + 0.2, atol=1e-9
    )
    turn = Ground(slope=0.2).to_world
    leaning = ground_overlap(human, position @ turn.T, turn @ rotation, Ground(slope=0.2))
    np.testing.assert_allclose(leaning.depth, level, atol=1e-9)


def test_a_hand_in_the_ground_is_found_where_bodies_are_solid():
    record = standing_record()
    qpos = record.motion.qpos.copy()
    qpos[:, 2:7] = [0.35, np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]  # prone above the ground
    qpos[:, 7 + record.human.hinge("arm_flex_r")] = np.pi / 2  # an arm points down
    sunk = having(record, qpos=qpos, limits=replace(record.limits, overlap=0.0))
    assert any("hand r in the ground is" in words for words in check(sunk).sentences())
