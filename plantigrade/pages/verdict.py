"""The verdict of a run in one sentence about the person, for the head of its report."""

from typing import Any

import numpy as np

from plantigrade.analyze.gait_profile import MIN_IMPORTANT_DIFFERENCE
from plantigrade.analyze.pushes import push_intervals
from plantigrade.pages.section import ReportedRun
from plantigrade.printable import joined


def verdict_sentence(subject: ReportedRun) -> str:
    """Return what became of the person, in one sentence; empty if nothing is known.

    A run that is not ok gets its status as the end of the sentence.
    """
    run, signals = subject.run, subject.record.signals
    if run.kind == "simulate":
        return _simulated(subject)
    if not run.ok:
        return f"{_FAILED.get(run.kind, 'This result is not valid')}: {_reason(subject)}."
    if run.kind == "vault":
        return _vaulted(subject)
    if "check.quantity" in signals:
        return _checked(subject)
    if "tasks.names" in signals:
        return _reproduced(subject)
    return _recorded(subject) if run.kind == "fit" else ""


_FAILED = {
    "fit": "The body does not fit this recording",
    "reproduce": "The tasks do not reproduce this walk",
    "synthesize": "No valid motion was found",
    "track": "No valid motion near the recording was found",
    "vault": "No valid vault was found",
}


def _reason(subject: ReportedRun) -> str:
    """Return the status; of several findings of the check the worst, and the number of others."""
    findings, status = subject.text_signal("check.findings"), subject.run.status
    if len(findings) < 2 or not status.startswith(findings[0]):
        return status
    more = len(findings) - 1
    return f"{findings[0]} (and {more} more finding{'s' if more > 1 else ''})"


def acted_on_body(subject: ReportedRun) -> list[str]:
    """Return what acted on a simulated person beyond gravity and level ground, in short phrases."""
    pushes, settings = push_intervals(subject.record), subject.run.provenance.settings
    found, pulled = [], bool(settings.get("rope")) and not settings.get("push")
    if pushes:
        most = f"{max(push.force for push in pushes):.0f} N"
        name = "pull" if pulled else "push"
        several = f"{len(pushes)} {name}{'es' if name == 'push' else 's'} of up to {most}"
        found.append(f"a {name} of {most}" if len(pushes) == 1 else several)
    boxes = _count(settings.get("box"))
    if boxes:
        found.append("a thrown box" if boxes == 1 else f"{boxes} thrown boxes")
    load = settings.get("load")
    if isinstance(load, int | float) and load > 0:
        found.append(f"a backpack of {load:g} kg")
    if settings.get("shift"):
        found.append("a shift of the floor")
    return found + _terrain(subject)


def _terrain(subject: ReportedRun) -> list[str]:
    ground = subject.record.ground
    if ground.bumps or ground.field is not None:
        return ["uneven ground"]
    if ground.steps:
        return ["steps"]
    slope = np.rad2deg(ground.slope)
    return [f"a slope of {abs(slope):.0f}°"] if abs(slope) > 0.5 else []


def _simulated(subject: ReportedRun) -> str:
    """Return whether the person stayed on their feet, and what they withstood."""
    acted, fell = acted_on_body(subject), subject.number("fell_at_s")
    diverged = subject.number("diverged_at_s")
    if diverged is not None:
        return (
            f"The simulation broke down after {diverged:.2f} s, because its motion grew without "
            "bounds; nothing follows for the person."
        )
    if fell is None:
        text = f"The person stayed on their feet for all {subject.record.motion.duration:.1f} s"
        return f"{text} and withstood {joined(acted)}." if acted else f"{text}."
    text = f"The person fell after {fell:.2f} s"
    before = [push for push in push_intervals(subject.record) if push.start < fell]
    if before:
        last = before[-1]
        return f"{text}, {fell - last.start:.2f} s after the start of a push of {last.force:.0f} N."
    return f"{text}, exposed to {joined(acted)}." if acted else f"{text}."


def _recorded(subject: ReportedRun) -> str:
    """Return how a recorded person moves."""
    speed, number = subject.number("walking_speed_m_s"), subject.number
    cadence, running = number("cadence_steps_min"), number("running_speed_m_s")
    if subject.runs and running is not None:
        return f"This person runs at {running:.2f} m/s{_steps(cadence)}."
    if speed is None:
        return "The body of the model follows the recorded motion."
    text = f"This person walks at {speed:.2f} m/s{_steps(cadence)}"
    score, usual = number("gps_deg"), number("gps_reference_deg")
    if score is None or usual is None:
        return f"{text}."
    people = subject.population.name
    if score <= usual:
        how = f"differ from the mean of healthy {people} no more than is usual among them"
    elif score <= usual + MIN_IMPORTANT_DIFFERENCE:
        how = f"differ slightly more from the mean of healthy {people} than is usual among them"
    else:
        how = f"differ clearly from those of healthy {people}"
    return f"{text}; joint angles {how} (Gait Profile Score {score:.1f}°, usual {usual:.1f}°)."


def _steps(cadence: float | None) -> str:
    return "" if cadence is None else f" with {cadence:.0f} steps per minute"


def _reproduced(subject: ReportedRun) -> str:
    """Return how near a reproduced walk is to the recorded one."""
    mean, most = subject.number("rom_error_mean_deg"), subject.number("rom_error_max_deg")
    text = "The tasks alone reproduce the recorded walk"
    if mean is None:
        return f"{text}."
    worst = "" if most is None else f", by {most:.1f}° at most"
    return f"{text}: ranges of the joints differ by {mean:.1f}° on average{worst}."


def _checked(subject: ReportedRun) -> str:
    """Return that a generated motion is physical, and what it does."""
    count = len(subject.record.signals["check.quantity"])
    speed, error = subject.number("walking_speed_m_s"), subject.number("tracking_angle_rms_deg")
    flight, what = subject.number("flight_rise_m"), "The person moves"
    if speed is not None:
        what = f"The person walks at {speed:.2f} m/s"
    elif flight is not None and flight > 0:
        what = f"The person jumps {100 * flight:.0f} cm high"
    text = f"{what} as the laws of physics allow: all {count} checks passed"
    return text + ("." if error is None else f"; angles follow the recording within {error:.1f}°.")


def _vaulted(subject: ReportedRun) -> str:
    speed = subject.number("take_off_speed_m_s")
    text = "The gymnast leaves the table"
    return f"{text}." if speed is None else f"{text} upward at {speed:.2f} m/s."


def _count(value: Any) -> int:
    """Return the number of values of a repeatable option in settings."""
    return len(value) if isinstance(value, list | tuple) else int(bool(value))
