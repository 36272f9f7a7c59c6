"""The documentation agrees with the code."""

import importlib
import json
import re
import shlex
import shutil
from pathlib import Path

import pytest

import plantigrade
from plantigrade.commands.main import COMMANDS, main, parse
from tests.paste import blocks, commands, inline_commands, paste
from tests.test_layers import LAYERS
from tests.textbook import walk_file

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs"
MODULES = sorted(Path(plantigrade.__file__).parent.rglob("*.py"))
WRITTEN = [
    page
    for folder in ("", "commands/", "settings/", "tutorials/", "methods/")
    for page in PAGES.glob(f"{folder}*.md")
]
WITH_COMMANDS = sorted(path for path in WRITTEN if path.name != "gallery.md")
RUN = {"demo", "fit", "simulate", "synthesize", "convert", "model", "report", "compare", "norms",
       "picture", "data"}  # fmt: skip
"""Commands whose printed lines are compared with the pages."""
ALSO_RUN = (
    "plantigrade demo --height 1.60 --mass 55 --sex female --speed 1.0 --seed 3 --out runs/small",
    "plantigrade fit monday/*.c3d --jobs 2 --out runs/monday",
)
"""Commands that other pages need."""


def test_every_citation_in_a_docstring_is_in_the_references():
    listed = set(
        re.findall(r"^\.\. \[([^]]+)\]", (PAGES / "references.md").read_text("utf-8"), re.M)
    )
    cited = {
        (key, path.name)
        for path in [*MODULES, *(ROOT / "experiments").glob("*.py")]
        for key in re.findall(r"\[([A-Za-z]{3,}(?:\d{4}[a-z]?)?)\]_", path.read_text("utf-8"))
    }
    assert {(key, name) for key, name in cited if key not in listed} == set()


def test_every_reference_comes_once():
    text = (PAGES / "references.md").read_text("utf-8")
    keys = re.findall(r"^\.\. \[([^]]+)\]", text, re.M)
    assert sorted(keys) == sorted(set(keys))


def test_references_are_written_out_in_one_place_only():
    defined = re.compile(r"^ *\.\. \[\w+\]", re.M)
    assert [path.name for path in MODULES if defined.search(path.read_text("utf-8"))] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_a_page(name):
    text = (PAGES / "commands" / f"{name}.md").read_text("utf-8")
    assert text.startswith(f"# {name}\n") and "\n## Exit codes\n" in text
    assert re.search(rf"^.. options:: {name}\b", text, re.M)
    assert re.search(rf"^(\$ )?plantigrade {name}\b", text, re.M)
    index = (PAGES / "commands" / "index.md").read_text("utf-8")
    assert f"\n| [`{name}`]({name}.md) | " in index and f"\n{name}\n" in index


@pytest.mark.slow
@pytest.mark.solver
def test_the_commands_of_the_pages_can_be_pasted(tmp_path, monkeypatch, capsys, demo):
    """Into an empty folder, page after page, and print what the pages show.

    The demo that other tests look at is the first; the longest ones are parsed, their files there.
    """
    monkeypatch.chdir(tmp_path)
    shutil.copytree(demo.folder / "runs", "runs")
    ran = []

    def call(words):
        if words == ["demo"]:
            return demo.said
        assert main([*words, "--quiet"]) == 0, words
        return capsys.readouterr().out

    for name in COMMANDS:
        ran += paste(PAGES / "commands" / f"{name}.md", RUN, call, ALSO_RUN)
    assert {line.split()[1] for line in ran} == RUN and {*ALSO_RUN} <= {*ran}
    small = json.loads(Path("runs", "small", "metrics.json").read_text("utf-8"))
    assert small["seed"] == 3 and small["walking_speed_m_s"] == pytest.approx(1.0, abs=0.03)
    assert small["mass_kg"] == pytest.approx(55, abs=0.1)
    assert small["height_m"] == pytest.approx(1.6, abs=1e-6)


