"""``study.html``: statistics of several reproduced gaits, compared with the paper's table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote

import numpy as np

from plantigrade.analyze.gait_study import FIGURES, MIN_GAITS, Study
from plantigrade.analyze.reproduction import ROTATIONS, Comparison
from plantigrade.charts import Figure
from plantigrade.charts.labels import axis_label
from plantigrade.charts.theme import STROKES
from plantigrade.pages.section import Section, page_html
from plantigrade.pages.sections.recorded import pair_plot
from plantigrade.pages.shown import shown_in
from plantigrade.pages.text import rounded_text, sided_title, signed_text
from plantigrade.side_names import side_of, without_side

_TESTS = {"t": "Student", "wilcoxon": "Wilcoxon", "": ""}
TABLE = "Table I: ranges of motion"
FIRST_FIGURE = 4  # number of the paper's first figure of curves


@dataclass(frozen=True)
class StudyGait:
    """One gait of a study, with metrics and folder of its run, relative to the study.

    ``problem`` is the reason why it is excluded from the statistics; empty if it is not.
    """

    name: str
    problem: str
    metrics: Mapping[str, Any] = field(repr=False)
    comparison: Comparison = field(repr=False)
    folder: str = ""


def study_html(
    study: Study | None,
    gaits: Sequence[StudyGait],
    left_out: Mapping[str, str],
    *,
    tasks: str,
    status: str = "ok",
    provenance: Mapping[str, Any] | None = None,
) -> str:
    """Return the page of a study.

    Args:
        study: The statistics; None if no gait counts.
        left_out: Recording → reason why it could not be reproduced.
        status: ``"ok"``, or the failures.
    """
    n = 0 if study is None else study.n
    uncounted = [(gait.name, gait.problem) for gait in gaits if gait.problem]
    sentence = (
        f"{len(gaits)} recorded gait{'s' if len(gaits) != 1 else ''} reproduced by the ordered "
        f"tasks “{tasks}”; {n} of them valid over a complete gait cycle and in the statistics."
    )
    sections = [
        *([table_section(study)] if study is not None else []),
        gait_section(gaits),
        *(curve_sections(study) if study is not None else []),
        *([rotation_section([g for g in gaits if not g.problem])] if study is not None else []),
    ]
    return page_html(
        sections,
        provenance=provenance or {},
        title="Reproduced gaits",
        sentence=sentence,
        status=status,
        facts=_facts(study),
        left_out=[*uncounted, *left_out.items()],
        footer="Angles in degrees; coordinates and signs are OpenSim's.",
    )


def table_section(study: Study) -> Section:
    """Return Table I with the paper's columns."""
    tested, several = any(r.p is not None for r in study.rows), study.n > 1
    rows = []
    for r in study.rows:
        low, high = r.interval
        row = [sided_title(r.coordinate)]
        row += [_pm(r.simulated, r.simulated_sd), _pm(r.reference, r.reference_sd)]
        row += [signed_text(r.difference) + (" ‡" if r.identical else "")]
        if several:
            row += [f"{signed_text(low)} to {signed_text(high)}"]
        if tested:
            row += ["–" if r.p is None else f"{r.p:.3f} ({_TESTS[r.test]})"]
        row += [f"{r.rmse:.1f}", rounded_text(r.correlation)]
        row += [str(r.paper.simulated), str(r.paper.reference)]
        row += [signed_text(-r.paper.difference, 0) + (" ‡" if r.paper.identical else "")]
        rows.append(row)
    text = "Ranges of motion in degrees of one gait; the difference is reproduced minus recorded."
    if several:
        text = (
            f"Ranges of motion in degrees over {study.n} gaits, mean ± standard deviation; the "
            "mean difference (reproduced minus recorded) with its 95 % confidence interval."
        )
    if tested:
        text += (
            " A paired Student test where Shapiro and Wilk's test does not reject normality, else "
            "Wilcoxon's, both at 5 %. ‡: no significant difference, the paper's “significantly "
            "identical”; it does not prove equality; the interval shows what is excluded. The test "
            "assumes independent gaits: give one recording per person."
        )
    else:
        text += (
            f" There is no test: it needs {MIN_GAITS} gaits with different differences. "
            "‡ marks what the paper calls “significantly identical”."
        )
    text += " The last columns are the paper's (Boukheddimi et al., nine people)."
    return Section(
        TABLE,
        text=text,
        headers=(
            "rotation", "reproduced", "recorded", "difference",
            *(["95 % interval"] if several else []), *(["p"] if tested else []), "RMSE", "r",
            "paper: simulated", "paper: recorded", "paper: difference",
        ),
        rows=rows,
    )  # fmt: skip


