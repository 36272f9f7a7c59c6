"""Curves over one axis, and paths in a plane."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from plantigrade.charts.marks import Outline, Ribbon, Series
from plantigrade.charts.svg import (
    SOFT,
    TITLE,
    axes,
    box,
    curve,
    data_range,
    hatching,
    legend,
    legend_width,
    linear_scale,
    open_svg,
    path_data,
    rule,
    title_text,
)

MIN_SHADE = 1.5  # minimum width of a shaded stretch [px]
MIN_MARK_DISTANCE = 2.0  # upright lines nearer than this are drawn in turns [px]


def line_plot(
    series: Sequence[Series],
    *,
    title: str = "",
    x_label: str = "time [s]",
    y_label: str,
    bands: Sequence[Ribbon] = (),
    marks: Sequence[tuple[float, str]] = (),
    ticks: Sequence[tuple[float, str]] = (),
    spans: Sequence[tuple[float, float, str]] = (),
    shades: Sequence[tuple[float, float, str]] = (),
    width: int = 330,
    height: int = 210,
    zero: bool = False,
    least: float = 0.0,
    log: float = 0.0,
) -> str:
    """Return a line plot.

    Args:
        x_label: With its unit.
        y_label: With its unit.
        bands: Shaded ranges, drawn behind.
        marks: Vertical dashed lines: where, and in which colour (foot off).
        ticks: Short lines at the upper edge, likewise (events of the other foot).
        spans: Thick lines along the lower edge: from, to, and in which colour.
        shades: Shaded stretches as high as the plot, likewise (pushes).
        width: Of the drawing [px].
        height: Of the drawing [px].
        zero: Whether zero must lie on the vertical axis.
        least: The vertical axis spans at least this much, so that stillness looks still.
        log: If positive the vertical axis counts powers of ten, from this value on: what is
            smaller is drawn there.
    """
    if log > 0:
        series = [replace(s, y=_power(s.y, log)) for s in series]
        bands = [replace(b, low=_power(b.low, log), high=_power(b.high, log)) for b in bands]
    ys = [s.y for s in series] + [b.low for b in bands] + [b.high for b in bands]
    x0, x1 = data_range([each.x for each in (*series, *bands)], pad=0.0)
    y0, y1 = data_range([*ys, np.zeros(1)] if zero else ys, pad=0.06, least=least)
    series = _distinguishable(series, y1 - y0)
    left, right, bottom = 52, width - 10, height - 38
    second = legend_width(series) > right - left - TITLE * len(title)
    top = 40 if second else 26
    px, py = linear_scale(x0, x1, left, right), linear_scale(y0, y1, bottom, top)
    parts = [open_svg(width, height, f"{title}, {y_label} over {x_label}"), title_text(title, left)]
    frame = (left, right, top, bottom)
    parts += axes(x0, x1, y0, y1, px, py, frame, x_label, y_label, powers=log > 0)
    parts += [_stretch(*shade, px, top, bottom) for shade in shades]
    parts += [_shade(band, px, py) for band in bands]
    for k, s in enumerate(series):
        parts += hatching(s, px, frame, rising=k % 2 == 0)
    parts += _mark_lines(marks, px, top, bottom)
    parts += [rule(px(x), px(x), top, top + 6, colour, 1.4) for x, colour in ticks]
    parts += [box(px(a), bottom - 4, px(b) - px(a), 4, colour, "0.9") for a, b, colour in spans]
    parts += [curve(s, px, py) for s in series]
    parts += legend(series, right, 30 if second else 15)
    return "".join(parts) + "</svg>"


def _stretch(start: float, stop: float, colour: str, px, top: float, bottom: float) -> str:
    """Return a shaded stretch as high as the plot."""
    wide = max(float(px(stop) - px(start)), MIN_SHADE)
    return (
        f'<rect class="shade" x="{float(px(start)):.1f}" y="{top}" width="{wide:.1f}" '
        f'height="{bottom - top}" style="fill:{colour}" opacity="0.22"/>'
    )


def _shade(band: Ribbon, px, py) -> str:
    """Return a shaded range; nothing if it is unknown everywhere."""
    ok = np.isfinite(band.low) & np.isfinite(band.high)
    x = np.concatenate([band.x[ok], band.x[ok][::-1]])
    y = np.concatenate([band.high[ok], band.low[ok][::-1]])
    if not len(x):
        return ""
    return (
        f'<path d="{path_data(px(x), py(y))}Z" style="fill:{band.colour}" '
        f'opacity="{band.opacity}"/>'
    )


def _mark_lines(marks: Sequence[tuple[float, str]], px, top: float, bottom: float) -> Iterator[str]:
    """Yield dashed vertical lines, with alternating dashes where two would hide each other."""
    for k, (where, colour) in enumerate(marks):
        at = float(px(where))
        near = any(abs(float(px(other)) - at) < MIN_MARK_DISTANCE for other, _ in marks[:k])
        shift = ' stroke-dashoffset="4"' if near else ""
        yield (
            f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top}" y2="{bottom}" '
            f'style="stroke:{colour}" stroke-dasharray="4 4"{shift} stroke-width="1"/>'
        )


def _distinguishable(series: Sequence[Series], height: float) -> list[Series]:
    """Return curves, dashed where they would hide another; ``height`` is that of the axis."""
    out: list[Series] = []
    for s in series:
        hides = not s.dash and any(
            not o.dash
            and o.colour != s.colour
            and len(o.y) == len(s.y)
            and np.array_equal(np.isfinite(o.y), np.isfinite(s.y))
            and np.nanmax(np.abs(o.y - s.y), initial=0.0) < 0.004 * height
            for o in out
        )
        out.append(replace(s, dash="7 7") if hides else s)
    return out


def _power(values, least: float) -> np.ndarray:
    """Return the power of ten of positive values, no less than that of ``least``."""
    return np.log10(np.maximum(np.asarray(values, float), least))


def path_plot(
    series: Sequence[Series],
    *,
    title: str,
    x_label: str = "forward [m]",
    y_label: str,
    outlines: Sequence[Outline] = (),
    width: int = 1060,
    max_height: int = 460,
    ground: bool = False,
) -> str:
    """Return paths in a plane, with one scale for both axes.

    Args:
        x_label: With its unit.
        y_label: With its unit.
        outlines: Shapes in the background (footprints).
        width: Of the drawing [px].
        max_height: Maximum height; higher drawings are scaled down [px].
        ground: Whether a line is drawn at zero height.
    """
    reach = [np.concatenate([o.points - o.width / 2, o.points + o.width / 2]) for o in outlines]
    xs, ys = [s.x for s in series], [s.y for s in series]
    x0, x1 = data_range([*xs, *(r[:, 0] for r in reach)], pad=0.03, least=0.3)
    more = [np.zeros(1)] if ground else []
    y0, y1 = data_range([*ys, *(r[:, 1] for r in reach), *more], pad=0.08, least=0.3)
    second = legend_width(series) > min(width, 400) - 62 - TITLE * len(title)
    left, top, below = 50, 42 if second else 28, 40
    scale = min((width - left - 12) / (x1 - x0), (max_height - top - below) / (y1 - y0))
    right, bottom = left + scale * (x1 - x0), top + scale * (y1 - y0)
    px, py = linear_scale(x0, x1, left, right), linear_scale(y0, y1, bottom, top)
    size = (max(round(right + 12), min(width, 400)), round(bottom + below))
    parts = [open_svg(*size, title), title_text(title, left)]
    parts += axes(x0, x1, y0, y1, px, py, (left, right, top, bottom), x_label, y_label)
    for o in outlines:
        d = path_data(px(o.points[:, 0]), py(o.points[:, 1]))
        if o.width:
            parts.append(
                f'<path d="{d}" fill="none" stroke-linecap="round" style="stroke:{o.colour}" '
                f'stroke-width="{o.width * scale:.2f}" opacity=".22"/>'
            )
        else:
            parts.append(f'<path d="{d}Z" style="fill:{o.colour}" opacity=".22"/>')
    if ground:
        parts.append(rule(left, right, py(0.0), py(0.0), SOFT, 1.4))
    parts += [curve(s, px, py) for s in series]
    parts += legend(series, max(right, left + legend_width(series)), 32 if second else 15)
    return "".join(parts) + "</svg>"
