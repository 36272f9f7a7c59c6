"""Sections of a report, what they require of a run, and the page they form.

No page holds an outside address.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, wraps
from importlib import resources
from typing import Any

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.at_limit import at_limit, cycles_at_limit
from plantigrade.analyze.clinical import Compared, clinical_angles, compared_with
from plantigrade.analyze.curves import GaitCurves, gait_curves
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.arrays import Array
from plantigrade.charts import Figure
from plantigrade.constants import SIDES
from plantigrade.pages.scene import side_forces
from plantigrade.pages.text import anchor, provenance_rows
from plantigrade.record import Record, Run


class Subject:
    """A run, its record and figures, and what is computed from them once.

    ``forces`` is the record whose forces are shown: the run's own, or the motion moved by forces
    that lies beside it; equal to ``record`` where there is none.
    """

    def __init__(self, run: Run):
        """Take what there is."""
        self.run, self.record = run, run.record
        self.figures: Mapping[str, Any] = run.figures
        self.forces: Record = run.with_forces

    @cached_property
    def angle_curves(self) -> GaitCurves:
        """Joint angles over the gait cycle."""
        return gait_curves(self.record)

    @cached_property
    def clinical_angles(self) -> dict[str, Array]:
        """Angles of both sides over the gait cycle, pelvis and foot progression too."""
        return clinical_angles(self.record, self.angle_curves)

    @cached_property
    def force_curves(self) -> GaitCurves:
        """Forces, moments and powers over the gait cycle."""
        same = self.forces is self.record
        return self.angle_curves if same else gait_curves(self.forces)

    @property
    def assumed(self) -> tuple[str, ...]:
        """Coordinates that the recording does not show."""
        figure = self.figures.get("assumed_joints")
        return tuple(map(str, figure)) if isinstance(figure, list) else ()

    @cached_property
    def held(self) -> dict[str, Array]:
        """Joints that are often at a limit, and in which frames."""
        return at_limit(self.record)

    @cached_property
    def held_in_cycles(self) -> dict[str, Array]:
        """Joints that are often at a limit, and at which percents of the gait cycle."""
        return cycles_at_limit(self.record, self.angle_curves.cycles)

    @cached_property
    def comparison(self) -> Comparison:
        """The motion beside the recorded one."""
        return compare(self.record)

    @cached_property
    def side_forces(self) -> tuple[Array | None, Array | None]:
        """Ground reaction and centre of pressure of right foot, left foot, unknown side [N, m]."""
        return side_forces(self.forces)

    @property
    def walks(self) -> bool:
        """Whether there is a whole gait cycle."""
        return bool(self.angle_curves.cycles)

    @property
    def foot_off(self) -> dict[str, float]:
        """Side → percent of the gait cycle at which its foot leaves the ground."""
        stance = {side: self.number(f"stance_{side}_pct") for side in SIDES}
        return {side: value for side, value in stance.items() if value is not None}

    @cached_property
    def compared(self) -> Compared:
        """Whom the person is compared with, and why."""
        return compared_with(self.record, self.figures)

    @property
    def population(self) -> norms.Population:
        """Whom the person is compared with."""
        return self.compared.population

    @property
    def speed_class(self) -> str:
        """The class of walking speed whose published values of children are shown."""
        return self.compared.speed_class

    @property
    def runs(self) -> bool:
        """Whether the person runs, so that no norm of walking is any measure of it."""
        return bool(self.figures.get("running", False))

    def number(self, key: str) -> float | None:
        """Return a figure of the run; None where it is not known."""
        value = self.figures.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            return None
        return float(value) if np.isfinite(float(value)) else None

    def words(self, name: str, count: int = 0) -> tuple[str, ...]:
        """Return a signal of words; ``count`` empty ones where the record has no such signal."""
        return tuple(str(word) for word in self.record.signals.get(name, ("",) * count))


Draw = Callable[[Subject], "Section | list[Section]"]


@dataclass(frozen=True)
class Group:
    """A small table among others."""

    title: str
    headers: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Section:
    """One part of a report.

    Attributes:
        title: Its heading.
        figures: Drawings.
        text: Before the drawings.
        headers: Of its table.
        rows: Of its table.
        groups: Small tables side by side.
        grid: Rows of drawings, or of words where there is none, under one heading for each column.
        sheet: Whether it is part of the first page on paper.
        folded: Whether only its heading is seen at first; on paper every section is open.
        missing: Why there is nothing to show; then it is one line of the report.
    """

    title: str
    figures: Sequence[Figure] = ()
    text: str = ""
    headers: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = field(default_factory=tuple)
    groups: Sequence[Group] = ()
    grid: Sequence[Sequence[Figure | str]] = ()
    sheet: bool = False
    folded: bool = False
    missing: str = ""


def needs(
    *signals: str, reference: str = "", planned: bool = False
) -> Callable[[Draw], Callable[[Subject], list[Section]]]:
    """Mark a function that draws sections with the data it requires of a run.

    Args:
        signals: Names of signals of the record; all must be there.
        reference: Name of a reference motion; the motion must have two frames to compare.
        planned: Whether contact must have been planned, and forces be known.
    """

    def decorate(draw: Draw) -> Callable[[Subject], list[Section]]:
        @wraps(draw)
        def drawn(subject: Subject) -> list[Section]:
            record = subject.record
            there = all(name in record.signals for name in signals)
            beside = reference in record.references and record.motion.n_frames > 1
            there &= not reference or beside
            there &= not planned or (record.has_forces and record.contact_planned is not None)
            return draw_all([draw], subject) if there else []

        return drawn

    return decorate


def draw_all(sections: Iterable[Draw], subject: Subject) -> list[Section]:
    """Return every section that a run has data for."""
    found = [draw(subject) for draw in sections]
    return [s for part in found for s in ([part] if isinstance(part, Section) else part)]


def page_html(
    sections: Sequence[Section],
    *,
    provenance: Mapping[str, Any],
    **words: Any,
) -> str:
    """Return a page as one text; ``words`` is what else ``report.html`` asks for.

    Sections without anything to show are named in a line each.
    """
    from jinja2 import Environment
    from markupsafe import Markup

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(template_text("report.html")).render(
        css=Markup(template_text("report.css")),
        script=Markup(template_text("report.js")),
        sections=[section for section in sections if not section.missing],
        missing=[section for section in sections if section.missing],
        provenance=provenance_rows(provenance),
        markup=Markup,
        anchor=anchor,
        **words,
    )


def template_text(name: str) -> str:
    """Return the text of the packaged template ``name``."""
    return (resources.files("plantigrade.pages") / "templates" / name).read_text("utf-8")
