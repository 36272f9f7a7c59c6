"""Pages as PDF: printed beside them where there is a browser, refused in words where not."""

import os

import pytest

from plantigrade.commands.main import main
from plantigrade.pages.pdf import VARIABLE, find_browser
from plantigrade.record import Run
from tests.pages.runs import fitted
from tests.pages.walker import walk, walker


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of two seconds of walking."""
    run = fitted(walk(walker(), duration=2.0))
    return run.save(tmp_path_factory.mktemp("runs") / "walk").folder


def test_a_report_is_printed_next_to_its_page(folder, browser, capsys):
    assert main(["report", str(folder), "--pdf"]) == 0
    assert f"pdf            {folder / 'report.pdf'}" in capsys.readouterr().out
    pdf = (folder / "report.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-") and b"/Type /Page" in pdf and len(pdf) > 20_000
    assert "report.pdf" in Run.load(folder).files


def test_without_a_browser_the_command_says_so_before_any_work(folder, capsys, monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setenv("PATH", os.devnull)
    monkeypatch.setattr("plantigrade.pages.pdf.PLACES", ())
    assert find_browser() is None
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert main(["report", str(folder), "--pdf"]) == 2
    assert (
        "none is installed here: install one, name it with the environment variable CHROMIUM"
        in capsys.readouterr().err
    )
    assert before == {path: path.stat().st_mtime_ns for path in folder.iterdir()}


def test_a_browser_that_prints_nothing_is_named(folder, capsys, monkeypatch):
    monkeypatch.setenv(VARIABLE, "true")
    assert main(["report", str(folder), "--pdf"]) == 2
    assert "true did not print" in capsys.readouterr().err
