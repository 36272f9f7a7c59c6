"""Learning curve of a training, with one row per part."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from plantigrade.io.writing import csv_text, write_text


@dataclass(frozen=True, kw_only=True)
class Progress:
    """One row of the learning curve.

    Attributes:
        decisions: Decisions since the start.
        seconds: Wall-clock time of the training [s].
        reward: Mean reward per decision, with exploration noise.
        pose: Mean of the pose term.
        velocity: Mean of the velocity term.
        com: Mean of the centre-of-mass term.
        ends: Mean of the limb-end term.
        falls_per_minute: Falls per minute, with exploration noise.
        spread: Standard deviation of actions.
        rate: Learning rate.
        standing: Evaluation starts without a fall, without noise; -1 if there was no evaluation.
        lasted: Mean walking time in the evaluation [s]; -1 if there was none.
        force: Mean of the force term.
        soles: Mean of the sole term.
    """

    decisions: int
    seconds: float
    reward: float
    pose: float
    velocity: float
    com: float
    ends: float
    falls_per_minute: float
    spread: float
    rate: float
    standing: int = -1
    lasted: float = -1.0
    force: float = 0.0
    soles: float = 0.0


def write_curve(path: Path, curve: Sequence[Progress]) -> None:
    """Write a learning curve as CSV with six significant digits.

    Raises:
        FileError: If the file cannot be written.
    """
    names = [f.name for f in fields(Progress)]
    write_text(path, csv_text(names, ([getattr(row, n) for n in names] for row in curve)))
