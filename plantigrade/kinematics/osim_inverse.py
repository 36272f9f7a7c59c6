r"""Inverse kinematics of markers with a person's own OpenSim model.

Per frame, the coordinates :math:`u` of the model with

.. math:: \min_u \sum_i \lVert x_i^{exp} - x_i(f(u)) \rVert^2
    \quad \text{s.t.} \quad \underline u \le u \le \bar u,

all markers with one weight, as OpenSim's tool has them by default. Bounds are the ranges of
coordinates that the file clamps; locked ones keep their default.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FitError
from plantigrade.io.osim_body import OsimHuman
from plantigrade.kinematics.inverse import bounded_step
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.motion import Markers, Table

MIN_MARKERS = 6  # on the model and in the recording; a person with fewer is undetermined
MIN_SEEN = 3  # markers of a frame that place the root
PULL_TO_LAST_FRAME = 1e-6  # [m²/rad²] for coordinates that no marker sees
TOLERANCE = 1e-5  # [rad, m] step at which a frame is solved
MAX_STEPS = 100  # Gauss-Newton steps of a frame
HEADINGS = np.deg2rad([0.0, 90.0, 180.0, 270.0])  # tried in the first frame


@dataclass(frozen=True)
class OsimFit:
    """A recording on a person's own model."""

    human: OsimHuman
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    u: Float[Array, "n_frames n_coordinates"]  #: Coordinates of the model [rad, m]
    notes: tuple[str, ...]  #: Warnings, one sentence each
    #: The recorded markers that the model has, on these frames; None for joint angles
    markers: Markers | None = None
    #: Distance of each from the model's [m]
    residual: Float[Array, "n_frames n_markers"] | None = None


def fit_osim(human: OsimHuman, recorded: Markers) -> OsimFit:
    """Return the motion of a model that follows recorded markers best.

    Frames with fewer than three markers are interpolated, or left out at both ends.

    Args:
        recorded: Markers, world axes [m].
    """
    spelled = {name.lower(): name for name in human.places}
    names = [name for name in recorded.names if name.lower() in spelled]
    if len(names) < MIN_MARKERS:
        raise FitError(
            f"the recording and the model share {len(names)} marker names, at least {MIN_MARKERS} "
            f"are needed; the model has {', '.join(list(human.places)[:12]) or 'no markers'}, the "
            f"recording {', '.join(recorded.names[:12])}"
        )
    notes = []
    if others := [name for name in recorded.names if name not in names]:
        notes.append(f"markers that the model lacks were not used: {', '.join(others)}.")
    markers = recorded.select(names)
    seen = np.asarray(np.isfinite(markers.positions).all(axis=2))
    placed = np.flatnonzero(seen.sum(axis=1) >= MIN_SEEN)
    if not len(placed):
        raise FitError(f"no frame shows {MIN_SEEN} markers of the model at once")
    part = slice(int(placed[0]), int(placed[-1]) + 1)
    if (left := len(seen) - (part.stop - part.start)) > 0:
        notes.append(f"{left} frames at the ends show too few markers and were left out.")
    markers = Markers(markers.names, markers.time[part], markers.positions[part])
    points = PointSet.of(human, [human.places[spelled[name.lower()]] for name in names])
    solver = OsimInverse(points)
    n, k = len(markers.time), len(human.every_coordinate)
    u, residual = np.full((n, k), np.nan), np.full((n, len(names)), np.nan)
    last = solver.start(markers.positions[0])
    for frame in placed - part.start:
        last = solver.solve(markers.positions[frame], last)
        u[frame], residual[frame] = last, solver.distance(markers.positions[frame], last)
    missing = np.isnan(u[:, 0])
    if missing.any():
        notes.append(f"{missing.sum()} frames show too few markers and were interpolated.")
        for column in u.T:
            column[missing] = np.interp(
                markers.time[missing], markers.time[~missing], column[~missing]
            )
    return OsimFit(human, markers.time, u, tuple(notes), markers, residual)


def take_coordinates(human: OsimHuman, recorded: Table) -> OsimFit:
    """Return the motion of a model whose coordinates were computed elsewhere.

    Coordinates that the recording lacks keep their default.

    Args:
        recorded: Coordinates [rad, m], knee flexion positive.
    """
    known = [c.name for c in human.every_coordinate]
    shared = [name for name in recorded.names if name in known]
    if not shared:
        raise FitError(
            f"the recording has none of the coordinates of the model: {', '.join(known[:12])}"
        )
    u = np.tile(human.defaults(), (len(recorded.time), 1))
    for name in shared:
        k = known.index(name)
        u[:, k] = recorded[name] * human.signs[k]
    if not np.isfinite(u).all():
        raise FitError("coordinates of the recording have gaps; fill them first")
    lacking = [name for name in known if name not in shared]
    unknown = [name for name in recorded.names if name not in known]
    notes = []
    if lacking:
        notes.append(f"coordinates without a value kept their default: {', '.join(lacking)}.")
    if unknown:
        notes.append(f"columns that are no coordinate of the model: {', '.join(unknown)}.")
    return OsimFit(human, recorded.time, u, tuple(notes))


