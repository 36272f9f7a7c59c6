r"""Whether a motion obeys the laws of physics and keeps its plan: the judge, not the maker.

The motion is looked at frame by frame with MuJoCo's inverse dynamics and nothing else; no
expression, row or constant of an optimiser is used. With the equations of motion of the free body,

.. math:: M(q)\,\dot v + h(q, v) = \tau + \sum_k J_k^T f_k,

the first six entries of :math:`\tau` are what no contact explains and must be zero; the others are
the true joint torques. Where something stands, the material at its lowest point must not move: a
sphere that rolls does not slip, so velocities are integrated,
:math:`\int v_t\,dt`, and places are not compared.

What the ground must supply follows from the motion alone. Its centre of pressure, the point where
that wrench has no moment in the plane of the ground,

.. math:: p = O + \frac{n \times M_O}{n^T F},

must lie in the hull of what stands. Below body weight its distance counts in proportion to the
load, as what is missing is a moment.

Positions, velocities and accelerations are given; that they belong together is checked step by
step with the relations that a cubic holds exactly,

.. math:: \frac{q_1 - q_0}{h} = \frac{v_0 + v_1}{2} - \frac{h}{12}(a_1 - a_0),
    \qquad \frac{q_2 - 2 q_1 + q_0}{h^2} = \frac{a_0 + 4 a_1 + a_2}{6}

(for steps of unequal length likewise), and for the body as a whole: momentum changes by the
forces, energy by the power of the joints.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from plantigrade.analyze.findings import (
    OF_JOINTS,
    QUANTITIES,
    QUANTITY,
    Finding,
    Measure,
    Slip,
    Tolerances,
)
from plantigrade.analyze.sweep import Sweep, cross, sweep
from plantigrade.analyze.under_test import (
    SPHERE,
    ContactSite,
    Ground,
    Limits,
    MotionUnderTest,
    motion_of_record,
    motion_of_run,
    side_of_name,
)
from plantigrade.arrays import Array, Float

_SAME = 1e-4  # a sphere and a site no further apart than this are one place [m]
_APART = 0.1  # excesses no further apart in time are one finding [s]


@dataclass(frozen=True, eq=False)
class MotionCheck:
    """The verdict.

    Attributes:
        measures: The worst of every quantity, by its name, good or bad.
        findings: What is wrong, worst first (relative to what is allowed).
        time: Time of each frame [s].
        tau: Generalised forces that the contacts leave to the joints [N m]; the first six entries
            are the unexplained root (world force [N], moment about the pelvis in body axes [N m]).
        root_force: Unexplained force, world [N].
        root_moment: Unexplained moment about the centre of mass, world [N m].
        com: Centre of mass [m].
        contact_point: Lowest point of each site, world [m].
        gap: Height of that point over what it stands on [m].
        centre_of_pressure: Of what the motion asks of the feet, world [m]; NaN where it asks for
            (next to) nothing.
        slips: Every stance of every site.
    """

    measures: dict[str, Measure]
    findings: tuple[Finding, ...]
    time: Float[Array, " n_frames"]
    tau: Float[Array, "n_frames nv"]
    root_force: Float[Array, "n_frames 3"]
    root_moment: Float[Array, "n_frames 3"]
    com: Float[Array, "n_frames 3"]
    contact_point: Float[Array, "n_frames n_sites 3"]
    gap: Float[Array, "n_frames n_sites"]
    centre_of_pressure: Float[Array, "n_frames 3"]
    slips: tuple[Slip, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.findings

    def words(self) -> list[str]:
        """Return one plain sentence for each fault, of several times the worst."""
        if self.ok:
            return [f"checked in {len(self.time)} frames: nothing is out of its limits"]
        times: dict[tuple[str, str], list[Finding]] = {}
        for finding in self.findings:
            where = finding.name if finding.quantity in OF_JOINTS else finding.side or finding.name
            times.setdefault((finding.quantity, where), []).append(finding)
        return [max(same, key=lambda f: f.value).sentence(len(same) - 1) for same in times.values()]

    def metrics(self) -> dict[str, Any]:
        """Return flat figures for ``metrics.json``, unit as suffix."""
        result: dict[str, Any] = {
            "check_ok": self.ok,
            "check_frames": len(self.time),
            "check_findings": len(self.findings),
        }
        for quantity, measure in self.measures.items():
            result[QUANTITY[quantity].key] = measure.value
        return result


def examine(motion: MotionUnderTest, tolerances: Tolerances | None = None) -> MotionCheck:
    """Return the verdict on a motion.

    Sample it finely (ten frames between two nodes of what made it), nodes among the frames.

    Args:
        motion: The motion, its forces and its plan.
        tolerances: What is allowed.
    """
    tol = tolerances or Tolerances()
    judge = _Judge(motion, tol, sweep(motion))
    judge.root()
    slips = judge.slip()
    judge.penetration()
    judge.forces()
    pressure = judge.pressure()
    judge.limits()
    judge.consistency()
    s = judge.state
    findings = sorted(judge.findings, key=lambda f: -f.value / max(f.limit, 1e-9))
    return MotionCheck(
        {
            q: judge.measures.get(q, Measure(q, np.nan, np.nan, QUANTITY[q].unit))
            for q in QUANTITIES
        },
        tuple(findings),
        motion.time,
        s.tau,
        s.root_force,
        s.root_moment,
        s.com,
        s.point,
        s.gap,
        pressure,
        slips,
    )


class _Judge:
    """Goes through the quantities; collects measures and findings.

    Attributes:
        motion: What is judged.
        tol: What is allowed.
        state: What MuJoCo says about it.
        measures: The worst of each quantity so far.
        findings: What is wrong so far.
    """

    def __init__(self, motion: MotionUnderTest, tol: Tolerances, state: Sweep):
        self.motion, self.tol, self.state = motion, tol, state
        self.measures: dict[str, Measure] = {}
        self.findings: list[Finding] = []
        force, normal = motion.contact_force, state.normal
        self.pushed = np.einsum("nki,ki->nk", force, normal)  # normal force [N]
        self.tangential = force - self.pushed[..., None] * normal
        self.names = tuple(site.name for site in motion.sites)
        self.sides = tuple(site.side for site in motion.sites)
        self.feet = np.array([site.side != "" for site in motion.sites], bool)

    # Quantities -------------------------------------------------------------------------------

    def root(self) -> None:
        """Force and moment at the root that nothing explains."""
        for name, wrench in (
            ("root_force", self.state.root_force),
            ("root_moment", self.state.root_moment),
        ):
            share = 100.0 * np.linalg.norm(wrench, axis=1) / self.state.weight
            rms = float(np.sqrt(np.mean(share**2)))
            most = getattr(self.tol, f"{name}_max")
            mean = getattr(self.tol, f"{name}_rms")
            found = self._series(name, share[:, None], most, ("",), ("",))
            quantity = f"{name}_rms"
            unit = QUANTITY[quantity].unit
            self.measures[quantity] = Measure(quantity, rms, mean, unit)
            if rms > mean and not found:  # else it is the same fault said twice
                t = self.motion.time
                self._add(quantity, "", "", np.nan, t[0], t[-1], rms, mean)

    def slip(self) -> tuple[Slip, ...]:
        """Way and speed of the material where something stands."""
        t, standing = self.motion.time, self.motion.standing
        along = np.einsum("nki,ki->nk", self.state.velocity, self.state.normal)
        v = self.state.velocity - along[..., None] * self.state.normal
        slips: list[Slip] = []
        for i, site in enumerate(self.motion.sites):
            for start, stop in _runs(standing[:, i]):
                step, u = np.diff(t[start:stop])[:, None], v[start:stop, i]
                way = np.zeros((stop - start, 3))
                way[1:] = np.cumsum(0.5 * step * (u[1:] + u[:-1]), axis=0)
                far = 1000.0 * np.linalg.norm(way, axis=1)
                worst = int(np.argmax(far))
                since, until = (int(np.argmax(far >= x * far[worst])) for x in (0.05, 0.95))
                slips.append(
                    Slip(
                        site.name,
                        site.side,
                        start=float(t[start]),
                        end=float(t[stop - 1]),
                        distance=float(far[worst]),
                        time=float(t[start + worst]),
                        since=float(t[start + since]),
                        until=float(t[start + until]),
                    )
                )
        self._slips(slips)
        speed = np.where(standing, np.linalg.norm(v, axis=2), -np.inf)
        self._series("slip_speed", speed, self.tol.slip_speed, self.names, self.sides)
        return tuple(slips)

    def penetration(self) -> None:
        """Depth of every sphere and site; height of what should stand."""
        s, motion = self.state, self.motion
        gap, names, sides = [], [], []
        for i, site in enumerate(motion.sites):
            # Beside a seat the body may be lower than it; the ground is everywhere.
            there = motion.standing[:, i] | (site.side != "")
            gap.append(np.where(there, s.gap[:, i], np.inf))
            names.append(site.name)
            sides.append(site.side)
        normal = np.array(motion.ground.normal)
        low = s.spheres - s.sphere_radii[:, None] * normal
        height = motion.ground.under(low)
        for j, name in enumerate(s.sphere_names):
            away = np.linalg.norm(s.point - low[:, j, None], axis=2).max(axis=0, initial=0.0)
            if len(away) and np.min(away) < _SAME:
                continue  # looked at as a site
            gap.append(low[:, j] @ normal - height[:, j])
            names.append(name.removeprefix(SPHERE))
            sides.append(side_of_name(name))
        if gap:
            depth = -1000.0 * np.stack(gap, axis=1)
            self._series("penetration", depth, self.tol.penetration, tuple(names), tuple(sides))
        hover = np.where(motion.standing, 1000.0 * s.gap, -np.inf)
        self._series("hover", hover, self.tol.hover, self.names, self.sides)

    def forces(self) -> None:
        """Friction, pull, force in the air, too much force."""
        tol, weight = self.tol, self.state.weight
        sites = (self.names, self.sides)
        along = np.linalg.norm(self.tangential, axis=2)
        ratio = along / np.maximum(self.pushed, 0.01 * tol.negligible * weight)
        mu = self.motion.ground.friction
        self._series("friction", ratio, mu + tol.friction, *sites, shown=mu)
        self._series("adhesion", -100.0 * self.pushed / weight, tol.adhesion, *sites)
        size = 100.0 * np.linalg.norm(self.motion.contact_force, axis=2) / weight
        loose = np.where(self.motion.standing, -np.inf, size)
        self._series("unsupported", loose, tol.unsupported, *sites)
        most = self.motion.limits.force
        limit = np.inf if most is None else most * (1.0 + 0.01 * tol.force)
        self._series("force", self.pushed, limit, *sites, shown=most)

    def pressure(self) -> Float[Array, "n_frames 3"]:
        """Centres of pressure against the hull of what stands; returns that of the motion."""
        motion, s = self.motion, self.state
        n = len(motion.time)
        normal = np.array(motion.ground.normal)
        plane = _tangents(normal)
        flat = s.point @ plane.T  # (n, k, 2)
        load = np.where(self.feet, np.maximum(self.pushed, 0.0), 0.0)
        least = 0.01 * self.tol.negligible * s.weight

        # What the feet must supply: all that the motion asks for, but for what other supports give.
        other = np.where(self.feet[:, None], 0.0, motion.contact_force)
        force = s.root[:, :3] - other.sum(axis=1)
        moment = s.root[:, 3:] - cross(s.point - s.com[:, None], other).sum(axis=1)
        # Feet on different levels: friction acts at each one's own height.
        level = s.point @ normal
        share = load + 1e-9 * self.feet * (1.0 + 1e6 * motion.standing)
        total = share.sum(axis=1, keepdims=True)
        mean = (share * level).sum(axis=1, keepdims=True) / np.where(total > 0, total, 1.0)
        lever = np.where(self.feet, level - mean, 0.0)
        friction = np.where(self.feet[:, None], self.tangential, 0.0)
        moment = moment - (lever[..., None] * cross(normal, friction)).sum(axis=1)
        origin = s.com + (mean - s.com @ normal[:, None]) * normal
        moment = moment + cross(s.com - origin, force)
        up = force @ normal
        asks = up > least
        safe = np.where(asks, up, 1.0)
        centre = np.where(
            asks[:, None], origin + cross(normal, moment) / safe[:, None], np.full((n, 3), np.nan)
        )

        columns, names, sides = [], [], []
        out = _outside(centre @ plane.T, flat, motion.standing & self.feet)
        columns.append(out * np.clip(up / s.weight, 0.0, 1.0))
        names.append("the feet")
        sides.append("")
        for side, name in (("r", "the right foot"), ("l", "the left foot")):
            mine = np.array([each == side for each in self.sides], bool)
            up = np.where(mine, self.pushed, 0.0).sum(axis=1)
            own = np.where(mine, self.pushed, 0.0)[..., None] * flat
            safe = np.where(up > least, up, np.nan)
            out = _outside(own.sum(axis=1) / safe[:, None], flat, motion.standing & mine)
            columns.append(out * np.clip(up / s.weight, 0.0, 1.0))
            names.append(name)
            sides.append(side)
        outside = 1000.0 * np.stack(columns, axis=1)
        self._series("pressure", outside, self.tol.pressure, tuple(names), tuple(sides))
        return centre

    def limits(self) -> None:
        """Joint, velocity and torque limits."""
        motion, model, limits = self.motion, self.motion.model, self.motion.limits
        names = motion.coordinates
        if not names:
            return
        sides = tuple(side_of_name(name) for name in names)
        q, v, tau = motion.qpos[:, 7:], motion.qvel[:, 6:], self.state.tau[:, 6:]
        low, high = _given(limits.coordinate, model.jnt_range[1:], model.jnt_limited[1:])
        beyond = np.rad2deg(np.maximum(q - high, low - q))
        self._series("coordinate", beyond, self.tol.coordinate, names, sides)
        if limits.velocity is not None:
            most = np.broadcast_to(np.asarray(limits.velocity, float), v.shape)
            allowed = 100.0 + self.tol.velocity
            use, shown = 100.0 * np.abs(v) / most, (np.abs(v), most, "rad/s")
            self._series("velocity", use, allowed, names, sides, shown=100.0, actual=shown)
        low, high = _given(limits.torque, model.jnt_actfrcrange[1:], model.jnt_actfrclimited[1:])
        bound = np.broadcast_to(np.where(tau > 0, high, low), tau.shape)
        scale = np.maximum(np.abs(low), np.abs(high))
        with np.errstate(invalid="ignore", divide="ignore"):  # a joint may be strong one way only
            use = np.where(bound != 0.0, tau / bound, 1.0 + np.abs(tau) / scale)
        use = np.where(np.isfinite(bound) & (tau != 0.0), use, 0.0)
        allowed = 100.0 + self.tol.torque
        shown = (np.abs(tau), np.abs(bound), "N m")
        self._series("torque", 100.0 * use, allowed, names, sides, shown=100.0, actual=shown)

    def consistency(self) -> None:
        """Positions, velocities, accelerations, momentum and energy belong together."""
        motion, s, tol = self.motion, self.state, self.tol
        n, nv = motion.qvel.shape
        if n < 2:
            return
        h = np.diff(motion.time)[:, None]
        middle = motion.time[:-1] + 0.5 * h[:, 0]
        v, a = motion.qvel, motion.qacc
        rate = np.empty((n - 1, nv))
        for f in range(n - 1):
            mujoco.mj_differentiatePos(
                motion.model, rate[f], h[f, 0], motion.qpos[f], motion.qpos[f + 1]
            )
        names = (*_ROOT, *motion.coordinates)
        sides = tuple(side_of_name(name) for name in names)
        floor = np.r_[np.full(3, 0.5), np.ones(nv - 3)]
        scale = np.maximum(np.abs(v).max(axis=0), floor)
        off = np.abs(rate - 0.5 * (v[1:] + v[:-1]) + h / 12.0 * (a[1:] - a[:-1]))
        wrong = self._series(
            "velocity_mismatch",
            100.0 * off / scale,
            tol.velocity_mismatch,
            names,
            sides,
            times=middle,
            by_name=True,
        )
        if n > 2:
            h0, h1 = h[:-1], h[1:]
            second = 2.0 * (rate[1:] - rate[:-1]) / (h0 + h1)
            mean = (h0 * a[:-2] + 2.0 * (h0 + h1) * a[1:-1] + h1 * a[2:]) / (3.0 * (h0 + h1))
            floor = np.r_[np.full(3, 3.0), np.full(nv - 3, 10.0)]
            scale = np.maximum(np.abs(a).max(axis=0), floor)
            wrong |= self._series(
                "acceleration_mismatch",
                100.0 * np.abs(second - mean) / scale,
                tol.acceleration_mismatch,
                names,
                sides,
                times=motion.time[1:-1],
                by_name=True,
            )
        # The same once more for the whole body: a judge who asks twice, but says it once.
        known = wrong or any(f.quantity.startswith("root_") for f in self.findings)
        force = motion.contact_force
        gravity = motion.model.opt.gravity * (s.weight / np.linalg.norm(motion.model.opt.gravity))
        pull = force.sum(axis=1) + gravity
        twist = cross(s.point - s.com[:, None], force).sum(axis=1)
        given = np.hstack([pull, twist])
        off = np.diff(s.momentum, axis=0) / h - 0.5 * (given[1:] + given[:-1])
        share = 100.0 * np.maximum(
            np.linalg.norm(off[:, :3], axis=1), np.linalg.norm(off[:, 3:], axis=1)
        )
        one: dict[str, Any] = {"names": ("",), "sides": ("",), "times": middle, "say": not known}
        self._series("momentum", share[:, None] / s.weight, tol.momentum, **one)
        work = np.diff(s.energy) / h[:, 0] - 0.5 * (s.power[1:] + s.power[:-1])
        most = max(float(np.abs(s.power).max()), s.weight)
        one["say"] = not wrong
        self._series("energy", 100.0 * np.abs(work)[:, None] / most, tol.energy, **one)

    # What is common to all --------------------------------------------------------------------

    def _series(
        self,
        quantity: str,
        values: np.ndarray,
        limit: float,
        names: Sequence[str],
        sides: Sequence[str],
        *,
        shown: float | None = None,
        actual: tuple[np.ndarray, np.ndarray, str] | None = None,
        times: np.ndarray | None = None,
        by_name: bool = False,
        say: bool = True,
    ) -> bool:
        """Measure a quantity over time and places; return whether it is out of its limit.

        Args:
            quantity: Which.
            values: Its values (n, m); -inf or NaN where there is none.
            limit: What is allowed, tolerance included.
            names: Names of the columns.
            sides: Sides of the columns.
            shown: The limit to show, without the tolerance; ``limit`` if not given.
            actual: Values, limits and unit that findings show instead of these.
            times: Times of the rows [s]; the frames' if not given.
            by_name: Report only the worst of all places at a time.
            say: Whether to add findings.
        """
        t = self.motion.time if times is None else times
        values = np.where(np.isfinite(values), values, -np.inf)
        unit = QUANTITY[quantity].unit
        shown = limit if shown is None else shown
        if values.size == 0 or not np.isfinite(values).any():
            self.measures[quantity] = Measure(quantity, np.nan, shown, unit)
            return False
        row, column = divmod(int(np.argmax(values)), values.shape[1])
        worst = float(values[row, column])
        self.measures[quantity] = Measure(
            quantity, worst, shown, unit, float(t[row]), names[column], sides[column]
        )
        if worst <= limit or not say:
            return worst > limit
        for group in _groups(quantity, names, sides, by_name):
            part = values[:, group]
            for start, stop in _runs(np.any(part > limit, axis=1), t):
                inside = part[start:stop]
                row, column = divmod(int(np.argmax(inside)), inside.shape[1])
                bad = [names[int(group[j])] for j in np.flatnonzero((inside > limit).any(axis=0))]
                row, column = start + row, int(group[column])
                name, value, most, unit = names[column], float(values[row, column]), shown, ""
                if actual is not None:
                    value, most, unit = (*(float(x[row, column]) for x in actual[:2]), actual[2])
                self._add(
                    quantity,
                    name,
                    sides[column],
                    t[row],
                    t[start],
                    t[stop - 1],
                    value,
                    most,
                    tuple(each for each in bad if each != name),
                    unit,
                )
        return True

    def _slips(self, slips: list[Slip]) -> None:
        """Measure the slips and report each foot's stances once."""
        limit, unit = self.tol.slip, QUANTITY["slip"].unit
        if not slips:
            self.measures["slip"] = Measure("slip", np.nan, limit, unit)
            return
        worst = max(slips, key=lambda s: s.distance)
        self.measures["slip"] = Measure(
            "slip", worst.distance, limit, unit, worst.time, worst.site, worst.side
        )
        bad = sorted((s for s in slips if s.distance > limit), key=lambda s: s.start)
        while bad:
            first = bad[0]
            same, end = [first], first.end
            for s in bad[1:]:
                if _key(s.site, s.side) == _key(first.site, first.side) and s.start <= end:
                    same.append(s)
                    end = max(end, s.end)
            bad = [s for s in bad if not any(s is each for each in same)]
            w = max(same, key=lambda s: s.distance)
            others = tuple(dict.fromkeys(s.site for s in same if s.site != w.site))
            self._add("slip", w.site, w.side, w.time, w.since, w.until, w.distance, limit, others)

    def _add(
        self,
        quantity: str,
        name: str,
        side: str,
        time: float,
        start: float,
        end: float,
        value: float,
        limit: float,
        others: tuple[str, ...] = (),
        unit: str = "",
    ) -> None:
        q = QUANTITY[quantity]
        self.findings.append(
            Finding(
                quantity,
                name,
                side,
                float(time),
                float(start),
                float(end),
                float(value),
                float(limit),
                unit or q.unit,
                q.advice,
                others,
            )
        )


