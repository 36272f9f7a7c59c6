"""Foot segments of a walk: fitted besides, where enough markers on the feet show them."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import FileError, FitError
from plantigrade.io.text import read_text
from plantigrade.record.folder import metrics_json

if TYPE_CHECKING:
    from plantigrade.analyze.trial import Trial
    from plantigrade.kinematics.result import Fit
    from plantigrade.motion.cycles import Cycle
    from plantigrade.report.sections import Section
    from plantigrade.workflows.fit import FitSettings, Loaded

FILE = "foot_segments.json"  # in the run folder
ENOUGH = 3  # markers on hindfoot and on forefoot of both feet
LONGEST = 600  # frames: the curves are means over cycles, and a few cycles are enough


@dataclass(frozen=True)
class FootSegments:
    """Angles between foot segments over the gait cycle.

    Attributes:
        marker_rms: Root mean square distance of the markers on the feet to their places [m].
        percent: Percent of the gait cycle.
        curves: Angle with its side → one row per cycle [degrees].
        toe_off: Side → percent at which the foot leaves the ground.
    """

    marker_rms: float
    percent: np.ndarray
    curves: dict[str, np.ndarray]
    toe_off: dict[str, float]

    def metrics(self) -> dict[str, Any]:
        """Return ranges of motion (mean over cycles) and the marker error of the feet."""
        found: dict[str, Any] = {"foot_segments_marker_rms_mm": 1e3 * self.marker_rms}
        for name, rows in self.curves.items():
            rom = float(np.mean(np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1)))
            found[f"{name[:-2]}_rom{name[-2:]}_deg"] = rom
        return found

    def to_json(self) -> str:
        """Return all of it as the run folder keeps it; a missing value is null."""
        return metrics_json(asdict(self)) + "\n"

    def section(self) -> "Section":
        """Return the curves as a section of the report."""
        from plantigrade.report.sections import CycleCurves, cycle_section

        return cycle_section(
            "Foot segments",
            [CycleCurves(name, self.percent, rows) for name, rows in self.curves.items()],
            {},
            self.toe_off,
            caption="Angles between the segments of the foot, from a fit with multi-segment feet: "
            "hindfoot to tibia, forefoot to hindfoot and to tibia, hallux to forefoot, with the "
            "signs and the order of rotations of the Oxford Foot Model (zero: standing pose of "
            "the body). The forefoot includes the tarsal bones, so the arch bends less than in "
            f"that model. Marker error of the feet {1e3 * self.marker_rms:.1f} mm RMS.",
            missing="",
        )


def read_foot_segments(folder: Path) -> FootSegments | None:
    """Return the foot segments that a run folder keeps; None where it has none.

    Raises:
        FileError: If the file is broken.
    """
    path = folder / FILE
    if not path.is_file():
        return None
    try:
        held = json.loads(read_text(path))
        return FootSegments(
            float(held["marker_rms"]),
            np.array(held["percent"], dtype=float),
            {name: np.array(rows, dtype=float) for name, rows in held["curves"].items()},
            {side: float(value) for side, value in held["toe_off"].items()},
        )
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise FileError(
            path, f"holds no angles of foot segments ({error})", remedy="make the run anew"
        ) from error


def foot_segments(loaded: "Loaded", trial: "Trial", settings: "FitSettings") -> FootSegments | None:
    """Return the foot segments of a walk; None where markers do not show them or nobody walks.

    Args:
        loaded: The recording as read.
        trial: The same, fitted with any feet and analysed: its gait cycles are used.
        settings: Those of the fit; joints and feet are replaced by the foot paper's.
    """
    from plantigrade.analyze.foot_angles import foot_angles
    from plantigrade.motion.cycles import PERCENT, normalise_cycles
    from plantigrade.motion.filters import lowpass
    from plantigrade.workflows.fit import fit

    cycles = trial.cycles
    if trial.fit.source_kind != "markers" or not cycles or not shows_segments(trial, settings):
        return None
    fitted, cycles = trial.fit, list(trial.cycles)
    if fitted.human.feet != "multi-segment":
        short, cycles = _cut(loaded, cycles)
        try:
            fitted = fit(short, replace(settings, joints="66", feet="multi-segment"))
        except FitError:  # the markers of these few cycles alone are too few
            return None
    table = foot_angles(fitted.human, fitted.time, fitted.qpos)
    values = np.rad2deg(table.values)
    rate = (len(table.time) - 1) / (table.time[-1] - table.time[0])
    if settings.cutoff and settings.cutoff < 0.45 * rate and len(table.time) >= 12:
        values = lowpass(table.time, values, cutoff=settings.cutoff)
    curves = {}
    for i, name in enumerate(table.names):
        mine = [c for c in cycles if c.side == name[-1]]
        rows = normalise_cycles(table.time, values[:, i], mine)
        rows = rows[np.isfinite(rows).mean(axis=1) > 0.5]
        if len(rows):
            curves[name] = rows
    stance = {s: trial.record.metrics.get(f"stance_{s}_pct") for s in ("r", "l")}
    toe_off = {s: v for s, v in stance.items() if v is not None}
    if not curves:
        return None
    return FootSegments(foot_marker_rms(fitted), PERCENT, curves, toe_off)


def shows_segments(trial: "Trial", settings: "FitSettings") -> bool:
    """Return whether hindfoot and forefoot of both feet carry enough markers to be followed."""
    from plantigrade.models import Human
    from plantigrade.models.markers import place_markers, read_marker_set

    chosen = read_marker_set(settings.marker_set) if settings.marker_set else None
    names = [] if trial.fit.markers is None else trial.fit.markers.names
    placed = place_markers(names, Human.create(joints="66", feet="multi-segment"), chosen)
    bodies = [p.body for p in placed.values() if p is not None]
    return all(
        bodies.count(f"heel_{s}") >= ENOUGH
        and bodies.count(f"foot_{s}") + bodies.count(f"lateral_metatarsal_{s}") >= ENOUGH
        and bodies.count(f"lateral_metatarsal_{s}") > 0
        for s in ("r", "l")
    )


def foot_marker_rms(fitted: "Fit") -> float:
    """Return the root mean square distance of the markers on the feet to their places [m]."""
    segments = ("foot", "heel", "medial_", "lateral_")
    mine = [p.body.startswith(segments) for p in fitted.places]
    assert fitted.residual is not None and fitted.kept is not None
    used = np.where(fitted.kept, fitted.residual, np.nan)[:, mine]
    return float(np.sqrt(np.nanmean(used**2)))


def _cut(loaded: "Loaded", cycles: "Sequence[Cycle]") -> tuple["Loaded", list["Cycle"]]:
    """Return the recording of as many cycles as fit into the longest stretch, and those cycles."""
    markers = loaded.recording.markers
    assert markers is not None
    start = min(c.start for c in cycles)
    last = markers.time[min(np.searchsorted(markers.time, start) + LONGEST, markers.n_frames) - 1]
    kept = [c for c in cycles if c.stop <= last]
    if not kept:
        kept = [min(cycles, key=lambda c: c.start)]
    margin = 0.1  # [s], so that the filter's ends lie outside
    inside = (markers.time >= start - margin) & (markers.time <= max(c.stop for c in kept) + margin)
    short = replace(markers, time=markers.time[inside], positions=markers.positions[inside])
    recording = replace(loaded.recording, markers=short, outputs={}, plates=())
    return replace(loaded, recording=recording), kept
