"""``compare.html``: curves of several gaits, and their differences with confidence bands."""

from collections.abc import Callable, Mapping
from typing import Any

from plantigrade.analyze.clinical import norms_for, usual_walk
from plantigrade.analyze.curve_difference import MIN_CYCLES
from plantigrade.analyze.curves import LOADED_JOINTS
from plantigrade.analyze.gait_profile import MIN_IMPORTANT_DIFFERENCE
from plantigrade.analyze.norms import PUBLISHED_NAMES, Population, names, norm, unit_of
from plantigrade.analyze.pooled_gait import TRUNK, ComparedGait
from plantigrade.analyze.run_comparison import RunComparison
from plantigrade.analyze.statistics import mean_sd
from plantigrade.arrays import Array
from plantigrade.charts import Figure, Ribbon, Series, line_plot
from plantigrade.charts.labels import MIN_SPANS, UNITS, axis_label, title_of
from plantigrade.charts.theme import STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDE_NAMES
from plantigrade.motion.cycles import PERCENT
from plantigrade.motion.filters import runs
from plantigrade.pages.compare_figures import figure_section, verdict_of
from plantigrade.pages.section import Section, page_html
from plantigrade.pages.sections.clinical import NAMES, OWN_SIDE, grid_of
from plantigrade.pages.shown import shown_in
from plantigrade.pages.text import rounded_text, signed_text
from plantigrade.side_names import split_side

COLOURS = ("var(--fg, #1c2430)", "#7e57c2", "#009e73", "#cc79a7", "#b07c00", "#56b4e9")
"""Colours of the gaits in order, repeated if there are more."""
LOADS = ("ground_force_up", "ground_force_forward", *(f"{name}_moment" for name in LOADED_JOINTS))
MAX_SPEED_DIFFERENCE = 0.1
"""Difference of walking speeds above which a note is given, because angles depend on speed
[m/s]."""
HEIGHT = 182  # [px] of a plot of one angle
Draw = Callable[[RunComparison, str, int], Figure]


def compare_html(found: RunComparison, provenance: Mapping[str, Any]) -> str:
    """Return the page of a comparison."""
    gaits = found.gaits
    first, others = gaits[0].name, ", ".join(gait.name for gait in gaits[1:])
    if found.sides:
        (one, other), trials = gaits, f" of {len(found.runs)} trials" if len(found.runs) > 1 else ""
        sentence = (
            f"The {other.name} and the {one.name} side{trials} of one person; differences are "
            f"{other.name} minus {one.name}."
        )
        titles = {"": "Affected and unaffected" if found.affected else "Right and left"}
    else:
        sentence = f"{others} compared with {first}; differences are relative to {first}."
        titles = {side: f"{word.capitalize()} side" for side, word in SIDE_NAMES.items()}
    sections = [] if found.sides else [measure_section(found)]
    ends = {"": ""} if found.sides else {"r": "_r", "l": "_l"}
    for side, ending in ends.items():
        sections.append(overlay_section(found, titles[side], ending))
    for side, ending in ends.items():
        sections.append(difference_section(found, titles[side], ending))
    sections.append(figure_section(found))
    sections += [s for side, ending in ends.items() for s in more_sections(found, side, ending)]
    return page_html(
        sections,
        provenance=provenance,
        title=_title(found),
        sentence=sentence,
        status="ok",
        verdict=verdict_of(found),
        good=True,
        who=[_person_line(gait, found) for gait in (gaits[:1] if found.sides else gaits)],
        notes=_notes(found),
        key=[(gait.name, colour_of(found, k)) for k, gait in enumerate(gaits)],
        footer="Angles in degrees; coordinates and signs are OpenSim's. Curves are in compare.csv.",
    )


def colour_of(found: RunComparison, k: int) -> str:
    """Return the colour of a gait or side."""
    return STROKES[found.gaits[k].side] if found.sides else COLOURS[k % len(COLOURS)]


def measure_section(found: RunComparison) -> Section:
    """Return the measures of the runs, and their differences from the first."""
    rows = []
    for one in shown_in("comparison"):
        known = [gait.figure(one.key) for gait in found.gaits]
        if all(value is None for value in known):
            continue
        row = [one.label, *(rounded_text(value, one.digits) for value in known)]
        row += [
            "–" if value is None or known[0] is None else signed_text(value - known[0], one.digits)
            for value in known[1:]
        ]
        rows.append([*row, one.unit])
    words = "difference" if len(found.gaits) == 2 else "{} minus first"
    headers = ["measure", *(gait.name for gait in found.gaits)]
    headers += [words.format(gait.name) for gait in found.gaits[1:]]
    text = (
        f"Differences of the Gait Profile Score below {MIN_IMPORTANT_DIFFERENCE}° are not "
        "clinically relevant (Baker et al. 2012, Gait & Posture 35:612; in children)."
    )
    return Section("Measures", headers=[*headers, "unit"], rows=rows, text=text)


