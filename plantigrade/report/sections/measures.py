"""Spatio-temporal measures of a walk, beside what is published of adults or children."""

from plantigrade.analyze import norms
from plantigrade.analyze.gait_profile import LEG, PELVIS, gait_profile
from plantigrade.charts.labels import title_of
from plantigrade.constants import SIDES
from plantigrade.report.section import Section, Subject
from plantigrade.report.text import rounded_text, signed_text

MEASURES = "Spatio-temporal measures"
WHOLE = (
    ("walking speed", "m/s", "walking_speed{}_m_s", 2),
    ("running speed", "m/s", "running_speed{}_m_s", 2),
    ("cadence", "steps/min", "cadence{}_steps_min", 0),
    ("step width", "m", "step_width{}_m", 2),
    ("double support", "% of stride", "double_support{}_pct", 0),
)
BY_SIDE = (
    ("stride length", "m", "stride_length_SIDE{}_m", 2),
    ("stride time", "s", "stride_time_SIDE{}_s", 2),
    ("step length", "m", "step_length_SIDE{}_m", 2),
    ("step time", "s", "step_time_SIDE{}_s", 2),
    ("stance", "% of stride", "stance_SIDE{}_pct", 1),
    ("swing", "% of stride", "swing_SIDE{}_pct", 1),
    ("contact time", "s", "contact_time_SIDE{}_s", 3),
    ("flight time", "s", "flight_time_SIDE{}_s", 3),
    ("duty factor", "of stride", "duty_factor_SIDE{}_ratio", 2),
)
"""Name, unit, key of the figure (``{}``: where the standard deviation's has ``_sd``), decimals."""


def measure_section(subject: Subject) -> list[Section]:
    """Return the table of measures: right, left, both, their asymmetry, and published."""
    if not subject.walks:
        missing = "no whole gait cycle was found, so no step or stride could be measured."
        return [Section(MEASURES, missing=missing)]
    published = {} if subject.runs else _published(subject)
    rows = [
        [name, "", "", _value(subject, key, digits), "", unit, published.get(name, "")]
        for name, unit, key, digits in WHOLE
    ]
    for name, unit, key, digits in BY_SIDE:
        keys = [key.replace("SIDE", side) for side in SIDES]
        cells = [_value(subject, one, digits) for one in keys]
        rows.append([name, *cells, "", _asymmetry(subject, keys), unit, published.get(name, "")])
    rows = [row for row in rows if any(row[1:4])]
    if not rows:
        return [Section(MEASURES, missing="no measure of the walk is known.")]
    text = (
        "A step goes from one foot's heel strike to the other's and is named after the foot that "
        "lands; a stride goes to the same foot's next. Mean ± standard deviation where there are "
        "several. Asymmetry: right minus left, of the mean of both."
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
    headers = ("measure", "right", "left", "both", "asymmetry", "unit", who.name)
    if subject.runs:  # nothing published of walking is any measure of it
        headers, rows = headers[:-1], [row[:-1] for row in rows]
    return [Section(MEASURES, headers=headers, rows=rows, text=text)]


def profile_section(subject: Subject) -> list[Section]:
    """Return the Gait Profile Score against adults; nothing where an angle is not known."""
    angles = subject.angle_curves.angles
    legs = [f"{name}_{side}" for side in SIDES for name in LEG]
    if (
        subject.runs
        or subject.population is not norms.ADULTS
        or not all(len(angles.get(name, ())) for name in (*PELVIS, *legs))
    ):
        return []
    found = gait_profile(subject.angle_curves.percent, angles)
    rows = [
        [title_of(name), "", "", f"{found.difference[name]:.1f}", f"{found.usual[name]:.1f}"]
        for name in PELVIS
    ]
    for name in LEG:
        cells = [f"{found.difference[f'{name}_{side}']:.1f}" for side in SIDES]
        rows.append([title_of(name), *cells, "", f"{found.usual[name]:.1f}"])
    scores = [f"{found.score(side):.1f}" for side in (*SIDES, "")]
    rows.append(["Gait Profile Score", *scores, f"{found.usual_score:.1f}"])
    text = (
        "Root mean square difference in degrees between the mean curve of each of the nine angles "
        "and that of adults, and the root mean square of them all (Baker et al. 2009, Gait & "
        "Posture 30:265). The last column is one standard deviation of the adults. Offsets that "
        "come from another definition of an angle are part of it, most of all in pelvis tilt, hip "
        f"rotation and foot progression. Adults: {norms.ADULTS.people}, {norms.ADULTS.speed}."
    )
    headers = ("angle", "right", "left", "both", "usual")
    return [Section("Gait Profile Score", text=text, headers=headers, rows=rows, folded=True)]


def _value(subject: Subject, key: str, digits: int) -> str:
    """Return mean and standard deviation; nothing where it is not known."""
    mean, sd = (subject.number(key.format(part)) for part in ("", "_sd"))
    if mean is None:
        return ""
    spread = "" if sd is None else f" ± {rounded_text(sd, digits)}"
    return rounded_text(mean, digits) + spread


def _asymmetry(subject: Subject, keys: list[str]) -> str:
    """Return the difference of right and left in percent of their mean."""
    right, left = (subject.number(key.format("")) for key in keys)
    if right is None or left is None or right + left <= 0:
        return ""
    return f"{signed_text(200.0 * (right - left) / (right + left))} %"


def _published(subject: Subject) -> dict[str, str]:
    """Return what is published of adults at the speed of the walk, or of children."""
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
    return {
        "stance": f"{foot_off[0]} ± {foot_off[1]}",
        "double support": f"{both[0]} ± {both[1]}",
    }
