"""Many simulations: seeds, pushes, grounds, controllers in all combinations, and one table of them.

A batch in a folder can be stopped and taken up again: what is there is not simulated anew.
"""

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from plantigrade import __version__
from plantigrade.control.balance import script_named
from plantigrade.errors import FileError, ParameterError, RunExists
from plantigrade.extras import require
from plantigrade.options import as_path
from plantigrade.record import Run
from plantigrade.record.folder import (
    FORMAT,
    METRICS,
    metrics_json,
    read_metrics,
    refuse_existing,
    replace_file,
    replace_files,
)
from plantigrade.record.jobs import run_jobs
from plantigrade.record.provenance import source_files
from plantigrade.report.batch_table import PAGE, TABLE, Simulated, table_csv, table_html
from plantigrade.workflows.beginning import around
from plantigrade.workflows.fit import Step, fit, silent
from plantigrade.workflows.settings import RecordingSettings
from plantigrade.workflows.simulate import simulate
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.variants import OWN, name_of, plain, settings_of, variants
from plantigrade.world import Controller, Disturbance

KIND = "simulations"
"""Kind of a folder that holds a batch."""
FITTED = "fit"
"""Its folder of the recording that was fitted."""


@dataclass(frozen=True, eq=False)
class Batch:
    """What came of many simulations.

    Attributes:
        members: Every one of them, in order.
        folder: Where they lie, with ``table.html`` and ``table.csv``; None where nothing is kept.
    """

    members: tuple[Simulated, ...]
    folder: Path | None = None

    @property
    def status(self) -> str:
        """``"ok"``, or how many could not be simulated; a fall is a result."""
        bad = sum(bool(one.problem) or "diverged_at_s" in one.metrics for one in self.members)
        return f"{bad} of {len(self.members)} simulations failed or diverged" if bad else "ok"

    @property
    def on_feet(self) -> int:
        """How many were on the feet at the end."""
        return sum(bool(one.metrics.get("on_feet")) for one in self.members)

    @property
    def seeds_alike(self) -> bool:
        """Whether simulations that differ by their seed alone all came out the same."""
        found: dict[str, list[dict[str, Any]]] = {}
        for one in self.members:
            others = {name: value for name, value in one.varied.items() if name != "seed"}
            own = {n: v for n, v in one.row().items() if n not in ("name", "seed")}
            found.setdefault(str(others), []).append(own)
        groups = [rows for rows in found.values() if len(rows) > 1]
        return bool(groups) and all(row == rows[0] for rows in groups for row in rows)

    def to_dataframe(self) -> Any:
        """Return the table as a pandas DataFrame, one row a simulation.

        Raises:
            MissingExtra: If pandas is not installed.
        """
        rows = [one.row() for one in self.members]
        return require("pandas", "tables").DataFrame(rows).set_index("name")


@dataclass(frozen=True, eq=False)
class Task:
    """One simulation of a batch; it travels to where it is computed."""

    name: str
    varied: Mapping[str, Any]
    settings: SimulateSettings
    source: Path | Run | None
    controller: Controller | None
    disturbances: tuple[Disturbance, ...]
    folder: Path | None
    command: str


