"""``plantigrade reproduce`` as a user calls it: one gait, a study, and what it refuses."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.errors import ParameterError
from plantigrade.workflows.fit_many import recordings
from tests.browser import moved
from tests.textbook import walk_file

FILES = {
    "model.xml", "motion.npz", "motion.mot", "metrics.json", "report.html", "viewer.html",
    "curves.csv",
}  # fmt: skip


def plantigrade(*words, cwd: Path) -> subprocess.CompletedProcess:
    """Run the command line in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "plantigrade", *map(str, words)],
        capture_output=True, text=True, cwd=cwd,
    )  # fmt: skip


@pytest.fixture(scope="module")
def one(data, tmp_path_factory):
    """One walk, reproduced: its process and the folder it was called in."""
    folder = tmp_path_factory.mktemp("one")
    walk = data / "cmu_asfamc/16_21.amc"
    return plantigrade("reproduce", walk, "--no-dynamics", "--json", cwd=folder), folder


@pytest.fixture(scope="module")
def study(data, tmp_path_factory):
    """Two people who walk and one who jumps, in one call."""
    folder = tmp_path_factory.mktemp("study")
    names = ("16_21.amc", "02_04.amc", "07_12.amc")
    files = [data / "cmu_asfamc" / name for name in names]
    done = plantigrade("reproduce", *files, "--no-dynamics", "--jobs", "2", "--json", cwd=folder)
    return done, folder


