r"""Check of a Record against physics, its limits and its task, independent of the engines.

The motion is examined frame by frame with MuJoCo's inverse dynamics alone; no expression or
constant of an optimiser is used. With the equations of motion of the free body,

.. math:: M(q)\,\dot v + h(q, v) = \tau + \sum_k J_k^T f_k,

the first six entries of :math:`\tau` are the unexplained residual at the root and must be zero; the
others are the true joint torques. The material at the lowest point of a site in stance must not
move. A sphere that rolls does not slip, so velocities are integrated, :math:`\int v_t\,dt`, and
positions are not compared. Centres of pressure must lie in the base of support
(:mod:`plantigrade.analyze.pressure`), and every condition of the task must hold in all frames
(:mod:`plantigrade.analyze.conditions`).

The consistency of positions, velocities and accelerations is checked step by step with the
relations that a cubic satisfies exactly,

.. math:: \frac{q_1 - q_0}{h} = \frac{v_0 + v_1}{2} - \frac{h}{12}(a_1 - a_0),
    \qquad \frac{q_2 - 2 q_1 + q_0}{h^2} = \frac{a_0 + 4 a_1 + a_2}{6}

(and their forms for unequal steps), and for the whole body: the rate of momentum equals the
external forces, the rate of energy the power of the joints.
"""

from collections.abc import Iterator

import mujoco
import numpy as np

from plantigrade.analyze.conditions import check_conditions
from plantigrade.analyze.findings import FindingCollector, LocatedSeries, runs
from plantigrade.analyze.overlap import ground_overlap, overlap
from plantigrade.analyze.pressure import centre_of_pressure, outside_support
from plantigrade.analyze.quantities import QUANTITIES, QUANTITY
from plantigrade.analyze.sweep import Sweep, seen_from_ground, sweep
from plantigrade.analyze.tolerances import RECORDING_TOLERANCES, Tolerances
from plantigrade.analyze.verdict import Measure, Slip, Verdict
from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.site import PUSH_PART
from plantigrade.errors import ParameterError
from plantigrade.record import Record, Run
from plantigrade.record.moving_ground import GroundPath
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import cross

_LEAST_FRICTION = 1e-3  # [1] friction of a support below which its check goes no further down
_SAME_POINT = 1e-4  # [m] distance below which a sphere and a site are the same point
SUPPORT_REACH = 0.1
"""How far the surface of a seat, an armrest or a wall extends at least around the place that it
carries at [m]; a site this near must not be behind it. Half of a narrow chair is 20 cm deep, an
armrest 8 cm wide."""
_ROOT = ("root x", "root y", "root z", "root turn x", "root turn y", "root turn z")
_FEET = ("the feet", "the right foot", "the left foot")


def check(record: Record | Run, tolerances: Tolerances | None = None) -> Verdict:
    """Return the verdict on a motion, its forces, limits and task conditions.

    Sample the motion finely, with ten frames per node of the optimisation, nodes included.

    Args:
        record: Record or run, with accelerations.
        tolerances: Tolerances; by default those of simulated motions, or
            :data:`~plantigrade.analyze.tolerances.RECORDING_TOLERANCES` for recordings.

    Raises:
        ParameterError: If the motion cannot be checked.
    """
    if isinstance(record, Run):
        record = record.record
    if not isinstance(record, Record):
        raise ParameterError(f"only a Record or a Run can be checked, not {type(record).__name__}")
    recorded = bool(record.sites) and all(site.measured for site in record.sites)
    tol = tolerances or (RECORDING_TOLERANCES if recorded else Tolerances())
    s = sweep(record)
    min_force = 0.01 * tol.negligible * s.weight
    centre = centre_of_pressure(record, s, min_force)
    slips = _slips(record, s)
    collector = FindingCollector(record.motion.time)
    for series in _root(s, tol, _advice(record) if recorded else ""):
        collector.add(series)
    collector.add_slips(slips, tol.slip)
    outside = np.where(
        s.known[:, None], 1000.0 * outside_support(record, s, centre, min_force), np.nan
    )
    for series in (
        *_geometry(record, s, tol),
        *_forces(record, s, tol),
        LocatedSeries("pressure", outside, tol.pressure, _FEET, ("", "r", "l")),
        _overlap(record, s, tol),
        *_limits(record, s, tol),
        *_consistency(record, s, tol),
    ):
        collector.add(series)
    conditions, broken = check_conditions(*seen_from_ground(record, s), tol)
    unmeasured = {q: Measure(q, np.nan, np.nan, QUANTITY[q].unit) for q in QUANTITIES}
    return Verdict(
        {q: collector.measures.get(q, unmeasured[q]) for q in QUANTITIES},
        conditions,
        tuple(sorted((*collector.findings, *broken), key=lambda f: -f.excess)),
        record.motion.time,
        s.tau,
        s.root_force,
        s.root_moment,
        s.com,
        s.point,
        s.gap,
        centre,
        slips,
    )


