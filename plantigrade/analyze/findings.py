"""The worst value of each quantity, and findings, from values over time and locations."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.analyze.quantities import OF_JOINTS, quantity
from plantigrade.analyze.verdict import Finding, Measure, Slip
from plantigrade.motion import filters

_MERGE_GAP = 0.1  # [s] gap below which two violations are one finding


@dataclass(frozen=True, eq=False)
class LocatedSeries:
    """One quantity over time and locations."""

    quantity: str  #: Name of the quantity
    values: np.ndarray  #: Its values (n, m); -inf or NaN where there is none
    limit: float  #: The limit, tolerance included
    names: Sequence[str] = ("",)  #: Names of the columns
    sides: Sequence[str] = ()  #: Sides of the columns; none if empty
    #: Times of the rows [s]; those of the frames if None; NaN for a mean over the motion
    times: np.ndarray | None = None
    shown: float | None = (
        None  #: The limit that is reported, without the tolerance; ``limit`` if None
    )
    #: Values, limits and unit that findings report instead of these
    actual: tuple[np.ndarray, np.ndarray, str] | None = None
    worst_only: bool = False  #: Whether findings name the worst column only
    #: Quantities whose findings are the same fault; with one of them, none is added
    unless: tuple[str, ...] = ()
    advice: str = ""  #: Advice; that of the quantity if empty


@dataclass(eq=False)
class FindingCollector:
    """Collects measures and findings."""

    time: np.ndarray  #: Time of each frame [s]
    measures: dict[str, Measure] = field(default_factory=dict)  #: The worst value of each quantity
    findings: list[Finding] = field(default_factory=list)  #: Faults

    def add(self, series: LocatedSeries) -> None:
        """Add the measure of a quantity, and a finding for every violation of its limit."""
        t = self.time if series.times is None else series.times
        values = np.where(np.isfinite(series.values), series.values, -np.inf)
        names, sides = series.names, series.sides or ("",) * len(series.names)
        unit, limit = quantity(series.quantity).unit, series.limit
        shown = limit if series.shown is None else series.shown
        if values.size == 0 or not np.isfinite(values).any():
            self.measures[series.quantity] = Measure(series.quantity, np.nan, shown, unit)
            return
        row, column = divmod(int(np.argmax(values)), values.shape[1])
        worst = float(values[row, column])
        reported = {finding.quantity for finding in self.findings}
        report = worst > limit and reported.isdisjoint(series.unless)
        self.measures[series.quantity] = Measure(
            series.quantity, worst, shown, unit, float(t[row]), names[column], sides[column], report
        )
        if not report:
            return
        for group in _groups(series, names, sides):
            part = values[:, group]
            for start, stop in runs(np.any(part > limit, axis=1), t):
                inside = part[start:stop]
                row, column = divmod(int(np.argmax(inside)), inside.shape[1])
                bad = [names[int(group[j])] for j in np.flatnonzero((inside > limit).any(axis=0))]
                row, column = start + row, int(group[column])
                name, value, most = names[column], float(values[row, column]), shown
                excess, of = value / max(shown, 1e-9), unit
                if series.actual is not None:
                    value, most = (float(x[row, column]) for x in series.actual[:2])
                    excess, of = value / max(most, 1e-9), series.actual[2]
                mean = np.isnan(t[row])
                since, until = (self.time[0], self.time[-1]) if mean else (t[start], t[stop - 1])
                where = (float(t[row]), name, sides[column], True)
                others = tuple(each for each in bad if each != name)
                found = Measure(series.quantity, value, most, of, *where)
                self._report(found, since, until, others, excess, series.advice)

    def add_slips(self, slips: Sequence[Slip], limit: float) -> None:
        """Add the measure of the slips, and one finding per stance of a foot."""
        if not slips:
            self.measures["slip"] = Measure("slip", np.nan, limit, quantity("slip").unit)
            return
        worst = max(slips, key=lambda s: s.distance)
        self.measures["slip"] = _slip(worst, limit)
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
            self._report(_slip(w, limit), w.since, w.until, others, w.distance / limit)

    def _report(
        self,
        worst: Measure,
        start: float,
        end: float,
        others: tuple[str, ...],
        excess: float,
        advice: str = "",
    ) -> None:
        more: dict[str, Any] = {"start": float(start), "end": float(end), "advice": advice}
        self.findings.append(Finding(**vars(worst), **more, others=others, excess=excess))


def _slip(slip: Slip, limit: float) -> Measure:
    """Return the measure of one stance."""
    where = (slip.time, slip.site, slip.side, slip.distance > limit)
    return Measure("slip", slip.distance, limit, quantity("slip").unit, *where)


def _key(name: str, side: str) -> str:
    """Return the key of columns that are reported together: a foot, or a site on none."""
    return side or name


def _groups(series: LocatedSeries, names: Sequence[str], sides: Sequence[str]) -> list[np.ndarray]:
    """Return the columns that are reported together."""
    if series.worst_only:
        return [np.arange(len(names))]
    if series.quantity in OF_JOINTS:
        keys = list(names)
    else:
        keys = [_key(n, s) for n, s in zip(names, sides, strict=True)]
    return [np.flatnonzero([k == key for k in keys]) for key in dict.fromkeys(keys)]


def runs(mask: np.ndarray, times: np.ndarray | None = None) -> list[tuple[int, int]]:
    """Return (start, stop) of every run of true values; with ``times``, close ones are merged."""
    found: list[tuple[int, int]] = []
    for run in filters.runs(mask):
        start = run.start
        if times is not None and found and times[start] - times[found[-1][1] - 1] <= _MERGE_GAP:
            start = found.pop()[0]
        found.append((start, run.stop))
    return found
