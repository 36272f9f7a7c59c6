"""Plots as small SVG drawings that follow the page's light or dark colours and print well.

Colours are CSS variables with a fallback, so a drawing also stands alone. Nothing is rasterised
and no plotting library is loaded: a report of forty plots takes milliseconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.report import theme

RIGHT = f"var(--right, {theme.RIGHT})"
LEFT = f"var(--left, {theme.LEFT})"
MIDDLE = f"var(--middle, {theme.MIDDLE})"
SIDES = {"r": RIGHT, "l": LEFT, None: MIDDLE, "": MIDDLE}
_SOFT, _GRID, _TEXT = "var(--soft, #64707f)", "var(--grid, #e3e7ec)", "var(--fg, #1c2430)"
TITLE, LETTER = 7.6, 5.6  # width of a letter of the title and of the legend, about [px]
_FONT = 'font-family="system-ui, sans-serif"'


@dataclass(frozen=True)
class Series:
    """One curve of a plot.

    Attributes:
        x: Where.
        y: How much; NaN breaks the curve.
        label: Its name in the legend; none where empty.
        colour: CSS colour.
        width: Of the stroke [px].
        opacity: Of the stroke.
        dash: SVG dash pattern; solid where empty.
    """

    x: Float[Array, " n"]
    y: Float[Array, " n"]
    label: str = ""
    colour: str = MIDDLE
    width: float = 1.8
    opacity: float = 1.0
    dash: str = ""


@dataclass(frozen=True)
class Band:
    """A shaded range of a plot.

    Attributes:
        x: Where.
        low: Lower edge.
        high: Upper edge.
        colour: CSS colour.
        opacity: Of the shade.
    """

    x: Float[Array, " n"]
    low: Float[Array, " n"]
    high: Float[Array, " n"]
    colour: str = MIDDLE
    opacity: float = 0.2


@dataclass(frozen=True)
class Bar:
    """A stretch of one row of a timeline.

    Attributes:
        start: Where it begins.
        stop: Where it ends.
        colour: CSS colour.
        label: Written into it where there is room.
        opacity: Of the colour.
    """

    start: float
    stop: float
    colour: str = MIDDLE
    label: str = ""
    opacity: float = 0.85


@dataclass(frozen=True)
class Outline:
    """A thick round stroke or a closed shape on a path plot, in its units.

    Attributes:
        points: Corners, or the ends of the stroke.
        colour: CSS colour.
        width: Of the stroke, in the plot's units; 0 fills the closed shape instead.
    """

    points: Float[Array, "n 2"]
    colour: str
    width: float = 0.0


def ticks_of(low: float, high: float, count: int = 5) -> list[float]:
    """Return round numbers between ``low`` and ``high``, about ``count`` of them.

    Example:
        >>> ticks_of(-12.0, 61.0)
        [0.0, 20.0, 40.0, 60.0]
    """
    if not high > low:
        return [low]
    raw = (high - low) / max(count - 1, 1)
    power = 10.0 ** np.floor(np.log10(raw))
    step = next(float(m * power) for m in (1, 2, 5, 10) if m * power >= raw * 0.999)
    first = int(np.ceil(low / step - 1e-9))
    return [round(k * step, 10) + 0.0 for k in range(first, int(np.floor(high / step + 1e-9)) + 1)]


def line_plot(
    series: Sequence[Series],
    *,
    title: str,
    x_label: str,
    y_label: str,
    bands: Sequence[Band] = (),
    marks: Sequence[tuple[float, str]] = (),
    width: int = 330,
    height: int = 210,
    zero: bool = False,
    least: float = 0.0,
    log: float = 0.0,
) -> str:
    """Return a line plot.

    Args:
        series: The curves.
        title: Above the plot.
        x_label: With its unit.
        y_label: With its unit.
        bands: Shaded ranges, drawn behind.
        marks: Vertical dashed lines: where, and in which colour (foot off).
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
    xs = [s.x for s in series] + [b.x for b in bands]
    ys = [s.y for s in series] + [b.low for b in bands] + [b.high for b in bands]
    x0, x1 = _range(xs, pad=0.0)
    y0, y1 = _range([*ys, np.zeros(1)] if zero else ys, pad=0.06, least=least)
    series = _told_apart(series, y1 - y0)
    left, right, bottom = 52, width - 10, height - 38
    second = _words(series) > right - left - TITLE * len(title)
    top = 40 if second else 26
    px = _scale(x0, x1, left, right)
    py = _scale(y0, y1, bottom, top)
    parts = [_open(width, height, f"{title}, {y_label} over {x_label}"), _title(title, left)]
    box = (left, right, top, bottom)
    parts += _axes(x0, x1, y0, y1, px, py, box, x_label, y_label, powers=log > 0)
    for band in bands:
        ok = np.isfinite(band.low) & np.isfinite(band.high)
        x = np.concatenate([band.x[ok], band.x[ok][::-1]])
        y = np.concatenate([band.high[ok], band.low[ok][::-1]])
        if len(x):
            parts.append(
                f'<path d="{_path(px(x), py(y))}Z" style="fill:{band.colour}" '
                f'opacity="{band.opacity}"/>'
            )
    for where, colour in marks:
        at = px(where)
        parts.append(
            f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top}" y2="{bottom}" '
            f'style="stroke:{colour}" stroke-dasharray="3 3" stroke-width="1"/>'
        )
    for s in series:
        dash = f' stroke-dasharray="{s.dash}"' if s.dash else ""
        parts.append(
            f'<path d="{_path(px(s.x), py(s.y))}" fill="none" style="stroke:{s.colour}" '
            f'stroke-width="{s.width}" opacity="{s.opacity}" stroke-linejoin="round"{dash}/>'
        )
    parts += _legend(series, right, 30 if second else 15)
    return "".join(parts) + "</svg>"


