"""Many recordings fitted: one table, one body for the trials of a subject."""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from plantigrade.analyze.norms_of_runs import norm_files
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.io import format_of
from plantigrade.io.asf import find_asf
from plantigrade.io.companions import candidates
from plantigrade.kinematics.scaled_body import Shared
from plantigrade.pages.batch import FITS
from plantigrade.record import Run
from plantigrade.record.inputs import Inputs, inputs, names_of
from plantigrade.record.jobs import Workers
from plantigrade.record.provenance import sha256_of
from plantigrade.signatures import takes
from plantigrade.workflows.batch import Batch, BatchSettings, Plan
from plantigrade.workflows.batch_items import Item, ItemGroup, content_key
from plantigrade.workflows.fit import run_fit
from plantigrade.workflows.one_subject import by_subject, share
from plantigrade.workflows.settings import FitSettings, Settings

Subjects = Literal["auto", "one", "each"]
"""Grouping of recordings by subject: by name and marker distances, all together, or none."""
FILES_AHEAD = 512
"""Files that are looked at together to find those of one subject: enough for all workers."""


@takes(BatchSettings, FitSettings)
def fit_many(
    paths: str | Path | Inputs | Iterable[str | Path],
    settings: FitSettings | None = None,
    *,
    subject: Subjects = "auto",
    **options: Any,
) -> Batch:
    """Fit many recordings; iterate over the batch for results as they arrive.

    Args:
        paths: Files, folders or patterns (``"data/**/*.c3d"``).
        settings: What decides the result of each; options replace its fields.
        subject: Grouping of the recordings: trials of one subject share lengths, marker places and
            body mass. ``"auto"`` finds them, ``"one"`` takes all as one subject's, ``"each"`` fits
            every recording on its own.
        options: Fields of ``BatchSettings`` and ``FitSettings``.

    Raises:
        ParameterError: If an option does not exist, a value is not allowed, there is no recording,
            or recordings of one subject (``"one"``) contradict each other.
        RunExists: If the folder holds anything else.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> import plantigrade as pg
        >>> batch = pg.fit_many("data/", jobs=-1, out="runs/all")  # doctest: +SKIP
        >>> for result in batch:  # doctest: +SKIP
        ...     print(result.name, result.status, result.figures.get("walking_speed_m_s"))
        >>> batch.to_dataframe()["knee_angle_r_rom_deg"].describe()  # doctest: +SKIP
    """
    where, options = BatchSettings.split(options)
    how = FitSettings.given("fit_many", settings, options)
    return fit_batch(recordings(paths), how, where, subject=subject)


def fit_batch(
    given: Inputs,
    how: FitSettings,
    where: BatchSettings,
    *,
    subject: Subjects = "auto",
    command: str = "",
) -> Batch:
    """Return the batch of recordings that are fitted; ``command`` is for the provenance."""
    every = _Recordings(given, names_of(given.files), how, settings_key(how))
    if subject == "each" or how.model is not None:  # a model of their own is shared already
        groups = partial(_groups, every, None)
    elif subject == "auto":
        groups = partial(_groups, every, partial(_by_subject, given.files))
    else:
        groups = partial(_one_group, every, _of_one_subject(given.files, how))
    plan = Plan(
        FITS,
        work=partial(_fitted, how, command),
        begin=partial(_begun, how),
        groups=groups,
        names=every.names,
        spec={"method": "fit", "settings": {**how.plain(), "subject": subject}},
    )
    return Batch(plan, where, command)


def recordings(
    words: str | Path | Inputs | Iterable[str | Path], listed: str | Path | None = None
) -> Inputs:
    """Return the recordings that files, folders, patterns and a list of them stand for.

    Raises:
        ParameterError: If there is none, or one is named twice.
        FileError: If the list cannot be read.
    """
    if isinstance(words, Inputs):
        return words
    words = [words] if isinstance(words, str | Path) else words
    return inputs(words, fits=lambda path: format_of(path).name != "npz", listed=listed)


def _fitted(settings: FitSettings, command: str, path: Path, start: Any) -> Run:
    shared, problem = (None, "") if start is None else start
    run = run_fit(path, settings, command=command, shared=shared)
    if not problem:
        return run
    notes = (f"fitted on its own: {problem}", *run.record.notes)
    return replace(run, record=replace(run.record, notes=notes))


