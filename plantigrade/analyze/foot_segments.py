"""Angles between foot segments of a walk with enough markers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from plantigrade.analyze.foot_angles import (
    NEEDED,
    WORN_IN_STANDING,
    Paths,
    foot_angles,
    tibia_axes,
    unsteadiness,
)
from plantigrade.analyze.trial import CUTOFF, Trial
from plantigrade.arrays import Array, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet, body_paths
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import MarkerSet, landmarks_of, read_marker_set
from plantigrade.motion import Markers, Recording, Table
from plantigrade.motion.cycles import PERCENT, Cycle, normalise_cycles
from plantigrade.motion.filters import lowpass
from plantigrade.motion.recording import rate_of


@dataclass(frozen=True)
class FootSegments:
    """Angles between foot segments over the gait cycle; empty without enough markers."""

    #: ``foot.percent``, ``foot.names`` and for each name ``foot.NAME``, one row per cycle [°]
    signals: dict[str, Array] = field(default_factory=dict, repr=False)
    #: Ranges of motion (mean over cycles) and deviation of the segments from rigid ones
    figures: dict[str, float] = field(default_factory=dict)


def foot_segment_signals(
    recording: Recording, trial: Trial, marker_set: Path | None = None, cutoff: float = CUTOFF
) -> FootSegments:
    """Return the foot segments of a walk; empty without enough markers or gait cycles.

    Args:
        recording: The recording as it was read, with its standing trial.
        cutoff: Low-pass of the angles [Hz].
    """
    chosen = read_marker_set(marker_set) if marker_set else None
    if not trial.cycles:
        return FootSegments()
    table = angles_of(trial.fit, recording.static, chosen)
    curves = {} if table is None else _curves(table, trial.cycles, cutoff)
    if not curves:
        return FootSegments()
    feet = [feet_of(_used(trial.fit), side, chosen) for side in SIDES]
    rms = [1e3 * unsteadiness(seen) for seen in feet if seen is not None]
    figures = {"foot_segments_marker_rms_mm": root_mean_square(np.asarray(rms))}
    for name, rows in curves.items():
        rom = float(np.mean(np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1)))
        figures[f"{name[:-2]}_rom{name[-2:]}_deg"] = rom
    signals = {"foot.percent": PERCENT, "foot.names": np.array(list(curves))}
    return FootSegments(signals | {f"foot.{name}": rows for name, rows in curves.items()}, figures)


def angles_of(
    fitted: Fit, static: Recording | None = None, chosen: MarkerSet | None = None
) -> Table | None:
    """Return the angles between the foot segments of a fit over time [rad].

    Args:
        fitted: The fit, with markers and joint centres.
        static: Standing trial of the same person; without it, landmarks with markers in standing
            only are those of the scaled body.

    Returns:
        The columns of :func:`plantigrade.analyze.foot_angles.foot_angles` of every foot with
        enough markers; None if there is none.
    """
    if fitted.markers is None:
        return None
    columns: dict[str, np.ndarray] = {}
    for side in SIDES:
        seen = feet_of(_used(fitted), side, chosen)
        if seen is None:
            continue
        standing = None if static is None else feet_of(static.markers, side, chosen)
        if standing is None or not set(WORN_IN_STANDING) <= set(standing):
            standing = _zero_pose(fitted, side, seen, chosen)
        columns |= foot_angles(seen, standing, _tibia(fitted, side, seen), side)
    if not columns:
        return None
    return Table(tuple(columns), fitted.time, np.stack(list(columns.values()), axis=1))


def feet_of(markers: Markers | None, side: str, chosen: MarkerSet | None = None) -> Paths | None:
    """Return landmark (without side) → path of the markers of one side [m].

    The result is None if a required marker is never visible.
    """
    if markers is None:
        return None
    found = {
        mark.removesuffix(f"_{side}"): markers.positions[:, markers.index(name)]
        for mark, name in landmarks_of(markers.names, chosen).items()
        if mark.endswith(f"_{side}")
    }
    found = {mark: path for mark, path in found.items() if np.isfinite(path[:, 0]).any()}
    return found if set(NEEDED) <= set(found) else None


def _used(fitted: Fit) -> Markers | None:
    """Return the markers of a fit without rejected samples."""
    if fitted.markers is None or fitted.kept is None:
        return fitted.markers
    x = np.where(fitted.kept[..., None], fitted.markers.positions, np.nan)
    return Markers(fitted.markers.names, fitted.markers.time, x)


def _zero_pose(
    fitted: Fit, side: str, seen: Mapping[str, np.ndarray], chosen: MarkerSet | None
) -> Paths:
    """Return the landmarks of the standing person: markers where the fit placed them."""
    assert fitted.markers is not None
    table = attachments(fitted.human)
    names = landmarks_of(fitted.markers.names, chosen)
    places = {}
    for mark in {*seen, *WORN_IN_STANDING}:
        name = names.get(f"{mark}_{side}")
        own = None if name is None else fitted.places[fitted.markers.index(name)]
        places[mark] = own or table[f"{mark}_{side}"]
    points = PointSet.of(fitted.human, list(places.values()))
    path = points.path(fitted.human.standing()[None])
    return {mark: path[:, i] for i, mark in enumerate(places)}


def _tibia(fitted: Fit, side: str, seen: Paths) -> np.ndarray:
    """Return the axes of the tibia by its markers, or else those of the fitted body."""
    human = fitted.human
    femur, tibia = human.body(f"femur_{side}"), human.body(f"tibia_{side}")
    origins, rotations = body_paths(human, fitted.qpos, (femur, tibia))
    hip, own = origins[:, 0], rotations[:, 1]
    table = attachments(human)
    knee, ankle = (
        abs(float(table[f"{mark}_{side}"].position[1]))
        for mark in ("knee_lateral", "ankle_lateral")
    )
    found = tibia_axes(seen, hip, knee, ankle, side)
    return own if found is None else found


def _curves(table: Table, cycles: Sequence[Cycle], cutoff: float) -> dict[str, Array]:
    """Return the angles over the gait cycle by name [°]."""
    values = np.rad2deg(table.values)
    rate = rate_of(table.time)
    if cutoff < 0.45 * rate and len(table.time) >= 12:
        values = lowpass(table.time, values, cutoff=cutoff)
    curves = {}
    for i, name in enumerate(table.names):
        mine = [c for c in cycles if c.side == name[-1]]
        rows = normalise_cycles(table.time, values[:, i], mine)
        rows = rows[np.isfinite(rows).mean(axis=1) > 0.5]
        if len(rows):
            curves[name] = rows
    return curves
