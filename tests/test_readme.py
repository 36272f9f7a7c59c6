"""The README is correct: its Python runs, its commands exist."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
CI = ROOT / ".ci" / "run"


def blocks(language: str) -> list[str]:
    """Return the code blocks of the README in ``language``."""
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text("utf-8"), re.DOTALL | re.M)


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """The file ``walk.c3d`` of the examples: a textbook walk."""
    from plantigrade.io import write
    from plantigrade.kinematics.textbook_recording import recorded, textbook_walk
    from plantigrade.models import Human

    path = tmp_path_factory.mktemp("readme") / "walk.c3d"
    write(recorded(textbook_walk(Human.create(1.74, 71.0, "male"), speed=1.25), path), path)
    return path


@pytest.mark.parametrize("source", blocks("python"))
def test_python_block_runs(source, walk, monkeypatch, capsys):
    monkeypatch.chdir(walk.parent)
    exec(compile(source, str(README), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_there_is_a_python_block():
    assert blocks("python")


def test_the_test_command_is_the_one_that_is_checked():
    (command,) = [block.strip() for block in blocks("bash") if "pytest" in block]
    lines = [line.strip() for line in CI.read_text("utf-8").splitlines()]
    assert command in lines


def test_the_main_command_is_tried_from_the_wheel():
    (command,) = [block.strip() for block in blocks("bash") if "plantigrade demo" in block]
    install, job = command.split(" && ")
    assert install == "pip install ."
    assert job in [line.strip() for line in CI.read_text("utf-8").splitlines()]


def test_every_command_exists():
    from plantigrade.commands.main import COMMANDS

    spoken = re.findall(r"\bplantigrade ([a-z]+)\b", "\n".join(blocks("bash")))
    assert spoken and set(spoken) <= set(COMMANDS)


def test_commands_parse():
    from plantigrade.commands.main import parse

    for line in "".join(blocks("bash")).splitlines():
        for part in line.split("&&"):
            words = shlex.split(part)
            if words[0] == "plantigrade":
                parse(words[1], words[2:])


def test_the_first_screen_says_what_it_is_shows_it_and_runs_it():
    lines = README.read_text("utf-8").splitlines()
    first = "\n".join(lines[:35])
    assert "![" in first and "pip install" in first and "plantigrade demo" in first
    assert len(lines) <= 160


def test_its_picture_moves():
    (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+\.svg)\)", README.read_text("utf-8"))
    assert "<animate" in (ROOT / picture).read_text("utf-8")


def test_every_page_of_the_documentation_is_linked():
    text = README.read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        if page.name != "index.md":
            assert f"](docs/{page.name}" in text, page.name


def test_results_are_those_of_the_page_of_measured_results():
    rows = [line for line in README.read_text("utf-8").splitlines() if line.count("|") == 5]
    measured = (ROOT / "docs" / "benchmarks.md").read_text("utf-8").splitlines()
    assert len(rows) > 5 and set(rows) <= set(measured)


def test_how_to_cite_agrees_with_the_citation_file():
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    (bibtex,) = blocks("bibtex")
    assert f"version = {{{citation['version']}}}" in bibtex
    assert f"license = {{{citation['license']}}}" in bibtex


def test_links_lead_somewhere():
    text = README.read_text("utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (ROOT / target).exists(), f"README links to {target}, which is not there"
