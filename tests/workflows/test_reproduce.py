"""A recorded gait rebuilt end to end: what comes out, what is refused, and why."""

from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from plantigrade.errors import ParameterError, ReproduceError
from plantigrade.io import write
from plantigrade.models import Human
from plantigrade.motion import GaitEvent
from plantigrade.report.reproduction import read_reproduction, reproduction_sections
from plantigrade.reproduce.phases import in_order, walking_events
from plantigrade.workflows import reproduce as reproducing
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.reproduce import Reproduced, ReproduceSettings
from plantigrade.workflows.textbook import recorded, textbook_walk


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    """The textbook walk, recorded and fitted."""
    path = tmp_path_factory.mktemp("walk") / "walk.c3d"
    write(recorded(textbook_walk(Human.create(1.74, 71.0), speed=1.25), path), path)
    return fit_trial(path)[1]


@pytest.fixture(scope="module")
def made(trial) -> Reproduced:
    """The gait rebuilt with the default tasks."""
    return reproducing.reproduce_trial(trial, dynamics=False)


@pytest.fixture(scope="module")
def run(made, tmp_path_factory):
    """Its run folder and its metrics."""
    return reproducing.write(
        made,
        tmp_path_factory.mktemp("runs") / "walk",
        title="A walk",
        command=["plantigrade", "reproduce", "walk.c3d"],
        settings=ReproduceSettings(),
        sources=[made.trial.fit.recording.source],
    )


def test_a_clean_walk_is_reproduced(made):
    assert reproducing.status(made) == "ok"
    assert made.motion.time[0] == pytest.approx(made.reference.start)
    assert made.motion.time[-1] == pytest.approx(made.reference.stop, abs=0.006)
    assert made.comparison.com_error_max_m < 0.005  # the issue's own bound
    assert len(made.comparison.cycles) >= 3
    low, high = made.reference.human.limits
    assert (made.motion.qpos[:, 7:] > low - 1e-6).all()
    assert (made.motion.qpos[:, 7:] < high + 1e-6).all()


@pytest.fixture(scope="module")
def forced(trial, tmp_path_factory):
    """The gait moved by forces, and its run folder."""
    made = reproducing.reproduce_trial(trial)
    folder, metrics = reproducing.write(
        made,
        tmp_path_factory.mktemp("runs") / "forced",
        title="A walk",
        command=["plantigrade", "reproduce", "walk.c3d"],
        settings=ReproduceSettings(),
        sources=[made.trial.fit.recording.source],
    )
    return made, folder, metrics


def test_forces_satisfy_their_motion_without_our_code(forced):
    """Inverse dynamics less the ground's push is the joint moments, and nothing at the root."""
    _, folder, metrics = forced
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    run = np.load(folder / "forces.npz")
    bodies = [
        model.body(f"{segment}_{side}").id
        for segment, side in zip(run["contact_segment"], run["contact_side"], strict=True)
    ]
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
    both, folder, metrics = forced
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<h2>Ground reactions: computed beside measured</h2>" in page
    assert "None was measured." in page
    np.testing.assert_array_equal(both.motion.qpos, made.motion.qpos)
    assert "vertical_force_rmse_bw" not in metrics
    assert reproducing.force_figures(made) == {}


def test_measured_forces_stand_beside_the_computed_ones(data):
    made = reproducing.reproduce_trial(fit_trial(data / "c3d/HC038A11.c3d")[1])
    assert reproducing.dynamics_status(made) == "ok"
    force, moment = reproducing.measured_forces(made)
    # where both feet are known they carry about the body's weight
    total = force[..., 2].sum(axis=1)
    assert np.nanmean(total) == pytest.approx(1.0, abs=0.15)
    ankle = moment[:, reproducing.SHOWN_MOMENTS.index("ankle_angle_r")]
    assert -2.5 < np.nanmin(ankle) < -1.0  # plantarflexion at push-off [N m/kg]
    figures = reproducing.force_figures(made)
    assert figures["vertical_force_rmse_bw"] < 0.15 and figures["vertical_force_correlation"] > 0.9
    assert figures["pressure_x_rmse_mm"] < 100, "the same foot, the same stance"
    # the arrows of the pages: one to a foot, together the body's weight over the strides
    arrows = reproducing.by_foot(reproducing.forced_record(made))["contact_force"]
    weight = made.reference.human.mass * 9.81
    assert arrows[..., 2].sum(axis=1).mean() == pytest.approx(weight, rel=0.1)


