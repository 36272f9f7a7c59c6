"""A walk from nothing but a speed: what physics says of any periodic, symmetric gait."""

from itertools import pairwise

import numpy as np
import pytest

from plantigrade import check
from plantigrade.contact.ground import Ground
from plantigrade.dynamics.centroid import centroid
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import ContactBody, ProblemBuilder, make_task
from plantigrade.trajopt.problem.contact import site_targets, soles_of
from plantigrade.trajopt.tasks.walking import PELVIS_LEAN
from plantigrade.trajopt.terms.contact import Clearance, Contact
from plantigrade.trajopt.terms.posture import Posture, Rest
from plantigrade.trajopt.transcription.mesh import nodes_of
from tests.models.presets import other_side
from tests.trajopt.coarse_walk import SPEED, person, solved

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def stride():
    """Two laps, which are a stride, finely sampled."""
    s = solved()
    return s.sample(s.times(10, periods=2))


def integral(t, x):
    """Trapezoidal mean of a series over its duration."""
    return np.trapezoid(x, t, axis=0) / (t[-1] - t[0])


def test_it_is_solved_and_the_checker_has_nothing_against_it(stride):
    assert solved().success
    verdict = check(solved().record())
    assert verdict.ok, verdict.words()


def test_the_ground_carries_body_weight_on_average(stride):
    """Momentum is the same after a stride, so impulses of ground and gravity cancel."""
    weight = person().mass * 9.81
    mean = integral(stride.time, stride.force.sum(axis=1)) / weight
    np.testing.assert_allclose(mean, [0.0, 0.0, 1.0], atol=5e-3)


def test_forces_are_what_the_centre_of_mass_needs(stride):
    whole = centroid(person(), stride.qpos, stride.qvel, stride.qacc)
    assert whole.force is not None
    off = np.linalg.norm(stride.force.sum(axis=1) - whole.force, axis=1)
    weight = person().mass * 9.81
    assert off.max() < 0.01 * weight
    assert np.sqrt(np.mean(off**2)) < 0.003 * weight


def test_it_has_the_requested_speed(stride):
    way = stride.qpos[-1, :3] - stride.qpos[0, :3]
    assert way[0] / stride.time[-1] == pytest.approx(SPEED, rel=1e-6)
    np.testing.assert_allclose(way[1:], 0.0, atol=1e-9)


def test_it_goes_on_without_a_seam():
    """Positions, velocities, accelerations and forces just before and after the end of a lap."""
    s = solved()
    end, h = s.task.plan.duration, 1e-6
    for lap in (1, 2):
        x = s.sample(np.array([lap * end - h, lap * end, lap * end + h]))
        np.testing.assert_allclose(np.diff(x.qpos, axis=0), 0.0, atol=1e-4)
        np.testing.assert_allclose(np.diff(x.qvel, axis=0), 0.0, atol=2e-2)
        np.testing.assert_allclose(x.qacc[0], x.qacc[2], atol=5e-3 * np.abs(x.qacc).max())
        assert np.abs(np.diff(x.force, axis=0)).max() < 5.0


def test_after_a_lap_left_is_what_right_was(stride):
    """In MuJoCo's variables, joint by joint; forces site by site."""
    s = solved()
    n = len(stride.time) // 2
    names = list(person().coordinates)
    for i, name in enumerate(names):
        j = names.index(other_side(name))
        sign = -1.0 if name.endswith(("_bending", "_rotation")) and name == names[j] else 1.0
        one, other = stride.qpos[:n, 7 + i], stride.qpos[n : 2 * n, 7 + j]
        np.testing.assert_allclose(other, sign * one, atol=1e-9, err_msg=name)
    np.testing.assert_allclose(stride.qpos[n : 2 * n, 2], stride.qpos[:n, 2], atol=1e-9)
    sites = [x.name for x in s.body.sites]
    pair = [sites.index(other_side(name)) for name in sites]
    mirrored = stride.force[:n, pair] * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(stride.force[n : 2 * n], mirrored, atol=2.0)
    assert stride.force[:n, :, 2].max() > 100


