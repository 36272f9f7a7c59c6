"""Many gaits reproduced: a batch, and a study with statistics and the paper's table."""

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from plantigrade.analyze.reproduction import compare
from plantigrade.errors import ParameterError
from plantigrade.pages.batch import REPRODUCED
from plantigrade.record import Run
from plantigrade.record.batch import BatchFolder
from plantigrade.record.inputs import Inputs, names_of
from plantigrade.record.jobs import Workers
from plantigrade.signatures import takes
from plantigrade.workflows.batch import Batch, BatchSettings, Concluded, Plan
from plantigrade.workflows.batch_items import Group, Item, content_key
from plantigrade.workflows.fit_many import contents, recordings, settings_key
from plantigrade.workflows.reproduce import run_reproduction
from plantigrade.workflows.settings import ReproduceSettings
from plantigrade.workflows.study import GaitStudy, Member, study_files


@takes(BatchSettings, ReproduceSettings)
def reproduce_many(
    paths: str | Path | Inputs | Iterable[str | Path],
    settings: ReproduceSettings | None = None,
    **options: Any,
) -> Batch:
    """Reproduce many recorded gaits; iterate over the batch for results as they arrive.

    In a folder the statistics of the gaits are written too: ``study.html``, and ``study.csv`` with
    the paper's Table I.

    Args:
        paths: Files, folders or patterns (``"data/**/*.c3d"``).
        settings: What decides the result of each; options replace its fields.
        options: Fields of ``BatchSettings`` and ``ReproduceSettings``.

    Raises:
        ParameterError: If an option does not exist, a value is not allowed, or there is no
            recording.
        RunExists: If the folder holds anything else.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> import plantigrade as pg
        >>> batch = pg.reproduce_many("walks/", jobs=-1, out="runs/study")  # doctest: +SKIP
        >>> batch.metrics["counted_count"]  # doctest: +SKIP
    """
    where, options = BatchSettings.split(options)
    how = ReproduceSettings.given("reproduce_many", settings, options)
    return reproduce_batch(recordings(paths), how, where)


def reproduce_batch(
    given: Inputs, how: ReproduceSettings, where: BatchSettings, *, command: str = ""
) -> Batch:
    """Return the batch of recordings that are reproduced; ``command`` is for the provenance."""
    if where.keep == "figures":
        raise ParameterError("a study compares whole gaits: keep runs or pages, not figures")
    plan = Plan(
        REPRODUCED,
        work=partial(_reproduced, how, command),
        groups=partial(_groups, given, how),
        names=names_of(given.files),
        spec={"method": "reproduce", "settings": how.plain()},
        passes_over=("FitError", "NothingToFit", "ReproduceError", "FileError"),
        conclude=partial(_study, how, command),
    )
    return Batch(plan, where, command)


def _reproduced(settings: ReproduceSettings, command: str, path: Path, _: None) -> Run:
    return run_reproduction(path, settings, command=command)


def _groups(given: Inputs, settings: ReproduceSettings, _: Workers) -> Iterator[Group]:
    decided = settings_key(settings)
    for i, (name, path) in enumerate(zip(names_of(given.files), given.files, strict=True)):
        place = path.absolute()
        key = content_key("reproduce", decided, contents(place, settings))
        yield Group((Item(name, i, key, place, place, named=path in given.named),))


def _study(
    settings: ReproduceSettings, command: str, store: BatchFolder, counts: Mapping[str, Any]
) -> Concluded:
    """Return pages, figures and Table I of the study of the gaits in the folder of a batch."""
    members, left_out = [], {}
    for row in store.rows():
        if row.failed:
            left_out[row.file] = row.status
            continue
        run = Run.load(store.path / row.name)
        members.append(Member(row.name, Path(row.file), compare(run.record), run.metrics))
    found = GaitStudy(tuple(members), left_out)
    pages = study_files(found, str(counts["status"]), settings, command)
    return Concluded(pages, found.metrics(), found.table_text())
