"""``batch.html``: distributions, outliers, failures, curves and a table of many items."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from textwrap import shorten
from typing import Any, Protocol, runtime_checkable
from urllib.parse import quote

import numpy as np

from plantigrade.analyze.curves import LOADED_JOINTS
from plantigrade.analyze.gait_profile import ANGLES, MIN_IMPORTANT_DIFFERENCE
from plantigrade.arrays import Array
from plantigrade.charts import Figure, Ribbon, Series, histogram_plot, line_plot
from plantigrade.charts.labels import MIN_SPANS, UNITS, axis_label, title_of
from plantigrade.charts.theme import STROKES
from plantigrade.motion.cycles import PERCENT
from plantigrade.notes import Repeated, repeated
from plantigrade.options import is_real
from plantigrade.pages.section import Section, page_html
from plantigrade.pages.shown import shown_in
from plantigrade.pages.text import rounded_text
from plantigrade.record.batch import BatchFolder, Row
from plantigrade.side_names import side_of, without_side

PAGE = "batch.html"
MAX_TABLE_ROWS = 1_000
"""Maximum number of rows of the table, because browsers become slow; the table file has all
items."""
MAX_LISTED = 100  # Maximum number of listed outliers and of listed failures
MAX_STATUS_LETTERS = 60  # Maximum length of a status in the table; failures are listed in full
MAX_NAMES = 3  # Names of items that are listed with a warning; chosen
MIN_DISTRIBUTION = 5  # Minimum number of values for a distribution
OUTLIER_ROBUST_SD = 3.5
"""Distance from the median in robust standard deviations above which a value is an outlier
([Iglewicz1993]_)."""
MAD_TO_SD = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


@runtime_checkable
class Ended(Protocol):
    """Result of an item, as needed for the counts."""

    @property
    def status(self) -> str:
        """``"ok"``, the failure of the result, or the reason why there is none."""
        ...

    @property
    def problem(self) -> str:
        """Reason why there is no result; empty if there is one."""
        ...

    @property
    def left_out(self) -> bool:
        """Whether it was found in a folder but has no usable content."""
        ...

    @property
    def figures(self) -> Mapping[str, Any]:
        """All figures."""
        ...


@dataclass(frozen=True)
class BatchKind:
    """Texts and columns of a kind of batch."""

    title: str  #: Heading of the page
    noun: str  #: Noun for an item
    done: str  #: Participle for its processing
    table: str  #: Name of the table of its figures, also of the distributions and the outliers
    note: str = ""  #: Explanation of the figures

    @property
    def columns(self) -> list[tuple[str, list[str], int]]:
        """Heading, figures (one, or right and left) and decimals of each column."""
        return [(one.label, one.key.split(), one.digits) for one in shown_in(self.table)]

    def fails(self, one: Ended) -> bool:
        """Return whether an item counts as failed."""
        return one.status != "ok"

    def words(self, one: Ended) -> str:
        """Return a short description of the outcome of an item."""
        return one.status

    def counts(self, ended: Iterable[Ended]) -> dict[str, Any]:
        """Return status and counts of a batch."""
        count = failed = without = left_out = 0
        for one in ended:
            if one.left_out:
                left_out += 1
                continue
            count += 1
            failed += self.fails(one)
            without += bool(one.problem)
        status = f"{failed} of {count} {self.noun}s failed" if failed else "ok"
        if not count:
            status = f"no {self.noun} could be {self.done}"
        return {
            "status": status,
            f"{self.noun}s_count": count,
            "failed_count": failed,
            "without_result_count": without,
            "left_out_count": left_out,
        }

    def sentence(self, counts: Mapping[str, Any]) -> str:
        """Return a sentence with the number of successful items."""
        count = counts[f"{self.noun}s_count"]
        return f"{count - counts['without_result_count']} of {count} {self.noun}s {self.done}."

    def counted(self, warning: Repeated, counts: Mapping[str, Any]) -> str:
        """Return a warning with the number of items that have it."""
        count = counts[f"{self.noun}s_count"]
        names = ", ".join(warning.names[:MAX_NAMES]) + " …" * (len(warning.names) > MAX_NAMES)
        return f"{len(warning.names)} of {count} {self.noun}s ({names}): {warning.sentence}"

    def sections(self, rows: Sequence[Row]) -> list[Section]:
        """Return further sections, before all others."""
        return []


FITS = BatchKind(
    title="Fitted recordings",
    noun="recording",
    done="fitted",
    table="fits",
    note=(
        "Error: RMS of the markers, mean over frames, or of the joint centres of a skeleton. "
        "Symmetry index: of step length (Robinson et al. 1987). GPS: Gait Profile Score; "
        f"{MIN_IMPORTANT_DIFFERENCE}° are clinically important (Baker et al. 2009, 2012). Mean and "
        "SD are over recordings: give one per person."
    ),
)
MOTIONS = BatchKind(title="Synthesised motions", noun="motion", done="synthesised", table="motions")
REPRODUCED = BatchKind(
    title="Reproduced gaits", noun="recording", done="reproduced", table="reproduced gaits"
)


class _Simulations(BatchKind):
    """Batch of simulations, in which a fall is a result but divergence is a failure."""

    def fails(self, one: Ended) -> bool:
        """Return whether a simulation failed or diverged."""
        return bool(one.problem) or one.figures.get("diverged_at_s") is not None

    def words(self, one: Ended) -> str:
        """Return the outcome of a simulation."""
        return "on the feet" if one.status == "ok" else one.status

    def counts(self, ended: Iterable[Ended]) -> dict[str, Any]:
        """Return status and counts, with the number of simulations without a fall."""
        on_feet = diverged = 0

        def counted() -> Iterator[Ended]:
            nonlocal on_feet, diverged
            for one in ended:
                on_feet += bool(one.figures.get("on_feet"))
                diverged += one.figures.get("diverged_at_s") is not None
                yield one

        found = super().counts(counted())
        status = found["status"].replace("failed", "failed or diverged")
        return {**found, "status": status, "on_feet_count": on_feet, "diverged_count": diverged}

    def sentence(self, counts: Mapping[str, Any]) -> str:
        """Return a sentence with the number of simulations without a fall."""
        return (
            f"{counts['on_feet_count']} of {counts['simulations_count']} simulations without fall."
        )

    def sections(self, rows: Sequence[Row]) -> list[Section]:
        """Return the numbers of simulations without a fall for each value of varied options."""
        lines = []
        for name in rows[0].varied if rows else ():
            values = list(dict.fromkeys(str(row.varied.get(name)) for row in rows))
            if not 1 < len(values) < len(rows):
                continue
            for value in values:
                those = [row for row in rows if str(row.varied.get(name)) == value]
                held = sum(bool(row.figures.get("on_feet")) for row in those)
                lines.append([name, value, f"{held} of {len(those)}"])
        headers = ("option", "value", "without a fall")
        return [Section("By varied option", headers=headers, rows=lines)] if lines else []


SIMULATIONS = _Simulations(
    title="Batch of simulations", noun="simulation", done="simulated", table="simulations"
)


def page_html_of(kind: BatchKind, store: BatchFolder, counts: Mapping[str, Any]) -> str:
    """Return the page of a batch."""
    keys = {key for _, keys, _ in kind.columns for key in keys} | {"on_feet"}
    rows = [  # only the figures of the page, to limit the memory of large batches
        replace(row, figures={key: row.figures[key] for key in keys if key in row.figures})
        for row in store.rows()
    ]
    failed = [(row.name, row.status) for row in rows if row.failed]
    rows = [row for row in rows if not row.left_out]
    linked = {
        row.name
        for row in rows
        if not row.failed and (store.path / row.name / "report.html").is_file()
    }
    more = len(failed) - MAX_LISTED
    if more > 0:
        failed = [*failed[:MAX_LISTED], (f"{more} more", "see the table")]
    return page_html(
        [
            *kind.sections(rows),
            *_warnings(kind, rows, linked),
            *_distributions(kind, rows),
            *_outliers(kind, rows, linked),
            *_mean_curves(store),
            _table(kind, rows, linked),
        ],
        provenance={"command": store.command, **store.spec},
        title=kind.title,
        sentence=kind.sentence(counts),
        status=str(counts["status"]),
        left_out=failed,
        key=(("right", STROKES["r"]), ("left", STROKES["l"])),
        footer=(
            "All figures of all items are in batch.csv (and batch.parquet), curves in "
            "curves.parquet or curves.csv. The same command retries failed items; failed.txt lists "
            "their files for --list."
        ),
    )


def _warnings(kind: BatchKind, rows: Sequence[Row], linked: set[str]) -> list[Section]:
    """Return every warning once, with the number of items that have it."""
    from markupsafe import Markup

    found = repeated((row.name, row.warnings) for row in rows)
    lines = []
    for each in found:
        names = Markup(", ").join(_link(name, linked) for name in each.names[:MAX_NAMES])
        more = len(each.names) - MAX_NAMES
        names += f" and {more} more" if more > 0 else ""
        lines.append([each.sentence, f"{len(each.names)} of {len(rows)}", names])
    headers = ("warning", f"{kind.noun}s", "which")
    text = "“…” is in the place of numbers that differ; the report of each item has them."
    return [Section("Warnings", headers=headers, rows=lines, text=text)] if found else []


def _distributions(kind: BatchKind, rows: Sequence[Row]) -> list[Section]:
    figures = []
    for label, values in _values(kind, rows):
        values = values[np.isfinite(values)]
        if len(values) >= MIN_DISTRIBUTION and np.ptp(values) > 0:
            name, _, unit = label.partition(" [")
            figures.append(Figure(histogram_plot(values, title=name, x_label=unit.rstrip("]"))))
    text = f"Number of {kind.noun}s by value; the line is the median."
    return [Section("Distributions", figures, text)] if figures else []


def _outliers(kind: BatchKind, rows: Sequence[Row], linked: set[str]) -> list[Section]:
    found: list[tuple[float, list[Any]]] = []
    for label, values in _values(kind, rows):
        known = values[np.isfinite(values)]
        if len(known) < MIN_DISTRIBUTION:
            continue
        middle = float(np.median(known))
        sd = MAD_TO_SD * float(np.median(np.abs(known - middle)))
        if sd <= 0:
            continue
        away = np.abs(values - middle) / sd
        for k in map(int, np.flatnonzero(away > OUTLIER_ROBUST_SD)):
            shown = [f"{values[k]:.4g}", f"{middle:.4g}", f"{away[k]:.1f}"]
            found.append((float(away[k]), [_link(rows[k].name, linked), label, *shown]))
    found.sort(key=lambda each: -each[0])
    headers = (kind.noun, "figure", "value", "median", "robust SDs away")
    text = (
        f"More than {OUTLIER_ROBUST_SD} robust standard deviations (1.4826 times the median "
        f"absolute deviation) from the median; the {min(len(found), MAX_LISTED)} farthest of "
        f"{len(found)}."
    )
    lines = [line for _, line in found[:MAX_LISTED]]
    return [Section("Outliers", headers=headers, rows=lines, text=text)] if found else []


def _values(kind: BatchKind, rows: Sequence[Row]) -> Iterator[tuple[str, Array]]:
    """Yield heading and values of every column, as the mean of right and left."""
    for label, keys, _ in kind.columns:
        values = np.full((len(rows), len(keys)), np.nan)
        for k, row in enumerate(rows):
            for i, key in enumerate(keys):
                if is_real(value := row.figures.get(key)):
                    values[k, i] = value
        known = np.isfinite(values).all(axis=1)
        yield label, np.where(known, values.mean(axis=1), np.nan)


def _mean_curves(store: BatchFolder) -> list[Section]:
    """Return mean and standard deviation over items of every curve of at least two items."""
    sums: dict[str, list[Any]] = {}
    for _, curves in store.curve_means():
        for name, curve in curves.items():
            mine = sums.setdefault(name, [0, 0.0, 0.0, curve.unit])
            mine[0], mine[1], mine[2] = (mine[0] + 1, mine[1] + curve.mean, mine[2] + curve.mean**2)
    order = [*ANGLES, *(f"{name}_moment" for name in LOADED_JOINTS)]
    order += ["ground_force_up", "ground_force_forward"]
    figures, most = [], 0
    for name in order:
        series, bands, unit = [], [], ""
        for key, (count, total, squares, of) in sums.items():
            if without_side(key) != name or count < 2:
                continue
            mean, unit, most = total / count, of, max(most, count)
            sd = np.sqrt(np.maximum(squares - count * mean**2, 0.0) / (count - 1))
            colour = STROKES[side_of(key) or ""]
            series.append(Series(PERCENT, mean, "", colour))
            bands.append(Ribbon(PERCENT, mean - sd, mean + sd, colour))
        if series:
            shown = UNITS.get(unit, unit)
            svg = line_plot(
                series,
                bands=bands,
                title=title_of(name),
                x_label="% of the gait cycle",
                y_label=axis_label(name, shown),
                least=MIN_SPANS.get(shown, 0.0),
            )
            figures.append(Figure(svg))
    text = f"Mean and standard deviation over up to {most} items, each averaged over its cycles."
    return [Section("Curves over the gait cycle", figures, text)] if figures else []


def _table(kind: BatchKind, rows: Sequence[Row], linked: set[str]) -> Section:
    columns = [c for c in kind.columns if any(key in row.figures for row in rows for key in c[1])]
    own = list(rows[0].varied) if rows else []
    lines = []
    for row in rows[:MAX_TABLE_ROWS]:
        cells = [_cell(row.figures, keys, digits) for _, keys, digits in columns]
        varied = [str(row.varied.get(name, "")) for name in own]
        status = shorten(row.status, MAX_STATUS_LETTERS, placeholder=" …")
        lines.append([_link(row.name, linked), *varied, status, *cells])
    if len(rows) > 1:
        spread = [_spread(rows, keys, digits) for _, keys, digits in columns]
        lines.append(["mean ± SD", *[""] * len(own), "", *spread])
    text = kind.note
    if len(rows) > MAX_TABLE_ROWS:
        text += f" The first {MAX_TABLE_ROWS} of {len(rows)}; all of them are in batch.csv."
    if not linked and rows:
        text += " plantigrade report FOLDER writes report and viewer of a kept run."
    headers = (kind.noun, *own, "status", *(label for label, _, _ in columns))
    return Section(f"{kind.noun.capitalize()}s", headers=headers, rows=lines, text=text.strip())


def _link(name: str, linked: set[str]) -> Any:
    if name not in linked:
        return name
    from markupsafe import Markup

    folder = quote(name, errors="surrogateescape")
    text = '<a href="{0}/report.html">{1}</a> <a href="{0}/viewer.html">viewer</a>'
    return Markup(text).format(folder, name)


def _cell(figures: Mapping[str, Any], keys: Sequence[str], digits: int) -> str:
    shown = [rounded_text(figures.get(key), digits) for key in keys]
    return "–" if set(shown) == {"–"} else " / ".join(shown)


def _spread(rows: Sequence[Row], keys: Sequence[str], digits: int) -> str:
    """Return mean and SD over items, averaged over sides."""
    found = [[row.figures.get(key) for key in keys] for row in rows]
    known = np.array([v for v in found if all(map(is_real, v))], dtype=float)
    if len(known) < 2:
        return ""
    known = known.mean(axis=1)
    return f"{rounded_text(known.mean(), digits)} ± {rounded_text(known.std(ddof=1), digits)}"
