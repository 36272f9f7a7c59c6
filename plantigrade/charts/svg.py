"""Elements of plots in SVG: scales, axes, legend, text."""

from collections.abc import Iterator
from html import escape
from math import isfinite

import numpy as np

SOFT, GRID, INK = "var(--soft, #64707f)", "var(--grid, #e3e7ec)", "var(--fg, #1c2430)"
TITLE, LETTER = 7.6, 5.6  # mean width of a letter of title and legend [px]
HATCH = 7  # distance of hatching lines [px]
MAX_POINTS = 800  # of a curve: one or two for every pixel of a plot
_FONT = 'font-family="system-ui, sans-serif"'


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


def data_range(arrays, *, pad: float, least: float = 0.0) -> tuple[float, float]:
    """Return the range of finite values, widened by a share ``pad`` and to ``least``."""
    values = np.concatenate([np.asarray(a, float).ravel() for a in arrays] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    wider = max(pad * (high - low), (least - (high - low)) / 2, 0.0)
    if high - low + 2 * wider < 1e-9:
        wider = max(0.5 * abs(high), 0.5)
    return low - wider, high + wider


def linear_scale(a0: float, a1: float, b0: float, b1: float):
    """Return the linear function that maps ``a0`` to ``b0`` and ``a1`` to ``b1``."""
    slope = (b1 - b0) / (a1 - a0)
    return lambda a: b0 + slope * (np.asarray(a, dtype=float) - a0)


def path_data(x, y) -> str:
    """Return SVG path data; NaN lifts the pen. Long curves are thinned to :data:`MAX_POINTS`."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) > MAX_POINTS:
        step = -(-len(x) // MAX_POINTS)
        x, y = x[::step], y[::step]
    text, pen = [], False
    for a, b in zip(x.tolist(), y.tolist(), strict=True):
        if not (isfinite(a) and isfinite(b)):
            pen = False
            continue
        text.append(f"{'L' if pen else 'M'}{a:.1f} {b:.1f}")
        pen = True
    return "".join(text) or "M0 0"


def axes(x0, x1, y0, y1, px, py, box, x_label, y_label, powers=False) -> Iterator[str]:
    """Yield frame, grid, ticks and labels of a plot in ``box`` (left, right, top, bottom)."""
    left, right, top, bottom = box
    last = -1e9
    for tick in ticks_of(y0, y1, max(5 if bottom - top < 90 else 3, round((bottom - top) / 27))):
        if powers and tick != round(tick):
            continue
        at = float(py(tick))
        zero = abs(tick) < 1e-12 and not powers
        yield rule(left, right, at, at, SOFT if zero else GRID, 0.8)
        yield text_at(
            power_of_ten(tick) if powers else number_text(tick), left - 6, at + 3.5, anchor="end"
        )
    for tick in ticks_of(x0, x1, max(3, round((right - left) / 60))):
        at = float(px(tick))
        yield rule(at, at, bottom, bottom + 4, SOFT)
        if at - last > 24:
            yield text_at(number_text(tick), at, bottom + 15, anchor="middle")
            last = at
    yield (
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" '
        f'height="{bottom - top:.1f}" fill="none" style="stroke:{GRID}"/>'
    )
    yield text_at(x_label, (left + right) / 2, bottom + 31, anchor="middle")
    middle = (top + bottom) / 2
    yield (
        f'<text transform="translate(12 {middle:.1f}) rotate(-90)" text-anchor="middle" '
        f'font-size="10.5" {_FONT} style="fill:{SOFT}">{escape(y_label)}</text>'
    )


def legend_width(series) -> float:
    """Return the width of the legend [px]."""
    return sum(LETTER * len(label) + 28 for label in {s.label for s in series if s.label})


def legend(series, right, y):
    """Yield the legend, ending at ``right``."""
    at = right
    for label, s in reversed({s.label: s for s in series if s.label}.items()):
        at -= LETTER * len(label)
        yield text_at(label, at, y)
        at -= 18
        dash = f' stroke-dasharray="{s.dash}"' if s.dash else ""
        yield (
            f'<line x1="{at:.1f}" x2="{at + 14:.1f}" y1="{y - 3.5:.1f}" y2="{y - 3.5:.1f}" '
            f'style="stroke:{s.colour}" stroke-width="2.4"{dash}/>'
        )
        at -= 10


def box(x, y, width, height, colour, opacity) -> str:
    """Return a bar with slightly rounded corners."""
    return (
        f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{height}" rx="1.5" '
        f'style="fill:{colour}" opacity="{opacity}"/>'
    )


def curve(s, px, py) -> str:
    """Return a series as a path."""
    dash = f' stroke-dasharray="{s.dash}"' if s.dash else ""
    return (
        f'<path d="{path_data(px(s.x), py(s.y))}" fill="none" style="stroke:{s.colour}" '
        f'stroke-width="{s.width}" opacity="{s.opacity}" stroke-linejoin="round"{dash}/>'
    )


def hatching(s, px, box, *, rising: bool) -> Iterator[str]:
    """Yield oblique lines over the stretches of a series that are hatched, as high as the plot.

    Lines, not an SVG pattern: browsers do not draw patterns defined in a folded section.
    """
    if s.hatched is None or not np.any(s.hatched):
        return
    left, right, top, bottom = box
    edges = np.flatnonzero(np.diff(np.r_[0, np.asarray(s.hatched, int), 0]))
    tall = bottom - top
    for first, stop in edges.reshape(-1, 2):
        a, b = (float(px(s.x[k])) for k in (first, stop - 1))
        a, b = max(left, a - 1), min(right, b + 1)
        lines = []
        for foot in np.arange(left - tall, right, HATCH):
            x0, x1 = max(a, foot), min(b, foot + tall)
            if x1 > x0:
                y0, y1 = bottom - (x0 - foot), bottom - (x1 - foot)
                if not rising:
                    y0, y1 = top + bottom - y0, top + bottom - y1
                lines.append(f"M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}")
        yield (
            f'<path class="hatched" d="{"".join(lines) or "M0 0"}" fill="none" '
            f'style="stroke:{s.colour}" stroke-width="0.9" opacity="0.55"/>'
        )


def open_svg(width: float, height: float, label: str) -> str:
    """Return the opening tag of a drawing; ``label`` is for screen readers."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="plot" role="img" '
        f'aria-label="{escape(label, quote=True)}" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">'
    )


def title_text(text: str, x: float) -> str:
    """Return the title of a plot."""
    return (
        f'<text x="{x}" y="16" font-size="12.5" font-weight="600" {_FONT} '
        f'style="fill:{INK}">{escape(text)}</text>'
    )


def text_at(words, x, y, *, anchor="start", colour=SOFT) -> str:
    """Return a text at a point."""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="10.5" {_FONT} '
        f'style="fill:{colour}">{escape(str(words))}</text>'
    )


def rule(x1, x2, y1, y2, colour, width=1.0) -> str:
    """Return a straight line."""
    return (
        f'<line x1="{x1:.1f}" x2="{x2:.1f}" y1="{y1:.1f}" y2="{y2:.1f}" '
        f'style="stroke:{colour}" stroke-width="{width}"/>'
    )


def power_of_ten(exponent: float) -> str:
    """Return a power of ten with a superscript exponent.

    Example:
        >>> power_of_ten(-3), power_of_ten(0)
        ('10⁻³', '1')
    """
    if exponent == 0:
        return "1"
    return "10" + str(round(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def number_text(value: float) -> str:
    """Return a number as a tick shows it, with a true minus sign."""
    return f"{value:.6g}".replace("-", "−")
