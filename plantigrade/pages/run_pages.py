"""The pages of a run: ``report.html`` and ``viewer.html``."""

from typing import Any

import numpy as np

from plantigrade.models import Human
from plantigrade.motion.resample import resampled
from plantigrade.pages.headline import headline_figures, person_lines
from plantigrade.pages.moving_person import moving_person
from plantigrade.pages.playback import part_of
from plantigrade.pages.scene import assumed_bodies, check, nearest, scene_model
from plantigrade.pages.section import Subject, draw_all, page_html
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.cycles import SHOWN
from plantigrade.pages.strip import instants, strip_svg
from plantigrade.pages.text import unbroken
from plantigrade.pages.verdict import verdict_sentence
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Record, Run
from plantigrade.record.scene_objects import scene_objects_of

STRIP_PICTURES = 8  # number of pictures in the strip
REFERENCE_WORDS = {
    "motion": "the motion that the controller follows",
    "recorded": "the recorded motion",
}
"""Reference motions that have a name of their own."""


def pages(run: Run) -> dict[str, str]:
    """Return ``report.html`` and ``viewer.html`` of a run, by file name.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    return {"report.html": report_html(run), "viewer.html": run_viewer(run)}


def report_html(run: Run) -> str:
    """Return the report page with all sections that the run has data for.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    from markupsafe import Markup

    check(run.record)
    subject = Subject(run)
    provenance = run.metrics
    return page_html(
        draw_all(SECTIONS, subject),
        title=title_of_run(run),
        sentence=run.sentence,
        status="ok",
        verdict=unbroken(verdict_sentence(subject)),
        good=run.ok,
        person=Markup(moving_person(subject)),
        who=person_lines(subject),
        facts={name: unbroken(value) for name, value in headline_figures(subject).items()},
        notes=run.record.notes,
        strip=Markup(strip_of(subject)),
        reference=_reference_words(run.record),
        arrows=_has_arrows(subject),
        footer="World axes: x forward, y left, z up. Signs of angles as in OpenSim.",
        provenance={
            name: provenance[name]
            for name in ("source_files", "version", "command", "settings", "seed")
        },
    )


def run_viewer(run: Run) -> str:
    """Return the viewer page.

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
    """Return the heading of the pages of a run, by default the name of its folder."""
    return run.title or (run.folder.resolve().name if run.folder else "Run")


def _reference_words(record: Record) -> str:
    """Return what is drawn behind the body, in words; empty if nothing is."""
    name = next(iter(record.references), "")
    return REFERENCE_WORDS.get(name, name)


def _has_arrows(subject: Subject) -> bool:
    total, cop = subject.side_forces
    if total is None or cop is None:
        return False
    return bool(np.any(total)) and bool(np.isfinite(cop).any())


def strip_of(
    subject: Subject,
    *,
    height_px: int = 250,
    background: str | None = None,
    view: str = "side",
    start: float | None = None,
    stop: float | None = None,
    solids: bool = False,
    x_ray: bool = False,
) -> str:
    """Return the picture strip of a run, over one right gait cycle if there is one.

    Args:
        height_px: Height of the picture [px].
        background: CSS colour of the background; none if None.
        view: One of :data:`~plantigrade.pages.camera.VIEWS`.
        start: First instant [s]; with neither ``start`` nor ``stop``, as above.
        stop: Last instant [s].
        solids: Whether the solids that physics sees are drawn in place of the skin.
        x_ray: Whether the bones of the feet are seen through the skin.

    Raises:
        ParameterError: If there is no such part or view.
    """
    record = subject.record
    motion = record.motion
    if start is None and stop is None:
        frames = _strip_frames(subject)
    else:
        begin, end = part_of(motion.time, start, stop)
        frames = list(nearest(motion.time, np.linspace(begin, end, STRIP_PICTURES)))
    forces: dict[str, Any] = {}
    force, point = subject.side_forces
    if force is not None and point is not None and _has_arrows(subject):
        here = nearest(subject.forces.motion.time, motion.time)
        forces = {"force": force[here], "point": point[here]}
    reference = next(iter(record.references.values()), None)
    return strip_svg(
        scene_model(record) if record.ground.seats else record.human.model,
        motion.qpos,
        frames,
        time=motion.time,
        height_px=height_px,
        pale=assumed_bodies(record),
        ground=record.ground,
        background=background,
        behind=None if reference is None else resampled(reference, motion.time).qpos,
        view=view,
        human=None if solids or type(record.human) is not Human else record.human,
        x_ray=x_ray,
        objects=scene_objects_of(record),
        **forces,
    )


def _strip_frames(subject: Subject) -> list[int]:
    """Return eight frames, over one right gait cycle if two heel strikes are known."""
    motion = subject.record.motion
    strikes = [e.time for e in motion.events if (e.side, e.kind) == ("r", "heel_strike")]
    inside = [t for t in strikes if motion.time[0] <= t <= motion.time[-1]]
    if len(inside) > 1:
        middle = (len(inside) - 1) // 2
        figures = np.linspace(inside[middle], inside[middle + 1], STRIP_PICTURES)
        frames = [int(np.argmin(np.abs(motion.time - t))) for t in figures]
        if len(set(frames)) == STRIP_PICTURES:
            return frames
    return instants(motion.n_frames, STRIP_PICTURES)