def overlay_section(found: RunComparison, title: str, ending: str) -> Section:
    """Return the mean curves of the gaits, by level and plane."""
    counts = ", ".join(f"{gait.name} {_count(gait, f'knee_angle{ending}')}" for gait in found.gaits)
    who = _norm_of(found)
    text = f"Line and band: mean and standard deviation over cycles ({counts})."
    text += " Dashed vertical lines: foot off. Thick lines on the axis: the difference from the "
    text += "first exceeds its 95 % band."
    if who is not None:
        text += f" Grey band: mean ± 1 SD of {who[0].people}. {who[0].citation}".rstrip() + "."
    grid = grid_of(_cells(found, ending, overlay))
    return Section(f"{title}: angles", text=text, grid=grid, sheet=found.sides)


def difference_section(found: RunComparison, title: str, ending: str) -> Section:
    """Return the differences with their bands, by level and plane."""
    text = (
        "Difference of the mean curves; band: 95 % confidence for the whole curve at once (random "
        "field theory as in statistical parametric mapping, Pataky 2010, J Biomech 43:1976). Where "
        "it excludes zero, these recordings differ. Cycles are assumed to be independent; "
        "successive strides of a trial are correlated, so the band is somewhat too narrow. It does "
        "not include variation between days or marker placements, which is usually 2 to 5° between "
        "sessions (McGinley et al. 2009, Gait & Posture 29:360)."
    )
    if any(each.half is None for table in found.differences.values() for each in table.values()):
        text += f" There is no band with fewer than {MIN_CYCLES} measured cycles."
    grid = grid_of(_cells(found, ending, difference))
    return Section(f"{title}: differences", text=text, grid=grid)


def more_sections(found: RunComparison, side: str, ending: str) -> list[Section]:
    """Return trunk, ground reactions and moments, if all gaits have them."""
    sections = []
    trunk = [name for name in TRUNK if name in found.names] if side != "l" else []
    loads = [f"{name}{ending}" for name in LOADS if f"{name}{ending}" in found.names]
    word = f", {SIDE_NAMES[side]}" if side else ""
    for title, shown in (("Trunk", trunk), (f"Ground reactions and moments{word}", loads)):
        figures = [draw(found, name) for name in shown for draw in (overlay, difference)]
        if figures:
            sections.append(Section(title, figures, text="Plotted as above.", folded=True))
    return sections


def overlay(found: RunComparison, name: str, height: int = 210) -> Figure:
    """Return a curve of all gaits: mean and standard deviation."""
    series, ribbons, marks, spans = [], [], [], []
    base, side = split_side(name)
    who = _norm_of(found)
    if who is not None and PUBLISHED_NAMES.get(base, base) in names(who[0]):
        band = norm(base, who[1], population=who[0])
        low, high = band.mean - band.sd, band.mean + band.sd
        ribbons.append(Ribbon(band.percent, low, high, STROKE_MIDDLE, 0.16))
    for k, gait in enumerate(found.gaits):
        colour = colour_of(found, k)
        mean, sd = mean_sd(gait.curves[name])
        if len(gait.curves[name]) > 1:
            ribbons.append(Ribbon(PERCENT, mean - sd, mean + sd, colour, 0.18))
        series.append(Series(PERCENT, mean, "", colour, 2.0))
        offs = gait.foot_off.values() if found.sides else [gait.foot_off.get(side or "r")]
        marks += [(off, colour) for off in offs if off is not None]
        if k:
            spans += _spans(found.differences[gait.name][name].beyond, colour)
    return Figure(
        line_plot(
            series, bands=ribbons, marks=marks, spans=spans, title=title_of(base),
            x_label="gait cycle [%]", y_label=_label(base), least=_least(base), height=height,
        )
    )  # fmt: skip


