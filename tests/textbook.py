"""The textbook walk as tests need it: as a record, and as a recording in a file."""

from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.io import write
from plantigrade.kinematics.textbook_recording import recorded
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record


def walk_record(human: Human, **options: Any) -> Record:
    """Return the textbook walk of a person with its events, all velocities zero."""
    book = textbook_walk(human, **options)
    rest = np.zeros((len(book.time), human.model.nv))
    return Record(human, Motion(book.time, book.qpos, rest, human.joint_names, events=book.events))


def walk_file(path: Path, *, seed: int = 0, **options: Any) -> Path:
    """Write a recording of the textbook walk of the usual person and return its path."""
    write(recorded(textbook_walk(Human.create(), **options), path, seed=seed), path)
    return path
