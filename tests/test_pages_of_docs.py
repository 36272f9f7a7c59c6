"""Build of the documentation: mathematics without scripts, pages without requests."""

import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
MATH = "{http://www.w3.org/1998/Math/MathML}"


def extension(name: str):
    spec = importlib.util.spec_from_file_location(name, DOCS / "_ext" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/mathjax.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/css">',
        '<img alt="" src="http://example.org/a.png">',
        '<img srcset="a.png 1x, https://example.org/b.png 2x">',
        "<style>@font-face { src: url('https://example.org/f.woff2') }</style>",
        '<style>@import "https://example.org/a.css";</style>',
        '<p style="background: url(https://example.org/a.png)"></p>',
        '<object data="https://example.org/a.svg"></object>',
    ],
)
def test_a_page_that_asks_for_something_outside_is_noticed(html):
    assert len(extension("alone").requests(html)) == 1


def test_links_and_local_files_are_not_requests():
    html = '<a href="https://doi.org/1"></a><img src="_images/a.svg"><script src="_static/a.js">'
    assert extension("alone").requests(html) == []


def test_a_folder_is_read_with_its_style_sheets(tmp_path):
    (tmp_path / "a.css").write_text("p { background: url(https://example.org/a.png) }")
    (tmp_path / "a.html").write_text("<p></p>")
    found = list(extension("alone").requests_of_folder(tmp_path))
    assert found == [(tmp_path / "a.css", "https://example.org/a.png")]


def test_the_build_looks_for_requests_and_has_no_other_mathematics():
    text = (DOCS / "conf.py").read_text("utf-8")
    assert '"alone"' in text and '"mathml"' in text and "mathjax" not in text


@pytest.fixture(scope="module")
def mathml():
    for library in ("sphinx", "latex2mathml"):
        pytest.importorskip(library)
    return extension("mathml").mathml


def test_mathematics_becomes_mathml(mathml):
    root = ET.fromstring(mathml(r"\ddot e = -\lambda_p\, e", block=True))
    assert root.tag == f"{MATH}math" and root.get("display") == "block"
    assert "λ" in "".join(root.itertext())


def test_lines_that_are_aligned_become_a_table(mathml):
    root = ET.fromstring(mathml(r"a &= b \\ c &= d", block=True))
    assert len(list(root.iter(f"{MATH}mtr"))) == 2


def test_a_command_that_is_not_known_is_refused(mathml):
    from sphinx.errors import ExtensionError

    for wrong in (r"\nosuchcommand x", r"\begin{nosuchlines}a & b\end{nosuchlines}"):
        with pytest.raises(ExtensionError, match="unknown command|cannot be read"):
            mathml(wrong)


def test_all_mathematics_of_the_pages_is_readable(mathml):
    formulas = []
    for page in DOCS.glob("*.md"):
        text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
        formulas += re.findall(r"\$\$(.+?)\$\$", text, re.S)
        formulas += re.findall(r"(?<![$\\])\$([^$\n]+)\$", text)
    for module in (ROOT / "plantigrade").rglob("*.py"):
        formulas += re.findall(r":math:`([^`]+)`", module.read_text("utf-8"))
    assert len(formulas) > 100
    for formula in formulas:
        mathml(formula)
