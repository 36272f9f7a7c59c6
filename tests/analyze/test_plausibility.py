"""A motion that its forces contradict, or that no person could make, is not ok."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.frame_rate import rate_doubt
from plantigrade.analyze.human_limits import motion_notes
from plantigrade.analyze.plausibility import Plausibility
from plantigrade.kinematics import exchanged_labels
from plantigrade.motion import GaitEvent
from plantigrade.workflows.fit import run_of
from plantigrade.workflows.settings import FitSettings
from tests.analyze.bodies import having
from tests.analyze.plated_walk import analyse, plated_walk
from tests.analyze.standing import standing_record


@pytest.fixture
def run(tmp_path):
    """The run of a fit, as a user gets it."""
    source = tmp_path / "walk.c3d"
    source.touch()

    def made(fit):
        fit = replace(fit, recording=replace(fit.recording, source=source))
        return run_of(fit.recording, analyse(fit), FitSettings())

    return made


def with_plates(fit, share):
    """Return a fit whose plates show a share of the force."""
    plates = tuple(replace(p, force=share * p.force) for p in fit.recording.plates)
    return replace(fit, recording=replace(fit.recording, plates=plates))


def test_a_walk_that_its_forces_explain_is_ok(run):
    found = run(plated_walk().fit())
    assert found.status == "ok" and found.figures["root_residual_rms_bw"] < 0.1
    assert not found.figures["joints_too_fast"]
    assert not any(
        "do not match the motion" in note or "faster" in note for note in found.record.notes
    )


@pytest.mark.parametrize(("share", "status"), [(0.75, "ok"), (0.55, "do not match")])
def test_forces_that_do_not_explain_the_motion_are_the_first_note(share, status, run):
    found = run(with_plates(plated_walk().fit(), share))
    assert "do not match" in found.record.notes[0]
    assert status in found.status
    assert found.figures["root_residual_rms_bw"] == pytest.approx(1 - share, abs=0.1)


def by_plate(change):
    """Return a fit of the walk whose plates are changed."""
    fit = plated_walk().fit()
    plates = tuple(change(k, plate) for k, plate in enumerate(fit.recording.plates))
    return replace(fit, recording=replace(fit.recording, plates=plates))


def times(*factors):
    """Return a change of the force by factors along x, y and z."""
    return lambda _, plate: replace(plate, force=plate.force * factors)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (times(-1, -1, 1), "opposite"),
        (times(-1, 1, 1), "fore-aft force has the opposite"),
        (lambda k, p: p if k else replace(p, force=p.force * [-1, 1, 1]), "under the right foot"),
        (lambda _, p: replace(p, force=p.force[:, [1, 0, 2]]), "axis"),
        (times(3, 3, 1), "times as much"),
        (lambda _, p: replace(p, free_moment=1000.0 * p.free_moment + 200.0), "unit of moments"),
    ],
)
def test_forces_of_another_sign_axis_or_unit_are_not_ok(change, expected, run):
    found = run(by_plate(change))
    assert expected in found.status
    assert any(note.startswith(found.status) for note in found.record.notes[:2])


@pytest.mark.parametrize("clock", [2.0, 1.2, 1 / 1.2, 0.5])
def test_a_wrong_frame_rate_is_named_with_its_factor_and_not_ok(clock, run):
    fit = by_plate(lambda _, p: replace(p, time=clock * p.time))
    status = run(replace(fit, time=clock * fit.time)).status
    (factor, how) = re.findall(r"(\d\.\d) times too (low|high)", status)[0]
    assert float(factor) == pytest.approx(max(clock, 1 / clock), rel=0.1)
    assert how == ("low" if clock > 1 else "high")


@pytest.mark.parametrize(("share", "fails"), [(0.5, True), (0.9, False)])
def test_a_mass_that_nobody_of_this_stature_has_is_not_ok(share, fails, run):
    fit = with_plates(plated_walk().fit(), share)
    subject = replace(fit.recording.subject, mass=None)
    found = run(replace(fit, recording=replace(fit.recording, subject=subject)))
    assert ("scale of the forces" in found.status) == fails
    assert (found.status == "ok") != fails


def test_what_else_carries_the_person_on_one_side_is_named(run):
    """A cane takes a tenth of the weight while the left foot stands alone."""
    whole = plated_walk().fit()
    assert not any("something else carries" in note for note in run(whole).record.notes)
    record = analyse(whole)
    assert record.forces is not None
    load = record.forces.force[..., 2]
    left = load[:, 1] / np.maximum(load.sum(axis=1), 50.0)
    less = [
        replace(p, force=p.force * (1 - 0.12 * np.interp(p.time, whole.time, left))[:, None])
        for p in whole.recording.plates
    ]
    found = run(replace(whole, recording=replace(whole.recording, plates=tuple(less))))
    (note,) = [n for n in found.record.notes if "something else carries" in n]
    assert "left foot" in note


@pytest.mark.parametrize(("clock", "word"), [(2.0, "too low"), (0.5, "too high")])
def test_a_wrong_frame_rate_shows_in_the_steps_without_plates(clock, word, run):
    fit = plated_walk().fit()
    alone = replace(fit.recording, plates=())
    assert word in run(replace(fit, time=clock * fit.time, recording=alone)).record.notes[0]


@pytest.mark.parametrize(("rate", "how"), [(1.03, "slower"), (0.97, "faster")])
def test_plates_whose_clock_drifts_away_are_named(rate, how, run):
    found = run(by_plate(lambda _, p: replace(p, time=rate * p.time)))
    (note,) = [n for n in found.record.notes if "drift apart" in n]
    assert how in note
    (percent,) = re.findall(r"(\d\.\d) %", note)
    assert float(percent) == pytest.approx(3.0, abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("clock", [1.2, 1.0, 1 / 1.2])
@pytest.mark.parametrize(
    "name",
    [
        "opensim/rajagopal_walk/markers_walk.trc",
        "c3d/HC038A11.c3d",
        "opensim/opencap_subject4/DJ1.trc",
        "opensim/running_subject04/run300.trc",
    ],
)
def test_gravity_shows_the_frame_rate_of_people_without_plates(name, clock, data):
    """Walks by pendulum and steps, a jump and a run in flight."""
    from plantigrade.workflows.fit import fit_recording, load

    recording = load(data / name, FitSettings())
    assert recording.markers is not None
    slow = replace(recording.markers, time=clock * recording.markers.time)
    fit = fit_recording(replace(recording, markers=slow, plates=(), events=()), FitSettings())
    doubt, _ = rate_doubt(analyse(fit))
    if clock == 1.0:
        assert doubt == ""
    else:
        factor, how = re.findall(r"(\d\.\d) times too (low|high)", doubt)[0]
        assert how == ("low" if clock > 1 else "high")
        assert float(factor) == pytest.approx(max(clock, 1 / clock), abs=0.1)


def test_forces_that_belong_to_the_motion_are_believed(run):
    found = run(plated_walk().fit())
    assert found.status == "ok"
    assert not any("act" in note or "backward" in note for note in found.record.notes)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda _, p: replace(p, cop=p.cop + [0.05, 0.0, 0.0]), "mm ahead of"),
        (lambda _, p: replace(p, cop=p.cop + [0.0, 0.05, 0.0]), "mm to the left of"),
        (times(2e-3, 2e-3, 2e-3), "no step"),
    ],
)
def test_plates_elsewhere_or_in_another_unit_are_the_first_note(change, expected, run):
    assert expected in run(by_plate(change)).record.notes[0]


def test_a_shoulder_that_unwinds_from_the_other_triple_of_angles_is_the_first_note(run):
    """Within 0.1 s, from (a + 180°, -180° - b, c + 180°) to (a, b, c), which is the same pose."""
    fit = plated_walk().fit()
    human, qpos = fit.human, fit.qpos.copy()
    flex, add, turn = (7 + human.hinge(f"arm_{each}_l") for each in ("flex", "add", "rot"))
    part = np.clip((np.arange(len(qpos)) - 60) / (0.1 / np.diff(fit.time)[0]), 0, 1)
    qpos[:, add] += (1 - part) * (-np.pi - 2 * qpos[:, add])
    qpos[:, flex] += (1 - part) * np.pi
    qpos[:, turn] += (1 - part) * np.pi * 0.9
    wrong = replace(fit, qpos=qpos)
    assert any(
        name.startswith("arm_") for name in Plausibility.of(analyse(wrong, cutoff=None)).fast
    )
    assert "do not match" in run(wrong).record.notes[0]


@pytest.mark.parametrize("reverse", [False, True])
def test_a_mirror_image_that_was_fitted_after_all_is_not_ok(data, monkeypatch, reverse):
    """Legs alone, with the search for mirrored labels switched off; a true backward walk is ok."""
    from plantigrade.io import read
    from plantigrade.kinematics.fit import fit_markers
    from plantigrade.kinematics.sides import swap_sides
    from plantigrade.models import Person

    monkeypatch.setattr(exchanged_labels, "MAX_MIRRORED_RATIO", 0.0)
    whole = read(data / "c3d" / "HC032A03.c3d")
    names = [s + n for s in "LR" for n in "ASI THI KNE TIB ANK HEE TOE".split()]
    markers = whole.markers.select(names)
    if reverse:
        markers = replace(markers, positions=markers.positions[::-1].copy())
    legs = replace(whole, markers=markers, plates=(), outputs={}, events=())
    fitted = fit_markers(legs if reverse else swap_sides(legs), Person(height=1.58, mass=60.3))
    plausibility = Plausibility.of(analyse(fitted, cutoff=6.0))
    assert plausibility.mirrored != reverse
    assert any("backward" in note for note in plausibility.doubts) == reverse
    assert ("--swap-sides" in plausibility.failure) != reverse


# Motions that were computed ----------------------------------------------------------------------


def walked(record, interval):
    """Return a record in which feet strike in turn at an interval [s]."""
    times = np.arange(0.0, record.motion.time[-1], interval)
    events = [GaitEvent(float(t), "rl"[k % 2], "heel_strike") for k, t in enumerate(times)]
    return replace(record, motion=replace(record.motion, events=tuple(events)))


def test_a_person_who_stands_or_steps_upright_is_plausible():
    record = standing_record()
    assert motion_notes(record) == [] and motion_notes(walked(record, 0.25)) == []


def test_a_cadence_beyond_runners_is_named():
    (note,) = motion_notes(walked(standing_record(), 0.2))
    assert "300 steps/min" in note and "more than 250" in note


def test_a_trunk_that_leans_in_walking_is_named_with_its_angle():
    record = standing_record()
    qpos = record.motion.qpos.copy()
    qpos[:, 7 + record.human.hinge("lumbar_extension")] -= np.deg2rad(28.0)
    bent = having(record, qpos=qpos)
    assert motion_notes(bent) == []  # in standing people bend
    (note,) = motion_notes(walked(bent, 0.5))
    assert "leans 28° forward" in note


def test_power_and_strength_beyond_people_are_named():
    record = standing_record()
    k = record.human.hinge("knee_angle_r")
    tau, qvel = record.qfrc_actuator.copy(), record.motion.qvel.copy()
    most = record.human.model.jnt_actfrcrange[1 + k, 1]
    tau[5, 6 + k], qvel[5, 6 + k] = 0.9 * most, 50.0 * record.human.mass / (0.9 * most)
    (note,) = motion_notes(having(replace(record, qfrc_actuator=tau), qvel=qvel))
    assert "knee_angle_r works at 50 W/kg" in note
    tau[5, 6 + k], qvel[5, 6 + k] = 1.5 * most, 0.0
    (note,) = motion_notes(having(replace(record, qfrc_actuator=tau), qvel=qvel))
    assert "knee_angle_r needs 150 %" in note
