"""Curves over time as panels: left and right of one quantity share a plot."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.charts.labels import MIN_SPANS, axis_label, title_of
from plantigrade.charts.lines import line_plot
from plantigrade.charts.marks import Series
from plantigrade.charts.theme import DOTTED, STROKES
from plantigrade.constants import SIDE_NAMES
from plantigrade.side_names import side_of, without_side

FIRST_PANELS = ("hip_flexion", "knee_angle", "ankle_angle", "pelvis_tilt", "lumbar_extension")


@dataclass(frozen=True)
class Panel:
    """Curves that share one plot."""

    name: str  #: The quantity without its side (``"knee_angle"``)
    unit: str  #: Its unit (``"°"``, ``"N"``, …)
    #: Side (``"r"``, ``"l"`` or empty) → values; NaN where unknown
    curves: Mapping[str, Float[Array, " n"]]
    #: Side → where the plot is hatched behind its curve
    hatched: Mapping[str, Bool[Array, " n"]] = field(default_factory=dict)
    dotted: tuple[str, ...] = ()  #: Sides whose curves are dotted

    @property
    def title(self) -> str:
        """Title of the plotted quantity."""
        return title_of(self.name)


def panels_of(curves: Mapping[str, Array]) -> tuple[Panel, ...]:
    """Return one panel per quantity that changes, hip, knee and ankle first.

    Args:
        curves: Values by name, side and unit: ``"knee_moment_r [N m/kg]"``.
    """
    grouped: dict[tuple[str, str], dict[str, Array]] = {}
    for label, values in curves.items():
        name, _, unit = label.partition("[")
        name = name.strip()
        mine = grouped.setdefault((without_side(name), unit.rstrip("] ")), {})
        mine[side_of(name) or ""] = np.asarray(values, float)
    order = {name: i for i, name in enumerate(FIRST_PANELS)}
    keys = sorted(grouped, key=lambda key: order.get(key[0], len(FIRST_PANELS)))
    panels = (
        Panel(name, unit, {s: mine[s] for s in ("r", "l", "") if s in mine})
        for name, unit in keys
        for mine in (grouped[name, unit],)
    )
    return tuple(panel for panel in panels if any(map(_moves, panel.curves.values())))


def panel_plot(panel: Panel, time: Float[Array, " n"], **options) -> str:
    """Return the plot of a panel over time [s]; ``options`` are those of ``line_plot``."""
    return line_plot(
        [
            Series(
                time,
                values,
                SIDE_NAMES.get(side, ""),
                STROKES[side],
                dash=DOTTED if side in panel.dotted else "",
                hatched=panel.hatched.get(side),
            )
            for side, values in panel.curves.items()
        ],
        **{
            "title": panel.title,
            "y_label": axis_label(panel.name, panel.unit),
            "least": MIN_SPANS.get(panel.unit, 0.0),
            **options,
        },
    )


def _moves(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return finite.size > 0 and float(np.ptp(finite)) > 1e-6
