"""Elements of plots: curves, ribbons, bars and outlines."""

from dataclasses import dataclass

from plantigrade.arrays import Array, Bool, Float
from plantigrade.charts.theme import STROKE_MIDDLE


@dataclass(frozen=True)
class Series:
    """One curve of a plot.

    Attributes:
        x: Abscissae.
        y: Ordinates; NaN interrupts the curve.
        label: Its name in the legend; none where empty.
        colour: CSS colour.
        width: Of the stroke [px].
        opacity: Of the stroke.
        dash: SVG dash pattern; solid where empty.
        hatched: Where the plot is hatched behind the curve; nowhere if None.
    """

    x: Float[Array, " n"]
    y: Float[Array, " n"]
    label: str = ""
    colour: str = STROKE_MIDDLE
    width: float = 1.8
    opacity: float = 1.0
    dash: str = ""
    hatched: Bool[Array, " n"] | None = None


@dataclass(frozen=True)
class Ribbon:
    """A shaded range of a plot.

    Attributes:
        x: Abscissae.
        low: Lower edge.
        high: Upper edge.
        colour: CSS colour.
        opacity: Of the shade.
    """

    x: Float[Array, " n"]
    low: Float[Array, " n"]
    high: Float[Array, " n"]
    colour: str = STROKE_MIDDLE
    opacity: float = 0.2


@dataclass(frozen=True)
class Bar:
    """A stretch of one row of a timeline.

    Attributes:
        start: Its beginning on the axis.
        stop: Its end on the axis.
        colour: CSS colour.
        label: Written into it where there is room.
        opacity: Of the colour.
    """

    start: float
    stop: float
    colour: str = STROKE_MIDDLE
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
