"""Spatio-temporal measures of a walk, with published values of adults or children."""

from plantigrade.analyze import norms
from plantigrade.analyze.symmetry import symmetry_index
from plantigrade.constants import SIDES
from plantigrade.pages.section import ReportedRun, Section
from plantigrade.pages.shown import shown_in
from plantigrade.pages.text import rounded_text, signed_text

MEASURES = "Spatio-temporal measures"


def measure_section(subject: ReportedRun) -> list[Section]:
    """Return the table of measures: right, left, both, symmetry, and published values."""
    if not subject.walks:
        missing = "no complete gait cycle was found, so no step or stride could be measured."
        return [Section(MEASURES, missing=missing)]
    # no published values for running, walking backward or sideways, or with norms of the user
    none = subject.population.own or not subject.has_norms
    published = {} if none else _published(subject)
    rows = [
        [w.label, "", "", _value(subject, w.key, w.digits), "", w.unit, published.get(w.label, "")]
        for w in shown_in("whole gait")
    ]
    for one in shown_in("gait by side"):
        keys = [one.key.replace("SIDE", side) for side in SIDES]
        cells = [_value(subject, key, one.digits) for key in keys]
        cells += ["", _symmetry(subject, keys), one.unit]
        rows.append([one.label, *cells, published.get(one.label, "")])
    rows = [row for row in rows if any(row[1:4])]
    if not rows:
        return [Section(MEASURES, missing="no gait measures are known.")]
    text = (
        "A step is from heel strike of one foot to that of the other and is named after the foot "
        "that lands; a stride is between heel strikes of the same foot. Mean ± standard deviation "
        "of several. Symmetry index: right minus left, relative to their mean (Robinson et al. "
        "1987, J Manipulative Physiol Ther 10:172)."
    )
    who = subject.population
    if published and who is norms.ADULTS:
        text += (
            " Adults: mean ± SD at this speed of 51 people of 21–37 and 50–84 years on a treadmill "
            "(BMClab, CC BY 4.0)."
        )
    elif published:
        speed = subject.speed_class.replace("_", " ")
        text += f" Children: {who.people}, {who.speed}; here: {speed} ({who.citation})."
    headers = ("measure", "right", "left", "both", "symmetry index", "unit", who.name)
    if none:
        headers, rows = headers[:-1], [row[:-1] for row in rows]
    return [Section(MEASURES, headers=headers, rows=rows, text=text)]


def _value(subject: ReportedRun, key: str, digits: int) -> str:
    """Return mean and standard deviation; empty if unknown."""
    mean, sd = (subject.number(key.format(part)) for part in ("", "_sd"))
    if mean is None:
        return ""
    spread = "" if sd is None else f" ± {rounded_text(sd, digits)}"
    return rounded_text(mean, digits) + spread


def _symmetry(subject: ReportedRun, keys: list[str]) -> str:
    """Return the symmetry index of a measure."""
    right, left = (subject.number(key.format("")) for key in keys)
    index = float("nan") if right is None or left is None else symmetry_index(right, left)
    return f"{signed_text(index)} %" if index == index else ""


def _published(subject: ReportedRun) -> dict[str, str]:
    """Return published values of adults at the speed of the walk, or of children."""
    if subject.population is norms.ADULTS:
        speed = subject.number("walking_speed_m_s")
        steps = {} if speed is None else norms.adult_steps(speed)
        digits = {"step_length": 2, "cadence": 0}
        return {
            name.replace("_", " "): f"{mean:.{digits[name]}f} ± {sd:.{digits[name]}f}"
            for name, (mean, sd) in steps.items()
        }
    foot_off, both = (
        table[subject.speed_class] for table in (norms.FOOT_OFF, norms.DOUBLE_SUPPORT)
    )
    return {"stance": f"{foot_off[0]} ± {foot_off[1]}", "double support": f"{both[0]} ± {both[1]}"}
