"""Histograms of one quantity."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts.svg import (
    INK,
    SOFT,
    box,
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
SIZE = 340, 150  # [px] of the drawing


def histogram_plot(values: Float[Array, " n"], *, title: str, x_label: str) -> str:
    """Return a histogram with its median; the width of bins is that of Freedman and Diaconis.

    Args:
        values: Two or more values; those that are not finite are omitted.
        x_label: With its unit.
    """
    width, height = SIZE
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
    for tick in ticks_of(edges[0], edges[-1], 4):
        at = float(px(tick))
        parts.append(rule(at, at, bottom, bottom + 4, SOFT))
        parts.append(text_at(number_text(tick), at, bottom + 15, anchor="middle"))
    middle = float(np.median(values))
    parts.append(rule(float(px(middle)), float(px(middle)), top, bottom, INK, 1.4))
    parts.append(text_at(x_label, (left + right) / 2, height - 6, anchor="middle"))
    return "".join(parts) + "</svg>"
