"""Display of a Motion: curves in degrees, a figure, a table.

The class calls these functions, so this module does not import it.
"""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, grid, panel_plot, panels_of
from plantigrade.errors import CoordinateNotFound, ParameterError, known_names
from plantigrade.extras import require

MAX_PANELS = 12  # panels of a figure by default
TRANSLATIONS = ("pelvis_tx", "pelvis_ty", "pelvis_tz")


def curves_of(motion: Any, names: Sequence[str] = ()) -> dict[str, Float[Array, " n_frames"]]:
    """Return coordinates in degrees, those of the pelvis's position in metres, by name and unit.

    A stem (``"knee_angle"``) stands for both sides; all coordinates if there are no names.
    """
    found = {}
    for name in names or motion.coordinates:
        mine = [full for full in (name, f"{name}_r", f"{name}_l") if full in motion.coordinates]
        if not mine:
            raise CoordinateNotFound(
                f"no coordinate {name!r} in this motion; {known_names(name, motion.coordinates)}"
            )
        for full in mine:
            metres = full in TRANSLATIONS
            label = f"{full} [{'m' if metres else '°'}]"
            found[label] = motion[full] if metres else np.rad2deg(motion[full])
    return found


def plot_curves(curves: Mapping[str, Array], time: Float[Array, " n"], *, asked: bool) -> Figure:
    """Return a figure of curves by name and unit, by default of the first ones."""
    panels = panels_of(curves)
    if not panels:
        raise ParameterError("there is nothing to plot: none of these curves changes")
    return grid([panel_plot(panel, time) for panel in (panels if asked else panels[:MAX_PANELS])])


def table_html(title: str, rows: Mapping[str, object]) -> str:
    """Return a short table for a notebook."""
    cells = "".join(
        f'<tr><th style="text-align:left">{escape(str(name))}</th>'
        f'<td style="text-align:left">{escape(str(value))}</td></tr>'
        for name, value in rows.items()
        if value not in ("", None)
    )
    return f"<table><caption>{escape(title)}</caption><tbody>{cells}</tbody></table>"


def summary(motion: Any) -> dict[str, object]:
    """Return a motion in a few rows."""
    return {
        "frames": motion.n_frames,
        "duration": f"{motion.duration:.2f} s",
        "rate": f"{motion.rate:.0f} Hz" if motion.n_frames > 1 else "",
        "hinges": len(motion.joint_names) - 1,
        "gait events": len(motion.events),
    }


def dataframe(time: Float[Array, " n"], columns: Mapping[str, Array]) -> Any:
    """Return columns as a pandas DataFrame indexed by time [s]."""
    pandas = require("pandas", "tables")
    return pandas.DataFrame(dict(columns), index=pandas.Index(time, name="time"))
