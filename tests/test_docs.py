"""The pages beside the code keep up with it."""

import re
from pathlib import Path

import pytest

import plantigrade
from plantigrade.commands.main import COMMANDS
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


def test_usage_shows_only_commands_and_options_that_exist(tmp_path, monkeypatch):
    import shlex

    from plantigrade.commands.main import parse

    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('[task]\nbase = "squat"\n')
    text = (PAGES / "usage.md").read_text("utf-8")
    for block in re.findall(r"^```bash\n(.*?)^```", text, re.M | re.S):
        for line in block.splitlines():
            words = shlex.split(line.split(">")[0])
            if words[0] == "plantigrade":
                parse(words[1], words[2:])


def test_conventions_name_every_coordinate():
    from plantigrade.models.coordinates import COORDINATES

    text = (PAGES / "conventions.md").read_text("utf-8")
    for name in COORDINATES:
        base, _, kind = name.rpartition("_")
        assert f"`{name}`" in text or (f"`{base}_…`" in text and f"`_{kind}`" in text), name


def test_every_package_with_public_names_is_in_the_api_page():
    text = (PAGES / "api.md").read_text("utf-8")
    for path in MODULES:
        if path.name == "__init__.py" and "__all__" in path.read_text("utf-8"):
            name = ".".join(path.parent.relative_to(Path(plantigrade.__file__).parent.parent).parts)
            assert f".. automodule:: {name}\n" in text


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
