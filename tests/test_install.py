"""Only synthesis needs CasADi and llvmlite, and it says so where they are missing."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import plantigrade as pg
from plantigrade.commands import main as cli
from plantigrade.errors import MissingExtra
from plantigrade.extras import install_command

ROOT = Path(__file__).resolve().parents[1]
BLOCKED = """
import importlib, sys
for name in ("casadi", "llvmlite"):
    sys.modules[name] = None
from plantigrade.commands.main import COMMANDS
for name in COMMANDS:
    importlib.import_module(f"plantigrade.commands.{name}")
for name in ("fit", "fit_many", "reproduce", "simulate", "live", "motions", "vault", "save"):
    importlib.import_module(f"plantigrade.workflows.{name}")
import plantigrade.learn, plantigrade.exchange.formats
"""


def test_everything_is_imported_without_the_extra_synthesis():
    subprocess.run([sys.executable, "-c", BLOCKED], check=True, cwd=ROOT)


@pytest.mark.parametrize("words", [["synthesize", "walk"], ["vault"]])
def test_a_command_that_needs_it_says_so_in_one_sentence(words, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "casadi", None)
    assert cli.main(words) == cli.BAD_INPUT
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and install_command("synthesis") in said
    assert not list(tmp_path.iterdir())


def test_the_dynamics_say_so_from_python(monkeypatch):
    from plantigrade.dynamics.symbolic import SymbolicHuman

    human = SymbolicHuman(pg.Human.create(1.7, 65.0))
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(MissingExtra, match="casadi is required"):
        human.inverse_dynamics([])


def test_the_extra_holds_both_and_the_core_neither():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    core, extra = project["dependencies"], project["optional-dependencies"]["synthesis"]
    names = ("casadi", "llvmlite")
    assert all(any(line.startswith(name) for line in extra) for name in names)
    assert not any(line.startswith(names) for line in core)
