"""Limbs are solid: rows of the optimiser beside MuJoCo's own distances."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.contact.plan import ContactPlan, path_heading
from plantigrade.models import Human
from plantigrade.models.loads import load_box
from plantigrade.trajopt import ContactBody, ProblemBuilder, make_task
from plantigrade.trajopt.diagnose.violations import values
from plantigrade.trajopt.guess.postures import (
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.trajopt.problem.contact import soles_of
from plantigrade.trajopt.terms.contact import Contact
from plantigrade.trajopt.terms.limb_shapes import leg_rods
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.momentum import AngularMomentum
from plantigrade.trajopt.terms.solid import (
    ARMS,
    ROW_SCALE,
    SolidLimbs,
    arms,
    arms_above_ground,
    legs,
)
from tests.trajopt.coarse_walk import body, solved

pytestmark = pytest.mark.solver


def apart(human, qpos, these, those):
    """Return the least distance of the solids of two sets of bodies, by MuJoCo [m]."""
    model = human.model
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    name = [model.body(int(b)).name for b in model.geom_bodyid]
    one, two = (
        [g for g in range(model.ngeom) if model.geom_group[g] == 1 and name[g] in names]
        for names in (these, those)
    )
    return min(mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a in one for b in two)


def bodies(human, stems, side=""):
    """Return the names of bodies that start so, of one side if given."""
    return [n for n in human.body_names if n.startswith(stems) and n.endswith(side)]


@pytest.mark.parametrize(
    "feet", ["rigid", "two-segment", pytest.param("multi-segment", marks=pytest.mark.slow)]
)
def test_limbs_that_the_rows_keep_apart_are_apart(feet):
    """Legs swing past each other and arms beside the trunk, at random."""
    human = Human.create(1.74, 71.0, joints="43", feet=feet)
    given = ContactBody(human, ())
    rng = np.random.default_rng(3)
    names = given.symbolic.names
    q = np.tile(
        given.symbolic.from_mujoco(human.standing()[None], *np.zeros((2, 1, len(names))))[0],
        (60, 1),
    )
    for stem, low, high in (
        ("hip_flexion", -0.3, 0.5), ("hip_adduction", -0.1, 0.12), ("knee_angle", 0.0, 1.0),
        ("arm_flex", -0.5, 0.5), ("arm_add", -0.25, 0.1),
    ):  # fmt: skip
        for side in "rl":
            q[:, names.index(f"{stem}_{side}")] = rng.uniform(low, high, len(q))
    zero, none = np.zeros_like(q), np.zeros((len(q), 0))
    families = legs(given, len(q)), arms(given, len(q), SolidLimbs())
    found = [values(family, q, zero, zero, none) / ROW_SCALE for family in families]
    qpos = given.symbolic.to_mujoco(q, zero, zero)[0]
    limb = ("femur", "tibia", "foot", "toes", "heel", "medial", "lateral")
    true_legs = [apart(human, x, *(bodies(human, limb, f"_{s}") for s in "rl")) for x in qpos]
    arm, around = ("humerus", "ulna", "radius", "hand"), ["pelvis", "abdomen", "femur_r"]
    true_arm = [apart(human, x, bodies(human, arm, "_r"), around) for x in qpos]
    for row, true in ((found[0][:, 0], true_legs), (found[1][:, 0], true_arm)):
        distance = np.array(true)
        assert (distance < 0.0).any()
        kept = row > 0.0
        assert kept.sum() > 10
        assert distance[kept].min() > -0.001  # what the row keeps apart is apart
        assert np.median((distance - row)[kept]) < 0.025  # and not much more than it must


@pytest.mark.parametrize("other", [False, True])
def test_a_load_in_a_hand_keeps_its_half_size_from_both_thighs(other):
    """Without that row a walker swung a bag of 10 kg through both thighs."""
    empty = Human.create(1.74, 71.0, joints="43", feet="two-segment")
    laden = empty.with_loads({"hand_r": 10.0})
    given = [ContactBody(human, ()) for human in (empty, laden)]
    names = given[0].symbolic.names
    q = np.zeros((1, len(names)))
    if other:  # across, in front of the body, above a pelvis that drops
        q[0, names.index("arm_flex_r")], q[0, names.index("arm_add_r")] = 0.5, 0.6
        q[0, names.index("pelvis_list")] = 0.3
    zero, none = np.zeros_like(q), np.zeros((1, 0))
    free, kept = (
        values(arms(b, 1, SolidLimbs()), q, zero, zero, none)[0, 0] / ROW_SCALE for b in given
    )
    data = mujoco.MjData(laden.model)
    data.qpos[:] = given[1].symbolic.to_mujoco(q, zero, zero)[0][0]
    mujoco.mj_kinematics(laden.model, data)
    body, centre, half = load_box(laden.skeleton, "hand_r", laden.height)
    place = data.body(body).xpos + data.body(body).xmat.reshape(3, 3) @ centre
    distance = []
    for side in "rl":
        g = next(
            g
            for g in range(laden.model.ngeom)
            if laden.model.geom_group[g] == 1
            and laden.model.body(int(laden.model.geom_bodyid[g])).name == f"femur_{side}"
        )
        along, length = data.geom_xmat[g].reshape(3, 3)[:, 2], laden.model.geom_size[g, 1]
        off = place - data.geom_xpos[g]
        off = off - np.clip(off @ along, -length, length) * along
        distance.append(np.linalg.norm(off) - laden.model.geom_size[g, 0] - half.min())
    assert kept < min(free, *distance) + 1e-3
    assert kept == pytest.approx(min(free, *distance), abs=0.01)
    beside = arms(given[1], 1, SolidLimbs(loads_beside=True))
    (row,) = values(beside, q, zero, zero, none)[:, 0] / ROW_SCALE
    hip, thigh = data.body("femur_r").xpos, leg_rods(laden, "r")[0].radius
    outward = -data.body("pelvis").xmat.reshape(3, 3)[:, 1] * [1, 1, 0]  # along the level
    outward /= np.linalg.norm(outward)
    aside = (place - hip) @ outward - half.min() - thigh
    assert row == pytest.approx(min(kept, aside), abs=0.005)


def test_forearms_and_hands_that_the_row_keeps_apart_are_apart():
    """Arms swing inwards in front of the body, at random."""
    human = Human.create(joints="43")
    given = ContactBody(human, ())
    rng, names = np.random.default_rng(5), given.symbolic.names
    q = np.tile(standing_posture(human), (60, 1))
    for stem, low, high in (
        ("arm_flex", 0.2, 0.9), ("arm_add", 0.0, 0.6), ("arm_rot", 0.2, 0.9),
        ("elbow_flex", 0.6, 1.3),
    ):  # fmt: skip
        for side in "rl":
            q[:, names.index(f"{stem}_{side}")] = rng.uniform(low, high, len(q))
    zero = np.zeros_like(q)
    family = arms(given, len(q), SolidLimbs())
    row = values(family, q, zero, zero, np.zeros((len(q), 0)))[:, 2] / ROW_SCALE
    qpos = given.symbolic.to_mujoco(q, zero, zero)[0]
    lower = ("ulna", "radius", "hand")
    distance = np.array(
        [apart(human, x, *(bodies(human, lower, f"_{s}") for s in "rl")) for x in qpos]
    )
    assert (distance < 0.0).any()
    kept = row > 0.0
    assert kept.sum() > 10
    assert distance[kept].min() > -0.001
    assert np.median((distance - row)[kept]) < 0.07  # a hand is as thick as it is wide here


def test_a_trunk_that_the_row_keeps_off_the_thigh_is_off_it():
    """People bend deep, at random."""
    human = Human.create(1.74, 71.0, joints="43")
    given = ContactBody(human, ())
    rng, names = np.random.default_rng(7), given.symbolic.names
    q = np.tile(standing_posture(human), (60, 1))
    for name, low, high in (("hip_flexion_r", 1.8, 2.6), ("lumbar_extension", -1.4, -0.4)):
        q[:, names.index(name)] = rng.uniform(low, high, len(q))
    zero = np.zeros_like(q)
    family = arms(given, len(q), SolidLimbs())
    row = values(family, q, zero, zero, np.zeros((len(q), 0)))[:, 3] / ROW_SCALE
    qpos = given.symbolic.to_mujoco(q, zero, zero)[0]
    distance = np.array([apart(human, x, ["femur_r"], ["abdomen", "thorax"]) for x in qpos])
    assert (row < 0.0).any() and (row > 0.01).any()
    assert distance[row > 0.0].min() > -0.005  # the upper half of the thigh is not looked at


def test_thighs_that_the_row_keeps_off_shoulders_and_head_are_off_them():
    """People who sit on the ground, their knees drawn up and apart, at random."""
    human = Human.create(1.74, 71.0, joints="43")
    given = ContactBody(human, ())
    rng, names = np.random.default_rng(11), given.symbolic.names
    q = np.tile(standing_posture(human), (400, 1))
    for name, low, high in (
        ("hip_flexion_r", 2.0, 2.6), ("hip_adduction_r", -0.7, 0.4), ("hip_rotation_r", -0.5, 0.5),
        ("lumbar_extension", -1.4, -0.6), ("lumbar_bending", -0.4, 0.4), ("neck_rotation", -1, 1),
    ):  # fmt: skip
        q[:, names.index(name)] = rng.uniform(low, high, len(q))
    zero, n = np.zeros_like(q), len(q)
    qpos = given.symbolic.to_mujoco(q, zero, zero)[0]
    distance = np.array([apart(human, x, ["femur_r"], ["thorax", "head"]) for x in qpos])
    found = {}
    for shoulders in (False, True):
        family = arms(given, n, SolidLimbs(opposite_thighs=True, shanks=True, shoulders=shoulders))
        row = values(family, q, zero, zero, np.zeros((n, 0)))[:, 3]
        assert (row > 0.0).sum() > 20 and (distance < -0.02).any()
        found[shoulders] = distance[row > 0.0].min()
    assert found[False] < -0.004 and found[True] > -0.001


def test_hands_far_apart_have_second_derivatives():
    import casadi as ca

    human = Human.create(2.1, 100.0, joints="42")
    family, n = arms(ContactBody(human, ()), 1, SolidLimbs()), len(standing_posture(human))
    q = ca.SX.sym("q", n)
    row = family.function(q, ca.SX(n, 1), ca.SX(n, 1), ca.SX(0, 1), ca.SX(0, 1))[2]
    hessian = ca.Function("hessian", [q], [row, ca.hessian(row, q)[0]])
    spread = standing_posture(human)
    for side in "rl":
        spread[6 + human.hinge(f"arm_add_{side}")] = -np.pi / 2
    distance, second = (np.array(x) for x in hessian(spread))
    assert distance > 0.5 * ROW_SCALE  # of the elbows
    assert np.isfinite(second).all()


@pytest.mark.parametrize("height, mass", [(1.0, 16.0), (1.45, 66.0), (1.61, 78.0), (2.0, 120.0)])
def test_people_of_all_sizes_stand_with_their_arms_clear(height, mass):
    human = Human.create(height, mass, joints="42")
    plan = ContactPlan(1.0, standing_stances(standing_feet(human), 1.0))
    builder = ProblemBuilder(ContactBody.for_plan(human, plan), plan, np.array([0.0, 0.5, 1.0]))
    SolidLimbs().add_to(builder)
    asked = builder.family(ARMS)
    q = np.tile(standing_posture(human), (3, 1))
    u = np.zeros((3, 3 * len(builder.body.sites)))
    assert np.all(values(asked, q, 0.0 * q, 0.0 * q, u) >= asked.lower)


def test_the_row_of_a_walk_is_kept_between_nodes_too():
    made = solved()
    times, depth = made.overlapping()
    assert len(times) > 5 * len(made.problem.nodes)
    assert depth.max() <= 0.0
    crossed = made.problem.states(made.coefficients, made.problem.nodes)
    q = crossed[0].copy()
    for side, turn in (("r", 0.25), ("l", 0.25)):  # both legs inwards
        q[:, made.problem.names.index(f"hip_adduction_{side}")] += turn
    family = legs(body(), len(q))
    u = np.zeros((len(q), 3 * len(body().sites)))
    assert values(family, q, *crossed[1:], u).min() < -0.03 * ROW_SCALE


def test_nodes_are_near_each_other_where_a_leg_passes_the_other():
    task = make_task("walk", body().human, {"steps": 4})
    spans, nodes = SolidLimbs().spaced(task.plan), task.nodes()
    assert len(spans) == 4
    for start, stop, most in spans:
        inside = (nodes[1:] > start) & (nodes[:-1] < stop)
        assert np.diff(nodes)[inside].max() < 0.75 / task.nodes_per_second
        assert 0.01 < most < 0.06 < stop - start < 0.3
    assert len(SolidLimbs().spaced(make_task("jump", body().human, {}).plan)) == 0


def test_a_heel_that_turns_inwards_is_seen_in_the_ground():
    human = Human.create(joints="43", feet="multi-segment")
    given = ContactBody.for_plan(human, ContactPlan(1.0, ()))
    family, spheres = soles_of(given, 1)
    q = standing_posture(human)[None]
    zero, u = np.zeros_like(q), np.zeros((1, 3 * len(given.sites)))
    flat = values(family, q, zero, zero, u)
    assert np.abs(flat).max() < 2e-3
    heel = [s.name.endswith("heel_front_medial_r") for s in spheres].index(True)
    turned = []
    for angle in (-0.3, 0.3):
        q[0, 6 + human.hinge("heel_inversion_r")] = angle
        turned.append(values(family, q, zero, zero, u)[0, heel])
    assert min(turned) < -0.003
    plain = ContactBody.for_plan(Human.create(joints="43"), ContactPlan(1.0, ()))
    assert soles_of(plain, 1) == (None, ())


def test_limits_of_the_check_do_not_depend_on_the_terms_of_a_task():
    made = solved()
    left_out = (SolidLimbs, Limits, Contact)
    terms = tuple(t for t in made.task.terms if not isinstance(t, left_out))
    loose = replace(made, task=replace(made.task, terms=terms)).limits
    assert loose.overlap == 0.0
    for name in ("coordinate", "velocity", "torque", "force"):
        np.testing.assert_array_equal(getattr(loose, name), getattr(made.limits, name))


def test_a_raised_foot_that_the_row_keeps_off_the_other_thigh_is_off_it():
    """Of people who stand on one leg, at random."""
    human = Human.create(1.74, 71.0, joints="43")
    given = ContactBody(human, ())
    rng, names = np.random.default_rng(4), given.symbolic.names
    q = np.tile(standing_posture(human), (80, 1))
    for name, low, high in (
        ("hip_flexion_r", 0.2, 1.0), ("knee_angle_r", 1.0, 2.2), ("hip_rotation_r", -0.7, 0.2),
        ("hip_adduction_r", -0.2, 0.3),
    ):  # fmt: skip
        q[:, names.index(name)] = rng.uniform(low, high, len(q))
    zero = np.zeros_like(q)
    row = values(legs(given, len(q)), q, zero, zero, np.zeros((len(q), 0)))[:, 0] / ROW_SCALE
    qpos = given.symbolic.to_mujoco(q, zero, zero)[0]
    raised = bodies(human, ("tibia", "foot", "toes"), "_r")
    distance = np.array([apart(human, x, raised, ["femur_l"]) for x in qpos])
    assert (distance < -0.01).any() and (row > 0.0).sum() > 10
    assert distance[row > 0.0].min() > -0.005  # the knee itself is not looked at


def test_arms_that_the_row_keeps_above_the_ground_are_above_it():
    """Of people who bend down, at random."""
    human = Human.create(1.74, 71.0, joints="43")
    given = ContactBody(human, ())
    rng, names = np.random.default_rng(6), given.symbolic.names
    q = np.tile(standing_posture(human), (40, 1))
    q[:, names.index("pelvis_ty")] *= 0.45
    for name, low, high in (
        ("pelvis_tilt", -1.5, 0.0), ("arm_flex_r", 0.0, 1.5), ("elbow_flex_r", 0.0, 1.5),
    ):  # fmt: skip
        q[:, names.index(name)] = rng.uniform(low, high, len(q))
    zero = np.zeros_like(q)
    row = values(arms_above_ground(given, 40), q, zero, zero, np.zeros((40, 0))) / ROW_SCALE
    arm, model = ("humerus", "ulna", "radius", "hand"), human.model
    names = [model.body(int(b)).name for b in model.geom_bodyid]
    drawn, these = model.geom_group == 1, bodies(human, arm, "_r")
    own = [g for g, name in enumerate(names) if drawn[g] and name in these]
    data, lowest, floor = mujoco.MjData(model), [], model.geom("floor").id
    for x in given.symbolic.to_mujoco(q, zero, zero)[0]:
        data.qpos[:] = x
        mujoco.mj_kinematics(model, data)
        lowest.append(min(mujoco.mj_geomDistance(model, data, g, floor, 5.0, None) for g in own))
    distance = np.array(lowest)
    assert (distance < 0.0).any() and (distance > 0.1).any()
    assert distance[row[:, 0] > 0.0].min() > -0.002
    assert np.median(np.abs(distance - row[:, 0])) < 0.01


def test_angular_momentum_is_that_of_mujoco():
    made, human = solved(), body().human
    q, v, a = made.problem.states(made.coefficients, made.problem.nodes)
    builder = ProblemBuilder(body(), made.task.plan, made.problem.nodes)
    AngularMomentum(1.0, 1.0, 1.0).add_to(builder)
    family = builder.family("angular momentum")
    u = np.zeros((len(q), 3 * len(body().sites)))
    rows = values(family, q, v, a, u)
    data, model, d = mujoco.MjData(human.model), human.model, human.dimensions
    unit = human.mass * np.sqrt(9.81) * (d.thigh + d.shank + d.ankle_height) ** 1.5 / 100
    qpos, qvel, _ = body().symbolic.to_mujoco(q, v, a)
    for k in range(0, len(q), 5):
        data.qpos[:], data.qvel[:] = qpos[k], qvel[k]
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        np.testing.assert_allclose(rows[k] * unit, data.subtree_angmom[1], atol=1e-3)


def test_the_way_of_a_turn_turns_with_the_footprints():
    task = make_task("walk", body().human, {"turn": np.pi / 2})
    times = np.linspace(0.0, task.plan.duration, 50)
    way = path_heading(task.plan, times)
    assert way[0] == pytest.approx(0.0, abs=0.25)
    assert way[-1] == pytest.approx(np.pi / 2, abs=0.1)
    assert (np.diff(way) >= -1e-12).all()
    straight = make_task("walk", body().human, {"periodic": True}).plan
    np.testing.assert_allclose(path_heading(straight, times), 0.0, atol=1e-12)
