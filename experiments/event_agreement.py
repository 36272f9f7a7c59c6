"""How close gait events from the motion alone come to force plates and to the file's own."""

import re
from collections.abc import Iterable

import numpy as np

from experiments.table import Row, at_most, sheet
from plantigrade.analyze.feet import event_points
from plantigrade.analyze.trial import Trial
from plantigrade.motion import Recording
from plantigrade.motion.event_sources import as_measured
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.plate_events import plate_events

END_MARGIN = 0.1  # events nearer to the first or last frame cannot be seen in the motion [s]
LONGEST_MATCH = 0.15  # events further apart than this are different events [s]


def event_rows(name: str, trial: Trial, recording: Recording) -> list[Row]:
    """Compare events found from the motion alone with plates and the file's own.

    Plates whose force was low-passed before it was stored rise before the foot lands: they are
    shown without a goal.
    """
    rows = []
    fit, feet = trial.fit, trial.feet
    own = detect_gait_events(fit.time, *event_points(fit), feet.pelvis)
    limit = 15 if is_running(own) else 10
    clean = as_measured(fit.recording.plates)
    rest = [plate for plate in fit.recording.plates if all(plate is not c for c in clean)]
    sources = [
        ("plates", plate_events(clean, fit.time, feet.heel, feet.toe), limit),
        ("low-passed plates", plate_events(rest, fit.time, feet.heel, feet.toe), None),
        ("file", recording.events, 20),
    ]
    first, last = fit.time[0] + END_MARGIN, fit.time[-1] - END_MARGIN
    for what, truth, goal in sources:
        if not truth:
            continue
        for kind in ("heel_strike", "toe_off"):
            theirs = [e for e in truth if e.kind == kind and first <= e.time <= last]
            if not theirs:
                continue
            errors, missed, invented = match(own, theirs, kind, complete=what == "file")
            label = f"{kind} against {what}"
            if errors:
                mae, bias = (1e3 * float(np.mean(e)) for e in (np.abs(errors), errors))
                quantity = f"{label}, mean error ({len(errors)})"
                rows.append(
                    Row(name, quantity, mae, "ms")
                    if goal is None
                    else at_most(name, quantity, mae, goal, "ms")
                )
                rows.append(Row(name, f"{label}, bias", bias, "ms"))
            if goal is not None:
                rows.append(at_most(name, f"{label}, missed", missed, 0))
            if what == "file":
                rows.append(at_most(name, f"{label}, invented", invented, 0))
    return rows


def match(ours: Iterable, theirs: Iterable, kind: str, *, complete: bool):
    """Return time errors of matched events [s], the number missed and the number invented."""
    errors, missed, used = [], 0, set()
    ours = [e for e in ours if e.kind == kind]
    theirs = list(theirs)
    for e in theirs:
        free = [i for i, o in enumerate(ours) if o.side == e.side and i not in used]
        i = min(free, key=lambda i: abs(ours[i].time - e.time), default=None)
        if i is not None and abs(ours[i].time - e.time) < LONGEST_MATCH:
            used.add(i)
            errors.append(ours[i].time - e.time)
        else:
            missed += 1
    first, last = min(e.time for e in theirs), max(e.time for e in theirs)
    extra = [o for i, o in enumerate(ours) if i not in used and first < o.time < last]
    return errors, missed, len(extra) if complete else 0


def event_sheet(title: str, rows: Iterable[Row]) -> str:
    """Return mean error and bias over all events of each kind and source."""
    found: dict[str, list[tuple[int, float, float]]] = {}
    errors: dict[tuple[str, str], tuple[int, float]] = {}
    for row in rows:
        match_ = re.fullmatch(r"((?:heel|toe).*), mean error \((\d+)\)", row.quantity)
        if match_ and row.value is not None:
            errors[row.subject, match_[1]] = (int(match_[2]), row.value)
        what, _, which = row.quantity.rpartition(", ")
        if which == "bias" and row.value is not None and (row.subject, what) in errors:
            count, mean = errors[row.subject, what]
            kind = f"{'running' if '/run' in row.subject else 'walking'}, {what}"
            found.setdefault(kind, []).append((count, mean, row.value))
    lines = []
    for kind, all_trials in sorted(found.items(), reverse=True):
        count, mean, bias = np.array(all_trials).T
        total = int(count.sum())
        lines.append(
            (kind, f"{total}", *(f"{(count * x).sum() / total:.1f}" for x in (mean, bias)))
        )
    return sheet(title, ("", "events", "mean error [ms]", "bias [ms]"), lines)