def _advice(record: Record) -> str:
    """Return advice for a recording whose forces do not explain its motion."""
    if "forces.measured" in record.signals:
        return (
            "noise of the motion remains as a residual of estimated forces; a larger one comes "
            "from a hand or seat that supports the person, from the body mass, or from the fit"
        )
    return "check the body mass, the timing and position of the plates, and the fit"


def _root(s: Sweep, tol: Tolerances, advice: str) -> Iterator[LocatedSeries]:
    """Yield residual force and moment at the root, where all forces are known."""
    for name, wrench in (("root_force", s.root_force), ("root_moment", s.root_moment)):
        share = 100.0 * np.linalg.norm(wrench, axis=1)[s.known] / s.weight
        most, mean = getattr(tol, f"{name}_max"), getattr(tol, f"{name}_rms")
        values = np.full(len(s.known), np.nan)
        values[s.known] = share
        yield LocatedSeries(name, values[:, None], most, advice=advice)
        if len(share):
            rms = np.array([[np.sqrt(np.mean(share**2))]])
            yield LocatedSeries(
                f"{name}_rms", rms, mean, times=np.array([np.nan]), unless=(name,), advice=advice
            )


def _slips(record: Record, s: Sweep) -> tuple[Slip, ...]:
    """Return the slip in every stance of every site."""
    t, v = record.motion.time, _sliding(s)
    slips: list[Slip] = []
    for i, site in enumerate(record.sites):
        for start, stop in runs(s.standing[:, i]):
            step, u = np.diff(t[start:stop])[:, None], v[start:stop, i]
            path = np.zeros((stop - start, 3))
            path[1:] = np.cumsum(0.5 * step * (u[1:] + u[:-1]), axis=0)
            far = 1000.0 * np.linalg.norm(path, axis=1)
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
    return tuple(slips)


def _sliding(s: Sweep) -> Float[Array, "n k 3"]:
    """Return the tangential velocity of the material [m/s]."""
    along = np.einsum("nki,nki->nk", s.velocity, s.normal)
    return s.velocity - along[..., None] * s.normal


def _geometry(record: Record, s: Sweep, tol: Tolerances) -> Iterator[LocatedSeries]:
    """Yield slip speed, penetration of spheres and sites, and height of sites in stance."""
    names, sides = _site_names(record)
    speed = np.where(s.standing, np.linalg.norm(_sliding(s), axis=2), -np.inf)
    yield LocatedSeries("slip_speed", speed, tol.slip_speed, names, sides)
    # Next to a support the body may be behind its surface; the ground is everywhere.
    boards = {seat.site for seat in record.ground.seats}
    grounded = np.array([name not in boards for name in names], bool)
    supported = s.standing | grounded | _facing(record, s)
    gap = np.where(supported & s.spread, s.gap, np.inf)
    distance = np.linalg.norm(s.point[:, :, None] - s.spheres[:, None], axis=3).max(axis=0)
    separate = np.flatnonzero((distance >= _SAME_POINT).all(axis=0))  # the others are sites
    yield LocatedSeries(
        "penetration",
        -1000.0 * np.hstack([gap, s.clearance[:, separate]]),
        tol.penetration,
        (*names, *(s.sphere_names[j] for j in separate)),
        (*sides, *(s.sphere_sides[j] for j in separate)),
    )
    hover = np.where(s.standing, 1000.0 * s.gap, -np.inf)
    yield LocatedSeries("hover", hover, tol.hover, names, sides)


