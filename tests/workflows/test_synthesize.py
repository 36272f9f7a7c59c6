"""From a task to a motion that is judged: settings, verdict, figures, run folder, warm start."""

import json
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.analyze.check import examine, motion_of_run
from plantigrade.errors import FileError, ParameterError
from plantigrade.record.folder import read_run
from plantigrade.synthesize.diagnose.post_mortem import Broken, broken_rows, pressing
from plantigrade.synthesize.tasks.registry import make_task
from plantigrade.workflows.synthesis_folder import read_synthesis, with_world
from plantigrade.workflows.synthesize import (
    SynthesizeSettings,
    judged,
    synthesize_task,
    task_of,
)


def test_the_walk_passes_the_check_and_says_so(synthesized):
    made, folder, _ = synthesized
    assert made.status == "ok" and made.check.ok
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["warnings"] == []
    assert metrics["check_root_force_max_bw_percent"] < 1.0


def test_the_folder_is_judged_alike_without_anything_of_the_optimiser(synthesized):
    """From model.xml and motion.npz alone, as anyone may."""
    verdict = examine(motion_of_run(synthesized[1]))
    assert verdict.ok, verdict.words()


def test_torques_of_the_record_are_those_of_mujoco(synthesized):
    made, folder, _ = synthesized
    xml, record, _ = read_run(folder)
    model = mujoco.MjModel.from_xml_string(xml)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)  # forces are given
    data = mujoco.MjData(model)
    motion, k = record.motion, 37
    assert motion.qacc is not None and record.qfrc_actuator is not None
    assert record.contact_force is not None and record.contact_point is not None
    data.qpos, data.qvel, data.qacc = motion.qpos[k], motion.qvel[k], motion.qacc[k]
    mujoco.mj_inverse(model, data)
    needed = data.qfrc_inverse.copy()
    for force, point, side, segment in zip(
        record.contact_force[k], record.contact_point[k], record.contact_side,
        record.contact_segment, strict=True,
    ):  # fmt: skip
        if not np.any(force):
            continue
        J = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, J, None, point, model.body(f"{segment}_{side}").id)
        needed -= J.T @ force
    np.testing.assert_allclose(record.qfrc_actuator[k, 6:], needed[6:], atol=1e-6)
    np.testing.assert_allclose(needed[:3], 0.0, atol=0.01 * made.synthesis.body.weight)


def test_whole_strides_are_written_and_measured(synthesized):
    made, folder, _ = synthesized
    plan, metrics = made.synthesis.task.plan, made.metrics
    assert metrics["duration_s"] == pytest.approx(4 * plan.duration)  # two strides, four steps
    assert metrics["walking_speed_m_s"] == pytest.approx(1.0, rel=0.005)
    assert metrics["cadence_steps_min"] == pytest.approx(60 / plan.duration)
    assert metrics["displacement_m"] == pytest.approx(4 * made.synthesis.task.step, rel=1e-6)
    assert metrics["strides_r_count"] == 2
    strikes = [e for e in made.events if e.kind == "heel_strike"]
    np.testing.assert_allclose([e.time for e in strikes], plan.duration * np.arange(5), atol=1e-9)
    assert [e.side for e in strikes] == ["r", "l", "r", "l", "r"]
    text = (folder / "motion.mot").read_text().split("endheader")[1].split()
    assert "knee_angle_r" in text


def test_the_ground_carries_the_body(synthesized):
    """Over whole strides the mean vertical force is the weight, the mean forward force zero."""
    made, _, _ = synthesized
    total = made.sampled.force.sum(axis=1) / made.synthesis.body.weight
    span = made.sampled.time[-1]
    mean = np.trapezoid(total, made.sampled.time, axis=0) / span
    np.testing.assert_allclose(mean, [0.0, 0.0, 1.0], atol=0.01)


def test_work_of_the_joints_is_the_work_that_is_given_and_taken(synthesized):
    """A periodic walk on level ground gains nothing, and feet that roll lose nothing."""
    m = synthesized[0].metrics
    given, all_ = m["joint_work_positive_j"], m["joint_work_absolute_j"]
    assert given == pytest.approx(all_ - given, rel=0.03)


def test_every_iteration_is_told(synthesized):
    made, _, told = synthesized
    assert {stage for stage, _ in told} == {s.name for s in made.synthesis.stages}
    kept = [it.number for s in made.synthesis.stages for it in s.history]
    assert {it.number for _, it in told} <= set(kept) and len(told) >= len(kept) - 1
    assert told[-1][1].violation < 1e-4


