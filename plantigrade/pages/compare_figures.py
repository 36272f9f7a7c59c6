"""Range, peak and time of the peak of compared gaits as a table, and the verdict."""

import math

from plantigrade.analyze.curve_difference import FigureDifference
from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.run_comparison import RunComparison
from plantigrade.charts.labels import title_of
from plantigrade.pages.section import Section
from plantigrade.pages.text import rounded_text, sided_title, signed_text
from plantigrade.side_names import side_of, without_side

SIGNIFICANT = 0.05  # Error probability below which a difference is set in bold
UNITS = {"deg": ("°", 1), "N m/kg": ("N m/kg", 2), "body weight": ("BW", 2), "%": ("% of cycle", 0)}
"""Unit on the page and decimals."""
UNIT_WORDS = {
    "paired trials": "a paired t test over the trials",
    "trials": "Welch's t test over the means of the trials",
    "cycles": "Welch's t test over the cycles, as if they were independent",
}


def figure_section(found: RunComparison) -> Section:
    """Return the table of range, peak and time of the peak of every curve."""
    from markupsafe import Markup

    several, rows, tests = len(found.gaits) > 2, [], {}
    for gait, each in found.figures.items():
        for d in each:
            unit, digits = UNITS[d.unit]
            p = _p_text(d.p)
            row = [_name(d), d.figure, rounded_text(d.first, digits)]
            row += [rounded_text(d.second, digits), signed_text(d.difference, digits), unit]
            row.append(Markup(f"<b>{p}</b>") if d.p < SIGNIFICANT else p)
            rows.append([gait, *row] if several else row)
            tests[d.test] = True
    first, second = found.gaits[0].name, "other" if several else found.gaits[1].name
    headers = ["curve", "figure", first, second, "difference", "unit", "p"]
    words = [UNIT_WORDS[test] for test in tests if test]
    text = "Means over cycles. Peak of an angle: its maximum; of a load: its larger extreme."
    if words:
        text += (
            f" p: {', or '.join(words)}; below {SIGNIFICANT} in bold. It is not corrected for the "
            f"number of rows: of {len(rows)}, about {max(round(SIGNIFICANT * len(rows)), 1)} are "
            "bold by chance alone."
        )
    else:
        text += " There are too few trials or cycles for a test."
    title = "Side differences" if found.sides else "Differences of ranges and peaks"
    return Section(title, text=text, headers=["gait", *headers] if several else headers, rows=rows)


def verdict_of(found: RunComparison) -> str:
    """Return the largest difference of a range of motion, in one sentence."""
    ranges = [
        (abs(d.difference), gait, d)
        for gait, each in found.figures.items()
        for d in each
        if d.figure == "range" and unit_of(without_side(d.curve)) == "deg"
    ]
    if not ranges:
        return ""
    significant = [one for one in ranges if one[2].p < SIGNIFICANT]
    _, gait, d = max(significant or ranges, key=lambda one: one[0])
    first = found.gaits[0].name
    more = "more" if d.difference > 0 else "less"
    tested = f", p {_p_text(d.p, sign=True)}" if d.test else ""
    kind = "largest significant difference" if significant else "largest difference"
    none = "" if significant or not d.test else "No range of motion differs significantly. "
    whose = f"the {gait} side moves" if found.sides else f"{gait} moves"
    name = sided_title(d.curve)
    return (
        f"{none}The {kind} is in {name[0].lower()}{name[1:]}: {whose} through "
        f"{abs(d.difference):.0f}° {more} ({d.second:.0f}° against {d.first:.0f}° "
        f"{'of the ' + first + ' side' if found.sides else 'of ' + first}{tested})."
    )


def _name(d: FigureDifference) -> str:
    """Return the name of a curve with its side."""
    side = side_of(d.curve)
    return sided_title(d.curve) if side else title_of(d.curve)


def _p_text(p: float, *, sign: bool = False) -> str:
    """Return an error probability.

    Example:
        >>> _p_text(0.0002), _p_text(0.0421, sign=True), _p_text(float("nan"))
        ('< 0.001', '= 0.042', '–')
    """
    if p < 0.001:
        return "< 0.001"
    return ("= " if sign else "") + rounded_text(p, 3) if math.isfinite(p) else "–"