def _told_apart(series: Sequence[Series], height: float) -> list[Series]:
    """Return curves with those dashed that would hide another one under them.

    Args:
        series: The curves.
        height: What the vertical axis spans.
    """
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


def bar_plot(
    labels: Sequence[str],
    values: Sequence[float],
    *,
    title: str,
    x_label: str,
    tips: Sequence[float] = (),
    colours: Sequence[str] = (),
    notes: Sequence[str] = (),
    width: int = 500,
) -> str:
    """Return horizontal bars, one row per label.

    Args:
        labels: Names of the rows.
        values: Lengths of the bars; NaN leaves the row empty.
        title: Above the plot.
        x_label: With its unit.
        tips: A second figure per row, drawn as a tick (the largest, say).
        colours: CSS colour per bar.
        notes: Words at the end of each row.
        width: Of the drawing [px].
    """
    row, top = 15, 30
    left = 24 + 6.2 * max((len(label) for label in labels), default=1)
    right = width - 16 - 5.4 * max((len(note) for note in notes), default=0)
    bottom = top + row * len(labels)
    high = _range([np.asarray([*values, *tips, 0.0], float)], pad=0.04)[1]
    px = _scale(0.0, high, left, right)
    parts = [_open(width, bottom + 38, f"{title}, {x_label}"), _title(title, 4)]
    for tick in ticks_of(0.0, high):
        at = px(tick)
        parts.append(_line(at, at, top, bottom, _GRID))
        parts.append(_text(_number(tick), at, bottom + 13, anchor="middle"))
    parts.append(_text(x_label, (left + right) / 2, bottom + 29, anchor="middle"))
    for i, (label, value) in enumerate(zip(labels, values, strict=True)):
        y = top + row * i
        parts.append(_text(label, left - 6, y + 11, anchor="end", colour=_TEXT))
        if np.isfinite(value):
            colour = colours[i] if colours else MIDDLE
            parts.append(
                f'<rect x="{left:.1f}" y="{y + 2.5}" width="{px(value) - left:.1f}" '
                f'height="{row - 5}" rx="1.5" style="fill:{colour}" opacity=".85"/>'
            )
        if len(tips) and np.isfinite(tips[i]):
            parts.append(_line(px(tips[i]), px(tips[i]), y + 2.5, y + row - 2.5, _SOFT, 1.6))
        if len(notes):
            parts.append(_text(notes[i], width - 6, y + 11, anchor="end"))
    return "".join(parts) + "</svg>"


