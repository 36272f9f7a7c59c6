"""Parts of the body inside each other: what the checker finds, and whom it blames."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade import check
from plantigrade.analyze.overlap import may_overlap, overlap
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
