"""The pages beside the code keep up with it."""

import re
from pathlib import Path

import pytest

import plantigrade
from plantigrade.commands.main import COMMANDS
from tests.paste import blocks, commands, paste
from tests.test_layers import LAYERS

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs"
MODULES = sorted(Path(plantigrade.__file__).parent.rglob("*.py"))


def test_every_citation_in_a_docstring_is_in_the_references():
    listed = set(
        re.findall(r"^\.\. \[([^]]+)\]", (PAGES / "references.md").read_text("utf-8"), re.M)
    )
    cited = {
        (key, path.name)
        for path in MODULES
        for key in re.findall(r"\[([A-Za-z]{3,}(?:\d{4}[a-z]?)?)\]_", path.read_text("utf-8"))
    }
    assert {(key, name) for key, name in cited if key not in listed} == set()


def test_references_are_written_out_in_one_place_only():
    defined = re.compile(r"^ *\.\. \[\w+\]", re.M)
    assert [path.name for path in MODULES if defined.search(path.read_text("utf-8"))] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_usage_shows_every_command(name):
    text = (PAGES / "usage.md").read_text("utf-8")
    assert f"### {name}\n" in text
    assert re.search(rf"^plantigrade {name}\b", text, re.M)


@pytest.mark.slow
def test_the_commands_of_the_usage_page_can_be_pasted(tmp_path, monkeypatch):
    """Into an empty folder, in the order of the page; the slowest are parsed, their files there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    quick = {"demo", "fit", "convert", "model", "data", "report", "picture"}
    ran = paste(PAGES / "usage.md", quick)
    assert set(ran) == quick and ran.count("fit") >= 4
    runs = {path.name for path in (tmp_path / "runs").iterdir()}
    assert {"demo", "demo-2", "demo-2-reproduced", "small", "fit-walk", "fit-walk-2"} <= runs


def test_usage_shows_only_commands_and_options_that_exist():
    from plantigrade.commands.main import parse

    for language in ("bash", "text"):
        for words in commands(PAGES / "usage.md", language):
            if words[0] == "plantigrade" and "mine.toml" not in words and words[1][0] != "-":
                parse(words[1], words[2 : words.index(">") if ">" in words else None])


def test_what_cannot_be_pasted_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    for line, words in (
        ("plantigrade view runs/fit-walk", "runs/fit-walk is not there"),
        ("plantigrade synthesize squat --warm runs/squat", "runs/squat is not there"),
        ("plantigrade synthesize squat --out a\nplantigrade synthesize squat --out a", "a"),
    ):
        page.write_text(f"```bash\n{line}\n```\n")
        with pytest.raises(AssertionError, match=words):
            paste(page, set())
    page.write_text("```bash\nplantigrade fit walk.c3d --no-dynamics\n```\n")
    with pytest.raises(SystemExit):
        paste(page, set())


def test_the_python_of_the_usage_page_runs(tmp_path, monkeypatch, capsys):
    from plantigrade.io import write
    from plantigrade.models import Human
    from plantigrade.workflows.textbook import recorded, textbook_walk

    monkeypatch.chdir(tmp_path)
    human = Human.create(1.74, 71.0, "male", joints="42")
    write(recorded(textbook_walk(human, cycles=2), Path("walk.c3d")), "walk.c3d")
    first = blocks(PAGES / "usage.md", "python")[0]  # the other one is the check in MuJoCo
    exec(compile(first, "usage.md", "exec"), {})
    assert capsys.readouterr().out.splitlines()[-1] == "runs/fit-walk/report.html"


def test_conventions_name_every_coordinate():
    from plantigrade.models.coordinates import COORDINATES

    text = (PAGES / "conventions.md").read_text("utf-8")
    for name in COORDINATES:
        base, _, kind = name.rpartition("_")
        assert f"`{name}`" in text or (f"`{base}_…`" in text and f"`_{kind}`" in text), name


def test_every_package_with_public_names_is_in_the_api_page():
    text = (PAGES / "api" / "index.md").read_text("utf-8")
    for path in MODULES:
        if path.name == "__init__.py" and "__all__" in path.read_text("utf-8"):
            name = ".".join(path.parent.relative_to(Path(plantigrade.__file__).parent.parent).parts)
            assert f"\n   {name}\n" in text, name


def test_guidelines_draw_the_layers_that_are_asserted():
    text = (PAGES / "design-guidelines.md").read_text("utf-8")
    (drawn,) = re.findall(r"^```text\n(.*?)^```", text, re.M | re.S)
    lines = [line.split() for line in drawn.splitlines()]
    assert lines == [list(line) for line in LAYERS if line != ("__main__",)]


def test_version_is_the_same_everywhere():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {plantigrade.__version__}\n" in citation


def test_citation_file_is_well_formed():
    yaml = pytest.importorskip("yaml")
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["cff-version"] and citation["license"] == "Apache-2.0"
    assert len(citation["references"]) == 4
    assert all(reference["title"] and reference["authors"] for reference in citation["references"])
