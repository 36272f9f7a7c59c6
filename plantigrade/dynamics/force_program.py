"""The quadratic program of ground forces: scales, contacts, solving, noise."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from plantigrade.arrays import root_mean_square
from plantigrade.constants import FRICTION, SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_bands import (
    NOISE_TIME,
    Spread,
    drawn_errors,
    errors_without_gait,
    spread_of,
)
from plantigrade.dynamics.force_rows import N_GLOBAL, ForceLayout, PathPrior, limits, objective
from plantigrade.dynamics.loading import Support, completed, usual_length
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.quadratic import solve_quadratic
from plantigrade.dynamics.required_forces import MIN_LEVEL_DIFFERENCE, RequiredForces
from plantigrade.dynamics.usual_stance import LEAN, PHASE, UsualStance
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
MAX_CONTACT_LEAN = -0.15
"""Largest median forward lean of shanks at heel strike with which they show the path [rad]. Walks
of seven people with markers have -0.37 to -0.21, 16 walks in skeleton files -0.24 to 0.30."""
FLAT_FOOT_COP = (0.02, 0.009)  # lateral position for a flat foot [foot lengths] and its SD [m]
SEAT_BENDING = 5.0  # [1] factor of the curvature of forces near seat-off and seat-on
SEAT_BENDING_TIME = 0.1  # [s] duration of this factor
# [1] factor of the curvature of forces in a double support with abrupt load transfer
ABRUPT_BENDING = 3.0
# [1] minimum decrease of the misfit for this factor, in squared standard deviations of independent
# rows; six recordings gain up to 6, with 1 mm and 0.3° of noise up to 10, abrupt transfers 10 to 50
MIN_MISFIT_GAIN = 12.0
# [1] vertical noise of the net force in other movements and running relative to walking; settled on
# the squats, chair and jumps of one person
OTHER_SWAY = 1.5
MISFIT_MARGIN = 0.03  # [s] margin of a double support for its misfit
MOTION_BLOCKS = ("force", "moment", "noise", "path", "side", "free")  # rows of motion and feet
# [m] standard deviation of the centre of pressure on a seat, forward and lateral
SEAT_COP_SPREAD = (0.04, 0.035)


@dataclass(frozen=True)
class ForceScales:
    """Scales of the rows of the program; forces in body weights (BW)."""

    force: tuple[float, float, float] = (0.005, 0.005, 0.01)  #: Net force [BW]
    moment: float = 0.004  #: Net moment about the centre of mass [BW m]
    #: Noise of the net force [BW]; the vertical one is 1.5 times as large outside walking
    sway: tuple[float, float, float] = (0.02, 0.02, 0.016)
    turn: float = 0.01  #: Noise of the net moment [BW m]
    shift: tuple[float, float, float] = (0.012, 0.012, 0.005)  #: Shift of the centre of mass [m]
    rate: float = 0.7  #: Rate of joint moments [BW m/s]
    bend: tuple[float, float, float] = (25.0, 25.0, 50.0)  #: Second derivative of forces [BW/s²]
    #: Second derivative of foot moments [BW m/s²]
    twist: tuple[float, float, float] = (15.0, 15.0, 3.0)
    free: float = 0.007  #: Free moment [BW m]
    shear: float = 0.1  #: Horizontal force of a seat [BW]
    path: float = 1.5  #: Deviation of the centre of pressure from its mean path, in its SD [1]
    side: float = 0.02  #: Deviation of the lateral force from its mean [BW]
    offset: tuple[float, float] = (0.010, 0.010)  #: Constant offset of a foot's path [m]
    #: Deviation of the load of a foot from its usual share in double support [BW]: events are known
    #: to 10 ms, in which a fifteenth of the weight changes feet
    share: float = 0.06
    effort: float = np.inf  #: Joint moments relative to strength [1]
    loading: float = 20.0  #: Maximum rate of loading after contact [BW/s]
    pace: float = 1.0  #: Ratio of the motion's frequencies to those of walking [1]
    most_free: float = 0.02  #: Maximum free moment per vertical force [m]
    usual: UsualStance = UsualStance()  #: What feet of walkers usually do

    @classmethod
    def of(cls, *, walks: bool, pace: float = 1.0) -> "ForceScales":
        """Return the scales for an activity.

        Without walking, both feet may stand for long, and the motion does not determine their load
        sharing and internal forces; the minimum sum of squared activations is then selected
        [Crowninshield1981]_.

        Running and jumps contain higher frequencies, ``pace`` times those of walking. Rates are
        ``pace`` times and second derivatives ``pace**2`` times as large; the same factor applies to
        errors of the net wrench from masses and soft tissue. The loading rate of landing runners
        and jumpers reaches 100 BW/s.
        """
        usual = cls(effort=np.inf if walks else 1.0)
        if walks and pace == 1.0:
            return usual
        usual = replace(usual, sway=(*usual.sway[:2], OTHER_SWAY * usual.sway[2]))
        if pace == 1.0:
            return usual
        return replace(
            usual,
            force=tuple(pace**2 * f for f in usual.force),
            moment=pace**2 * usual.moment,
            rate=pace * usual.rate,
            bend=tuple(pace**2 * b for b in usual.bend),
            twist=tuple(pace**2 * b for b in usual.twist),
            loading=100.0,
            pace=pace,
        )


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
        whole = tuple(_lasting(c, (beyond + 1) * self.dt) for c in whole)
        contact, ramp, path = _contact_frames(
            wide, whole, supports, scales, human.dimensions.foot_length
        )
        self.known = np.zeros(contact.shape, bool)
        measured = np.zeros((*contact.shape, 6))
        if data is not None:
            now = self.inside
            self.known[now, :2], measured[now, :2], carried = _told(data, needs)
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


def _lasting(contact: ContactInterval, more: float) -> ContactInterval:
    """Return a contact, extended by ``more`` [s] beyond an end of the recording that cuts it."""
    start = contact.start if contact.begins else contact.start - more
    return replace(contact, start=start, stop=contact.stop if contact.ends else contact.stop + more)


def _contact_frames(needs: RequiredForces, contacts, supports, scales: ForceScales, length: float):
    """Return contact frames and maximum loads (n, k), and the path prior."""
    time = needs.time
    names = (*SIDES, *(support.name for support in supports))
    n, m = len(time), len(names)
    contact, ramp = np.zeros((n, m), bool), np.full((n, m), np.inf)
    mean, spread = np.full((n, m, 2), np.nan), np.ones((n, m, 2))
    side, forward = np.full((n, m), np.nan), np.zeros((n, m, 2))
    usual, curves = usual_length(contacts), scales.usual
    over_time = scales.pace > 1.0 or not _leans_back(needs, contacts)
    for each in contacts:
        k, here = names.index(each.side or each.region), each.frames(time)
        contact[here, k] = True
        t, limit = time[here], np.full(int(here.sum()), np.inf)
        if each.begins:
            limit = np.minimum(limit, t - each.start)
        if each.ends:
            limit = np.minimum(limit, each.stop - t)
        ramp[here, k] = 0.01 + scales.loading * limit
        if not each.side:
            ramp[here, k] = np.inf
            mean[here, k], spread[here, k] = 0.0, np.array(SEAT_COP_SPREAD)
            continue
        outward = -1.0 if each.side == "r" else 1.0
        mean[here, k, 1], spread[here, k, 1] = outward * length * FLAT_FOOT_COP[0], FLAT_FOOT_COP[1]
        if each.rolls and len(t):
            s, lean = each.share(t, usual), needs.lean[here, k]
            if over_time:
                mean[here, k, 0] = length * np.interp(s, PHASE, curves.cop_forward)
                spread[here, k, 0] = np.interp(s, *curves.cop_forward_spread)
            else:
                mean[here, k, 0] = length * np.interp(lean, LEAN, curves.roll_over)
                spread[here, k, 0] = np.interp(lean, *curves.roll_over_spread)
            if scales.pace > 1.0:  # runners land on the heel like walkers but step in one line
                continue
            mean[here, k, 1] = outward * length * np.interp(s, PHASE, curves.cop_outward)
            spread[here, k, 1] = np.interp(s, *curves.cop_outward_spread)
            side[here, k] = -outward * np.interp(s, PHASE, curves.force_inward)
            ahead = needs.rotation[here, :2, 0].mean(axis=0)
            forward[here, k] = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    share = _usual_shares(needs, contacts, scales)
    return contact, ramp, PathPrior(mean, spread, side, forward, share)


def _leans_back(needs: RequiredForces, contacts) -> bool:
    """Return whether shanks lean back at heel strike as people's do, so that they show the path.

    Knees that are bent there are mostly those of a skeleton file, whose shanks lean too far forward
    all through the stance.
    """
    leans = [
        needs.lean[np.searchsorted(needs.time, each.start), SIDES.index(each.side)]
        for each in contacts
        if each.rolls and each.begins and needs.time[0] <= each.start < needs.time[-1]
    ]
    return not leans or bool(np.median(leans) < MAX_CONTACT_LEAN)


def _usual_shares(needs: RequiredForces, contacts, scales: ForceScales) -> np.ndarray:
    """Return the usual shares of both feet in the load of double supports of a walk (n, 2).

    They are unknown in running and in a recording with steps.
    """
    time, found = needs.time, np.full((len(needs.time), 2), np.nan)
    level = bool(np.ptp(needs.base[:, :2, 2]) < MIN_LEVEL_DIFFERENCE)
    steps = [c for c in contacts if c.rolls and level and scales.pace == 1.0]
    for rear in steps:
        for front in steps:
            if rear.side == front.side or not (front.begins and rear.ends):
                continue
            if not rear.start < front.start < rear.stop < front.stop:
                continue
            phase = (time - front.start) / (rear.stop - front.start)
            here = (phase >= 0.0) & (phase <= 1.0)
            share = np.interp(phase[here], PHASE, scales.usual.rear_share)
            found[here, SIDES.index(rear.side)] = share
            found[here, SIDES.index(front.side)] = 1.0 - share
    return found


def _told(data: FootForces, needs: RequiredForces):
    """Return the frames with known wrench, the wrench, and the frames in which it is not zero."""
    known = np.array(data.valid_side)
    force = data.force / needs.weight
    carried = np.isfinite(data.point).all(axis=-1) & (force[..., 2] > 0)
    arm = np.where(carried[..., None], data.point - needs.base[:, :2], 0.0)
    moment = np.cross(arm, force) + data.torque / needs.weight
    measured = np.concatenate([force, moment], axis=-1)
    return known, np.where(carried[..., None], measured, 0.0), carried
