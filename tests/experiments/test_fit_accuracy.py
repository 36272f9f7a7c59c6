"""Accuracy on public recordings, held as it was reached, and the yardsticks themselves."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from experiments import fit_accuracy
from experiments.event_agreement import match
from experiments.fit_accuracy import posture_rows, roughness
from experiments.stored_angles import (
    agreement,
    agreement_sheet,
    on_clock,
    shared,
    turned,
)
from plantigrade.commands import main as cli
from plantigrade.motion import GaitEvent, Table

LEGS = [
    f"{joint}_{side}" for joint in ("hip_flexion", "knee_angle", "ankle_angle") for side in "rl"
]
RAJAGOPAL = "opensim_rajagopal_walk_markers_walk_trc"
GAIT2392 = "opensim_gait2392_subject01_subject01_walk1_trc"
HC = ("c3d/HC038A11.c3d", "c3d/HC038A27.c3d", "c3d/HC032A03.c3d")


def key(name: str) -> str:
    """Trial as the keys of the metrics have it."""
    return name.lower().replace("/", "_").replace(".", "_")


def experiment(data: Path) -> dict:
    """Run the experiment in a process of its own and return its metrics."""
    done = subprocess.run(
        [sys.executable, "-m", "plantigrade", "experiment", "fit-accuracy", "--json", "--quiet",
         "--data", str(data)],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def metrics(data, tmp_path_factory):
    """The experiment on the walks with markers, and on one skeleton; all take three times as long.

    Folders of the trials are linked, so that their forces and standing trials are found.
    """
    some = tmp_path_factory.mktemp("some")
    for folder in ("c3d", "opensim/rajagopal_walk", "opensim/gait2392_subject01"):
        (some / folder).parent.mkdir(parents=True, exist_ok=True)
        (some / folder).symlink_to(data / folder)
    (some / "cmu_bvh").mkdir()
    (some / "cmu_bvh" / "07_01.bvh").symlink_to(data / "cmu_bvh" / "07_01.bvh")
    return experiment(some)


@pytest.mark.slow
@pytest.mark.parametrize("name", fit_accuracy.WALKS)
def test_markers_are_met_within_a_centimetre(metrics, name):
    rms = metrics[f"{key(name)}_marker_rms_mean_mm"]
    assert rms < 8, "reached: 4 to 6.5 mm; asked: 10 mm"


@pytest.mark.slow
@pytest.mark.parametrize("who", ["people_on_whom_constants_were_settled", "other_people"])
def test_the_centre_of_mass_is_where_the_forces_place_it(metrics, who):
    """It was 13 mm ahead on average of people before their torso was placed as published."""
    assert abs(metrics[f"{who}_centre_of_mass_ahead_of_the_forces_mean_mm"]) < 10


@pytest.mark.slow
@pytest.mark.parametrize("angle", LEGS)
def test_angles_of_opensim(metrics, angle):
    figure = "rmse_without_offset_deg"
    assert metrics[f"{RAJAGOPAL}_{angle}_against_opensim_{figure}"] < 3
    assert metrics[f"{GAIT2392}_{angle}_against_opensim_with_rigid_feet_as_there_{figure}"] < 3


@pytest.mark.slow
@pytest.mark.parametrize("angle", LEGS)
def test_moments_of_opensim(metrics, angle):
    stem = f"{RAJAGOPAL}_{angle}_moment_against_opensim"
    assert metrics[f"{stem}_r"] > 0.94
    assert metrics[f"{stem}_peak_pct"] < 10


@pytest.mark.slow
@pytest.mark.parametrize("name", HC)
def test_angles_and_moments_of_plug_in_gait(metrics, name):
    trial = key(name)
    for angle in LEGS:
        assert metrics[f"{trial}_{angle}_against_plug_in_gait_r"] > 0.95, angle
    moments = {k: v for k, v in metrics.items() if k.startswith(trial) and "moment_against" in k}
    assert len(moments) >= 3
    assert min(moments.values()) > 0.92, moments


@pytest.mark.slow
@pytest.mark.parametrize("name", ["c3d/HC038A11.c3d", "c3d/HC032A03.c3d"])
def test_events_of_straight_walks(metrics, name):
    trial = key(name)
    for kind in ("heel_strike", "toe_off"):
        assert metrics[f"{trial}_{kind}_against_file_missed"] == 0
        assert metrics[f"{trial}_{kind}_against_file_invented"] == 0
        stem = f"{trial}_{kind}_against_file_mean"
        mae = [v for k, v in metrics.items() if k.startswith(stem)]
        assert len(mae) == 1 and mae[0] < 20


@pytest.mark.slow
@pytest.mark.parametrize("side", "rl")
@pytest.mark.parametrize("name", [*HC, "c3d/gaitalytics_treadmill_events.c3d"])
def test_other_planes_of_plug_in_gait(metrics, name, side):
    def figure(angle, what):
        return metrics[f"{key(name)}_{angle}_{side}_against_plug_in_gait_{what}"]

    assert figure("hip_adduction", "r") > 0.93, "reached .94 to .99; asked .95"
    assert figure("hip_adduction", "rmse_deg") < 3.5, "reached 1.5 to 3.2; asked 3"
    assert abs(figure("hip_adduction", "range_ours_less_theirs_deg")) < 4, "5 to 9 before"
    assert figure("ankle_dorsiflexion", "r") > 0.99
    assert figure("ankle_dorsiflexion", "rmse_without_offset_deg") < 2.5
    if name in HC:
        assert figure("foot_progression", "r") > 0.95


@pytest.mark.slow
def test_goals_are_met(metrics):
    """Hip rotation against knees that turn freely, and deep squats, are most of the rest."""
    assert metrics["goals"] > 200
    assert metrics["goals_met"] >= 0.77 * metrics["goals"]


def test_missing_and_broken_trials_are_named(tmp_path, capsys):
    """Nothing there is a table of notes; a broken file is a goal not met, not the end."""
    (tmp_path / "c3d").mkdir()
    (tmp_path / "c3d" / "HC038A11.c3d").write_bytes(b"nonsense")
    assert cli.main(["experiment", "fit-accuracy", "--data", str(tmp_path), "--quiet"]) == 0
    out = capsys.readouterr().out
    assert "HC038A27.c3d is not there and was left out" in out
    assert "0 of 1 goals met" in out
    shutil.rmtree(tmp_path / "c3d")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["experiment", "no-such"], "fit-accuracy"),
        (["experiment", "fit-accuracy", "--data", "nowhere"], "--data"),
    ],
)
def test_bad_input(words, sentence, capsys):
    assert cli.main(words) == 2
    assert sentence in capsys.readouterr().err


def events(*rows) -> list[GaitEvent]:
    return [GaitEvent(t, side, "heel_strike") for t, side in rows]


def test_events_are_matched_once_by_side_and_nearness():
    truth = events((1.0, "r"), (1.5, "l"), (2.0, "r"))
    ours = events((1.01, "r"), (1.49, "l"), (2.02, "r"))
    errors, missed, invented = match(ours, truth, "heel_strike", complete=True)
    np.testing.assert_allclose(errors, [0.01, -0.01, 0.02])
    assert (missed, invented) == (0, 0)
    # the other foot's, another kind's, and one too far off are no match
    assert match(events((1.0, "l")), truth[:1], "heel_strike", complete=True)[1] == 1
    assert match([GaitEvent(1.0, "r", "toe_off")], truth[:1], "heel_strike", complete=True)[1] == 1
    assert match(events((1.2, "r")), truth[:1], "heel_strike", complete=True)[1] == 1
    # one of ours answers one of theirs; what is left inside their span is invented
    double = events((1.0, "r"), (1.05, "r"), (1.5, "l"), (2.0, "r"), (9.0, "l"))
    assert match(double, truth, "heel_strike", complete=True)[1:] == (0, 1)
    assert match(double, truth, "heel_strike", complete=False)[2] == 0


def test_signals_are_laid_on_one_clock():
    slow, fast = np.arange(0, 1, 0.1), np.arange(0.2, 0.8, 0.05)
    a = Table(("x",), slow, 2 * slow[:, None])
    b = Table(("x",), fast, 3 * fast[:, None])
    ours, theirs = shared(a, b, "x")
    np.testing.assert_allclose(3 * ours, 2 * theirs)
    placed = on_clock(slow, slow**2, np.array([0.3, 0.35, 0.6]))
    np.testing.assert_allclose(placed, [0.09, np.nan, 0.36])
    assert np.isnan(on_clock(slow, slow, np.array([-0.5, 2.0]))).all()


def test_an_agreement_tells_shape_from_offset_and_range():
    time = np.linspace(0, 1, 101)
    theirs = 10 * np.sin(2 * np.pi * time)
    same = agreement("hip_adduction_r", "Plug-in Gait", theirs + 4, theirs)
    np.testing.assert_allclose(same.values, [1, 4, 0, 0, 4], atol=1e-9)
    wider = agreement("hip_adduction_r", "Plug-in Gait", 1.5 * theirs, theirs)
    np.testing.assert_allclose(wider.values[0], 1)
    np.testing.assert_allclose(wider.values[3], 10)
    late = agreement("hip_adduction_r", "Plug-in Gait", 10 * np.cos(2 * np.pi * time), theirs)
    assert abs(late.values[0]) < 0.02
    assert agreement("hip_adduction_r", "Plug-in Gait", theirs, 0.05 * theirs) is None, "locked"
    gaps = np.where(time > 0.1, np.nan, theirs)
    assert agreement("hip_adduction_r", "Plug-in Gait", theirs, gaps) is None, "too few"

    def met(found):
        return {r.quantity.split(", ")[1]: r.met for r in found.rows("walk") if r.goal}

    assert met(same) == {"r": True, "RMSE": False}
    assert met(late) == {"r": False, "RMSE": False}
    rows = [*same.rows("walk"), *wider.rows("run")]
    text = agreement_sheet("Angles", rows)
    assert len(text.splitlines()) == 6 and "hip_adduction_r against Plug-in Gait" in text


def test_the_pelvis_of_another_heading_is_turned_with_the_recording():
    """A person who walks back along the axis tilts the other way about the room's axes."""
    names = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "hip_flexion_r")
    walk = np.array([[0.2, 0.05, 0.1, 0.5], [0.25, -0.05, -0.1, 0.6]])
    there = Table(names, np.array([0.0, 1.0]), walk)
    back = turned(there, np.pi)
    np.testing.assert_allclose(back.values[:, 0], -walk[:, 0], atol=0.02)
    np.testing.assert_allclose(turned(back, -np.pi).values, walk, atol=1e-9)
    np.testing.assert_allclose(turned(there, 0.0).values, walk)