_ROOT = ("root x", "root y", "root z", "root turn x", "root turn y", "root turn z")


def _key(name: str, side: str) -> str:
    """Return what is reported together: a foot; a place on no foot alone."""
    return side or name


def _groups(
    quantity: str, names: Sequence[str], sides: Sequence[str], by_name: bool
) -> list[np.ndarray]:
    """Return the columns that are reported together."""
    if by_name:
        return [np.arange(len(names))]
    if quantity in OF_JOINTS:
        keys = list(names)
    else:
        keys = [_key(n, s) for n, s in zip(names, sides, strict=True)]
    return [np.flatnonzero([k == key for k in keys]) for key in dict.fromkeys(keys)]


def _runs(mask: np.ndarray, times: np.ndarray | None = None) -> list[tuple[int, int]]:
    """Return (start, stop) of every run of true; with ``times``, close ones are one."""
    edges = np.flatnonzero(np.diff(np.r_[0, mask.astype(np.int8), 0]))
    runs = [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
    if times is None:
        return runs
    merged: list[tuple[int, int]] = []
    for start, stop in runs:
        if merged and times[start] - times[merged[-1][1] - 1] <= _APART:
            merged[-1] = (merged[-1][0], stop)
        else:
            merged.append((start, stop))
    return merged


def _tangents(normal: np.ndarray) -> np.ndarray:
    """Return two axes along the plane (2, 3)."""
    first = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def _outside(
    point: Float[Array, "n 2"], corners: Float[Array, "n k 2"], there: np.ndarray
) -> Float[Array, " n"]:
    r"""Return how far points are outside of hulls; negative inside, NaN where nothing stands.

    The distance is :math:`\max_d\; d^T p - \max_i d^T x_i` over unit directions :math:`d`; the
    greatest is at the normal of a side, or points from a corner to the point.

    Args:
        point: Point of every frame [m].
        corners: Places whose hull is meant [m].
        there: Which of them count (n, k).
    """
    n, k = there.shape
    result = np.full(n, np.nan)
    use = there.any(axis=1) & np.isfinite(point).all(axis=1)
    if not use.any():
        return result
    every = np.flatnonzero(there[use].any(axis=0))
    p, x, there = point[use], corners[use][:, every], there[use][:, every]
    i, j = np.triu_indices(len(every), 1)
    side = x[:, j] - x[:, i]
    normal = np.stack([side[..., 1], -side[..., 0]], axis=2)
    directions = np.concatenate([normal, -normal, p[:, None] - x], axis=1)
    length = np.linalg.norm(directions, axis=2, keepdims=True)
    directions = directions / np.where(length > 1e-12, length, np.inf)
    support = np.einsum("ndc,nkc->ndk", directions, x)
    support = np.where(there[:, None], support, -np.inf).max(axis=2)
    distance = np.einsum("ndc,nc->nd", directions, p) - support
    distance = np.where(length[..., 0] > 1e-12, distance, -np.inf).max(axis=1)
    result[use] = np.where(np.isfinite(distance), distance, 0.0)
    return result


def _given(own: Any, of_model: np.ndarray, limited: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper limits: those given, or those of the model where it has some."""
    if own is not None:
        return own[0], own[1]
    on = np.asarray(limited, bool)
    return np.where(on, of_model[:, 0], -np.inf), np.where(on, of_model[:, 1], np.inf)


__all__ = [
    "QUANTITIES",
    "ContactSite",
    "Finding",
    "Ground",
    "Limits",
    "Measure",
    "MotionCheck",
    "MotionUnderTest",
    "Slip",
    "Tolerances",
    "examine",
    "motion_of_record",
    "motion_of_run",
]
