"""Figures of estimated ground reactions against measured ones, and their goals."""

from collections.abc import Callable
from dataclasses import dataclass

from experiments.recording_ends import COVERAGE_PREFIX, ERROR_PREFIX, PHASES
from plantigrade.analyze.gait_forces import ForceComparison


@dataclass(frozen=True)
class Figure:
    """One figure of the table.

    Attributes:
        name: Of its rows.
        short: Over its column.
        of: Reads it from a comparison; the computing time is measured.
        unit: Its unit.
        goal: Goal of the mean over recordings; None for none.
        least: Whether the goal is a lower bound instead of an upper one.
        most: Upper bound besides that lower one; None for none.
        opengrf: What [DiPietro2025]_ prints.
        digits: Behind the decimal point.
    """

    name: str
    short: str
    of: Callable[[ForceComparison], float]
    unit: str = ""
    goal: float | None = None
    least: bool = False
    most: float | None = None
    opengrf: str = ""
    digits: int = 3


IN_BAND = 85.0, True, 95.0
"""Goal of what is in the 90 % bands [%]."""


def _moment(kind: str, joint: str) -> Callable[[ForceComparison], float]:
    return lambda c: getattr(c, f"moment_{kind}").get(joint, float("nan"))


def _nowhere(_: ForceComparison) -> float:
    """Return NaN: the figure is measured elsewhere."""
    return float("nan")


def _covered(what: str) -> Callable[[ForceComparison], float]:
    return lambda c: 100.0 * c.covered.get(what, float("nan"))


FORCES = (
    Figure("vertical force, r", "vert r", lambda c: c.vertical_r, "", 0.985, True, None, ">= .94"),
    Figure("vertical force, RMSE", "BW", lambda c: c.vertical_rmse, "BW", 0.045),
    Figure("forward force, r", "fore r", lambda c: c.forward_r, "", 0.98, True, None, ".81-.91"),
    Figure("forward force, RMSE", "BW", lambda c: c.forward_rmse, "BW"),
    Figure(
        "forward force, nRMSE", "%", lambda c: c.forward_nrmse,
        "%", 5.0, opengrf="4.4-6.1", digits=1,
    ),
    Figure("sideways force, r", "side r", lambda c: c.sideways_r, "", 0.94, True),
    Figure("sideways force, RMSE", "BW", lambda c: c.sideways_rmse, "BW"),
    Figure(
        "centre of pressure x, median error", "CoP x mm", lambda c: 1e3 * c.pressure_median_m[0],
        "mm", 10.0, opengrf="21-23", digits=1,
    ),
    Figure(
        "centre of pressure y, median error", "y mm", lambda c: 1e3 * c.pressure_median_m[1],
        "mm", digits=1,
    ),
    Figure(
        "centre of pressure x, ahead", "ahead", lambda c: 1e3 * c.pressure_ahead_m[0],
        "mm", digits=1,
    ),
    Figure(
        "centre of pressure, backward in a stance", "back mm", lambda c: 1e3 * c.backward_m,
        "mm", 10.0, digits=1,
    ),
)  # fmt: skip
"""Ground reactions."""
MOMENTS = tuple(
    figure
    for joint, words, goal, printed in (
        ("ankle_angle", "ankle", 0.985, ".98"),
        ("knee_angle", "knee", 0.955, ""),
        ("hip_flexion", "hip", 0.97, ""),
    )
    for figure in (
        Figure(
            f"{words} moment, r", f"{words} r", _moment("r", joint), "", goal, True, opengrf=printed
        ),
        Figure(f"{words} moment, RMSE", "N m/kg", _moment("rmse", joint), "N m/kg"),
    )
)
"""Joint moments against inverse dynamics with the plates."""
BAND_FIGURES = tuple(
    Figure(f"{words} in the 90 % band", short, _covered(what), "%", *IN_BAND, digits=0)
    for what, words, short in (
        ("vertical_force", "vertical force", "vertical"),
        ("forward_force", "forward force", "forward"),
        ("sideways_force", "sideways force", "sideways"),
        ("pressure_x", "centre of pressure x", "CoP x"),
        ("pressure_y", "centre of pressure y", "CoP y"),
        ("ankle_angle_moment", "ankle moment", "ankle"),
        ("knee_angle_moment", "knee moment", "knee"),
        ("hip_flexion_moment", "hip moment", "hip"),
    )
)
"""How often the measured value lies in the band."""
BY_PHASE = (
    *(
        Figure(ERROR_PREFIX + phase, f"{short} BW", _nowhere, "BW", goal)
        for phase, short, goal in zip(
            PHASES, ("single", "double", "ends"), (None, 0.055, None), strict=True
        )
    ),
    *(
        Figure(COVERAGE_PREFIX + phase, f"{short} %", _nowhere, "%", *IN_BAND, digits=0)
        for phase, short in zip(PHASES, ("single", "double", "ends"), strict=True)
    ),
)
"""Vertical force by phase of the walk."""
LEAST_CORRELATION = Figure(
    "vertical force, least r of a recording", "least r", _nowhere, "", 0.95, True
)
COMPUTING_TIME = Figure("computing time", "s", _nowhere, "s", 0.5, digits=2)
PRESSURE_AHEAD = Figure("centre of pressure x, ahead", "ahead", _nowhere, "mm", 10.0, digits=1)
"""Goal of its size in movements other than walking."""
FIGURES = (*FORCES, *MOMENTS, *BAND_FIGURES)
OPENGRF = (
    "OpenGRF: published figures of level walking of seven adults, other people and another "
    "protocol (Di Pietro, Di Puccio and Modenese 2025): "
    + "; ".join(f"{f.name} {f.opengrf}{f.unit and ' '}{f.unit}" for f in FIGURES if f.opengrf)
    + "."
)
"""A note with the published figures."""