def difference(found: RunComparison, name: str, height: int = 210) -> Figure:
    """Return the differences of a curve from the first gait, each with its band."""
    series, ribbons, spans = [], [], []
    base, _ = split_side(name)
    for k, gait in enumerate(found.gaits[1:], start=1):
        colour = STROKE_MIDDLE if found.sides else colour_of(found, k)
        each = found.differences[gait.name][name]
        if each.half is not None:
            low, high = each.mean - each.half, each.mean + each.half
            ribbons.append(Ribbon(PERCENT, low, high, colour, 0.22))
        series.append(Series(PERCENT, each.mean, "", colour, 2.0))
        spans += _spans(each.beyond, colour)
    unit = UNITS[unit_of(base)]
    return Figure(
        line_plot(
            series, bands=ribbons, spans=spans, title=f"{title_of(base)}, difference",
            x_label="gait cycle [%]", y_label=f"[{unit}]", least=_least(base), height=height,
            zero=True,
        )
    )  # fmt: skip


def _cells(found: RunComparison, ending: str, draw: Draw) -> dict[str, Figure]:
    """Return the plots of all angles that every gait has."""
    names = [name for name in NAMES if f"{name}{ending}" in found.names]
    return {name: draw(found, f"{name}{ending}", HEIGHT) for name in names}


def _spans(beyond: Array, colour: str) -> list[tuple[float, float, str]]:
    """Return the intervals of the cycle in which a difference exceeds its band."""
    last = len(PERCENT) - 1
    return [
        (float(PERCENT[run.start]), float(PERCENT[min(run.stop, last)]), colour)
        for run in runs(beyond)
    ]


def _norm_of(found: RunComparison) -> tuple[Population, str] | None:
    """Return the norms of the gaits, if they are the same for all."""
    if not all(usual_walk(run.figures) for run in found.runs):
        return None
    every = [norms_for(run.record, run.figures) for run in found.runs]
    same = {(each.population, each.speed_class) for each in every}
    adults = {each.population for each in every}
    if len(same) > 1 and not (len(adults) == 1 and every[0].population.name == "adults"):
        return None
    return every[0].population, every[0].speed_class


def _notes(found: RunComparison) -> list[str]:
    """Return notes on conditions that affect the differences."""
    notes, first = [], found.gaits[0].runs[0]
    for gait in () if found.sides else found.gaits[1:]:
        run, slow, fast = gait.runs[0], _speed(found.gaits[0]), _speed(gait)
        if slow is not None and fast is not None and abs(fast - slow) > MAX_SPEED_DIFFERENCE:
            notes.append(
                f"{gait.name} has a speed of {fast:.2f} m/s, {found.gaits[0].name} of {slow:.2f} "
                "m/s; angles and forces depend on speed."
            )
        a, b = (r.record.human for r in (first, run))
        if abs(a.height - b.height) > 0.03 or (a.joints, a.feet) != (b.joints, b.feet):
            notes.append(
                f"{gait.name} ({b.height:.2f} m, {b.joints} joints, {b.feet} feet) has another "
                "body "
                f"than {found.gaits[0].name} ({a.height:.2f} m, {a.joints} joints, {a.feet} feet)."
            )
        if run.kind != first.kind:
            notes.append(
                f"{gait.name} was made by {run.kind}, {found.gaits[0].name} by {first.kind}."
            )
    for name in found.omitted:
        notes.append(f"{name} is omitted, because it shows no complete gait cycle.")
    for gait in found.gaits:
        if gait.exact:
            notes.append(
                f"all strides of {gait.name} are equal because it is synthesised; the band "
                "contains the variability of the others only."
            )
    return notes


def _person_line(gait: ComparedGait, found: RunComparison) -> str:
    run = gait.runs[0]
    human, name = run.record.human, run.name if found.sides else gait.name
    if len(gait.runs) > 1:
        name = ", ".join(one.name for one in gait.runs)
        name = f"{len(gait.runs)} trials ({name})" if found.sides else f"{gait.name} ({name})"
    return f"{name}: {run.kind}, {human.height:.2f} m, {human.mass:.1f} kg"


def _speed(gait: ComparedGait) -> float | None:
    walked = gait.figure("walking_speed_m_s")
    return gait.figure("running_speed_m_s") if walked is None else walked


def _title(found: RunComparison) -> str:
    gaits, first = found.gaits, found.runs[0]
    if not found.sides:
        return f"{gaits[0].name} and {', '.join(gait.name for gait in gaits[1:])}"
    if len(found.runs) == 1 and found.affected is None:
        return first.title or "Two sides"
    return f"{gaits[1].name[0].upper()}{gaits[1].name[1:]} and {gaits[0].name} side"


def _count(gait: ComparedGait, name: str) -> str:
    rows = gait.curves.get(name, ())
    return "as made" if gait.exact else str(len(rows))


def _label(base: str) -> str:
    return OWN_SIDE.get(base) or axis_label(base, UNITS[unit_of(base)])


def _least(base: str) -> float:
    return MIN_SPANS.get(UNITS[unit_of(base)], 0.0)
