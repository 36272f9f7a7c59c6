from plantigrade import __version__ as release

project = "plantigrade"
author = "The plantigrade developers"
copyright = f"2025, {author}"
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build"]
# A reference may be there for the reader, without a docstring that names it.
suppress_warnings = ["ref.citation"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"plantigrade {release}"
