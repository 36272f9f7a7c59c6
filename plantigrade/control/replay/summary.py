"""Summary of a replay: its steps compared with the motion, and its touchdowns."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES
from plantigrade.control.gait.phase import Touchdown
from plantigrade.control.gait.reference import ReferenceTables

MIN_DEVIATION, MAX_STEPS = 0.04, 4  # [m] of a step that is described, and how many are
MAX_STRAY = 0.25  # [m] how far beside the motion it may end without a word: the length of a foot


def describe_steps(touchdowns: Sequence[Touchdown]) -> list[str]:
    """Return a sentence for each of the steps that deviate most from the motion, in order of time.

    A step deviates by its offset from the motion, less that of the step before.

    Example:
        >>> axes = np.eye(2)
        >>> aside = Touchdown(3.21, "l", 0.0, np.array([0.0, 0.06, 0.0]), axes)
        >>> describe_steps([Touchdown(2.7, "r", 0.0, np.zeros(3), axes), aside])
        ['Stepped 6 cm to the left with the left foot at 3.2 s.']
    """
    deviations = []
    before = np.zeros(2)
    for step in touchdowns:
        deviations.append((step, (step.offset[:2] - before) @ step.axes))
        before = step.offset[:2]
    large = [each for each in deviations if np.linalg.norm(each[1]) > MIN_DEVIATION]
    large = sorted(large, key=lambda each: -float(np.linalg.norm(each[1])))[:MAX_STEPS]
    in_time = sorted(large, key=lambda each: each[0].time)
    return [_step(step, deviation) for step, deviation in in_time]


def _step(step: Touchdown, deviation: Float[Array, " 2"]) -> str:
    (ahead, left), least = 100.0 * deviation, 50.0 * MIN_DEVIATION
    words = []
    if abs(ahead) > least:
        words.append(f"{abs(ahead):.0f} cm {'ahead' if ahead > 0 else 'short'}")
    if abs(left) > least:
        words.append(f"{abs(left):.0f} cm to the {'left' if left > 0 else 'right'}")
    return (
        f"Stepped {' and '.join(words)} with the {SIDE_NAMES[step.side]} foot at {step.time:.1f} s."
    )


def describe_touchdowns(touchdowns: Sequence[Touchdown]) -> str:
    """Return a sentence on early and late touchdowns; an empty one without touchdowns."""
    if not touchdowns:
        return ""
    early = np.array([step.early for step in touchdowns])
    parts = []
    for word, those in (("sooner", early[early > 0]), ("later", -early[early < 0])):
        if len(those):
            parts.append(f"{len(those)} {word} than planned by {1e3 * those.mean():.0f} ms")
    count = f"{len(early)} touchdown{'s' if len(early) > 1 else ''}"
    return f"{count}: {', '.join(parts)} on average." if parts else f"{count}, all as planned."


def describe_end(reference: ReferenceTables, phase: float) -> str:
    """Return a sentence on a motion that ended before its simulation, and not at rest; else none.

    Args:
        phase: Time of the motion at the end of the simulation [s].
    """
    if reference.period is not None or reference.ends or phase <= reference.duration:
        return ""
    return (
        f"The motion ends after {reference.duration:.2f} s, and not at rest; a foot that swung was "
        "set down there, and what follows is not part of it."
    )


def describe_stray(off: Float[Array, " 2"]) -> str:
    """Return a sentence on a body that is far beside the motion [m]; an empty one if it is not."""
    far = float(np.linalg.norm(off))
    if far <= MAX_STRAY:
        return ""
    return (
        f"Steps that the motion does not have led the person {far:.2f} m beside it: this is not "
        "that motion."
    )


def touchdown_figures(touchdowns: Sequence[Touchdown]) -> dict[str, float | int]:
    """Return the numbers of touchdowns, of early and late ones, and their greatest deviations."""
    early = np.array([step.early for step in touchdowns])
    return {
        "touchdowns": len(early),
        "touchdowns_early": int((early > 0).sum()),
        "touchdowns_late": int((early < 0).sum()),
        "touchdown_early_max_s": float(early.max(initial=0.0)),
        "touchdown_late_max_s": float((-early).max(initial=0.0)),
    }
