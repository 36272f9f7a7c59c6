"""Figures and tables of a Record and a Run.

The classes call these functions, so nothing here imports them.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array
from plantigrade.charts import Figure
from plantigrade.constants import SIDES
from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.extras import require
from plantigrade.motion.views import curves_of, dataframe, plot_curves, summary
from plantigrade.record.signals import signal_of

AXES = {"forward": 0, "sideways": 1, "up": 2}
_MOMENT, _FORCE = "_moment", "ground_force_"


def plot(record: Any, names: Sequence[str]) -> Figure:
    """Return a figure of coordinates, moments, ground forces or signals; see Record.plot."""
    curves = curves_of(record.motion) if not names else {}
    for name in names:
        curves |= _curves(record, name)
    return plot_curves(curves, record.motion.time, asked=bool(names))


def _curves(record: Any, name: str) -> dict[str, Array]:
    value = record.signals.get(name)
    if value is not None:
        if value.shape != (record.motion.n_frames,) or value.dtype.kind not in "fiub":
            raise ParameterError(f"signal {name!r} is not one number a frame")
        return {f"{name} [{signal_of(name).unit}]": value.astype(float)}
    if name.startswith(_FORCE):
        axis, _, side = name.removeprefix(_FORCE).partition("_")
        if axis not in AXES or side not in ("", *SIDES):
            raise CoordinateNotFound(f"no {name!r}; there are {_FORCE}{{{','.join(AXES)}}}_{{r,l}}")
        if not record.has_forces:
            raise ParameterError("this record has no ground forces")
        force = {s: record.foot(s).force[:, AXES[axis]] for s in ((side,) if side else SIDES)}
        return {f"{_FORCE}{axis}_{s} [BW]": f / record.weight for s, f in force.items()}
    stem, dot, side = name.partition(_MOMENT)
    if dot:
        hinges = [label.split(" [")[0] for label in curves_of(record.motion, [f"{stem}{side}"])]
        mass = record.human.mass
        return {f"{hinge}{_MOMENT} [N m/kg]": record.torque(hinge) / mass for hinge in hinges}
    return curves_of(record.motion, [name])


def record_summary(record: Any) -> dict[str, object]:
    """Return a record in a few rows."""
    human = record.human
    return {
        "person": f"{human.height:.2f} m, {human.mass:.1f} kg, {human.feet} feet",
        **summary(record.motion),
        "contact sites": len(record.sites) or "",
        "torques": "yes" if record.qfrc_actuator is not None else "no",
        "references": ", ".join(record.references),
        "signals": ", ".join(sorted({name.split(".")[0] for name in record.signals})),
        "notes": " ".join(record.notes),
    }


def run_summary(run: Any) -> dict[str, object]:
    """Return a run in a few rows."""
    return {
        "kind": run.kind,
        "status": run.status,
        "what": run.sentence,
        "folder": run.folder or "",
        **record_summary(run.record),
    }


def columns_of(record: Any) -> dict[str, Array]:
    """Return every number there is one of a frame, by name [rad, m, N m, N]."""
    motion = record.motion
    found = {name: motion[name] for name in motion.coordinates}
    if record.qfrc_actuator is not None:
        found |= {f"{h}{_MOMENT}": record.torque(h) for h in motion.joint_names[1:]}
    if record.has_forces:
        for side in SIDES:
            foot = record.foot(side)
            for axis, i in AXES.items():
                found[f"{_FORCE}{axis}_{side}"] = foot.force[:, i]
            for axis, i in AXES.items():
                found[f"centre_of_pressure_{axis}_{side}"] = foot.centre_of_pressure[:, i]
            if "forces.measured" in record.signals:
                found[f"ground_force_measured_{side}"] = foot.measured
    plain = {k: v for k, v in record.signals.items() if v.shape == (motion.n_frames,)}
    return found | plain


def to_dataframe(record: Any) -> Any:
    """Return the record as a pandas DataFrame, one row a frame."""
    return dataframe(record.motion.time, columns_of(record))


def to_xarray(record: Any) -> Any:
    """Return the record as an xarray Dataset with named dimensions."""
    xarray = require("xarray", "tables")
    motion, n = record.motion, record.motion.n_frames
    names = list(motion.coordinates)
    arrays: dict[str, Any] = {
        "coordinate_value": (("time", "coordinate"), np.stack([motion[c] for c in names], axis=1))
    }
    if record.qfrc_actuator is not None:
        arrays["torque"] = (("time", "hinge"), record.qfrc_actuator[:, 6:])
    coordinates: dict[str, Any] = {
        "time": motion.time,
        "coordinate": names,
        "hinge": list(motion.joint_names[1:]),
        "axis": list(AXES),
        "site": [site.name for site in record.sites],
    }
    for name in ("contact_force", "contact_point", "contact_torque"):
        value = getattr(record, name)
        if value is not None:
            arrays[name] = (("time", "site", "axis"), value)
    markers = record.recorded_markers
    if record.fitted_markers is not None and markers is not None:
        arrays["recorded_marker"] = (("time", "marker", "axis"), markers.positions)
        arrays["fitted_marker"] = (("time", "marker", "axis"), record.fitted_markers)
        coordinates["marker"] = list(markers.names)
    for name, value in record.signals.items():
        if value.ndim and len(value) == n:
            more = [f"{name}.{k}" for k in range(1, value.ndim)]
            known = signal_of(name)
            about = {"units": known.unit, "long_name": known.meaning}
            arrays[name] = (("time", *more), value, about)
    used = {d for dims, *_ in arrays.values() for d in dims}
    return xarray.Dataset(arrays, {k: v for k, v in coordinates.items() if k in used})
