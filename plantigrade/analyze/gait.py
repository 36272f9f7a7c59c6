r"""Spatio-temporal measures of walking and running from gait events and the feet's path.

Lengths are relative to the ground: the motion of a treadmill's belt
(:mod:`plantigrade.motion.ground_velocity`) is subtracted first. Step length and width are measured
at heel strike along and across the stride of that foot, so walking may have any direction and turn;
a step is named after the foot that lands.

Terms as in [Whittle2007]_, chapter 2: double support is the sum of both parts of the cycle in
which both feet are on the ground. In running, where steps have a flight
(:func:`~plantigrade.motion.event_timing.is_running`), there is none; contact time, flight time and
duty factor, the ratio of contact time to stride time, are reported instead.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.motion.cycles import Cycle, cut_cycles
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.filters import derivative, fill_gaps
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import GaitEvent
from plantigrade.motion.swings import MAX_FLIGHT

MAX_STANCE = 3.0  #: Maximum contact time of a gait [s]; a longer contact is standing
MAX_STEP_TIME = 1.5
"""Maximum time between heel strikes of one step [s]; a longer pause is standing. Chosen."""
MIN_STRIDE = 0.05  #: Minimum stride length that defines a line of walking [m]

_UNITS = {
    "cadence": "steps_min",
    "step_width": "m",
    "double_support": "pct",
    "stride_length": "m",
    "stride_time": "s",
    "step_length": "m",
    "step_time": "s",
    "stance": "pct",
    "swing": "pct",
}
_UNITS_OF_RUNNING = {"contact_time": "s", "flight_time": "s", "duty_factor": "ratio"}


@dataclass(frozen=True)
class Statistic:
    """Mean, sample standard deviation and count of one measure; NaN if unknown."""

    mean: float
    sd: float
    count: int

    @classmethod
    def of(cls, values: Iterable[float]) -> "Statistic":
        """Return the statistic of values, ignoring NaN."""
        known = np.array([v for v in values if v is not None and np.isfinite(v)], dtype=float)
        mean = float(known.mean()) if len(known) else float("nan")
        sd = float(known.std(ddof=1)) if len(known) > 1 else float("nan")
        return cls(mean, sd, len(known))


@dataclass(frozen=True)
class GaitMeasures:
    """Spatio-temporal measures; those by side are dictionaries with keys ``"l"`` and ``"r"``."""

    #: Speed over the ground [m/s]: stride length over stride time, all strides
    speed: Statistic
    #: Steps per minute [1/min]: two per stride time, so that missed or false steps cannot double it
    cadence: Statistic
    #: Heel strike to next heel strike of the same foot, over the ground [m]
    stride_length: dict[str, Statistic]
    stride_time: dict[str, Statistic]  #: The same in time [s]
    #: Other foot to this foot at its heel strike, along the line of walking [m]
    step_length: dict[str, Statistic]
    step_time: dict[str, Statistic]  #: Other foot's heel strike to this foot's [s]
    #: Distance of the landing heel from the line of the other foot's stride [m]
    step_width: Statistic
    stance: dict[str, Statistic]  #: Heel strike to toe off [% of stride]
    swing: dict[str, Statistic]  #: Toe off to heel strike [% of stride]
    double_support: Statistic  #: Both feet on the ground, both parts together [% of stride]
    treadmill: bool  #: Whether the ground moved
    #: Mean speed of the ground [m/s]; 0 overground. It is estimated from the feet in stance,
    #: not read from the treadmill.
    belt_speed: float
    running: bool  #: Whether most steps have a flight
    contact_time: dict[str, Statistic]  #: Heel strike to toe off [s]
    #: Of running: toe off to the other foot's heel strike, named after the foot that leaves [s]
    flight_time: dict[str, Statistic]

    @property
    def duty_factor(self) -> dict[str, Statistic]:
        """Contact time over stride time."""
        return {
            side: Statistic(s.mean / 100.0, s.sd / 100.0, s.count)
            for side, s in self.stance.items()
        }

    def metrics(self) -> dict[str, float | int | bool]:
        """Return every measure under a flat key with its unit; unknown ones are omitted."""
        flat: dict[str, float | int | bool] = {}

        def put(name, unit, measure):
            if measure.count:
                flat[f"{name}_{unit}"] = measure.mean
            if measure.count > 1:
                flat[f"{name}_sd_{unit}"] = measure.sd

        put("running_speed" if self.running else "walking_speed", "m_s", self.speed)
        for name, unit in (_UNITS | (_UNITS_OF_RUNNING if self.running else {})).items():
            measure = getattr(self, name)
            if isinstance(measure, dict):
                for side in SIDES:
                    put(f"{name}_{side}", unit, measure[side])
            else:
                put(name, unit, measure)
        for side in SIDES:
            flat[f"strides_{side}_count"] = self.stride_time[side].count
        flat["treadmill"] = self.treadmill
        flat["running"] = self.running
        if self.treadmill:
            flat["belt_speed_m_s"] = self.belt_speed
        return flat


def gait_measures(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    events: Iterable[GaitEvent],
    *,
    overground: bool = False,
) -> GaitMeasures:
    """Return the spatio-temporal measures of a recording.

    Args:
        time: Time of each frame [s].
        heel: Back of the heel, right then left, world [m]; NaN if not visible.
        toe: Toe tip or metatarsal head, right then left, world [m] (to detect moving ground).
        events: Gait events; measures outside them remain unknown.
        overground: Whether the ground is known to be at rest; otherwise its velocity is
            estimated from the feet.
    """
    events = sorted(events, key=lambda event: event.time)
    ground = np.zeros((len(time), 3)) if overground else ground_velocity(time, heel, toe)
    belt = float(np.linalg.norm(ground.mean(axis=0))) if len(time) else 0.0
    floor, running = _over_ground(time, heel, ground), is_running(events)
    return GaitMeasures(
        **_strides(time, floor, cut_cycles(events), running),
        **_contacts(events, running),
        **_steps(time, floor, [e for e in events if e.kind == "heel_strike"]),
        treadmill=belt > 0,
        belt_speed=belt,
        running=running,
    )


def _empty() -> dict[str, list[float]]:
    return {side: [] for side in SIDES}


def _by_side(table: dict[str, list[float]]) -> dict[str, Statistic]:
    return {side: Statistic.of(table[side]) for side in SIDES}


def _strides(time, floor, cycles: Iterable[Cycle], running: bool) -> dict[str, Any]:
    """Return the measures of whole cycles."""
    lengths, times, stance, swing = (_empty() for _ in range(4))
    speeds, double = [], []
    for cycle in cycles:
        k = SIDES.index(cycle.side)
        a, b = _at(time, floor, cycle.start, k), _at(time, floor, cycle.stop, k)
        length = float(np.linalg.norm(b - a))
        lengths[cycle.side].append(length)
        times[cycle.side].append(cycle.duration)
        speeds.append(length / cycle.duration)
        if cycle.toe_off is not None:
            percent = cycle.percent(cycle.toe_off)
            stance[cycle.side].append(percent)
            swing[cycle.side].append(100.0 - percent)
            first, second = cycle.opposite_toe_off, cycle.opposite_heel_strike
            if first is not None and second is not None and first < second < cycle.stop:
                both = max(cycle.toe_off - second, 0.0) + max(first - cycle.start, 0.0)
                double.append(100.0 * both / cycle.duration)
    return {
        "speed": Statistic.of(speeds),
        "cadence": Statistic.of(120.0 / t for s in SIDES for t in times[s]),
        "stride_length": _by_side(lengths),
        "stride_time": _by_side(times),
        "stance": _by_side(stance),
        "swing": _by_side(swing),
        "double_support": Statistic.of(() if running else double),
    }


def _contacts(events: Sequence[GaitEvent], running: bool) -> dict[str, Any]:
    """Return contact times, and flight times of running."""
    contacts, flights = _empty(), _empty()
    strikes, offs = (
        {side: [e.time for e in events if (e.side, e.kind) == (side, kind)] for side in SIDES}
        for kind in ("heel_strike", "toe_off")
    )
    for own, other in (SIDES, SIDES[::-1]):
        for start in strikes[own]:
            contacts[own] += [t - start for t in offs[own] if 0 < t - start < MAX_STANCE][:1]
        for off in offs[own] if running else ():
            flights[own] += [t - off for t in strikes[other] if 0 < t - off < MAX_FLIGHT][:1]
    return {"contact_time": _by_side(contacts), "flight_time": _by_side(flights)}


def _steps(time, floor, strikes: Sequence[GaitEvent]) -> dict[str, Any]:
    """Return length, width and time of steps between heel strikes."""
    step_times, step_lengths, widths = _empty(), _empty(), []
    measured: dict[int, list[float]] = {}  # step length by index of the strike that ends it
    for before, now in pairwise(strikes):
        if before.side != now.side and now.time - before.time <= MAX_STEP_TIME:
            step_times[now.side].append(now.time - before.time)
    # A step lies between two strikes of the other foot, which define the line of walking.
    triples = zip(strikes[:-2], strikes[1:-1], strikes[2:], strict=True)
    for i, (first, now, last) in enumerate(triples):
        if not first.side == last.side != now.side or last.time - first.time > 2 * MAX_STEP_TIME:
            continue
        k, other = SIDES.index(now.side), SIDES.index(first.side)
        start, end = _at(time, floor, first.time, other), _at(time, floor, last.time, other)
        landing = _at(time, floor, now.time, k)
        line = end - start
        norm = np.linalg.norm(line)
        if not norm > MIN_STRIDE:
            continue
        line = line / norm
        across = landing - start
        measured.setdefault(i + 1, []).append(float(across @ line))
        measured.setdefault(i + 2, []).append(float((end - landing) @ line))
        widths.append(float(abs(line[0] * across[1] - line[1] * across[0])))
    # A step within the walk is measured along the strides of both feet; its length is the mean.
    for i, values in measured.items():
        step_lengths[strikes[i].side].append(float(np.mean(values)))
    return {
        "step_time": _by_side(step_times),
        "step_length": _by_side(step_lengths),
        "step_width": Statistic.of(widths),
    }


def _over_ground(time, heel, ground):
    """Return the heels' horizontal path on the ground, (n_frames, 2, 2)."""
    steps = 0.5 * (ground[1:] + ground[:-1]) * np.diff(time)[:, None]
    way = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])[: len(time)]
    return fill_gaps(time, heel[..., :2], longest=0.1) - way[:, None, :2]


def _at(time, floor, instant, side):
    """Return the position of the heel on the ground at its rest after an instant."""
    # The heel still slides a few centimetres at heel strike; its slowest instant counts.
    near = (time >= instant) & (time <= instant + 0.2)
    if not near.any():
        return np.full(2, np.nan)
    path = floor[near, side]
    if len(path) < 5 or not np.isfinite(path).all():
        known = path[np.isfinite(path).all(axis=1)]
        return known[-1] if len(known) else np.full(2, np.nan)
    speed = np.linalg.norm(derivative(time[near], path), axis=1)
    return path[int(np.argmin(speed))]
