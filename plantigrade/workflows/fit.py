"""The path every recording takes: read, fit, analyse, write."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.errors import FitError, ParameterError

if TYPE_CHECKING:
    from plantigrade.analyze.trial import Trial
    from plantigrade.kinematics.result import Fit
    from plantigrade.motion import Recording


@dataclass(frozen=True)
class FitSettings:
    """Everything that decides the result of a fit, as written into ``metrics.json``.

    Attributes:
        height: Stature [m]; from the recording if None.
        mass: Body mass [kg]; likewise.
        sex: ``"female"`` or ``"male"``; likewise, else male.
        joints: Joint set.
        feet: Kind of foot; the joint set's own if None.
        static: Standing trial; looked for beside the recording if None.
        skeleton: ASF file of an AMC; likewise.
        forces: File of ground reactions; likewise.
        marker_set: TOML file of a marker set.
        cutoff: Low-pass of motion and forces [Hz].
        companions: Look for companion files at all.
    """

    height: float | None = None
    mass: float | None = None
    sex: str | None = None
    joints: str = "42"
    feet: str | None = None
    static: Path | None = None
    skeleton: Path | None = None
    forces: Path | None = None
    marker_set: Path | None = None
    cutoff: float = 6.0
    companions: bool = True


@dataclass(frozen=True)
class Loaded:
    """A recording with its companions and the files all of it came from."""

    recording: "Recording"
    static: "Recording | None"
    sources: tuple[Path, ...]


def load(path: Path, settings: FitSettings) -> Loaded:
    """Read a recording and what belongs to it.

    Raises:
        FileError: If a file cannot be read.
    """
    from plantigrade.io import read
    from plantigrade.io.companions import Companions, find_companions

    skeleton = settings.skeleton
    if skeleton is None and path.suffix.lower() == ".amc":
        from plantigrade.io.asf_amc import find_asf

        skeleton = find_asf(path) if path.exists() else None
    recording = read(path, **({"skeleton": skeleton} if skeleton else {}))
    found = find_companions(recording, read) if settings.companions else Companions()
    static = read(settings.static) if settings.static else found.static
    if static is not None and static.markers is None:
        raise FitError(f"{settings.static} holds no markers, so it is no standing trial")
    plates, source = recording.plates or found.forces, found.forces_source
    if settings.forces:
        plates, source = read(settings.forces).plates, settings.forces
        if not plates:
            raise FitError(f"{settings.forces} holds no ground reactions")
    notes = []
    if static is not None and settings.static is None:
        notes.append(f"{static.source.name} beside it was taken as its standing trial.")
    if source is not None and settings.forces is None:
        notes.append(f"{source.name} beside it was taken as its ground reactions.")
    recording = replace(
        recording,
        plates=plates,
        warnings=tuple(recording.warnings) + tuple(notes),
    )
    sources = [path, *([static.source] if static else []), *([source] if source else [])]
    if skeleton:
        sources.append(skeleton)
    return Loaded(recording, static, tuple(sources))


def fit(loaded: Loaded, settings: FitSettings, progress: Callable | None = None) -> "Fit":
    """Fit a recording of any kind.

    Raises:
        FitError: If it cannot be fitted; the message says why.
    """
    if not settings.cutoff > 0:  # also catches NaN
        raise ParameterError(f"cutoff={settings.cutoff} [Hz] must be positive; 6 suits walking")
    recording = loaded.recording
    person = {k: getattr(settings, k) for k in ("height", "mass", "sex", "joints", "feet")}
    if recording.markers is not None and recording.markers.names:
        from plantigrade.kinematics.fit import Person, fit_markers
        from plantigrade.models.markers import read_marker_set

        chosen = read_marker_set(settings.marker_set) if settings.marker_set else None
        return fit_markers(
            recording,
            Person(**person),
            static=loaded.static,
            marker_set=chosen,
            progress=progress,
        )
    if recording.skeleton is not None:
        from plantigrade.kinematics.retarget import fit_skeleton

        return fit_skeleton(recording, **person)
    if recording.coordinates is not None:
        from plantigrade.kinematics.coordinate_fit import fit_coordinates

        return fit_coordinates(recording, **person)
    held = "ground reactions alone" if recording.plates else "neither markers nor joint angles"
    raise FitError(f"{recording.source} holds {held}: there is no motion to fit")


def refuse_existing(out: Path, *, overwrite: bool) -> None:
    """Raise before any work is done where a run folder could not be written in the end.

    Raises:
        RunExists: If the folder exists and is not to be replaced, or is no run folder.
    """
    from plantigrade.record.folder import refuse_existing as refuse

    refuse(out, overwrite)


def analyse(fitted: "Fit", settings: FitSettings) -> "Trial":
    """Analyse a fit with the settings' cut-off and mass."""
    from plantigrade.analyze.trial import analyse as analyse_trial

    return analyse_trial(fitted, cutoff=settings.cutoff, mass=settings.mass)


