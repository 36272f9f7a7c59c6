"""Wrenches on a body and hands on a thing: dynamics, record and check, against MuJoCo."""

import mujoco
import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands.synthesize import parse
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import PUSH_PART, Point, foot_sites
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.errors import ParameterError
from plantigrade.trajopt import ContactBody, make_task
from plantigrade.trajopt.problem.dynamics import asked_by
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.terms.external import Hold, Wrench
from tests.models.presets import person

HUMAN = person("42", "two-segment")
PULL = Wrench(Point("hand_r", (0.01, 0.02, -0.08)), (30.0, -20.0, 50.0), (4.0, 5.0, -6.0))


def test_a_wrench_takes_from_the_torques_what_mujoco_says():
    rng = np.random.default_rng(1)
    plan, feet = ContactPlan(1.0, ()), foot_sites(HUMAN)
    bare, pulled = (ContactBody(HUMAN, feet, plan=plan, wrenches=w) for w in ((), (PULL,)))
    n = bare.symbolic.nv
    q, v, a = (scale * rng.standard_normal((1, n)) for scale in (0.3, 1.0, 5.0))
    none, now = np.zeros((1, 3 * len(feet))), np.array([0.3])
    (root, tau), (pulled_root, pulled_tau) = (
        asked_by(bare, q, v, a, none),
        asked_by(pulled, q, v, a, none, now),
    )
    m = without_constraints(HUMAN)
    d, force = mujoco.MjData(m), np.zeros(n)
    d.qpos[:] = bare.symbolic.to_mujoco(q, v, a)[0][0]
    mujoco.mj_forward(m, d)
    body = HUMAN.body("hand_r")
    at = d.xpos[body] + d.xmat[body].reshape(3, 3) @ PULL.point.position
    mujoco.mj_applyFT(m, d, np.array(PULL.force), np.array(PULL.moment), at, body, force)
    np.testing.assert_allclose((tau - pulled_tau)[0], force[6:], atol=1e-9)
    np.testing.assert_allclose((root - pulled_root)[0, :3] * bare.weight, PULL.force, atol=1e-9)


def test_a_wrench_comes_and_goes():
    pull = Wrench(PULL.point, (10.0, 0.0, 0.0), start=0.5, stop=1.0)
    found = pull.values(np.array([0.3, 0.5, 0.8, 1.0, 1.2]), ContactPlan(2.0, ()))[:, 0]
    np.testing.assert_allclose(found, [0.0, 10.0, 10.0, 10.0, 0.0])


def test_a_pull_to_one_side_takes_a_whole_stride():
    walk = make_task("walk", HUMAN, {"periodic": True})
    for words, half in (("pelvis=-30,0,0", True), ("trunk=0,30,0", False)):
        task = Impairments(wrench=(words,)).task(HUMAN, walk)
        assert task.plan.mirrored is half
        assert len(task.body_of(HUMAN).external.wrenches) == 1
    both = walk.with_terms(PULL, PULL.mirrored())
    assert both.plan.mirrored
    assert PULL.mirrored().mirrored() == PULL


def test_a_cart_is_held_by_both_hands_and_pushes_back():
    task = make_task("walk", HUMAN, {"periodic": True, "cart_force": 60.0})
    assert sum(w.force[0] for w in task.wrenches) == -60.0
    assert len([t for t in task.terms if isinstance(t, Hold)]) == 2
    assert task.plan.mirrored
    task.problem(task.body_of(HUMAN))
    with pytest.raises(ParameterError, match="cart_force needs periodic"):
        make_task("walk", HUMAN, {"cart_force": 60.0})


def test_a_body_without_the_wrench_of_the_task_is_refused():
    task = make_task("walk", HUMAN, {"periodic": True}).with_terms(PULL, PULL.mirrored())
    with pytest.raises(ParameterError, match="task.body_of"):
        task.problem(ContactBody.for_plan(HUMAN, task.plan))
    gust = Wrench(PULL.point, (5.0, 0.0, 0.0), start=0.1)
    task = make_task("walk", HUMAN, {"periodic": True}).with_terms(gust)
    with pytest.raises(ParameterError, match="leave out start and stop"):
        task.problem(task.body_of(HUMAN))
    assert parse(["walk", "--wrench", "pelvis=1,2,3"]).wrench == ("pelvis=1,2,3",)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "force"),
    [
        ({"wrench": ("pelvis=-50,0,0",)}, (-50.0, 0.0)),
        ({"wrench": ("trunk=0,20,0",)}, (0.0, 20.0)),
        ({"cart_force": 80.0}, (-80.0, 0.0)),
    ],
)
def test_a_walk_under_force_passes_the_check_and_the_ground_gives_it(options, force, tmp_path):
    run = pg.synthesize("walk", periodic=True, speed=1.1, **options)
    assert run.status == "ok", run.status
    run.save(tmp_path / "walk")
    record = pg.Run.load(tmp_path / "walk").record
    steps = np.diff(record.motion.time)[:, None]
    total = sum(record.foot(side).force[:, :2] for side in "rl")
    mean = ((total[1:] + total[:-1]) / 2 * steps).sum(axis=0) / steps.sum()
    np.testing.assert_allclose(mean, np.negative(force), atol=1.5)
    pushes = [k for k, site in enumerate(record.sites) if site.part == PUSH_PART]
    given = record.contact_force[:, pushes].sum(axis=1)
    np.testing.assert_allclose(given[:, :2], np.tile(force, (len(given), 1)), atol=1e-9)