def curve_sections(study: Study) -> list[Section]:
    """Return the paper's Figs. 4 to 7, and the other rotations."""
    figures = [
        Figure(_curves(study, name, f"Fig. {k}: {title}", 520, 280))
        for k, (name, title) in enumerate(FIGURES.items(), start=FIRST_FIGURE)
    ]
    others = [
        Figure(_curves(study, name, sided_title(name)))
        for _, name in ROTATIONS
        if name not in FIGURES
    ]
    text = (
        "Mean over the gaits and, as a band, one standard deviation. Full line: reproduced; violet "
        "dashes: recorded. Each gait counts once, with the mean of its cycles."
    )
    return [
        Section("Figures 4 to 7: angles over the gait cycle", figures, text=text),
        Section("The other rotations", others, text="Plotted as above.", folded=True),
    ]


def _curves(study: Study, name: str, title: str, width: int = 330, height: int = 210) -> str:
    ours = np.array([c.curves_simulated[name].mean(axis=0) for c in study.comparisons])
    theirs = np.array([c.curves_reference[name].mean(axis=0) for c in study.comparisons])
    row = next(r for r in study.rows if r.coordinate == name)
    return pair_plot(
        study.percent,
        ours,
        theirs,
        title=title,
        colour=STROKES[side_of(name)],
        y_label=axis_label(without_side(name), "°"),
        note=f"RMSE {row.rmse:.1f}°, r {rounded_text(row.correlation)}",
        width=width,
        height=height,
    )


def gait_section(gaits: Sequence[StudyGait]) -> Section:
    """Return a table with one row of figures per gait and links to its pages."""
    from markupsafe import Markup

    columns = [
        c for c in shown_in("study") if any(gait.metrics.get(c.key) is not None for gait in gaits)
    ]
    rows = []
    for gait in gaits:
        folder = quote(gait.folder, errors="surrogateescape")
        link = Markup('<a href="{0}/report.html">{1}</a>').format(folder, gait.name)
        shown = [rounded_text(gait.metrics.get(c.key), c.digits) for c in columns]
        clearance = [
            " / ".join(rounded_text(1e3 * height, 0) for height in gait.comparison.clearance[side])
            for side in ("r", "l")
        ]
        viewer = Markup('<a href="{0}/viewer.html">viewer</a>').format(folder)
        state = "" if not gait.problem else "not counted"
        rows.append([link, state, *shown, *clearance, viewer])
    text = (
        "One line per recording. Toe clearance: minimum height of forefoot and toes in "
        "midswing, reproduced / recorded; no task tracks it."
    )
    return Section(
        "Individual gaits",
        text=text,
        headers=(
            "gait", "", *(c.label for c in columns),
            "toe clearance right [mm]", "left [mm]", "",
        ),
        rows=rows,
    )  # fmt: skip


def rotation_section(gaits: Sequence[StudyGait]) -> Section:
    """Return the difference of every range of motion of every gait."""
    rows = []
    for gait in gaits:
        errors = gait.comparison.rom_error
        cells = (signed_text(errors[n]) if n in errors else "–" for _, n in ROTATIONS)
        rows.append([gait.name, *cells])
    return Section(
        "Ranges of motion of individual gaits",
        text="Reproduced minus recorded range of motion [°], for the gaits in the statistics.",
        headers=("gait", *(sided_title(name) for _, name in ROTATIONS)),
        rows=rows,
        folded=True,
    )


def _facts(study: Study | None) -> dict[str, str]:
    if study is None:
        return {}
    errors = [abs(row.difference) for row in study.rows]
    worst = 1e3 * max(c.com_error_max_m for c in study.comparisons)
    tested = [row.identical for row in study.rows if row.identical is not None]
    words = f"{sum(tested)} of {len(tested)}"
    return {
        "gaits": str(study.n),
        "range of motion error, mean": f"{np.mean(errors):.1f}°",
        "range of motion error, maximum": f"{np.max(errors):.1f}°",
        "RMSE, mean": f"{np.mean([row.rmse for row in study.rows]):.1f}°",
        **({"without significant difference": words} if tested else {}),
        "centre of mass error, maximum": f"{worst:.1f} mm",
    }


def _pm(mean: float, sd: float) -> str:
    return f"{mean:.1f} ± {sd:.1f}" if np.isfinite(sd) else f"{mean:.1f}"
