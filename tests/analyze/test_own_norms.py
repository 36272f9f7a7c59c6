"""A user's own norms: from a table, from runs, inside a record; and what is wrong with them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import norm
from plantigrade.analyze.clinical import clinical_figures, norms_for
from plantigrade.analyze.norms_of_runs import norms_of, person_curves, read_norms
from plantigrade.analyze.own_norms import as_signals, from_signals, norms_csv, read_norms_file
from plantigrade.commands.norms import Command as Norms
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import Human
from plantigrade.record import Run
from tests.pages.walker import walk

TABLE = "# our 3 friends\nvariable,percent,mean,sd\nknee_angle,0,5,4\nknee_angle,100,7,2\n"


@pytest.fixture(scope="module")
def people():
    """Walks of two people."""
    return {str(h): walk(Human.create(h, 70.0)) for h in (1.6, 1.8)}


def bent(record, degrees: float):
    """A walk with knees bent more by some degrees."""
    qpos = record.motion.qpos.copy()
    for side in "rl":
        qpos[:, 7 + record.human.hinge(f"knee_angle_{side}")] += np.deg2rad(degrees)
    return replace(record, motion=replace(record.motion, qpos=qpos))


def test_a_table_is_read_at_every_percent(tmp_path):
    path = tmp_path / "norms.csv"
    path.write_text(TABLE)
    found = read_norms(path)
    band = norm("knee_angle_r", population=found)
    assert found.people == "our 3 friends" and found.own
    assert band.mean[50] == 6.0 and band.sd[50] == 3.0 and len(band.percent) == 101
    with pytest.raises(ParameterError, match="no norm 'hip_flexion'.*knee_angle"):
        norm("hip_flexion", population=found)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("knee_angle,0", "knee_angel,0", "line 3.*did you mean knee_angle"),
        ("knee_angle,0", "knee_angle_r,0", "line 3.*write knee_angle"),
        ("mean", "average", "no column mean"),
        ("5,4", "x,4", "line 3.*must be numbers"),
        ("5,4", "5,-4", "line 3.*not negative"),
        ("5,4", "nan,4", "line 3.*finite"),
        ("knee_angle,0", '"knee_angle,0', "line 3.*no variable"),
        ("5,4", "5," + 140_000 * "4", "line 3.*not a row of a table"),
        ("100,7", "90,7", "knee_angle goes from 0 to 90 percent"),
        ("knee_angle,100,7,2\n", "", "goes from 0 to 0"),
        ("knee_angle,0,5,4\nknee_angle,100,7,2\n", "", "holds no rows"),
    ],
)
def test_faults_of_a_table_are_reported(tmp_path, old, new, words):
    path = tmp_path / "norms.csv"
    path.write_text(TABLE.replace(old, new))
    with pytest.raises(FileError, match=words):
        read_norms_file(path)


def test_mean_and_sd_are_over_people(people):
    """Two people whose knees differ by 10° have a mean between and an SD of 10 / √2."""
    first, second = people["1.6"], bent(people["1.6"], 10.0)
    found = norms_of({"a": first, "b": second}, "two")
    mean, sd = found.curves["knee_angle"]
    np.testing.assert_allclose(mean - person_curves(first)["knee_angle"], 5.0, atol=1e-6)
    np.testing.assert_allclose(sd, 10 / np.sqrt(2), atol=1e-6)
    assert {"pelvis_tilt", "foot_progression", "ground_force_up"} <= set(found.curves)


def test_a_table_written_from_runs_reads_the_same(tmp_path, people):
    found = norms_of(people, "two\npeople")
    path = tmp_path / "norms.csv"
    path.write_text(norms_csv(found))
    again = read_norms(path)
    assert again.people == "two people" and list(again.curves) == list(found.curves)
    for name, (mean, _) in found.curves.items():
        np.testing.assert_allclose(again.curves[name][0], mean, rtol=1e-4, atol=1e-5)


def test_a_folder_of_runs_is_a_norm(tmp_path, people):
    for name, record in people.items():
        Run(record, "fit").save(tmp_path / "runs" / name)
    (tmp_path / "runs" / "table").mkdir()
    (tmp_path / "runs" / "table" / "metrics.json").write_text(json.dumps({"status": "ok"}))
    found = read_norms(tmp_path / "runs")
    assert found.people == "2 people: the runs in runs"
    with pytest.raises(ParameterError, match="at least 2 people.*holds 1"):
        read_norms(tmp_path / "runs" / "1.6")


def test_runs_that_are_no_measure_of_walking_are_left_out_and_named(tmp_path, people):
    first, second = people.values()
    ends = first.motion.time[0] + first.motion.time[-1]
    kinds = {"heel_strike": "toe_off", "toe_off": "heel_strike"}
    events = [replace(e, time=ends - e.time, kind=kinds[e.kind]) for e in first.motion.events]
    backward = replace(first.motion, qpos=first.motion.qpos[::-1], events=tuple(events[::-1]))
    runs = {
        "ok": Run(first, "fit"),
        "wrong": Run(second, "fit", status="the markers are 31 mm off"),
        "still": Run(replace(first, motion=replace(first.motion, events=())), "fit"),
        "back": Run(replace(first, motion=backward), "fit"),
    }
    for name, run in runs.items():
        run.save(tmp_path / "runs" / name)
    with pytest.raises(ParameterError, match="1 can be used.*back: .*backward.*cycle.*31 mm"):
        read_norms(tmp_path / "runs")
    Run(second, "fit").save(tmp_path / "runs" / "other")
    outcome = Norms(runs=(tmp_path / "runs",), out=tmp_path / "norms.csv", quiet=True).run()
    assert "2 people: the runs in runs without back, still, wrong" in outcome.text
    assert "back: it walks backward" in outcome.text
    alone = norms_of({"ok": first, "other": second}, "")
    found = read_norms(tmp_path / "norms.csv").curves["knee_angle"][0]
    np.testing.assert_allclose(found, alone.curves["knee_angle"][0], atol=1e-4)


def test_a_person_is_compared_with_own_norms_inside_the_record(people):
    """A gait that is itself the mean scores zero, and the reason is said."""
    record = people["1.6"]
    own = norms_of({"a": record, "b": bent(record, 10.0)}, "two")
    held = replace(bent(record, 5.0), signals=as_signals(own))
    assert from_signals(held.signals).people == "two"
    assert norms_for(held, {}).reason == "given with --norms"
    found = clinical_figures(held, {})
    assert found["norm_population"] == "own norms"
    assert found["gvs_knee_angle_r_deg"] == pytest.approx(0.0, abs=0.2)
    assert found["gps_deg"] < 0.5 < clinical_figures(record, {})["gps_deg"]


def test_age_comes_before_height(people):
    record = people["1.6"]
    assert clinical_figures(record, {})["norm_population"] == "adults"
    child = clinical_figures(record, {"age_years": 9.0})
    assert child["norm_population"] == "children" and "age of 9" in child["norm_reason"]
    assert child["gps_reference_deg"] != clinical_figures(record, {})["gps_reference_deg"]


def test_an_estimated_stature_chooses_no_norms():
    child = walk(Human.create(1.3, 27.0))
    known = clinical_figures(child, {})
    assert known["norm_population"] == "children" and "1.30 m" in known["norm_reason"]
    estimated = clinical_figures(child, {"height_estimated": True})
    assert estimated["norm_population"] == "adults" and "1.30" not in estimated["norm_reason"]
    aged = clinical_figures(child, {"height_estimated": True, "age_years": 9.0})
    assert aged["norm_population"] == "children"


def test_a_run_is_held_against_own_norms_only(people):
    """Norms of walking are no measure of running; those of one's own runners are."""
    record = people["1.6"]
    running = clinical_figures(record, {"running": True})
    assert not any(key.startswith(("gps", "norm")) for key in running)
    assert any(key.startswith("trend_symmetry") for key in running)
    own = norms_of({"a": record, "b": bent(record, 10.0)}, "two")
    held = replace(record, signals=as_signals(own))
    assert clinical_figures(held, {"running": True})["norm_population"] == "own norms"
