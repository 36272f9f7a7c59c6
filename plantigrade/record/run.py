"""Runs: one or more Records with figures and provenance, and their folder."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from plantigrade.contact.scene import scene_xml
from plantigrade.errors import FigureNotFound, FileError, known_names
from plantigrade.io.mot import write_mot
from plantigrade.motion.recording import Table
from plantigrade.motion.views import table_html
from plantigrade.notes import Info
from plantigrade.options import as_path
from plantigrade.record.folder import FORMAT, write_folder
from plantigrade.record.metrics import METRICS, read_metrics
from plantigrade.record.npz import read_npz, write_npz
from plantigrade.record.provenance import Provenance
from plantigrade.record.record import Record
from plantigrade.record.scene_objects import scene_objects_of
from plantigrade.record.views import run_summary

MODEL, MOTION, COORDINATES = "model.xml", "motion.npz", "motion.mot"
RUNS = Path("runs")  #: Where a run goes for which no folder is named
_META = ("status", "format", "version", "kind", "title", "sentence", "command", "settings", "seed",
         "source_files", "notes", "warnings", "files", "seconds")  # fmt: skip


class Figures(dict[str, Any]):
    """Figures by key: flat, in snake_case, unit as suffix.

    Example:
        >>> Figures(walking_speed_m_s=1.3)["walking_speed"]
        Traceback (most recent call last):
        ...
        plantigrade.errors.FigureNotFound: no figure 'walking_speed'; did you mean ...
    """

    def __missing__(self, key: str) -> Any:
        """Refuse a key that is not there."""
        raise FigureNotFound(f"no figure {key!r}; {known_names(str(key), list(self))}")


@dataclass(frozen=True, eq=False)
class Run:
    """The result of a command.

    Attributes:
        record: What happened.
        kind: The engine or command: ``"fit"``, ``"reproduce"``, ``"synthesize"``, ``"track"``.
        title: Heading of its pages.
        sentence: What was done, in one sentence.
        status: ``"ok"``, or what is wrong, where and when.
        figures: Every figure: flat keys in snake_case, unit as suffix.
        seconds: Computing times by what was computed [s]; the only figures that differ between
            equal runs.
        provenance: Where it comes from.
        others: Further records by name (``"forces"``), kept as ``NAME.npz``.
        name: Of its folder, where none is named: ``"fit-walk"``; its kind if empty.
        folder: Where it lies; None as long as it is not saved.
        files: Names of the files beside ``metrics.json``, once it is saved.

    Example:
        >>> run = Run.load("runs/fit-walk")  # doctest: +SKIP
        >>> run.record.motion["knee_angle_r"].max()  # doctest: +SKIP
    """

    record: Record
    kind: str
    title: str = ""
    sentence: str = ""
    status: str = "ok"
    figures: Mapping[str, Any] = field(default_factory=dict)
    provenance: Provenance = field(default_factory=Provenance)
    others: Mapping[str, Record] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    name: str = ""
    folder: Path | None = None
    files: tuple[str, ...] = ()

    def __post_init__(self):
        object.__setattr__(self, "figures", Figures(self.figures))

    @property
    def ok(self) -> bool:
        """Whether everything that was asked for was reached."""
        return self.status == "ok"

    @property
    def with_forces(self) -> Record:
        """The record whose forces are shown.

        It is the motion moved by forces that is stored with the record, or the record itself where
        it has forces of its own or there is no such motion.
        """
        forced = self.others.get("forces")
        lost = self.figures.get("dynamics_status", "ok") != "ok"
        return self.record if forced is None or lost or self.record.has_forces else forced

    @property
    def metrics(self) -> dict[str, Any]:
        """Everything ``metrics.json`` holds."""
        from plantigrade import __version__

        p = self.provenance
        return {
            "status": self.status,
            "format": FORMAT,
            "version": __version__,
            "kind": self.kind,
            "title": self.title,
            "sentence": self.sentence,
            "command": p.command,
            "settings": dict(p.settings),
            "seed": p.seed,
            "source_files": dict(p.source_files),
            "seconds": dict(self.seconds),
            **self.figures,
            "notes": list(self.record.notes),
            "warnings": [note for note in self.record.notes if not isinstance(note, Info)],
            **({"files": list(self.files)} if self.files else {}),
        }

    def save(
        self,
        out: str | Path | None = None,
        *,
        files: Mapping[str, str | bytes] | None = None,
        overwrite: bool = False,
        numbered: bool = False,
        beside: str = "",
    ) -> "Run":
        """Write the run folder, whole or not at all, and return the run in it.

        Args:
            out: The folder; ``runs/<name>`` if absent, numbered where that is taken.
            files: Pages and other files, by name.
            overwrite: Replace an existing run, also ``runs/<name>``.
            numbered: Number the folder where ``out`` is taken, too.
            beside: Ending of the name of a second folder that will lie beside this one; a number
                is passed over if that is taken.

        Raises:
            RunExists: If the folder exists and is not to be replaced, or is no run.
            FileError: If the place cannot be written, or a name is taken.
            ParameterError: If ``out`` is not the path of a folder.
        """
        place = RUNS / (self.name or self.kind) if out is None else as_path(out, "out")
        theirs = {f"{name}.{ending}" for name in self.others for ending in ("npz", "xml")}
        names = {MODEL, MOTION, COORDINATES, METRICS, *theirs}
        if taken := names & set(files or {}):
            remedy = "use a plain new name"
            raise FileError(place / min(taken), "is a file of every run", remedy=remedy)

        def contents(folder: Path) -> None:
            record = self.record
            fixed = [(t.scene_object, t.pose[0]) for t in scene_objects_of(record) if t.fixed]
            xml = scene_xml(record.human, record.ground, record.sites, fixed)
            (folder / MODEL).write_text(xml, encoding="utf-8")
            write_npz(record, folder / MOTION)
            columns, values = record.human.file_coordinates(record.motion.qpos)
            write_mot(Table(columns, record.motion.time, values), folder / COORDINATES)
            for name, other in self.others.items():
                write_npz(other, folder / f"{name}.npz")
                if other.human.xml != record.human.xml:  # a person with another mass distribution
                    xml = scene_xml(other.human, other.ground, other.sites)
                    (folder / f"{name}.xml").write_text(xml, encoding="utf-8")

        folder = write_folder(
            place,
            metrics=self.metrics,
            files=files or {},
            overwrite=overwrite,
            numbered=(numbered or out is None) and not overwrite,
            beside=beside,
            more=contents,
        )
        return replace(self, folder=folder, files=tuple(read_metrics(folder)["files"]))

    def report(self, out: str | Path | None = None, *, overwrite: bool = False) -> Path:
        """Write report and viewer, and return the path of ``report.html``.

        A run that is not saved yet, or is given another folder, is saved first, as :meth:`save`
        does; in a saved one the two pages are written anew.

        Raises:
            RunExists: If the folder exists and is not to be replaced, or is no run.
            FileError: If the place cannot be written.
            ParameterError: If the record cannot be drawn.
        """
        import plantigrade  # the face: pages lie in a room below this one

        return plantigrade.report(self, out, overwrite=overwrite)

    def view(self, **options: Any) -> Any:
        """Return the viewer for a cell of a notebook, as :func:`plantigrade.view` does.

        Args:
            options: Those of :func:`plantigrade.view`.

        Raises:
            ParameterError: If the record cannot be drawn.
        """
        import plantigrade  # the face: pages lie in a room below this one

        return plantigrade.view(self, **options)

    def export(self, path: str | Path, **options: Any) -> tuple[str, ...]:
        """Write this run as a file of another program, as :func:`plantigrade.export` does.

        Args:
            path: The file; its extension chooses the format.
            options: Those of the format.

        Returns:
            One sentence for each thing that the file does not hold.

        Raises:
            FileError: If the file cannot be written, or the run has not what the format stores.
            ParameterError: If the format has no such option.
        """
        import plantigrade  # the face: formats of other programs lie in a room below this one

        return plantigrade.export(self, path, **options)

    @classmethod
    def load(cls, folder: str | Path) -> "Run":
        """Return the run of a folder.

        Raises:
            FileError: If the folder is no run, is of another version, or one of its files is
                broken.
            ParameterError: If ``folder`` is not the path of a folder.
        """
        folder = as_path(folder, "a run").expanduser()
        metrics = read_metrics(folder)
        if metrics.get("format") != FORMAT:
            problem = f"is of format {metrics.get('format', 1)}; this version reads format {FORMAT}"
            raise FileError(folder / METRICS, problem, remedy="run the command again")
        if not isinstance(metrics.get("kind"), str) or metrics["kind"] == "batch":
            what = "is of a batch" if metrics.get("kind") == "batch" else "names no kind of run"
            raise FileError(folder / METRICS, what, remedy="name the folder of a single run")
        missing = ", ".join(name for name in (MODEL, MOTION) if not (folder / name).is_file())
        if missing:
            remedy = "name a folder a plantigrade command wrote"
            raise FileError(folder, f"is not a complete run: {missing} missing", remedy=remedy)
        kept = sorted(folder.glob("*.npz"))
        others = {path.stem: read_npz(path) for path in kept if path.name != MOTION}
        settings, sources = metrics.get("settings"), metrics.get("source_files")
        seconds = metrics.get("seconds")
        files = metrics.get("files")
        seed = metrics.get("seed")
        return cls(
            read_npz(folder / MOTION),
            metrics["kind"],
            title=str(metrics.get("title", "")),
            sentence=str(metrics.get("sentence", "")),
            status=str(metrics.get("status", "")),
            figures={k: v for k, v in metrics.items() if k not in _META},
            provenance=Provenance(
                str(metrics.get("command", "")),
                settings if isinstance(settings, dict) else {},
                sources if isinstance(sources, dict) else {},
                seed if isinstance(seed, int) else None,
            ),
            others=others,
            seconds=seconds if isinstance(seconds, dict) else {},
            name=folder.resolve().name,
            folder=folder,
            files=tuple(map(str, files)) if isinstance(files, list) else (),
        )

    def _repr_html_(self) -> str:
        return table_html(self.title or "Run", run_summary(self))

    def __repr__(self) -> str:
        where = f" in {self.folder}" if self.folder else ""
        return f"Run({self.kind}{where}, {self.status}: {self.sentence or self.record!r})"


def load_run(folder: str | Path) -> Run:
    """Return the run of a folder: :meth:`Run.load`."""
    return Run.load(folder)
