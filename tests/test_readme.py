"""The README is correct: its Python runs, its commands exist."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from plantigrade.extras import install_command
from tests.paste import blocks
from tests.textbook import walk_file

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
CI = ROOT / ".ci" / "run"


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """The file ``walk.c3d`` of the examples: a textbook walk."""
    return walk_file(tmp_path_factory.mktemp("readme") / "walk.c3d", speed=1.25)


@pytest.mark.parametrize("source", blocks(README, "python"))
def test_python_block_runs(source, walk, monkeypatch, capsys):
    monkeypatch.chdir(walk.parent)
    exec(compile(source, str(README), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_there_is_a_python_block():
    assert blocks(README, "python")


def test_the_test_command_is_the_one_that_is_checked():
    (command,) = [block.strip() for block in blocks(README, "bash") if "pytest" in block]
    lines = [line.strip() for line in CI.read_text("utf-8").splitlines()]
    assert command in lines


def test_the_main_command_is_tried_from_the_wheel():
    (command,) = [block.strip() for block in blocks(README, "bash") if "plantigrade demo" in block]
    install, job = command.split(" && ")
    assert install == install_command("synthesis")
    assert job in [line.strip() for line in CI.read_text("utf-8").splitlines()]


def test_every_command_exists():
    from plantigrade.commands.main import COMMANDS

    spoken = re.findall(r"\bplantigrade ([a-z]+)\b", "\n".join(blocks(README, "bash")))
    assert spoken and set(spoken) <= set(COMMANDS)


def test_commands_parse():
    from plantigrade.commands.main import parse

    for line in "".join(blocks(README, "bash")).splitlines():
        for part in line.split("&&"):
            words = shlex.split(part)
            if words[0] == "plantigrade":
                parse(words[1], words[2:])


@pytest.mark.slow
@pytest.mark.solver
def test_the_commands_run_in_order_and_write_what_they_name(tmp_path, monkeypatch, demo, capsys):
    """In one folder, after the demo; a live page would run until somebody ends it."""
    from plantigrade.commands.main import main

    monkeypatch.chdir(tmp_path)
    shutil.copytree(demo.folder / "runs", "runs")
    before = {path.name for path in Path("runs").iterdir()}
    ran = []
    for line in "".join(blocks(README, "bash")).splitlines():
        words = shlex.split(line)
        if words[0] == "plantigrade" and "--live" not in words:
            assert main([*words[1:], "--quiet"]) == 0, line
            ran.append(words[1])
            if "--out" in words:
                made = Path(words[words.index("--out") + 1])
                assert made.suffix or (made / "report.html").is_file(), line
                assert made.exists(), line
    assert ran == [
        "fit", "compare", "convert", "synthesize", "convert", "convert", "model", "simulate",
        "simulate", "reproduce",
    ]  # fmt: skip
    for name in ("curves.csv", "stroll.bvh", "stroll.glb", "human.xml"):
        assert Path(name).stat().st_size > 1000, name
    numbered = [path.name for path in Path("runs").iterdir() if re.search(r"-\d+$", path.name)]
    assert set(numbered) <= before, "two commands write to one folder"
    assert capsys.readouterr().err == ""


def test_the_first_screen_says_what_it_is_for_whom_shows_it_and_runs_it():
    lines = README.read_text("utf-8").splitlines()
    first = "\n".join(lines[:20])
    assert "![" in first and "pip install" in first and "plantigrade demo" in first
    assert all(who in lines[3] for who in ("laboratories", "animators", "roboticists", "teachers"))
    assert len(lines) <= 175


@pytest.mark.parametrize("user", ["laboratory", "animation", "robotics", "teaching"])
def test_each_kind_of_user_has_three_lines(user):
    (block,) = re.findall(
        rf"^\*\*(?:In|For) (?:the )?{user}\*\*.*?\n```bash\n(.*?)^```",
        README.read_text("utf-8"), re.M | re.S,
    )  # fmt: skip
    assert [line.split()[0] for line in block.splitlines()] == ["plantigrade"] * 3


def test_its_picture_moves_and_is_small():
    image = pytest.importorskip("PIL.Image")
    (picture,) = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README.read_text("utf-8"))
    assert (ROOT / picture).stat().st_size <= 1_500_000
    assert image.open(ROOT / picture).n_frames > 20


def test_a_report_and_the_viewer_are_shown():
    shown = re.findall(r'<img src="([^"]+)"', README.read_text("utf-8"))
    assert [Path(path).stem for path in shown] == ["report", "viewer"]
    assert all((ROOT / path).stat().st_size < 300_000 for path in shown)


def test_every_page_of_the_documentation_is_linked():
    text = README.read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        if page.name != "index.md":
            assert f"](docs/{page.name}" in text, page.name


def test_results_are_those_of_the_page_of_measured_results():
    rows = [line for line in README.read_text("utf-8").splitlines() if line.count("|") == 5]
    measured = (ROOT / "docs" / "benchmarks.md").read_text("utf-8").splitlines()
    assert len(rows) == 8 and set(rows) <= set(measured)


def test_how_to_cite_agrees_with_the_citation_file():
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    (bibtex,) = blocks(README, "bibtex")
    assert f"version = {{{citation['version']}}}" in bibtex
    assert f"license = {{{citation['license']}}}" in bibtex


def test_links_lead_somewhere():
    text = README.read_text("utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (ROOT / target).exists(), f"README links to {target}, which is not there"
