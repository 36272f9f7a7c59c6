"""Runs as BIDS Motion."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.motion import Markers

NAME = "sub-01_task-walk_tracksys-plantigrade_motion.tsv"


@pytest.fixture
def dataset(walk, tmp_path):
    """Return a folder with a dataset of one run with two markers, and its record."""
    record = walk.record
    path = np.random.default_rng(0).normal(0, 0.1, (record.motion.n_frames, 2, 3))
    path[3, 0] = np.nan
    seen = Markers(("R KNE", "LKNE"), record.motion.time, path)
    record = replace(record, recorded_markers=seen, fitted_markers=path)
    folder = tmp_path / "sub-01" / "motion"
    folder.mkdir(parents=True)
    replace(walk, record=record).export(folder / NAME)
    return tmp_path, record


def test_the_files_agree_with_each_other_and_with_the_record(dataset):
    root, record = dataset
    stem = root / "sub-01/motion" / NAME.removesuffix("_motion.tsv")
    header, *rows = (stem.parent / f"{stem.name}_channels.tsv").read_text().splitlines()
    channels = [dict(zip(header.split("\t"), row.split("\t"), strict=True)) for row in rows]
    names = [channel["name"] for channel in channels]
    values = np.genfromtxt(stem.parent / NAME, missing_values="n/a")
    assert values.shape == (record.motion.n_frames, len(channels))
    knee = names.index("knee_angle_r")
    assert channels[knee]["type"] == "JNTANG" and channels[knee]["units"] == "deg"
    expected = np.rad2deg(record.motion["knee_angle_r"])
    assert values[:, knee] == pytest.approx(expected, abs=1e-4)
    marker = names.index("R_KNE_y")
    assert channels[marker] == {
        "name": "R_KNE_y",
        "component": "y",
        "type": "POS",
        "tracked_point": "R_KNE",
        "units": "m",
        "reference_frame": "world",
    }
    assert np.isnan(values[3, marker]) and np.isfinite(values[4, marker])
    sidecar = json.loads((stem.parent / f"{stem.name}_motion.json").read_text())
    assert sidecar["MotionChannelCount"] == len(channels) and sidecar["TaskName"] == "walk"
    assert sidecar["SamplingFrequency"] == pytest.approx(record.motion.rate, rel=1e-3)
    assert sidecar["TrackedPointsCount"] == 3
    events = (stem.parent / f"{stem.name}_events.tsv").read_text().splitlines()
    assert len(events) == 1 + len(record.motion.events)


def test_a_name_that_bids_does_not_know_is_refused(walk, tmp_path):
    with pytest.raises(FileError, match="sub-LABEL_task-LABEL_tracksys-LABEL_motion.tsv"):
        walk.export(tmp_path / "walk.tsv")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_validator_of_bids_finds_no_error(dataset):
    pytest.importorskip("bids_validator_deno")
    root, _ = dataset
    described = {"Name": "walk", "BIDSVersion": "1.10.0", "DatasetType": "raw", "License": "CC0"}
    (root / "dataset_description.json").write_text(json.dumps(described))
    (root / "README.md").write_text("A walk of mean angles, on a person, for a test.\n" * 5)
    (root / "participants.tsv").write_text("participant_id\nsub-01\n")
    command = "import sys, bids_validator_deno as b; sys.argv[1:] = sys.argv[1:]; b.cli()"
    done = subprocess.run(
        [sys.executable, "-c", command, str(root), "--json"], capture_output=True, text=True
    )
    issues = json.loads(done.stdout)["issues"]["issues"]
    assert not [issue for issue in issues if issue["severity"] == "error"]
