"""Paths in a plane, with one scale for both axes."""

from collections.abc import Sequence

import numpy as np

from plantigrade.charts.marks import Outline, Series
from plantigrade.charts.svg import (
    SOFT,
    TITLE,
    axes,
    curve,
    data_range,
    legend,
    legend_width,
    linear_scale,
    open_svg,
    path_data,
    rule,
    title_text,
)


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
