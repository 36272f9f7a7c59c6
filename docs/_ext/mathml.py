"""Mathematics as MathML, made when the pages are built: no script, no font, no request.

Browsers draw MathML by themselves since 2023.
"""

from xml.etree import ElementTree

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


def setup(app: Sphinx) -> dict:
    """Make ``mathml`` the renderer of mathematics in HTML."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def mathml(latex: str, *, block: bool = False) -> str:
    """Return LaTeX as a MathML element.

    Raises:
        ExtensionError: If the LaTeX cannot be read, or a command of it is not known.
    """
    lines = latex.strip().replace("{aligned}", "{split}")
    if block and ("\\\\" in lines or "&" in lines) and "\\begin" not in lines:
        lines = rf"\begin{{split}}{lines}\end{{split}}"
    try:
        markup = convert(lines, display="block" if block else "inline")
        ElementTree.fromstring(markup)  # an & without columns would be passed on as it is
    except Exception as error:
        raise ExtensionError(f"mathematics cannot be read: {latex!r}: {error}") from error
    if "\\" in markup.replace("&#x0005C;", "\\"):  # a command that was passed on as text
        raise ExtensionError(f"mathematics holds an unknown command: {latex!r}")
    return markup


def _inline(translator, node) -> None:
    translator.body.append(mathml(node.astext()))
    raise SkipNode


def _block(translator, node) -> None:
    parts = [part for part in node.astext().split("\n\n") if part.strip()]
    inner = "".join(mathml(part, block=True) for part in parts)
    translator.body.append(translator.starttag(node, "div", CLASS="math") + inner + "</div>\n")
    raise SkipNode
