r"""Ground reactions from the motion alone, or beside plates: one quadratic program per recording.

Unknown are the wrench of each foot in every frame of its contacts, force :math:`F` and moment
:math:`M` about a point of the floor below the ankle, and one shift :math:`d` of the centre of mass
for the whole recording. With the net wrench :math:`F_n, M_n` about the model's centre of mass
:math:`c` and the joint moments :math:`\tau_0` that the motion needs, minimise the time integral of

* :math:`\sum F - F_n` and :math:`\sum (p - c) \times F + M - M_n - d \times F_n`: the net wrench,
  softly. Held exactly, what the motion has of noise would go into the centre of pressure;
* :math:`\frac{d}{dt}(\tau_0 - J^T w)` of the joints of each leg: joint moments change slowly;
* :math:`\ddot F` and :math:`\ddot M`, zero outside the contacts: forces are smooth;
* the free moment, and in walking the distance of the centre of pressure from its usual path,

each squared and over its scale, subject to :math:`F_z \ge 0`, friction, and a centre of pressure
within the part of the sole that is on the floor. Wrenches that plates measured are no unknowns.

**Noise.** Where the moment rows are missed by more than their scale, the motion is noisier
than assumed: the scales of the net wrench are taken :math:`k` times (vertical force
:math:`\sqrt k`), and the program is solved again, twice.
"""

from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import FRICTION, SIDES
from plantigrade.dynamics.centroid import check_motion
from plantigrade.dynamics.force_needs import ForceNeeds, force_needs
from plantigrade.dynamics.force_rows import Layout, PathPrior, limits, objective
from plantigrade.dynamics.load_intervals import (
    LoadInterval,
    usual_length,
    walking_intervals,
)
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.quadratic import solve_quadratic
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.motion import Motion

