"""Sections of a report, the data they require of a run, and the page they form.

Pages contain no external addresses.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, wraps
from importlib import resources
from typing import Any

from plantigrade.analyze import norms
from plantigrade.analyze.at_limit import at_limit, cycles_at_limit
from plantigrade.analyze.clinical import (
    NormChoice,
    clinical_angles,
    norms_for,
    number_of,
    usual_walk,
)
from plantigrade.analyze.curves import GaitCurves, gait_curves
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.arrays import Array
from plantigrade.charts import Figure
from plantigrade.constants import SIDES
from plantigrade.pages.scene import side_forces
from plantigrade.pages.text import anchor, provenance_rows
from plantigrade.record import Record, Run


class ReportedRun:
    """A run with cached results that several sections use.

    ``forces`` is the record whose forces are shown: that of the motion moved by forces if the run
    has one, else ``record``.
    """

    def __init__(self, run: Run):
        """Store the run, its record and its figures."""
        self.run, self.record = run, run.record
        self.figures: Mapping[str, Any] = run.figures
        self.forces: Record = run.with_forces

    @cached_property
    def angle_curves(self) -> GaitCurves:
        """Joint angles over the gait cycle."""
        return gait_curves(self.record)

    @cached_property
    def clinical_angles(self) -> dict[str, Array]:
        """Angles of both sides over the gait cycle, including pelvis and foot progression."""
        return clinical_angles(self.record, self.angle_curves)

    @cached_property
    def force_curves(self) -> GaitCurves:
        """Forces, moments and powers over the gait cycle."""
        same = self.forces is self.record
        return self.angle_curves if same else gait_curves(self.forces)

    @property
    def assumed(self) -> tuple[str, ...]:
        """Coordinates that are assumed, not measured."""
        figure = self.figures.get("assumed_joints")
        return tuple(map(str, figure)) if isinstance(figure, list) else ()

    @cached_property
    def limited_frames(self) -> dict[str, Array]:
        """Joints often at a limit, with the frames."""
        return at_limit(self.record)

    @cached_property
    def limited_percents(self) -> dict[str, Array]:
        """Joints often at a limit, with the percentages of the gait cycle."""
        return cycles_at_limit(self.record, self.angle_curves.cycles)

    @cached_property
    def comparison(self) -> Comparison:
        """Comparison of the motion with the recorded one."""
        return compare(self.record)

    @cached_property
    def side_forces(self) -> tuple[Array | None, Array | None]:
        """Ground reactions [N] and centres of pressure [m] of right, left and unknown side."""
        return side_forces(self.forces)

    @property
    def walks(self) -> bool:
        """Whether there is a complete gait cycle."""
        return bool(self.angle_curves.cycles)

    @property
    def foot_off(self) -> dict[str, float]:
        """Side → foot off [% of the gait cycle]."""
        stance = {side: self.number(f"stance_{side}_pct") for side in SIDES}
        return {side: value for side, value in stance.items() if value is not None}

    @cached_property
    def norm_choice(self) -> NormChoice:
        """Norms for the person, and the reason for their choice."""
        return norms_for(self.record, self.figures)

    @property
    def population(self) -> norms.Population:
        """Population of the norms."""
        return self.norm_choice.population

    @property
    def speed_class(self) -> str:
        """Speed class of the norms of children."""
        return self.norm_choice.speed_class

    @property
    def runs(self) -> bool:
        """Whether the person runs."""
        return bool(self.figures.get("running", False))

    @property
    def has_norms(self) -> bool:
        """Whether there are norms: the user's, or those of walking forward."""
        return self.population.own or usual_walk(self.figures)

    def number(self, key: str) -> float | None:
        """Return a figure of the run; None if it is unknown."""
        return number_of(self.figures, key)

    def text_signal(self, name: str, count: int = 0) -> tuple[str, ...]:
        """Return a signal of words; ``count`` empty ones where the record has no such signal."""
        return tuple(str(word) for word in self.record.signals.get(name, ("",) * count))


Draw = Callable[[ReportedRun], "Section | list[Section]"]


@dataclass(frozen=True)
class Group:
    """A small table of a section."""

    title: str
    headers: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """One part of a report."""

    title: str  #: Heading
    figures: Sequence[Figure] = ()  #: Plots
    text: str = ""  #: Text before the plots
    headers: Sequence[str] = ()  #: Headers of the table
    rows: Sequence[Sequence[str]] = field(default_factory=tuple)  #: Rows of the table
    groups: Sequence[Group] = ()  #: Small tables side by side
    #: Rows of plots, or of texts in their place, with a row of column headings
    grid: Sequence[Sequence[Figure | str]] = ()
    sheet: bool = False  #: Whether it belongs to the first page in print
    folded: bool = False  #: Whether it is folded at first; in print every section is open
    missing: str = ""  #: Reason why there is nothing to show; the report then has one line


def needs(
    *signals: str, reference: str = "", planned: bool = False
) -> Callable[[Draw], Callable[[ReportedRun], list[Section]]]:
    """Decorate a function that draws sections with the data it requires of a run.

    Args:
        reference: Name of a required reference motion, for a motion of at least two frames.
        planned: Whether planned contact and forces are required.
    """

    def decorate(draw: Draw) -> Callable[[ReportedRun], list[Section]]:
        @wraps(draw)
        def drawn(subject: ReportedRun) -> list[Section]:
            record = subject.record
            there = all(name in record.signals for name in signals)
            beside = reference in record.references and record.motion.n_frames > 1
            there &= not reference or beside
            there &= not planned or (record.has_forces and record.contact_planned is not None)
            return draw_all([draw], subject) if there else []

        return drawn

    return decorate


def draw_all(sections: Iterable[Draw], subject: ReportedRun) -> list[Section]:
    """Return all sections for which a run has data."""
    found = [draw(subject) for draw in sections]
    return [s for part in found for s in ([part] if isinstance(part, Section) else part)]


def page_html(
    sections: Sequence[Section], *, provenance: Mapping[str, Any], **variables: Any
) -> str:
    """Return a page as one text; ``variables`` are the other variables of ``report.html``.

    Sections without content get one line each.
    """
    from markupsafe import Markup

    return rendered(
        "report.html",
        css=Markup(template_text("report.css")),
        script=Markup(template_text("report.js")),
        sections=[section for section in sections if not section.missing],
        missing=[section for section in sections if section.missing],
        provenance=provenance_rows(provenance),
        markup=Markup,
        anchor=anchor,
        **variables,
    )


def rendered(template: str, **variables: Any) -> str:
    """Return a packaged template with its variables filled in."""
    from jinja2 import Environment, FunctionLoader

    loader = FunctionLoader(template_text)
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, loader=loader)
    return environment.get_template(template).render(**variables)


def svg_of(template: str, **variables: Any) -> str:
    """Return a packaged template of a drawing with its variables filled in, in one line."""
    return rendered(template, **variables).replace("\n", "")


def template_text(name: str) -> str:
    """Return the text of the packaged template ``name``."""
    return (resources.files("plantigrade.pages") / "templates" / name).read_text("utf-8")
