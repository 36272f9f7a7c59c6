"""Elements of plots: curves, ribbons, bars and outlines."""

from dataclasses import dataclass

from plantigrade.arrays import Array, Bool, Float
from plantigrade.charts.theme import STROKE_MIDDLE


@dataclass(frozen=True)
class Series:
    """One curve of a plot."""

    x: Float[Array, " n"]  #: Abscissae
    y: Float[Array, " n"]  #: Ordinates; NaN interrupts the curve
    label: str = ""  #: Its name in the legend; none where empty
    colour: str = STROKE_MIDDLE  #: CSS colour
    width: float = 1.8  #: Of the stroke [px]
    opacity: float = 1.0  #: Of the stroke
    dash: str = ""  #: SVG dash pattern; solid where empty
    #: Where the plot is hatched behind the curve; nowhere if None
    hatched: Bool[Array, " n"] | None = None


@dataclass(frozen=True)
class Ribbon:
    """A shaded range of a plot."""

    x: Float[Array, " n"]  #: Abscissae
    low: Float[Array, " n"]  #: Lower edge
    high: Float[Array, " n"]  #: Upper edge
    colour: str = STROKE_MIDDLE  #: CSS colour
    opacity: float = 0.2  #: Of the shade


@dataclass(frozen=True)
class Bar:
    """A stretch of one row of a timeline."""

    start: float  #: Its beginning on the axis
    stop: float  #: Its end on the axis
    colour: str = STROKE_MIDDLE  #: CSS colour
    label: str = ""  #: Written into it where there is room
    opacity: float = 0.85  #: Of the colour


@dataclass(frozen=True)
class Outline:
    """A thick round stroke or a closed shape on a path plot, in its units."""

    points: Float[Array, "n 2"]  #: Corners, or the ends of the stroke
    colour: str  #: CSS colour
    width: float = 0.0  #: Of the stroke, in the plot's units; 0 fills the closed shape instead
