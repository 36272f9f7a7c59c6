"""The report and the viewer of a run: a Record and its figures in words and curves."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.curves import GaitCurves, coordinates_of, gait_curves
from plantigrade.motion import Table
from plantigrade.record import Record
from plantigrade.report.report import Measure, ReportData, report_html
from plantigrade.report.sections import CycleCurves, Norm, Section
from plantigrade.report.viewer import viewer_html

SHOWN = (
    "pelvis_tilt",
    "pelvis_list",
    "pelvis_rotation",
    "hip_flexion",
    "hip_adduction",
    "hip_rotation",
    "knee_angle",
    "ankle_angle",
    "subtalar_angle",
    "mtp_angle",
    "lumbar_extension",
    "lumbar_bending",
    "lumbar_rotation",
    "arm_flex",
    "arm_add",
    "elbow_flex",
)
LOADED = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
FORCE_NAMES = {
    "up": "ground_force_up",
    "forward": "ground_force_forward",
    "left": "ground_force_sideways",
}
# Spatio-temporal measures: label, unit, stem of the key in the metrics, unit in the key.
BY_SIDE = (
    ("stride length", "m", "stride_length", "m"),
    ("stride time", "s", "stride_time", "s"),
    ("step length", "m", "step_length", "m"),
    ("step time", "s", "step_time", "s"),
    ("stance", "% of stride", "stance", "pct"),
    ("swing", "% of stride", "swing", "pct"),
)
WHOLE = (
    ("walking speed", "m/s", "walking_speed_m_s"),
    ("cadence", "steps/min", "cadence_steps_min"),
    ("step width", "m", "step_width_m"),
    ("double support", "% of stride", "double_support_pct"),
)


def run_pages(
    model: mujoco.MjModel,
    record: Record,
    *,
    title: str,
    sentence: str = "",
    extra: Sequence[Section] = (),
    first: Sequence[Section] = (),
    facts: dict[str, str] | None = None,
    reference: str = "reference",
) -> dict[str, str]:
    """Return ``report.html`` and ``viewer.html`` of a run, by file name.

    Args:
        model: The body.
        record: What happened, with the run's metrics.
        title: Heading of both pages.
        sentence: What was done.
        extra: More sections of the report.
        first: Sections of the report that come before all others.
        facts: Short figures shown large; those of the walk if absent.
        reference: What the other motion of the record is, where it has one.
    """
    data = run_data(model, record, title=title, sentence=sentence, extra=extra)
    data = replace(data, first=first, reference=reference)
    if facts is not None:
        data = replace(data, facts=facts)
    return {
        "report.html": report_html(model, record, data),
        "viewer.html": viewer_html(
            model,
            record,
            title=title,
            subtitle=sentence,
            curves=_viewer_curves(record),
            reference_label=reference.capitalize(),
        ),
    }


def run_data(
    model: mujoco.MjModel, record: Record, *, title: str, sentence: str = "", extra=()
) -> ReportData:
    """Return what the report says about a run."""
    metrics = record.metrics
    curves = gait_curves(model, record)
    speed_class = _speed_class(metrics)
    walks = bool(curves.cycles)
    stance = {s: metrics.get(f"stance_{s}_pct") for s in ("r", "l")}
    return ReportData(
        title=title,
        sentence=sentence,
        facts=_facts(metrics, curves),
        angles=_curves(curves, curves.angles, SHOWN, "°") if walks else (),
        moments=_curves(curves, curves.moments, LOADED, "N m/kg", "_moment"),
        powers=_curves(curves, curves.powers, LOADED, "W/kg", "_power"),
        forces=_curves(curves, curves.forces, tuple(FORCE_NAMES), "BW"),
        norms=_norms(speed_class),
        toe_off={s: v for s, v in stance.items() if v is not None},
        measures=_measures(metrics, speed_class) if walks else (),
        measures_source=norms.CITATION,
        provenance={
            "source files": metrics.get("source_files", {}),
            "version": metrics.get("version", ""),
            "command": metrics.get("command", ""),
            "settings": metrics.get("settings", {}),
        },
        extra=extra,
    )


def _facts(metrics: dict[str, Any], curves: GaitCurves) -> dict[str, str]:
    facts = {}
    for label, unit, key, digits in (
        ("walking speed", "m/s", "walking_speed_m_s", 2),
        ("cadence", "steps/min", "cadence_steps_min", 0),
        ("marker error, RMS", "mm", "marker_rms_mean_mm", 1),
        ("joint centre error, RMS", "mm", "joint_rms_mm", 1),
    ):
        if metrics.get(key) is not None:
            facts[label] = f"{metrics[key]:.{digits}f} {unit}"
    for side, word in (("r", "right"), ("l", "left")):
        rows = curves.angles.get(f"knee_angle_{side}", np.empty((0, 1)))
        if len(rows):
            rom = float(np.nanmean(np.nanmax(rows, 1) - np.nanmin(rows, 1)))
            facts[f"{word} knee range"] = f"{rom:.0f}°"
    return facts


def _curves(curves: GaitCurves, table, names, unit, suffix="") -> list[CycleCurves]:
    out = []
    for name in names:
        for full in (name, f"{name}_r", f"{name}_l"):
            values = table.get(full)
            if values is not None and len(values):
                out.append(CycleCurves(_named(full, suffix), curves.percent, values, unit))
    return out


def _named(name: str, suffix: str) -> str:
    """Put a suffix before the side: ``knee_angle_r`` → ``knee_angle_moment_r``."""
    plain, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
    return f"{FORCE_NAMES.get(plain, plain)}{suffix}{side}"


def _norms(speed_class: str) -> dict[str, Norm]:
    renamed = {"vertical_grf": "ground_force_up", "anterior_grf": "ground_force_forward"}
    renamed |= {
        f"{j}_power": f"{c}_power" for j, c in zip(("hip", "knee", "ankle"), _SAGITTAL, strict=True)
    }
    out = {}
    for name in norms.names():
        band = norms.norm(name, speed_class)
        out[renamed.get(name, name)] = Norm(band.percent, band.mean, band.sd, "Schwartz 2008")
    return out


_SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")


def _speed_class(metrics: dict[str, Any]) -> str:
    speed = metrics.get("walking_speed_m_s")
    legs = [metrics.get(f"length_{n}_m") for n in ("thigh", "shank", "ankle_height")]
    known = [float(v) for v in legs if v is not None]
    if speed is None or len(known) < len(legs):
        return "free"
    return norms.speed_class(speed, sum(known))


def _measures(metrics: dict[str, Any], speed_class: str) -> list[Measure]:
    foot_off, both = norms.FOOT_OFF[speed_class], norms.DOUBLE_SUPPORT[speed_class]
    published = {
        "stance": f"{foot_off[0]} ± {foot_off[1]}",
        "double support": f"{both[0]} ± {both[1]}",
    }
    rows = [
        Measure(label, unit, both=metrics.get(key), norm=published.get(label, ""))
        for label, unit, key in WHOLE
    ]
    for label, unit, stem, ending in BY_SIDE:
        right, left = (metrics.get(f"{stem}_{s}_{ending}") for s in ("r", "l"))
        rows.append(Measure(label, unit, right=right, left=left, norm=published.get(label, "")))
    return rows


def _viewer_curves(record: Record) -> Table:
    table = coordinates_of(record)
    wanted = {full for n in SHOWN for full in (n, f"{n}_r", f"{n}_l")}
    shown = [i for i, n in enumerate(table.names) if n in wanted]
    return Table(tuple(table.names[i] for i in shown), table.time, table.values[:, shown])


__all__ = ["run_data", "run_pages"]