def timeline_plot(
    rows: Sequence[tuple[str, Sequence[Bar]]],
    *,
    title: str,
    x_label: str,
    marks: Sequence[float] = (),
    width: int = 1060,
) -> str:
    """Return what is on when: a row of bars for each thing, over one axis of time.

    Args:
        rows: Name of each row and its bars.
        title: Above the plot.
        x_label: With its unit.
        marks: Where thin upright lines are drawn.
        width: Of the drawing [px].
    """
    row, top = 19, 28
    left = 16 + 5.9 * max((len(label) for label, _ in rows), default=1)
    right, bottom = width - 12, top + row * len(rows)
    ends = [v for _, bars in rows for bar in bars for v in (bar.start, bar.stop)]
    x0, x1 = _range([np.asarray([*ends, *marks], float)], pad=0.0)
    px = _scale(x0, x1, left, right)
    parts = [_open(width, bottom + 38, title), _title(title, 4)]
    for i in range(len(rows) + 1):
        parts.append(_line(left, right, top + row * i, top + row * i, _GRID, 0.8))
    for i, (label, bars) in enumerate(rows):
        y = top + row * i
        parts.append(_text(label, left - 6, y + 13, anchor="end", colour=_TEXT))
        for bar in bars:
            a, b = float(px(bar.start)), float(px(bar.stop))
            parts.append(
                f'<rect x="{a:.1f}" y="{y + 3}" width="{max(b - a, 0.8):.1f}" '
                f'height="{row - 6}" rx="1.5" style="fill:{bar.colour}" '
                f'opacity="{bar.opacity:g}"/>'
            )
            if bar.label and b - a > LETTER * len(bar.label) + 6:
                parts.append(_text(bar.label, (a + b) / 2, y + 13, anchor="middle", colour=_TEXT))
    for mark in marks:
        at = float(px(mark))
        parts.append(
            f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top}" y2="{bottom}" '
            f'style="stroke:{_SOFT}" stroke-dasharray="3 3" stroke-width="0.8" opacity="0.7"/>'
        )
    for tick in ticks_of(x0, x1, max(3, round((right - left) / 80))):
        at = float(px(tick))
        parts.append(_line(at, at, bottom, bottom + 4, _SOFT))
        parts.append(_text(_number(tick), at, bottom + 15, anchor="middle"))
    parts.append(_text(x_label, (left + right) / 2, bottom + 31, anchor="middle"))
    return "".join(parts) + "</svg>"


def path_plot(
    series: Sequence[Series],
    *,
    title: str,
    x_label: str,
    y_label: str,
    outlines: Sequence[Outline] = (),
    width: int = 1060,
    max_height: int = 460,
    ground: bool = False,
) -> str:
    """Return paths in a plane, with one scale for both axes.

    Args:
        series: The paths.
        title: Above the plot.
        x_label: With its unit.
        y_label: With its unit.
        outlines: Shapes drawn behind (foot prints).
        width: Of the drawing [px].
        max_height: The drawing is narrowed where it would be higher [px].
        ground: Whether a line is drawn at zero height.
    """
    reach = [np.concatenate([o.points - o.width / 2, o.points + o.width / 2]) for o in outlines]
    xs, ys = [s.x for s in series], [s.y for s in series]
    x0, x1 = _range([*xs, *(r[:, 0] for r in reach)], pad=0.03, least=0.3)
    more = [np.zeros(1)] if ground else []
    y0, y1 = _range([*ys, *(r[:, 1] for r in reach), *more], pad=0.08, least=0.3)
    second = _words(series) > min(width, 400) - 62 - TITLE * len(title)
    left, top, below = 50, 42 if second else 28, 40
    scale = min((width - left - 12) / (x1 - x0), (max_height - top - below) / (y1 - y0))
    right, bottom = left + scale * (x1 - x0), top + scale * (y1 - y0)
    px, py = _scale(x0, x1, left, right), _scale(y0, y1, bottom, top)
    size = (max(round(right + 12), min(width, 400)), round(bottom + below))
    parts = [_open(*size, title), _title(title, left)]
    parts += _axes(x0, x1, y0, y1, px, py, (left, right, top, bottom), x_label, y_label)
    for o in outlines:
        d = _path(px(o.points[:, 0]), py(o.points[:, 1]))
        if o.width:
            parts.append(
                f'<path d="{d}" fill="none" stroke-linecap="round" style="stroke:{o.colour}" '
                f'stroke-width="{o.width * scale:.2f}" opacity=".22"/>'
            )
        else:
            parts.append(f'<path d="{d}Z" style="fill:{o.colour}" opacity=".22"/>')
    if ground:
        parts.append(_line(left, right, py(0.0), py(0.0), _SOFT, 1.4))
    for s in series:
        parts.append(
            f'<path d="{_path(px(s.x), py(s.y))}" fill="none" style="stroke:{s.colour}" '
            f'stroke-width="{s.width}" opacity="{s.opacity}" stroke-linejoin="round"/>'
        )
    parts += _legend(series, max(right, left + _words(series)), 32 if second else 15)
    return "".join(parts) + "</svg>"


