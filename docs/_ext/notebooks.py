"""Notebooks that readers can download: ``download-notebook::`` links to its page as ``.ipynb``.

The pages are Markdown with ``code-cell`` blocks, run while the documentation is built. The file
behind the link has the same text and code without outputs, for Jupyter on the reader's machine.
"""

import json
import re
from pathlib import Path, PurePosixPath
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive

LINK = (
    '<p class="download"><a href="{name}.ipynb" download>Download this page as a notebook</a></p>'
)
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(?::[^\n]*\n)*(.*?)^```$", re.M | re.S)
HEAD = re.compile(r"\A---\n.*?^---\n", re.M | re.S)
DIRECTIVE = re.compile(r"^```\{(?!code-cell).*?^```\n", re.M | re.S)
OWN_IMAGE = re.compile(r"!\[[^]]*\]\((?!https?:)[^)]+\)\n?")
OWN_LINK = re.compile(r"\[([^]]+)\]\((?!https?:)[^)]+\)")  # another page, which is not beside it
ROLE = re.compile(r"\{\w+\}`~?([^`]+)`")


def cells(page: str) -> list[tuple[str, str]]:
    """Return the cells of a page: kind (``markdown`` or ``code``) and text."""
    text = DIRECTIVE.sub("", HEAD.sub("", page))
    found: list[tuple[str, str]] = []
    for number, part in enumerate(CELL.split(text)):
        kind = "code" if number % 2 else "markdown"
        plain = part if kind == "code" else _alone(part)
        if plain.strip():
            found.append((kind, plain.strip("\n")))
    return found


def _alone(text: str) -> str:
    """Return text without the pictures, links and roles that need the other pages."""
    return ROLE.sub(r"`\1`", OWN_LINK.sub(r"\1", OWN_IMAGE.sub("", text)))


def notebook(page: str) -> str:
    """Return a page as the text of a notebook, format 4.5, without outputs."""
    made = []
    for number, (kind, text) in enumerate(cells(page)):
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text}
        made.append(cell | ({"execution_count": None, "outputs": []} if kind == "code" else {}))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, ensure_ascii=False, indent=1) + "\n"


class DownloadNotebook(Directive):
    """The link to the notebook of a page."""

    def run(self) -> list:
        """Return the link."""
        name = PurePosixPath(self.state.document.settings.env.docname).name
        return [nodes.raw("", LINK.format(name=name), format="html")]


def setup(app: Any) -> dict:
    """Add the directive; write the notebooks beside their pages when these are built."""

    def write(app: Any, exception: Exception | None) -> None:
        if exception is not None or app.builder.format != "html":
            return
        for page in app.env.found_docs:
            text = Path(app.env.doc2path(page)).read_text("utf-8")
            if "```{download-notebook}" in text:
                Path(app.outdir, f"{page}.ipynb").write_text(notebook(text), "utf-8")

    app.add_directive("download-notebook", DownloadNotebook)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
