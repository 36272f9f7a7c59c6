"""Teach a person to walk after a reference; one folder for each seed."""

import csv
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from loky import cpu_count

from plantigrade.errors import ParameterError, RunExists
from plantigrade.io.text import read_text
from plantigrade.io.writing import csv_text, write_text
from plantigrade.learn.action import LANDING_GAINS
from plantigrade.learn.mirror import MAX_ASYMMETRY, asymmetry
from plantigrade.learn.policy import Policy, file_of
from plantigrade.learn.reference import ReferenceMotion
from plantigrade.learn.reward import LANDING_WEIGHTS
from plantigrade.learn.rules import Rules
from plantigrade.models import Human
from plantigrade.options import as_path
from plantigrade.record import Run
from plantigrade.threads import on_one_thread
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import OF_RECORDINGS, TrainSettings
from plantigrade.workflows.steps import Step, silent

if TYPE_CHECKING:
    from plantigrade.learn.learning_curve import LearningProgress

PAPER_PERSON = {"height": 1.50, "mass": 48.5, "joints": "66"}
"""The person of [Park2020]_, who walks where no recording is named."""
TERRAIN_CLEARANCE = 3.0
"""Clearance of the reference in mid-swing with random terrain [cm]; people pass ground with hidden
obstacles at 2.7 ± 0.7 cm, level ground at 1.1 ± 0.6 cm [Schulz2011]_, the textbook walk at 0.6."""
FILES = ("checkpoint.pt", "curve.csv", "policy.npz")
SPREAD = "curves.csv"  # The learning curves of all seeds as one


@dataclass(frozen=True)
class Taught:
    """The result of one seed."""

    seed: int  #: The seed
    folder: Path  #: Where its policy, learning curve and checkpoint are
    reached: bool  #: Whether the goal was
    last: "LearningProgress"  #: Last row of its learning curve


@on_one_thread
def train(
    source: str | Path | Run | None = None,
    settings: TrainSettings | None = None,
    *,
    out: str | Path,
    resume: bool = False,
    overwrite: bool = False,
    step: Step = silent,
    tell: Callable[[int, Any], None] = lambda seed, row: None,
    **options: Any,
) -> tuple[Taught, ...]:
    """Teach a person to walk after a reference.

    Args:
        source: A recording, which is fitted first, or a run or its folder; without either the
            published mean walk on the person of [Park2020]_.
        out: Folder; each seed has one of its own within. resume: Take up what was stopped; what has
        ended is kept as it is. tell: Called with the seed and a
        :class:`~plantigrade.learn.learning_curve.LearningProgress` after
            every part of a training.
        options: Fields of ``settings`` by name; they replace those of ``settings``.

    Raises:
        ParameterError: If a value is not allowed, or what is taken up is another training.
        RunExists: If there is a training already, neither to be taken up nor replaced.
        MissingExtra: If the extra ``learn`` is not installed.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.
    """
    from plantigrade.learn.training import Training

    how = TrainSettings.given("train", settings, options)
    folder = as_path(out, "the folder of a training").expanduser()
    places = [folder / f"seed-{how.seed + i}" for i in range(how.seeds)]
    _claim(places, resume, overwrite)
    start = None if how.start is None else Policy.load(file_of(how.start))
    rules = rules_of(source, how, step)
    taught = []
    for i, place in enumerate(places):
        place.mkdir(parents=True, exist_ok=True)
        seed = how.seed + i
        training = Training(
            rules,
            place,
            seed=seed,
            goal=how.goal,
            max_decisions=how.steps,
            device=how.device,
            start=start,
            jobs=how.jobs if how.jobs > 0 else cpu_count(),
        )
        with closing(training):
            training.run(lambda row, seed=seed: tell(seed, row))
        taught.append(Taught(seed, place, training.reached, training.curve[-1]))
    if len(taught) > 1:
        write_spread(folder / SPREAD, [place / "curve.csv" for place in places])
    return tuple(taught)


def write_spread(path: Path, curves: list[Path]) -> None:
    """Write the learning curves of several seeds as one: means and standard deviations.

    A row is of all seeds that still learned then: so many of them, their decisions, reward and
    falls per minute.

    Args:
        curves: Those of the seeds, ``curve.csv``.

    Raises:
        FileError: If one cannot be read, or the file not be written.
    """
    tables = [list(csv.DictReader(read_text(curve).splitlines())) for curve in curves]
    rows = []
    for k in range(max(map(len, tables))):
        there = [table[k] for table in tables if k < len(table)]
        row: dict[str, Any] = {"decisions": there[0]["decisions"], "seeds": len(there)}
        for name in ("reward", "falls_per_minute"):
            values = np.array([float(each[name]) for each in there])
            sd = float(values.std(ddof=1)) if len(values) > 1 else None
            row |= {name: float(values.mean()), f"{name}_sd": sd}
        rows.append(row)
    write_text(path, csv_text(list(rows[0]), (list(row.values()) for row in rows)))


def rules_of(source: Any, how: TrainSettings, step: Step = silent) -> Rules:
    """Return the rules of the episodes that settings ask for.

    A stride that is even to both sides is learned for one side only, in the form ``lean``.

    Raises:
        ParameterError: If a run is given, and a person too, or it cannot be followed.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.
    """
    reference = _reference(source, how, step)
    clearance = how.clearance
    if clearance is None:
        clearance = TERRAIN_CLEARANCE if how.terrain and reference.cyclic else 0.0
    if clearance:
        reference = reference.cleared(0.01 * clearance)
    lean = how.form == "lean"
    if how.landing and not lean:
        raise ParameterError("landing needs form=lean")
    return Rules(
        reference=reference,
        form=how.form,
        gains=how.gains == "variable",
        ground=how.ground or "flat",
        base=LANDING_GAINS if how.landing else None,
        weights=LANDING_WEIGHTS if how.landing else None,
        terrain=0.01 * how.terrain,
        pushes=how.pushes,
        passive=lean,
        mirrored=bool(lean and asymmetry(reference) < MAX_ASYMMETRY),
    )


def _reference(source: Any, how: TrainSettings, step: Step) -> ReferenceMotion:
    if source is None:
        how.refuse(OF_RECORDINGS, "without a recording to fit; name one")
        return ReferenceMotion.textbook(Human.create(**{**PAPER_PERSON, **how.known}))
    if not isinstance(source, Run):
        path = as_path(source, "what is followed")
        if not path.is_dir():
            return ReferenceMotion.of(fit_trial(path, how, step)[1].record())
    how.refuse_person()
    how.refuse(OF_RECORDINGS, "on a run; name the recording")
    return ReferenceMotion.of(source)


def _claim(places: list[Path], resume: bool, overwrite: bool) -> None:
    """Refuse to lose a training; remove what is to be replaced."""
    if resume:
        return
    there = [p / name for p in places for name in FILES if (p / name).exists()]
    if there and not overwrite:
        raise RunExists(
            f"{there[0].parent} holds a training: add --resume to take it up, --overwrite to "
            "replace it, or name another --out"
        )
    for file in there:
        file.unlink()
