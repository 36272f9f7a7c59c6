"""From a task to a run that is judged: settings, verdict, figures, run folder, warm start."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade import check
from plantigrade.analyze.movement import movement_figures
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.record import Run
from plantigrade.trajopt import ContactBody, make_task, parse_task_file, synthesize
from plantigrade.trajopt.diagnose.violations import Violation, pressing, violations
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from plantigrade.trajopt.warm_start import WarmStart
from plantigrade.trajopt.zhakatayev2023 import MOTIONS, paper_human
from plantigrade.trajopt.zhakatayev2023.solve import equal_shares, plan_of
from plantigrade.workflows.settings import SolveSettings
from plantigrade.workflows.synthesize import in_words, run_of, status, synthesize_task
from plantigrade.workflows.task import person, the_task
from tests.conftest import QUICK_WALK
from tests.test_self_check import carried


def test_the_walk_passes_the_check_and_says_so(synthesized):
    run = synthesized.run
    assert run.ok and run.kind == "synthesize"
    metrics = json.loads((run.folder / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["notes"] == []
    assert metrics["check_root_force_max_bw_percent"] < 1.0
    assert metrics["settings"]["friction"] == 0.8


def test_the_folder_is_judged_alike_without_anything_of_the_optimiser(synthesized):
    """From the run folder alone, conditions of the task included."""
    again = Run.load(synthesized.run.folder).record
    assert again.conditions == synthesized.run.record.conditions
    verdict = check(again)
    assert verdict.ok, verdict.words()
    assert any(name.startswith("clearance") for name in verdict.conditions)


def test_anyone_can_check_it_without_our_code(synthesized):
    carried(synthesized.run.folder, synthesized.run.record)


def test_torques_of_the_record_are_those_of_the_checker(synthesized):
    record = synthesized.run.record
    np.testing.assert_allclose(record.qfrc_actuator, check(record).tau, atol=1e-6)


def test_whole_strides_are_written_and_measured(synthesized):
    run, plan = synthesized.run, synthesized.solution.task.plan
    figures, motion = run.figures, run.record.motion
    assert figures["duration_s"] == pytest.approx(4 * plan.duration)  # two strides, four steps
    assert figures["walking_speed_m_s"] == pytest.approx(1.0, rel=0.005)
    assert figures["cadence_steps_min"] == pytest.approx(60 / plan.duration)
    assert figures["displacement_m"] == pytest.approx(4 * plan.advance, rel=1e-6)
    assert figures["strides_r_count"] == 2
    strikes = [e for e in motion.events if e.kind == "heel_strike"]
    np.testing.assert_allclose([e.time for e in strikes], plan.duration * np.arange(5), atol=1e-9)
    assert [e.side for e in strikes] == ["r", "l", "r", "l", "r"]


def test_only_a_walk_has_a_cost_of_transport(synthesized):
    record = synthesized.run.record
    jump = replace(record, motion=replace(record.motion, events=()))
    assert "cost_of_transport" in synthesized.run.figures
    assert not any("transport" in name for name in movement_figures(jump))


def test_the_ground_carries_the_body(synthesized):
    """Over whole strides the mean vertical force is the weight, the mean forward force zero."""
    record = synthesized.run.record
    total = record.contact_force.sum(axis=1) / record.weight
    mean = np.trapezoid(total, record.motion.time, axis=0) / record.motion.duration
    np.testing.assert_allclose(mean, [0.0, 0.0, 1.0], atol=0.01)


def test_work_of_the_joints_is_the_work_that_is_given_and_taken(synthesized):
    """A periodic walk on level ground gains nothing, and feet that roll lose nothing."""
    figures = synthesized.run.figures
    given, every = figures["joint_work_positive_j"], figures["joint_work_absolute_j"]
    assert given == pytest.approx(every - given, rel=0.03)


def test_sites_of_the_record_are_those_of_the_body(synthesized):
    record = synthesized.run.record
    assert record.sites == foot_sites(record.human)
    assert record.contact_planned is not None and record.contact_planned.any(axis=1).all()
    assert not record.contact_force[~record.contact_planned].any()
    assert record.limits.force == pytest.approx(3.0 * record.weight)


def test_every_iteration_is_reported(synthesized):
    solution, iterations = synthesized.solution, synthesized.iterations
    assert {stage for stage, _ in iterations} == {s.name for s in solution.stages}
    kept = [it.number for s in solution.stages for it in s.history]
    assert {it.number for _, it in iterations} <= set(kept)
    assert len(iterations) >= len(kept) - len(solution.stages)
    assert iterations[-1][1].violation < 1e-3
    history = synthesized.run.record.signals["solver.history"]
    assert history.shape == (len(kept), 5)
    np.testing.assert_array_equal(history[:, 1], kept)


def test_a_run_can_be_started_from(synthesized):
    """Its folder holds the solution; person and task are not made anew."""
    solution = synthesized.solution
    warm = WarmStart.of_record(Run.load(synthesized.run.folder).record)
    np.testing.assert_array_equal(warm.coefficients, solution.coefficients)
    np.testing.assert_array_equal(warm.nodes, solution.nodes)
    times = np.linspace(0.0, 0.5, 7)
    ours, theirs = (
        p.states(solution.coefficients, times) for p in (solution.problem, warm.problem)
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert warm.multipliers is not None
    assert set(warm.multipliers.rows) == set(solution.multipliers.rows)
    again = synthesize(solution.body, solution.task, warm=warm, refinements=0)
    assert again.success and again.iterations <= 1


def test_an_unusable_start_is_reported(synthesized):
    record = synthesized.run.record
    with pytest.raises(ParameterError, match="holds no solved spline"):
        WarmStart.of_record(replace(record, signals={}))
    short = {**record.signals, "spline.coefficients": np.zeros((2, 2))}
    with pytest.raises(ParameterError, match="spline.co.* has shape"):
        WarmStart.of_record(replace(record, signals=short))
    how = SolveSettings(joints="66", warm=synthesized.run.folder)
    with pytest.raises(ParameterError, match="the run has 42 coordinates, this person 66"):
        synthesize_task(WalkSettings(periodic=True), how)


@pytest.fixture(scope="module")
def spoiled(synthesized):
    """The walk with its right knee bent 10° more halfway."""
    made = synthesized.solution
    c = made.coefficients.copy()
    knee = made.problem.names.index("knee_angle_r")
    c[len(c) // 2 - 1 : len(c) // 2 + 2, knee] += np.deg2rad(10.0)
    return replace(made, coefficients=c, success=False, status="stalled")


def test_a_spoiled_motion_is_not_ok_and_says_why(spoiled):
    run = run_of(spoiled, {})
    assert not run.ok and "refine the mesh" in run.status
    assert run.figures["check_ok"] is False
    assert "“stalled”" in run.record.notes[0]
    assert list(run.record.signals["solver.broken"]) == run.figures["violations"]


def test_violations_name_row_side_time_amount_and_remedy(spoiled, synthesized):
    found = spoiled.violations
    assert {"root force", "contact"} <= {b.family for b in found}
    contact = next(b for b in found if b.family == "contact")
    assert contact.unit == "mm" and contact.side in ("right", "left")
    assert np.min(np.abs(spoiled.problem.nodes - contact.time)) < 1e-12
    text = contact.sentence()
    assert contact.side in text and " mm at " in text and "shorter steps" in text
    assert synthesized.solution.violations == ()


def test_limits_that_are_pushed_against_are_named(synthesized):
    """Those that bind: at each the motion is near its limit."""
    made = synthesized.solution
    words = pressing(made.problem, made.multipliers, count=9)
    assert words and all(re.search(r" at \d\.\d\d s$", w) for w in words)
    assert pressing(made.problem, None) == ()


def test_advice_tells_what_was_fixed_from_what_was_limited(synthesized):
    made = synthesized.solution
    rows = next(r for r in made.problem.rows if r.name == "coordinates")
    lower, upper = rows.lower.copy(), rows.upper.copy()
    knee = rows.names.index("knee_angle_r")
    lower[3, knee] = upper[3, knee] = 2.0
    asked = replace(rows, lower=lower, upper=upper)
    others = tuple(r for r in made.problem.rows if r is not rows)
    problem = replace(made.problem, rows=(*others, asked))
    (broken,) = violations(problem, made.coefficients, made.forces)
    assert broken.name == "knee_angle_r" and broken.unit == "deg"
    assert "requested posture" in broken.sentence()


def test_amounts_are_those_of_the_motion(synthesized):
    """A pelvis raised by 7 mm lifts all that stands by 7 mm."""
    made = synthesized.solution
    c = made.coefficients.copy()
    c[:, made.problem.names.index("pelvis_ty")] += 0.007  # splines of this basis sum to one
    found = violations(made.problem, c, made.forces)
    contact = next(b for b in found if b.family == "contact")
    assert contact.amount == pytest.approx(7.0, abs=1e-3) and contact.name.startswith("z of")


def test_a_physical_motion_that_misses_its_task_is_not_ok(synthesized):
    verdict = check(synthesized.run.record)
    off = Violation("coordinates", "hip_flexion_r", 0.1, 5.0, "deg", 0.09)
    words = status(verdict, (off,))
    assert verdict.ok and "not what was asked for: right hip flexion is off by 5 deg" in words
    assert status(verdict, (replace(off, relative=1e-5),)) == "ok"


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"solver": "snopt"}, "snopt"),
        ({"basis": "wavelets"}, "wavelets"),
        ({"restarts": 0}, "from 1 to"),
        ({"nodes_per_second": 0.0}, "2–500"),
    ],
)
def test_settings_that_cannot_be_are_refused(given, match):
    with pytest.raises((ParameterError, TypeError), match=match):  # types are checked in tests
        SolveSettings(**given)


def test_a_task_is_made_from_its_settings_or_from_a_file(synthesized):
    human, made = synthesized.run.record.human, synthesized.solution
    how = SolveSettings(basis="polynomial", nodes_per_second=11.0)
    task = the_task(human, WalkSettings(periodic=True), how)
    assert (task.basis, task.nodes_per_second) == ("polynomial", 11.0)
    assert len(task.terms) == len(made.task.terms) + 1  # the file leaves one out
    file = parse_task_file(QUICK_WALK)
    slower = the_task(human, WalkSettings(speed=0.8, periodic=True), how, file)
    assert slower.plan.duration > made.task.plan.duration
    assert person(SolveSettings()).joints == "43"


def test_words_have_units():
    assert in_words("speed", 1.0) == "speed 1 m/s" and in_words("side", "r") == "side r"
    assert in_words("slope", np.deg2rad(5.0)) == "slope 5°" and in_words("periodic", False) == ""


def test_steps_and_slopes_are_the_ground_the_feet_stand_on(synthesized):
    human = synthesized.run.record.human
    for parameters in ({"steps": 4, "step_height": 0.1}, {"steps": 4, "slope": 0.1}):
        task = make_task("walk", human, parameters)
        body = ContactBody.for_plan(human, task.plan)
        last = task.plan.to_world @ np.array(task.plan.stances[-1].footprint.position)
        made = replace(synthesized.solution, task=task, body=body)
        ground = replace(made, problem=task.problem(body), multipliers=None)
        c, u = task.start(body, ground.problem)
        record = replace(ground, coefficients=c, forces=u).record(samples_per_interval=1)
        assert record.ground.under(last) == pytest.approx(last @ record.ground.normal, abs=1e-9)


def test_motions_of_the_paper_stand_where_its_contact_matrix_says():
    human = paper_human()
    for motion in MOTIONS.values():
        plan = plan_of(motion, human)
        for site in foot_sites(human):
            stands = plan.standing(site, motion.times)
            alone = [s for s in plan.stances if s.footprint.side == site.side]
            assert alone and set(np.flatnonzero(stands)) <= set(
                np.flatnonzero(motion.contact[site.side])
            )
    u = equal_shares(np.array([[True, True, False], [False, False, False]]))
    np.testing.assert_array_equal(u[:, 2::3], [[0.5, 0.5, 0.0], [0.0, 0.0, 0.0]])