def _begun(settings: FitSettings, paths: Sequence[Path]) -> tuple[Shared | None, str]:
    """Return what trials of one subject share, or why they are fitted each on its own."""
    try:
        return share(paths, settings), ""
    except PlantigradeError as error:
        return None, str(error)


def _of_one_subject(paths: Sequence[Path], settings: FitSettings) -> Shared | None:
    """Return body and mass shared by recordings of one subject."""
    shared, problem = _begun(settings, [path.absolute() for path in paths])
    if problem:
        raise ParameterError(problem)
    return shared


@dataclass(frozen=True)
class _Recordings:
    """The recordings of a batch, with the hashes and names they have in common."""

    given: Inputs
    names: Sequence[str]
    settings: FitSettings
    decided: Mapping[str, Any]  #: Settings, with the content of files in place of their paths

    def items(self, indices: Sequence[int]) -> tuple[Item, ...]:
        """Return recordings of one subject as items.

        Their keys are content hashes of the recording, of all that may be its companions, of the
        subject's other recordings, and of the settings.
        """
        paths = [self.given.files[i].absolute() for i in indices]
        others = contents_of(paths)
        return tuple(
            Item(
                name=self.names[i],
                number=i,
                key=content_key("fit", self.decided, contents(path, self.settings), others),
                what=path,
                source=path,
                named=self.given.files[i] in self.given.named,
            )
            for i, path in zip(indices, paths, strict=True)
        )


def _one_group(every: _Recordings, shared: Shared | None, _: Workers) -> Iterator[ItemGroup]:
    yield ItemGroup(every.items(range(len(every.names))), start=(shared, ""))


def _groups(
    every: _Recordings,
    grouped: Callable[[Workers], Iterable[tuple[int, ...]]] | None,
    workers: Workers,
) -> Iterator[ItemGroup]:
    """Yield the recordings of each subject together."""
    alone = ((i,) for i in range(len(every.names)))
    for indices in alone if grouped is None else grouped(workers):
        items = every.items(indices)
        yield ItemGroup(items, [item.what for item in items] if len(items) > 1 else None)


def _by_subject(files: Sequence[Path], workers: Workers) -> Iterator[tuple[int, ...]]:
    """Yield which recordings are of one subject, folder by folder."""
    order = sorted(range(len(files)), key=lambda i: str(files[i].resolve().parent))
    held: list[int] = []
    for _, inside in groupby(order, key=lambda i: files[i].resolve().parent):
        held += inside
        if len(held) >= FILES_AHEAD:
            yield from _grouped(held, files, workers)
            held = []
    yield from _grouped(held, files, workers)


def _grouped(
    indices: Sequence[int], files: Sequence[Path], workers: Workers
) -> Iterator[tuple[int, ...]]:
    indices = sorted(indices)
    groups = by_subject([files[i] for i in indices], workers)
    together = {indices[k]: tuple(sorted(indices[i] for i in group))
                for group in groups for k in group}  # fmt: skip
    for i in indices:
        group = together.get(i, (i,))
        if group[0] == i:
            yield group


def contents(path: Path, settings: Settings) -> dict[str, str]:
    """Return name and SHA-256 of a recording and of all that may be its companions."""
    found = [path, *(candidates(path) if getattr(settings, "companions", False) else ())]
    if path.suffix.lower() == ".amc" and getattr(settings, "skeleton", None) is None:
        with contextlib.suppress(PlantigradeError):  # the item itself reports a missing skeleton
            found.append(find_asf(path))
    return {each.name: _sum(each) for each in found}


def contents_of(paths: Iterable[Path]) -> list[str]:
    """Return the SHA-256 of files, in any order."""
    return sorted(_sum(path) for path in paths)


def settings_key(settings: Settings) -> Mapping[str, Any]:
    """Return settings with the content of the files that they name in place of their paths."""
    plain = settings.plain()
    for name in plain:
        value = getattr(settings, name, None)
        if isinstance(value, Path):
            files = norm_files(value) if name == "norms" else [value]
            plain[name] = [_sum(Path(file)) for file in files]
    return plain


def _sum(path: Path) -> str:
    """Return the SHA-256 of a file; its path where it cannot be read, which its item will say."""
    try:
        stat = path.stat()
        return _cached_sum(path, stat.st_size, stat.st_mtime_ns)
    except (PlantigradeError, OSError):
        return str(path)


@cache
def _cached_sum(path: Path, size: int, changed: int) -> str:
    del size, changed  # they tell whether the sum still holds
    return sha256_of(path)
