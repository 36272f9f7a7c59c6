"""The quadratic program of ground forces: scales, contacts, solving, noise."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from plantigrade.constants import FRICTION, SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_bands import (
    NOISE_TIME,
    Spread,
    calm_errors,
    drawn_errors,
    spread_of,
)
from plantigrade.dynamics.force_needs import ForceNeeds
from plantigrade.dynamics.force_rows import LAST, Layout, PathPrior, limits, objective
from plantigrade.dynamics.load_intervals import Support, completed, usual_length
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.quadratic import solve_quadratic
from plantigrade.models import Human
from plantigrade.motion.filters import runs

LIGHT = 0.01  # centres of pressure and free moments are told above this load [BW]
NET = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
NOISE_ROWS = [0, 1, 3, 4]  # rows of the net wrench that tell the noise of the motion
ROUNDS = 3  # times that the program is solved, as the noise turns out
# Noise alike at all frequencies up to 5 Hz: RMS of its second derivative, over its own [1/s²]
ROUGHNESS = (2 * np.pi * 5.0) ** 2 / np.sqrt(5.0)
# By what rows are missed in recordings of little noise, over what their errors leave
USUAL = (1.0, 1.0, 1.0, 0.85, 0.7, 1.0)
# Path of the centre of pressure from the ankle over a stance, forward and outward in lengths of the
# foot: mean of three people, five stances
SHARE = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
FORWARD = (-0.06, -0.025, 0.09, 0.205, 0.345, 0.45, 0.485, 0.497, 0.48, 0.37, 0.14)
OUTWARD = (0.01, 0.03, 0.05, 0.06, 0.065, 0.085, 0.095, 0.095, 0.065, 0.01, -0.04)
# Force towards the other foot over a stance [BW], of the same stances
INWARD = (0.0, 0.0, 0.053, 0.058, 0.045, 0.036, 0.042, 0.054, 0.047, 0.005, 0.0)
# How far they stray from their own mean path [m]
STRAY_FORWARD = (
    (0.0, 0.1, 0.4, 0.5, 0.75, 0.9, 1.0),
    (0.012, 0.009, 0.008, 0.008, 0.005, 0.012, 0.022),
)
STRAY_OUTWARD = ((0.0, 0.2, 0.4, 0.6, 0.8, 1.0), (0.007, 0.006, 0.005, 0.006, 0.004, 0.012))
FLAT = (0.02, 0.009)  # outward of a foot that does not roll: share of its length, and astray [m]
HAND_OVER, HAND_OVER_TIME = 5.0, 0.1  # forces bend so much more so near seat-off [s] and seat-on
# Factor by which forces may bend more in a double support whose load goes over abruptly
ABRUPT_BENDING = 3.0
# Fall of the misfit that this must bring [squared standard deviations of independent rows]: six
# recordings gain up to 6, with 1 mm and 0.3° of noise up to 10; abrupt hand-overs gain 10 to 50
MIN_MISFIT_GAIN = 12.0
MISFIT_MARGIN = 0.03  # time before and after a double support that counts for its misfit [s]
MOTION_BLOCKS = ("force", "moment", "noise", "path", "side", "free")  # rows of motion and feet
SEATED = (0.04, 0.035)  # on a seat, from the ischia: standard deviation [m]


@dataclass(frozen=True)
class ForceScales:
    """By what the rows of the program are divided; forces in body weights (BW)."""

    force: tuple[float, float, float] = (0.005, 0.005, 0.01)  #: Net force [BW]
    moment: float = 0.004  #: Net moment about the centre of mass [BW m]
    sway: tuple[float, float, float] = (0.02, 0.02, 0.025)  #: Noise of the net force [BW]
    turn: float = 0.01  #: Noise of the net moment [BW m]
    shift: tuple[float, float, float] = (0.012, 0.012, 0.005)  #: Of the centre of mass [m]
    rate: float = 0.7  #: Change of joint moments [BW m/s]
    bend: tuple[float, float, float] = (25.0, 25.0, 50.0)  #: Bend of forces [BW/s²]
    twist: tuple[float, float, float] = (15.0, 15.0, 3.0)  #: Bend of foot moments [BW m/s²]
    free: float = 0.007  #: Free moment [BW m]
    shear: float = 0.1  #: Horizontal force of a seat [BW]
    path: float = 1.5  #: Centre of pressure from its usual path, in its standard deviations
    side: float = 0.02  #: Force to the side from the usual one [BW]
    offset: tuple[float, float] = (0.010, 0.010)  #: Of a foot's path, for the recording [m]
    effort: float = np.inf  #: Joint moments, as a share of the joint's strength
    loading: float = 20.0  #: Fastest growth of the load, from contact on [BW/s]
    pace: float = 1.0  #: How many times higher the motion's frequencies are than in walking
    most_free: float = 0.02  #: Most of the free moment, by vertical force [m]

    @classmethod
    def of(cls, *, walks: bool, pace: float = 1.0) -> "ForceScales":
        """Return the scales for what a person does.

        Where nobody walks, both feet may stand for long, and the motion alone does not tell how
        they share the load or press against each other: of all that explain it, the least sum of
        squared activations is taken [Crowninshield1981]_.

        With flight (running, jumps) the motion keeps higher frequencies, ``pace`` times those of
        walking. Rates are ``pace`` times and bends ``pace**2`` times as large, and so are
        accelerations and the errors of the net wrench by masses and soft tissue. A load grows by
        up to 100 BW/s when a runner or a jumper lands.
        """
        usual = cls(effort=np.inf if walks else 1.0)
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
    """The program of one recording: made from a motion, solved, asked for its bands.

    Args:
        human: Whose motion.
        needs: What it says.
        contacts: When feet and supports may carry load.
        supports: What may carry load besides the feet.
        data: Wrenches that plates measured, on the frames of the program.
        scales: What the program weighs by.

    Attributes:
        wrench: The estimate (n, k, 6) [BW, BW m].
        shift: Shift of the centre of mass [m].
        noise: How many times noisier force x, y, z and moment x, y, z are than assumed.
        missed_force: Root mean square of the net force that is missed beside the noise [BW].
        missed_moment: The same of the pitch and roll moment [BW m].
    """

    def __init__(
        self,
        human: Human,
        needs: ForceNeeds,
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
        told = np.zeros((*contact.shape, 6))
        if data is not None:
            now = self.inside
            self.known[now, :2], told[now, :2], carried = _told(data, needs)
            contact[now, :2] = np.where(self.known[now, :2], carried, contact[now, :2])
        contact[:beyond] &= contact[beyond]
        contact[beyond + n :] &= contact[beyond + n - 1]
        self.layout = Layout.of(contact)
        rows = objective(wide, self.layout, path, effort=scales.effort < np.inf)
        A, b = rows.system()
        self.blocks, self.place = rows.blocks, rows.place
        start = self.layout.start
        fixed = self.known & contact
        x = np.zeros(self.layout.size)
        x[(start[fixed][:, None] + np.arange(6)).ravel()] = told[fixed].ravel()
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
        #: How much more forces and joint moments bend than usual, in every frame
        self.bending = np.ones(len(time))
        for each in contacts:
            for edge, seen in ((each.start, each.begins), (each.stop, each.ends)):
                if seen and not each.side:
                    self.bending[np.abs(time - edge) < HAND_OVER_TIME] = HAND_OVER

    def weights(self, noise: np.ndarray) -> np.ndarray:
        """Return what each row is multiplied by, for noise of force x, y, z and moment x, y, z."""
        s, w = self.scales, np.empty(len(self.b))
        white = np.array([*s.force, *(s.moment,) * 3])
        scale = dict(zip(NET, white * noise, strict=True))
        sway = np.array([*s.sway, *(s.turn,) * 3]) * noise / ROUGHNESS
        scale |= {f"noise{i}": v for i, v in enumerate(sway)}
        scale |= {f"bend{i}": v for i, v in enumerate((*s.bend, *s.twist))}
        scale |= {"free": s.free, "path_x": s.path, "path_y": s.path, "side": s.side}
        scale |= {"shear0": s.shear, "shear1": s.shear}
        for name, rows in self.blocks.items():
            usual = s.effort if name.startswith("effort") else s.rate
            w[rows] = np.sqrt(self.dt) / scale.get(name, usual)
        for name, rows in self.blocks.items():
            if name.startswith(("bend", "rate")):
                w[rows] /= self.bending[self.place[name][0]]
        for name, rows in self.blocks.items():
            if not name.startswith(("bend", "noise", "free", "shift", "offset")):
                w[rows] *= self._recorded(name)
        w[self.blocks["shift"]] = 1.0 / np.array(s.shift)
        for i, name in enumerate(("offset_x", "offset_y")):
            w[self.blocks[name]] = 1.0 / s.offset[i]
        return w

    def _recorded(self, name: str) -> np.ndarray:
        """Return which rows of a block belong to frames of the recording."""
        frame = self.place[name][0]
        last = frame + 1 if name.startswith("rate") else frame
        return (frame >= self.inside.start) & (last < self.inside.stop)

    def _recorded_rows(self, name: str) -> np.ndarray:
        """Return the numbers of these rows."""
        rows = self.blocks[name]
        return np.arange(rows.start, rows.stop)[self._recorded(name)]

    def solve(self) -> None:
        """Find wrenches and shift; three times at most, as the noise turns out."""
        solution = None
        place = np.searchsorted(self.unknown, self.layout.noise)
        self.sways = [place + i for i in range(6)]
        frames = len(self.layout.start)
        self.errors = drawn_errors(self.blocks, self.place, frames, self.dt, self.scales.pace)
        noise = np.ones(6)
        for _ in range(ROUNDS):
            solution, w = self._optimum(noise, solution)
            missed = self.A @ solution.x - self.b
            self.moved = solution.response(self.scaled.T @ self.errors)
            self.noise, noise = noise, self._noise(noise, solution.x, missed, w)
            if np.abs(noise - self.noise).max() < 0.05:
                break
        assert solution is not None
        if self.scales.effort < np.inf:
            errors = calm_errors(self.errors, self.blocks, self.missed)
            self.moved = solution.response(self.scaled.T @ errors)
        elif self._hands_over_abruptly(solution):
            solution, _ = self._optimum(self.noise, solution)
            self.moved = solution.response(self.scaled.T @ self.errors)
        missed = self.A @ solution.x - self.b
        net = [missed[self._recorded_rows(name)] for name in NET]
        self.missed_force, self.missed_moment = _rms(net[:3]), _rms(net[3:5])
        x = self.x.copy()
        x[self.unknown] = solution.x
        self.wrench, self.shift = self._by_foot(x), x[self.layout.shift].copy()

    def _optimum(self, noise: np.ndarray, start: Any) -> tuple[Any, np.ndarray]:
        """Return the optimum with so much noise, and what its rows were multiplied by."""
        w = self.weights(noise)
        self.scaled = self.A.multiply(w[:, None]).tocsr()
        P = (self.scaled.T @ self.scaled).tocsr()
        q = -(self.scaled.T @ (w * self.b))
        solution = solve_quadratic(P, q, self.G, self.h, border=LAST, start=start)
        self.missed = (self.A @ solution.x - self.b) * w / np.sqrt(self.dt)
        return solution, w

    def _hands_over_abruptly(self, solution: Any) -> bool:
        """Mark double supports whose motion contradicts a smooth hand-over; return if any do.

        In these, rows of the motion and of the feet have a smaller misfit if forces and joint
        moments may change faster. Double supports on a force plate are not examined.
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
        """Return the misfit of rows of motion and feet around a double support.

        It is the sum of squares, in their scales, of rows whose errors are independent.
        """
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
        """Return how noisy the motion is: rows missed by more than their errors leave them.

        That of each row, by half (in logarithms) that of all four that tell.
        """
        found = np.ones(6)
        for i in NOISE_ROWS:
            rows, own = self._recorded_rows(NET[i]), self.blocks[f"noise{i}"]
            bend = self.A[rows][:, self.sways[i]]
            total = missed[rows] - bend @ x[self.sways[i]]
            left = (self.scaled[rows] @ self.moved - self.errors[rows]) / w[rows, None]
            left -= bend @ (self.moved[self.sways[i]] - self.errors[own] / w[own, None])
            found[i] = noise[i] * np.sqrt(np.mean(total**2) / np.mean(left**2)) / USUAL[i]
        k = float(np.sqrt(np.mean(found[NOISE_ROWS] ** 2)))
        found = np.sqrt(found * k)
        found[2], found[5] = np.sqrt(k), k
        return np.maximum(1.0, found)

    def _by_foot(self, x: np.ndarray) -> np.ndarray:
        """Return the unknowns of each carrier and frame (n, k, 6, …); zero where there are none."""
        start = self.layout.start
        values = x[np.maximum(start, 0)[..., None] + np.arange(6)]
        values[start < 0] = 0.0
        return values[self.inside]

    @property
    def told_noise(self) -> float:
        """How many times noisier the rows that tell it are than assumed, on the mean."""
        return float(self.noise[NOISE_ROWS].mean())

    def spread(self) -> Spread:
        """Return the spread of everything that follows from the wrenches."""
        whole = np.zeros((self.layout.size, self.moved.shape[1]))
        whole[self.unknown] = self.moved
        return spread_of(self.needs, self.wrench, self._by_foot(whole), LIGHT)


