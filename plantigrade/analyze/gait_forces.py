"""Ground reactions and joint moments of a gait rebuilt by forces, beside the measured ones.

Nothing measured enters the rebuilt gait. A foot is compared over the recorded frames in which its
force is known, swing included, if it was loaded at all in them: the zeros of a foot that
never stood on a plate say little.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.analyze.statistics import correlation
from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.motion.recording import even_clock
from plantigrade.motion.resample import interpolate
from plantigrade.record import Record

LOADED = 0.2  # centres of pressure are compared where both loads exceed this [body weights]
JOINTS = ("hip_flexion", "knee_angle", "ankle_angle")
SHOWN = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")


@dataclass(frozen=True)
class ForceComparison:
    """Forces of a rebuilt gait against the measured ones."""

    time: Float[Array, " n"]  #: Recorded frames of the rebuilt gait [s]
    sides: tuple[str, ...]  #: Feet that were loaded on a plate
    known: dict[str, Bool[Array, " n"]]  #: Where the force of each foot is known, by side
    #: Ground reaction on each foot, by side [body weights]
    simulated: dict[str, Float[Array, "n 3"]]
    measured: dict[str, Float[Array, "n 3"]]  #: The same, measured
    vertical_rmse: float  #: Root mean square difference of vertical forces, all feet [body weights]
    vertical_r: float  #: Their correlation
    forward_rmse: float  #: The same of the forces forward
    sideways_rmse: float  #: The same of the forces sideways
    #: Root mean square distance of the centres of pressure along x and y [m]
    pressure_rmse_m: tuple[float, float]
    #: Of the moments of each joint [N m/kg]; empty without inverse dynamics
    moment_rmse: dict[str, float]
    moment_r: dict[str, float]  #: Their correlation
    residual: float  #: Greatest unexplained force at the root [body weights]

    def metrics(self) -> dict[str, float]:
        """Return all figures, flat."""
        flat = {
            "vertical_force_rmse_bw": self.vertical_rmse,
            "vertical_force_correlation": self.vertical_r,
            "forward_force_rmse_bw": self.forward_rmse,
            "sideways_force_rmse_bw": self.sideways_rmse,
            "pressure_x_rmse_mm": 1e3 * self.pressure_rmse_m[0],
            "pressure_y_rmse_mm": 1e3 * self.pressure_rmse_m[1],
            "forced_root_residual_bw": self.residual,
        }
        for joint, value in self.moment_rmse.items():
            flat[f"{joint}_moment_rmse_nm_kg"] = value
            flat[f"{joint}_moment_correlation"] = self.moment_r[joint]
        return flat


def compare_forces(
    forced: Record,
    measured: Record,
    *,
    ground: Float[Array, "n_frames 3"] | None = None,
) -> ForceComparison:
    """Hold the forces of a rebuilt gait against the measured ones.

    Args:
        forced: The gait rebuilt by forces.
        measured: The fitted recording with its measured forces and joint moments.
        ground: Path of the ground itself, a treadmill's belt [m]; at rest if absent.
    """
    assert forced.qfrc_actuator is not None
    clock, weight = forced.motion.time, forced.weight
    frames = even_clock(measured.motion.time)
    inside = (frames >= clock[0]) & (frames <= clock[-1])
    time = frames[inside]
    way = np.zeros((len(time), 3)) if ground is None else ground[inside]
    known, simulated, recorded = {}, {}, {}
    apart, pairs = [], {joint: ([], []) for joint in JOINTS}
    for side in SIDES:
        ours, theirs = forced.foot(side), measured.foot(side)
        sure = theirs.known[inside]
        load = theirs.force[inside] / weight
        if not (sure & (load[:, 2] > LOADED)).any():
            continue
        known[side], recorded[side] = sure, load
        simulated[side] = interpolate(time, clock, ours.force / weight)
        both = sure & (load[:, 2] > LOADED) & (simulated[side][:, 2] > LOADED)
        centre = theirs.centre_of_pressure[inside] - way
        difference = interpolate(time, clock, ours.centre_of_pressure) - centre
        apart.append(difference[both])
        for joint, (computed, inverse) in pairs.items():
            name = f"{joint}_{side}"
            if measured.qfrc_actuator is not None and name in measured.human.coordinates:
                computed.append(np.interp(time, clock, forced.torque(name))[sure])
                inverse.append(measured.torque(name)[inside][sure])
    sides = tuple(known)
    ours = np.concatenate([np.zeros((0, 3)), *(simulated[s][known[s]] for s in sides)])
    theirs = np.concatenate([np.zeros((0, 3)), *(recorded[s][known[s]] for s in sides)])
    rmse = _rms(ours - theirs)
    pressure = _rms(np.concatenate([np.zeros((0, 3)), *apart]))
    pairs = {j: (np.concatenate(a), np.concatenate(b)) for j, (a, b) in pairs.items() if a}
    return ForceComparison(
        time=time,
        sides=sides,
        known=known,
        simulated=simulated,
        measured=recorded,
        vertical_rmse=rmse[2],
        vertical_r=correlation(ours[:, 2], theirs[:, 2]) if sides else float("nan"),
        forward_rmse=rmse[0],
        sideways_rmse=rmse[1],
        pressure_rmse_m=(pressure[0], pressure[1]),
        moment_rmse={
            j: _rms((a - b)[:, None])[0] / forced.human.mass for j, (a, b) in pairs.items()
        },
        moment_r={j: correlation(a, b) for j, (a, b) in pairs.items()},
        residual=float(np.abs(forced.qfrc_actuator[:, :6]).max() / forced.weight),
    )


def measured_signals(forced: Record, measured: Record) -> dict[str, Array]:
    """Return measured forces and moments at the ticks of a rebuilt gait, as signals of its record.

    ``measured.force`` (n, 2, 3) right and left [N], ``measured.moment`` (n, m) [N m/kg] with
    ``measured.moment_names``; NaN where not known. Empty where nothing is known.
    """
    now, frames, human = forced.motion.time, measured.motion.time, forced.human
    names = [f"{n}_{s}" for n in SHOWN for s in SIDES if f"{n}_{s}" in human.coordinates]
    force, moment = np.full((len(now), 2, 3), np.nan), np.full((len(now), len(names)), np.nan)
    for k, side in enumerate(SIDES):
        foot = measured.foot(side)
        known = np.interp(now, frames, foot.known.astype(float)) > 0.999
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


def _rms(values: np.ndarray) -> list[float]:
    if not len(values):
        return [float("nan")] * values.shape[1]
    return [float(x) for x in np.sqrt(np.nanmean(values**2, axis=0))]