def test_feet_stand_on_their_footprints_at_nodes():
    s = solved()
    q, v, _ = s.problem.states(s.coefficients, s.problem.nodes)
    place = next(r for r in s.problem.rows if r.name == "contact")
    heights = place.lower[:, 2::3]
    assert np.isfinite(heights).any()
    points = s.body.symbolic.positions(list(s.body.sites))
    low = np.array([np.asarray(points(x)).T for x in q])
    for stance in s.task.plan.stances:
        targets = site_targets(s.body, stance.footprint)
        for k, site in enumerate(s.body.sites):
            if site.side == stance.footprint.side:
                start, stop = stance.interval(site.part)
                down = (s.problem.nodes >= start - 1e-9) & (s.problem.nodes <= stop + 1e-9)
                np.testing.assert_allclose(low[down, k, 2], targets[site.name][2], atol=1e-4)
                turned = np.abs(low[down, k, :2] - targets[site.name][:2])
                assert turned.max(initial=0.0) < 2.5 * site.radius  # it rolls, no farther


def test_force_is_only_where_a_place_stands_and_starts_from_nothing():
    s = solved()
    fine = s.sample(s.times(10))
    assert not fine.force[~fine.standing].any()
    force = s.forces.reshape(len(s.problem.nodes), -1, 3)
    for k, site in enumerate(s.body.sites):
        for start, stop in s.task.plan.intervals(site):
            for end in (start, stop):
                at = np.abs(s.problem.nodes - end) < 1e-9
                assert np.abs(force[at, k]).max(initial=0.0) < 1e-9


def test_it_looks_like_walking(stride):
    """Heel before toe, one or two feet on the ground at any time, knees that bend in swing."""
    down = stride.force[:, :, 2] > 20.0
    sides = np.array([s.side for s in solved().body.sites])
    feet = np.stack([down[:, sides == side].any(axis=1) for side in "rl"], axis=1)
    assert feet.any(axis=1).all()  # no flight
    assert 0.1 < feet.all(axis=1).mean() < 0.4  # double support
    knee = np.rad2deg(stride.qpos[:, 7 + person().coordinates.index("knee_angle_r")])
    assert 45 < knee.max() < 80 and knee[feet[:, 1] & ~feet[:, 0]].max() == knee.max()
    assert np.ptp(stride.qpos[:, 2]) < 0.08  # the pelvis goes up and down by some centimetres


def test_what_is_no_walk_is_refused():
    human = person()
    for given, words in (
        ({"speed": 9.0}, "speed"),
        ({"periodic": True, "turn": 0.5}, "a periodic walk is straight"),
        ({"periodic": True, "step_height": 0.1}, "straight and on even ground"),
        ({"slope": 0.8}, "slope must be -20–20 degrees"),
        ({"slope": 0.1, "turn": 0.2}, "turn and slope cannot be combined"),
        ({"step_height": 0.1, "heights": [0.0] * 4}, "cannot be combined"),
        ({"heights": [0.0] * 3, "steps": 4}, "3 heights for 4 steps"),
        ({"turn": 3.0, "steps": 2}, "is 172° for each step .* take more steps"),
        ({"step_height": 0.9}, "steps .* at most"),
        ({"steps": 1}, "from 2 to 200"),
    ):
        with pytest.raises(ParameterError, match=words):
            make_task("walk", human, given)


def test_a_walk_from_standing_starts_and_ends_at_rest():
    task = make_task("walk", person(), {"speed": 1.0, "steps": 3})
    times = sorted(t.time for t in task.terms if isinstance(t, Rest))
    assert times == [0.0, task.plan.duration]
    assert not task.plan.periodic
    for side in "rl":
        assert task.plan.footprint(side, 0.0) and task.plan.footprint(side, task.plan.duration)