FASTEST = 150.0  # frames are left out above this rate [Hz]
LIGHT = 0.01  # centres of pressure and free moments are told above this load [BW]
PATH = (
    (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
    (-0.0142, -0.0019, 0.0129, 0.0254, 0.0425, 0.0600, 0.0714, 0.0783, 0.0805, 0.0731, 0.0519),
    (0.0008, 0.0033, 0.0040, 0.0046, 0.0056, 0.0058, 0.0048, 0.0035, 0.0006, -0.0049, -0.0083),
)
SPREAD_X = ((0.0, 0.1, 0.2, 0.45, 0.75, 0.85, 1.0), (12, 9, 10, 22, 7, 9, 30))
SPREAD_Y = ((0.0, 0.1, 0.8, 1.0), (9, 6, 5, 9))


@dataclass(frozen=True)
class ForceScales:
    """By what the rows of the program are divided; forces in body weights (BW)."""

    force: tuple[float, float, float] = (0.02, 0.02, 0.025)  #: Net force [BW]
    moment: float = 0.01  #: Net moment about the centre of mass [BW m]
    shift: tuple[float, float, float] = (0.03, 0.02, 0.005)  #: Of the centre of mass [m]
    rate: float = 0.7  #: Change of joint moments [BW m/s]
    bend: tuple[float, float, float] = (25.0, 25.0, 50.0)  #: Bend of forces [BW/s²]
    twist: tuple[float, float, float] = (12.0, 12.0, 3.0)  #: Bend of foot moments [BW m/s²]
    free: float = 0.007  #: Free moment [BW m]
    path: float = 2.0  #: Centre of pressure from its usual path, in its standard deviations
    loading: float = 12.0  #: Fastest growth of the load, from contact on [BW/s]
    most_free: float = 0.02  #: Most of the free moment, by vertical force [m]


@dataclass(frozen=True)
class GroundForces:
    """Ground reactions of both feet over a motion, with how sure they are; sides r, l."""

    forces: FootForces  #: Every foot in every frame
    measured: Bool[Array, "n_frames 2"]  #: Where plates told them
    #: Half-width of the 90 % band of the force [N]
    force_band: Float[Array, "n_frames 2 3"]
    point_band: Float[Array, "n_frames 2 2"]  #: The same of the centre of pressure, x and y [m]
    torque_band: Float[Array, "n_frames 2"]  #: The same of the free moment [N m]
    #: The same of the generalised forces of inverse dynamics with these forces [N, N m]
    moment_band: Float[Array, "n_frames nv"]
    com_shift: Float[Array, " 3"]  #: Where the true centre of mass lies from the model's [m]
    noise: float  #: How many times noisier the motion is than assumed; 1 as assumed
    residual_force: float  #: Root mean square of the net force that is missed [BW]
    residual_moment: float  #: The same of the pitch and roll moment [BW m]
    contacts: tuple[LoadInterval, ...] = field(default=(), repr=False)  #: As taken


def estimate_forces(
    human: Human,
    motion: Motion,
    *,
    measured: FootForces | None = None,
    contacts: tuple[LoadInterval, ...] | None = None,
    scales: ForceScales | None = None,
) -> GroundForces:
    """Return the ground reaction on each foot in every frame.

    Args:
        human: Whose motion.
        motion: The motion, filtered, with accelerations and gait events.
        measured: What plates tell; it is kept, where ``valid_side`` says it is known.
        contacts: When each foot may carry load; from the gait events if absent.
        scales: What the program weighs by.

    Raises:
        ParameterError: If the motion has no accelerations, is too short, or the measured forces
            are not on its frames.
        SolverError: If the program cannot be solved.
    """
    scales = scales or ForceScales()
    qacc = _check(human, motion, measured)
    contacts = walking_intervals(motion) if contacts is None else contacts
    step = max(1, int(np.ceil(motion.rate / FASTEST)))
    coarse = motion.frames(slice(None, None, step))
    needs = force_needs(human, coarse, qacc[::step], contacts)
    data = None if measured is None else _frames(measured, slice(None, None, step))
    program = _Program(human, needs, contacts, data, scales)
    wrench, shift, noise, missed = program.solve()
    forces = _as_forces(motion.time, needs, wrench, measured)
    n = motion.n_frames
    known = np.zeros((n, 2), bool) if measured is None else np.array(measured.valid_side)
    return GroundForces(
        forces,
        known,
        np.full((n, 2, 3), np.nan),
        np.full((n, 2, 2), np.nan),
        np.full((n, 2), np.nan),
        np.full((n, human.model.nv), np.nan),
        shift,
        noise,
        *missed,
        contacts,
    )


class _Program:
    def __init__(self, human, needs: ForceNeeds, contacts, data: FootForces | None, scales):
        self.needs, self.scales = needs, scales
        time = needs.time
        contact, ramp, path = _contact_frames(time, contacts, scales, human.height)
        self.known = np.zeros(contact.shape, bool)
        told = np.zeros((*contact.shape, 6))
        if data is not None:
            self.known, told, carried = _told(data, needs)
            contact = np.where(self.known, carried, contact)
        self.layout = Layout.of(contact)
        rows = objective(needs, self.layout, path)
        A, b = rows.system()
        self.blocks = rows.blocks
        start = self.layout.start
        fixed = self.known & contact
        x = np.zeros(self.layout.size)
        x[(start[fixed][:, None] + np.arange(6)).ravel()] = told[fixed].ravel()
        free = contact & ~self.known
        self.unknown = np.concatenate(
            [(start[free][:, None] + np.arange(6)).ravel(), self.layout.shift]
        )
        self.x, self.b, self.A = x, b - A @ x, A[:, self.unknown].tocsr()
        G, h = (
            limits(needs, self.layout, free, ramp, FRICTION, scales.most_free).system()
            if free.any()
            else (None, np.zeros(0))
        )
        self.G, self.h = None if G is None else G[:, self.unknown].tocsr(), h
        self.dt = float(time[1] - time[0])

    def weights(self, noise: float) -> np.ndarray:
        """Return what each row is multiplied by."""
        s, w = self.scales, np.empty(len(self.b))
        scale = {f"force_{a}": v * noise for a, v in zip("xy", s.force, strict=False)}
        scale["force_z"] = s.force[2] * np.sqrt(noise)
        scale |= {f"moment_{a}": s.moment * noise for a in "xyz"}
        scale |= {f"bend{i}": v for i, v in enumerate((*s.bend, *s.twist))}
        scale |= {"free": s.free, "path_x": s.path, "path_y": s.path}
        for name, rows in self.blocks.items():
            w[rows] = np.sqrt(self.dt) / scale.get(name, s.rate)
        w[self.blocks["shift"]] = 1.0 / np.array(s.shift)
        return w

    def solve(self):
        noise, first = 1.0, self.scales.moment
        for _ in range(3):
            w = self.weights(noise)
            scaled = self.A.multiply(w[:, None]).tocsr()
            self.P = (scaled.T @ scaled).tocsc()
            q = -(scaled.T @ (w * self.b))
            self.solution = solve_quadratic(self.P, q, self.G, self.h)
            missed = self.A @ self.solution.x - self.b
            moment = np.concatenate([missed[self.blocks[f"moment_{a}"]] for a in "xy"])
            rms = float(np.sqrt(np.mean(moment**2)))
            last, noise = noise, max(1.0, rms / first)
            if abs(noise - last) < 0.02:
                break
        self.scaled = scaled
        x = self.x.copy()
        x[self.unknown] = self.solution.x
        start = self.layout.start
        wrench = np.where(
            (start >= 0)[..., None], x[np.maximum(start, 0)[..., None] + np.arange(6)], 0.0
        )
        force = np.concatenate([missed[self.blocks[f"force_{a}"]] for a in "xyz"])
        residual = float(np.sqrt(np.mean(force**2))), rms
        return wrench, x[-3:].copy(), float(last), residual


def _contact_frames(time, contacts, scales: ForceScales, height: float):
    n = len(time)
    contact, ramp = np.zeros((n, 2), bool), np.full((n, 2), np.inf)
    mean, spread = np.full((n, 2, 2), np.nan), np.ones((n, 2, 2))
    usual = usual_length(contacts)
    for each in contacts:
        k, here = SIDES.index(each.side), each.frames(time)
        contact[here, k] = True
        t, limit = time[here], np.full(int(here.sum()), np.inf)
        if each.begins:
            limit = np.minimum(limit, t - each.start)
        if each.ends:
            limit = np.minimum(limit, each.stop - t)
        ramp[here, k] = 0.01 + scales.loading * limit
        if each.walking:
            s = each.share(t, usual)
            outward = -1.0 if each.side == "r" else 1.0
            mean[here, k, 0] = height * np.interp(s, PATH[0], PATH[1])
            mean[here, k, 1] = outward * height * np.interp(s, PATH[0], PATH[2])
            for i, table in enumerate((SPREAD_X, SPREAD_Y)):
                spread[here, k, i] = 1e-3 * np.interp(s, *table) * height / 1.7
    return contact, ramp, PathPrior(mean, spread)


def _told(data: FootForces, needs: ForceNeeds):
    """Return where plates tell the wrench, the wrench itself, and where it is not zero."""
    known = np.array(data.valid_side)
    force = data.force / needs.weight
    carried = np.isfinite(data.point).all(axis=-1) & (force[..., 2] > 0)
    arm = np.where(carried[..., None], data.point - needs.base, 0.0)
    moment = np.cross(arm, force) + data.torque / needs.weight
    told = np.concatenate([force, moment], axis=-1)
    return known, np.where(carried[..., None], told, 0.0), carried


def _as_forces(time, needs: ForceNeeds, wrench, measured: FootForces | None) -> FootForces:
    """Return the wrenches as forces at centres of pressure, on all frames of the motion."""
    w = np.stack(
        [[np.interp(time, needs.time, wrench[:, k, i]) for i in range(6)] for k in (0, 1)]
    ).transpose(2, 0, 1)
    base = np.stack(
        [[np.interp(time, needs.time, needs.base[:, k, i]) for i in range(3)] for k in (0, 1)]
    ).transpose(2, 0, 1)
    load = w[..., 2] > LIGHT
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = -w[..., 4] / w[..., 2], w[..., 3] / w[..., 2]
    point = base + np.stack([x, y, np.zeros_like(x)], axis=-1)
    point[~load] = np.nan
    torque = np.zeros_like(point)
    torque[..., 2] = np.where(load, w[..., 5] - x * w[..., 1] + y * w[..., 0], 0.0) * needs.weight
    force = np.where(load[..., None], w[..., :3], 0.0) * needs.weight
    uses, notes = (), ()
    if measured is not None:
        known = np.asarray(measured.valid_side)
        force[known], point[known] = measured.force[known], measured.point[known]
        torque[known] = measured.torque[known]
        uses, notes = measured.uses, measured.warnings
    sure = np.ones(load.shape, bool)
    return FootForces(force, point, torque, sure, sure[:, 0].copy(), uses, notes)


def _frames(forces: FootForces, keep: slice) -> FootForces:
    return FootForces(
        forces.force[keep],
        forces.point[keep],
        forces.torque[keep],
        forces.valid_side[keep],
        forces.valid[keep],
    )


def _check(human: Human, motion: Motion, measured: FootForces | None) -> np.ndarray:
    if motion.qacc is None:
        raise ParameterError("the motion has no accelerations; filter and differentiate it first")
    check_motion(human, motion.qpos, motion.qvel, motion.qacc)
    if motion.n_frames < 4:
        raise ParameterError(f"{motion.n_frames} frames are too few; forces need at least 4")
    if measured is not None and len(measured.force) != motion.n_frames:
        raise ParameterError(
            f"the forces have {len(measured.force)} frames, the motion {motion.n_frames}; put both "
            "on one clock"
        )
    return motion.qacc
