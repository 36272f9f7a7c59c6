"""Learning curve of a training, with one row per part."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from plantigrade.io.writing import csv_text, write_text


@dataclass(frozen=True, kw_only=True)
class LearningProgress:
    """One row of the learning curve."""

    decisions: int  #: Decisions since the start
    seconds: float  #: Wall-clock time of the training [s]
    reward: float  #: Mean reward per decision, with exploration noise
    pose: float  #: Mean of the pose term
    velocity: float  #: Mean of the velocity term
    com: float  #: Mean of the centre-of-mass term
    ends: float  #: Mean of the limb-end term
    falls_per_minute: float  #: Falls per minute, with exploration noise
    spread: float  #: Standard deviation of actions
    rate: float  #: Learning rate
    #: Evaluation starts without a fall, without noise; -1 if there was no evaluation
    standing: int = -1
    lasted: float = -1.0  #: Mean walking time in the evaluation [s]; -1 if there was none
    force: float = 0.0  #: Mean of the force term
    touchdown: float = 0.0  #: Mean of the touchdown term
    load: float = 0.0  #: Mean of the load term
    soles: float = 0.0  #: Mean of the sole term


def write_curve(path: Path, curve: Sequence[LearningProgress]) -> None:
    """Write a learning curve as CSV with six significant digits.

    Raises:
        FileError: If the file cannot be written.
    """
    names = [f.name for f in fields(LearningProgress)]
    write_text(path, csv_text(names, ([getattr(row, n) for n in names] for row in curve)))