def test_upright_on_a_slope_is_upright_in_the_world():
    for slope in (0.2, -0.2):
        terms = make_task("walk", person(), {"slope": slope}).terms
        posture = next(t for t in terms if isinstance(t, Posture))
        assert posture.targets["pelvis_tilt"] == pytest.approx(-PELVIS_LEAN - slope)


def test_every_change_of_contact_is_a_node():
    for human in (person(), Human.create(1.9, 95.0, joints="42", feet="rigid")):
        plan = make_task("walk", human, {"speed": 0.8, "steps": 2}).plan
        nodes = nodes_of(plan, 13.0)
        assert np.abs(plan.switches[:, None] - nodes).min(axis=1).max() < 1e-9


def test_the_clearance_of_a_foot_rises_gradually():
    """One that stood has no acceleration as it leaves, however high it is to be later."""
    task = make_task("side-step", person(), {"clearance": 0.3})
    for c in (c for c in task.conditions(solved().body) if c.quantity == "clearance"):
        part = (np.array(c.time) - c.time[0]) / (c.time[-1] - c.time[0])
        assert max(c.lower) == pytest.approx(0.3)
        assert np.all(np.array(c.lower[:3]) <= 5 * part[:3] ** 3)


def test_parts_of_the_sole_that_carry_nothing_clear_a_step_too():
    human = Human.create(joints="42", feet="multi-segment")
    task = make_task("walk", human, {"step_height": 0.1})
    given = ContactBody.for_plan(human, task.plan)
    builder = ProblemBuilder(given, task.plan, task.nodes())
    Contact().add_to(builder)
    Clearance().add_to(builder)
    low, side = builder.family("soles").lower, task.plan.stances[-1].footprint.side
    before, after = [s for s in task.plan.stances if s.footprint.side == side][-2:]
    assert before.footprint.position[2] < after.footprint.position[2]
    late = (builder.nodes > after.heel_strike - 0.1) & (builder.nodes < after.heel_strike)
    own = [k for k, s in enumerate(soles_of(given, 1)[1]) if s.side == side]
    assert own and low[late][:, own].min() > 0.09


@pytest.mark.parametrize("rise", [0.17, -0.17])
def test_a_swing_foot_passes_every_edge_of_a_stair_round_its_corner(rise):
    """At one node it is above the tread and not yet beyond the edge, or no longer before it."""
    human = Human.create(joints="43")
    heights = (rise, 2 * rise, 3 * rise, 3 * rise)
    task = make_task("walk", human, {"heights": heights, "speed": 0.8})
    given = ContactBody.for_plan(human, task.plan)
    builder = ProblemBuilder(given, task.plan, task.nodes())
    Clearance(0.01).add_to(builder)
    contact, nodes = builder.family("contact"), builder.nodes
    low, near, far = contact.lower[:, 2::3], contact.upper[:, ::3], contact.lower[:, ::3]
    steps, corners = Ground.of_plan(task.plan).steps, 0
    for side in "rl":
        stances = [s for s in task.plan.stances if s.footprint.side == side]
        for one, two in pairwise(stances):
            swing = (nodes > one.toe_off) & (nodes < two.heel_strike)
            here, there = one.footprint.position, two.footprint.position
            passed = [s for s in steps if here[0] < s.x < there[0]]
            assert len(passed) == round(abs(there[2] - here[2]) / abs(rise))
            for site in (k for k, s in enumerate(given.sites) if s.side == side):
                z = low[swing, site]
                assert np.all(np.diff(z) * np.sign(rise) > -0.02)  # up or down all the way
                for step in passed:
                    if rise > 0:
                        corner = (near[swing, site] < step.x) & (z >= step.height)
                    else:
                        corner = (far[swing, site] > step.x) & (z >= step.height - rise)
                    corners += corner.any()
    assert corners == 2 * 3 * len([s for s in given.sites if s.side == "r"])


def test_palms_face_the_thighs():
    """People walk with forearms pronated by about 80°; at 0° the palms face forward."""
    motion = solved().record().motion
    for side in ("r", "l"):
        assert 60.0 < np.rad2deg(motion[f"pro_sup_{side}"]).mean() < 100.0