def _facing(record: Record, s: Sweep) -> Bool[Array, "n k"]:
    """Return whether a site is where its support is, seen along the normal, and not far behind."""
    near = np.zeros(s.gap.shape, bool)
    for seat in record.ground.seats:
        for i, site in enumerate(record.sites):
            if site.name == seat.site:
                there = record.ground.displacement(record.motion.time, seat) + seat.position
                away = s.point[:, i] - there
                beside = np.linalg.norm(away - s.gap[:, i, None] * np.array(seat.normal), axis=1)
                near[:, i] = (beside < SUPPORT_REACH) & (s.gap[:, i] > -SUPPORT_REACH)
    return near


def _forces(record: Record, s: Sweep, tol: Tolerances) -> Iterator[LocatedSeries]:
    """Yield friction, adhesion, force without contact, and excessive force."""
    names, sides = _site_names(record)
    ground = np.array([site.part != PUSH_PART for site in record.sites], bool)
    pushed = np.einsum("nki,nki->nk", s.force, s.normal)  # normal force [N]
    pushed = np.where(ground, pushed, np.nan)
    along = np.linalg.norm(s.force - pushed[..., None] * s.normal, axis=2)
    ratio = along / np.maximum(pushed, 0.01 * tol.negligible * s.weight)
    mu, most = record.ground.friction, record.limits.force
    own = {s.site: s.friction for s in record.ground.seats if s.friction is not None}
    each = np.array([own.get(name, mu) for name in names])
    # as on the ground: that of a support with friction of its own, relative to it
    share = ratio * (mu / np.maximum(each, _LEAST_FRICTION))
    actual = (ratio, np.broadcast_to(each, ratio.shape), "") if own else None
    yield LocatedSeries("friction", share, mu + tol.friction, names, sides, shown=mu, actual=actual)
    yield LocatedSeries("adhesion", -100.0 * pushed / s.weight, tol.adhesion, names, sides)
    size = 100.0 * np.linalg.norm(s.force, axis=2) / s.weight
    unsupported = np.where(s.standing | ~s.spread, -np.inf, size)
    yield LocatedSeries("unsupported", unsupported, tol.unsupported, names, sides)
    limit = np.inf if most is None else most * (1.0 + 0.01 * tol.force)
    yield LocatedSeries("force", pushed, limit, names, sides, shown=most)


def _overlap(record: Record, s: Sweep, tol: Tolerances) -> LocatedSeries:
    """Return the overlap of body parts and, if the record has a limit, with the ground."""
    parts, most = [overlap(record.human, s.position, s.rotation)], record.limits.overlap
    if most is not None:
        moved, position, rotation = GroundPath.of(record), s.position, s.rotation
        if moved is not None:  # as seen from the ground
            position = moved.inward(position)
            rotation = moved.rotation.transpose(0, 2, 1)[:, None] @ rotation
        parts.append(ground_overlap(record.human, position, rotation, record.ground))
    limit = np.inf if most is None else 1000.0 * most + tol.overlap
    shown = limit if most is None else 1000.0 * most
    names = tuple(name.replace("_", " ") for part in parts for name in part.names)
    depth = 1000.0 * np.hstack([part.depth for part in parts])
    return LocatedSeries("overlap", depth, limit, names, shown=shown, worst_only=True)


def _limits(record: Record, s: Sweep, tol: Tolerances) -> Iterator[LocatedSeries]:
    """Yield excess over joint, velocity and torque limits."""
    motion, model, limits = record.motion, record.human.model, record.limits
    names = record.human.coordinates
    if not names:
        return
    sides = tuple(split_side(name)[1] for name in names)
    q, v, tau = motion.qpos[:, 7:], motion.qvel[:, 6:], s.tau[:, 6:] - record.device_torque[:, 6:]
    low, high = _bounds(limits.coordinate, model.jnt_range[1:], model.jnt_limited[1:])
    beyond = np.rad2deg(np.maximum(q - high, low - q))
    yield LocatedSeries("coordinate", beyond, tol.coordinate, names, sides)
    if limits.velocity is not None:
        most = np.broadcast_to(np.asarray(limits.velocity, float), v.shape)
        use, actual = 100.0 * np.abs(v) / most, (np.abs(v), most, "rad/s")
        allowed = 100.0 + tol.velocity
        yield LocatedSeries("velocity", use, allowed, names, sides, shown=100.0, actual=actual)
    low, high = _bounds(limits.torque, model.jnt_actfrcrange[1:], model.jnt_actfrclimited[1:])
    bound = np.broadcast_to(np.where(tau > 0, high, low), tau.shape)
    scale = np.maximum(np.abs(low), np.abs(high))
    with np.errstate(
        invalid="ignore", divide="ignore"
    ):  # a joint may have strength in one direction only
        use = np.where(bound != 0.0, tau / bound, 1.0 + np.abs(tau) / scale)
    use = np.where(np.isfinite(bound) & (tau != 0.0) & s.known[:, None], use, 0.0)
    actual = (np.abs(tau), np.abs(bound), "N m")
    allowed = 100.0 + tol.torque
    yield LocatedSeries("torque", 100.0 * use, allowed, names, sides, shown=100.0, actual=actual)