def test_a_run_is_read_back_whole(synthesized):
    made, folder, _ = synthesized
    again = read_synthesis(folder)
    np.testing.assert_array_equal(again.c, made.synthesis.c)
    np.testing.assert_array_equal(again.u, made.synthesis.u)
    assert again.task.plan == made.synthesis.task.plan
    assert again.multipliers is not None and made.synthesis.multipliers is not None
    assert set(again.multipliers.rows) == set(made.synthesis.multipliers.rows)
    times = np.linspace(0.0, 1.0, 7)
    np.testing.assert_allclose(again.sample(times).q, made.synthesis.sample(times).q, atol=1e-12)


def test_a_folder_that_is_no_such_run_is_refused(synthesized, tmp_path):
    with pytest.raises(FileError, match="no synthesis.npz"):
        read_synthesis(tmp_path)
    (tmp_path / "synthesis.npz").write_bytes(b"PK")
    (tmp_path / "metrics.json").write_bytes((synthesized[1] / "metrics.json").read_bytes())
    with pytest.raises(FileError, match="no motion to start from"):
        read_synthesis(tmp_path)
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    metrics["settings"]["parameters"]["speed"] = 1.4
    (tmp_path / "metrics.json").write_text(json.dumps(metrics))
    (tmp_path / "synthesis.npz").write_bytes((synthesized[1] / "synthesis.npz").read_bytes())
    with pytest.raises(FileError, match="another problem"):
        read_synthesis(tmp_path)


@pytest.fixture(scope="module")
def spoiled(synthesized):
    """The walk with its right knee bent 10° more halfway."""
    made = synthesized[0]
    c = made.synthesis.c.copy()
    knee = made.synthesis.problem.names.index("knee_angle_r")
    c[len(c) // 2 - 1 : len(c) // 2 + 2, knee] += np.deg2rad(10.0)
    return judged(made.settings, replace(made.synthesis, c=c, success=False, status="stalled"))


def test_a_spoiled_motion_is_not_ok_and_says_why(spoiled):
    assert spoiled.status != "ok" and "refine the mesh" in spoiled.status
    assert spoiled.metrics["check_ok"] is False
    assert "“stalled”" in spoiled.notes[0]


def test_the_post_mortem_names_row_side_time_amount_and_remedy(spoiled, synthesized):
    families = {b.family for b in spoiled.broken}
    assert {"dynamics", "contact"} <= families
    contact = next(b for b in spoiled.broken if b.family == "contact")
    assert contact.unit == "mm" and contact.side in ("right", "left")
    nodes = spoiled.synthesis.problem.nodes
    assert np.min(np.abs(nodes - contact.time)) < 1e-12
    text = contact.sentence()
    assert contact.side in text and " mm at " in text and "shorter steps" in text
    made = synthesized[0].synthesis
    assert broken_rows(made.problem, made.c, made.u) == ()


def test_limits_that_are_pushed_against_are_named(synthesized):
    """Those that bind: at each the motion is near its limit."""
    made = synthesized[0].synthesis
    words = pressing(made.problem, made.multipliers, count=9)
    assert words and all(re.search(r" at \d\.\d\d s$", w) for w in words)
    assert pressing(made.problem, None) == ()


def test_advice_tells_what_was_fixed_from_what_was_limited(synthesized):
    made = synthesized[0].synthesis
    rows = next(r for r in made.problem.rows if r.name == "coordinates")
    lower, upper = rows.lower.copy(), rows.upper.copy()
    knee = rows.names.index("knee_angle_r")
    lower[3, knee] = upper[3, knee] = 2.0
    asked = replace(rows, lower=lower, upper=upper)
    others = tuple(r for r in made.problem.rows if r is not rows)
    problem = replace(made.problem, rows=(*others, asked))
    (broken,) = broken_rows(problem, made.c, made.u)
    assert broken.name == "knee_angle_r" and broken.unit == "deg"
    assert "posture asked for" in broken.sentence()


def test_amounts_are_those_of_the_motion(synthesized):
    """A pelvis raised by 7 mm lifts all that stands by 7 mm."""
    made = synthesized[0].synthesis
    c = made.c.copy()
    c[:, made.problem.names.index("pelvis_ty")] += 0.007  # splines of this basis sum to one
    contact = next(b for b in broken_rows(made.problem, c, made.u) if b.family == "contact")
    assert contact.amount == pytest.approx(7.0, abs=1e-6) and contact.name.startswith("z of")


def test_a_motion_that_is_physical_but_not_what_was_asked_is_not_ok(synthesized):
    made = synthesized[0]
    off = Broken("coordinates", "hip_flexion_r", 0.1, 5.0, "deg", 0.09)
    other = replace(made, broken=(off,))
    assert other.check.ok and "not what was asked for: right hip flexion is off by 5 deg" in (
        other.status
    )


def test_steps_and_slopes_are_to_be_seen_where_the_feet_stand(synthesized):
    human = synthesized[0].human
    for told in ({"steps": 4, "step_height": 0.1}, {"steps": 4, "slope": 0.1}):
        plan = make_task("walk", human, told).plan
        model = mujoco.MjModel.from_xml_string(with_world(human.xml, plan))
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        drawn = [g for g in range(model.ngeom) if model.geom(g).name[:5] in ("step_", "slope")]
        assert drawn and model.geom_contype[drawn].max() == 0
        last = plan.to_world @ np.array(plan.stances[-1].footprint.position)
        away = mujoco.mj_ray(
            model, data, last + [0.0, 0.0, 1.0], np.array([0.0, 0.0, -1.0]),
            np.array([1, 0, 0, 0, 0, 0], np.uint8), 1, -1, np.zeros(1, np.int32),
        )  # fmt: skip
        assert away == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"formulation": "ours"}, "default, paper"),
        ({"solver": "snopt"}, "band, ipopt"),
        ({"basis": "wavelets"}, "trigonometric, polynomial"),
        ({"tries": 0}, "from 1 to"),
        ({"strides": 0}, "from 1 to"),
        ({"nodes_per_second": 0.0}, "2 to 500"),
    ],
)
def test_settings_that_cannot_be_are_refused(given, match):
    with pytest.raises(ParameterError, match=match):
        SynthesizeSettings(**given)


