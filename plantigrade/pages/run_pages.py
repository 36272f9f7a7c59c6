"""The pages of a run: ``report.html`` and ``viewer.html``."""

from typing import Any

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.motion.resample import resampled
from plantigrade.pages.playback import part_of
from plantigrade.pages.scene import assumed_bodies, check, nearest, scene_model
from plantigrade.pages.section import Section, Subject, draw_all, page_html
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.cycles import SHOWN
from plantigrade.pages.strip import instants, strip_svg
from plantigrade.pages.text import rounded_text
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Run

STRIP_PICTURES = 8  # number of pictures in the strip
FIT_FIGURES = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("running speed", " m/s", "running_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("RMS marker error", " mm", "marker_rms_mean_mm", 1),
    ("RMS joint centre error", " mm", "joint_rms_mm", 1),
)
SIMULATION_FIGURES = (
    ("fell at", " s", "fell_at_s", 2),
    ("speed", " m/s", "speed_m_s", 2),
    ("speed of the recording", " m/s", "recorded_speed_m_s", 2),
    ("steps", "", "landings", 0),
    ("tracking error, RMS", "°", "tracking_error_rms_deg", 1),
    ("trunk lean, mean", "°", "trunk_lean_mean_deg", 1),
    ("distance from path, maximum", " m", "astray_max_m", 2),
    ("vertical force, peak", " BW", "vertical_force_max_bw", 2),
    ("motor torque, peak", " %", "motor_torque_max_pct", 0),
)
REPRODUCTION_FIGURES = (
    ("range of motion error, mean", "°", "rom_error_mean_deg", 1),
    ("range of motion error, maximum", "°", "rom_error_max_deg", 1),
    ("centre of mass error, maximum", " mm", "com_error_max_mm", 1),
    ("contact drift, maximum", " mm", "contact_drift_max_mm", 1),
    ("lowest point of the soles", " mm", "sole_lowest_mm", 1),
    ("vertical force error, RMS", " BW", "vertical_force_rmse_bw", 3),
)
SYNTHESIS_FIGURES = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("distance", " m", "displacement_m", 2),
    ("duration", " s", "duration_s", 2),
    ("rise in flight", " m", "flight_rise_m", 2),
    ("take-off speed", " m/s", "take_off_speed_m_s", 2),
    ("knee range", "°", "knee_angle_range_r_deg", 0),
    ("vertical force, peak", " BW", "ground_force_max_bw", 2),
    ("cost of transport", "", "cost_of_transport", 2),
)


def pages(run: Run) -> dict[str, str]:
    """Return ``report.html`` and ``viewer.html`` of a run, by file name.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    return {"report.html": report_html(run), "viewer.html": run_viewer(run)}


def report_html(run: Run, more: tuple[Section, ...] = ()) -> str:
    """Return the report page with all sections that the run has data for, then ``more``.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    from markupsafe import Markup

    check(run.record)
    subject = Subject(run)
    provenance = run.metrics
    return page_html(
        [*draw_all(SECTIONS, subject), *more],
        title=title_of_run(run),
        sentence=run.sentence,
        status=run.status,
        who=person_lines(subject),
        facts=headline_figures(subject),
        notes=run.record.notes,
        strip=Markup(strip_of(subject)),
        reference=next(iter(run.record.references), ""),
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
        subject: The run.
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


def person_lines(subject: Subject) -> list[str]:
    """Return lines on the person, the model, and the norms of the gait."""
    human, age, figures = subject.record.human, subject.number("age_years"), subject.figures
    name, sex, date = (figures.get(key) for key in ("subject_name", "sex", "recorded_on"))
    known = [f"Subject {name}"] if name else []
    known += [str(sex)] if sex else []
    known += [f"{age:.3g} years"] if age is not None else []
    known += [f"body height {human.height:.2f} m", f"mass {human.mass:.1f} kg"]
    known += [f"recorded on {date}"] if date else []
    known += [f"{human.model.nv} degrees of freedom, {human.feet} feet"]
    who = subject.norm_choice
    if subject.walks and (who.population.own or not subject.runs):
        known += [f"compared with {who.population.name}, {who.reason}"]
    return known


def headline_figures(subject: Subject) -> dict[str, str]:
    """Return names and values of the headline figures."""
    signals = subject.record.signals
    if "check.quantity" in signals:
        verdict = {"verdict": "passed" if subject.run.ok else "failed"}
        found = verdict | _facts_from(subject, SYNTHESIS_FIGURES)
        if "walking speed" in found:
            found.pop("distance", None)
        return found
    if "tasks.names" in signals:
        return _facts_from(subject, REPRODUCTION_FIGURES)
    if subject.run.kind == "simulate":
        return _facts_from(subject, SIMULATION_FIGURES)
    found = _facts_from(subject, FIT_FIGURES[:3]) | _both_sides(subject)
    return found | _facts_from(subject, FIT_FIGURES[3:])


def _both_sides(subject: Subject) -> dict[str, str]:
    """Return step length, Gait Profile Score and range of the knee, right and left."""
    found, usual = {}, rounded_text(subject.number("gps_reference_deg"), 1)
    for name, unit, key, digits in (
        ("step length, right and left", " m", "step_length_{}_m", 2),
        (f"Gait Profile Score (usual: {usual}°)", "°", "gps_{}_deg", 1),
    ):
        sides = [subject.number(key.format(side)) for side in SIDES]
        if any(value is not None for value in sides):
            found[name] = " / ".join(rounded_text(value, digits) for value in sides) + unit
    ranges = []
    for side in SIDES:
        rows = subject.angle_curves.angles.get(f"knee_angle_{side}", np.empty((0, 1)))
        spans = np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1) if len(rows) else [np.nan]
        ranges.append(rounded_text(float(np.mean(spans)), 0))
    if ranges != ["–", "–"]:
        found["knee range, right and left"] = " / ".join(ranges) + "°"
    return found


def _facts_from(subject: Subject, figures: tuple[tuple[str, str, str, int], ...]) -> dict[str, str]:
    return {
        name: f"{rounded_text(value, digits)}{unit}"
        for name, unit, key, digits in figures
        if (value := subject.number(key)) is not None
    }
