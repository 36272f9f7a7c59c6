"""A recorded gait rebuilt end to end: what comes out, what is refused, and why."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.analyze import compare
from plantigrade.analyze.reproduction_status import (
    FORCE_LIMITS,
    MAX_ERRORS,
    force_figures,
    forces_status,
    gait_status,
    limit_of,
    run_status,
)
from plantigrade.constants import GRAVITY
from plantigrade.contact.site import contact_sites
from plantigrade.errors import ReproduceError
from plantigrade.motion import GaitEvent
from plantigrade.ordered_tasks.phases import ordered_events, walking_events
from plantigrade.record import Run
from plantigrade.workflows import reproduce as reproducing
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.save import save
from plantigrade.workflows.settings import ReproduceSettings
from tests.textbook import walk_file

PLAIN = ReproduceSettings(no_dynamics=True)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """The textbook walk, recorded and fitted."""
    return fit_trial(walk_file(tmp_path_factory.mktemp("walk") / "walk.c3d", speed=1.25))


@pytest.fixture(scope="module")
def made(fitted) -> Run:
    """The gait rebuilt with the default tasks."""
    return reproducing.run_of(*fitted, PLAIN)


@pytest.fixture(scope="module")
def forced(fitted, tmp_path_factory) -> Run:
    """The gait moved by forces too, in its run folder."""
    run = reproducing.run_of(*fitted, ReproduceSettings())
    return save(run, tmp_path_factory.mktemp("runs") / "forced")


def test_a_clean_walk_is_reproduced(made):
    motion, events = made.record.motion, made.record.motion.events
    assert made.ok and made.kind == "reproduce" and made.others == {}
    assert motion.time[0] == pytest.approx(events[0].time)
    assert motion.time[-1] == pytest.approx(events[-1].time, abs=0.006)
    assert made.figures["com_error_max_mm"] < 5  # the issue's own bound
    assert made.figures["cycles_count"] >= 3
    low, high = made.record.human.limits
    assert (motion.qpos[:, 7:] > low - 1e-6).all() and (motion.qpos[:, 7:] < high + 1e-6).all()


def test_forces_satisfy_their_motion_without_our_code(forced):
    """Inverse dynamics less the ground's push is the joint moments, and nothing at the root."""
    folder, metrics = forced.folder, forced.metrics
    model = mujoco.MjModel.from_xml_path(str(folder / "forces.xml"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.dof_armature[:] = model.dof_damping[:] = 0  # of the scene, not of the person
    data = mujoco.MjData(model)
    run = np.load(folder / "forces.npz")
    bodies = [model.body(str(segment)).id for segment in run["contact_segment"]]
    weight = model.body_mass.sum() * 9.81
    for f in range(0, len(run["time"]), 7):
        data.qpos[:], data.qvel[:], data.qacc[:] = (run[k][f] for k in ("qpos", "qvel", "qacc"))
        mujoco.mj_inverse(model, data)
        ground = np.zeros(model.nv)
        for k, body in enumerate(bodies):
            if run["contact_force"][f, k].any():
                mujoco.mj_applyFT(
                    model, data, run["contact_force"][f, k], np.zeros(3),
                    run["contact_point"][f, k], body, ground,
                )  # fmt: skip
        left = data.qfrc_inverse - ground
        assert np.abs(left[:6]).max() < 1e-6 * weight
        np.testing.assert_allclose(left, run["qfrc_actuator"][f], atol=1e-6 * weight)
    # over whole strides the ground carries the body
    assert run["contact_force"][..., 2].sum(axis=1).mean() == pytest.approx(weight, rel=0.1)
    assert (run["contact_force"][..., 2] >= 0).all()
    assert metrics["equations_residual_max_bw"] < 1e-6


def test_the_pages_show_the_forces(forced, made):
    page = (forced.folder / "report.html").read_text(encoding="utf-8")
    assert "<h2>Computed ground reactions</h2>" in page
    np.testing.assert_array_equal(forced.record.motion.qpos, made.record.motion.qpos)
    assert "vertical_force_rmse_bw" not in forced.figures
    assert "dynamics_status" not in made.figures


@pytest.mark.slow
def test_measured_forces_are_shown_with_the_computed_ones(data):
    run = reproducing.reproduce(data / "c3d/HC038A11.c3d")
    assert run.figures["dynamics_status"] == "ok"
    moved = run.others["forces"]
    force, moment = moved.signals["measured.force"], moved.signals["measured.moment"]
    # where both feet are known they carry about the body's weight
    total = force[..., 2].sum(axis=1)
    assert np.nanmean(total) == pytest.approx(run.record.weight, rel=0.15)
    names = moved.signals["measured.moment_names"].tolist()
    ankle = moment[:, names.index("ankle_angle_r")]
    assert -2.5 < np.nanmin(ankle) < -1.0  # plantarflexion at push-off [N m/kg]
    figures = run.figures
    assert figures["vertical_force_rmse_bw"] < 0.15 and figures["vertical_force_correlation"] > 0.9
    assert figures["pressure_x_rmse_mm"] < 100, "the same foot, the same stance"
    # together the feet carry the body's weight over the strides
    carried = sum(moved.foot(side).force[:, 2] for side in ("r", "l"))
    assert carried.mean() == pytest.approx(run.record.human.mass * GRAVITY, rel=0.1)


def test_a_fall_is_reported(forced):
    record = forced.others["forces"]
    qpos = record.motion.qpos.copy()
    qpos[100:, 2] -= 0.3  # whatever came after
    fallen = replace(record, motion=replace(record.motion, qpos=qpos))
    held = compare(fallen)
    said = forces_status(fallen, held)
    assert "fell" in said and f"{record.motion.time[100]:.2f} s" in said
    figures = force_figures(fallen, held)
    assert figures["dynamics_status"] == said and "vertical_force_rmse_bw" not in figures
    assert run_status("ok", said) == f"gait computed with forces: {said}"
    assert run_status(said, "ok").startswith("gait computed without forces: ")
    assert run_status("ok", "ok", said) == f"recording: {said}"
    assert run_status("ok", "ok") == "ok"


def test_ok_is_only_what_is_within_the_limits_that_the_figures_name(forced):
    """A gait with a range of motion 39 degrees off was ok once."""
    record, moved, figures = forced.record, forced.others["forces"], forced.figures
    held = compare(record)
    theirs = held.rom["knee_angle_r"][1]
    off = replace(held, rom={**held.rom, "knee_angle_r": (theirs + 39.0, theirs)})
    assert gait_status(record, held) == "ok"
    said = gait_status(record, off)
    assert "the range of motion of knee_angle_r is 39.0° off" in said
    assert "s into the recording" in said and "at most 20° allowed" in said
    assert "39.0° off" in forces_status(moved, off)
    for key, limit in (MAX_ERRORS | FORCE_LIMITS).items():
        assert figures[limit_of(key)] == limit and abs(figures[key]) <= abs(limit)
    soles = held.soles.copy()
    soles[50, 1] = -0.02
    sunk = gait_status(record, replace(held, lowest_m=-0.02, soles=soles))
    assert f"the left sole is at -20 mm, in the ground, {record.motion.time[50]:.2f} s" in sunk
    assert "at least -10 mm allowed" in sunk
    shifted = moved.signals["estimated.force"] + [0.0, 0.2 * moved.weight, 0.0]
    other = replace(moved, signals={**moved.signals, "estimated.force": shifted})
    assert "body weights (RMS) from the estimated" in forces_status(other, compare(moved))


def test_the_status_of_a_run_is_the_worst_of_its_parts(fitted, monkeypatch):
    """A run was ok while its gait with forces had ranges of motion up to 30 degrees off."""
    recording, trial = fitted
    short = without_events(trial, walking_events(trial.motion.events)[:3])
    monkeypatch.setitem(FORCE_LIMITS, "force_residual_rms_bw", 1e-3)
    run = reproducing.run_of(recording, short, ReproduceSettings())
    assert run.figures["motion_status"] == "ok" and not run.ok
    assert run.status == f"gait computed with forces: {run.figures['dynamics_status']}"
    assert "foot, " in run.status and "s into the recording" in run.status
    assert "at most 0.001 body weights allowed" in run.status


def test_a_sliding_sole_is_reported_with_its_place_and_instant(made):
    record = made.record
    qpos = record.motion.qpos.copy()
    qpos[100:, 1] += 0.03
    said = gait_status(
        moved := replace(record, motion=replace(record.motion, qpos=qpos)), compare(moved)
    )
    assert "the sole slides by" in said and "at most 20 mm allowed" in said
    assert any(f"at {site.name}," in said for site in contact_sites(record.human))


def test_the_run_folder_is_the_motion_and_the_recorded_one(forced):
    held, record = np.load(forced.folder / "motion.npz"), forced.record
    model = mujoco.MjModel.from_xml_path(str(forced.folder / "model.xml"))
    np.testing.assert_array_equal(held["qpos"], record.motion.qpos)
    assert held["reference/recorded/qpos"].shape[1] == held["qpos"].shape[1]
    assert held["reference_qpos"].shape == held["qpos"].shape
    assert forced.metrics["frames"] == len(held["time"])
    # from posture, velocity and acceleration of one tick follows the posture of the next
    for k in (50, 200):
        step = held["time"][k + 1] - held["time"][k]
        qpos = held["qpos"][k].copy()
        rate = held["qvel"][k] + 0.5 * step * held["qacc"][k]
        mujoco.mj_integratePos(model, qpos, rate, step)
        assert np.abs(qpos - held["qpos"][k + 1]).max() < 2e-3
    # the centre of mass of the motion and of the recorded one, without our code
    data, com = mujoco.MjData(model), []
    recorded = record.references["recorded"].at(record.motion.time)
    for k in (0, 100, 300):
        for qpos in (held["qpos"][k], recorded.qpos[k]):
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            com.append(data.subtree_com[1].copy())
    assert np.linalg.norm(np.array(com[::2]) - com[1::2], axis=1).max() < 0.005


def test_a_run_comes_back_from_its_folder(forced):
    again = Run.load(forced.folder)
    assert again.kind == "reproduce" and set(again.others) == {"forces"}
    for ours, theirs in ((again.record, forced.record), (again.others["forces"],) * 2):
        assert set(ours.signals) == set(theirs.signals)
        np.testing.assert_array_equal(ours.motion.qpos, theirs.motion.qpos)
    held, before = compare(again.record), compare(forced.record)
    assert held.metrics() == pytest.approx(before.metrics())


def test_figures_are_flat_and_tell_the_tasks(made):
    figures, signals = made.figures, made.record.signals
    assert figures["tasks"] == "default"
    assert figures["task_order"] == signals["tasks.names"].tolist()
    held = compare(made.record)
    assert figures["rom_error_mean_deg"] == held.metrics()["rom_error_mean_deg"]
    stride = np.mean([c.duration for c in held.cycles])
    cycle = made.seconds["reproduce"] * stride / made.record.motion.duration
    assert made.seconds["cycle"] == pytest.approx(cycle)
    assert 0 < made.seconds["tick_solver"] < made.seconds["cycle"]
    assert "exact" in signals and len(signals["tasks.residual"]) == made.record.motion.n_frames
    levels = signals["tasks.level"]
    assert set(levels) == set(range(1, levels.max() + 1))
    assert len(signals["tasks.meanings"]) == len(levels) == len(signals["tasks.names"])


def without_events(trial, events=()):
    """The trial with other gait events."""
    return replace(trial, motion=replace(trial.motion, events=tuple(events)))


def test_standing_is_refused_in_one_sentence(fitted):
    recording, trial = fitted
    with pytest.raises(ReproduceError, match=r"walk\.c3d: it shows no walking"):
        reproducing.run_of(recording, without_events(trial), PLAIN)


def test_flight_is_not_walking():
    """Running: each foot leaves before the other comes down, at every step."""
    kinds = [("r", "heel_strike"), ("r", "toe_off"), ("l", "heel_strike"), ("l", "toe_off")]
    events = [GaitEvent(0.15 * k, *kinds[k % 4]) for k in range(12)]
    events = [
        replace(e, time=e.time - 0.08) if e.kind == "heel_strike" else e for e in events
    ]  # flight of 0.07 s
    same, blurred = ordered_events(events)
    assert blurred == 0 and list(same) == events
    assert len(walking_events(events)) < 3


def test_one_blurred_step_of_a_walk_is_mended():
    kinds = [("r", "heel_strike"), ("l", "toe_off"), ("l", "heel_strike"), ("r", "toe_off")]
    gaps = [0.0, 0.1, 0.5, 0.6]
    events = [GaitEvent(gaps[k % 4] + k // 4, *kinds[k % 4]) for k in range(12)]
    assert len(walking_events(events)) == 12
    swapped = list(events)
    swapped[6] = replace(events[6], time=events[6].time + 0.08)  # strike after the toe off
    swapped[7] = replace(events[7], time=events[7].time - 0.08)
    assert len(walking_events(swapped)) < 12
    mended, blurred = ordered_events(swapped)
    assert blurred == 1 and len(walking_events(mended)) == 12
    assert all(
        abs(a.time - b.time) < 0.1 and (a.side, a.kind) == (b.side, b.kind)
        for a, b in zip(mended, events, strict=True)
    )


def test_stairs_are_refused(fitted):
    recording, trial = fitted
    qpos = trial.motion.qpos.copy()
    qpos[:, 2] += 0.15 * (trial.motion.time - trial.motion.time[0])  # a quarter of a metre in all
    stairs = replace(trial, motion=replace(trial.motion, qpos=qpos))
    with pytest.raises(ReproduceError, match="not level"):
        reproducing.run_of(recording, stairs, PLAIN)


@pytest.mark.slow
def test_a_treadmill_and_the_ground_give_one_gait(fitted, made):
    """The same walk with the belt's path taken away from everything that was recorded."""
    recording, trial = fitted
    way = 1.25 * (trial.fit.time - trial.fit.time[0])
    qpos = trial.motion.qpos.copy()
    qpos[:, 0] -= way
    feet = replace(
        trial.feet,
        heel=trial.feet.heel - way[:, None, None] * [1, 0, 0],
        toe=trial.feet.toe - way[:, None, None] * [1, 0, 0],
    )
    belt = replace(trial, feet=feet, motion=replace(trial.motion, qpos=qpos))
    again = reproducing.run_of(recording, belt, PLAIN)
    assert again.ok
    assert any("treadmill" in note for note in again.record.notes)
    assert not any("treadmill" in note for note in made.record.notes)
    ours, theirs = compare(again.record), compare(made.record)
    for name in ("knee_angle_r", "hip_flexion_l"):
        assert ours.rom[name] == pytest.approx(theirs.rom[name], abs=1.5)


def test_a_stop_leaves_the_longest_run_of_steps(fitted):
    """More events follow a pause than precede it."""
    recording, trial = fitted
    events = walking_events(trial.motion.events)
    early = [replace(e, time=e.time - 20.0) for e in events[:4]]
    run = reproducing.run_of(recording, without_events(trial, (*early, *events)), PLAIN)
    (note,) = [n for n in run.record.notes if "longest sequence" in n]
    assert f"of {len(events) + 4} gait events" in note and f"{len(events)} events" in note


def test_an_early_end_is_reported_with_its_instant(made):
    record = made.record
    signals = {**record.signals, "stopped": np.array("no acceleration was found")}
    said = gait_status(replace(record, signals=signals), compare(record))
    assert "ended early" in said and "Residual of each level" in said
    assert f"{record.motion.time[-1]:.2f} s into the recording" in said


def test_a_centre_of_mass_off_its_path_is_reported_with_its_instant(made):
    record = made.record
    qpos = record.motion.qpos.copy()
    qpos[100:, 2] += 0.2
    lifted = replace(record, motion=replace(record.motion, qpos=qpos))
    said = gait_status(lifted, compare(lifted))
    assert "the centre of mass left its path by more than 5 cm" in said
    assert "Residual of each level" in said
    assert f"{record.motion.time[100]:.2f} s into the recording" in said


def test_a_drifting_pelvis_is_reported(made):
    """The centre of mass is on its path, the pelvis is not."""
    record, reference = made.record, made.record.references["recorded"]
    qpos = reference.qpos.copy()
    qpos[:, 0] += 0.5
    other = replace(record, references={"recorded": replace(reference, qpos=qpos)})
    assert "pelvis deviated" in gait_status(other, compare(record))
