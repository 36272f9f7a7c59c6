"""Figures of many experiments in one file, and what differs between two such files."""

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import plantigrade
from experiments.table import ResultTable, sheet
from plantigrade.errors import FileError
from plantigrade.io.text import read_text
from plantigrade.record.folder import metrics_json

FILE = "figures.json"
# How the names of computing times end: these differ from run to run. What else ends so is named.
TIMES = (
    "_time_s",
    "_time_per_cycle_s",
    "_time_median_s",
    "_time_most_s",
    "_read_fit_and_analyse_s",
    "_ms_per_frame",
    "_program_median_ms",
    "_tick_median_ms",
)
NO_TIMES = ("flight_time_s",)

Figures = dict[str, Any]


def is_time(key: str) -> bool:
    """Whether a figure is a computing time.

    Example:
        >>> is_time("walk_default_tasks_time_per_cycle_s"), is_time("stride_time_l_s")
        (True, False)
    """
    return f"_{key}".endswith(TIMES) and not key.endswith(NO_TIMES)


def figures_of(table: ResultTable) -> Figures:
    """Return what is kept of a table: its status, its figures, and which goals are met.

    A figure that could not be measured is the reason in words.
    """
    figures = table.metrics()
    status = figures.pop("status")
    del figures["goals"], figures["goals_met"]  # they are counted with those on times
    figures |= {row.key: row.note for row in table.rows if row.value is None}
    goals = {row.key: row.met for row in table.rows if row.met is not None}
    return {"status": status, "figures": figures, "goals": goals}


