"""The learning curve of a training, one row for each part."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from plantigrade.io.writing import csv_text, write_text


@dataclass(frozen=True, kw_only=True)
class Progress:
    """One row of the learning curve: a part of the training.

    Attributes:
        decisions: So far.
        seconds: Of the clock, so far, as long as it ran [s].
        reward: Mean of a decision, with noise.
        pose: Likewise of the term; the next three, too.
        velocity: Likewise.
        com: Likewise.
        ends: Likewise.
        falls_per_minute: With noise.
        spread: Standard deviation of actions.
        rate: Learning rate.
        standing: Of the starts that were looked at without noise, how many did not fall; -1 where
            none was looked at.
        lasted: How long they walked on average [s]; -1 likewise.
        force: Mean of a decision of that term, with noise.
        soles: Likewise.
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
    """Write a learning curve as CSV, six digits to a number.

    Raises:
        FileError: If the file cannot be written.
    """
    names = [f.name for f in fields(Progress)]
    write_text(path, csv_text(names, ([getattr(row, n) for n in names] for row in curve)))