def _range(arrays, *, pad: float, least: float = 0.0) -> tuple[float, float]:
    values = np.concatenate([np.asarray(a, float).ravel() for a in arrays] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    wider = max(pad * (high - low), (least - (high - low)) / 2, 0.0)
    if high - low + 2 * wider < 1e-9:
        wider = max(0.5 * abs(high), 0.5)
    return low - wider, high + wider


def _power(values, least: float) -> np.ndarray:
    """Return the power of ten of positive values, no less than that of ``least``."""
    return np.log10(np.maximum(np.asarray(values, float), least))


def _scale(a0: float, a1: float, b0: float, b1: float):
    slope = (b1 - b0) / (a1 - a0)
    return lambda a: b0 + slope * (np.asarray(a, dtype=float) - a0)


def _path(x, y) -> str:
    """Return SVG path data; NaN lifts the pen. Long curves are thinned to 800 points."""
    x, y = np.asarray(x), np.asarray(y)
    if len(x) > 1600:
        step = -(-len(x) // 800)
        x, y = x[::step], y[::step]
    text, pen = [], False
    for a, b in zip(x, y, strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            pen = False
            continue
        text.append(f"{'L' if pen else 'M'}{a:.1f} {b:.1f}")
        pen = True
    return "".join(text) or "M0 0"


def _axes(x0, x1, y0, y1, px, py, box, x_label, y_label, powers=False):
    left, right, top, bottom = box
    last = -1e9
    for tick in ticks_of(y0, y1, max(5 if bottom - top < 90 else 3, round((bottom - top) / 27))):
        if powers and tick != round(tick):
            continue
        at = float(py(tick))
        zero = abs(tick) < 1e-12 and not powers
        yield _line(left, right, at, at, _SOFT if zero else _GRID, 0.8)
        yield _text(
            _power_of_ten(tick) if powers else _number(tick), left - 6, at + 3.5, anchor="end"
        )
    for tick in ticks_of(x0, x1, max(3, round((right - left) / 60))):
        at = float(px(tick))
        yield _line(at, at, bottom, bottom + 4, _SOFT)
        if at - last > 24:
            yield _text(_number(tick), at, bottom + 15, anchor="middle")
            last = at
    yield (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" '
        f'height="{bottom - top:.1f}" fill="none" style="stroke:{_GRID}"/>'
    )
    yield _text(x_label, (left + right) / 2, bottom + 31, anchor="middle")
    middle = (top + bottom) / 2
    yield (
        f'<text transform="translate(12 {middle:.1f}) rotate(-90)" text-anchor="middle" '
        f'font-size="10.5" {_FONT} style="fill:{_SOFT}">{escape(y_label)}</text>'
    )


def _words(series) -> float:
    """Return the width of the legend [px]."""
    return sum(LETTER * len(label) + 28 for label in {s.label for s in series if s.label})


def _legend(series, right, y):
    """Yield the legend, ending at ``right``."""
    at = right
    for label, s in reversed({s.label: s for s in series if s.label}.items()):
        at -= LETTER * len(label)
        yield _text(label, at, y)
        at -= 18
        dash = f' stroke-dasharray="{s.dash}"' if s.dash else ""
        yield (
            f'<line x1="{at:.1f}" x2="{at + 14:.1f}" y1="{y - 3.5:.1f}" y2="{y - 3.5:.1f}" '
            f'style="stroke:{s.colour}" stroke-width="2.4"{dash}/>'
        )
        at -= 10


def _open(width: float, height: float, label: str) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="plot" role="img" '
        f'aria-label="{escape(label, quote=True)}" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">'
    )


def _title(text: str, x: float) -> str:
    return (
        f'<text x="{x}" y="16" font-size="12.5" font-weight="600" {_FONT} '
        f'style="fill:{_TEXT}">{escape(text)}</text>'
    )


def _text(text, x, y, *, anchor="start", size=10.5, colour=_SOFT) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" {_FONT} '
        f'style="fill:{colour}">{escape(str(text))}</text>'
    )


def _line(x1, x2, y1, y2, colour, width=1.0) -> str:
    return (
        f'<line x1="{x1:.1f}" x2="{x2:.1f}" y1="{y1:.1f}" y2="{y2:.1f}" '
        f'style="stroke:{colour}" stroke-width="{width}"/>'
    )


def _power_of_ten(exponent: float) -> str:
    """Return a power of ten as it is written.

    Example:
        >>> _power_of_ten(-3), _power_of_ten(0)
        ('10⁻³', '1')
    """
    if exponent == 0:
        return "1"
    return "10" + str(round(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _number(value: float) -> str:
    return f"{value:.6g}".replace("-", "−")