def simulate_many(
    source: str | Path | Run | None = None,
    settings: SimulateSettings | None = None,
    *,
    vary: Mapping[str, Sequence[Any]] | None = None,
    seeds: int = 1,
    disturbances: Sequence[Disturbance] = (),
    out: str | Path | None = None,
    overwrite: bool = False,
    jobs: int = 1,
    backend: str = "loky",
    address: str | None = None,
    say: Callable[[str], None] = lambda _: None,
    step: Step = silent,
    command: str = "",
    **options: Any,
) -> Batch:
    """Simulate a person many times, in all combinations of what varies, side by side.

    Args:
        source: As for :func:`~plantigrade.workflows.simulate.simulate`; a recording is fitted once.
        settings: What all have in common.
        vary: Option of ``settings`` → its values; a ``controller`` may be your own. Values of
            ``push``, ``rope`` and ``box`` come beside those of ``settings``; None is nothing.
        seeds: Each combination with so many seeds, from that of ``settings`` on.
        disturbances: What acts on all of them beside.
        out: Folder for the runs and the table. What it holds of the same batch is not simulated
            anew. Without it the runs come back in memory.
        overwrite: Replace a batch that is there.
        jobs: How many at once; -1 for one per core.
        backend: as for :func:`~plantigrade.record.jobs.run_jobs`.
        address: Of a running cluster (ray, dask).
        say: Called with one line for every simulation that has ended.
        step: Shows progress of the fit.
        command: The command line, for the provenance.
        options: Fields of ``settings`` by name; they replace those of ``settings``.

    Raises:
        ParameterError: If an option does not exist, or a value is not allowed.
        RunExists: If the folder holds anything else.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> import plantigrade as pg
        >>> batch = pg.simulate_many(  # doctest: +SKIP
        ...     vary={"push": ["40,0.2,0,1", "80,0.2,0,1"]}, seeds=5, jobs=-1
        ... )
    """
    how = SimulateSettings.given("simulate_many", settings, options)
    every = variants(how, vary or {}, seeds, standing=source is None)
    made = [settings_of(how, each) for each in every]
    for each, _ in made:
        around(each)  # refuses what is no ground, push or motion, before any work
        if each.motion is not None:
            script_named(each.motion)
    shown = [plain(each) for each in every]
    folder = None if out is None else as_path(out, "the folder of a batch").expanduser()
    names = [name_of(i, len(made), each) for i, each in enumerate(shown)]
    if folder is not None:
        _claim(folder, _spec(source, how, shown), names, command, overwrite)
    begin = _begin(source, how, folder, step, command)
    tasks = []
    for i, (each, controller) in enumerate(made):
        name = names[i]
        if source is not None:  # the person is fitted, or that of the run
            each = SimulateSettings(**{own: getattr(each, own) for own in OWN})
        place = None if folder is None else folder / name
        task = Task(name, shown[i], each, begin, controller, tuple(disturbances), place, command)
        tasks.append(task)
    run = partial(run_jobs, jobs=jobs, backend=backend, address=address)
    batch = Batch(_simulated(tasks, run, say), folder)
    if folder is not None:
        _write(batch, _spec(source, how, shown), command)
    return batch


def _simulated(
    tasks: Sequence[Task], run: Callable[..., Any], say: Callable[[str], None]
) -> tuple[Simulated, ...]:
    """Return what came of every task; what lies in its folder is read."""
    found: dict[str, Simulated] = {}
    for task in tasks:
        if task.folder is not None and (task.folder / METRICS).is_file():
            metrics = read_metrics(task.folder)
            if not _is_result_of(task, metrics):
                raise RunExists(
                    f"{task.folder} holds a simulation with other settings: choose another folder "
                    "with --out, or add --overwrite"
                )
            found[task.name] = Simulated(task.name, task.varied, metrics)
    if found:
        say(f"{len(found)} of {len(tasks)} were there")
    left = [task for task in tasks if task.name not in found]
    for done in run(_simulate, left):
        task = done.item
        if done.result is None:
            one = Simulated(task.name, task.varied, problem=done.problem)
        else:
            metrics, result = done.result
            one = Simulated(task.name, task.varied, metrics, run=result)
        found[task.name] = one
        ended = "on the feet" if one.status == "ok" else one.status
        say(f"{len(found)} of {len(tasks)}: {task.name}: {ended}")
    return tuple(found[task.name] for task in tasks)


def _is_result_of(task: Task, metrics: Mapping[str, Any]) -> bool:
    """Return whether figures that were found are of this task and of this version."""
    settings = json.loads(metrics_json(task.settings.plain()))
    return metrics.get("settings") == settings and metrics.get("version") == __version__


