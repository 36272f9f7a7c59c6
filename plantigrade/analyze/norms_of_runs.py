"""Norms from the runs of several people, each with the mean of its cycles."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from plantigrade.analyze.clinical import known_curves
from plantigrade.analyze.curves import gait_curves
from plantigrade.analyze.feet import progress_in_stance
from plantigrade.analyze.norms import Population
from plantigrade.analyze.own_norms import NAMES, own_population, read_norms_file
from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.record import Record, Run
from plantigrade.record.metrics import METRICS
from plantigrade.record.run import MOTION
from plantigrade.side_names import without_side

MIN_PEOPLE = 2  # Minimum number of people for a standard deviation


def read_norms(path: str | Path) -> Population:
    """Return the norms of a file, or of the runs in a folder.

    Raises:
        FileError: If the file, or a run, cannot be read.
        ParameterError: If the folder holds fewer than two runs of people who walk.
    """
    path = Path(path).expanduser()
    return norms_of_folder(path)[0] if path.is_dir() else read_norms_file(path)


def norm_files(path: str | Path | None) -> list[Path]:
    """Return the files that :func:`read_norms` reads: the table, or the motions of the runs."""
    if path is None:
        return []
    path = Path(path).expanduser()
    return [run / MOTION for run in run_folders(path)] if path.is_dir() else [path]


def run_folders(folder: Path) -> list[Path]:
    """Return the run folders in a folder or batch, or the folder itself if it is a run."""
    inside = [folder] if (folder / MOTION).exists() else sorted(folder.iterdir())
    return [place for place in inside if all((place / n).is_file() for n in (METRICS, MOTION))]


def norms_of_folder(*folders: str | Path) -> tuple[Population, dict[str, str]]:
    """Return the norms of the runs in folders, or of run folders, with one run per person.

    Runs that are not ok, of backward walking, or without a complete gait cycle are excluded.

    Returns:
        The norms, and for each excluded run the reason.
    """
    found: dict[str, Run] = {}
    for folder in map(Path, folders):
        if not folder.is_dir():
            raise FileError(folder, "is no folder", remedy="name a folder that holds run folders")
        found |= {str(each): Run.load(each) for each in run_folders(folder)}
    excluded = {name: why for name, run in found.items() if (why := reason_excluded(run))}
    found = {name: run for name, run in found.items() if name not in excluded}
    where = ", ".join(map(str, folders))
    if excluded and len(found) < MIN_PEOPLE:
        reasons = "; ".join(f"{name}: {why}" for name, why in excluded.items())
        raise ParameterError(
            f"norms need runs of at least {MIN_PEOPLE} people, {len(found)} can be used; {reasons}"
        )
    sources: dict[tuple, str] = {}
    for name, run in found.items():
        key = tuple(run.provenance.source_files.values())
        if key and key in sources:
            raise ParameterError(
                f"{name} and {sources[key]} are runs of one recording; norms need one run per "
                "person: move one elsewhere"
            )
        sources[key] = name
    people = f"{len(found)} people: the runs in {', '.join(Path(f).name for f in folders)}"
    if excluded:
        people += f" without {', '.join(Path(name).name for name in excluded)}"
    return norms_of({name: run.record for name, run in found.items()}, people, where), excluded


def reason_excluded(run: Run) -> str:
    """Return the reason why a run is excluded from norms; empty if it is not.

    An example is ``"its status is not ok: the markers are 31 mm off"``.
    """
    if not run.ok:
        return f"its status is not ok: {run.status}"
    if not gait_curves(run.record).cycles:
        return "it has no complete gait cycle"
    if progress_in_stance(run.record.human, run.record.motion) < 0:
        return "it walks backward"
    return ""


def norms_of(records: Mapping[str, Record], people: str, where: str = "") -> Population:
    """Return mean and SD, over the people of records, of the curves that all have."""
    if len(records) < MIN_PEOPLE:
        raise ParameterError(
            f"norms need runs of at least {MIN_PEOPLE} people; {where or 'this'} holds "
            f"{len(records)}: name a folder that holds run folders"
        )
    means = {name: person_curves(record) for name, record in records.items()}
    still = [name for name, curves in means.items() if not curves]
    if still:
        raise ParameterError(
            f"{', '.join(still)}: no complete gait cycle; move runs without walking elsewhere"
        )
    shared = [n for n in NAMES if all(n in curves for curves in means.values())]
    curves = {}
    for name in shared:
        rows = np.array([each[name] for each in means.values()])
        curves[name] = rows.mean(axis=0), rows.std(axis=0, ddof=1)
    return own_population(curves, people)


def person_curves(record: Record) -> dict[str, Float[Array, " n_percent"]]:
    """Return the curves of one person without side, as the mean of cycles and then of sides."""
    curves = gait_curves(record)
    if not curves.cycles:
        return {}
    sides: dict[str, list[Array]] = {}
    for name, values in known_curves(record, curves).items():
        sides.setdefault(without_side(name), []).append(np.nanmean(values, axis=0))
    return {name: np.mean(both, axis=0) for name, both in sides.items() if name in NAMES}