def test_roughness_tells_noise_from_movement():
    t = np.arange(200) / 100
    smooth = np.sin(2 * np.pi * t)
    noise = np.random.default_rng(0).normal(size=200)
    assert roughness(smooth) < 0.02 < fit_accuracy.MAX_MOMENT_ROUGHNESS < roughness(noise)
    # of white noise the second difference has sqrt(6) times its spread
    assert roughness(np.random.default_rng(1).normal(size=20000)) == pytest.approx(6**0.5, rel=0.03)


def test_a_body_that_does_not_stand_like_one_misses_its_goals():
    """What the first version made of HC038A11: lumbar joint 143 mm behind the hips, hunched."""
    good = {
        "lumbar_behind_hips_mm": 47.0,
        "trunk_lean_mean_deg": 4.0,
        "neck_lean_mean_deg": 7.0,
        "arms_at_stop_pct": 0.0,
        "trunk_lean_standing_deg": -3.0,
    }
    assert all(row.met for row in posture_rows("walk", good) if row.goal)
    bad = {"lumbar_behind_hips_mm": 143.0, "trunk_lean_standing_deg": 16.4}
    bad["arms_at_stop_pct"] = 52.0
    for name, value in bad.items():
        missed = [row for row in posture_rows("walk", {**good, name: value}) if row.met is False]
        assert [row.value for row in missed] == [value], name