def _rms(parts: list[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def _lasting(contact: ContactInterval, more: float) -> ContactInterval:
    """Return a contact that lasts beyond the end of the recording that cuts it, by ``more`` [s]."""
    start = contact.start if contact.begins else contact.start - more
    return replace(contact, start=start, stop=contact.stop if contact.ends else contact.stop + more)


def _contact_frames(needs: ForceNeeds, contacts, supports, scales: ForceScales, length: float):
    """Return frames of contact, the most that may be carried (n, k), and what is usual."""
    time = needs.time
    names = (*SIDES, *(support.name for support in supports))
    n, m = len(time), len(names)
    contact, ramp = np.zeros((n, m), bool), np.full((n, m), np.inf)
    mean, spread = np.full((n, m, 2), np.nan), np.ones((n, m, 2))
    side, forward = np.full((n, m), np.nan), np.zeros((n, m, 2))
    usual = usual_length(contacts)
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
            mean[here, k], spread[here, k] = 0.0, np.array(SEATED)
            continue
        outward = -1.0 if each.side == "r" else 1.0
        mean[here, k, 1], spread[here, k, 1] = outward * length * FLAT[0], FLAT[1]
        if each.rolls and len(t):
            s = each.share(t, usual)
            mean[here, k, 0] = length * np.interp(s, SHARE, FORWARD)
            spread[here, k, 0] = np.interp(s, *STRAY_FORWARD)
            if scales.pace > 1.0:  # runners land on the heel like walkers, but step in one line
                continue
            mean[here, k, 1] = outward * length * np.interp(s, SHARE, OUTWARD)
            spread[here, k, 1] = np.interp(s, *STRAY_OUTWARD)
            side[here, k] = -outward * np.interp(s, SHARE, INWARD)
            ahead = needs.rotation[here, :2, 0].mean(axis=0)
            forward[here, k] = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    return contact, ramp, PathPrior(mean, spread, side, forward)


def _told(data: FootForces, needs: ForceNeeds):
    """Return where plates tell the wrench, the wrench itself, and where it is not zero."""
    known = np.array(data.valid_side)
    force = data.force / needs.weight
    carried = np.isfinite(data.point).all(axis=-1) & (force[..., 2] > 0)
    arm = np.where(carried[..., None], data.point - needs.base[:, :2], 0.0)
    moment = np.cross(arm, force) + data.torque / needs.weight
    told = np.concatenate([force, moment], axis=-1)
    return known, np.where(carried[..., None], told, 0.0), carried
