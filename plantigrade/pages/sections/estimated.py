"""Estimated ground reactions, joint moments and powers, with their uncertainty bands."""

from dataclasses import dataclass

import numpy as np

from plantigrade.analyze.curves import LOADED_JOINTS, nothing_measured
from plantigrade.analyze.statistics import mean_sd
from plantigrade.arrays import Array
from plantigrade.charts import Figure, Ribbon, line_plot
from plantigrade.charts.labels import MIN_SPANS, axis_label
from plantigrade.charts.theme import STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.motion.cycles import PERCENT, normalise_cycles
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.sections.ground import AXES
from plantigrade.pages.sections.recorded import pair_series
from plantigrade.pages.text import sided_title
from plantigrade.record import Record
from plantigrade.record.signals import SIGNALS

FORCES, MOMENTS = (SIGNALS[f"forces.{name}"].section for name in ("band", "moment_band"))
POWERS = "Estimated joint powers"
MAX_POINTS = 400  # points of a curve over time, about its width in pixels


@dataclass(frozen=True)
class _Estimate:
    """A curve over the frames: estimate, half-width of its band, measured value or NaN."""

    title: str
    label: str
    side: str
    value: Array
    half: Array
    measured: Array
    least: float


@needs("forces.measured", "forces.band", "forces.moment_band")
def estimated_section(subject: ReportedRun) -> list[Section]:
    """Return the estimates over the gait cycle, or over time without cycles."""
    record = subject.record
    if not record.has_forces or record.qfrc_actuator is None:
        return []
    forces, (moments, powers) = _forces(record), _moments(record)
    return [
        Section(title, [_figure(subject, one) for one in found], text=text, folded=True)
        for title, text, found in (
            (FORCES, _words(subject, "Ground reaction on each foot in body weights"), forces),
            (MOMENTS, _words(subject, "Internal moments per body mass"), moments),
            (POWERS, _words(subject, "Joint moment times angular velocity per body mass"), powers),
        )
        if found
    ]


def _words(subject: ReportedRun, what: str) -> str:
    """Return the legend."""
    text = f"{what}. Full line: estimated from the motion, not measured; shade: its 90 % band"
    text += ", mean over gait cycles" if subject.walks else ""
    if "measured.force" in subject.record.signals:
        return (
            text + ". Violet dashes: measured by the plates, which were withheld from the estimate."
        )
    if nothing_measured(subject.record):
        return text + ". No plate measured anything here."
    return text + ". Violet dashes: measured by a plate."


def _forces(record: Record) -> list[_Estimate]:
    found, band = [], record.signals["forces.band"]
    withheld = record.signals.get("measured.force")
    for axis, name in AXES.items():
        for k, side in enumerate(SIDES):
            foot = record.foot(side)
            value = foot.force[:, axis] / record.weight
            seen = np.where(foot.measured, value, np.nan)
            found.append(
                _Estimate(
                    f"{SIDE_NAMES[side].capitalize()}, {name}",
                    "[BW]",
                    side,
                    np.where(foot.known & ~foot.measured, value, np.nan),
                    band[:, k, axis] / record.weight,
                    seen if withheld is None else withheld[:, k, axis] / record.weight,
                    MIN_SPANS["BW"],
                )
            )
    return found


def _moments(record: Record) -> tuple[list[_Estimate], list[_Estimate]]:
    """Return moments and powers of the joints of both legs."""
    motion, mass, band = record.motion, record.human.mass, record.signals["forces.moment_band"]
    names = [str(name) for name in record.signals.get("measured.moment_names", ())]
    moments, powers = [], []
    for stem in LOADED_JOINTS:
        for side in SIDES:
            name, foot = f"{stem}_{side}", record.foot(side)
            if name not in record.human.coordinates:
                continue
            value, half = record.torque(name) / mass, band[:, 6 + motion.hinge(name)] / mass
            seen = np.where(foot.measured, value, np.nan)
            if names:
                seen = np.full(motion.n_frames, np.nan)
                if name in names:
                    seen = record.signals["measured.moment"][:, names.index(name)]
            value = np.where(foot.known & ~foot.measured, value, np.nan)
            speed = motion.velocity(name)
            for found, kind, unit, by in (
                (moments, "moment", "N m/kg", np.ones_like(speed)),
                (powers, "power", "W/kg", speed),
            ):
                found.append(
                    _Estimate(
                        sided_title(name),
                        axis_label(f"{stem}_{kind}", unit),
                        side,
                        value * by,
                        half * np.abs(by),
                        seen * by,
                        MIN_SPANS.get(unit, 0.0),
                    )
                )
    return moments, powers


def _figure(subject: ReportedRun, one: _Estimate) -> Figure:
    """Return one plot of the estimate with its band, and the measured curve."""
    motion = subject.record.motion
    step = -(-motion.n_frames // MAX_POINTS)
    x, curves = motion.time[::step], tuple(y[::step] for y in (one.value, one.half, one.measured))
    x_label = "time [s]"
    if subject.walks:
        cycles = [c for c in subject.angle_curves.cycles if c.side == one.side]
        x, x_label = PERCENT, "gait cycle [%]"
        frames = (one.value, one.half, one.measured)
        curves = tuple(mean_sd(normalise_cycles(motion.time, y, cycles))[0] for y in frames)
    value, half, measured = curves
    series = pair_series(x, value, measured, one.side, ("estimated", "measured"))
    known = np.concatenate([s.y[np.isfinite(s.y)] for s in series] or [np.zeros(1)])
    low, high = known.min(initial=0.0), known.max(initial=0.0)
    room = high - low  # wider bands are clipped, so that the curves remain visible
    lower, upper = (np.clip(y, low - room, high + room) for y in (value - half, value + half))
    drawn = line_plot(
        series,
        bands=[Ribbon(x, lower, upper, STROKES[one.side], 0.22)],
        title=one.title,
        x_label=x_label,
        y_label=one.label,
        zero=True,
        least=one.least,
    )
    return Figure(drawn)
