"""Walks compared whose difference is known, and the page of them."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands.main import main
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.compare import compare_html
from plantigrade.record import Run
from plantigrade.workflows.compare import write
from tests.analyze.test_own_norms import bent
from tests.pages.walker import walk


@pytest.fixture(scope="module")
def record():
    """Six seconds of walking: four strides and more of each foot."""
    return walk(Human.create(1.75, 73.0), duration=6.0)


@pytest.fixture(scope="module")
def folders(record, tmp_path_factory):
    """A walk and the same with knees bent 6° more, saved."""
    place = tmp_path_factory.mktemp("compared")
    for name, each in (("before", record), ("after", bent(record, 6.0))):
        rng = np.random.default_rng(len(name))
        qpos = each.motion.qpos.copy()
        qpos[:, 7:] += np.deg2rad(rng.normal(0, 0.2, size=(1, qpos.shape[1] - 7)))
        moved = replace(each, motion=replace(each.motion, qpos=qpos), references={})
        figures = {"walking_speed_m_s": 1.25, "stance_r_pct": 62.0}
        Run(moved, "fit", figures=figures).save(place / name)
    return place


@pytest.fixture(scope="module")
def found(folders):
    """The two compared."""
    return pg.compare(folders / "before", folders / "after")


def test_a_bent_knee_is_the_difference(found):
    table = found.differences["after"]
    assert table["knee_angle_r"].largest == pytest.approx(6.0, abs=1.0)
    assert table["knee_angle_r"].beyond.all() and table["knee_angle_l"].beyond.all()
    assert table["hip_flexion_r"].rms < 1.0
    figures = found.metrics()["differences"]["after"]
    assert figures["difference_beyond_knee_angle_r_pct"] == 100.0
    assert figures["difference_max_knee_angle_r_deg"] == table["knee_angle_r"].largest
    assert found.metrics()["measures"]["before"]["walking_speed_m_s"] == 1.25


def test_right_and_left_of_one_run(folders):
    found = pg.compare(pg.load_run(folders / "before"))
    assert found.sides and [gait.name for gait in found.gaits] == ["right", "left"]
    assert found.differences["left"]["knee_angle"].rms < 1.5  # the made-up walk is alike


@pytest.fixture(scope="module")
def trials(record, tmp_path_factory):
    """Three trials of one person, whose left knee bends 8° less; each a little different."""
    place, short = tmp_path_factory.mktemp("anna"), walk(record.human, duration=2.0)
    left = 7 + record.human.hinge("knee_angle_l")
    for k in range(3):
        qpos = short.motion.qpos.copy()
        qpos[:, left] *= 1.0 - np.deg2rad(8.0 + 0.4 * k) / np.ptp(qpos[:, left])
        moved = replace(short, motion=replace(short.motion, qpos=qpos), references={})
        Run(moved, "fit", figures={"walking_speed_m_s": 1.2 + 0.01 * k}).save(place / f"walk-{k}")
    return place


def test_trials_of_one_person_are_pooled_and_their_sides_compared(trials):
    found = pg.compare(trials, affected="left")
    unaffected, affected = found.gaits
    assert (unaffected.name, affected.name) == ("unaffected (right)", "affected (left)")
    assert sorted(set(affected.trials["knee_angle"])) == [0, 1, 2] and len(found.runs) == 3
    assert affected.figure("walking_speed_m_s") == pytest.approx(1.21)
    assert affected.figure("cadence_steps_min") is None
    table = {(d.curve, d.figure): d for d in found.figures["affected (left)"]}
    knee = table["knee_angle", "range"]
    assert knee.difference == pytest.approx(-8.4, abs=0.8) and knee.test == "paired trials"
    assert knee.p < 0.001
    assert abs(table["knee_angle", "time of peak"].difference) < 1.5
    page = compare_html(found, {})
    assert (
        "The largest significant difference is in knee flexion: the affected (left) side moves"
        in page
    )
    assert "<h2>Side differences</h2>" in page and "paired t test over the trials" in page
    header, rows = found.figure_rows()
    assert header[:4] == ["gait", "compared_with", "variable", "figure"]
    assert ["affected (left)", "unaffected (right)", "knee_angle", "range"] in [r[:4] for r in rows]


def test_a_folder_of_trials_is_one_gait(trials, folders):
    found = pg.compare(folders / "before", trials)
    assert [gait.name for gait in found.gaits] == ["before", trials.name]
    assert found.metrics()["measures"][trials.name]["walking_speed_m_s"] == pytest.approx(1.21)


def test_trials_of_different_people_are_not_pooled(folders, record):
    tall = walk(Human.create(1.90, 80.0), duration=2.0)
    with pytest.raises(ParameterError, match="must be of one person"):
        pg.compare([folders / "before", Run(tall, "fit", name="tall")])


def test_a_made_motion_does_not_scatter(found):
    before, after = found.runs
    found = pg.compare(before, replace(after, kind="synthesize"))
    assert found.gaits[1].exact and not found.gaits[0].exact
    page = compare_html(found, {})
    assert "all strides of after are equal" in page and "made by synthesize" in page


def test_the_page_names_both_and_draws_every_angle(found):
    page = compare_html(found, {"version": "1"})
    assert not re.search(
        r"\b(nan|None|NaN)\b", re.sub(r"<script>.*?</script>", "", page, flags=re.S)
    )
    for side in ("Right", "Left"):
        assert f"{side} side: angles" in page and f"{side} side: differences" in page
    assert page.count(">Knee flexion</text>") == 2  # one for each side
    assert page.count(">Knee flexion, difference</text>") == 2
    assert "Ground reactions and moments, right" in page
    assert "McGinley" in page and "Pataky" in page


def test_the_command_writes_page_table_and_figures(folders, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["compare", str(folders / "before"), str(folders / "after"), "--json"]
    assert main(words) == 0
    out, err = capsys.readouterr()
    printed = json.loads(out)
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name == "compare-before-after"
    files = {"compare.html", "compare.csv", "differences.csv", "metrics.json"}
    assert {p.name for p in folder.iterdir()} == files
    assert printed["gaits"] == ["before", "after"] and "knee_angle_r" in err
    header, *rows = (folder / "compare.csv").read_text().splitlines()
    assert header.startswith("variable,percent,mean before,sd before,mean after")
    knee = [row.split(",") for row in rows if row.startswith("knee_angle_r,")]
    assert len(knee) == 101
    low, difference, high = (np.array([float(r[k]) for r in knee]) for k in (7, 6, 8))
    assert (low <= difference).all() and (difference <= high).all() and low.min() < low.max()


def test_runs_that_cannot_be_compared_are_refused(folders, record, tmp_path, capsys):
    still = replace(record, motion=replace(record.motion, events=()), references={})
    Run(still, "fit").save(tmp_path / "still")
    before = str(folders / "before")
    for words, sentence in (
        ([], "no run given"),
        ([before, before], "is given twice"),
        ([before, str(tmp_path / "still")], "still shows no complete gait cycle"),
        ([before, str(tmp_path)], "none of the 1 runs in"),
        ([before, str(tmp_path / "nothing")], "there is no such folder"),
    ):
        assert main(["compare", *words]) == 2
        assert sentence in capsys.readouterr().err
    with pytest.raises(ParameterError, match="nothing to compare"):
        pg.compare()


@pytest.mark.slow
def test_own_norms_from_the_command_line(folders, tmp_path, monkeypatch, capsys):
    """`norms` writes a table of runs; `report --norms` compares a run with it from now on."""
    monkeypatch.chdir(tmp_path)
    assert main(["norms", str(folders), "--people", "our two"]) == 0
    assert (tmp_path / "norms.csv").read_text().startswith("# our two\nvariable,percent,mean,sd\n")
    assert main(["norms", str(folders)]) == 2
    assert "norms.csv: exists" in capsys.readouterr().err
    run = pg.load_run(folders / "before")
    saved = run.save(tmp_path / "mine", files={"extra.txt": "kept"})
    assert main(["report", str(saved.folder), "--norms", "norms.csv", "--age", "30"]) == 0
    again = pg.load_run(tmp_path / "mine")
    assert again.figures["norm_population"] == "own norms" and again.figures["age_years"] == 30.0
    assert again.provenance.settings["norms"] == "norms.csv"
    assert "norms.csv" in again.provenance.source_files
    assert (tmp_path / "mine" / "extra.txt").read_text() == "kept"
    page = (tmp_path / "mine" / "report.html").read_text()
    assert "<th>own norms</th>" not in page and "typically developing" not in page
    assert "our two (your own norms)" in page and ">own</text>" in page
    assert main(["report", str(saved.folder), "--age", "9"]) == 0
    assert pg.load_run(saved.folder).figures["norm_population"] == "own norms"
    assert main(["report", str(saved.folder), "--age", "-1"]) == 2


def test_a_comparison_is_written_from_python(found, tmp_path):
    folder = write(found, tmp_path / "both")
    assert (folder / "compare.html").exists()
