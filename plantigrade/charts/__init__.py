"""Plots as small SVG drawings that follow the page's light or dark colours and print well.

Colours are CSS variables with a fallback, so a drawing also stands alone. Nothing is rasterised
and no plotting library is loaded: a report of forty plots takes milliseconds.
"""

from plantigrade.charts.bars import bar_plot, histogram_plot, timeline_plot
from plantigrade.charts.figure import Figure, grid
from plantigrade.charts.lines import line_plot, path_plot
from plantigrade.charts.marks import Bar, Outline, Ribbon, Series
from plantigrade.charts.panels import Panel, panel_plot, panels_of
from plantigrade.charts.theme import STROKE_LEFT as LEFT
from plantigrade.charts.theme import STROKE_MIDDLE as MIDDLE
from plantigrade.charts.theme import STROKE_RIGHT as RIGHT

__all__ = [
    "LEFT",
    "MIDDLE",
    "RIGHT",
    "Bar",
    "Figure",
    "Outline",
    "Panel",
    "Ribbon",
    "Series",
    "bar_plot",
    "grid",
    "histogram_plot",
    "line_plot",
    "panel_plot",
    "panels_of",
    "path_plot",
    "timeline_plot",
]
