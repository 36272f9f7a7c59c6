"""Many simulations: recordings, seeds, pushes, grounds, controllers in all combinations."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from plantigrade.control.balance import script_named
from plantigrade.errors import ParameterError
from plantigrade.pages.batch import SIMULATIONS
from plantigrade.record import Run
from plantigrade.record.inputs import names_of
from plantigrade.record.jobs import Workers
from plantigrade.record.metrics import METRICS
from plantigrade.record.run import MODEL, MOTION
from plantigrade.signatures import takes
from plantigrade.workflows.batch import Batch, BatchSettings, Plan
from plantigrade.workflows.batch_items import Item, ItemGroup, content_key
from plantigrade.workflows.fit import run_fit
from plantigrade.workflows.fit_many import contents, contents_of, settings_key
from plantigrade.workflows.settings import FitSettings, RecordingSettings
from plantigrade.workflows.simulate import SIMULATION_OPTIONS, run_simulation
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulated_world import surroundings
from plantigrade.workflows.variants import OWN, name_of, plain, settings_of, variants
from plantigrade.world import Controller, Disturbance

FITTED = "fit"  #: Folder of the recording that was fitted; after its name where there are several

Source = Path | Run | None


@dataclass(frozen=True, eq=False)
class Variant:
    """Settings of one simulation of a batch."""

    shown: Mapping[str, Any]  #: Option → value, as a table shows it
    settings: SimulateSettings  #: Its settings
    controller: Controller | None  #: Its controller, where that is no word


class Simulations(Batch):
    """A batch of simulations."""

    @property
    def on_feet(self) -> int:
        """How many were on the feet at the end."""
        return int(self.metrics["on_feet_count"])

    @property
    def seeds_alike(self) -> bool:
        """Whether simulations that differ by their seed alone all came out the same."""
        found: dict[str, list[dict[str, Any]]] = {}
        for one in self.members:
            others = {name: value for name, value in one.varied.items() if name != "seed"}
            own = {n: v for n, v in one.row().items() if n not in ("name", "seed")}
            found.setdefault(f"{one.source} {others}", []).append(own)
        groups = [rows for rows in found.values() if len(rows) > 1]
        return bool(groups) and all(row == rows[0] for rows in groups for row in rows)


@takes(BatchSettings, more=SIMULATION_OPTIONS)
def simulate_many(
    source: str | Path | Run | None | Sequence[str | Path | Run] = None,
    settings: SimulateSettings | None = None,
    *,
    vary: Mapping[str, Sequence[Any]] | None = None,
    seeds: int = 1,
    disturbances: Sequence[Disturbance] = (),
    **options: Any,
) -> Simulations:
    """Simulate people many times, in all combinations of what varies, side by side.

    Iterate over the batch for results as they arrive.

    Args:
        source: As for :func:`~plantigrade.workflows.simulate.simulate`, or several of them; a
            recording is fitted once.
        settings: What all have in common; options replace its fields.
        vary: Option of ``settings`` → its values; a ``controller`` may be your own. Values of
            ``push``, ``rope`` and ``box`` are added to those of ``settings``; None adds nothing.
        seeds: Each combination with so many seeds, from that of ``settings`` on.
        disturbances: Disturbances of all simulations, in addition to those of ``settings``.
        options: Fields of ``BatchSettings`` and ``SimulateSettings``.

    Raises:
        ParameterError: If an option does not exist, or a value is not allowed.
        RunExists: If the folder holds anything else.
        FileError: If a file or run cannot be read.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> import plantigrade as pg
        >>> batch = pg.simulate_many(  # doctest: +SKIP
        ...     vary={"push": ["40,0.2,0,1", "80,0.2,0,1"]}, seeds=5, jobs=-1
        ... )
    """
    where, options = BatchSettings.split(options)
    how = SimulateSettings.given("simulate_many", settings, options)
    return simulate_batch(source, how, vary or {}, seeds, where, disturbances=disturbances)


def simulate_batch(
    source: str | Path | Run | None | Sequence[str | Path | Run],
    how: SimulateSettings,
    vary: Mapping[str, Sequence[Any]],
    seeds: int,
    where: BatchSettings,
    *,
    disturbances: Sequence[Disturbance] = (),
    command: str = "",
) -> Simulations:
    """Return the batch of all combinations and seeds; ``command`` is for the provenance.

    Raises:
        ParameterError: If a value is not allowed.
    """
    sources = _sources(source)
    every = variants(how, vary, seeds, standing=sources == [None])
    made = [Variant(plain(each), *settings_of(how, each)) for each in every]
    for each in made:
        surroundings(each.settings)  # refuses what is no ground, push or motion, before any work
        if each.settings.motion is not None:
            script_named(each.settings.motion)
    if any(isinstance(each, Path) and each.is_dir() for each in sources):
        how.refuse_person()
    named = _names(sources)
    names = [_name(named[i], k, made) for i in range(len(sources)) for k in range(len(made))]
    fits = [_fit_name(name) for name, each in zip(named, sources, strict=True)
            if _is_recording(each) and len(made) > 1]  # fmt: skip
    place = None
    if where.out is not None and not where.collect:
        place = Path(where.out).expanduser().absolute()
    plan = Plan(
        SIMULATIONS,
        work=partial(_simulated, tuple(disturbances), command),
        begin=partial(_begun, place, how, command),
        groups=partial(_groups, sources, named, made, tuple(disturbances)),
        names=names,
        spec={
            "method": "simulate",
            "settings": how.plain(),
            "varied": [dict(each.shown) for each in made],
        },
        default="runs",
        folders=fits,
    )
    return Simulations(plan, where, command)


def _sources(source: Any) -> list[Source]:
    given: list[Any] = [source]
    if isinstance(source, Iterable) and not isinstance(source, str | Path):
        given = list(source)
    if not given:
        raise ParameterError("no recording or run is given to be simulated")
    return [each if each is None or isinstance(each, Run) else Path(each).expanduser().absolute()
            for each in given]  # fmt: skip


def _is_recording(source: Source) -> bool:
    return isinstance(source, Path) and not source.is_dir()


def _names(sources: Sequence[Source]) -> list[str]:
    """Return a name for each source; an empty one where it is the only one."""
    if len(sources) == 1:
        return [""]
    paths = [Path(each.name or each.kind) if isinstance(each, Run) else each or Path("standing")
             for each in sources]  # fmt: skip
    return names_of(paths)


def _name(source: str, k: int, made: Sequence[Variant]) -> str:
    """Return the name of a simulation."""
    if source and len(made) == 1:
        return source
    own = name_of(k, len(made), made[k].shown)
    return f"{source}-{own}" if source else own


def _fit_name(name: str) -> str:
    return f"{name}-{FITTED}" if name else FITTED


def _groups(
    sources: Sequence[Source],
    named: Sequence[str],
    made: Sequence[Variant],
    disturbances: Sequence[Disturbance],
    _: Workers,
) -> Iterator[ItemGroup]:
    """Yield the simulations of each source together."""
    acting = [repr(each) for each in disturbances]
    for i, source in enumerate(sources):
        once = _is_recording(source) and len(made) > 1
        content = _content(source, made[0].settings)
        items = []
        for k, each in enumerate(made):
            what = each
            if source is not None and (once or not _is_recording(source)):
                own = {name: getattr(each.settings, name) for name in OWN}
                what = replace(each, settings=SimulateSettings(**own))
            key = content_key(
                "simulate", content, settings_key(each.settings), dict(each.shown), acting
            )
            items.append(
                Item(
                    name=_name(named[i], k, made),
                    number=i * len(made) + k,
                    key=key,
                    what=what,
                    source=source if isinstance(source, Path) else None,
                    varied=each.shown,
                )
            )
        if once:
            yield ItemGroup(tuple(items), begin=(source, _fit_name(named[i])))
        else:
            yield ItemGroup(tuple(items), start=source)


def _content(source: Source, settings: SimulateSettings) -> Any:
    """Return what identifies the content of a source."""
    if source is None:
        return None
    if isinstance(source, Run):
        return content_key(source.metrics, source.record.motion.qpos)
    if source.is_dir():
        return contents_of([source / name for name in (MODEL, MOTION, METRICS)])
    return contents(source, settings)


def _begun(
    place: Path | None, how: SimulateSettings, command: str, begin: tuple[Path, str]
) -> Path | Run:
    """Return the fit of a recording: its folder if it can be kept there."""
    source, name = begin
    if place is not None and (place / name / METRICS).is_file():
        return place / name
    run = run_fit(source, FitSettings(**vars(RecordingSettings.of(how))), command=command)
    if place is None:
        return run
    return run.save(place / name, overwrite=True).folder or place / name


def _simulated(
    disturbances: Sequence[Disturbance], command: str, what: Variant, start: Source
) -> Run:
    return run_simulation(
        start, what.settings, controller=what.controller, disturbances=disturbances, command=command
    )
