"""Many fits: taken up by content, kept as asked, the same table wherever they are computed."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import plantigrade as pg
from plantigrade.analyze.norms_of_runs import run_folders
from plantigrade.commands import main as cli
from plantigrade.errors import FileError, ParameterError, RunExists
from tests.browser import wait_for
from tests.workflows.test_batch import PUSHES, SMALL
from tests.workflows.test_one_subject import trial

HOW = {"sex": "female", "joints": "42", "feet": "rigid"}


@pytest.fixture(scope="module")
def walks(tmp_path_factory):
    """Two trials of one subject and one of another, in a folder."""
    folder = tmp_path_factory.mktemp("walks")
    for path, seed in (("p1/walk1.trc", 1), ("p1/walk2.trc", 2), ("p2/walk1.trc", 3)):
        (folder / path).parent.mkdir(exist_ok=True)
        trial(folder / path, seed=seed, n=50)
    return folder


@pytest.fixture(scope="module")
def fitted(walks, tmp_path_factory):
    """The folder in which they were fitted, of recordings that have moved since."""
    place = tmp_path_factory.mktemp("batch")
    shutil.copytree(walks, place / "data")
    assert pg.fit_many(place / "data", out=place / "out", keep="figures", **HOW).status == "ok"
    shutil.rmtree(place / "data")
    return place / "out"


@pytest.fixture
def done(walks, fitted, tmp_path):
    """Copies of the recordings and of the folder in which they were fitted."""
    shutil.copytree(walks, tmp_path / "data")
    shutil.copytree(fitted, tmp_path / "out")
    return tmp_path / "data", tmp_path / "out"


def table(out: Path) -> list[dict[str, str]]:
    """Return the table without what takes another time each time."""
    with (out / "batch.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    return [{k: v for k, v in row.items() if k != "seconds"} for row in rows]


def said_of(data, out, **options) -> list[str]:
    """Return what is said while recordings are fitted."""
    said: list[str] = []
    pg.fit_many(data, out=out, keep="figures", say=said.append, **{**HOW, **options}).finish()
    return said


def test_trials_of_one_subject_share_a_body_and_each_is_a_row(done):
    rows = table(done[1])
    assert [row["name"] for row in rows] == ["p1-walk1-trc", "walk2", "p2-walk1-trc"]
    assert rows[0]["length_thigh_m"] == rows[1]["length_thigh_m"] != rows[2]["length_thigh_m"]
    assert all(row["status"] == "ok" and row["setting_joints"] == "42" for row in rows)


def test_what_has_the_same_content_is_not_done_again(done):
    data, out = done
    before = table(out)
    assert said_of(data, out) == ["3 of 3 were there"]
    data.rename(data.with_name("moved"))  # another place, the same content
    assert said_of(data.with_name("moved"), out) == ["3 of 3 were there"]
    assert table(out) == before


def test_another_trial_of_a_subject_changes_its_fits_and_no_other(done):
    data, out = done
    trial(data / "p1" / "walk3.trc", seed=4, n=50)
    said = said_of(data, out)
    assert len(said) == 4 and said[0] == "1 of 4 were there"
    assert [row["name"] for row in table(out)] == ["p1-walk1-trc", "walk2", "walk3", "p2-walk1-trc"]


def test_a_failure_is_tried_again_and_others_are_kept(done):
    data, out = done
    broken = data / "p3.trc"
    broken.write_text("PathFileType\t4\t(X/Y/Z)\tx.trc\nnothing\n")
    batch = pg.fit_many([data, broken], out=out, keep="figures", **HOW)
    assert batch.status == "1 of 4 recordings failed"
    assert (out / "failed.txt").read_text("utf-8") == f"{broken}\n"
    trial(broken, seed=5, n=50)
    assert said_of([data, broken], out)[0] == "3 of 4 were there"
    assert not (out / "failed.txt").exists()


def test_other_settings_are_another_batch(done):
    data, out = done
    with pytest.raises(RunExists, match=r"height None, not 1.7"):
        pg.fit_many(data, out=out, height=1.7, **HOW)
    with pytest.raises(ParameterError, match="name a folder with out"):
        pg.fit_many(data, keep="runs", **HOW)
    with pytest.raises(ParameterError, match="collect has no effect with keep figures"):
        pg.fit_many(data, out=out.with_name("new"), keep="figures", collect=True, **HOW)
    assert not out.with_name("new").exists()


def test_results_come_as_they_arrive_and_load(walks, tmp_path):
    batch = pg.fit_many(walks / "p1", out=tmp_path / "b", keep="runs", collect=True, **HOW)
    first = next(iter(batch))
    assert first.load().record.motion.n_frames == 50
    assert first.metrics["status"] == first.status == "ok"
    assert {p.name for p in (tmp_path / "b" / first.name).iterdir()} == {
        "model.xml", "motion.npz", "motion.mot", "metrics.json"
    }  # fmt: skip
    assert [one.name for one in batch.members] == ["walk1", "walk2"]
    assert [path.name for path in run_folders(tmp_path / "b")] == ["walk1", "walk2"]
    with pytest.raises(FileError, match="is of a batch — name the folder of a single run"):
        pg.load_run(tmp_path / "b")


def test_a_batch_without_workers_says_so(walks):
    with pytest.warns(UserWarning, match="made but not computed"):
        del_me = pg.fit_many(walks, **HOW)
        del del_me


def test_an_interrupted_batch_is_no_batch_without_workers(walks, tmp_path, recwarn):
    def interrupt(_: str) -> None:
        raise KeyboardInterrupt

    batch = pg.fit_many(walks, out=tmp_path / "out", keep="figures", say=interrupt, **HOW)
    with pytest.raises(KeyboardInterrupt):
        batch.finish()
    del batch
    assert not [w for w in recwarn if "not computed" in str(w.message)]
    assert said_of(walks, tmp_path / "out")[0] == "1 of 3 were there", "its first result is kept"


def test_a_list_a_pattern_and_what_is_left_out(walks, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    shutil.copy(walks / "p1" / "walk1.trc", "in/walk.trc")
    (tmp_path / "in" / "walk_grf.mot").write_text(
        "x\nversion=1\nnRows=2\nnColumns=10\ninDegrees=no\nendheader\ntime\t"
        + "\t".join(f"ground_force_{k}{a}" for k in ("v", "p") for a in "xyz")
        + "\tground_torque_x\tground_torque_y\tground_torque_z\n"
        + "".join(f"{t}" + "\t0" * 9 + "\n" for t in (0.0, 0.01))
    )
    Path("list.txt").write_text("# mine\nin/*\n")
    words = ["--joints", "42", "--feet", "rigid", "--keep", "figures", "--quiet"]
    assert cli.main(["fit", "--list", "list.txt", *words]) == 0
    metrics = json.loads(Path("runs/fit-batch-list/metrics.json").read_text())
    assert metrics["recordings_count"] == 1 and metrics["left_out_count"] == 1
    assert cli.main(["fit", "in", "in/walk_grf.mot", *words, "--out", "named"]) == 3
    assert "no motion to fit" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_run_that_was_killed_loses_only_what_was_in_work(tmp_path):
    words = [sys.executable, "-m", "plantigrade", "simulate", "--duration", "0.3", "--joints", "42"]
    words += ["--feet", "rigid", "--seeds", "8", "--start-noise", "0.01", "--jobs", "2"]
    words += ["--out", "out"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.DEVNULL)
    journal = tmp_path / "out" / "items.jsonl"
    count = wait_for(lambda: journal.exists() and journal.read_bytes().count(b"\n") > 3)
    process.kill()
    process.wait()
    assert count
    whole = journal.read_bytes().count(b"\n") - 1
    again = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    assert f"{whole} of 8 were there" in again.stderr
    alone = pg.simulate_many(
        duration=0.3, joints="42", feet="rigid", seeds=8, start_noise=0.01, out=tmp_path / "alone"
    )
    assert alone.status == "ok" and table(tmp_path / "alone") == table(tmp_path / "out")


class Deadly:
    """Hold on; the first time in a folder, end the process as the kernel would."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __call__(self, state):
        """Return nothing to be done."""
        mark = self.folder / "killed"
        if not mark.exists():
            mark.write_text("x")
            os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("backend", "collect"), [("loky", False), ("loky", True), ("ray", True), ("dask", False)]
)
def test_everywhere_the_table_is_the_same_also_where_a_worker_is_killed(tmp_path, backend, collect):
    if backend != "loky":
        pytest.importorskip("distributed" if backend == "dask" else backend)
    vary = {"push": PUSHES, "controller": ["posture", Deadly(tmp_path)]}
    (tmp_path / "killed").write_text("not in the first batch")
    here, there = tmp_path / "here", tmp_path / "there"
    assert pg.simulate_many(vary=vary, out=here, **SMALL).status == "ok"
    (tmp_path / "killed").unlink()
    batch = pg.simulate_many(
        vary=vary, out=there, jobs=2, backend=backend, collect=collect, **SMALL
    )
    assert batch.status == "ok" and (tmp_path / "killed").exists()
    assert table(there) == table(here)
    for one in batch.members:
        assert {p.name for p in (there / one.name).iterdir()} == {
            p.name for p in (here / one.name).iterdir()
        }


@pytest.mark.slow
def test_a_dask_cluster_of_other_processes(tmp_path):
    """Scheduler and workers are started by hand, as on a cluster; one worker is killed."""
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    started = [
        subprocess.Popen(
            [*dask, "--scheduler-file", file, "--port", "0", "--no-dashboard"],
            stderr=subprocess.DEVNULL,
        )
    ]
    try:
        address = wait_for(lambda: json.loads(file.read_text())["address"])
        for _ in range(2):
            worker = [sys.executable, "-m", "distributed.cli.dask_worker", address]
            started.append(
                subprocess.Popen(
                    [*worker, "--nthreads", "1", "--no-dashboard", "--local-directory", tmp_path],
                    stderr=subprocess.DEVNULL,
                )
            )
        vary = {"push": PUSHES, "controller": ["posture", Deadly(tmp_path)]}
        out = tmp_path / "out"
        batch = pg.simulate_many(
            vary=vary, out=out, jobs=2, backend="dask", address=address, collect=True, **SMALL
        )
        assert batch.status == "ok" and (tmp_path / "killed").exists()
        assert len(table(out)) == 4
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()