def test_a_task_is_made_from_its_name_or_from_a_file_and_options_go_over_it(synthesized):
    made = synthesized[0]
    plain = SynthesizeSettings(
        parameters={"periodic": True}, basis="polynomial", nodes_per_second=11.0
    )
    task = task_of(made.human, plain)
    assert (task.basis, task.nodes_per_second) == ("polynomial", 11.0)
    assert len(task.terms) == len(made.synthesis.task.terms) + 1  # the file left one out
    slower = replace(made.settings, parameters={"speed": 0.8, "periodic": True})
    assert task_of(made.human, slower).plan.duration > made.synthesis.task.plan.duration
    with pytest.raises(ParameterError, match="no task 'hop'"):
        task_of(made.human, SynthesizeSettings(task="hop"))


def test_a_seat_is_to_be_seen_and_touches_nothing(synthesized):
    human = synthesized[0].human
    task = make_task("sit-to-stand", human, {})
    model = mujoco.MjModel.from_xml_string(with_world(human.xml, task.plan))
    assert model.nq == human.model.nq
    np.testing.assert_allclose(model.body_mass, human.model.body_mass)
    top = {s.position[2] for s in task.plan.supports}
    seat = model.geom("seat_1")
    assert seat.pos[2] + seat.size[2] == pytest.approx(next(iter(top)), abs=1e-3)
    assert model.geom_contype[seat.id] == 0 and model.geom_conaffinity[seat.id] == 0
    assert {model.geom(g).name for g in range(model.ngeom)} >= {"contact_seat_r", "contact_seat_l"}
    assert with_world(human.xml, synthesized[0].synthesis.task.plan) == human.xml


def test_motions_of_the_paper_stand_where_its_contact_matrix_says():
    from plantigrade.contact.site import foot_sites
    from plantigrade.synthesize.zhakatayev2023 import MOTIONS, paper_human
    from plantigrade.workflows.zhakatayev2023 import equal_shares, plan_of

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


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"task": "squat"}, "has no 'squat'"),
        ({"nodes_per_second": 30.0}, "knows no --nodes-per-second"),
    ],
)
def test_the_paper_has_its_own_motions_only(given, match):
    with pytest.raises(ParameterError, match=match):
        synthesize_task(SynthesizeSettings(formulation="paper", **given))