def test_one_gait_has_its_folder(one):
    done, folder = one
    assert done.returncode == 0, done.stderr
    run = folder / "runs" / "reproduce-16_21"
    assert {p.name for p in run.iterdir()} == FILES
    metrics = json.loads(done.stdout)
    assert metrics == json.loads((run / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["settings"]["tasks"] == "default"
    assert set(metrics["source_files"]) == {"16_21.amc", "16.asf"}
    assert metrics["com_error_max_mm"] < 5
    assert "reproducing" in done.stderr and str(run.relative_to(folder)) in done.stderr


def test_plantigrade_report_writes_the_same_pages(one):
    run = one[1] / "runs" / "reproduce-16_21"
    before = {p: (run / p).read_text(encoding="utf-8") for p in ("report.html", "viewer.html")}
    assert cli.main(["report", str(run)]) == 0
    for page, text in before.items():
        assert (run / page).read_text(encoding="utf-8") == text, page


@pytest.mark.slow
def test_its_pages_in_a_browser(browser, one):
    run = one[1] / "runs" / "reproduce-16_21"
    browser.open(
        run / "viewer.html",
        ready="document.body.dataset.ready === '1' && document.body.dataset.time",
    )
    browser.evaluate("plantigrade.pause(); plantigrade.seek(0.5)")
    both = browser.screenshot()[60:740, :900]
    browser.evaluate("document.querySelector('input[name=ref]').click()")
    alone = browser.screenshot()[60:740, :900]
    assert moved(both, alone) > 0.002, "the recorded body is not to be seen"
    browser.open(run / "report.html")
    text = browser.evaluate("document.body.innerText")
    assert "Ranges of motion" in text and "Residual of each level" in text
    assert browser.evaluate("document.querySelectorAll('svg.plot').length") > 25
    assert browser.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    assert browser.errors == [] and browser.requests == []


@pytest.mark.slow
def test_several_make_a_study_and_one_that_jumps_does_not_stop_them(study):
    done, folder = study
    assert done.returncode == 3, done.stderr
    (found,) = (folder / "runs").iterdir()
    assert found.name == "reproduce-study-16_21-and-2-more"
    gaits = [path for path in found.iterdir() if path.is_dir()]
    assert {path.name for path in gaits} == {"16_21", "07_12"}
    for path in gaits:
        assert {p.name for p in path.iterdir()} == FILES
    assert {"study.html", "study.csv", "batch.csv"} <= {p.name for p in found.iterdir()}
    metrics = json.loads(done.stdout)
    assert metrics["status"] == "1 of 3 recordings failed"
    assert metrics["counted_count"] == metrics["gaits_count"] == 2
    assert "02_04.amc: it shows no walking" in done.stderr


@pytest.mark.slow
def test_the_table_of_a_study_is_the_mean_of_its_gaits(study):
    folder = study[1] / "runs" / "reproduce-study-16_21-and-2-more"
    each = [json.loads((folder / name / "metrics.json").read_text()) for name in ("16_21", "07_12")]
    with (folder / "study.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 12
    for row in rows:
        stem, side = row["coordinate"][:-2], row["coordinate"][-1]
        ours = [m[f"{stem}_rom_{side}_deg"] for m in each]
        theirs = [m[f"{stem}_rom_reference_{side}_deg"] for m in each]
        assert float(row["simulated_deg"]) == pytest.approx(np.mean(ours), rel=1e-4)
        assert float(row["reference_sd_deg"]) == pytest.approx(np.std(theirs, ddof=1), rel=1e-4)
        assert float(row["difference_deg"]) == pytest.approx(
            np.mean(np.subtract(ours, theirs)), rel=1e-3, abs=1e-4
        )


@pytest.mark.slow
def test_a_folder_is_searched_and_files_not_named_are_no_failure(data, tmp_path, monkeypatch):
    walks = tmp_path / "walks" / "deep"
    walks.mkdir(parents=True)
    for name in ("16_21.amc", "16.asf"):
        (walks / name).write_bytes((data / "cmu_asfamc" / name).read_bytes())
    (walks / "notes.md").write_text("a walk")
    (walks / "broken.trc").write_text("PathFileType\t4\t(X/Y/Z)\tbroken.trc\nno markers here\n")
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "all" / "mine"
    words = ["reproduce", "walks", "--no-dynamics", "--quiet", "--out", str(out)]
    assert cli.main(words) == 0
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["gaits_count"] == 1
    assert metrics["left_out_count"] == 1 and "broken.trc" in (out / "batch.csv").read_text("utf-8")
    assert (out / "16_21" / "report.html").exists()
    assert "16_21/report.html" in (out / "study.html").read_text("utf-8")


def test_which_files_of_a_folder_are_recordings(data, tmp_path):
    run = tmp_path / "run"
    run.mkdir()
    (run / "metrics.json").write_text("{}")
    (run / "motion.mot").write_text("x\nendheader\n")
    walk = tmp_path / "walk.mot"
    walk.write_bytes((data / "opensim/gait2392_subject01/normal_gait.mot").read_bytes())
    (tmp_path / "list.txt").write_text(f"# two\n{tmp_path}\n\nother.c3d\n")
    listed = recordings([], tmp_path / "list.txt")
    for given in (recordings([tmp_path, Path("other.c3d")]), listed):
        assert given.files == (walk, Path("other.c3d")) and given.named == {Path("other.c3d")}
    assert listed.title == "list" and recordings([tmp_path]).title == tmp_path.name
    assert recordings([f"{tmp_path}/w*.mot", "a.c3d", "b.c3d"]).title == "walk-and-2-more"
    with pytest.raises(ParameterError, match="holds no recording"):
        recordings([run])


@pytest.mark.parametrize(
    ("file", "sentence"),
    [
        ("cmu_asfamc/02_04.amc", "02_04.amc: it shows no walking"),
        ("cmu_bvh/13_11.bvh", "it shows no walking"),
        ("opensim/opencap_squat/squats1_videoAndMocap.mot", "it shows no walking"),
        ("deepmimic/humanoid3d_run.txt", "running"),
        ("cmu_asfamc/03_01.amc", "not level"),
        ("opensim/gait2392_subject01/subject01_walk1_grf.mot", "no motion to fit"),
    ],
)
def test_a_recording_without_walking_is_one_sentence(
    data, tmp_path, monkeypatch, capsys, file, sentence
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["reproduce", str(data / file), "--quiet"]) == 2
    out, err = capsys.readouterr()
    (line,) = err.strip().splitlines()
    assert sentence in line and not out
    assert not (tmp_path / "runs").exists()


def test_an_existing_folder_is_refused_before_any_work(tmp_path, monkeypatch, capsys):
    from plantigrade.workflows import fit as fitting

    monkeypatch.setattr(fitting, "load", lambda *_: pytest.fail("work was done"))
    monkeypatch.chdir(tmp_path)
    for name in ("walk.c3d", "other.c3d", "a.c3d", "b.c3d"):
        (tmp_path / name).touch()
    for name in ("reproduce-walk", "reproduce-study-a-and-1-more",
                 "reproduce-study-other-and-1-more"):  # fmt: skip
        (tmp_path / "runs" / name).mkdir(parents=True)
        (tmp_path / "runs" / name / "metrics.json").write_text("{}")
    place = "runs/reproduce-walk"
    assert cli.main(["reproduce", "walk.c3d", "--out", place]) == 2
    assert cli.main(["reproduce", "other.c3d", "walk.c3d", "--out", place]) == 2
    assert capsys.readouterr().err.count("add --overwrite") == 2
    # without --out they would be numbered, but not where they are to be replaced
    assert cli.main(["reproduce", "walk.c3d", "--overwrite"]) == 2
    assert cli.main(["reproduce", "a.c3d", "b.c3d", "--overwrite"]) == 2
    assert cli.main(["reproduce", "other.c3d", "walk.c3d", "--overwrite"]) == 2
    assert capsys.readouterr().err.count("does not mark a run") == 3


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["walk.c3d", "--jobs", "0"], "jobs must be 1, 2"),
        (["nowhere.c3d"], "nowhere.c3d"),
        (["walk.c3d", "walk.c3d"], "twice"),
    ],
)
def test_bad_words_are_one_sentence(tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "walk.c3d").touch()
    assert cli.main(["reproduce", *words]) == 2
    err = capsys.readouterr().err
    assert sentence in err and "Traceback" not in err


@pytest.mark.slow
def test_a_study_is_numbered_where_its_name_is_taken(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("anna", "beth")):
        walk_file(Path(f"{name}.c3d"), seed=seed, cycles=2)
    (tmp_path / "runs" / "reproduce-study-anna-and-1-more").mkdir(parents=True)
    (tmp_path / "runs" / "reproduce-study-anna-and-1-more" / "notes").write_text("mine")
    words = ["reproduce", "anna.c3d", "beth.c3d", "--no-dynamics", "--quiet"]
    assert cli.main(words) == 0
    folder = Path("runs/reproduce-study-anna-and-1-more-2")
    assert f"{folder}: 2 of 2 recordings reproduced" in capsys.readouterr().out
    page = (folder / "study.html").read_text("utf-8")
    assert "anna/report.html" in page and "beth/report.html" in page
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["seconds"]["cycle"] > 0 and metrics["folders"] == ["anna", "beth"]
