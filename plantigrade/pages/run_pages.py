"""The pages of a run: ``report.html`` and ``viewer.html``.

The moving person at the head of a report is an image of its own, which keeps the names and styles
of the drawing apart from those of the page.
"""

from typing import Any
from urllib.parse import quote

import numpy as np

from plantigrade.analyze.pushes import push_intervals
from plantigrade.models import Human
from plantigrade.motion.motion import resampled
from plantigrade.pages.animation import moving_picture
from plantigrade.pages.headline import headline_figures, person_lines
from plantigrade.pages.playback import part_of, playback
from plantigrade.pages.scene import assumed_bodies, check, nearest, scene_model
from plantigrade.pages.section import ReportedRun, draw_all, page_html
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.cycles import SHOWN_ANGLES
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
HEIGHT_PX = 330  # [px] of the picture: verdict and tiles fit on the same screen
MAX_RATE = 15.0  # [Hz] key frames per second; a browser interpolates between them
MAX_KEY_FRAMES = 40  # about 150 kB and two seconds of computing for a dressed person
MAX_SHOWN = 3.0  # [s] of a motion that does not repeat
BEFORE_PUSH, BEFORE_FALL, AFTER_FALL = 0.5, 2.0, 0.8  # [s] shown around an event; chosen
MIN_MOTION = 0.1  # [s] below which nothing moves
SAFE = " !$'()*+,-./:;=?@[]^_`{|}~"  # characters that the data of an address may hold


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
    subject = ReportedRun(run)
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
            full for name in SHOWN_ANGLES for full in (name, f"{name}_r", f"{name}_l")
            if full in coordinates
        ),
        forces=ReportedRun(run).forces,
    )  # fmt: skip


def title_of_run(run: Run) -> str:
    """Return the heading of the pages of a run, by default the name of its folder."""
    return run.title or (run.folder.resolve().name if run.folder else "Run")


def _reference_words(record: Record) -> str:
    """Return what is drawn behind the body, in words; empty if nothing is."""
    name = next(iter(record.references), "")
    return REFERENCE_WORDS.get(name, name)


def _has_arrows(subject: ReportedRun) -> bool:
    total, cop = subject.side_forces
    if total is None or cop is None:
        return False
    return bool(np.any(total)) and bool(np.isfinite(cop).any())


def strip_of(
    subject: ReportedRun,
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


def _strip_frames(subject: ReportedRun) -> list[int]:
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


def moving_person(subject: ReportedRun) -> str:
    """Return the address (``data:``) of an animated SVG; empty for less than a moment of motion.

    A steady gait loops over one stride; a pushed or falling person is shown around that event, any
    other motion from its start.

    Raises:
        ParameterError: If the motion cannot be drawn.
    """
    record = subject.record
    if record.motion.n_frames < 2 or record.motion.duration < MIN_MOTION:
        return ""
    start, stop = shown_part(subject)
    shown = MAX_SHOWN if start is None or stop is None else stop - start
    picture = moving_picture(
        record,
        forces=subject.forces,
        foot="none",
        start=start,
        stop=stop,
        rate=min(MAX_RATE, MAX_KEY_FRAMES / shown),
        height_px=HEIGHT_PX,
    )
    svg = picture.svg.replace('"', "'")  # which an attribute in double quotes may hold
    return f"data:image/svg+xml,{quote(svg, safe=SAFE)}"


def shown_part(subject: ReportedRun) -> tuple[float | None, float | None]:
    """Return the first and last instant that are shown [s]; None twice for one stride."""
    time, fell = subject.record.motion.time, subject.number("fell_at_s")
    pushes = push_intervals(subject.record)
    first, last = float(time[0]), float(time[-1])
    if fell is not None:
        return max(first, fell - BEFORE_FALL), min(last, fell + AFTER_FALL)
    if pushes:
        strongest = max(pushes, key=lambda push: push.force)
        start = max(first, strongest.start - BEFORE_PUSH)
        return start, min(last, start + MAX_SHOWN)
    if last - first <= MAX_SHOWN or playback(subject.record).loop is not None:
        return None, None
    return first, first + MAX_SHOWN
