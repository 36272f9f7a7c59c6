"""The quadratic program of ground forces: solving, noise, abrupt transfers."""

from typing import Any

import numpy as np
import scipy.sparse as sp

from plantigrade.arrays import root_mean_square
from plantigrade.constants import FRICTION
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_bands import (
    NOISE_TIME,
    Spread,
    drawn_errors,
    errors_without_gait,
    spread_of,
)
from plantigrade.dynamics.force_contacts import contact_frames, lasting, measured_wrenches
from plantigrade.dynamics.force_rows import N_GLOBAL, ForceLayout, limits, objective
from plantigrade.dynamics.force_scales import ForceScales
from plantigrade.dynamics.loading import Support, completed
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.quadratic import solve_quadratic
from plantigrade.dynamics.required_forces import RequiredForces
from plantigrade.models import Human
from plantigrade.motion.filters import runs

MIN_PRESSURE_LOAD = 0.01  # [BW] minimum load for centre of pressure and free moment
NET_ROWS = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
NOISE_ROWS = [0, 1, 3, 4]  # components of the net wrench used to estimate the noise of the motion
MAX_NOISE_ROUNDS = 3  # [1] maximum number of solutions while the noise estimate converges
# [1/s²] RMS of the second derivative over that of white noise up to 5 Hz
NOISE_ROUGHNESS = (2 * np.pi * 5.0) ** 2 / np.sqrt(5.0)
# [1] residuals of the rows in recordings with little noise, relative to the expected ones
USUAL_RESIDUALS = (1.0, 1.0, 1.0, 0.85, 0.7, 1.0)
SEAT_BENDING = 5.0  # [1] factor of the curvature of forces near seat-off and seat-on
SEAT_BENDING_TIME = 0.1  # [s] duration of this factor
# [1] factor of the curvature of forces in a double support with abrupt load transfer
ABRUPT_BENDING = 3.0
# [1] minimum decrease of the misfit for this factor, in squared standard deviations of independent
# rows; six recordings gain up to 6, with 1 mm and 0.3° of noise up to 10, abrupt transfers 10 to 50
MIN_MISFIT_GAIN = 12.0
MISFIT_MARGIN = 0.03  # [s] margin of a double support for its misfit
MOTION_BLOCKS = ("force", "moment", "noise", "path", "side", "free")  # rows of motion and feet


