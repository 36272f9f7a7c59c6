"""Many motions synthesised: tasks, task files, recordings to track, options in all combinations."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.options import as_path
from plantigrade.pages.batch import MOTIONS
from plantigrade.record import Run
from plantigrade.record.inputs import names_of
from plantigrade.record.jobs import Workers
from plantigrade.signatures import takes
from plantigrade.workflows.batch import Batch, BatchSettings, Plan
from plantigrade.workflows.batch_items import Item, ItemGroup, content_key
from plantigrade.workflows.fit_many import contents_of
from plantigrade.workflows.motions import RECORDING, SYNTHESIS_OPTIONS, run_synthesis
from plantigrade.workflows.settings import TRACK
from plantigrade.workflows.variants import checked_values, combinations, name_of, plain


@takes(BatchSettings, more=SYNTHESIS_OPTIONS)
def synthesize_many(
    tasks: str | Path | Sequence[str | Path],
    *,
    vary: Mapping[str, Sequence[Any]] | None = None,
    **options: Any,
) -> Batch:
    """Synthesise many motions; iterate over the batch for results as they arrive.

    Args:
        tasks: Tasks or task files, as for :func:`~plantigrade.workflows.motions.synthesize`.
        vary: Option → its values; every combination is made, of every task. ``recording`` may
            vary for ``"track"``.
        options: Fields of ``BatchSettings``, and options that all motions have in common.

    Raises:
        ParameterError: If there is no task, or an option has no values or a value twice.
        RunExists: If the folder holds anything else.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> import plantigrade as pg
        >>> batch = pg.synthesize_many(  # doctest: +SKIP
        ...     "walk", vary={"speed": [0.8, 1.2, 1.6]}, periodic=True, jobs=-1
        ... )
        >>> batch.to_dataframe()["cost_of_transport"]  # doctest: +SKIP
    """
    where, options = BatchSettings.split(options)
    given = [tasks] if isinstance(tasks, str | Path) else list(tasks)
    return synthesize_batch(given, vary or {}, options, where)


def synthesize_batch(
    given: Sequence[str | Path],
    vary: Mapping[str, Sequence[Any]],
    options: Mapping[str, Any],
    where: BatchSettings,
    *,
    command: str = "",
) -> Batch:
    """Return the batch of tasks in all combinations; ``command`` is for the provenance."""
    if not given:
        raise ParameterError("no task is given to be synthesised")
    words = [str(as_path(task, "a task")) for task in given]
    axes = {name: checked_values(name, values) for name, values in vary.items()}
    every = combinations(axes, "motions")
    names = _names(words, every)
    plan = Plan(
        MOTIONS,
        work=partial(_made, options, command),
        groups=partial(_groups, words, every, names, options),
        names=names,
        spec={"method": "synthesize", "settings": plain(options)},
    )
    return Batch(plan, where, command)


def _names(words: Sequence[str], every: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a name for every motion: its task or file, and what it has of its own."""
    of_tasks = names_of([Path(word) for word in dict.fromkeys(words)])
    named = dict(zip(dict.fromkeys(words), of_tasks, strict=True))
    if len(named) < len(words):
        raise ParameterError("a task is given twice; give each once")
    found = []
    for word in words:
        for k, each in enumerate(every):
            shown = {n: Path(v).stem if isinstance(v, Path) else v for n, v in plain(each).items()}
            own = name_of(k, len(every), shown) if len(every) > 1 else ""
            found.append("-".join(filter(None, (named[word], own))))
    return found


def _groups(
    words: Sequence[str],
    every: Sequence[Mapping[str, Any]],
    names: Sequence[str],
    options: Mapping[str, Any],
    _: Workers,
) -> Iterator[ItemGroup]:
    common = _key(options)
    for i, (word, each) in enumerate(itertools.product(words, every)):
        file = Path(word).absolute() if word.lower().endswith(".toml") else None
        recording = each.get(RECORDING.name, options.get(RECORDING.name)) if word == TRACK else None
        source = file if recording is None else Path(recording).absolute()
        content = contents_of([source]) if source is not None else word
        key = content_key("synthesize", word if file is None else "", content, common, _key(each))
        task = word if file is None else str(file)
        shown = {name: value for name, value in plain(each).items() if name != RECORDING.name}
        yield ItemGroup((Item(names[i], i, key, (task, dict(each)), source, shown),))


def _key(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options with the content of the files that they name in place of their paths."""
    paths = {name: [value] for name, value in options.items() if isinstance(value, Path)}
    return {**plain(options), **{name: contents_of(files) for name, files in paths.items()}}


def _made(
    options: Mapping[str, Any], command: str, what: tuple[str, Mapping[str, Any]], _: None
) -> Run:
    task, own = what
    return run_synthesis(task, None, {**options, **own}, command=command)