def test_completion_is_installed_as_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    asked = []
    paste(PAGES / "commands" / "index.md", set(), lambda words: str(asked.append(words)))
    assert asked == [["--print-completion", "bash"]]
    assert (tmp_path / ".local/share/bash-completion/completions/plantigrade").is_file()


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: page.stem)
def test_pages_show_only_commands_and_options_that_exist(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("tasks").mkdir()
    for words in (*commands(page, "bash", "console", "text"), *inline_commands(page)):
        words = words[: words.index("&&")] if "&&" in words else words
        if words[0] == "plantigrade" and words[1][0] != "-" and "--help" not in words:
            if words[2:] and words[2].endswith(".toml"):
                Path(words[2]).write_text('[task]\nbase = "squat"\n')
            words = ["2" if word.startswith("$") else word for word in words]  # a variable of Slurm
            parse(words[1], words[2 : words.index(">") if ">" in words else None])


def test_experiments_named_with_the_measured_results_exist():
    from experiments.registry import EXPERIMENTS

    rows = re.findall(r"^\|.*\| (`.*`) \|$", (PAGES / "benchmarks.md").read_text("utf-8"), re.M)
    named = {name for row in rows for name in re.findall(r"`([a-z-]+)`", row)}
    assert len(named) > 5 and named <= set(EXPERIMENTS)
    pages = ("experiments.md", "experiments-control.md")
    described = "".join((PAGES / name).read_text("utf-8") for name in pages)
    assert [name for name in EXPERIMENTS if f"`{name}`" not in described] == []


def test_each_row_of_the_page_that_chooses_a_command_has_one():
    text = (PAGES / "which-command.md").read_text("utf-8")
    rows = re.findall(r"^\| (?!you have|---)(.*) \|$", text, re.M)
    assert len(rows) > 30
    chosen = {re.findall(r"`plantigrade (\w+)[^`]*`$", row)[0] for row in rows}
    assert chosen == {*COMMANDS}


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
            paste(page, set(), str)
    page.write_text("```bash\nplantigrade fit walk.c3d --no-dynamics\n```\n")
    with pytest.raises(SystemExit):
        paste(page, set(), str)
    page.write_text("```console\n$ plantigrade model\nmale, 1.74 m\n```\n")
    assert paste(page, {"model"}, lambda _: "male, 1.80 m\n") == ["plantigrade model"]
    with pytest.raises(AssertionError, match="page.md: plantigrade model"):
        paste(page, {"model"}, lambda _: "female, 1.74 m\n")


@pytest.mark.slow
def test_the_python_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    walk_file(Path("walk.c3d"), cycles=2)
    (code,) = blocks(PAGES / "python.md", "python")
    exec(compile(code, "python.md", "exec"), {})
    assert capsys.readouterr().out.splitlines()[-1] == "runs/fit-walk/report.html"


def test_every_name_of_the_package_is_documented_and_listed_by_need():
    names = {f"plantigrade.{name}" for name in {*plantigrade.__all__} - {"__version__"}}
    documented = re.findall(
        r"^\.\. auto\w+:: (\S+)$", (PAGES / "api" / "plantigrade.md").read_text("utf-8"), re.M
    )
    assert sorted(documented) == sorted(names)
    text = (PAGES / "api" / "index.md").read_text("utf-8")
    assert {name for name in names if not re.search(rf"\b{re.escape(name)}\b", text)} == set()


def test_every_module_of_the_api_exists_and_comes_once():
    text = (PAGES / "api" / "modules.md").read_text("utf-8")
    names = re.findall(r"^   (plantigrade[\w.]*)$", text, re.M)
    assert len(names) > 50 and len(set(names)) == len(names)
    for name in names:
        importlib.import_module(name)


def test_the_api_by_need_lists_packages_that_say_what_they_offer():
    text = (PAGES / "api" / "index.md").read_text("utf-8")
    packages = re.findall(r"^\.\. public-names:: (\S+)$", text, re.M)
    assert len(packages) > 10 and len(set(packages)) == len(packages)
    for name in packages:
        assert importlib.import_module(name).__all__


def test_pages_have_no_words_of_the_house():
    for page in (*WRITTEN, *PAGES.glob("api/*.md"), ROOT / "README.md"):
        assert not re.search(r"\b(rooms?|face)\b", page.read_text("utf-8")), page.name


def test_the_gallery_shows_what_its_commands_make(tmp_path, monkeypatch):
    """Each block makes a run and draws it, under the name of the picture above it."""
    monkeypatch.chdir(tmp_path)
    text = (PAGES / "gallery.md").read_text("utf-8")
    made = set()
    parts = re.findall(r"!\[[^]]+\]\(images/(\S+)\)\n\n```bash\n(.*?)^```", text, re.M | re.S)
    assert len(parts) > 5 and len(parts) == text.count("```bash") == text.count("](images/")
    for picture, block in parts:
        for line in block.splitlines():
            words = shlex.split(line)
            command = parse(words[1], words[2:])
            if words[1] == "picture":
                assert str(command.run_folder).removesuffix("-reproduced") in made
                assert str(command.out) == picture
            else:
                made.add(str(command.out))
        assert (PAGES / "images" / picture).stat().st_size < 400_000


def test_there_are_no_pictures_that_no_page_shows():
    pages = "".join(p.read_text("utf-8") for p in [*WRITTEN, ROOT / "README.md"])
    images = {path.name for path in (PAGES / "images").iterdir()}
    assert images == {name for name in images if re.search(rf"images/{re.escape(name)}\b", pages)}


@pytest.mark.parametrize("page", WRITTEN, ids=lambda page: page.stem)
def test_links_between_pages_lead_somewhere(page):
    text = page.read_text("utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (page.parent / target).exists(), target


@pytest.mark.slow
@pytest.mark.solver
def test_the_tutorial_can_be_followed_to_the_letter(tmp_path, monkeypatch, capsys):
    """Its commands and its Python, one after the other in an empty folder."""
    monkeypatch.chdir(tmp_path)
    text = (PAGES / "tutorial.md").read_text("utf-8")
    names: dict = {"__name__": "__main__"}
    commands = []
    for language, block in re.findall(r"^```(bash|python)\n(.*?)^```", text, re.M | re.S):
        if language == "python":
            exec(compile(block, "tutorial.md", "exec"), names)
            assert capsys.readouterr().out.strip()
            continue
        for line in block.splitlines():
            words = shlex.split(line)
            if words[0] == "plantigrade":
                assert main([*words[1:], "--quiet"]) == 0, line
                commands.append(words[1])
    assert commands == ["demo", "fit", "picture", "synthesize"]
    for path in re.findall(r"`(runs/[^`]+)`", text):
        assert (tmp_path / path).exists(), path


def test_conventions_name_every_coordinate():
    from plantigrade.models.coordinates import COORDINATES

    text = (PAGES / "conventions.md").read_text("utf-8")
    for name in COORDINATES:
        base, _, kind = name.rpartition("_")
        assert f"`{name}`" in text or (f"`{base}_…`" in text and f"`_{kind}`" in text), name


def test_every_package_with_public_names_has_a_page_of_the_api():
    text = (PAGES / "api" / "modules.md").read_text("utf-8")
    for path in MODULES:
        if path.parent == MODULES[0].parent:
            continue  # the names of the package itself, above
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
