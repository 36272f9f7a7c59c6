"""Knees and hands on the floor: how they rest, what carries, what the check sees."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plantigrade import check
from plantigrade.analyze.overlap import ground_overlap
from plantigrade.contact.ground import Ground
from plantigrade.contact.limb_sites import KNEELING_PITCH, limb_site
from plantigrade.contact.plan import ContactPlan, PointSupport
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.trajopt import ContactBody, make_task, synthesize
from plantigrade.trajopt.guess.foot_motion import with_toes
from plantigrade.trajopt.guess.lying_leg import LyingLeg
from plantigrade.trajopt.problem.contact import site_places
from plantigrade.trajopt.tasks.settings import GetUpSettings
from plantigrade.trajopt.transcription.derivatives import derivatives_of
from plantigrade.workflows.settings import SolveSettings
from plantigrade.workflows.synthesize import synthesize_task


@cache
def person(feet: str = "two-segment") -> Human:
    return Human.create(1.72, 68.0, joints="42", feet=feet)


def on_knee(height: float = 0.0, friction: float | None = None) -> ContactPlan:
    site, place = limb_site(person(), "knee_l"), (0.0, 0.1, height)
    knee = PointSupport(site, place, -1.0, 2.0, friction=friction, pitch=KNEELING_PITCH)
    return ContactPlan(1.0, (), supports=(knee,))


@cache
def risen(begin: str = "half-kneeling", feet: str = "two-segment") -> Record:
    """A person who gets up, on a coarse mesh."""
    human = person(feet)
    task = replace(make_task("get-up", human, {"begin": begin}), nodes_per_second=14.0)
    made = synthesize(task.body_of(human), task)
    assert made.success
    return made.record()


def knee(record: Record, name: str = "knee_l") -> int:
    return [s.name for s in record.sites].index(name)


def test_a_kneeling_knee_rolls_without_slipping():
    """Rates of its rows are the velocity of the material that touches the floor, by MuJoCo."""
    human, plan = person(), on_knee()
    body = ContactBody.for_plan(human, plan)
    k = [s.name for s in body.sites].index("knee_l")
    q = np.zeros((1, body.symbolic.nv))
    q[0, body.symbolic.names.index("knee_angle_l")] = KNEELING_PITCH
    v = np.random.default_rng(0).normal(size=q.shape)
    zero = np.zeros_like(q)
    rows = derivatives_of(site_places(body, np.zeros((1, len(body.sites))), rates=True).function)
    u, p = np.zeros((1, 3 * len(body.sites))), np.tile([1.0, 0.0], (1, len(body.sites)))
    rate = rows.values(q, v, zero, u, p)[0, 3 * k : 3 * k + 3]
    qpos, qvel, _ = body.symbolic.to_mujoco(q, v, zero)
    state, site = BodyState(human, qpos[0]), limb_site(human, "knee_l")
    centre = PointSet(human, [site.body], np.array([site.position]))
    down = state.rotation(site.body).T @ [0.0, 0.0, -site.radius]
    touching = PointSet(human, [site.body], np.array([site.position]) + down)
    along = (state.jacobian(touching)[0] @ qvel[0])[:2]
    up = (state.jacobian(centre)[0] @ qvel[0])[2]
    # not quite level, as the knee's axis is oblique; without rolling they would be apart
    np.testing.assert_allclose(rate, [*along, up], atol=5e-3)
    assert np.linalg.norm(along - (state.jacobian(centre)[0] @ qvel[0])[:2]) > 0.02


def test_a_support_at_the_height_of_the_floor_is_the_floor():
    assert Ground.of_plan(on_knee()).seats == ()
    assert [seat.site for seat in Ground.of_plan(on_knee(0.1)).seats] == ["knee_l"]
    assert [seat.friction for seat in Ground.of_plan(on_knee(0.0, 0.3)).seats] == [0.3]


def test_toes_that_cannot_bend_do_not_kneel():
    with pytest.raises(ParameterError, match="two-segment"):
        make_task("get-up", Human.create(1.72, 68.0, joints="42", feet="rigid"))


@pytest.mark.parametrize("begin", ["all-fours", "sitting", "lying"])
def test_hands_without_wrists_do_not_lie_on_the_floor(begin):
    with pytest.raises(ParameterError, match="no wrists.*joints='43'.*begin='half-kneeling'"):
        make_task("get-up", Human.create(1.74, 71.0, joints="66"), {"begin": begin})


@pytest.mark.solver
@pytest.mark.parametrize(
    "feet", ["two-segment", pytest.param("multi-segment", marks=pytest.mark.slow)]
)
def test_a_person_stands_up_from_one_knee(feet):
    record = risen(feet=feet)
    k = knee(record)
    verdict = check(record)
    assert verdict.ok, [f.sentence() for f in verdict.findings]
    assert record.contact_force is not None and record.contact_planned is not None
    force, planned = record.contact_force[:, k, 2], record.contact_planned[:, k]
    assert force[planned].max() > 0.2 * record.weight and not force[~planned].any()
    assert force.min() >= 0.0 and not record.ground.seats


def test_toes_of_multi_segment_feet_lie_flat_as_far_as_they_can_bend():
    """The lateral ones bend more than the first; the ankle takes what is left."""
    human, leg = person("multi-segment"), {"mtp_angle": 1.1, "ankle_angle": 0.7}
    bent = with_toes(human, leg)
    assert with_toes(person(), leg) == leg
    assert bent["mtp_angle"] < bent["mtp4_angle"] < human.limits[1, human.hinge("mtp4_angle_r")]
    assert bent["mtp_angle"] + bent["ankle_angle"] == pytest.approx(1.8)
    slightly = with_toes(human, {"mtp_angle": 0.5})
    assert slightly["mtp_angle"] == 0.5 and "ankle_angle" not in slightly


def test_a_first_guess_rests_where_the_plan_has_it():
    task = make_task("get-up", person(), {"side": "l"})
    body, times = task.body_of(person()), np.array([0.0, 0.5, 1.0, 2.0, 2.3])
    q = task.guess(body, task.plan, times)
    at = derivatives_of(site_places(body, np.zeros((5, len(body.sites))), rates=False).function)
    p = np.tile([1.0, 0.0], (5, len(body.sites)))
    rows = at.values(q, 0 * q, 0 * q, np.zeros((5, 3 * len(body.sites))), p).reshape(5, -1, 3)
    for support in task.plan.supports:
        k = [s.name for s in body.sites].index(support.site.name)
        held = times <= support.stop
        np.testing.assert_allclose(
            rows[held, k], np.tile(support.position, (held.sum(), 1)), atol=1e-3
        )


def test_a_stretched_leg_lies_on_its_heel_and_is_drawn_in():
    sitter = Human.create(1.9, 80.0, joints="42", feet="two-segment")
    task = make_task("get-up", sitter, {"begin": "sitting", "side": "l"})
    plan, body = task.plan, task.body_of(sitter)
    heels = {s.site.name[-1]: s for s in plan.supports if s.site.name.startswith("heel")}
    assert heels["l"].stop < heels["r"].stop
    q = task.guess(body, plan, np.array([0.0, 2.2]))
    bent, ahead = body.symbolic.names.index("knee_angle_r"), heels["r"].position[0]
    assert np.rad2deg(q[0, bent]) < 30.0 and np.rad2deg(q[1, bent]) > 100.0
    for side in "rl":
        (foot,) = (s for s in plan.stances if s.footprint.side == side)
        assert foot.heel_strike > heels[side].stop
        assert ahead - foot.footprint.position[0] > 0.5 * sitter.dimensions.thigh
    at = derivatives_of(site_places(body, np.zeros((1, len(body.sites))), rates=False).function)
    p = np.tile([1.0, 0.0], (1, len(body.sites)))
    zero = np.zeros_like(q[:1])
    rows = at.values(q[:1], zero, zero, np.zeros((1, 3 * len(body.sites))), p)
    for support in plan.supports:
        k = [s.name for s in body.sites].index(support.site.name)
        np.testing.assert_allclose(rows.reshape(-1, 3)[k], support.position, atol=1e-3)


@pytest.mark.parametrize("height", [1.3, 1.98])
def test_a_person_who_lies_rests_on_the_back_and_rolls_on_the_buttocks(height):
    lain = Human.create(height, 22.5 * height**2, joints="43", feet="two-segment")
    task = make_task("get-up", lain, {"begin": "lying"})
    plan, body = task.plan, task.body_of(lain)
    names = body.symbolic.names
    stop = {s.site.name: s.stop for s in plan.supports}
    assert stop["head"] < stop["back_r"] == stop["back_l"] < stop["buttock_r"] < stop["hand_l"]
    q = task.guess(body, plan, np.array([0.0, 1.5]))
    at = derivatives_of(site_places(body, np.zeros((2, len(body.sites))), rates=False).function)
    p, zero = np.tile([1.0, 0.0], (2, len(body.sites))), np.zeros_like(q)
    rows = at.values(q, zero, zero, np.zeros((2, 3 * len(body.sites))), p).reshape(2, -1, 3)
    for support in plan.supports:
        k = [s.name for s in body.sites].index(support.site.name)
        np.testing.assert_allclose(rows[0, k], support.position, atol=1e-3)
    tilt = np.rad2deg(q[:, names.index("pelvis_tilt")])
    assert 80.0 < tilt[0] < 90.0 and tilt[1] < 40.0
    qpos = body.symbolic.to_mujoco(q, zero, zero)[0]
    hips, radius = [], limb_site(lain, "buttock_r").radius
    for posture in qpos:
        state = BodyState(lain, posture)
        hips.append(state.position(PointSet(lain, ["femur_r"], np.zeros((1, 3))))[0, 0])
    assert hips[1] - hips[0] == pytest.approx(radius * np.deg2rad(tilt[0] - tilt[1]), abs=0.02)
    state = BodyState(lain, qpos[0])
    bodies = lain.body_names
    origins = state.position(PointSet(lain, bodies, np.zeros((len(bodies), 3))))
    origins = np.vstack([np.zeros(3), origins])[None]
    turns = np.stack([np.eye(3), *(state.rotation(name) for name in bodies)])[None]
    deep = ground_overlap(lain, origins, turns, Ground())
    depth = dict(zip(deep.names, deep.depth[0], strict=True))
    for part in ("pelvis", "abdomen", "thorax", "head"):  # near the floor, and not in it
        assert -0.03 < depth[f"{part} in the ground"] < 1e-4


def test_a_leg_on_its_heel_reaches_as_far_as_its_knee_lets_it():
    leg = LyingLeg(person(), 0.09)
    assert leg.knee(leg.reach(0.7)) == pytest.approx(0.7, abs=1e-3)
    assert leg.reach(0.1) > leg.reach(0.7) > leg.reach(1.4)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("height, mass, side", [(1.3, 28.0, "r"), (1.74, 71.0, "l")])
def test_a_person_gets_up_from_lying_on_the_back(height, mass, side):
    parts = ("head", "back_l", "back_r", "buttock_l", "buttock_r", "heel_behind_l", "hand_r")
    record, shares = checked_rise("lying", height, mass, side, parts)
    assert 0.9 < shares.sum() < 1.0 and shares.min() > 0.003
    names = list(record.human.coordinates)
    spine = [7 + names.index(f"{n}_extension") for n in ("lumbar", "neck")]
    begins = record.motion.time < 1.5
    assert np.abs(record.motion.qpos[begins][:, spine]).max() < np.deg2rad(60.0)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("height, mass, side", [(1.3, 28.0, "r"), (1.74, 71.0, "l")])
def test_a_person_gets_up_from_sitting_on_the_floor(height, mass, side):
    parts = ("seat_l", "seat_r", "heel_behind_l", "heel_behind_r", "hand_l", "hand_r")
    _, shares = checked_rise("sitting", height, mass, side, parts)
    assert shares.sum() == pytest.approx(1.0, abs=0.02) and shares.min() > 0.005


def checked_rise(
    begin: str, height: float, mass: float, side: str, parts: tuple[str, ...]
) -> tuple[Record, np.ndarray]:
    """Return a checked rise that leans aside by less than 20°, and the first loads of parts [1]."""
    human = Human.create(height, mass, joints="43", feet="two-segment")
    task = make_task("get-up", human, {"begin": begin, "side": side})
    record = synthesize(task.body_of(human), task).record()
    verdict = check(record)
    assert verdict.ok, [f.sentence() for f in verdict.findings]
    assert record.contact_force is not None and not record.ground.seats
    assert max(aside(record, "head"), aside(record, human.trunk)) < np.deg2rad(20.0)
    return record, record.contact_force[0, [knee(record, n) for n in parts], 2] / record.weight


def aside(record: Record, part: str) -> float:
    """Return how far the upward axis of a part leans to a side at most [rad]."""
    human = record.human
    up = [BodyState(human, q).rotation(part)[1, 2] for q in record.motion.qpos[::5]]
    return float(np.arcsin(np.abs(up).max()))


@pytest.mark.slow
@pytest.mark.solver
def test_a_person_gets_up_from_hands_and_knees():
    record = risen("all-fours")
    verdict = check(record)
    assert verdict.ok, [f.sentence() for f in verdict.findings]
    assert record.contact_force is not None
    parts = ("hand_l", "hand_r", "knee_l", "knee_r", "toes_l")
    shares = record.contact_force[0, [knee(record, n) for n in parts], 2] / record.weight
    assert shares.sum() == pytest.approx(1.0, abs=0.02) and shares.min() > 0.02
    assert max(aside(record, "head"), aside(record, record.human.trunk)) < np.deg2rad(20.0)
    lumbar = np.rad2deg(record.motion["lumbar_extension"])
    assert -45.0 < lumbar.min() and lumbar.max() < 5.0  # hollow by 31° once


@pytest.mark.solver
def test_the_check_sees_what_a_knee_does_wrong():
    record, k = risen(), knee(risen())
    assert record.contact_force is not None and record.contact_planned is not None
    planned, force = record.contact_planned.copy(), record.contact_force.copy()
    planned[:, k] = True
    assert "hover" in {f.quantity for f in check(replace(record, contact_planned=planned)).findings}
    force[:, k] *= 1.3
    faults = {f.quantity for f in check(replace(record, contact_force=force)).findings}
    assert {"root_force", "momentum"} & faults
    qpos = record.motion.qpos - [0.0, 0.0, 0.004, *np.zeros(record.motion.qpos.shape[1] - 3)]
    sunk = replace(record, motion=replace(record.motion, qpos=qpos))
    names = " ".join(f.sentence() for f in check(sunk).findings)
    assert "knee l" in names and "inside the ground" in names


@pytest.mark.parametrize("begin", ["all-fours", "half-kneeling", "sitting"])
def test_a_motion_on_the_floor_that_no_controller_knows_is_refused_before_it_is_solved(begin):
    with pytest.raises(ParameterError, match="on the floor, and replay"):
        synthesize_task(GetUpSettings(begin=begin), SolveSettings(replay=True))
