"""Spatio-temporal measures of a walk beside published ones."""

from plantigrade.analyze import norms
from plantigrade.report.section import Section, Subject
from plantigrade.report.text import figure_text

TITLE = "Spatio-temporal measures"
WHOLE = (
    ("walking speed", "m/s", "walking_speed_m_s"),
    ("cadence", "steps/min", "cadence_steps_min"),
    ("step width", "m", "step_width_m"),
    ("double support", "% of stride", "double_support_pct"),
)
BY_SIDE = (
    ("stride length", "m", "stride_length_{}_m"),
    ("stride time", "s", "stride_time_{}_s"),
    ("step length", "m", "step_length_{}_m"),
    ("step time", "s", "step_time_{}_s"),
    ("stance", "% of stride", "stance_{}_pct"),
    ("swing", "% of stride", "swing_{}_pct"),
)


def measure_section(subject: Subject) -> list[Section]:
    """Return the table of measures: right, left, both, and published."""
    if not subject.walks:
        missing = "no whole gait cycle was found, so no step or stride could be measured."
        return [Section(TITLE, missing=missing)]
    foot_off = norms.FOOT_OFF[subject.speed_class]
    both = norms.DOUBLE_SUPPORT[subject.speed_class]
    published = {
        "stance": f"{foot_off[0]} ± {foot_off[1]}",
        "double support": f"{both[0]} ± {both[1]}",
    }
    rows = [
        [name, "", "", figure_text(subject.number(key)), unit, published.get(name, "")]
        for name, unit, key in WHOLE
    ]
    for name, unit, key in BY_SIDE:
        right, left = (figure_text(subject.number(key.format(side))) for side in ("r", "l"))
        rows.append([name, right, left, "", unit, published.get(name, "")])
    text = (
        "A step goes from one foot's heel strike to the other's, a stride to the same foot's next. "
        f"Published values: {norms.CITATION}."
    )
    headers = ("measure", "right", "left", "both", "unit", "published")
    return [Section(TITLE, headers=headers, rows=rows, text=text)]