def write(
    trial: "Trial",
    out: Path,
    *,
    title: str,
    command: Sequence[str],
    settings: FitSettings,
    sources: Sequence[Path],
    seed: int = 0,
    overwrite: bool = False,
    extra: dict[str, Any] | None = None,
    loaded: Loaded | None = None,
) -> tuple[Path, dict[str, Any]]:
    """Write the run folder of an analysed recording; return it and its metrics.

    Where the recording as it was read is given and its markers show the segments of the feet,
    their angles are in the report and in the metrics too.
    """
    from plantigrade import __version__
    from plantigrade.motion import Table
    from plantigrade.record.folder import source_files, write_run
    from plantigrade.report.run_report import run_pages
    from plantigrade.workflows.foot_segments import FILE, foot_segments

    human, motion = trial.fit.human, trial.record.motion
    feet = foot_segments(loaded, trial, settings) if loaded is not None else None
    metrics = {
        "status": status(trial),
        "version": __version__,
        "command": " ".join(command),
        "settings": {k: str(v) if isinstance(v, Path) else v for k, v in asdict(settings).items()},
        "seed": seed,
        "source_files": source_files(sources),
        **trial.record.metrics,
        **(feet.metrics() if feet else {}),
        **(extra or {}),
        "warnings": list(trial.record.warnings),
    }
    metrics["title"], metrics["sentence"] = title, sentence(trial)
    record = replace(trial.record, metrics=metrics)
    pages = run_pages(
        human.model,
        record,
        title=title,
        sentence=metrics["sentence"],
        extra=[feet.section()] if feet else (),
    )
    names, values = human.to_coordinates(motion.qpos)
    folder = write_run(
        out,
        model_xml=human.xml,
        record=record,
        metrics=metrics,
        coordinates=Table(names, motion.time, values),
        files=pages | ({FILE: feet.to_json()} if feet else {}),
        overwrite=overwrite,
    )
    return folder, metrics


def status(trial: "Trial") -> str:
    """Return ``"ok"``, or why the result cannot be called a fit."""
    from plantigrade.kinematics.plausible import verdict

    kind = "marker" if trial.fit.source_kind == "markers" else "joint"
    error = trial.fit.metrics.get("marker_rms_mean_mm", trial.fit.metrics.get("joint_rms_mm"))
    return verdict(None if error is None else 1e-3 * error, kind)


def sentence(trial: "Trial") -> str:
    """Return what was done, in one sentence."""
    fitted = trial.fit
    human, seconds = fitted.human, fitted.time[-1] - fitted.time[0]
    what = {
        "markers": f"{len(fitted.places)} markers",
        "skeleton": "the skeleton",
        "coordinates": "the joint coordinates",
    }[fitted.source_kind]
    text = (
        f"{what} of {fitted.recording.source.name} ({len(fitted.time)} frames, {seconds:.2f} s) on "
        f"a person of {human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees "
        f"of freedom and {human.feet} feet"
    )
    error = fitted.metrics.get("marker_rms_mean_mm", fitted.metrics.get("joint_rms_mm"))
    if error is not None:
        text += f"; mean error {error:.1f} mm"
    known = trial.record.contact_known
    if trial.moments is not None and (known is None or known.any()):
        text += "; joint moments from the measured ground reactions"
    return text[0].upper() + text[1:] + "."


def fit_file(path: str | Path, **settings) -> "Trial":
    """Read, fit and analyse one recording, as ``plantigrade fit`` does, and write nothing.

    Args:
        path: The recording.
        settings: Fields of :class:`FitSettings`.

    Raises:
        FileError: If the file cannot be read.
        FitError: If it cannot be fitted; the message says why.
    """
    chosen = FitSettings(**settings)
    loaded = load(Path(path), chosen)
    return analyse(fit(loaded, chosen), chosen)
