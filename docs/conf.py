import sys
from pathlib import Path

from plantigrade import __version__ as release

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "plantigrade"
author = "The plantigrade developers"
copyright = f"2025–2026, {author}"
version = release

extensions = [
    "alone",
    "mathml",
    "option_tables",
    "public_names",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
]
templates_path = ["_templates"]
exclude_patterns = ["_build"]
# A reference may be there for the reader, without a docstring that names it.
suppress_warnings = ["ref.citation"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autosummary_ignore_module_all = False
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"plantigrade {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sphinx = False
