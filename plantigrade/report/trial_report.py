"""The report and the viewer of a fitted recording: a :class:`Trial` in words and curves."""

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.gait import GaitMeasures
from plantigrade.analyze.trial import SIDES, Trial
from plantigrade.motion import Table
from plantigrade.report.report import Measure, ReportData, report_html
from plantigrade.report.sections import CycleCurves, Norm
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
SAGITTAL = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
FORCE_AXES = {
    "up": "ground_force_up",
    "forward": "ground_force_forward",
    "left": "ground_force_left",
}


def trial_pages(trial: Trial, *, title: str, provenance: dict[str, object]) -> dict[str, str]:
    """Return ``report.html`` and ``viewer.html`` of a trial, by file name.

    Args:
        trial: The analysed recording.
        title: Heading of both pages.
        provenance: What the numbers came from, as it is to be read.
    """
    data = trial_data(trial, title=title, provenance=provenance)
    model = trial.fit.human.model
    return {
        "report.html": report_html(model, trial.record, data),
        "viewer.html": viewer_html(
            model, trial.record, title=title, subtitle=data.sentence, curves=_viewer_curves(trial)
        ),
    }


def trial_data(trial: Trial, *, title: str, provenance: dict[str, object]) -> ReportData:
    """Return what the report says about a trial."""
    speed_class = _speed_class(trial)
    cycled = bool(trial.cycles)
    return ReportData(
        title=title,
        sentence=_sentence(trial),
        facts=_facts(trial),
        angles=_curves(trial, trial.angles, SHOWN, "°") if cycled else (),
        moments=_curves(trial, trial.joint_moments, SAGITTAL, "N m/kg", "_moment"),
        powers=_curves(trial, trial.joint_powers, SAGITTAL, "W/kg", "_power"),
        forces=_curves(trial, trial.ground_forces, ("up", "forward", "left"), "body weights"),
        norms=_norms(speed_class),
        toe_off={s: trial.measures.stance[s].mean for s in SIDES if trial.measures.stance[s].count},
        measures=_measures(trial.measures, speed_class) if cycled else (),
        measures_source=norms.CITATION,
        provenance=provenance,
    )


def _sentence(trial: Trial) -> str:
    fit = trial.fit
    human, seconds = fit.human, fit.time[-1] - fit.time[0]
    what = {
        "markers": f"{len(fit.places)} markers",
        "skeleton": "the skeleton",
        "coordinates": "the joint coordinates",
    }[fit.source_kind]
    error = fit.metrics.get("marker_rms_mean_mm") or fit.metrics.get("joint_rms_mean_mm")
    text = (
        f"{what} of {fit.recording.source.name} ({len(fit.time)} frames, {seconds:.2f} s) on a "
        f"person of {human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees of "
        f"freedom and {human.feet} feet"
    )
    if error is not None:
        text += f"; mean error {error:.1f} mm"
    if trial.moments is not None:
        text += "; joint moments from the measured ground reactions"
    return text[0].upper() + text[1:] + "."


def _facts(trial: Trial) -> dict[str, str]:
    facts = {}
    m, metrics = trial.measures, trial.fit.metrics
    if m.speed.count:
        facts["walking speed"] = f"{m.speed.mean:.2f} m/s"
        facts["cadence"] = f"{m.cadence.mean:.0f} steps/min"
    if "marker_rms_mean_mm" in metrics:
        facts["marker error, RMS"] = f"{metrics['marker_rms_mean_mm']:.1f} mm"
    if "joint_rms_mean_mm" in metrics:
        facts["joint centre error, RMS"] = f"{metrics['joint_rms_mean_mm']:.1f} mm"
    for side, word in (("r", "right"), ("l", "left")):
        curves = trial.angles.get(f"knee_angle_{side}", np.empty((0, 1)))
        if len(curves):
            rom = float(np.nanmean(np.nanmax(curves, 1) - np.nanmin(curves, 1)))
            facts[f"{word} knee range"] = f"{rom:.0f}°"
    return facts


def _curves(trial, table, names, unit, suffix="") -> list[CycleCurves]:
    out = []
    for name in names:
        for full in (name, f"{name}_r", f"{name}_l"):
            values = table.get(full)
            if values is not None and len(values):
                out.append(CycleCurves(_named(full, suffix), trial.percent, values, unit))
    return out


def _named(name: str, suffix: str) -> str:
    """Put a suffix before the side: ``knee_angle_r`` → ``knee_angle_moment_r``."""
    plain, side = (name[:-2], name[-2:]) if name[-2:] in ("_l", "_r") else (name, "")
    plain = FORCE_AXES.get(plain, plain)
    return f"{plain}{suffix}{side}"


def _norms(speed_class: str) -> dict[str, Norm]:
    out = {}
    for name in norms.names():
        band = norms.norm(name, speed_class)
        out[name] = Norm(band.percent, band.mean, band.sd, "Schwartz 2008")
    return out


def _speed_class(trial: Trial) -> str:
    speed = trial.measures.speed
    if not speed.count:
        return "free"
    d = trial.fit.human.dimensions
    return norms.speed_class(speed.mean, d.thigh + d.shank + d.ankle_height)


def _measures(m: GaitMeasures, speed_class: str) -> list[Measure]:
    foot_off, both = norms.FOOT_OFF[speed_class], norms.DOUBLE_SUPPORT[speed_class]
    rows = [
        Measure("walking speed", "m/s", both=m.speed.mean),
        Measure("cadence", "steps/min", both=m.cadence.mean),
    ]
    for label, unit, table in (
        ("stride length", "m", m.stride_length),
        ("stride time", "s", m.stride_time),
        ("step length", "m", m.step_length),
        ("step time", "s", m.step_time),
        ("stance", "% of stride", m.stance),
        ("swing", "% of stride", m.swing),
    ):
        right, left = (table[s].mean if table[s].count else None for s in ("r", "l"))
        norm = f"{foot_off[0]} ± {foot_off[1]}" if label == "stance" else ""
        rows.append(Measure(label, unit, right=right, left=left, norm=norm))
    rows.append(Measure("step width", "m", both=m.step_width.mean))
    rows.append(
        Measure(
            "double support",
            "% of stride",
            both=m.double_support.mean,
            norm=f"{both[0]} ± {both[1]}",
        )
    )
    return rows


def _viewer_curves(trial: Trial) -> Table:
    names, values = trial.fit.human.to_coordinates(trial.record.motion.qpos)
    shown = [
        i for i, n in enumerate(names) if any(n == s or n in (f"{s}_r", f"{s}_l") for s in SHOWN)
    ]
    return Table(tuple(names[i] for i in shown), trial.record.motion.time, values[:, shown])


__all__ = ["trial_data", "trial_pages"]
