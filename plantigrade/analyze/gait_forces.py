"""Ground reactions and joint moments of a gait rebuilt by forces, beside the measured ones.

Nothing measured enters the rebuilt gait. A foot is compared over the recorded frames in which its
plate tells its force, swing included, if it was loaded at all in them: the zeros of a foot that
never stood on a plate say little.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.analyze.statistics import correlation
from plantigrade.arrays import Array, Bool, Float
from plantigrade.dynamics.inverse import Moments
from plantigrade.dynamics.plates import FootForces
from plantigrade.reproduce.reference import SIDES, Reference

LOADED = 0.2  # centres of pressure are compared where both loads exceed this [body weights]
JOINTS = ("hip_flexion", "knee_angle", "ankle_angle")


@runtime_checkable
class MovedByForces(Protocol):
    """A motion with the forces that move it, from wherever: rebuilt by tasks, or optimised."""

    @property
    def time(self) -> Float[Array, " n"]:
        """Time of each frame, on the clock of the recording [s]."""
        ...

    @property
    def qpos(self) -> Float[Array, "n nq"]:
        """Configurations."""
        ...

    @property
    def qvel(self) -> Float[Array, "n nv"]:
        """Velocities."""
        ...

    @property
    def tau(self) -> Float[Array, "n nv"]:
        """Generalised forces: the root's, then joint moments [N m]."""
        ...

    @property
    def root_residual(self) -> Float[Array, "n 6"]:
        """What nothing explains at the root [N, N m]."""
        ...

    def foot(self, side: str) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
        """Return the ground reaction on a foot [N] and its centre of pressure [m]."""
        ...


@dataclass(frozen=True)
class ForceComparison:
    """Forces of a rebuilt gait against the measured ones.

    Attributes:
        time: Recorded frames of the rebuilt gait [s].
        sides: Feet that were loaded on a plate.
        known: Where the force of each foot is known, by side.
        simulated: Ground reaction on each foot, by side [body weights].
        measured: The same, measured.
        vertical_rmse: Root mean square difference of vertical forces, all feet [body weights].
        vertical_r: Their correlation.
        forward_rmse: The same of the forces forward.
        sideways_rmse: The same of the forces sideways.
        pressure_rmse_m: Root mean square distance of the centres of pressure along x and y [m].
        moment_rmse: Of the moments of each joint [N m/kg]; empty without inverse dynamics.
        moment_r: Their correlation.
        residual: Greatest unexplained force at the root [body weights].
        com_error_m: Greatest distance of the centre of mass from its recorded path [m].
    """

    time: Float[Array, " n"]
    sides: tuple[str, ...]
    known: dict[str, Bool[Array, " n"]]
    simulated: dict[str, Float[Array, "n 3"]]
    measured: dict[str, Float[Array, "n 3"]]
    vertical_rmse: float
    vertical_r: float
    forward_rmse: float
    sideways_rmse: float
    pressure_rmse_m: tuple[float, float]
    moment_rmse: dict[str, float]
    moment_r: dict[str, float]
    residual: float
    com_error_m: float

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
            "forced_com_error_max_mm": 1e3 * self.com_error_m,
        }
        for joint, value in self.moment_rmse.items():
            flat[f"{joint}_moment_rmse_nm_kg"] = value
            flat[f"{joint}_moment_correlation"] = self.moment_r[joint]
        return flat


def compare_forces(
    reference: Reference,
    forced: MovedByForces,
    forces: FootForces,
    moments: Moments | None = None,
    *,
    ground: Float[Array, "n_frames 3"] | None = None,
) -> ForceComparison:
    """Hold the forces of a rebuilt gait against the measured ones.

    Args:
        reference: The recorded gait.
        forced: The gait rebuilt by forces.
        forces: The measured forces, on the frames of the recording.
        moments: Joint moments from them, on the same frames.
        ground: Path of the ground itself, a treadmill's belt [m]; at rest if absent.
    """
    human = reference.human
    weight = human.mass * float(np.linalg.norm(human.model.opt.gravity))
    inside = (reference.time >= forced.time[0]) & (reference.time <= forced.time[-1])
    time = reference.time[inside]
    way = np.zeros((len(time), 3)) if ground is None else ground[inside]
    known, simulated, measured = {}, {}, {}
    apart, pairs = [], {joint: ([], []) for joint in JOINTS}
    for k, side in enumerate(SIDES):
        sure = forces.valid_side[inside, k]
        load = forces.force[inside, k] / weight
        if not (sure & (load[:, 2] > LOADED)).any():
            continue
        force, centre = forced.foot(side)
        known[side], measured[side] = sure, load
        simulated[side] = _on(time, forced.time, force / weight)
        both = sure & (load[:, 2] > LOADED) & (simulated[side][:, 2] > LOADED)
        difference = _on(time, forced.time, centre) - (forces.point[inside, k] - way)
        apart.append(difference[both])
        for joint, (ours, theirs) in pairs.items():
            name = f"{joint}_{side}"
            if moments is not None and name in moments.names:
                column = 6 + human.hinge(name)
                ours.append(_on(time, forced.time, forced.tau[:, column : column + 1])[sure, 0])
                theirs.append(moments[name][inside][sure])
    sides = tuple(known)
    ours = np.concatenate([np.zeros((0, 3)), *(simulated[s][known[s]] for s in sides)])
    theirs = np.concatenate([np.zeros((0, 3)), *(measured[s][known[s]] for s in sides)])
    rmse = _rms(ours - theirs)
    pressure = _rms(np.concatenate([np.zeros((0, 3)), *apart]))
    pairs = {j: (np.concatenate(a), np.concatenate(b)) for j, (a, b) in pairs.items() if a}
    return ForceComparison(
        time=time,
        sides=sides,
        known=known,
        simulated=simulated,
        measured=measured,
        vertical_rmse=rmse[2],
        vertical_r=correlation(ours[:, 2], theirs[:, 2]) if sides else float("nan"),
        forward_rmse=rmse[0],
        sideways_rmse=rmse[1],
        pressure_rmse_m=(pressure[0], pressure[1]),
        moment_rmse={j: _rms((a - b)[:, None])[0] / human.mass for j, (a, b) in pairs.items()},
        moment_r={j: correlation(a, b) for j, (a, b) in pairs.items()},
        residual=float(np.abs(forced.root_residual).max() / weight),
        com_error_m=com_error(reference, forced),
    )


def com_error(reference: Reference, forced: MovedByForces) -> float:
    """Return the greatest distance of the centre of mass from its recorded path [m]."""
    from plantigrade.dynamics.centroid import centroid

    path = centroid(reference.human, forced.qpos, forced.qvel).com
    wanted = np.array([reference.com(float(t))[0] for t in forced.time])
    return float(np.linalg.norm(path - wanted, axis=1).max())


def _on(time, clock, values) -> np.ndarray:
    return np.stack([np.interp(time, clock, column) for column in values.T], axis=1)


def _rms(values: np.ndarray) -> list[float]:
    if not len(values):
        return [float("nan")] * values.shape[1]
    return [float(x) for x in np.sqrt(np.nanmean(values**2, axis=0))]
