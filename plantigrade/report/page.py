"""``report.html`` and ``study.html`` from sections: pages without any outside address."""

from collections.abc import Mapping, Sequence
from importlib import resources
from typing import Any

from plantigrade.report.section import Section
from plantigrade.report.text import anchor, figure_rows, provenance_rows


def page_html(
    template: str,
    sections: Sequence[Section],
    *,
    figures: Mapping[str, Any],
    provenance: Mapping[str, Any],
    **words: Any,
) -> str:
    """Return a page as one text.

    Args:
        template: File name of the template.
        sections: What the page shows; those without anything to show are named in a line each.
        figures: All figures of the run.
        provenance: Where it comes from.
        words: What else the template asks for.
    """
    from jinja2 import Environment
    from markupsafe import Markup

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(template_text(template)).render(
        css=Markup(template_text("report.css")),
        sections=[section for section in sections if not section.missing],
        missing=[section for section in sections if section.missing],
        figures=figure_rows(figures),
        provenance=provenance_rows(provenance),
        markup=Markup,
        anchor=anchor,
        **words,
    )


def template_text(name: str) -> str:
    """Return the text of the packaged template ``name``."""
    return (resources.files("plantigrade.report") / "templates" / name).read_text("utf-8")
