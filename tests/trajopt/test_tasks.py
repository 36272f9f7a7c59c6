"""Tasks other than walking: what physics says about them, on coarse meshes."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from plantigrade import check
from plantigrade.analyze.feet import foot_path
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import Footprint, Stance, alternates
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import (
    TASKS,
    ContactBody,
    ProblemBuilder,
    make_task,
    parse_task_file,
    read_task_file,
    synthesize,
)
from plantigrade.trajopt.tasks.settings import JumpSettings
from plantigrade.trajopt.terms.contact import Contact, Dynamics
from plantigrade.trajopt.terms.effort import Torque
from plantigrade.trajopt.terms.limits import Within
from plantigrade.trajopt.terms.obstacle import StepOver
from plantigrade.trajopt.terms.posture import LumbopelvicRhythm, Posture, Rest
from plantigrade.trajopt.terms.term import one_sided

GRAVITY = 9.81
PUSH = JumpSettings().push


def rise_after(s, time):
    """How far the centre of mass would rise freely from a time on [m]."""
    q, v, _ = s.problem.states(s.coefficients, np.array([time]))
    symbolic = s.body.symbolic
    up = float(np.asarray(symbolic.momentum()(q[0], v[0])[0]).ravel()[2]) / symbolic.mass
    return max(up, 0.0) ** 2 / (2 * GRAVITY)


@cache
def person() -> Human:
    return Human.create(1.72, 68.0, joints="42", feet="rigid")


@cache
def solved(name: str, nodes_per_second: float):
    task = replace(make_task(name, person()), nodes_per_second=nodes_per_second)
    return synthesize(ContactBody.for_plan(person(), task.plan), task)


def at_nodes(s):
    """Coordinates and centre of mass (position, velocity) at nodes; forces there (n, sites, 3)."""
    q, v, _ = s.problem.states(s.coefficients, s.problem.nodes)
    symbolic = s.body.symbolic
    com = np.array([np.asarray(symbolic.com()(x)).ravel() for x in q])
    speed = np.array(
        [np.asarray(symbolic.momentum()(x, y)[0]).ravel() for x, y in zip(q, v, strict=True)]
    )
    return q, com, speed / symbolic.mass, s.forces.reshape(len(q), -1, 3)


def column(s, q, name):
    return q[:, s.problem.names.index(name)]


@pytest.mark.slow
@pytest.mark.solver
def test_a_run_flies_between_its_steps_and_lands_on_bent_knees():
    s = solved("run", 60.0)
    assert s.success
    record = s.record()
    assert check(record).ok, check(record).status
    t, up = record.motion.time, record.contact_force[:, :, 2].sum(axis=1) / record.weight
    flies = np.trapezoid(1.0 - record.contact_planned.any(axis=1), t) / t[-1]
    contact = s.task.plan.stances[0].toe_off
    assert flies == pytest.approx(1.0 - contact / s.task.plan.duration, abs=0.02)
    assert np.trapezoid(up, t) / t[-1] == pytest.approx(1.0, abs=0.01)  # as it does not rise
    assert 2.0 < up.max() < 2.6  # 2.2 in a recorded runner at this speed
    strikes = [e for e in record.motion.events if e.kind == "heel_strike"]
    for e in strikes:
        knee = np.interp(e.time, t, record.motion[f"knee_angle_{e.side}"])
        assert knee >= np.deg2rad(15.0) - 1e-4
    steps = np.diff([e.time for e in strikes])
    np.testing.assert_allclose(steps, s.task.plan.duration, atol=1e-6)


@pytest.mark.parametrize("soft", [True, False])
def test_the_heel_lands_at_rest_only_if_the_task_says_so(soft):
    task = make_task("run", person())
    first = next(t for t in task.terms if isinstance(t, Contact))
    task = replace(task, terms=(Dynamics(), replace(first, soft_landing=soft)))
    body = ContactBody.for_plan(person(), task.plan)
    nodes = np.linspace(0.0, task.plan.duration, 20)[:-1]
    b = ProblemBuilder(body, task.plan, nodes)
    task.terms[1].add_to(b)
    speed = b.family("contact speed")
    fixed = [n for n, low in zip(speed.names, speed.lower[0], strict=True) if low == 0.0]
    assert bool(fixed) == soft and all("heel" in n for n in fixed)


def test_a_run_takes_shorter_contacts_and_quicker_steps_when_faster():
    slow, fast = (make_task("run", person(), {"speed": v}).plan for v in (2.2, 5.0))
    assert 0.30 < slow.stances[0].toe_off < 0.36 and 0.18 < fast.stances[0].toe_off < 0.23
    assert slow.stances[0].toe_off < slow.duration and fast.duration < slow.duration
    assert fast.advance == pytest.approx(5.0 * fast.duration)
    own = make_task("run", person(), {"cadence": 180.0}).plan
    assert own.duration == pytest.approx(1.0 / 3.0)
    with pytest.raises(ParameterError, match="speed"):
        make_task("run", person(), {"speed": 6.0})
    file = parse_task_file('[task]\nbase = "run"\n[parameters]\nspeed = 4.0\n')
    assert file.task(person()).plan.advance == pytest.approx(
        4.0 * file.task(person()).plan.duration
    )


@pytest.mark.parametrize("legs", ["both", "r", "l"])
def test_a_hop_lands_after_as_long_a_flight_as_its_height_takes(legs):
    plan = make_task("hop", person(), {"legs": legs, "hop_height": 0.05}).plan
    flight = plan.duration - plan.stances[0].toe_off
    assert GRAVITY * flight**2 / 8 == pytest.approx(0.05, rel=1e-3)
    assert {s.footprint.side for s in plan.stances} == ({"r", "l"} if legs == "both" else {legs})
    assert plan.periodic and plan.advance == 0.0 and not alternates(plan)


def test_a_hop_too_high_for_its_rate_is_refused():
    with pytest.raises(ParameterError, match=r"hop 0\.11 m high at most"):
        make_task("hop", person(), {"hop_height": 0.2})


@pytest.mark.wrong_types
def test_a_hop_on_legs_that_nobody_has_is_refused():
    with pytest.raises(ParameterError, match="legs"):
        make_task("hop", person(), {"legs": "left"})


@pytest.mark.slow
@pytest.mark.solver
def test_a_hop_on_one_leg_stays_on_it():
    task = replace(make_task("hop", person(), {"legs": "l"}), nodes_per_second=60.0)
    s = synthesize(ContactBody.for_plan(person(), task.plan), task)
    record = s.record(strides=2)
    assert check(record).ok, check(record).status
    assert record.motion.events == ()  # no gait
    force = record.contact_force.sum(axis=0)[:, 2]
    sides = np.array([site.side for site in record.sites])
    assert force[sides == "r"].sum() == 0.0 and force[sides == "l"].sum() > 0.0
    t, up = record.motion.time, record.contact_force[:, :, 2].sum(axis=1) / record.weight
    assert np.trapezoid(up, t) / t[-1] == pytest.approx(1.0, abs=0.01)
    assert 2.5 < up.max() < 3.6


def test_a_block_lies_between_two_footprints_and_is_ground_for_the_check():
    plan = make_task("walk", person(), {"obstacle_height": 0.2, "speed": 1.0}).plan
    (block,) = plan.obstacles
    ground = Ground.of_plan(plan)
    assert ground.along(np.array([block.x])) == pytest.approx(0.2)
    feet = np.array([s.footprint.position[0] for s in plan.stances])
    assert np.all(ground.along(feet + 0.07, 0.2) == 0.0)  # from heel to toes
    with pytest.raises(ParameterError, match="leave no room"):
        make_task("walk", person(), {"obstacle_height": 0.2, "speed": 0.3})
    with pytest.raises(ParameterError, match="even ground"):
        make_task("walk", person(), {"obstacle_height": 0.2, "periodic": True})


def test_only_the_steps_over_a_block_take_longer_the_higher_the_longer():
    even, low, high = (
        make_task("walk", person(), {"obstacle_height": h, "steps": 6}).plan
        for h in (0.0, 0.1, 0.4)
    )
    strikes = [np.array([s.heel_strike for s in plan.stances]) for plan in (even, low, high)]
    first, second, third = (np.diff(each)[1:] for each in strikes)
    assert (second - first > 0.01).sum() == 2 and (third - second > 0.01).sum() == 2
    np.testing.assert_allclose((third - first).sum(), 4.0 * (second - first).sum())
    (block,) = low.obstacles
    swings = [x for x in StepOver().spaced(low) if x[0] < x[1]]
    assert len(swings) == 2  # both feet, once
    for plan in (low, high):
        for side in "rl":
            own = [s for s in plan.stances if s.footprint.side == side]
            assert all(a.toe_off < b.heel_strike for a, b in pairwise(own))


@pytest.mark.parametrize("height", [0.2, 0.4])
def test_the_first_guess_lifts_feet_over_a_block_no_higher_than_legs_bend(height):
    """Lifted most in the middle of its swing, the foot came to the hip, and the leg turned."""
    task = make_task("walk", person(), {"obstacle_height": height, "speed": 1.0})
    times = np.linspace(0.0, task.plan.duration, round(40 * task.plan.duration) + 1)
    q = task.guess(ContactBody.for_plan(person(), task.plan), task.plan, times)
    for side in "rl":
        hips = [6 + person().hinge(f"hip_{n}_{side}") for n in ("flexion", "adduction", "rotation")]
        assert np.abs(np.diff(q[:, hips], axis=0)).max() < np.deg2rad(20.0)


def test_what_stands_beside_a_block_need_not_be_above_its_hill():
    """At 0.8 m/s the heel lands where the hill of 44 cm is 3 mm high: both cannot hold."""
    task = make_task("walk", person(), {"obstacle_height": 0.4, "speed": 0.8})
    body = task.body_of(person())
    problem = task.problem(body)
    (hill,) = (rows for rows in problem.rows if rows.name.startswith("obstacle"))
    for k, site in enumerate(s for s in body.sites if s.side):
        stands = task.plan.standing(site, problem.nodes)
        assert stands.any() and not stands.all()
        np.testing.assert_array_equal(np.isneginf(hill.lower[:, k]), stands)
    assert np.isfinite(hill.lower[:, hill.lower.shape[1] - 1]).all()  # a shank


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize(
    ("height", "steps", "speed"), [(0.1, 2, 1.3), (0.4, 2, 1.3), (0.4, 4, 1.3), (0.4, 4, 0.8)]
)
def test_both_feet_pass_over_a_block(height, steps, speed):
    given = {"obstacle_height": height, "steps": steps, "speed": speed}
    task = make_task("walk", person(), given)
    s = synthesize(ContactBody.for_plan(person(), task.plan), task)
    record = s.record()
    assert check(record).ok, check(record).status
    (block,) = task.plan.obstacles
    heel = foot_path(record.human, record.motion.qpos).heel
    for foot in heel.swapaxes(0, 1):
        over = np.abs(foot[:, 0] - block.x) < block.width / 2
        assert over.any() and foot[over, 2].min() > height


@pytest.mark.solver
def test_the_seat_carries_while_seated_and_nothing_after():
    s = solved("sit-to-stand", 12.0)
    assert s.success
    q, _, _, force = at_nodes(s)
    seat = [k for k, site in enumerate(s.body.sites) if not site.side]
    assert len(seat) == 2
    load = force[:, seat, 2].sum(axis=1)
    start, stop = s.task.plan.supports[0].start, s.task.plan.supports[0].stop
    t = s.problem.nodes
    away = (t <= start) | (t >= stop)
    assert np.abs(load[away]).max() < 1e-9
    assert load[0] > 0.5  # sitting still, most weight is on the chair
    total = force[:, :, 2].sum(axis=1)
    assert total[[0, -1]] == pytest.approx(1.0, abs=0.08)  # nearly no acceleration at the ends


def test_sitting_down_is_standing_up_in_reverse():
    up, down = (make_task(n, person()) for n in ("sit-to-stand", "stand-to-sit"))
    one, other = up.plan.supports[0], down.plan.supports[0]
    assert other.start == pytest.approx(down.plan.duration - one.stop)
    assert other.position == one.position


@pytest.mark.solver
def test_people_lean_forward_before_they_leave_the_seat():
    s = solved("sit-to-stand", 12.0)
    _, com, _, _ = at_nodes(s)
    off = s.task.plan.supports[0].stop
    k = int(np.argmin(np.abs(s.problem.nodes - off)))
    assert com[k, 0] - com[0, 0] > 0.08


@pytest.mark.solver
@pytest.mark.parametrize("name", ["squat", "side-step"])
def test_feet_stay_where_they_stand(name):
    s = solved(name, 12.0)
    assert s.success
    times = s.times(4)
    q, _, _ = s.problem.states(s.coefficients, np.clip(times, 0, s.problem.basis.stop))
    points = s.body.symbolic.positions(list(s.body.sites))
    place = np.array([np.asarray(points(x)).T for x in q])
    for k, site in enumerate(s.body.sites):
        for start, stop in s.task.plan.intervals(site):
            at = (times >= start) & (times <= stop)
            assert np.ptp(place[at, k], axis=0).max() < 2e-3


@pytest.mark.solver
@pytest.mark.parametrize("name", ["squat", "side-step", "sit-to-stand", "reach"])
def test_neck_and_forearms_stay_relaxed(name):
    """Neck and forearms bear so little that torques alone let them drift: by 47° and 66° once."""
    s = solved(name, 12.0)
    assert s.success
    q, _, _, _ = at_nodes(s)
    assert np.rad2deg(np.abs(column(s, q, "neck_extension")).max()) <= 20.0
    for side in "rl":
        assert np.rad2deg(np.ptp(column(s, q, f"pro_sup_{side}"))) <= 15.0


@pytest.mark.solver
@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("squat", 13.0, 26.0),
        ("sit-to-stand", 13.0, 35.0),
        ("reach", 0.0, 10.0),
        ("side-step", 0.0, 15.0),
    ],
)
def test_the_back_flexes_with_the_hips_as_in_people_and_is_never_hollow(name, least, most):
    """Squats of people flex the lumbar spine by 13° (women) to 26° (men) [McKean2010]."""
    s = solved(name, 12.0)
    q, _, _, _ = at_nodes(s)
    lumbar = np.rad2deg(column(s, q, "lumbar_extension"))
    assert least <= -lumbar.min() <= most
    assert lumbar.max() <= 2.0


def test_the_lumbopelvic_rhythm_costs_nothing_where_the_back_follows_the_hips():
    human = person()
    task = make_task("squat", human)
    b = ProblemBuilder(task.body_of(human), task.plan, np.linspace(0.0, 2.5, 6))
    LumbopelvicRhythm(weight=2.0, ratio=0.25).add_to(b)
    family = b.family("lumbopelvic rhythm")
    q, zero = np.zeros((1, len(b.names))), np.zeros((1, len(b.names)))
    q[0, b.column("hip_flexion_r")], q[0, b.column("hip_flexion_l")] = 1.2, 0.4

    def row(lumbar):
        q[0, b.column("lumbar_extension")] = lumbar
        forces = np.zeros((1, 3 * len(b.body.sites)))
        return float(family.function(q[0], zero[0], zero[0], forces[0], [])[0])

    assert row(-0.2) == pytest.approx(0.0)
    assert row(0.1) == pytest.approx(0.3)
    np.testing.assert_allclose(family.weight[:, 0], 4.0 * b.weights)


@pytest.mark.solver
def test_a_squat_has_the_requested_depth_and_is_symmetric():
    s = solved("squat", 12.0)
    q, _, _, _ = at_nodes(s)
    height = column(s, q, "pelvis_ty")
    assert height[0] - height.min() == pytest.approx(0.2 * 1.72, abs=0.01)
    for name in s.problem.names:
        if name.endswith("_r"):
            left = column(s, q, name[:-2] + "_l")
            assert np.abs(column(s, q, name) - left).max() < 0.01
    assert np.rad2deg(column(s, q, "arm_flex_r")).min() > -5.0  # arms are not held back


@pytest.mark.solver
def test_the_hand_is_at_its_target_and_at_rest():
    s = solved("reach", 12.0)
    assert s.success
    term = next(t for t in s.task.terms if hasattr(t, "target"))
    q, v, _ = s.problem.states(s.coefficients, s.problem.nodes[-1:])
    place = np.asarray(s.body.symbolic.positions([term.point])(q[0])).ravel()
    assert place == pytest.approx(term.target, abs=1e-5)
    assert np.abs(v).max() < 1e-5


@pytest.mark.solver
def test_a_step_to_the_side_ends_standing_so_far_away():
    s = solved("side-step", 12.0)
    q, _, _, _ = at_nodes(s)
    assert column(s, q, "pelvis_tz")[-1] == pytest.approx(0.3)  # OpenSim's z is to the right
    assert np.rad2deg(np.abs(column(s, q, "arm_flex_r")).max()) < 25.0  # 43° as a counterweight


@pytest.mark.solver
@pytest.mark.slow
def test_a_jump_falls_freely_and_has_the_requested_height():
    """The arms swing forward, not sideways."""
    s = solved("jump", 20.0)
    assert s.success
    q, com, speed, force = at_nodes(s)
    assert np.rad2deg(column(s, q, "arm_flex_r").max()) > 60.0
    assert np.rad2deg(np.abs(column(s, q, "arm_add_r")).max()) < 30.0
    flight = 2 * np.sqrt(2 * 0.25 / GRAVITY)
    t = s.problem.nodes
    air = (t >= PUSH - 1e-9) & (t <= PUSH + flight + 1e-9)
    assert np.abs(force[air]).max() < 1e-9
    assert rise_after(s, PUSH) == pytest.approx(0.25, rel=1e-4)
    down = t[air] - PUSH
    assert speed[air, 2][-1] == pytest.approx(speed[air, 2][0] - GRAVITY * down[-1], abs=0.02)
    assert np.ptp(com[air, 1]) < 5e-3


def test_toes_may_land_before_the_heel():
    foot = Footprint("r", (0.0, 0.0, 0.0))
    usual = Stance(foot, 1.0, 1.2, 2.0, 2.1, 2.2)
    toes = replace(usual, toes_first=True)
    assert usual.interval("heel")[0] == toes.interval("toe")[0] == 1.0
    assert usual.interval("toe")[0] == toes.interval("heel")[0] == 1.2


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("sit-to-stand", {"chair_height": 1.4}, "chair_height must be .* for a person of 1.72 m"),
        ("squat", {"depth": 0.9}, "for a squat of a person of 1.72 m"),
        ("squat", {"deph": 0.2}, "it has depth"),
        ("reach", {"target": (3.0, 0.0, 1.0)}, "reaches about"),
        ("jump", {"jump_height": 5.0}, "jump_height must be 0.02–1.2 m for a jump, not 5"),
        ("walk", {"speed": 9}, "speed must be 0.3–2.2 m/s for walking, not 9"),
        ("walk", {"speed": True}, "speed must be a number"),
        ("walk", {"slope": 0.6}, "slope must be -20–20 degrees for walking, not 34.3775"),
        ("walk", {"steps": 100000}, "steps must be a whole number from 2 to 200"),
        ("walk", {"optimise_timing": True}, "optimise_timing needs periodic"),
        ("dance", {}, "there are"),
    ],
)
def test_what_is_not_possible_is_refused_in_words(name, given, words):
    with pytest.raises(ParameterError, match=words):
        make_task(name, person(), given)


def test_every_task_by_name_is_a_task_of_that_name():
    human = Human.create(1.72, 68.0, joints="42", feet="two-segment")  # toes to kneel on
    for name in TASKS:
        assert make_task(name, human).name == name


FILE = """
[task]
name = "squat, head still"
base = "squat"
without = ["acceleration"]

