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
    "notebooks",
    "option_tables",
    "public_names",
    "myst_nb",
    "sphinx_copybutton",
    "sphinx_design",
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

nb_execution_mode = "force"  # every notebook runs whenever the pages are built, and must succeed
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 600  # [s] for one cell; all of them take about a minute
nb_merge_streams = True
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

autodoc_member_order = "bysource"
autosummary_ignore_module_all = False
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"plantigrade {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_logo = "_static/logo.svg"
html_favicon = "_static/logo.svg"
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#1b6a9c",
        "color-brand-content": "#1b6a9c",
        "color-brand-visited": "#1b6a9c",
    },
    "dark_css_variables": {
        "color-brand-primary": "#7cc0ea",
        "color-brand-content": "#7cc0ea",
        "color-brand-visited": "#7cc0ea",
    },
}
html_show_sphinx = False
