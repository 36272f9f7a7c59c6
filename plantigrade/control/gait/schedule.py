"""Stances of the feet in a motion, and the share of the load that each carries."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.control.gait.divergent import offset_weights
from plantigrade.control.gait.swing import SwingOffsetSettings
from plantigrade.motion.filters import runs
from plantigrade.wbc.forces import ForceSettings

N_TIME_CONSTANTS = 13.0  # of the pendulum, after which offsets of feet weigh a millionth


@dataclass(frozen=True, kw_only=True)
class StanceSettings:
    """When contact spheres carry load."""

    lead_time: float = 0.010
    """Time before its load at which a sphere is in contact [s]. Chosen (±20 %: 0.8 s)."""
    min_duration: float = SwingOffsetSettings.min_arrival_time
    """Least duration of a stance and of a swing [s]; that in which a foot arrives."""


@dataclass(frozen=True, eq=False)
class StanceSchedule:
    """Stances of a motion, with their weights at every instant.

    A periodic motion is looked up in its second period, so that there are stances before it and
    after; stances of later periods have higher numbers.
    """

    stances: tuple[ContactInterval, ...]  #: Stances of feet and seat, in order of their start
    alpha: Float[Array, "n k"]  #: Share of the load of each of them, at every time of a grid
    beta: Float[Array, "n k"]  #: Weight of its offset in the divergent component, likewise
    step: float  #: Time step of the grid [s]
    period: float | None  #: Period of the motion [s], or None
    per_period: int  #: Number of stances in a period
    first: float  #: Time of the first row on the clock of the stances [s]

    def cycle(self, phase: float) -> tuple[int, float]:
        """Return the number of the period, and the phase in it."""
        if self.period is None:
            return 0, phase
        cycle = int(np.floor(phase / self.period))
        return cycle, phase - cycle * self.period

    def number(self, column: int, cycle: int) -> int:
        """Return the running number of the stance of a column."""
        return column + cycle * self.per_period

    def weights(self, phase: float) -> tuple[int, Float[Array, " k"], Float[Array, " k"]]:
        """Return the number of the first column, and alpha and beta of all."""
        cycle, phase = self.cycle(phase)
        i = min(max(round(phase / self.step), 0), len(self.alpha) - 1)
        return self.number(0, cycle), self.alpha[i], self.beta[i]

    def standing(self, side: str, phase: float) -> int | None:
        """Return the number of the stance a foot is in, if it is."""
        cycle, phase = self.cycle(phase)
        time = phase + self.first
        for j, s in enumerate(self.stances):
            if s.side == side and s.start <= time < s.stop:
                return self.number(j, cycle)
        return None

    def after(self, side: str, phase: float) -> tuple[int, float] | None:
        """Return number and time of the next stance of a foot that begins at a phase or later."""
        cycle, within = self.cycle(phase)
        time = within + self.first
        for j, s in enumerate(self.stances):
            if s.side == side and s.start >= time - 1e-9:
                return self.number(j, cycle), phase + s.start - time
        return None

    def near(self, side: str, phase: float, within: float) -> float | None:
        """Return the phase nearest to a phase at which a side is in stance.

        Args:
            within: How far it may be [s].

        Returns:
            The phase; None if there is none as near as that, in this period.
        """
        _, now = self.cycle(phase)
        spans = [(s.start, s.stop) for s in self.stances if s.side == side]
        found = [min(max(now + self.first, a), b) - self.first - now for a, b in spans]
        shift = min(found, key=abs, default=np.inf)
        return phase + shift if abs(shift) <= within else None

    def stop(self, number: int, phase: float) -> float:
        """Return when a stance ends, by its number, on the clock of the phase [s]."""
        own, shift = self._found(number, phase)
        return own.stop + shift

    def stance(self, number: int, phase: float) -> ContactInterval:
        """Return a stance by its number, on the clock of the phase."""
        own, shift = self._found(number, phase)
        return own.later(shift)

    def _found(self, number: int, phase: float) -> tuple[ContactInterval, float]:
        """Return a stance of this period, and how much later the one of a number is [s]."""
        cycle, within = self.cycle(phase)
        column = number - cycle * self.per_period
        back = 0
        while column < 0:
            column, back = column + self.per_period, back + 1
        own = self.stances[min(column, len(self.stances) - 1)]
        shift = phase - within - self.first - back * (self.period or 0.0)
        return own, shift


def carrying(
    load: Float[Array, "n k"],
    weight: float,
    step: float,
    *,
    periodic: bool,
    settings: StanceSettings | None = None,
) -> Bool[Array, "n k"]:
    """Return when each sphere is in contact: while it carries load, and a little before.

    Args:
        load: Load of the spheres [N].
        weight: Weight of the person [N].
        step: Time step of the grid [s].
        periodic: Whether the last row is the first of the next period.
        settings: Lead time. The least load is that of a foot, evenly on all spheres.
    """
    settings = settings or StanceSettings()
    on = load > ForceSettings.min_foot_load * weight / load.shape[1]
    rows = on[:-1] if periodic else on
    early = rows.copy()
    for i in range(1, round(settings.lead_time / step) + 1):
        if periodic:
            early |= np.roll(rows, -i, axis=0)
        else:
            early[:-i] |= rows[i:]
    return np.concatenate([early, early[:1]]) if periodic else early


def contact_intervals(
    sites, on: Bool[Array, "n k"], step: float, period: float | None, min_duration: float
) -> tuple[ContactInterval, ...]:
    """Return the stances of feet and seat, by start.

    Those of a periodic motion begin in the period. In other motions a stance at the start has no
    beginning, and one at the end no end.

    Args:
        on: When each of them is in contact.
        step: Time step of the grid [s].
        period: Period of the motion [s], or None.
        min_duration: Least duration of a stance and of a swing [s].
    """
    found = []
    shortest, periodic = round(min_duration / step), period is not None
    for side in (*SIDES, ""):
        mine, region = [s.side == side for s in sites], "foot" if side else ""
        if not any(mine):
            continue
        stands = settled(np.asarray(on[:, mine].any(axis=1)), shortest)
        if stands.all():
            found.append(ContactInterval(side, region, -np.inf, np.inf))
            continue
        before = np.roll(stands[:-1], 1) if periodic else np.append(False, stands[:-1])
        rows = stands[:-1] if periodic else stands
        starts = [float(i * step) for i in np.flatnonzero(rows & ~before)]
        stops = [float(i * step) for i in np.flatnonzero(~rows & before)]
        if periodic:
            assert period is not None
            for start in starts:
                stop = next((t for t in stops if t > start), stops[0] + period)
                found.append(ContactInterval(side, region, start, stop))
            continue
        if stands[0]:
            starts[0] = -np.inf
        if stands[-1]:
            stops.append(np.inf)
        found += [ContactInterval(side, region, a, b) for a, b in zip(starts, stops, strict=True)]
    return tuple(sorted(found, key=lambda s: s.start))


def settled(stands: Bool[Array, " n"], shortest: int) -> Bool[Array, " n"]:
    """Return stances without those, and without gaps, of fewer rows than the shortest."""
    out = stands.copy()
    for value in (False, True):
        for run in runs(out == value):
            if run.stop - run.start < shortest and run.start > 0 and run.stop < len(out):
                out[run] = not value
    return out


def schedule_of(
    stances: tuple[ContactInterval, ...],
    sites,
    load: Float[Array, "n k"],
    omega: float,
    step: float,
    period: float | None,
) -> StanceSchedule:
    """Return the schedule: of a periodic motion over several periods, of which one is used.

    Args:
        stances: Stances of the motion, or of one period.
        load: Load of each of them [N].
        omega: Rate of the pendulum [1/s].
        step: Time step of the grid [s].
        period: Period of the motion [s], or None.
    """
    n, horizon = len(load), N_TIME_CONSTANTS / omega
    whole = n - 1 if period is not None else n
    if period is not None:
        tiles = 2 + int(np.ceil(horizon / period))
        rows = np.concatenate([np.arange(whole)] * tiles)
        first = whole
    else:
        rows = np.concatenate([np.arange(n), np.full(int(horizon / step), n - 1)])
        tiles, first = 1, 0
    per_foot = {
        side: load[rows][:, [s.side == side for s in sites]].sum(axis=1) for side in (*SIDES, "")
    }
    time = step * np.arange(len(rows))
    if period is not None:
        time = np.concatenate([step * np.arange(whole) + t * period for t in range(tiles)])
    found: list[ContactInterval] = []
    for t in range(tiles):
        found += [s.later(t * (period or 0.0)) for s in stances]
    found.sort(key=lambda s: s.start)
    alpha = np.zeros((len(rows), len(found)))
    for j, stance in enumerate(found):
        during = (time >= stance.start - 1e-9) & (time <= stance.stop + 1e-9)
        alpha[during, j] = per_foot[stance.side][during]
    total = alpha.sum(axis=1, keepdims=True)
    alpha = np.divide(alpha, total, out=np.zeros_like(alpha), where=total > 1.0)
    beta = offset_weights(alpha, omega, step)
    return StanceSchedule(
        tuple(found),
        alpha[first : first + n],
        beta[first : first + n],
        step,
        period,
        len(stances),
        first * step if period is None else period,
    )
