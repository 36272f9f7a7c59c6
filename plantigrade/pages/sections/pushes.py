"""Pushes in a simulation, and the motion of the centre of mass around them."""

import numpy as np
from scipy.integrate import trapezoid

from plantigrade.analyze.pushes import SIGNAL, push_intervals
from plantigrade.charts import Figure, Series, line_plot
from plantigrade.charts.theme import REFERENCE, STROKE_LEFT, STROKE_MIDDLE, STROKE_RIGHT
from plantigrade.pages.scene import poses
from plantigrade.pages.section import ReportedRun, Section, needs

TITLE = "Pushes and recovery"
LEGEND = " Shaded: a push acts."
MIN_FRAMES = 3  # of a motion, for velocities
MAX_ROWS = 12  # pushes in the table


def push_shades(subject: ReportedRun) -> list[tuple[float, float, str]]:
    """Return the stretches of time in which the body is pushed, for plots over time."""
    return [(push.start, push.stop, REFERENCE) for push in push_intervals(subject.record)]


@needs(SIGNAL)
def push_section(subject: ReportedRun) -> list[Section]:
    """Return the pushes, and velocity and path of the centre of mass, if there was a push."""
    pushes = push_intervals(subject.record)
    if not pushes or subject.record.motion.n_frames < MIN_FRAMES:
        return []
    record, time = subject.record, subject.record.motion.time
    _, _, com = poses(record.human.model, record.motion.qpos)
    velocity = np.gradient(com, time, axis=0)
    force, shades = record.signals[SIGNAL], push_shades(subject)

    def plot(series: list[Series], title: str, label: str) -> Figure:
        drawn = line_plot(series, title=title, y_label=label, shades=shades, zero=True, width=520)
        return Figure(drawn)

    figures = [
        plot(
            [
                Series(time, velocity[:, 0], "forward", STROKE_RIGHT),
                Series(time, velocity[:, 1], "to the left", STROKE_LEFT),
            ],
            "Velocity of the centre of mass",
            "[m/s]",
        ),
        plot(
            [Series(time, com[:, 1] - com[0, 1], "", STROKE_MIDDLE)],
            "Centre of mass, sideways",
            "to the left [m]",
        ),
    ]
    rows = []
    for push in pushes[:MAX_ROWS]:
        acts = (time >= push.start) & (time <= push.stop)
        impulse = float(trapezoid(np.linalg.norm(force[acts], axis=1), time[acts]))
        mean = force[acts].mean(axis=0)
        rows.append(
            [
                f"{push.start:.2f} s",
                f"{push.stop - push.start:.2f} s",
                f"{push.force:.0f} N ({100 * push.force / record.weight:.0f} % BW)",
                f"{impulse:.0f} N s",
                direction_text(float(mean[0]), float(mean[1])),
            ]
        )
    text = f"Velocity and path in world axes.{LEGEND}"
    if len(pushes) > MAX_ROWS:
        text += f" The first {MAX_ROWS} of {len(pushes)} pushes are listed."
    headers = ("from", "duration", "largest force", "impulse", "direction")
    return [Section(TITLE, figures, text=text, headers=headers, rows=rows)]


def direction_text(forward: float, left: float) -> str:
    """Return a horizontal direction in words.

    Example:
        >>> direction_text(1.0, 0.0), direction_text(-1.0, 1.0), direction_text(0.0, -2.0)
        ('forward', 'backward and to the left', 'to the right')
    """
    size, words = max(abs(forward), abs(left)), []
    if abs(forward) > 0.4 * size:
        words.append("forward" if forward > 0 else "backward")
    if abs(left) > 0.4 * size:
        words.append("to the left" if left > 0 else "to the right")
    return " and ".join(words)
