"""Distances between recorded and fitted markers."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.charts import Figure, Series, bar_plot, line_plot
from plantigrade.charts.theme import STROKE_MIDDLE, STROKE_RIGHT
from plantigrade.pages.section import ReportedRun, Section
from plantigrade.record import Record
from plantigrade.record.signals import SIGNALS

TITLE = SIGNALS["markers.residual"].section


def marker_section(subject: ReportedRun) -> list[Section]:
    """Return the distances between recorded and fitted markers, per marker and per frame."""
    record = subject.record
    if record.recorded_markers is None or record.fitted_markers is None:
        return [Section(TITLE, missing="the recording has no markers.")]
    gap = 1000 * _distance(record.recorded_markers.positions, record)
    seen = np.isfinite(gap)
    if not seen.any():
        return [Section(TITLE, missing="no marker was both recorded and fitted.")]
    square = np.where(seen, gap, 0.0) ** 2
    error = float(np.nanmean(_over(1, gap, seen, square)[0]))
    text = (
        "Distance between each recorded marker and the same marker on the fitted body. The RMS "
        "marker error, root mean square over the markers of a frame and mean over the frames, is "
        f"{error:.1f} mm. Soft tissue artefact of millimetres to centimetres in walking (Leardini "
        "et al. 2005, Gait & Posture 21:212) makes distances of zero impossible."
    )
    bars = _per_marker(record.recorded_markers.names, gap, seen, square)
    curve = _per_frame(record.motion.time, gap, seen, square)
    figures = [
        Figure(bars, "The percentage is the share of frames in which the marker is visible."),
        Figure(curve, "An isolated peak indicates a swapped or stray marker."),
    ]
    return [Section(TITLE, figures, text=text, folded=True)]


def _distance(recorded: Array, record: Record) -> Array:
    """Return the distance between recorded and fitted markers [m].

    Residuals of the fit are preferred, because the filter of the motion after the fit moves markers
    by tenths of a millimetre.
    """
    assert record.fitted_markers is not None  # the section asks for them
    there = np.isfinite(recorded).all(axis=2)
    residual = record.signals.get("markers.residual")
    if residual is None or residual.shape != there.shape:
        residual = np.linalg.norm(recorded - record.fitted_markers, axis=2)
    return np.where(there, residual, np.nan)


def _per_marker(names, gap, seen, square) -> str:
    count = seen.sum(axis=0)
    rms, worst = _over(0, gap, seen, square)
    order = np.argsort(-np.nan_to_num(rms, nan=-1.0), kind="stable")
    return bar_plot(
        [names[i] for i in order],
        [float(rms[i]) for i in order],
        tips=[float(worst[i]) for i in order],
        colours=[STROKE_RIGHT] * len(order),
        notes=["never seen" if not count[i] else _share(count[i], len(gap)) for i in order],
        title="Per marker",
        x_label="distance, root mean square (tick: largest) [mm]",
        width=520,
    )


def _per_frame(time, gap, seen, square) -> str:
    rms, largest = _over(1, gap, seen, square)
    return line_plot(
        [
            Series(time, largest, "largest", STROKE_MIDDLE, 1.2, 0.8),
            Series(time, rms, "root mean square", STROKE_RIGHT, 2.0),
        ],
        title="Per frame",
        y_label="distance [mm]",
        width=520,
        height=260,
        zero=True,
    )


def _over(axis, gap, seen, square) -> tuple[np.ndarray, np.ndarray]:
    """Return RMS and maximum along an axis; NaN without visible markers."""
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(square.sum(axis=axis) / seen.sum(axis=axis))
    return rms, np.where(seen.any(axis=axis), np.where(seen, gap, -np.inf).max(axis=axis), np.nan)


def _share(count, total) -> str:
    """Return the share in percent, at most 99.9 % unless complete."""
    return "100 %" if count == total else f"{min(99.9, 100 * count / total):.3g} %"
