"""Many gaits reproduced: a batch, and a study with statistics and the paper's table."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from plantigrade import __version__
from plantigrade.analyze.gait_study import Study, study
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.errors import ParameterError
from plantigrade.io.writing import csv_text
from plantigrade.pages.batch import REPRODUCED
from plantigrade.pages.study import StudyGait, study_html
from plantigrade.record import Run
from plantigrade.record.batch import BatchFolder
from plantigrade.record.inputs import Inputs, names_of
from plantigrade.record.jobs import Workers
from plantigrade.record.provenance import source_files
from plantigrade.signatures import takes
from plantigrade.workflows.batch import Batch, BatchSettings, Concluded, Plan
from plantigrade.workflows.batch_items import Item, ItemGroup, content_key
from plantigrade.workflows.fit_many import contents, recordings, settings_key
from plantigrade.workflows.reproduce import run_reproduction
from plantigrade.workflows.settings import ReproduceSettings

PAGE, TABLE = "study.html", "study.csv"


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


def _groups(given: Inputs, settings: ReproduceSettings, _: Workers) -> Iterator[ItemGroup]:
    decided = settings_key(settings)
    for i, (name, path) in enumerate(zip(names_of(given.files), given.files, strict=True)):
        place = path.absolute()
        key = content_key("reproduce", decided, contents(place, settings))
        yield ItemGroup((Item(name, i, key, place, place, named=path in given.named),))


def _study(
    settings: ReproduceSettings, command: str, store: BatchFolder, counts: Mapping[str, Any]
) -> Concluded:
    """Return pages, figures and Table I of the study of the gaits in the folder of a batch."""
    gaits, files, left_out = [], [], {}
    for row in store.rows():
        if row.failed:
            left_out[row.file] = row.status
            continue
        run = Run.load(store.path / row.name)
        comparison, files = compare(run.record), [*files, Path(row.file)]
        problem = _problem(run.metrics, comparison)
        gaits.append(StudyGait(row.name, problem, run.metrics, comparison, row.name))
    found = GaitStudy(tuple(gaits), left_out)
    pages = study_files(found, files, str(counts["status"]), settings, command)
    return Concluded(pages, found.metrics(), found.table_text())


def _problem(metrics: Mapping[str, Any], comparison: Comparison) -> str:
    """Return why a gait does not count in the statistics; nothing where it does."""
    if metrics["motion_status"] != "ok":
        return str(metrics["motion_status"])
    return "" if comparison.cycles else "it holds no complete gait cycle"


@dataclass(frozen=True)
class GaitStudy:
    """Several reproduced gaits."""

    members: tuple[StudyGait, ...]  #: Those that were reproduced
    left_out: dict[str, str]  #: Recording → why it could not be

    @property
    def counted(self) -> tuple[StudyGait, ...]:
        """Those whose angles count: a valid motion without forces, and a complete gait cycle."""
        return tuple(member for member in self.members if not member.problem)

    @cached_property
    def study(self) -> Study | None:
        """The statistics; None where no gait counts."""
        counted = self.counted
        if not counted:
            return None
        return study([m.name for m in counted], [m.comparison for m in counted])

    def metrics(self) -> dict[str, Any]:
        """Return the figures of the study."""
        found: dict[str, Any] = {
            "reproduced_count": len(self.members),
            "counted_count": len(self.counted),
        }
        if self.study is not None:
            found |= self.study.metrics()
        times = [m.metrics.get("seconds", {}) for m in self.counted]
        found["seconds"] = {
            key: sum(values) / len(values)
            for key in ("cycle", "tick_solver", "tick_kinematics")
            if (values := [time[key] for time in times if key in time])
        }
        return found

    def table_rows(self) -> tuple[list[str], list[list[Any]]]:
        """Return Table I as names of columns and rows of plain values; empty where none counts."""
        header = [
            "rotation", "coordinate", "simulated_deg", "simulated_sd_deg", "reference_deg",
            "reference_sd_deg", "difference_deg", "difference_abs_deg", "low_95_deg",
            "high_95_deg", "shapiro_p", "test", "p", "identical", "rmse_deg", "correlation",
            "paper_simulated_deg", "paper_reference_deg", "paper_difference_deg",
            "paper_identical",
        ]  # fmt: skip
        rows = [
            [
                r.label, r.coordinate, r.simulated, r.simulated_sd, r.reference, r.reference_sd,
                r.difference, r.difference_abs, *r.interval, r.shapiro_p, r.test, r.p,
                r.identical, r.rmse, r.correlation, r.paper.simulated, r.paper.reference,
                r.paper.difference, r.paper.identical,
            ]
            for r in (self.study.rows if self.study is not None else ())
        ]  # fmt: skip
        return header, rows

    def table_text(self) -> list[str]:
        """Return Table I as lines to print."""
        if self.study is None:
            return ["  no gait counts in the statistics: none is valid with a whole cycle"]
        lines = [
            f"  {'range of motion [°]':22}{'sim':>6}{'ref':>6}{'diff':>7}{'RMSE':>6}{'r':>6}"
            f"{'p':>7}   paper: sim ref diff"
        ]
        for r in self.study.rows:
            p = "–" if r.p is None else f"{r.p:.3f}"
            mark = "‡" if r.identical else " "
            printed = "‡" if r.paper.identical else " "
            lines.append(
                f"  {r.label:22}{r.simulated:6.1f}{r.reference:6.1f}{r.difference:+7.1f}"
                f"{r.rmse:6.1f}{r.correlation:6.2f}{p:>7}{mark}  {r.paper.simulated:9d}"
                f"{r.paper.reference:4d}{r.paper.difference:5d}{printed}"
            )
        n = len(self.counted)
        tested = any(r.p is not None for r in self.study.rows)
        said = "‡ no significant difference at 5 %" if tested else "nothing was tested"
        lines.append(f"  {n} gait{'' if n == 1 else 's'}; {said}")
        return lines


def study_files(
    found: GaitStudy, files: Sequence[Path], status: str, settings: ReproduceSettings, command: str
) -> dict[str, str]:
    """Return page and table of a study by name; ``settings`` are those of all gaits."""
    provenance = {
        "version": __version__,
        "command": command,
        "settings": settings.plain(),
        "source_files": source_files(files),
    }
    page = study_html(
        found.study,
        found.members,
        found.left_out,
        tasks=settings.tasks,
        status=status,
        provenance=provenance,
    )
    return {PAGE: page, TABLE: csv_text(*found.table_rows())}
