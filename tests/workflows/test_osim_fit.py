"""Recordings on a person's own OpenSim model, from the files to the run folder."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands import main as cli
from plantigrade.dynamics import plate_checks
from plantigrade.errors import FitError, ParameterError
from plantigrade.io import read
from plantigrade.io.mot import read_table, write_mot
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.trc import write_trc
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.markers import MARKER_SETS, places_of
from plantigrade.models.osim import to_osim
from plantigrade.motion import Markers, Recording, Table
from plantigrade.record import Run
from tests.analyze.plated_walk import FAR, analyse, plated_walk


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """Return the folder of a walk with its forces and its model, and the run behind them."""
    folder = tmp_path_factory.mktemp("own")
    run = Run(analyse(plated_walk().fit(), cutoff=None).record(), "fit", name="walk")
    run.export(folder / "walk.trc", marker_set="rajagopal", rate=25)
    run.export(folder / "anna.osim", marker_set="rajagopal")
    return folder, run


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Return a recording of twelve frames and its model."""
    folder = tmp_path_factory.mktemp("short")
    human = Human.create(1.7, 65.0, joints="42", feet="rigid")
    places = places_of(MARKER_SETS["rajagopal"], human)
    (folder / "anna.osim").write_text(to_osim(human, places), encoding="utf-8")
    own = OsimHuman.of((folder / "anna.osim").read_text(encoding="utf-8"))
    time = 0.02 * np.arange(12)
    u = np.tile(own.defaults(), (12, 1))
    u[:, [c.name for c in own.every_coordinate].index("hip_flexion_r")] = np.sin(4 * time)
    path = PointSet.of(own, list(own.places.values())).path(own.poses(u))
    markers = Markers(tuple(own.places), time, path)
    write_trc(Recording(folder / "kick.trc", markers=markers), folder / "kick.trc")
    return folder


def test_a_run_on_an_own_model_is_kept_whole(short, tmp_path):
    run = pg.fit(short / "kick.trc", model=short / "anna.osim")
    assert run.ok and run.figures["marker_rms_mean_mm"] < 1
    assert "anna.osim" in run.provenance.source_files
    saved = run.save(tmp_path / "run")
    again = Run.load(saved.folder)
    assert isinstance(again.record.human, OsimHuman)
    assert again.record.motion["hip_flexion_r"] == pytest.approx(run.record.motion["hip_flexion_r"])
    written = read_table(saved.folder / "motion.mot")
    assert set(written.names) == {c.name for c in run.record.human.every_coordinate}
    assert run.export(tmp_path / "same.osim")
    assert OsimHuman.of((tmp_path / "same.osim").read_text(encoding="utf-8")).mass == pytest.approx(
        65.0
    )


def test_a_standing_trial_beside_it_is_said_not_to_be_used(short, tmp_path):
    for name in ("kick.trc", "anna.osim"):
        (tmp_path / name).write_bytes((short / name).read_bytes())
    kick = read(short / "kick.trc").markers
    assert kick is not None
    still = replace(kick, positions=np.repeat(kick.positions[:1], len(kick.time), axis=0))
    write_trc(Recording(tmp_path / "static.trc", markers=still), tmp_path / "static.trc")
    run = pg.fit(tmp_path / "kick.trc", model=tmp_path / "anna.osim")
    assert "static.trc" not in run.provenance.source_files
    assert [n for n in run.record.notes if "static.trc" in n and "not used" in n]


def test_a_wrong_rate_is_refused_as_a_rate(short):
    with pytest.raises(ParameterError, match="rate") as caught:
        pg.fit(short / "kick.trc", rate=0.0)
    assert "walking" not in str(caught.value)


@pytest.mark.slow
def test_the_command_writes_pages_and_what_needs_our_anatomy_is_refused(short, tmp_path, capsys):
    out = tmp_path / "run"
    words = ["fit", str(short / "kick.trc"), "--model", str(short / "anna.osim"), "--out", str(out)]
    assert cli.main(words) == 0
    assert {"report.html", "viewer.html", "motion.mot"} <= {p.name for p in out.iterdir()}
    for words in (["convert", str(out), str(tmp_path / "x.bvh")], ["simulate", str(out)]):
        assert cli.main(words) == 2
        assert "without --model" in capsys.readouterr().err


def test_options_of_a_scaled_human_are_refused(short):
    with pytest.raises(ParameterError, match="joints has no effect with a model of your own"):
        pg.fit(short / "kick.trc", model=short / "anna.osim", joints="43")


def test_joint_angles_of_a_file_move_the_model_as_they_are(short, tmp_path):
    human = OsimHuman.of((short / "anna.osim").read_text(encoding="utf-8"))
    names = [c.name for c in human.every_coordinate]
    u = np.tile(human.defaults(), (40, 1))
    u[:, names.index("knee_angle_r")] = np.sin(np.linspace(0, 3, 40))
    time = 0.02 * np.arange(40)
    written = Table((*names[1:], "mine_r"), time, np.roll(u, -1, axis=1))
    write_mot(written, tmp_path / "angles.mot")
    run = pg.fit(tmp_path / "angles.mot", model=short / "anna.osim", cutoff=20)
    assert run.ok and "joint angles" in run.sentence
    knee = u[:, names.index("knee_angle_r")]
    assert run.record.motion["knee_angle_r"] == pytest.approx(knee, abs=0.01)
    notes = "\n".join(run.record.notes)
    assert "mine_r" in notes and f"default: {names[0]}" in notes
    table = Table(("ankle_angle_x", "elbow_flexion_r"), time, u[:, :2])
    write_mot(table, tmp_path / "other.mot")
    with pytest.raises(FitError, match="none of the coordinates"):
        pg.fit(tmp_path / "other.mot", model=short / "anna.osim")


@pytest.mark.slow
def test_files_of_a_walk_give_its_angles_and_moments_back(walk, tmp_path):
    folder, source = walk
    with patch.object(plate_checks, "MAX_SOLE_DISTANCE", FAR):  # that walk does not sway
        run = pg.fit(folder / "walk.trc", model=folder / "anna.osim")
    assert read(folder / "walk_grf.mot").plates
    saved = replace(run, name="walk")
    record, before = saved.record, source.record
    clock = record.motion.time + before.motion.time[0] - record.motion.time[0]
    inner = slice(12, -12)
    for name in ("hip_flexion_r", "knee_angle_l", "ankle_angle_r"):
        angle = np.interp(clock, before.motion.time, before.motion[name])
        assert record.motion[name][inner] == pytest.approx(angle[inner], abs=np.deg2rad(2))
        moment = np.interp(clock, before.motion.time, before.torque(name))
        assert np.corrcoef(record.torque(name)[inner], moment[inner])[0, 1] > 0.98, name
    assert {event.kind for event in record.motion.events} == {"heel_strike", "toe_off"}
    found = pg.compare(saved, saved.save(tmp_path / "again"))
    assert "knee_angle_r" in next(iter(found.differences.values()))
