r"""Names of files that are no UTF-8, command a terminal, or are as long as can be."""

import json
import os
import subprocess
import sys

import pytest

from plantigrade.commands.main import main
from plantigrade.printable import UNSAFE, printable, short_name
from plantigrade.record import Run
from plantigrade.record.folder import write_folder
from plantigrade.record.metrics import metrics_json, read_metrics
from tests.textbook import walk_file

NAME = "\x1b]0;t\x07 <blink>\"'\n\u202e\x9b2J\udcff-é.trc"
"""Sets a title, turns the line around, clears the screen, ends a line, is no UTF-8."""


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A recording under a nasty name."""
    path = walk_file(tmp_path_factory.mktemp("names") / "walk.trc", speed=1.2, cycles=1)
    return path.rename(path.with_name(NAME))


def test_a_fit_is_kept_and_printed_without_commands(walk, tmp_path, monkeypatch, capsys):
    """Folder, pages and figures are whole; nothing raw reaches the terminal."""
    monkeypatch.chdir(tmp_path)
    assert main(["fit", str(walk), "--json"]) == 0
    out, err = capsys.readouterr()
    assert not UNSAFE.search(out) and not UNSAFE.search(err)
    printed = json.loads(out)
    (source,) = printed["source_files"]
    assert source.endswith(NAME)
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name == f"fit-{walk.stem}"
    assert read_metrics(folder)["source_files"] == printed["source_files"]
    assert Run.load(folder).provenance.source_files == printed["source_files"]
    for page in ("report.html", "viewer.html"):
        text = (folder / page).read_bytes().decode("utf-8")
        assert "<blink>" not in text and (r"\xff" in text or r"\udcff" in text)
    assert main(["report", str(folder)]) == 0
    assert main(["data", str(walk.parent)]) == 0
    out, err = capsys.readouterr()
    assert not UNSAFE.search(out + err)
    assert r"\x1b]0;t\x07 <blink>" in out and r"\n\u202e\x9b2J\xff-é.trc" in out


def test_errors_are_one_line_without_commands(walk, capsys):
    assert main(["fit", str(walk) + "x.trc"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and not UNSAFE.search(err) and "no such file" in err
    assert main(["fit", str(walk), "--quie\x1b[2J\udcff"]) == 2
    assert not UNSAFE.search(capsys.readouterr().err)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_a_listing_in_any_encoding(walk, encoding):
    words = [sys.executable, "-m", "plantigrade", "data", os.fsencode(walk.parent)]
    environment = os.environ | {"PYTHONIOENCODING": encoding, "LC_ALL": "C"}
    done = subprocess.run(words, capture_output=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert b"\x1b" not in done.stdout and b"1 recordings" in done.stdout


@pytest.mark.parametrize("name", ["x" * 255, "é" * 127, "..." + "\udcff" * 250])
def test_names_as_long_as_can_be(tmp_path, name):
    """What is put before and behind a name never makes it too long."""
    for number in range(3):
        out = tmp_path / f"reproduce-{name}"
        made = write_folder(out, metrics={"n": number}, files={}, numbered=True)
        assert read_metrics(made)["n"] == number
    again = write_folder(tmp_path / f"reproduce-{name}", metrics={"n": 9}, files={}, overwrite=True)
    assert read_metrics(again)["n"] == 9 and len(list(tmp_path.iterdir())) == 3


def test_json_is_exact():
    words = {"name": NAME, "all": "".join(map(chr, range(0x2100))) + "\udcff😀"}
    text = metrics_json(words)
    assert json.loads(text) == words and not UNSAFE.search(text)
    assert text.encode("utf-8")


def test_printable():
    assert printable("a\tb\nc é 😀 °") == "a\tb\nc é 😀 °"
    assert printable("a\nb", lines=False) == r"a\nb"
    assert not UNSAFE.search(printable("".join(map(chr, range(0x3000))) + "\ud800"))
    assert short_name("ab") == "ab" and len(short_name("é" * 255).encode()) <= 203
