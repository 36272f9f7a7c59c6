"""Curves over time as panels: left and right of one quantity share a plot."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion import Motion, Table
from plantigrade.report.theme import SIDE_NAMES, colour_of, side_of, title_of, without_side

FIRST = ("hip_flexion", "knee_angle", "ankle_angle", "pelvis_tilt", "lumbar_extension")
TRANSLATIONS = ("pelvis_tx", "pelvis_ty", "pelvis_tz")


@dataclass(frozen=True)
class Line:
    """One curve.

    Attributes:
        label: What tells it from its neighbours (``"right"``, ``"left"``).
        colour: CSS colour.
        values: In the panel's unit; NaN where unknown.
    """

    label: str
    colour: str
    values: Float[Array, " n"]


@dataclass(frozen=True)
class Panel:
    """Curves that share one plot.

    Attributes:
        title: What is plotted.
        unit: Its unit (``"°"``, ``"N"``, …).
        lines: The curves.
        name: The coordinate without its side.
    """

    title: str
    unit: str
    lines: tuple[Line, ...]
    name: str = ""


def hinge_table(model: mujoco.MjModel, motion: Motion) -> Table:
    """Return the angles of all hinges of ``model`` over time [rad] (slides in metres)."""
    joints = [
        j
        for j in range(model.njnt)
        if int(model.jnt_type[j])
        in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    ]
    return Table(
        names=tuple(model.joint(j).name for j in joints),
        time=motion.time,
        values=motion.qpos[:, [int(model.jnt_qposadr[j]) for j in joints]],
    )


def panels_of(curves: Table | dict[str, np.ndarray], n_frames: int) -> tuple[Panel, ...]:
    """Return one panel per quantity that changes, hip, knee and ankle first.

    Args:
        curves: A table of coordinates in radians and metres (shown in degrees and metres), or
            arrays by name in the unit they are to be shown in, named at the end in brackets
            (``"knee_moment_r [N m/kg]"``).
        n_frames: Length every curve must have.

    Raises:
        ParameterError: If a curve has another length.
    """
    grouped: dict[tuple[str, str], list[Line]] = {}
    for name, unit, values in _flat(curves):
        if np.shape(values) != (n_frames,):
            raise ParameterError(
                f"curve {name!r} has shape {np.shape(values)}; the motion has {n_frames} frames"
            )
        side = side_of(name)
        line = Line(SIDE_NAMES.get(side or "", ""), colour_of(name), np.asarray(values, float))
        grouped.setdefault((without_side(name), unit), []).append(line)
    order = {name: i for i, name in enumerate(FIRST)}
    keys = sorted(grouped, key=lambda key: order.get(key[0], len(FIRST)))
    panels = (
        Panel(title_of(name), unit, tuple(sorted(grouped[name, unit], key=_right_first)), name)
        for name, unit in keys
    )
    return tuple(panel for panel in panels if any(map(_moves, panel.lines)))


def _right_first(line: Line) -> int:
    return ("right", "left").index(line.label) if line.label in ("right", "left") else 2


def _moves(line: Line) -> bool:
    finite = line.values[np.isfinite(line.values)]
    return finite.size > 0 and float(np.ptp(finite)) > 1e-6


def _flat(curves):
    if isinstance(curves, Table):
        for name in curves.names:
            if name in TRANSLATIONS:
                yield name, " m", curves[name]
            else:
                yield name, "°", np.degrees(curves[name])
        return
    for label, values in curves.items():
        name, _, unit = label.partition("[")
        unit = unit.rstrip("] ")
        unit = "°" if unit in ("deg", "°") else f" {unit}" if unit else ""
        yield name.strip().replace(" ", "_"), unit, values
