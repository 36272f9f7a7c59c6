"""Bar charts, timelines and histograms."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts.marks import Bar
from plantigrade.charts.svg import (
    GRID,
    INK,
    LETTER,
    SOFT,
    box,
    data_range,
    linear_scale,
    number_text,
    open_svg,
    rule,
    text_at,
    ticks_of,
    title_text,
)
from plantigrade.charts.theme import STROKE_MIDDLE as MIDDLE

MAX_BINS = 40  # Maximum number of bars; narrower ones are indistinguishable at the usual width
HISTOGRAM_SIZE = 340, 150  # [px]
TIMELINE_WIDTH = 1060  # [px] that of a page


def bar_plot(
    labels: Sequence[str],
    values: Sequence[float],
    *,
    title: str = "",
    x_label: str,
    tips: Sequence[float] = (),
    colours: Sequence[str] = (),
    notes: Sequence[str] = (),
    width: int = 500,
) -> str:
    """Return horizontal bars, one row per label.

    Args:
        values: Lengths of the bars; NaN leaves the row empty.
        x_label: With its unit.
        tips: A second value per row, drawn as a tick (the maximum, for example).
        colours: CSS colour per bar.
        notes: Text at the end of each row.
        width: Of the drawing [px].
    """
    row, top = 15, 30
    left = 24 + 6.2 * max((len(label) for label in labels), default=1)
    right = width - 16 - 5.4 * max((len(note) for note in notes), default=0)
    bottom = top + row * len(labels)
    high = data_range([np.asarray([*values, *tips, 0.0], float)], pad=0.04)[1]
    px = linear_scale(0.0, high, left, right)
    parts = [open_svg(width, bottom + 38, f"{title}, {x_label}"), title_text(title, 4)]
    for tick in ticks_of(0.0, high):
        at = px(tick)
        parts.append(rule(at, at, top, bottom, GRID))
        parts.append(text_at(number_text(tick), at, bottom + 13, anchor="middle"))
    parts.append(text_at(x_label, (left + right) / 2, bottom + 29, anchor="middle"))
    for i, (label, value) in enumerate(zip(labels, values, strict=True)):
        y = top + row * i
        parts.append(text_at(label, left - 6, y + 11, anchor="end", colour=INK))
        if np.isfinite(value):
            colour = colours[i] if colours else MIDDLE
            parts.append(box(left, y + 2.5, px(value) - left, row - 5, colour, ".85"))
        if len(tips) and np.isfinite(tips[i]):
            parts.append(rule(px(tips[i]), px(tips[i]), y + 2.5, y + row - 2.5, SOFT, 1.6))
        if len(notes):
            parts.append(text_at(notes[i], width - 6, y + 11, anchor="end"))
    return "".join(parts) + "</svg>"


def timeline_plot(
    rows: Sequence[tuple[str, Sequence[Bar]]], *, title: str = "", marks: Sequence[float] = ()
) -> str:
    """Return a timeline: rows of bars over one axis of time, with vertical lines at ``marks`` [s].

    Each row is its name and its bars.
    """
    width = TIMELINE_WIDTH
    row, top = 19, 28
    left = 16 + 5.9 * max((len(label) for label, _ in rows), default=1)
    right, bottom = width - 12, top + row * len(rows)
    ends = [v for _, bars in rows for bar in bars for v in (bar.start, bar.stop)]
    x0, x1 = data_range([np.asarray([*ends, *marks], float)], pad=0.0)
    px = linear_scale(x0, x1, left, right)
    parts = [open_svg(width, bottom + 38, title), title_text(title, 4)]
    for i in range(len(rows) + 1):
        parts.append(rule(left, right, top + row * i, top + row * i, GRID, 0.8))
    for i, (label, bars) in enumerate(rows):
        y = top + row * i
        parts.append(text_at(label, left - 6, y + 13, anchor="end", colour=INK))
        for bar in bars:
            a, b = float(px(bar.start)), float(px(bar.stop))
            wide = max(b - a, 0.8)
            parts.append(box(a, y + 3, wide, row - 6, bar.colour, f"{bar.opacity:g}"))
            if bar.label and b - a > LETTER * len(bar.label) + 6:
                parts.append(text_at(bar.label, (a + b) / 2, y + 13, anchor="middle", colour=INK))
    for mark in marks:
        at = float(px(mark))
        parts.append(
            f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top}" y2="{bottom}" '
            f'style="stroke:{SOFT}" stroke-dasharray="3 3" stroke-width="0.8" opacity="0.7"/>'
        )
    parts += _marked(ticks_of(x0, x1, max(3, round((right - left) / 80))), px, bottom)
    parts.append(text_at("time [s]", (left + right) / 2, bottom + 31, anchor="middle"))
    return "".join(parts) + "</svg>"


def histogram_plot(values: Float[Array, " n"], *, title: str, x_label: str) -> str:
    """Return a histogram with its median; the width of bins is that of Freedman and Diaconis.

    Args:
        values: Two or more values; those that are not finite are omitted.
        x_label: With its unit.
    """
    width, height = HISTOGRAM_SIZE
    values = values[np.isfinite(values)]
    edges = np.histogram_bin_edges(values, "fd")
    if not 2 <= len(edges) - 1 <= MAX_BINS:
        edges = np.histogram_bin_edges(values, 1 if len(edges) == 2 else MAX_BINS)
    counts, _ = np.histogram(values, edges)
    left, right, top, bottom = 40, width - 12, 28, height - 38
    px = linear_scale(edges[0], edges[-1], left, right)
    py = linear_scale(0.0, max(counts.max(), 1), bottom, top)
    parts = [open_svg(width, height, f"{title}, {x_label}"), title_text(title, 4)]
    for count, a, b in zip(counts, edges[:-1], edges[1:], strict=True):
        if count:
            y, wide = float(py(count)), max(float(px(b) - px(a)) - 1.0, 0.8)
            parts.append(box(float(px(a)) + 0.5, round(y, 1), wide, round(bottom - y, 1), MIDDLE,
                             ".7"))  # fmt: skip
    parts.append(rule(left, right, bottom, bottom, SOFT))
    parts.append(text_at(str(int(counts.max())), left - 6, top + 8, anchor="end"))
    parts.append(text_at("0", left - 6, bottom, anchor="end"))
    parts += _marked(ticks_of(edges[0], edges[-1], 4), px, bottom)
    middle = float(np.median(values))
    parts.append(rule(float(px(middle)), float(px(middle)), top, bottom, INK, 1.4))
    parts.append(text_at(x_label, (left + right) / 2, height - 6, anchor="middle"))
    return "".join(parts) + "</svg>"


def _marked(ticks: Iterable[float], px: Callable[..., Any], bottom: float) -> Iterator[str]:
    """Yield the ticks of a horizontal axis with their numbers."""
    for tick in ticks:
        at = float(px(tick))
        yield rule(at, at, bottom, bottom + 4, SOFT)
        yield text_at(number_text(tick), at, bottom + 15, anchor="middle")
