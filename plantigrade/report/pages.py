"""The pages of a run, whatever made it: ``report.html`` and ``viewer.html``."""

from typing import Any

import numpy as np

from plantigrade.motion.resample import resampled
from plantigrade.record import Run
from plantigrade.report.facts import facts_of
from plantigrade.report.page import page_html
from plantigrade.report.scene import check, nearest, scene_model
from plantigrade.report.section import Section, draw_all
from plantigrade.report.sections import SECTIONS
from plantigrade.report.sections.cycles import SHOWN
from plantigrade.report.strip import instants, strip_svg
from plantigrade.report.subject import Subject
from plantigrade.report.viewer import viewer_html

PICTURES = 8  # in the strip


def pages(run: Run) -> dict[str, str]:
    """Return ``report.html`` and ``viewer.html`` of a run, by file name.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    return {"report.html": report_html(run), "viewer.html": run_viewer(run)}


def report_html(run: Run, more: tuple[Section, ...] = ()) -> str:
    """Return the report as one page.

    The sections are those that the run has something for: forces, markers, references, signals.

    Args:
        run: The run.
        more: Further sections, drawn last.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    from markupsafe import Markup

    check(run.record)
    subject = Subject(run)
    provenance = run.metrics
    return page_html(
        "report.html",
        [*draw_all(SECTIONS, subject), *more],
        title=title_of_run(run),
        sentence=run.sentence,
        status=run.status,
        facts=facts_of(subject),
        notes=run.record.notes,
        strip=Markup(_strip(subject)),
        reference=next(iter(run.record.references), ""),
        arrows=_has_arrows(subject),
        figures=run.figures,
        provenance={
            name.replace("_", " "): provenance[name]
            for name in ("source_files", "version", "command", "settings", "seed")
        },
    )


def run_viewer(run: Run) -> str:
    """Return the page with the moving body.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    coordinates = run.record.motion.coordinates
    return viewer_html(
        run.record,
        title=title_of_run(run),
        subtitle=run.sentence,
        coordinates=tuple(
            full for name in SHOWN for full in (name, f"{name}_r", f"{name}_l")
            if full in coordinates
        ),
        forces=Subject(run).forces,
    )  # fmt: skip


def title_of_run(run: Run) -> str:
    """Return the heading of the pages of a run; the name of its folder where it has none."""
    return run.title or (run.folder.resolve().name if run.folder else "Run")


def _has_arrows(subject: Subject) -> bool:
    total, cop = subject.side_forces
    if total is None or cop is None:
        return False
    return bool(np.any(total)) and bool(np.isfinite(cop).any())


def _strip(subject: Subject) -> str:
    record = subject.record
    motion, frames = record.motion, _strip_frames(subject)
    drawn: dict[str, Any] = {}
    if _has_arrows(subject):
        here = nearest(subject.forces.motion.time, motion.time)
        drawn = {
            name: values[here]
            for name, values in zip(("force", "point"), subject.side_forces, strict=True)
            if values is not None
        }
    reference = next(iter(record.references.values()), None)
    return strip_svg(
        scene_model(record),
        motion.qpos,
        frames,
        time=motion.time,
        height_px=250,
        behind=None if reference is None else resampled(reference, motion.time).qpos,
        **drawn,
    )


def _strip_frames(subject: Subject) -> list[int]:
    """Return eight instants: of one right gait cycle where two heel strikes are known."""
    motion = subject.record.motion
    strikes = [e.time for e in motion.events if (e.side, e.kind) == ("r", "heel_strike")]
    inside = [t for t in strikes if motion.time[0] <= t <= motion.time[-1]]
    if len(inside) > 1:
        middle = (len(inside) - 1) // 2
        wanted = np.linspace(inside[middle], inside[middle + 1], PICTURES)
        frames = [int(np.argmin(np.abs(motion.time - t))) for t in wanted]
        if len(set(frames)) == PICTURES:
            return frames
    return instants(motion.n_frames, PICTURES)