class OsimInverse:
    """Solves frame after frame."""

    def __init__(self, points: PointSet):
        human = points.human
        assert isinstance(human, OsimHuman)
        self.human, self.points = human, points
        self.state = BodyState(human, human.standing())
        every = human.every_coordinate
        self.free = np.array([not c.locked for c in every])
        self.low = np.array([c.low if c.clamped else -np.inf for c in every])
        self.high = np.array([c.high if c.clamped else np.inf for c in every])

    def places(self, u: Float[Array, " k"]) -> Float[Array, "n_points 3"]:
        """Return where the markers of the model are [m]."""
        return self._at(u).position(self.points)

    def distance(
        self, measured: Float[Array, "n_points 3"], u: Float[Array, " k"]
    ) -> Float[Array, " n_points"]:
        """Return the distance of each marker from the model's [m]; NaN where not seen."""
        return np.linalg.norm(measured - self.places(u), axis=1)

    def start(self, measured: Float[Array, "n_points 3"]) -> Float[Array, " k"]:
        """Return coordinates for the first frame: the best of four headings."""
        human, names = self.human, [c.name for c in self.human.every_coordinate]
        turning = [a for a in human.root.axes if not a.slides and abs(a.direction[1]) > 0.9]
        found = []
        for heading in HEADINGS if turning else HEADINGS[:1]:
            u = human.defaults()
            for axis in turning:
                if axis.coordinate is not None:
                    u[names.index(axis.coordinate)] += heading
            u = self._moved_onto(measured, u, names)
            found.append(self.solve(measured, u))
        return min(found, key=lambda u: float(np.nansum(self.distance(measured, u) ** 2)))

    def _moved_onto(self, measured, u, names) -> Float[Array, " k"]:
        """Return coordinates whose root is moved by the mean distance of the markers."""
        off = np.nanmean(measured - self.places(u), axis=0)
        G = self.human.slopes(u)[:3]
        slides = [
            names.index(a.coordinate)
            for a in self.human.root.axes
            if a.slides and a.coordinate is not None
        ]
        u = u.copy()
        u[slides] += np.linalg.lstsq(G[:, slides], off, rcond=None)[0]
        return u

    def solve(
        self, measured: Float[Array, "n_points 3"], start: Float[Array, " k"]
    ) -> Float[Array, " k"]:
        """Return the coordinates whose markers are nearest to the measured ones.

        Args:
            measured: World positions [m]; NaN rows are left out.
            start: Coordinates to start from, which unseen ones keep.
        """
        seen = np.isfinite(measured).all(axis=1)
        u = np.where(self.free, np.clip(start, self.low, self.high), start)
        rest, free = u.copy(), self.free
        damping, state = 1e-9, self._at(u)
        error = self._error(measured, state, u - rest, seen)
        for _ in range(MAX_STEPS):
            J = state.jacobian(self.points)[seen].reshape(-1, len(state.qvel))
            J = J @ self.human.slopes(u)[:, free]
            r = (measured - state.position(self.points))[seen].ravel()
            H, g = J.T @ J, J.T @ r + PULL_TO_LAST_FRAME * (rest - u)[free]
            H[np.diag_indices(len(H))] += PULL_TO_LAST_FRAME + damping
            step = bounded_step(H, g, (self.low - u)[free], (self.high - u)[free])
            tried = u.copy()
            tried[free] += step
            there = self._at(tried)
            reached = self._error(measured, there, tried - rest, seen)
            if reached <= error * (1 + 1e-12):
                u, error, state, damping = tried, reached, there, max(damping / 10, 1e-9)
                if np.abs(step).max() < TOLERANCE:
                    break
            else:
                damping = max(damping * 30, 1e-5)
                if damping > 1e3:
                    break
        return u

    def _at(self, u: Float[Array, " k"]) -> BodyState:
        return self.state.moved_to(self.human.poses(u[None])[0])

    def _error(self, measured, state: BodyState, moved, seen) -> float:
        away = (measured - state.position(self.points))[seen]
        return float(np.sum(away**2) + PULL_TO_LAST_FRAME * np.sum(moved**2))