[parameters]
depth = 0.3

[[term]]
type = "jerk"
weight = 1e-8

[[term]]
type = "pose"
time = 1.25
coordinates_deg = { arm_flex_r = 60 }
at_rest = false
held = false
"""


def test_a_task_file_is_read_and_written_alike(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(FILE)
    one = read_task_file(path)
    assert parse_task_file(one.toml()) == one
    task = one.task(person())
    assert task.name == "squat, head still"
    kinds = [type(t).__name__ for t in task.terms]
    assert "Acceleration" not in kinds and kinds[-2:] == ["Jerk", "Pose"]
    assert task.terms[-1].coordinates["arm_flex_r"] == pytest.approx(np.pi / 3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[task]\nbase = "skip"', "no task 'skip'"),
        ('[task]\nbase = "squat"\n[parameters]\ndeph = 1', "unknown key 'deph'.*depth"),
        ('[task]\nbase = "squat"\n[[term]]\ntype = "torque"\nweigth = 1', "'weigth'.*weight"),
        ('[task]\nbase = "squat"\n[[term]]\ntype = "torque"\nweight = "x"', "a number is needed"),
        ('[task]\nbase = "squat"\n[[term]]\ntype = "posture"', "weights is missing"),
        (
            '[task]\nbase = "squat"\n[[term]]\ntype = "posture"\nstart = 2\nstop = 1\nweights = {}',
            "stops before it starts",
        ),
        ("[parameters]\ndepth = 1", "is missing"),
        ("= 3", "is not a TOML file"),
    ],
)
def test_what_is_wrong_in_a_task_file_is_named(text, words):
    with pytest.raises(FileError, match=words):
        parse_task_file(text)


def test_a_task_file_may_say_anything_and_only_our_errors_come_back():
    for text in (
        '[task]\nbase = ["squat"]',
        '[task]\nbase = "squat"\nwithout = [1]',
        '[task]\nbase = "squat"\n[[term]]\ntype = {}',
        '[task]\nbase = "squat"\n[[term]]\ntype = "torque"\nweight = ' + "9" * 400,
        "x = " + "9" * 5000,
    ):
        with pytest.raises(FileError):
            parse_task_file(text)


def test_a_term_that_needs_an_instant_gets_a_node_there():
    task = make_task("squat", person()).with_terms(Rest(0.7123))
    assert np.abs(task.nodes() - 0.7123).min() < 1e-9
    assert len(task.nodes()) == len(make_task("squat", person()).nodes())
    with pytest.raises(ParameterError, match="9 s is outside the motion, which lasts 2.5 s"):
        task.with_terms(Rest(9.0)).nodes()


@pytest.mark.solver
def test_what_a_task_demands_is_on_the_record_and_holds():
    """Every condition of every term, by the checker, which shares no line with the optimiser."""
    s = solved("reach", 12.0)
    record = s.record()
    hand = [c for c in record.conditions if c.quantity == "point"]
    assert {c.axis for c in hand} == {"x", "y", "z"} and {c.of for c in hand} == {"hand_r"}
    assert {c.name for c in record.conditions} >= {"rest", "knee_angle_r"}
    verdict = check(record)
    assert set(verdict.conditions) == {c.name for c in record.conditions}
    assert not any(m.bad for m in verdict.conditions.values())
    far = tuple(replace(c, lower=(9.0,), upper=(9.0,)) for c in hand)
    assert not check(replace(record, conditions=far)).ok


def test_one_sided_terms_are_found():
    knee = [Within(f"knee_angle_{side}", high=0.2) for side in "rl"]
    list_ = Within("pelvis_list", -0.1, 0.1)
    assert one_sided((knee[0],)) == (knee[0],) and one_sided(tuple(knee)) == ()
    assert one_sided((list_,)) == () and one_sided((replace(list_, low=0.0),))
    assert one_sided((Torque(1.0, {"ankle_angle_l": 2.0}),)) and not one_sided((Torque(),))
    assert one_sided((Posture({"knee_angle_r": 1.0, "knee_angle_l": 1.0}),)) == ()


@pytest.mark.solver
def test_a_periodic_walk_with_a_stiff_right_knee_is_a_whole_stride():
    task = make_task("walk", person(), {"periodic": True, "speed": 1.0})
    assert task.plan.mirrored
    stiff = replace(
        task.with_terms(Within("knee_angle_r", high=np.deg2rad(10.0))), nodes_per_second=24.0
    )
    assert not stiff.plan.mirrored and stiff.plan.duration == 2 * task.plan.duration
    s = synthesize(ContactBody.for_plan(person(), stiff.plan), stiff)
    assert s.success
    record = s.record(strides=2)
    assert np.rad2deg(record.motion["knee_angle_r"].max()) < 10.5  # the checker's tolerance
    assert np.rad2deg(record.motion["knee_angle_l"].max()) > 40.0
    verdict = check(record)
    assert verdict.ok, verdict.words()
    (knee,) = (m for name, m in verdict.conditions.items() if name == "knee_angle_r")
    assert knee.value < 10.5
    way = np.ptp(record.motion["pelvis_tx"][[0, -1]])
    assert way / record.motion.duration == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", ["jump", "take-off"])
def test_legs_of_the_guess_of_a_jump_are_bent_while_they_push(name):
    human = Human.create(1.66, 82.0, joints="43")
    task = make_task(name, human, {})
    body = ContactBody.for_plan(human, task.plan)
    times = np.linspace(0.5, 0.9, 41)
    knee = task.guess(body, task.plan, times)[:, 6 + human.hinge("knee_angle_r")]
    assert knee.min() > np.deg2rad(30.0)
    assert np.abs(np.diff(knee) / np.diff(times)).max() < 12.0