def _simulate(task: Task) -> tuple[dict[str, Any], Run | None]:
    """Return the figures of one simulation, and the run unless it is kept in a folder."""
    run = simulate(
        task.source,
        task.settings,
        controller=task.controller,
        disturbances=task.disturbances,
        command=task.command,
    )
    if task.folder is None:
        return run.metrics, run
    return replace(run, name=task.name).save(task.folder).metrics, None


def _begin(
    source: Any, how: SimulateSettings, folder: Path | None, step: Step, command: str
) -> Path | Run | None:
    """Return what every simulation starts from; a recording is fitted, once."""
    if source is None or isinstance(source, Run):
        return source
    path = as_path(source, "what is simulated")
    if path.is_dir():
        if how.known:
            raise ParameterError(
                f"a run defines its own person: leave out {', '.join(how.known)}, or name the "
                "recording"
            )
        return path.absolute()
    if folder is not None and (folder / FITTED / METRICS).is_file():
        return (folder / FITTED).absolute()
    fitted = fit(path, step=step, command=command, **vars(RecordingSettings.of(how)))
    if folder is None:
        return fitted
    fitted.save(folder / FITTED)
    return (folder / FITTED).absolute()


def _spec(source: Any, how: SimulateSettings, shown: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what two batches have in common if they are the same."""
    files: dict[str, str] = {}
    if isinstance(source, str | Path) and str(source):
        path = Path(source).expanduser()
        files = source_files([path / METRICS if path.is_dir() else path])
    settings = {k: list(v) if isinstance(v, tuple) else v for k, v in how.plain().items()}
    return {
        "version": __version__,
        "settings": settings,
        "source_files": files,
        "simulations": [dict(each) for each in shown],
    }


def _claim(
    folder: Path, spec: Mapping[str, Any], names: Sequence[str], command: str, overwrite: bool
) -> None:
    """Make the folder of a batch, or take up the same batch where it was left.

    Where its ``metrics.json`` was cut off, the batch is known by the names of its members.

    Raises:
        RunExists: If it holds anything else.
    """
    if (folder / METRICS).is_file() and not overwrite:
        try:
            held = read_metrics(folder)
        except FileError:
            within = {item.name for item in folder.iterdir() if item.is_dir()}
            held = {"kind": KIND, **spec} if within and within <= {FITTED, *names} else {}
        if held.get("kind") == KIND:
            if {key: held.get(key) for key in spec} == spec:
                return
            raise RunExists(
                f"{folder} holds another batch: choose another folder with --out, or add "
                "--overwrite"
            )
    if folder.exists():
        refuse_existing(folder, overwrite)
        shutil.rmtree(folder)
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise FileError(folder, f"cannot be written ({error.strerror or error})") from error
    begun = {"status": "not finished; run the same command to continue", "command": command}
    replace_file(folder / METRICS, _metrics_of(begun | dict(spec), (), names))


def _metrics_of(found: Mapping[str, Any], files: Sequence[str], names: Sequence[str]) -> str:
    """Return ``metrics.json`` of a batch with these files and members."""
    marked = {"format": FORMAT, "kind": KIND, **found, "files": list(files)}
    return metrics_json({**marked, "folders": [FITTED, *names]}) + "\n"


def _write(batch: Batch, spec: Mapping[str, Any], command: str) -> None:
    """Write the table of a batch into its folder."""
    assert batch.folder is not None
    members = batch.members
    provenance = {key: spec[key] for key in ("version", "settings", "source_files")}
    provenance["command"] = command
    page = table_html(
        members, status=batch.status, provenance=provenance, title="Batch of simulations"
    )
    figures = {
        "simulations_count": len(members),
        "on_feet_count": batch.on_feet,
        "failed_count": sum(bool(one.problem) for one in members),
        "diverged_count": sum("diverged_at_s" in one.metrics for one in members),
        "members": {one.name: one.row() for one in members},
    }
    found = {"status": batch.status, "command": command, **spec, **figures}
    marked = _metrics_of(found, (PAGE, TABLE), [one.name for one in members])
    replace_file(batch.folder / METRICS, marked)
    replace_files(batch.folder, {PAGE: page, TABLE: table_csv(members)})
