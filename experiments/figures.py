"""Figures of all experiments in one JSON file, and the differences between two such files."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import plantigrade
from experiments.table import ResultTable, sheet
from plantigrade.errors import FileError
from plantigrade.io.text import read_text
from plantigrade.record.metrics import metrics_json

FILE = "figures.json"
TIME_SUFFIXES = (
    "_time_s", "_time_per_cycle_s", "_time_median_s", "_time_most_s", "_read_fit_and_analyse_s",
    "_ms_per_frame", "_program_median_ms", "_tick_median_ms",
)  # fmt: skip
"""Suffixes of computing times, which differ from run to run."""
MOTION_TIMES = ("flight_time_s",)
"""Figures with such a suffix that are no computing times."""

Figures = dict[str, Any]


def is_time(key: str) -> bool:
    """Return whether a figure is a computing time.

    Example:
        >>> is_time("walk_default_tasks_time_per_cycle_s"), is_time("stride_time_l_s")
        (True, False)
    """
    return f"_{key}".endswith(TIME_SUFFIXES) and not key.endswith(MOTION_TIMES)


def figures_of(table: ResultTable) -> Figures:
    """Return status, figures and goals of a table; a missing figure is replaced by the reason."""
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
    """Run one experiment after the other; write the file after each of them.

    Args:
        runs: Name → function that returns ``status``, ``figures`` and ``goals``. The status of a
            run that fails is its error.
        path: The file.
        quick: Whether these are the short forms, as the file says.
        say: Called with a line about each experiment.
    """
    found: Figures = {"version": plantigrade.__version__, "quick": quick, "time_s": 0.0}
    found["experiments"] = {}
    path.parent.mkdir(parents=True, exist_ok=True)
    for name, run in runs.items():
        say(f"{name} …")
        started = time.perf_counter()
        try:
            result = run()
        except Exception as error:  # the other experiments are run in any case
            message = " ".join(f"{error}".split())
            result = {"status": f"{type(error).__name__}: {message}", "figures": {}, "goals": {}}
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
    """Return the content of a file that :func:`measure` wrote.

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


KINDS = {
    "statuses_changed": "How experiments ended",
    "goals_lost": "Goals lost",
    "goals_won": "Goals won",
    "figures_changed": "Changed",
    "figures_gone": "Gone",
    "figures_new": "New",
    "times_changed": "Computing times (they differ from run to run)",
}
"""Kind of a difference → title of its table."""


@dataclass(frozen=True)
class Change:
    """A value of two files that differs; None where a file has none."""

    kind: str
    name: str
    before: Any
    after: Any

    @property
    def relative(self) -> float:
        """Relative change of a number; infinite where it has none."""
        if not (_is_number(self.before) and _is_number(self.after) and self.before):
            return math.inf
        return (self.after - self.before) / abs(self.before)

    def line(self) -> list[str]:
        """Return it as a line of a table."""
        relative = f"{100 * self.relative:+.2g} %" if math.isfinite(self.relative) else ""
        return [self.name, _shown(self.before), _shown(self.after), relative]


@dataclass(frozen=True)
class Comparison:
    """Differences between two files of figures.

    Attributes:
        identical: Number of figures that are the same to the last digit.
        changes: The differences, by :data:`KINDS`. Goals on computing times are left out.
    """

    identical: int
    changes: Mapping[str, list[Change]]

    @property
    def status(self) -> str:
        """``"ok"``, or the lost goals and the experiments that fail now."""
        faults = [f"{c.name}: goal lost" for c in self.changes["goals_lost"]]
        ended = (c for c in self.changes["statuses_changed"] if c.after != "ok")
        return "; ".join([*faults, *(f"{c.name}: {c.after or 'left out'}" for c in ended)]) or "ok"

    def metrics(self) -> dict[str, Any]:
        """Return the number of differences of each kind, and the status."""
        counts = {kind: len(found) for kind, found in self.changes.items()}
        return {"status": self.status, "figures_identical": self.identical, **counts}

    def text(self) -> str:
        """Return the differences for a reader."""
        header, m = ("", "before", "after", "change"), self.metrics()
        parts = [
            sheet(title, header, [change.line() for change in self.changes[kind]])
            for kind, title in KINDS.items()
            if self.changes[kind]
        ]
        parts.append(
            f"{self.identical} figures identical, {m['figures_changed']} changed, "
            f"{m['figures_gone']} gone, {m['figures_new']} new; {m['goals_lost']} goals lost, "
            f"{m['goals_won']} won"
        )
        return "\n\n".join(parts)


def compare(before: Figures, after: Figures) -> Comparison:
    """Return the differences between two results of :func:`measure`."""
    old, new = _flat(before), _flat(after)
    changes: dict[str, list[Change]] = {kind: [] for kind in KINDS}
    identical = 0
    for key in {**old, **new}:
        section, name = key
        pair = old.get(key), new.get(key)
        if key in old and pair[0] == pair[1] and key in new:
            identical += section == "figures"
            continue
        if section == "goals":
            if None in pair or is_time(name.rpartition(" ")[2]) or bool(pair[0]) == bool(pair[1]):
                continue
            kind = "goals_won" if pair[1] else "goals_lost"
            pair = old.get(("figures", name)), new.get(("figures", name))
        elif section == "statuses":
            kind = "statuses_changed"
        elif key not in new or key not in old:
            kind = "figures_gone" if key in old else "figures_new"
        else:
            kind = "times_changed" if is_time(name.rpartition(" ")[2]) else "figures_changed"
        changes[kind].append(Change(kind, name, *pair))
    changes["figures_changed"].sort(key=lambda c: -abs(c.relative))
    return Comparison(identical, changes)


def _flat(figures: Figures) -> dict[tuple[str, str], Any]:
    """Return all values by section and name."""
    found: dict[tuple[str, str], Any] = {}
    for name, each in figures["experiments"].items():
        found["statuses", name] = each["status"]
        for section in ("goals", "figures"):
            found |= {(section, f"{name} {key}"): value for key, value in each[section].items()}
    return found


def _shown(value: Any) -> str:
    return "-" if value is None else f"{value:.6g}" if _is_number(value) else str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