def _consistency(record: Record, s: Sweep, tol: Tolerances) -> Iterator[LocatedSeries]:
    """Yield inconsistencies of positions, velocities, accelerations, momentum and energy."""
    motion, model = record.motion, record.human.model
    n, nv = motion.qvel.shape
    if n < 2:
        return
    h = np.diff(motion.time)[:, None]
    middle = motion.time[:-1] + 0.5 * h[:, 0]
    v, a = motion.qvel, s.qacc
    rate = np.empty((n - 1, nv))
    for f in range(n - 1):
        mujoco.mj_differentiatePos(model, rate[f], h[f, 0], motion.qpos[f], motion.qpos[f + 1])
    names = (*_ROOT, *record.human.coordinates)
    sides = tuple(split_side(name)[1] for name in names)
    scale = np.maximum(np.abs(v).max(axis=0), np.r_[np.full(3, 0.5), np.ones(nv - 3)])
    off = np.abs(rate - 0.5 * (v[1:] + v[:-1]) + h / 12.0 * (a[1:] - a[:-1]))
    use, most = 100.0 * off / scale, tol.velocity_mismatch
    yield LocatedSeries("velocity_mismatch", use, most, names, sides, middle, worst_only=True)
    if n > 2:
        h0, h1 = h[:-1], h[1:]
        second = 2.0 * (rate[1:] - rate[:-1]) / (h0 + h1)
        mean = (h0 * a[:-2] + 2.0 * (h0 + h1) * a[1:-1] + h1 * a[2:]) / (3.0 * (h0 + h1))
        scale = np.maximum(np.abs(a).max(axis=0), np.r_[np.full(3, 3.0), np.full(nv - 3, 10.0)])
        use, most = 100.0 * np.abs(second - mean) / scale, tol.acceleration_mismatch
        times = motion.time[1:-1]
        yield LocatedSeries(
            "acceleration_mismatch", use, most, names, sides, times, worst_only=True
        )
    # The same faults for the whole body: checked twice, but reported once.
    mismatch = ("velocity_mismatch", "acceleration_mismatch")
    root = ("root_force", "root_force_rms", "root_moment", "root_moment_rms")
    gravity = model.opt.gravity * (s.weight / np.linalg.norm(model.opt.gravity))
    moment = cross(s.point - s.com[:, None], s.force) + s.torque
    given = np.hstack([s.force.sum(axis=1) + gravity, moment.sum(axis=1)])
    off = np.diff(s.momentum, axis=0) / h - 0.5 * (given[1:] + given[:-1])
    share = 100.0 * np.maximum(
        np.linalg.norm(off[:, :3], axis=1), np.linalg.norm(off[:, 3:], axis=1)
    )
    share = np.where(s.known[1:] & s.known[:-1], share, np.nan)[:, None] / s.weight
    yield LocatedSeries("momentum", share, tol.momentum, times=middle, unless=(*mismatch, *root))
    work = np.diff(s.energy) / h[:, 0] - 0.5 * (s.power[1:] + s.power[:-1])
    most = max(float(np.abs(s.power).max()), s.weight)
    share = 100.0 * np.abs(work)[:, None] / most
    yield LocatedSeries("energy", share, tol.energy, times=middle, unless=mismatch)


def _site_names(record: Record) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and sides of the sites."""
    return tuple(site.name for site in record.sites), tuple(site.side for site in record.sites)


def _bounds(
    own: Float[Array, "2 n"] | None, of_model: np.ndarray, limited: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper limits of the record, or else of the model."""
    if own is not None:
        return own[0], own[1]
    on = np.asarray(limited, bool)
    return np.where(on, of_model[:, 0], -np.inf), np.where(on, of_model[:, 1], np.inf)
