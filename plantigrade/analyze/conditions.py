"""Check of the conditions of a task in every frame, not only at the nodes."""

from collections.abc import Callable
from typing import Any

import numpy as np

from plantigrade.analyze.findings import runs
from plantigrade.analyze.sweep import Sweep
from plantigrade.analyze.tolerances import Tolerances
from plantigrade.analyze.verdict import Finding, Measure
from plantigrade.arrays import Array, Float
from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.record import Condition, Record
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, PELVIS

AXES = ("x", "y", "z")


def check_conditions(
    record: Record, s: Sweep, tol: Tolerances
) -> tuple[dict[str, Measure], list[Finding]]:
    """Return the worst value of every condition by name, and all violations.

    Conditions of one name are one condition at several times, as in the cycles of a periodic
    motion.
    """
    worst: dict[str, tuple[float, Measure]] = {}
    findings: list[Finding] = []
    for condition in record.conditions:
        excess, measure, more = _check(record, s, tol, condition)
        findings += more
        if condition.name not in worst or not excess <= worst[condition.name][0]:
            worst[condition.name] = (excess, measure)
    return {name: measure for name, (_, measure) in worst.items()}, findings


def _check(
    record: Record, s: Sweep, tol: Tolerances, condition: Condition
) -> tuple[float, Measure, list[Finding]]:
    """Return violation over tolerance, worst measure and findings of one condition."""
    allowed, unit, factor = _unit(condition, tol)
    time, value = _values(record, s, condition)
    low, high = condition.bounds(time)
    if condition.quantity == "displacement":
        low, high = (np.array(each[-1:]) for each in (condition.lower, condition.upper))
    label = condition.name
    if not len(time) or not np.isfinite(value).all():
        instant = float(condition.time[0])
        bad = Measure("condition", np.nan, np.nan, unit, instant, label, bad=True)
        finding = Finding(**vars(bad), start=instant, end=instant, excess=np.inf)
        return np.inf, bad, [finding]
    excess = np.maximum(low - value, value - high) * factor / allowed
    below = low - value > value - high
    bound = np.where(below, low, high)

    def measure(i: int) -> Measure:
        actual, limit = float(factor * value[i]), float(factor * bound[i])
        bad, lower = bool(excess[i] > 1.0), bool(below[i])
        at = float(time[i])
        return Measure("condition", actual, limit, unit, at, label, bad=bad, below=lower)

    findings = []
    for start, stop in runs(excess > 1.0, time):
        i = start + int(np.argmax(excess[start:stop]))
        span: dict[str, Any] = {"start": float(time[start]), "end": float(time[stop - 1])}
        findings.append(Finding(**vars(measure(i)), **span, excess=float(excess[i])))
    i = int(np.argmax(excess))
    return float(excess[i]), measure(i), findings


def _unit(condition: Condition, tol: Tolerances) -> tuple[float, str, float]:
    """Return the tolerance of a condition, the unit of its display, and the factor to it."""
    degrees = np.rad2deg(1.0)
    if condition.quantity == "clearance":
        return 0.001 * tol.clearance, "m", 1.0
    return {
        "rad": (tol.condition_deg, "deg", degrees),
        "m": (0.001 * tol.condition_mm, "m", 1.0),
        "rad/s": (np.rad2deg(tol.condition_rad_s), "deg/s", degrees),
        "m/s": (tol.condition_m_s, "m/s", 1.0),
        "W": (tol.condition_w, "W", 1.0),
        "N m": (tol.condition_n_m, "N m", 1.0),
    }[condition.unit]


def _values(
    record: Record, s: Sweep, condition: Condition
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return the times at which a condition is checked, and the values there.

    They are all frames within its time and both ends, interpolated between frames.
    """
    frames = record.motion.time
    series = _SERIES[condition.quantity](record, s, condition)
    start, stop = condition.time[0], condition.time[-1]
    stop = stop if np.isfinite(stop) else max(start, float(frames[-1]))
    inside = frames[condition.holds_at(frames)]
    ends = [t for t in (start, stop) if frames[0] - 1e-9 <= t <= frames[-1] + 1e-9]
    time = np.unique(np.r_[inside, ends])
    value = np.interp(time, frames, series)
    if condition.quantity == "displacement":
        return time[-1:], value[-1:] - value[:1]
    return time, value


def _coordinate(record: Record, s: Sweep, condition: Condition) -> Float[Array, " n"]:
    return record.motion[condition.of]


def _speed(record: Record, s: Sweep, condition: Condition) -> Float[Array, " n"]:
    motion, name = record.motion, condition.of
    if name in PELVIS[:3]:
        return np.gradient(motion[name], motion.time, edge_order=2)
    if name in PELVIS:
        return motion.qvel[:, :3] @ OPENSIM_TO_WORLD[:, PELVIS.index(name) - 3]
    return motion.velocity(name)


def _lowest(record: Record, s: Sweep, condition: Condition) -> Float[Array, "n 3"]:
    """Return the lowest point of a sphere [m]."""
    body = record.human.body(condition.of)
    place = s.position[:, body] + s.rotation[:, body] @ np.array(condition.position)
    return place - condition.radius * record.ground.normal


def _clearance(record: Record, s: Sweep, condition: Condition) -> Float[Array, " n"]:
    """Return the height of the lowest point of a sphere above the ground [m]."""
    low, ground = _lowest(record, s, condition), record.ground
    return ground.gap(low)


def _muscle_torque(record: Record, s: Sweep, condition: Condition) -> Float[Array, " n"]:
    """Return the torque of a joint's muscles: less that of passive tissue and devices [N m]."""
    motion, human, i = record.motion, record.human, record.human.hinge(condition.of)
    q, v = (
        np.stack([f(name) for name in human.coordinates])
        for f in (motion.__getitem__, motion.velocity)
    )
    passive = passive_moments(human.coordinates, list(q), list(v), scale(human.mass, human.height))
    return s.tau[:, 6 + i] - passive[i] - record.device_torque[:, 6 + i]


def _along(
    record: Record, vectors: Float[Array, "n 3"], condition: Condition
) -> Float[Array, " n"]:
    """Return the component of world vectors along an axis of the ground."""
    return vectors @ record.ground.to_world[:, AXES.index(condition.axis)]


_SERIES: dict[str, Callable[[Record, Sweep, Condition], np.ndarray]] = {
    "coordinate": _coordinate,
    "displacement": _coordinate,
    "speed": _speed,
    "rest": lambda record, s, c: np.abs(record.motion.qvel).max(axis=1),
    "point": lambda record, s, c: _along(record, _lowest(record, s, c), c),
    "clearance": _clearance,
    "com": lambda record, s, c: _along(record, s.com, c),
    "com speed": lambda record, s, c: _along(record, s.momentum[:, :3] / record.human.mass, c),
    "power": lambda record, s, c: _muscle_torque(record, s, c) * record.motion.velocity(c.of),
    "muscle torque": _muscle_torque,
}
