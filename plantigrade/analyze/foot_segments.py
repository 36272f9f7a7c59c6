"""Angles between the segments of the feet of a walk, where enough markers show them.

The fit whose angles are taken has multi-segment feet. Where the recording was fitted with other
feet, a few of its gait cycles are fitted once more.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.foot_angles import foot_angles
from plantigrade.analyze.trial import CUTOFF, Trial
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.errors import FitError
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.result import Fit
from plantigrade.models import Human
from plantigrade.models.markers import MarkerSet, place_markers, read_marker_set
from plantigrade.models.person import Person
from plantigrade.motion import Recording
from plantigrade.motion.cycles import PERCENT, Cycle, normalise_cycles
from plantigrade.motion.filters import lowpass

ENOUGH = 3  # markers on hindfoot and on forefoot of both feet
LONGEST = 600  # frames that are fitted once more: a few cycles are enough for mean curves
MARGIN = 0.1  # of recording around those cycles, so that the filter's ends lie outside [s]
JOINTS, FEET = "66", "multi-segment"


@dataclass(frozen=True)
class FootSegments:
    """Angles between foot segments over the gait cycle; empty where nothing shows them."""

    #: ``foot.percent``, ``foot.names`` and for each name ``foot.NAME``, one row per cycle [°]
    signals: dict[str, Array] = field(default_factory=dict, repr=False)
    #: Ranges of motion (mean over cycles) and the marker error of the feet
    figures: dict[str, float] = field(default_factory=dict)


def foot_segment_signals(
    recording: Recording,
    trial: Trial,
    known: dict[str, Any],
    marker_set: Path | None = None,
    cutoff: float = CUTOFF,
) -> FootSegments:
    """Return the foot segments of a walk; nothing where markers do not show them or nobody walks.

    Args:
        recording: The recording as it was read.
        trial: The same, fitted with any feet and analysed: its gait cycles are used.
        known: What is known of the person; joints and feet are replaced by multi-segment ones.
        marker_set: The user's own marker set.
        cutoff: Low-pass of the angles [Hz].
    """
    fitted, cycles = trial.fit, trial.cycles
    chosen = read_marker_set(marker_set) if marker_set else None
    if fitted.source_kind != "markers" or not cycles or not shows_segments(fitted, chosen):
        return FootSegments()
    if fitted.human.feet != FEET:
        short, cycles = _cut(recording, cycles)
        own: dict[str, Any] = {**known, "joints": JOINTS, "feet": FEET}
        person = Person(**own)
        try:
            fitted = fit_markers(short, person, static=recording.static, marker_set=chosen)
        except FitError:  # the markers of these few cycles alone are too few
            return FootSegments()
    curves = _curves(fitted, cycles, cutoff)
    if not curves:
        return FootSegments()
    figures = {"foot_segments_marker_rms_mm": 1e3 * foot_marker_rms(fitted)}
    for name, rows in curves.items():
        rom = float(np.mean(np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1)))
        figures[f"{name[:-2]}_rom{name[-2:]}_deg"] = rom
    signals = {"foot.percent": PERCENT, "foot.names": np.array(list(curves))}
    return FootSegments(signals | {f"foot.{name}": rows for name, rows in curves.items()}, figures)


def shows_segments(fitted: Fit, chosen: MarkerSet | None = None) -> bool:
    """Return whether hindfoot and forefoot of both feet carry enough markers to be followed."""
    names = [] if fitted.markers is None else fitted.markers.names
    placed = place_markers(names, Human.create(joints=JOINTS, feet=FEET), chosen)
    bodies = [place.body for place in placed.values() if place is not None]
    return all(
        bodies.count(f"heel_{s}") >= ENOUGH
        and bodies.count(f"foot_{s}") + bodies.count(f"lateral_metatarsal_{s}") >= ENOUGH
        and bodies.count(f"lateral_metatarsal_{s}") > 0
        for s in SIDES
    )


def foot_marker_rms(fitted: Fit) -> float:
    """Return the root mean square distance of the markers on the feet to their places [m]."""
    segments = ("foot", "heel", "medial_", "lateral_")
    mine = [place.body.startswith(segments) for place in fitted.places]
    assert fitted.residual is not None and fitted.kept is not None
    used = np.where(fitted.kept, fitted.residual, np.nan)[:, mine]
    return float(np.sqrt(np.nanmean(used**2)))


def _curves(fitted: Fit, cycles: Sequence[Cycle], cutoff: float) -> dict[str, Array]:
    """Return the angles over the gait cycle by name [°]."""
    table = foot_angles(fitted.human, fitted.time, fitted.qpos)
    values = np.rad2deg(table.values)
    rate = (len(table.time) - 1) / (table.time[-1] - table.time[0])
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


def _cut(recording: Recording, cycles: Sequence[Cycle]) -> tuple[Recording, tuple[Cycle, ...]]:
    """Return the recording of as many cycles as fit into the longest stretch, and those cycles."""
    markers = recording.markers
    assert markers is not None  # the fit is one of markers
    start = min(c.start for c in cycles)
    last = markers.time[min(np.searchsorted(markers.time, start) + LONGEST, markers.n_frames) - 1]
    kept = [c for c in cycles if c.stop <= last] or [min(cycles, key=lambda c: c.start)]
    stop = max(c.stop for c in kept)
    inside = (markers.time >= start - MARGIN) & (markers.time <= stop + MARGIN)
    short = replace(markers, time=markers.time[inside], positions=markers.positions[inside])
    return replace(recording, markers=short, outputs={}, plates=()), tuple(kept)