def measure(
    runs: Mapping[str, Callable[[], Figures]],
    path: Path,
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Figures:
    """Run one after the other and write what they return to a file, after each of them.

    Each returns a status, ``figures`` and ``goals``. A run that fails is kept with its error as
    status; the others go on. ``quick`` stands in the file.
    """
    found: Figures = {"version": plantigrade.__version__, "quick": quick, "time_s": 0.0}
    found["experiments"] = {}
    path.parent.mkdir(parents=True, exist_ok=True)
    for name, run in runs.items():
        say(f"{name} …")
        started = time.perf_counter()
        try:
            result = run()
        except Exception as error:  # whatever it is: the others are still of use
            words = " ".join(f"{error}".split())
            result = {"status": f"{type(error).__name__}: {words}", "figures": {}, "goals": {}}
        seconds = time.perf_counter() - started
        status = result["status"]
        say(f"{name}: {status}, {len(result['figures'])} figures in {seconds:.1f} s")
        found["experiments"][name] = {"status": status, "time_s": seconds} | result
        found["time_s"] += seconds
        path.write_text(metrics_json(found) + "\n", encoding="utf-8")
    return found


def measured_table(found: Figures) -> str:
    """Return one line for each experiment: status, figures, goals and time."""
    lines = []
    for name, e in found["experiments"].items():
        goals = f"{sum(map(bool, e['goals'].values()))} of {len(e['goals'])}"
        lines.append([name, f"{len(e['figures'])}", goals, f"{e['time_s']:.1f}", e["status"]])
    lines.append(["together", "", "", f"{found['time_s']:.1f}", ""])
    return sheet("Experiments", ("", "figures", "goals met", "s", "status"), lines)


def read_figures(path: Path) -> Figures:
    """Return what :func:`measure` wrote.

    Raises:
        FileError: If the file cannot be read or holds something else.
    """
    remedy = "make one with `plantigrade experiment --all`"
    text = read_text(path)
    try:
        found = json.loads(text, parse_int=float)
        for each in found["experiments"].values():
            if not (isinstance(each["figures"], dict) and isinstance(each["goals"], dict)):
                raise TypeError("figures and goals have names")
            str(each["status"])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise FileError(path, "holds no figures of experiments", remedy=remedy) from error
    return found


@dataclass(frozen=True)
class Change:
    """A figure of an experiment that differs; None where there is none."""

    name: str
    before: Any
    after: Any

    @property
    def relative(self) -> float:
        """The change of a number as a part of it; infinite where this says nothing."""
        if not (_is_number(self.before) and _is_number(self.after) and self.before):
            return math.inf
        return (self.after - self.before) / abs(self.before)


@dataclass
class Comparison:
    """What differs between two files of figures.

    Attributes:
        identical: How many figures are the same to the last digit.
        changed: Figures with another value, the greatest relative change first.
        gone: Figures that are in the first file only.
        new: Figures that are in the second file only.
        lost: Goals that were met and are not any more.
        won: Goals that are met now and were not.
        statuses: Experiments that end in another way, or are in one file only.
        times: Computing times that differ; goals on them are neither lost nor won.
    """

    identical: int = 0
    changed: list[Change] = field(default_factory=list)
    gone: list[Change] = field(default_factory=list)
    new: list[Change] = field(default_factory=list)
    lost: list[Change] = field(default_factory=list)
    won: list[Change] = field(default_factory=list)
    statuses: list[Change] = field(default_factory=list)
    times: list[Change] = field(default_factory=list)

    @property
    def status(self) -> str:
        """``"ok"``, or which goals are lost and which experiments fail that did not."""
        faults = [f"{c.name}: goal lost" for c in self.lost]
        faults += [f"{c.name}: {c.after or 'left out'}" for c in self.statuses if c.after != "ok"]
        return "; ".join(faults) or "ok"

    def metrics(self) -> dict[str, Any]:
        """Return how many there are of each kind, and the status."""
        return {
            "status": self.status,
            "figures_identical": self.identical,
            "figures_changed": len(self.changed),
            "figures_gone": len(self.gone),
            "figures_new": len(self.new),
            "goals_lost": len(self.lost),
            "goals_won": len(self.won),
            "statuses_changed": len(self.statuses),
            "times_changed": len(self.times),
        }

    def text(self) -> str:
        """Return the differences for a reader."""
        kinds = {
            "How experiments ended": self.statuses,
            "Goals lost": self.lost,
            "Goals won": self.won,
            "Changed": self.changed,
            "Gone": self.gone,
            "New": self.new,
            "Computing times (they differ from run to run)": self.times,
        }
        header = ("", "before", "after", "change")
        parts = [sheet(title, header, map(_line, c)) for title, c in kinds.items() if c]
        parts.append(
            f"{self.identical} figures identical, {len(self.changed)} changed, "
            f"{len(self.gone)} gone, {len(self.new)} new; {len(self.lost)} goals lost, "
            f"{len(self.won)} won"
        )
        return "\n\n".join(parts)


def compare(before: Figures, after: Figures) -> Comparison:
    """Return what differs between two results of :func:`measure`."""
    found = Comparison()
    for name, first, second in _pairs(before["experiments"], after["experiments"]):
        first, second = first or {}, second or {}
        if first.get("status") != second.get("status"):
            found.statuses.append(Change(name, first.get("status"), second.get("status")))
        there = first.get("figures", {}), second.get("figures", {})
        for key, x, y in _pairs(first.get("goals", {}), second.get("goals", {})):
            if not is_time(key) and bool(x) != bool(y) and None not in (x, y):
                change = Change(f"{name} {key}", there[0].get(key), there[1].get(key))
                (found.won if y else found.lost).append(change)
        for key, x, y in _pairs(*there):
            change = Change(f"{name} {key}", x, y)
            if key not in there[1]:
                found.gone.append(change)
            elif key not in there[0]:
                found.new.append(change)
            elif x == y:
                found.identical += 1
            else:
                (found.times if is_time(key) else found.changed).append(change)
    found.changed.sort(key=lambda c: -abs(c.relative))
    return found


def _pairs(first: Mapping, second: Mapping) -> Iterator[tuple[str, Any, Any]]:
    """Yield every key of both with its two values, None where one has none."""
    for key in {**first, **second}:
        yield key, first.get(key), second.get(key)


def _line(change: Change) -> list[str]:
    relative = f"{100 * change.relative:+.2g} %" if math.isfinite(change.relative) else ""
    return [change.name, _shown(change.before), _shown(change.after), relative]


def _shown(value: Any) -> str:
    return "-" if value is None else f"{value:.6g}" if _is_number(value) else str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
