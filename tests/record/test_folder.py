"""A folder of results is whole or not there, and nothing foreign is ever deleted."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from plantigrade.commands.options import RunOptions
from plantigrade.errors import FileError, RunExists
from plantigrade.record import folder as run_folder
from plantigrade.record.folder import (
    refuse_existing,
    refuse_unwritable,
    replace_files,
    write_folder,
)
from plantigrade.record.metrics import read_metrics


def write(out, **more):
    return write_folder(out, **{"metrics": {"speed_m_s": 1.2}, "files": {"page.html": "x"}, **more})


def test_round_trip(tmp_path):
    out = tmp_path / "deep" / "run"
    metrics = {
        "rms_mm": np.float64(3.5),
        "never": float("nan"),
        "huge": [float("inf"), 1],
        "counts": np.arange(3),
        "settings": {"feet": "rigid", "out": out},
        "seed": np.int64(4),
    }

    def more(folder):
        (folder / "sub").mkdir()
        (folder / "sub" / "table.csv").write_text("1")

    assert write(out, metrics=metrics, files={"report.html": "<p>ä", "b": b"1"}, more=more) == out
    read = read_metrics(out)
    assert read["never"] is None and read["huge"] == [None, 1] and read["counts"] == [0, 1, 2]
    assert read["rms_mm"] == 3.5 and read["settings"]["out"] == str(out) and read["seed"] == 4
    assert read["format"] == run_folder.FORMAT
    assert read["files"] == ["b", "report.html", "sub/table.csv"]
    assert (out / "report.html").read_text(encoding="utf-8") == "<p>ä"
    assert os.listdir(tmp_path / "deep") == ["run"]
    json.loads((out / "metrics.json").read_text(), parse_constant=pytest.fail)


def test_existing_is_refused_or_replaced(tmp_path):
    out = write(tmp_path / "run", files={"old.txt": "x"})
    with pytest.raises(RunExists, match="--overwrite"):
        write(out)
    assert (out / "old.txt").exists()
    (out / ".DS_Store").write_bytes(b"")  # a file browser's, nobody misses it
    write(out, metrics={"speed_m_s": 2.0}, overwrite=True)
    assert not (out / "old.txt").exists()
    assert read_metrics(out)["speed_m_s"] == 2.0
    assert os.listdir(tmp_path) == ["run"]
    (tmp_path / "empty").mkdir()
    assert read_metrics(write(tmp_path / "empty", overwrite=True))


def test_a_folder_that_is_not_ours_is_never_replaced(tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    (home / "thesis.txt").write_text("x")
    with pytest.raises(RunExists, match="not a run folder"):
        write(home, overwrite=True)
    with pytest.raises(RunExists, match="not a folder"):
        write(home / "thesis.txt", overwrite=True)
    (tmp_path / "link").symlink_to(home)
    with pytest.raises(RunExists):
        write(tmp_path / "link", overwrite=True)
    for text in (
        "{}",
        '{"status": "ok"}',
        '{"format": 2}',
        "[1]",
        "{",
        '{"format": 2, "files": 1}',
    ):
        (home / "metrics.json").write_text(text)  # some other program's
        with pytest.raises(RunExists, match="will not be replaced.*--out"):
            write(home, overwrite=True)
    assert (home / "thesis.txt").read_text() == "x"


@pytest.mark.parametrize("name", ["thesis.txt", "data/walk.c3d", "data/deeper/"])
def test_a_run_with_foreign_files_is_never_replaced(tmp_path, name):
    out = write(tmp_path / "run")
    (out / name).parent.mkdir(exist_ok=True)
    if name.endswith("/"):
        (out / name).mkdir()
    else:
        (out / name).write_text("x")
    with pytest.raises(RunExists, match=f"also holds {name.rstrip('/')}"):
        write(out, overwrite=True)
    assert (out / name).exists()


def test_replacing_a_run_touches_nothing_outside(tmp_path):
    """Whatever metrics.json lists: links are removed, not followed; other paths not looked at."""
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "thesis.txt").write_text("x")
    out = write(tmp_path / "run")
    (out / "page.html").unlink()
    (out / "page.html").symlink_to(kept / "thesis.txt")
    (out / "folder").symlink_to(kept)
    with pytest.raises(RunExists, match="also holds folder"):
        write(out, overwrite=True)
    names = ["page.html", "folder", "../kept/thesis.txt", str(kept / "thesis.txt"), "a" * 9999]
    listed = {**read_metrics(out), "files": [*names, *map(str, range(100_000)), {"a": []}]}
    (out / "metrics.json").write_text(json.dumps(listed))
    write(out, overwrite=True)
    assert sorted(os.listdir(out)) == ["metrics.json", "page.html"]
    assert not (out / "page.html").is_symlink()
    assert [p.name for p in kept.iterdir()] == ["thesis.txt"]


@pytest.mark.parametrize("special", ["fifo", "metrics.json"])
def test_a_folder_with_a_pipe_is_never_replaced(tmp_path, special):
    """And never waited for."""
    out = write(tmp_path / "run")
    (out / special).unlink(missing_ok=True)
    os.mkfifo(out / special)
    with pytest.raises(RunExists):
        write(out, overwrite=True)


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("overwrite", [False, True])
def test_interrupted_writing_leaves_nothing(tmp_path, fault, overwrite):
    out = tmp_path / "run"
    if overwrite:
        write(out)

    def fail(folder):
        (folder / "half.npz").write_bytes(b"1")
        raise fault

    with pytest.raises(FileError if isinstance(fault, OSError) else KeyboardInterrupt):
        write(out, overwrite=overwrite, metrics={"speed_m_s": 9.0}, more=fail)
    assert os.listdir(tmp_path) == (["run"] if overwrite else [])
    if overwrite:
        assert read_metrics(out)["speed_m_s"] == 1.2


def test_a_full_disk_names_the_file(tmp_path, monkeypatch):
    from plantigrade.io.writing import not_written

    full = OSError(28, "No space left on device")

    def fill(folder):
        raise not_written(folder / "motion.npz", full)

    with pytest.raises(FileError, match=r"run/motion.npz: .*No space left") as caught:
        write(tmp_path / "run", more=fill)
    assert caught.value.path == tmp_path / "run" / "motion.npz"

    def refuse(self, content):
        raise full

    monkeypatch.setattr(run_folder.Path, "write_bytes", refuse)
    with pytest.raises(FileError, match=r"run.page\.html: cannot be written .*No space left"):
        write(tmp_path / "run")


def test_failed_rename_brings_the_old_one_back(tmp_path, monkeypatch):
    out = write(tmp_path / "run")
    rename = run_folder.Path.rename

    def fail(self, target):
        if self.name.endswith(".part"):
            raise OSError(5, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(run_folder.Path, "rename", fail)
    with pytest.raises(FileError, match="Input/output error"):
        write(out, overwrite=True, metrics={"speed_m_s": 9.0})
    assert read_metrics(out)["speed_m_s"] == 1.2
    assert os.listdir(tmp_path) == ["run"]


def test_unwritable_place(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileError, match=r"cannot be written.*--out"):
        write(tmp_path / "file" / "run")
    with pytest.raises(FileError, match=r"cannot be written .*file is no folder"):
        refuse_existing(tmp_path / "file" / "run", overwrite=True)
    for name in ("../up.html", "metrics.json", ".hidden", "a/b"):
        with pytest.raises(FileError, match="not allowed as the name"):
            write(tmp_path / "run", files={name: "x"})


def test_a_place_that_may_not_be_written_is_refused_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr("os.access", lambda place, how: place != tmp_path)
    with pytest.raises(FileError, match=r"cannot be written \(no permission to write to .*--out"):
        refuse_unwritable(tmp_path / "runs" / "new")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match="no permission to write"):
        RunOptions().refuse_existing("fit-walk")
    (tmp_path / "mine").mkdir()
    refuse_unwritable(tmp_path / "mine" / "new")


def test_read_says_what_is_wrong(tmp_path):
    with pytest.raises(FileError, match="no such folder"):
        read_metrics(tmp_path / "gone")
    with pytest.raises(FileError, match="not a run folder: metrics.json is missing"):
        read_metrics(tmp_path)
    out = write(tmp_path / "run")
    with pytest.raises(FileError, match="is not a folder"):
        read_metrics(out / "metrics.json")
    for text, match in (
        ('{"a": 1,\n"b": }', r"metrics.json: line 2: is not JSON"),
        ("[1]", "no object"),
        ('{"a": ' + "9" * 5000 + "}", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
    ):
        (out / "metrics.json").write_text(text)
        with pytest.raises(FileError, match=match):
            read_metrics(out)


def test_a_page_added_later_belongs_to_the_run(tmp_path):
    out = write(tmp_path / "run")
    assert replace_files(out, {"page.html": "new", "viewer.html": "y"}) == [
        out / "page.html",
        out / "viewer.html",
    ]
    assert read_metrics(out) == {
        "format": run_folder.FORMAT,
        "speed_m_s": 1.2,
        "files": ["page.html", "viewer.html"],
    }
    write(out, overwrite=True)
    assert sorted(os.listdir(out)) == ["metrics.json", "page.html"]


def numbered(out, **options):
    return write_folder(out, metrics={"status": "ok"}, files={}, numbered=True, **options)


def test_a_taken_name_is_numbered(tmp_path):
    out = tmp_path / "runs" / "fit-walk"
    assert [numbered(out).name for _ in range(3)] == ["fit-walk", "fit-walk-2", "fit-walk-3"]
    (tmp_path / "runs" / "fit-run").mkdir()  # not ours, and empty: taken all the same
    (tmp_path / "runs" / "fit-run-2").symlink_to("nowhere")
    assert numbered(tmp_path / "runs" / "fit-run").name == "fit-run-3"
    assert (tmp_path / "runs" / "fit-run-2").is_symlink()


def test_two_folders_keep_in_step(tmp_path):
    out = tmp_path / "demo"
    (tmp_path / "demo-2-reproduced").mkdir()
    assert numbered(out, beside="-reproduced").name == "demo"
    assert numbered(out, beside="-reproduced").name == "demo-3"


def test_processes_at_once_do_not_collide(tmp_path):
    import subprocess
    import sys

    program = (
        "import sys; from plantigrade.record.folder import write_folder\n"
        "print('ready', flush=True); sys.stdin.readline()\n"
        "for k in range(8):\n"
        "    files = {'a.txt': sys.argv[1]}\n"
        "    out = write_folder('r', metrics={'k': k}, files=files, numbered=True)\n"
        "    assert (out / 'a.txt').read_text() == sys.argv[1], out\n"
    )
    started = [
        subprocess.Popen(
            [sys.executable, "-c", program, str(i)],
            cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        for i in range(3)
    ]  # fmt: skip
    for process in started:
        assert process.stdout.readline() == "ready\n"
    for process in started:
        process.stdin.write("go\n")
        process.stdin.flush()
    assert [process.wait() for process in started] == [0, 0, 0]
    names = {f"r-{n}" for n in range(2, 25)} | {"r"}
    assert {path.name for path in tmp_path.iterdir()} == names
    written = [(path / "a.txt").read_text() for path in tmp_path.iterdir()]
    assert sorted(written) == sorted("012" * 8)


def test_a_name_that_is_taken_at_the_last_moment_is_numbered(tmp_path, monkeypatch):
    from pathlib import Path

    rename, out = Path.rename, tmp_path / "r"

    def late(self, target):
        if Path(target) == out and not out.exists():
            (out / "somebody").mkdir(parents=True)
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", late)
    assert numbered(out).name == "r-2"


def test_what_a_killed_process_left_is_removed_by_the_next(tmp_path):
    """Parts of processes that live, of other machines, and foreign folders stay."""
    script = (
        "import os, signal\n"
        "from pathlib import Path\n"
        "from plantigrade.record.folder import write_folder\n"
        "def more(folder):\n"
        "    (folder / 'half').write_text('x')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        f"write_folder(Path({str(tmp_path / 'run')!r}), metrics={{}}, files={{}}, more=more)\n"
    )
    subprocess.run([sys.executable, "-c", script], check=False)
    (left,) = tmp_path.iterdir()
    assert left.name.endswith(".part") and (left / "half").exists()
    others = [
        tmp_path / ".mine.part",
        tmp_path / f".run-{'0' * 8}-999999-abc.part",
        tmp_path / f"{left.name.rsplit('-', 2)[0]}-{os.getpid()}-abc.part",
    ]
    for other in others:
        other.mkdir()
    write(tmp_path / "run")
    assert sorted(tmp_path.iterdir()) == sorted([*others, tmp_path / "run"])
