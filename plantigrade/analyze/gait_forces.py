"""Comparison of estimated or simulated ground reactions and joint moments with measured ones.

Each foot is compared over the frames of stance in which its force was measured. The zeros of swing
are equal for any method and would raise every correlation. Figures of a recording are means over
its feet. Estimated forces never count as measured.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.statistics import compare_curves, known_mean
from plantigrade.arrays import Array, Bool, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.motion.filters import interpolate, runs
from plantigrade.motion.recording import even_clock
from plantigrade.record import Record

STANCE_LOAD = 0.05  # [body weights] minimum measured vertical force of a foot in stance
MIN_FRAMES = 10  # Minimum number of stance frames for a comparison
JOINTS = ("hip_flexion", "knee_angle", "ankle_angle")
SIGNAL_JOINTS = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
AXES = ("forward", "sideways", "vertical")


@dataclass(frozen=True)
class FootComparison:
    """Comparison of force and moments of one foot and its leg with measured ones, in stance."""

    side: str  #: ``"r"`` or ``"l"``
    stance: Bool[Array, " n"]  #: Frames that are compared
    known: Bool[Array, " n"]  #: Frames in which the force was measured, swing included
    simulated: Float[Array, "n 3"]  #: Ground reaction [body weights]
    measured: Float[Array, "n 3"]  #: The same, measured
    force_r: tuple[float, ...]  #: Correlation of the force forward, to the left and upward
    force_rmse: tuple[float, ...]  #: Root mean square difference [body weights]
    force_range: tuple[float, ...]  #: Range of the measured force [body weights]
    #: Median distance of the centres of pressure along x and y [m]
    pressure_median_m: tuple[float, ...]
    pressure_rmse_m: tuple[float, ...]  #: Root mean square distance along x and y [m]
    #: Mean error of the centre of pressure forward and to the left [m]
    pressure_ahead_m: tuple[float, ...]
    #: Mean backward travel of the centre of pressure in a stance [m]
    backward_m: float
    backward_measured_m: float  #: The same for the measured one
    #: RMS error of the moment of each joint [N m/kg]; empty without inverse dynamics
    moment_rmse: dict[str, float]
    moment_r: dict[str, float]  #: Correlation of the moments of each joint
    #: Share of frames with the measured value inside the error band, by quantity; empty without
    #: bands
    covered: dict[str, float]


def _over_feet(name: str, axis: int | tuple[int, ...] | None = None) -> Any:
    """Return a property: the mean over the feet of a figure, of one of its axes, or of each."""

    def mean(self: "ForceComparison") -> Any:
        found = [getattr(foot, name) for foot in self.feet]
        if isinstance(axis, tuple):
            return tuple(known_mean(each[k] for each in found) for k in axis)
        return known_mean(found if axis is None else [each[axis] for each in found])

    return property(mean)


@dataclass(frozen=True)
class ForceComparison:
    """Comparison of the forces of a gait with measured ones; figures are means over its feet."""

    time: Float[Array, " n"]  #: Recorded frames [s]
    feet: tuple[FootComparison, ...]  #: Feet on a plate
    residual: float  #: Maximum residual force at the root [body weights]

    @property
    def sides(self) -> tuple[str, ...]:
        """Sides of the feet on a plate."""
        return tuple(foot.side for foot in self.feet)

    vertical_rmse = _over_feet("force_rmse", 2)  #: RMS difference of vertical forces [body weights]
    vertical_r = _over_feet("force_r", 2)  #: Correlation of vertical forces
    forward_rmse = _over_feet("force_rmse", 0)  #: RMS difference of forward forces [body weights]
    forward_r = _over_feet("force_r", 0)  #: Correlation of forward forces
    sideways_rmse = _over_feet("force_rmse", 1)  #: RMS difference of lateral forces [body weights]
    sideways_r = _over_feet("force_r", 1)  #: Correlation of lateral forces
    #: RMS distance of the centres of pressure along x and y [m]
    pressure_rmse_m = _over_feet("pressure_rmse_m", (0, 1))
    #: Median distance of the centres of pressure along x and y [m]
    pressure_median_m = _over_feet("pressure_median_m", (0, 1))
    #: Mean error of the centres of pressure forward and to the left [m]
    pressure_ahead_m = _over_feet("pressure_ahead_m", (0, 1))
    #: Mean backward travel of the centre of pressure in a stance [m]
    backward_m = _over_feet("backward_m")
    #: Mean backward travel of the measured centre of pressure [m]
    backward_measured_m = _over_feet("backward_measured_m")

    @property
    def forward_nrmse(self) -> float:
        """RMS difference of forward forces relative to the measured range [%]."""
        shares = (_share(foot.force_rmse[0], foot.force_range[0]) for foot in self.feet)
        return 100.0 * known_mean(shares)

    @property
    def moment_rmse(self) -> dict[str, float]:
        """RMS difference of the moments of each joint [N m/kg]."""
        return _means(foot.moment_rmse for foot in self.feet)

    @property
    def moment_r(self) -> dict[str, float]:
        """Correlation of the moments of each joint."""
        return _means(foot.moment_r for foot in self.feet)

    @property
    def covered(self) -> dict[str, float]:
        """Share of frames with the measured value inside the error band."""
        return _means(foot.covered for foot in self.feet)

    def metrics(self) -> dict[str, float]:
        """Return all figures, flat."""
        flat = {
            "vertical_force_rmse_bw": self.vertical_rmse,
            "vertical_force_correlation": self.vertical_r,
            "forward_force_rmse_bw": self.forward_rmse,
            "forward_force_correlation": self.forward_r,
            "forward_force_nrmse_pct": self.forward_nrmse,
            "sideways_force_rmse_bw": self.sideways_rmse,
            "sideways_force_correlation": self.sideways_r,
            "pressure_x_rmse_mm": 1e3 * self.pressure_rmse_m[0],
            "pressure_y_rmse_mm": 1e3 * self.pressure_rmse_m[1],
            "pressure_x_error_median_mm": 1e3 * self.pressure_median_m[0],
            "pressure_y_error_median_mm": 1e3 * self.pressure_median_m[1],
            "pressure_x_ahead_mm": 1e3 * self.pressure_ahead_m[0],
            "pressure_backward_mm": 1e3 * self.backward_m,
            "forced_root_residual_bw": self.residual,
        }
        r = self.moment_r
        for joint, value in self.moment_rmse.items():
            flat[f"{joint}_moment_rmse_nm_kg"] = value
            flat[f"{joint}_moment_correlation"] = r[joint]
        return flat | {f"{what}_in_band_pct": 100.0 * x for what, x in self.covered.items()}


def compare_forces(
    forced: Record,
    measured: Record,
    *,
    ground: Float[Array, "n_frames 3"] | None = None,
    belt: Float[Array, "n_frames 3"] | None = None,
) -> ForceComparison:
    """Compare the forces of a gait with measured ones, foot by foot, in stance.

    Args:
        forced: The gait with estimated or simulated forces.
        measured: The fitted recording with its measured forces and joint moments.
        ground: Path of a treadmill's belt [m], to which the measured centres of pressure are
            relative; at rest if absent.
        belt: The same if both motions are on that belt.
    """
    assert forced.qfrc_actuator is not None
    clock = forced.motion.time
    frames = even_clock(measured.motion.time)
    inside = (frames >= clock[0]) & (frames <= clock[-1])
    rest = np.zeros((len(frames), 3))
    ways = rest if belt is None else belt, rest if ground is None else ground
    feet = (_compare_foot(forced, measured, side, frames, inside, ways) for side in SIDES)
    return ForceComparison(
        time=frames[inside],
        feet=tuple(foot for foot in feet if foot is not None),
        residual=float(np.abs(forced.qfrc_actuator[:, :6]).max() / forced.weight),
    )


def _compare_foot(
    forced: Record,
    measured: Record,
    side: str,
    frames: Array,
    inside: Array,
    ways: tuple[Array, Array],
) -> FootComparison | None:
    """Compare one foot; None if too few frames of its stance were measured."""
    time, clock, weight = frames[inside], forced.motion.time, forced.weight
    ours, theirs = forced.foot(side), measured.foot(side)
    load = theirs.force[inside] / weight
    is_known = np.interp(time, clock, ours.known.astype(float)) > 0.999
    known = theirs.measured[inside] & is_known
    stance = known & (load[:, 2] > STANCE_LOAD)
    if stance.sum() < MIN_FRAMES:
        return None
    simulated = interpolate(time, clock, ours.force / weight)
    both, theirs_alone = (way[inside] for way in ways)
    point = interpolate(time, clock, ours.centre_of_pressure) - both
    recorded = theirs.centre_of_pressure[inside] - both - theirs_alone
    loaded = stance & (simulated[:, 2] > STANCE_LOAD)
    pressure_error = (point - recorded)[loaded, :2]
    curves = {
        joint: (
            np.interp(time, clock, forced.torque(f"{joint}_{side}"))[stance] / forced.human.mass,
            measured.torque(f"{joint}_{side}")[inside][stance] / forced.human.mass,
        )
        for joint in JOINTS
        if measured.qfrc_actuator is not None
        and f"{joint}_{side}" in measured.human.coordinates
        and f"{joint}_{side}" in forced.human.coordinates
    }
    force = [compare_curves(simulated[stance, k], load[stance, k]) for k in range(3)]
    moment = {joint: compare_curves(a, b) for joint, (a, b) in curves.items()}
    return FootComparison(
        side=side,
        stance=stance,
        known=known,
        simulated=simulated,
        measured=load,
        force_r=tuple(axis.correlation for axis in force),
        force_rmse=tuple(axis.rmse for axis in force),
        force_range=tuple(float(np.ptp(load[stance, k])) for k in range(3)),
        pressure_median_m=tuple(_median(np.abs(pressure_error[:, k])) for k in (0, 1)),
        pressure_rmse_m=tuple(root_mean_square(pressure_error[:, k]) for k in (0, 1)),
        pressure_ahead_m=tuple(known_mean(pressure_error[:, k]) for k in (0, 1)),
        backward_m=_backward(point[:, 0], loaded),
        backward_measured_m=_backward(recorded[:, 0], loaded),
        moment_rmse={joint: found.rmse for joint, found in moment.items()},
        moment_r={joint: found.correlation for joint, found in moment.items()},
        covered=_covered(forced, measured, side, frames, inside, stance, loaded, pressure_error),
    )


def _covered(
    forced: Record,
    measured: Record,
    side: str,
    frames: Array,
    inside: Array,
    stance: Array,
    loaded: Array,
    pressure_error: Array,
) -> dict[str, float]:
    """Return the share of stance frames with the measured value inside each band."""
    if "forces.band" not in forced.signals:
        return {}
    time, clock, k = frames[inside], forced.motion.time, SIDES.index(side)
    ours, theirs = forced.foot(side), measured.foot(side)

    def band(name: str, column) -> Array:
        return np.interp(time, clock, forced.signals[name][(slice(None), *column)])

    def share(off: Array, half: Array) -> float:
        known = np.isfinite(off) & np.isfinite(half)
        return float(np.mean(np.abs(off)[known] <= half[known])) if known.any() else float("nan")

    found = {}
    force = interpolate(time, clock, ours.force) - theirs.force[inside]
    for axis, name in enumerate(AXES):
        half = band("forces.band", (k, axis))
        found[f"{name}_force"] = share(force[stance, axis], half[stance])
    for axis, name in enumerate("xy"):
        half = band("forces.point_band", (k, axis))
        found[f"pressure_{name}"] = share(pressure_error[:, axis], half[loaded])
    torque = np.interp(time, clock, ours.torque[:, 2]) - theirs.torque[inside, 2]
    found["free_moment"] = share(torque[stance], band("forces.torque_band", (k,))[stance])
    for joint in JOINTS:
        name = f"{joint}_{side}"
        if measured.qfrc_actuator is None or name not in measured.human.coordinates:
            continue
        off = np.interp(time, clock, forced.torque(name)) - measured.torque(name)[inside]
        half = band("forces.moment_band", (6 + forced.motion.hinge(name),))
        found[f"{joint}_moment"] = share(off[stance], half[stance])
    return found


def measured_signals(forced: Record, measured: Record) -> dict[str, Array]:
    """Return measured forces and moments at the ticks of a gait, as signals of its record.

    The signals are ``measured.force`` (n, 2, 3) right and left [N], and ``measured.moment`` (n, m)
    [N m/kg] with ``measured.moment_names``; NaN if not measured. The result is empty without any.
    """
    now, frames, human = forced.motion.time, measured.motion.time, forced.human
    names = [f"{n}_{s}" for n in SIGNAL_JOINTS for s in SIDES if f"{n}_{s}" in human.coordinates]
    force, moment = np.full((len(now), 2, 3), np.nan), np.full((len(now), len(names)), np.nan)
    for k, side in enumerate(SIDES):
        foot = measured.foot(side)
        known = np.interp(now, frames, foot.measured.astype(float)) > 0.999
        force[known, k] = interpolate(now, frames, foot.force)[known]
        for i, name in enumerate(names):
            if name.endswith(f"_{side}") and measured.qfrc_actuator is not None:
                here = np.interp(now, frames, measured.torque(name) / human.mass)
                moment[known, i] = here[known]
    if not np.isfinite(force).any():
        return {}
    return {
        "measured.force": force,
        "measured.moment": moment,
        "measured.moment_names": np.array(names, dtype=np.str_),
    }


def _backward(path: Array, there: Array) -> float:
    """Return the backward travel of a path within a stance, mean over stances [m]."""
    stances = [path[run] for run in runs(there) if run.stop - run.start >= MIN_FRAMES]
    ways = [float(-np.minimum(np.diff(x), 0.0).sum()) for x in stances]
    return known_mean(ways)


def _means(tables: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Return the mean of each entry over tables."""
    values: dict[str, list[float]] = {}
    for table in tables:
        for name, value in table.items():
            values.setdefault(name, []).append(value)
    return {name: known_mean(found) for name, found in values.items()}


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else float("nan")


def _median(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")
