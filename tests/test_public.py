"""``__all__`` defines what is public; the page about it, examples and documentation agree."""

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import plantigrade
from tests.stub import PLACE, stub

PACKAGE = Path(plantigrade.__file__).parent
ROOT = PACKAGE.parent
PAGE = (ROOT / "docs" / "python.md").read_text("utf-8").partition("## What is public")[2]
PUBLIC = set(re.findall(r"^\| `(plantigrade[\w.]*)`", PAGE, re.MULTILINE))
BLOCK = re.compile(r"^```(?:python|\{code-cell\} ipython3)\n(.*?)^```", re.MULTILINE | re.DOTALL)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def offered(module: str) -> set[str]:
    return {*getattr(importlib.import_module(module), "__all__", ()), "__all__"}


def not_public(source: str) -> Iterator[str]:
    """Yield the names that a program imports from the package and that are not public."""
    tree, aliases = ast.parse(source), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("plantigrade"):
            for alias in node.names:
                if node.module not in PUBLIC or alias.name not in offered(node.module):
                    yield f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "plantigrade":
                    aliases[alias.asname or alias.name] = alias.name
                    if alias.name not in PUBLIC:
                        yield alias.name
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and (module := aliases.get(ast.unparse(node.value))):
            inner = f"{module}.{node.attr}"
            if node.attr not in offered(module) and inner not in PUBLIC:
                yield inner


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_take_what_is_public(path):
    assert sorted(not_public(path.read_text("utf-8"))) == []


def test_the_documentation_takes_what_is_public():
    found = {
        str(path.relative_to(ROOT)): sorted(
            {name for block in BLOCK.findall(path.read_text("utf-8")) for name in not_public(block)}
        )
        for path in PAGES
    }
    assert {page: names for page, names in found.items() if names} == {}


def test_what_is_not_public_is_noticed():
    source = "from plantigrade.world.box import Box\nimport plantigrade.world as world\n"
    source += "import plantigrade as pg\nworld.Push\nworld.box\npg.fit\npg.kinematics"
    found = ["plantigrade.kinematics", "plantigrade.world.box", "plantigrade.world.box.Box"]
    assert sorted(not_public(source)) == found


def test_the_page_lists_every_public_package_and_all_of_them_offer_names():
    packages = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for path in PACKAGE.rglob("__init__.py")
        if re.search(r"^__all__ = ", path.read_text("utf-8"), re.MULTILINE)
    }
    assert packages <= PUBLIC
    assert all(len(offered(module)) > 1 for module in PUBLIC)


def test_the_api_has_a_page_for_everything_public():
    api = ROOT / "docs" / "api"
    modules = (api / "modules.md").read_text("utf-8")
    listed = set(re.findall(r"^   (plantigrade[\w.]*)$", modules, re.MULTILINE))
    assert PUBLIC - listed == {"plantigrade"}  # has a page of its own
    by_need = re.findall(r"^.. public-names:: (\S+)$", (api / "index.md").read_text("utf-8"), re.M)
    assert PUBLIC - {*by_need} == {"plantigrade"}  # its names are sorted by hand


def test_what_editors_read_is_what_the_functions_take():
    assert PLACE.read_text("utf-8") == stub(), "make it anew: python -m tests.stub"