class ForceProgram:
    """Quadratic program of one recording with its solution and confidence bands.

    Attributes:
        wrench: The estimate (n, k, 6) [BW, BW m].
        shift: Shift of the centre of mass [m].
        noise: Noise of force x, y, z and moment x, y, z relative to the assumed noise [1].
        residual_force: Root mean square of the net force that is missed in addition to the noise
            [BW].
        residual_moment: The same of the pitch and roll moment [BW m].
    """

    def __init__(
        self,
        human: Human,
        needs: RequiredForces,
        contacts: tuple[ContactInterval, ...],
        supports: tuple[Support, ...],
        data: FootForces | None,
        scales: ForceScales,
    ):
        self.needs, self.scales, self.contacts = needs, scales, contacts
        n, first, last = len(needs.time), needs.time[0], needs.time[-1]
        self.dt = float(needs.time[1] - first)
        whole = completed(contacts, first, last)
        more = max((e for c in whole for e in (first - c.start, c.stop - last)), default=0.0)
        beyond = max(0, int(np.ceil(more / self.dt)))
        self.inside = slice(beyond, beyond + n)
        wide = needs.held(beyond, beyond)
        whole = tuple(lasting(c, (beyond + 1) * self.dt) for c in whole)
        contact, ramp, path = contact_frames(
            wide, whole, supports, scales, human.dimensions.foot_length
        )
        self.known = np.zeros(contact.shape, bool)
        measured = np.zeros((*contact.shape, 6))
        if data is not None:
            now = self.inside
            self.known[now, :2], measured[now, :2], carried = measured_wrenches(data, needs)
            contact[now, :2] = np.where(self.known[now, :2], carried, contact[now, :2])
        contact[:beyond] &= contact[beyond]
        contact[beyond + n :] &= contact[beyond + n - 1]
        self.layout = ForceLayout.of(contact)
        rows = objective(wide, self.layout, path, effort=scales.effort < np.inf)
        A, b = rows.system()
        self.blocks, self.place = rows.blocks, rows.place
        start = self.layout.start
        fixed = self.known & contact
        x = np.zeros(self.layout.size)
        x[(start[fixed][:, None] + np.arange(6)).ravel()] = measured[fixed].ravel()
        free = contact & ~self.known
        is_known = np.zeros(self.layout.size, bool)
        is_known[(start[fixed][:, None] + np.arange(6)).ravel()] = True
        self.unknown = np.flatnonzero(~is_known)
        self.x, self.b, self.A = x, b - A @ x, A[:, self.unknown].tocsr()
        G, self.h = sp.csr_array((1, self.layout.size)), np.ones(1)
        if free.any():
            G, self.h = limits(wide, self.layout, free, ramp, FRICTION, scales.most_free).system()
        self.G = G[:, self.unknown].tocsr()
        time = wide.time
        #: Factor of the curvature of forces and joint moments in every frame
        self.bending = np.ones(len(time))
        for each in contacts:
            for edge, seen in ((each.start, each.begins), (each.stop, each.ends)):
                if seen and not each.side:
                    self.bending[np.abs(time - edge) < SEAT_BENDING_TIME] = SEAT_BENDING

    def weights(self, noise: np.ndarray) -> np.ndarray:
        """Return the weight of each row for relative noise of force x, y, z and moment x, y, z."""
        s, w = self.scales, np.empty(len(self.b))
        white = np.array([*s.force, *(s.moment,) * 3])
        scale = dict(zip(NET_ROWS, white * noise, strict=True))
        sway = np.array([*s.sway, *(s.turn,) * 3]) * noise / NOISE_ROUGHNESS
        scale |= {f"noise{i}": v for i, v in enumerate(sway)}
        scale |= {f"bend{i}": v for i, v in enumerate((*s.bend, *s.twist))}
        scale |= {"free": s.free, "path_x": s.path, "path_y": s.path, "side": s.side}
        scale["share"] = s.share
        scale |= {"shear0": s.shear, "shear1": s.shear}
        for name, rows in self.blocks.items():
            usual = s.effort if name.startswith("effort") else s.rate
            w[rows] = np.sqrt(self.dt) / scale.get(name, usual)
        for name, rows in self.blocks.items():
            if name.startswith(("bend", "rate", "share")):
                # a load that goes over in another way says nothing of the usual shares
                power = 2 if name == "share" else 1
                w[rows] /= self.bending[self.place[name][0]] ** power
        for name, rows in self.blocks.items():
            if not name.startswith(("bend", "noise", "free", "shift", "offset")):
                w[rows] *= self._recorded(name)
        w[self.blocks["shift"]] = 1.0 / np.array(s.shift)
        for i, name in enumerate(("offset_x", "offset_y")):
            w[self.blocks[name]] = 1.0 / s.offset[i]
        return w

    def _recorded(self, name: str) -> np.ndarray:
        """Return the mask of the rows of a block within the recording."""
        frame = self.place[name][0]
        last = frame + 1 if name.startswith("rate") else frame
        return (frame >= self.inside.start) & (last < self.inside.stop)

    def _recorded_rows(self, name: str) -> np.ndarray:
        """Return the indices of the rows of a block within the recording."""
        rows = self.blocks[name]
        return np.arange(rows.start, rows.stop)[self._recorded(name)]

    def solve(self) -> None:
        """Solve for wrenches and shift, repeatedly until the noise estimate converges."""
        solution = None
        place = np.searchsorted(self.unknown, self.layout.noise)
        self.sways = [place + i for i in range(6)]
        frames = len(self.layout.start)
        self.errors = drawn_errors(self.blocks, self.place, frames, self.dt, self.scales.pace)
        noise = np.ones(6)
        for _ in range(MAX_NOISE_ROUNDS):
            solution, w = self._optimum(noise, solution)
            missed = self.A @ solution.x - self.b
            self.moved = solution.response(self.scaled.T @ self.errors)
            self.noise, noise = noise, self._noise(noise, solution.x, missed, w)
            if np.abs(noise - self.noise).max() < 0.05:
                break
        assert solution is not None
        if self.scales.effort < np.inf:
            errors = errors_without_gait(self.errors, self.blocks, self.missed)
            self.moved = solution.response(self.scaled.T @ errors)
        elif self._hands_over_abruptly(solution):
            solution, _ = self._optimum(self.noise, solution)
            self.moved = solution.response(self.scaled.T @ self.errors)
        missed = self.A @ solution.x - self.b
        net = [missed[self._recorded_rows(name)] for name in NET_ROWS]
        self.residual_force = root_mean_square(np.concatenate(net[:3]))
        self.residual_moment = root_mean_square(np.concatenate(net[3:5]))
        x = self.x.copy()
        x[self.unknown] = solution.x
        self.wrench, self.shift = self._by_foot(x), x[self.layout.shift].copy()

    def _optimum(self, noise: np.ndarray, start: Any) -> tuple[Any, np.ndarray]:
        """Return the optimum for a noise level and the weights of its rows."""
        w = self.weights(noise)
        self.scaled = self.A.multiply(w[:, None]).tocsr()
        P = (self.scaled.T @ self.scaled).tocsr()
        q = -(self.scaled.T @ (w * self.b))
        solution = solve_quadratic(P, q, self.G, self.h, border=N_GLOBAL, start=start)
        self.missed = (self.A @ solution.x - self.b) * w / np.sqrt(self.dt)
        return solution, w

    def _hands_over_abruptly(self, solution: Any) -> bool:
        """Mark double supports with abrupt load transfer and return whether there are any.

        In these, rows of the motion and of the feet have a smaller misfit with faster changes of
        forces and joint moments. Double supports on a force plate are excluded.
        """
        there = self.layout.start[:, :2] >= 0
        both = np.asarray(there.all(axis=1) & ~self.known[:, :2].any(axis=1))
        shared = [
            run
            for run in runs(both)
            if run.stop > self.inside.start and run.start < self.inside.stop
        ]
        if not shared:
            return False
        usual, kept = self.bending, (self.scaled, self.missed)
        smooth = [self._misfit(run) for run in shared]
        self.bending = np.where(both, np.maximum(ABRUPT_BENDING, usual), usual)
        self._optimum(self.noise, solution)
        loose, self.bending = self.bending, usual.copy()
        for run, before in zip(shared, smooth, strict=True):
            if before - self._misfit(run) > MIN_MISFIT_GAIN:
                self.bending[run] = loose[run]
        self.scaled, self.missed = kept
        return bool(np.any(self.bending != usual))

    def _misfit(self, run: slice) -> float:
        """Return the misfit around a double support, the sum of squares of independent rows."""
        around, total = round(MISFIT_MARGIN / self.dt), 0.0
        for name in self.blocks:
            if name.startswith(MOTION_BLOCKS):
                frame = self.place[name][0]
                near = (frame >= run.start - around) & (frame < run.stop + around)
                total += float(
                    np.sum(self.missed[self.blocks[name]][near & self._recorded(name)] ** 2)
                )
        return total * self.dt / NOISE_TIME

    def _noise(
        self, noise: np.ndarray, x: np.ndarray, missed: np.ndarray, w: np.ndarray
    ) -> np.ndarray:
        """Return the relative noise, the ratio of actual to expected residuals of the net wrench.

        Each component is the geometric mean of its own ratio and that of all four components.
        """
        found = np.ones(6)
        for i in NOISE_ROWS:
            rows, own = self._recorded_rows(NET_ROWS[i]), self.blocks[f"noise{i}"]
            bend = self.A[rows][:, self.sways[i]]
            total = missed[rows] - bend @ x[self.sways[i]]
            left = (self.scaled[rows] @ self.moved - self.errors[rows]) / w[rows, None]
            left -= bend @ (self.moved[self.sways[i]] - self.errors[own] / w[own, None])
            found[i] = noise[i] * np.sqrt(np.mean(total**2) / np.mean(left**2)) / USUAL_RESIDUALS[i]
        k = float(np.sqrt(np.mean(found[NOISE_ROWS] ** 2)))
        found = np.sqrt(found * k)
        found[2], found[5] = np.sqrt(k), k
        return np.maximum(1.0, found)

    def _by_foot(self, x: np.ndarray) -> np.ndarray:
        """Return the unknowns of each support and frame (n, k, 6, …); zero without contact."""
        start = self.layout.start
        values = x[np.maximum(start, 0)[..., None] + np.arange(6)]
        values[start < 0] = 0.0
        return values[self.inside]

    @property
    def mean_noise(self) -> float:
        """Mean noise of the estimated components relative to the assumed noise [1]."""
        return float(self.noise[NOISE_ROWS].mean())

    def spread(self) -> Spread:
        """Return the standard deviations of all results."""
        whole = np.zeros((self.layout.size, self.moved.shape[1]))
        whole[self.unknown] = self.moved
        return spread_of(self.needs, self.wrench, self._by_foot(whole), MIN_PRESSURE_LOAD)
