"""The tutorials and the pages of methods are notebooks, which the build of the pages runs."""

import ast
import json

import pytest

from tests.test_pages_of_docs import DOCS, extension

pytest.importorskip("docutils")

NOTEBOOKS = extension("notebooks")
PAGES = [
    *sorted((DOCS / "tutorials").glob("*.md")),
    *(page for page in sorted((DOCS / "methods").glob("*.md")) if page.stem != "index"),
]


def test_there_is_one_for_each_user_and_each_paper():
    assert [page.stem for page in PAGES] == [
        "animator", "clinician", "roboticist",
        "boukheddimi", "cheng", "park", "tsai", "zhakatayev",
    ]  # fmt: skip


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_becomes_a_notebook(page):
    text = page.read_text("utf-8")
    made = json.loads(NOTEBOOKS.notebook(text))
    assert (made["nbformat"], made["nbformat_minor"]) == (4, 5)
    code = [cell for cell in made["cells"] if cell["cell_type"] == "code"]
    assert len(code) == text.count("```{code-cell} ipython3\n") >= 2
    for cell in code:
        ast.parse(cell["source"])
    prose = "".join(cell["source"] for cell in made["cells"] if cell["cell_type"] == "markdown")
    assert prose.startswith("# ") and "](../" not in prose and "```{" not in prose


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_is_run_and_can_be_downloaded(page):
    text = page.read_text("utf-8")
    assert text.startswith("---\nfile_format: mystnb\n")
    assert text.count("```{download-notebook}\n```\n") == 1


def test_each_method_has_equation_code_and_figure():
    for page in (DOCS / "methods").glob("*.md"):
        if page.stem != "index":
            text = page.read_text("utf-8")
            assert all(f"\n## {part}\n" in text for part in ("Equation", "Code", "Figure"))
            assert "$$" in text.split("## Equation")[1].split("## Code")[0], page.stem


def test_outputs_and_links_of_a_page_stay_out():
    page = (
        "---\nfile_format: mystnb\n---\n\n# A [page](../b.md) and [site](https://example.org)\n\n"
        "```{download-notebook}\n```\n\n```{code-cell} ipython3\n:tags: [hide-input]\nx = 1\n```\n"
    )
    assert NOTEBOOKS.cells(page) == [
        ("markdown", "# A page and [site](https://example.org)"),
        ("code", "x = 1"),
    ]
