"""The package is ready to be released: metadata agree, placeholders are known."""

import re
import tomllib
from pathlib import Path

import pytest

import plantigrade
from plantigrade.extras import RELEASED, install_command, require
from tests.test_readme import README

ROOT = Path(__file__).resolve().parents[1]
PLACEHOLDER = "example.org"
PLACES = (
    *("pyproject.toml", "SECURITY.md", "CODE_OF_CONDUCT.md", ".github/ISSUE_TEMPLATE/config.yml"),
)
"""Files that name an address of the project."""
WRITTEN = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


@pytest.mark.parametrize("name", PLACES)
def test_addresses_are_placeholders_until_there_is_a_release(name):
    text = (ROOT / name).read_text("utf-8")
    assert (PLACEHOLDER in text) is not RELEASED


def test_addresses_are_of_one_host():
    hosts = {re.sub(r"https://([^/]+)/.*", r"\1", url) for url in PROJECT["urls"].values()}
    assert len(hosts) == 1 and {"Source", "Issues", "Documentation"} <= set(PROJECT["urls"])


def test_classifiers_exist():
    known = pytest.importorskip("trove_classifiers").classifiers
    assert set(PROJECT["classifiers"]) <= known
    assert "Programming Language :: Python :: 3.11" in PROJECT["classifiers"]
    assert PROJECT["requires-python"] == ">=3.11"


def test_the_install_command_is_that_of_what_exists():
    every = "\n".join(path.read_text("utf-8") for path in WRITTEN)
    other = "." if RELEASED else "plantigrade"
    assert f"pip install '{other}[" not in every
    assert ("There is no release on the package index" in every) is not RELEASED


def test_a_missing_extra_names_that_command():
    with pytest.raises(plantigrade.PlantigradeError) as caught:
        require("no_such_library", "tables")
    assert install_command("tables") in str(caught.value)


def test_the_image_copies_what_exists_and_runs_the_demo_as_nobody_special():
    lines = (ROOT / "Dockerfile").read_text("utf-8").splitlines()
    copied = [
        line.split()[1:-1] for line in lines if line.startswith("COPY ") and "--from" not in line
    ]
    assert all((ROOT / name).exists() for names in copied for name in names)
    kept = (ROOT / ".dockerignore").read_text("utf-8").split()
    assert all(f"!{name}" in kept for names in copied for name in names)
    user = next(
        i for i, line in enumerate(lines) if line.startswith("USER ") and "root" not in line
    )
    assert any("plantigrade demo" in line for line in lines[user:])


@pytest.mark.parametrize(
    "path", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")), ids=lambda p: p.stem
)
def test_issue_templates_are_well_formed(path):
    yaml = pytest.importorskip("yaml")
    form = yaml.safe_load(path.read_text("utf-8"))
    if path.stem == "config":
        return
    assert form["name"] and form["description"]
    fields = [part for part in form["body"] if part["type"] != "markdown"]
    assert len({part["id"] for part in fields}) == len(fields)
    assert all(part["attributes"]["label"] for part in fields)


def test_the_source_distribution_holds_what_the_readme_links_to():
    build = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["build"]
    held = [name.lstrip("/") for name in build["targets"]["sdist"]["include"]] + ["LICENSE"]
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", README.read_text("utf-8")):
        assert target.split("/")[0] in held, target
