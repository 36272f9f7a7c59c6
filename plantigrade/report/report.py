"""``report.html``: what was done, the figures, the plots, where it all came from."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from plantigrade.motion import Table
from plantigrade.record import Record
from plantigrade.report.curves import panels_of
from plantigrade.charts import LEFT, MIDDLE, RIGHT, Series, line_plot
from plantigrade.report.scene import body_weight, check, side_forces
from plantigrade.report.sections import (
    LEAST,
    CycleCurves,
    Figure,
    Section,
    cycle_section,
    force_section,
    marker_section,
    moments_over_time,
    path_section,
    time_section,
)
from plantigrade.report.strip import instants, strip_svg
from plantigrade.report.theme import SIDE_NAMES
from plantigrade.report.viewer import template_text

LEG = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")


@dataclass(frozen=True)
class Measure:
    """One row of the table of spatio-temporal measures.

    Attributes:
        name: What was measured (``"stride length"``).
        unit: Its unit.
        right: Of the right side; None where it has none.
        left: Of the left side.
        both: Where the measure has no side.
        norm: Published value, as words (``"1.44 ± 0.12"``).
    """

    name: str
    unit: str
    right: float | None = None
    left: float | None = None
    both: float | None = None
    norm: str = ""


@dataclass(frozen=True)
class ReportData:
    """What a report says beyond its record; everything but the title may be left out.

    Attributes:
        title: Heading of the page.
        sentence: What was done, in one sentence.
        facts: Short figures shown large: name to value with unit.
        angles: Joint angles over the gait cycle [°].
        moments: Joint moments over the gait cycle, in the unit of each curve.
        powers: Joint powers over the gait cycle.
        forces: Ground reaction over the gait cycle.
        norms: Published values by coordinate, without side (``"knee_angle"``,
            ``"knee_angle_moment"``): a :class:`~plantigrade.report.sections.Norm` or a tuple
            ``(percent, mean, sd)``, in the unit of the curve.
        toe_off: Percent of the gait cycle at which each side's foot leaves the ground.
        curves: Curves over time where there are no gait cycles; every hinge where None.
        measures: Spatio-temporal measures.
        measures_source: Citation of their published values.
        strip: Frames of the picture strip; evenly spread where empty.
        extra: More sections, drawn after the others (an engine's own).
        first: More sections, drawn before the others: what the run was made for.
        reference: What the translucent body is.
        warnings: Besides those of the record.
        provenance: Source files with SHA-256, version, command, settings, as they are to be read.
    """

    title: str
    sentence: str = ""
    facts: dict[str, str] = field(default_factory=dict)
    angles: Sequence[CycleCurves] = ()
    moments: Sequence[CycleCurves] = ()
    powers: Sequence[CycleCurves] = ()
    forces: Sequence[CycleCurves] = ()
    norms: dict = field(default_factory=dict)
    toe_off: dict[str, float] = field(default_factory=dict)
    curves: Table | dict[str, np.ndarray] | None = None
    measures: Sequence[Measure] = ()
    measures_source: str = ""
    strip: Sequence[int] = ()
    extra: Sequence[Section] = ()
    first: Sequence[Section] = ()
    reference: str = "another motion of the same body"
    warnings: Sequence[str] = ()
    provenance: dict[str, object] = field(default_factory=dict)


def report_html(model: mujoco.MjModel, record: Record, data: ReportData) -> str:
    """Return the report as one page without any outside address.

    Sections for which there is nothing are left out and named in one line each.

    Args:
        model: The body.
        record: What happened.
        data: What to say about it.

    Raises:
        ParameterError: If the record does not fit the model.
    """
    from jinja2 import Environment
    from markupsafe import Markup

    check(model, record)
    sections = list(_sections(model, record, data))
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        template_text("report.html")
    )
    return template.render(
        data=data,
        css=Markup(template_text("report.css")),
        strip=Markup(_strip(model, record, data)),
        ghost=data.reference if record.reference_qpos is not None else "",
        arrows=record.contact_force is not None and bool(np.any(record.contact_force)),
        status=str(record.metrics.get("status", "ok")),
        warnings=list(dict.fromkeys([*record.warnings, *data.warnings])),
        sections=[section for section in sections if not section.missing],
        missing=[section for section in sections if section.missing],
        markup=Markup,
        metrics=metric_rows(record.metrics),
        provenance=provenance_rows({**_known(record.metrics), **data.provenance}),
        anchor=anchor,
    )


def _sections(model, record, data):
    yield from data.first
    if data.angles:
        yield cycle_section(
            "Joint angles over the gait cycle",
            data.angles,
            data.norms,
            data.toe_off,
            caption="From one heel strike of a foot (0 %) to its next (100 %).",
            missing="",
        )
    else:
        yield time_section(model, record, data.curves)
    if data.forces:
        yield cycle_section(
            "Ground reaction over the gait cycle",
            data.forces,
            data.norms,
            data.toe_off,
            caption="Force of the ground on the foot, in body weights (BW).",
            missing="",
        )
    yield force_section(model, record)
    yield _moments(model, record, data)
    yield cycle_section(
        "Joint powers",
        data.powers,
        data.norms,
        data.toe_off,
        caption="Joint moment times joint speed: positive where muscles give energy to the body, "
        "negative where they take it up.",
        missing="joint powers need measured or computed forces and whole gait cycles.",
    )
    yield marker_section(record)
    yield path_section(model, record)
    yield _measures(data)
    yield from data.extra


def _moments(model, record, data) -> Section:
    if data.moments:
        return cycle_section(
            "Joint moments",
            data.moments,
            data.norms,
            data.toe_off,
            caption="Internal moments, made by the body's own muscles and ligaments; positive in "
            "the direction in which the joint angle is positive.",
            missing="",
        )
    table = moments_over_time(model, record)
    if table is None:
        return Section("Joint moments", missing="no forces were measured, so no joint moments.")
    panels = panels_of({f"{name} [N m]": table[name] for name in table.names}, len(table.time))
    legs = [p for p in panels if p.lines[0].label and _is_leg(p.title)] or list(panels[:12])
    if not panels:
        return Section(
            "Joint moments", missing="no foot had a force of its own measured, so no joint moments."
        )
    colours = {"right": RIGHT, "left": LEFT}
    figures = [
        Figure(
            line_plot(
                [
                    Series(table.time, line.values, line.label, colours.get(line.label, MIDDLE))
                    for line in panel.lines
                ],
                title=f"{panel.title} moment",
                x_label="time [s]",
                y_label="[N m]",
                zero=True,
                least=LEAST["N m"],
            )
        )
        for panel in legs
    ]
    return Section(
        "Joint moments",
        figures,
        text="Internal moments over time, made by the body's own muscles and ligaments.",
    )


def _is_leg(title: str) -> bool:
    from plantigrade.report.theme import title_of

    return title in {title_of(name) for name in LEG}


def _measures(data) -> Section:
    if not data.measures:
        return Section(
            "Spatio-temporal measures",
            missing="no whole gait cycle was found, so no step or stride could be measured.",
        )
    sided = any(m.right is not None or m.left is not None for m in data.measures)
    norm = any(m.norm for m in data.measures)
    headers = ["measure", *(["right", "left"] if sided else []), "both" if sided else "value"]
    headers += ["unit", *(["published"] if norm else [])]
    rows = []
    for m in data.measures:
        row = [m.name, *([_figure(m.right), _figure(m.left)] if sided else []), _figure(m.both)]
        rows.append([*row, m.unit, *([m.norm] if norm else [])])
    text = (
        "A step goes from one foot's heel strike to the other's, a stride to the same foot's next."
    )
    if norm and data.measures_source:
        text += f" Published values: {data.measures_source}."
    return Section("Spatio-temporal measures", headers=headers, rows=rows, text=text)


def _strip(model, record, data) -> str:
    frames = list(data.strip) or _strip_frames(record)
    force, point = record.contact_force, record.contact_point
    if force is not None and point is not None and force.shape[1] > 2:  # many places: one a foot
        force, point = side_forces(record, body_weight(model))
    return strip_svg(
        model,
        record.motion.qpos,
        frames,
        time=record.motion.time,
        force=force if point is not None else None,
        point=point,
        height_px=250,
        behind=record.reference_qpos,
    )


def _strip_frames(record) -> list[int]:
    """Return eight instants: of one right gait cycle where two heel strikes are known."""
    time = record.motion.time
    strikes = [
        e.time
        for e in record.motion.events
        if e.kind == "heel_strike" and e.side == "r" and time[0] <= e.time <= time[-1]
    ]
    if len(strikes) > 1:
        middle = (len(strikes) - 1) // 2
        wanted = np.linspace(strikes[middle], strikes[middle + 1], 8)
        frames = [int(np.argmin(np.abs(time - t))) for t in wanted]
        if len(set(frames)) == 8:
            return frames
    return instants(record.motion.n_frames, 8)


def metric_rows(metrics: dict) -> list[tuple[str, str]]:
    """Return the flat figures of a run as rows of name and value, as they are to be read."""
    hidden = set(_known(metrics)) | {"status", "title", "sentence", "warnings"}
    return [
        (_label(key), _figure(value))
        for key, value in metrics.items()
        if key not in hidden and isinstance(value, (int, float, str, bool, np.number))
    ]


UNITS = {
    "deg": "°", "rad": "rad", "mm": "mm", "cm": "cm", "m": "m", "s": "s", "ms": "ms", "hz": "Hz",
    "us": "µs", "n": "N", "nm": "N m", "kg": "kg", "w": "W", "j": "J", "percent": "%",
    "bw": "body weight", "mps": "m/s", "spm": "steps/min", "mb": "MB", "pct": "%",
    "m_s": "m/s", "steps_min": "steps/min", "nm_kg": "N m/kg", "w_kg": "W/kg",
}  # fmt: skip


def _label(key: str) -> str:
    """Return a metric's key as words, its unit in brackets.

    Example:
        >>> _label("knee_rom_error_r_deg"), _label("walking_speed_m_s"), _label("frames")
        ('knee rom error right [°]', 'walking speed [m/s]', 'frames')
    """
    words = key.split("_")
    unit = next((n for n in (2, 1) if len(words) > n and "_".join(words[-n:]) in UNITS), 0)
    name = " ".join(SIDE_NAMES.get(word, word) for word in words[: len(words) - unit])
    return f"{name} [{UNITS['_'.join(words[-unit:])]}]" if unit else name


def _known(metrics: dict) -> dict:
    names = ("source_files", "version", "command", "settings", "seed")
    return {name: metrics[name] for name in names if metrics.get(name) not in (None, {}, [])}


def provenance_rows(values: dict) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return provenance as rows: a name and either one value or pairs below it."""
    rows = []
    for name, value in values.items():
        label = str(name).replace("_", " ")
        if isinstance(value, dict):
            rows.append((label, [(str(k), _flat(v)) for k, v in value.items()]))
        elif isinstance(value, (list, tuple)):
            rows.append((label, [("", _flat(v)) for v in value]))
        else:
            rows.append((label, [("", _flat(value))]))
    return rows


def _flat(value) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{k}: {_flat(v)}" for k, v in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_flat(v) for v in value)
    return "–" if value is None else str(value)


def _figure(value) -> str:
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, str, np.integer)):
        return str(value)
    if not math.isfinite(value):
        return "–"
    text = f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return text.replace("-", "−")


def anchor(title: str) -> str:
    """Return the address of a section within its page."""
    return "".join(c if c.isalnum() else "-" for c in title.lower()).strip("-")
