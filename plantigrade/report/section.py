"""A part of a report, and what it needs of a run."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import wraps

from plantigrade.charts import Figure
from plantigrade.report.subject import Subject

Draw = Callable[[Subject], "Section | list[Section]"]


@dataclass(frozen=True)
class Section:
    """One part of a report.

    Attributes:
        title: Its heading.
        figures: Drawings.
        text: Before the drawings.
        headers: Of its table.
        rows: Of its table.
        missing: Why there is nothing to show; then it is one line of the report.
    """

    title: str
    figures: Sequence[Figure] = ()
    text: str = ""
    headers: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = field(default_factory=tuple)
    missing: str = ""


def needs(
    *signals: str, reference: str = "", planned: bool = False
) -> Callable[[Draw], Callable[[Subject], list[Section]]]:
    """Mark a function that draws sections with what a run must have for them.

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
            if not there:
                return []
            found = draw(subject)
            return [found] if isinstance(found, Section) else list(found)

        return drawn

    return decorate


def draw_all(
    sections: Iterable[Callable[[Subject], list[Section]]], subject: Subject
) -> list[Section]:
    """Return every section that a run has something for."""
    return [section for draw in sections for section in draw(subject)]
