"""Where the command for experiments finds them, and what is installed with the package."""

import zipfile
from pathlib import Path

import pytest

from plantigrade.commands import experiment, main
from plantigrade.errors import CheckoutNeeded

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """As if the package were installed in a folder of libraries, and called from an empty one."""
    monkeypatch.setattr(experiment, "CHECKOUT", tmp_path / "site-packages")
    monkeypatch.chdir(tmp_path)


def test_the_experiments_are_those_of_the_checkout(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert experiment.find_checkout() == ROOT
    assert experiment.Command.__module__ == "experiments.command"


def test_an_installed_package_takes_those_of_the_current_folder(installed, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert experiment.find_checkout() == ROOT


@pytest.mark.parametrize("words", [["gait-table"], ["--help"], ["--all", "--quick"]])
def test_without_a_checkout_one_sentence_says_where_they_are(installed, words, capsys):
    assert main.main(["experiment", *words]) == main.BAD_INPUT
    said = capsys.readouterr()
    assert "run this command in a checkout of" in said.err and not said.out
    assert len(said.err.splitlines()) == 1


def test_without_a_checkout_the_other_commands_are_completed(installed, capsys):
    with pytest.raises(CheckoutNeeded):
        experiment.find_checkout()
    assert main.main(["--print-completion", "bash"]) == main.DONE
    script = capsys.readouterr().out
    assert "simulate" in script and "experiment" not in script


def test_the_wheel_holds_the_package_alone(tmp_path):
    wheel = pytest.importorskip("hatchling.builders.wheel")
    (path,) = wheel.WheelBuilder(str(ROOT)).build(directory=str(tmp_path))
    names = {name.split("/")[0] for name in zipfile.ZipFile(path).namelist()}
    assert {name for name in names if not name.endswith(".dist-info")} == {"plantigrade"}


def test_the_source_distribution_holds_the_experiments():
    sdist = pytest.importorskip("hatchling.builders.sdist")
    files = {f.relative_path for f in sdist.SdistBuilder(str(ROOT)).recurse_included_files()}
    assert "experiments/command.py" in files and "plantigrade/__init__.py" in files
