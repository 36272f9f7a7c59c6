"""What a replay did, in words and figures: where it stepped beside the motion, and when."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.phase import Touchdown

TOLD = 0.04
"""A step further than this beside the one before is told [m]."""
MOST = 4
"""So many steps are told, the widest."""
NAMES = {"r": "right", "l": "left"}


def steps_told(touchdowns: Sequence[Touchdown]) -> list[str]:
    """Return a sentence for each of the widest steps beside the motion, in order of time.

    A step counts by how far its foot is beside the motion, less what the foot before it was.

    Example:
        >>> axes = np.eye(2)
        >>> aside = Touchdown(3.21, "l", 0.0, np.array([0.0, 0.06, 0.0]), axes)
        >>> steps_told([Touchdown(2.7, "r", 0.0, np.zeros(3), axes), aside])
        ['Stepped 6 cm to the left with the left foot at 3.2 s.']
    """
    moved = []
    before = np.zeros(2)
    for step in touchdowns:
        moved.append((step, (step.offset[:2] - before) @ step.axes))
        before = step.offset[:2]
    wide = [(step, way) for step, way in moved if np.linalg.norm(way) > TOLD]
    wide = sorted(wide, key=lambda each: -float(np.linalg.norm(each[1])))[:MOST]
    return [_step(step, way) for step, way in sorted(wide, key=lambda each: each[0].time)]


def _step(step: Touchdown, way: Float[Array, " 2"]) -> str:
    ahead, left = 100.0 * way
    words = []
    if abs(ahead) > 100.0 * TOLD / 2:
        words.append(f"{abs(ahead):.0f} cm {'ahead' if ahead > 0 else 'short'}")
    if abs(left) > 100.0 * TOLD / 2:
        words.append(f"{abs(left):.0f} cm to the {'left' if left > 0 else 'right'}")
    return f"Stepped {' and '.join(words)} with the {NAMES[step.side]} foot at {step.time:.1f} s."


def touchdowns_told(touchdowns: Sequence[Touchdown]) -> str:
    """Return a sentence on when feet came down; nothing where none did."""
    if not touchdowns:
        return ""
    early = np.array([step.early for step in touchdowns])
    parts = []
    for word, those in (("sooner", early[early > 0]), ("later", -early[early < 0])):
        if len(those):
            parts.append(f"{len(those)} {word} than planned by {1e3 * those.mean():.0f} ms")
    count = f"{len(early)} touchdown{'s' if len(early) > 1 else ''}"
    return f"{count}: {', '.join(parts)} on average." if parts else f"{count}, all as planned."


def replay_figures(touchdowns: Sequence[Touchdown]) -> dict[str, float | int]:
    """Return touchdowns, how many came early and late, and by how much at most."""
    early = np.array([step.early for step in touchdowns])
    return {
        "touchdowns": len(early),
        "touchdowns_early": int((early > 0).sum()),
        "touchdowns_late": int((early < 0).sum()),
        "touchdown_early_max_s": float(early.max(initial=0.0)),
        "touchdown_late_max_s": float((-early).max(initial=0.0)),
    }