def test_a_fall_is_told_and_its_forces_end_there(forced):
    both, _, _ = forced
    motion = both.forced
    qpos = motion.qpos.copy()
    qpos[100:, 2] -= 0.3  # whatever came after
    fallen = replace(both, forced=replace(motion, qpos=qpos))
    said = reproducing.dynamics_status(fallen)
    assert "fell" in said and f"{motion.time[100]:.2f} s" in said
    assert len(reproducing.drawing(fallen).force_time) == 100
    assert any("moved by forces" in note for note in reproducing.notes(fallen))
    assert "vertical_force_rmse_bw" not in reproducing.force_figures(fallen)
    assert reproducing.status(fallen) == "ok", "the gait from accelerations stands"


def test_names_of_task_sets_are_checked(trial):
    with pytest.raises(ParameterError, match="paper"):
        reproducing.reproduce_trial(trial, "papers")


def test_the_run_folder_is_the_motion_and_the_recorded_one(made, run):
    folder, metrics = run
    held = np.load(folder / "motion.npz")
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    np.testing.assert_array_equal(held["qpos"], made.motion.qpos)
    assert held["reference_qpos"].shape == held["qpos"].shape
    assert metrics["frames"] == len(held["time"])
    # from posture, velocity and acceleration of one tick follows the posture of the next
    for k in (50, 200):
        step = held["time"][k + 1] - held["time"][k]
        qpos = held["qpos"][k].copy()
        rate = held["qvel"][k] + 0.5 * step * held["qacc"][k]
        mujoco.mj_integratePos(model, qpos, rate, step)
        assert np.abs(qpos - held["qpos"][k + 1]).max() < 2e-3
    # the centre of mass, without our code
    data = mujoco.MjData(model)
    for k in (0, 100, 300):
        data.qpos[:] = held["qpos"][k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        path = made.reference.com(float(held["time"][k]))[0]
        assert np.linalg.norm(data.subtree_com[1] - path) < 0.005


def test_metrics_are_flat_and_tell_the_tasks(made, run):
    _, metrics = run
    assert metrics["status"] == "ok" and metrics["tasks"] == "default"
    assert metrics["task_order"] == list(made.motion.names)
    assert metrics["rom_error_mean_deg"] == made.comparison.metrics()["rom_error_mean_deg"]
    stride = np.mean([c.duration for c in made.comparison.cycles])
    lasted = made.motion.time[-1] - made.motion.time[0]
    assert metrics["time_per_cycle_s"] == pytest.approx(made.seconds * stride / lasted)
    units = ("_s", "_m", "_kg", "_deg", "_mm", "_us", "_pct", "_count", "_m_s", "_bw", "_nm_kg")
    for key in reproducing.figures(made):
        assert key.endswith(units) or key in ("tasks", "task_order") or "correlation" in key, key


def test_the_report_can_be_drawn_from_the_folder_alone(made, run):
    folder, metrics = run
    held, drawn = read_reproduction(folder), reproducing.drawing(made)
    assert held is not None
    for name in ("names", "phase_kind", "contact_place", "coordinates", "tasks", "meanings"):
        assert getattr(held, name) == getattr(drawn, name)
    np.testing.assert_array_equal(held.residual, drawn.residual)
    titles = [section.title for section in reproduction_sections(held) if not section.missing]
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert all(f"<h2>{title}</h2>" in page for title in titles) and len(titles) >= 5
    assert max(drawn.com_error) == pytest.approx(made.comparison.com_error_max_m)
    assert set(drawn.level) == set(range(1, drawn.level.max() + 1))


def test_standing_is_refused_in_one_sentence(trial):
    motion = replace(trial.record.motion, events=())
    still = replace(trial, record=replace(trial.record, motion=motion))
    with pytest.raises(ReproduceError, match=r"walk\.c3d: nobody is seen to walk"):
        reproducing.reproduce_trial(still, dynamics=False)


def test_flight_is_not_walking():
    """Running: each foot leaves before the other comes down, at every step."""
    kinds = [("r", "heel_strike"), ("r", "toe_off"), ("l", "heel_strike"), ("l", "toe_off")]
    events = [GaitEvent(0.15 * k, *kinds[k % 4]) for k in range(12)]
    events = [
        replace(e, time=e.time - 0.08) if e.kind == "heel_strike" else e for e in events
    ]  # flight of 0.07 s
    same, blurred = in_order(events)
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
    mended, blurred = in_order(swapped)
    assert blurred == 1 and len(walking_events(mended)) == 12
    assert all(
        abs(a.time - b.time) < 0.1 and (a.side, a.kind) == (b.side, b.kind)
        for a, b in zip(mended, events, strict=True)
    )


def test_stairs_are_refused(trial):
    motion = trial.record.motion
    qpos = motion.qpos.copy()
    climbed = motion.time - motion.time[0]
    qpos[:, 2] += 0.15 * climbed  # a quarter of a metre over the strides
    motion = replace(motion, qpos=qpos)
    stairs = replace(trial, record=replace(trial.record, motion=motion))
    with pytest.raises(ReproduceError, match="not level"):
        reproducing.reproduce_trial(stairs, dynamics=False)


def test_a_treadmill_and_the_ground_give_one_gait(trial, made):
    """The same walk with the belt's path taken away from everything that was recorded."""
    way = 1.25 * (trial.fit.time - trial.fit.time[0])
    moved = trial.record.motion.qpos.copy()
    moved[:, 0] -= way
    feet = replace(
        trial.feet,
        heel=trial.feet.heel - way[:, None, None] * [1, 0, 0],
        toe=trial.feet.toe - way[:, None, None] * [1, 0, 0],
    )
    motion = replace(trial.record.motion, qpos=moved)
    belt = replace(trial, feet=feet, record=replace(trial.record, motion=motion))
    again = reproducing.reproduce_trial(belt, dynamics=False)
    assert reproducing.status(again) == "ok"
    assert any("treadmill" in note for note in reproducing.notes(again))
    assert not any("treadmill" in note for note in reproducing.notes(made))
    for name in ("knee_angle_r", "hip_flexion_l"):
        assert again.comparison.rom[name] == pytest.approx(made.comparison.rom[name], abs=1.5)


def test_a_stop_leaves_the_longest_run_of_steps(made):
    """Of the events before and after a pause, those after it are more."""
    events = made.reference.events
    early = [replace(e, time=e.time - 20.0) for e in events[:4]]
    trial = made.trial
    motion = replace(trial.record.motion, events=(*early, *events))
    paused = replace(made, trial=replace(trial, record=replace(trial.record, motion=motion)))
    (note,) = [n for n in reproducing.notes(paused) if "longest run" in n]
    assert f"of {len(events) + 4} gait events" in note and f"{len(events)} events" in note


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stopped": "no acceleration was found"}, "ended early"),
        ({"lift": 0.2}, "the centre of mass left its path by more than 5 cm"),
    ],
)
def test_post_mortem_in_words(made, change, words):
    motion = made.motion
    if "stopped" in change:
        motion = replace(motion, stopped=change["stopped"])
    else:
        qpos = motion.qpos.copy()
        qpos[100:, 2] += change["lift"]
        motion = replace(motion, qpos=qpos)
    said = reproducing.status(replace(made, motion=motion))
    assert words in said and "What each level missed" in said
    when = motion.time[-1] if "stopped" in change else motion.time[100]
    assert f"{when:.2f} s into the recording" in said


def test_a_pelvis_that_wanders_off_is_told(made):
    """The centre of mass is on its path, the pelvis is not."""
    reference = SimpleNamespace(
        at=lambda t: made.motion.qpos + np.eye(1, made.motion.qpos.shape[1])[0] * 0.5,
        phases=made.reference.phases,
        com=made.reference.com,
        human=made.reference.human,
    )
    said = reproducing.status(replace(made, reference=reference))
    assert "pelvis wandered" in said
