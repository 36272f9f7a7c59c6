"""From a recording to a motion on a scaled Human: read, fit, analyse."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.at_limit import limit_figures, limit_notes
from plantigrade.analyze.clinical import clinical_figures
from plantigrade.analyze.estimated_forces import box_height
from plantigrade.analyze.foot_segments import foot_segment_signals
from plantigrade.analyze.gait_forces import compare_forces, measured_signals
from plantigrade.analyze.laboratory_angles import laboratory_figures
from plantigrade.analyze.norms_of_runs import norm_files, read_norms
from plantigrade.analyze.own_norms import as_signals
from plantigrade.analyze.plausibility import Plausibility
from plantigrade.analyze.trial import CUTOFF, Trial, analyse
from plantigrade.arrays import Array
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.errors import FitError, NothingToFit, ParameterError
from plantigrade.io import read
from plantigrade.io.asf import find_asf
from plantigrade.io.companions import Companions, find_companions
from plantigrade.io.length import require_memory
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.given_ground import GivenGround
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.plausibility import verdict
from plantigrade.kinematics.result import Fit, filled
from plantigrade.kinematics.retarget import fit_skeleton
from plantigrade.kinematics.scaled_body import Shared
from plantigrade.kinematics.sides import mirror_axis, swap_sides
from plantigrade.models.markers import read_marker_set
from plantigrade.models.person import Person
from plantigrade.motion import ForcePlate, Recording
from plantigrade.motion.recording import Subject
from plantigrade.notes import Info
from plantigrade.options import as_path
from plantigrade.record import Provenance, Run
from plantigrade.record.provenance import source_files
from plantigrade.signatures import takes
from plantigrade.threads import on_one_thread
from plantigrade.workflows.osim_fit import fit_own_model
from plantigrade.workflows.settings import FitSettings, RecordingSettings, Settings
from plantigrade.workflows.steps import Step, silent
from plantigrade.world.grounds import ground_named

MAX_HEADING = 45.0
"""Largest angle between the rise of a given slope and the walking direction [deg]."""


def load(path: str | Path, settings: RecordingSettings) -> Recording:
    """Read a recording and its companion files.

    Raises:
        FileError: If a file cannot be read.
        FitError: If a file that was named does not hold what it was named for.
    """
    path = Path(path)
    skeleton = settings.skeleton
    if skeleton is None and path.suffix.lower() == ".amc" and path.exists():
        skeleton = find_asf(path)
    options = {"skeleton": skeleton, "rate": getattr(settings, "rate", None)}
    if not isinstance(settings, FitSettings):  # the rate of a simulation is another
        del options["rate"]
    recording = read(path, **options)
    if recording.markers is None or not recording.markers.names:
        for name in ("static", "marker_set", "swap_sides", "mirror_axis"):
            if getattr(settings, name):
                raise FitError(f"{name} has no effect on {path.name}, which holds no markers")
    found = find_companions(recording, read) if settings.companions else Companions()
    static, notes = _standing_trial(settings, found)
    plates, source = _ground_reactions(recording, settings, found)
    if source is not None and settings.forces is None:
        notes.append(Info(f"{source.name}, found beside it, holds its ground reactions."))
    named = (static.source if static else None, source, skeleton, settings.marker_set)
    recording = replace(
        recording,
        plates=plates,
        static=static,
        companions=tuple(each for each in named if each is not None),
    )
    if settings.swap_sides:
        chosen = read_marker_set(settings.marker_set) if settings.marker_set else None
        recording = swap_sides(recording, chosen)
        notes.append(Info("left and right were swapped in marker and event names."))
    if settings.mirror_axis:
        recording = mirror_axis(recording)
        notes.append(Info("the leftward axis of markers and ground reactions was reversed."))
    return replace(recording, warnings=(*recording.warnings, *notes))


def _standing_trial(
    settings: RecordingSettings, found: Companions
) -> tuple[Recording | None, list[str]]:
    """Return the standing trial that was named, or else found, and what to say of a found one."""
    if settings.static:
        static = read(settings.static)
        if static.markers is None:
            raise FitError(f"{settings.static} holds no markers, so it is not a standing trial")
        return static, []
    if found.static is None:
        return None, []
    said = f"{found.static.source.name}, found beside it, is its standing trial"
    if getattr(settings, "model", None) is None:
        return found.static, [Info(f"{said}.")]
    return None, [Info(f"{said}, which is not used: a model of your own is scaled already.")]


def _ground_reactions(
    recording: Recording, settings: RecordingSettings, found: Companions
) -> tuple[tuple[ForcePlate, ...], Path | None]:
    """Return the plates of the file that was named, of the recording or of a found file.

    The path is that of the other file, if there is one.
    """
    plates, source = recording.plates or found.forces, found.forces_source
    if settings.forces:
        plates, source = read(settings.forces).plates, settings.forces
        if not plates:
            raise FitError(f"{settings.forces} holds no ground reactions")
    if settings.without_plates and not plates:
        raise FitError(f"without_plates has no effect on {recording.source.name}, which has none")
    return plates, source


def fit_recording(
    recording: Recording,
    settings: RecordingSettings,
    shared: Shared | None = None,
    *,
    box: Ground | None = None,
) -> Fit:
    """Fit a recording of any kind.

    Args:
        shared: What it has in common with other trials.
        box: Steps of the height of a box below its feet.
    """
    person = Person(**settings.known)
    subject = filled(Subject(age=settings.age), recording.subject)
    recording = replace(recording, subject=subject)
    ground = given_ground(settings) if box is None else GivenGround(box)
    if recording.markers is not None and recording.markers.names:
        chosen = read_marker_set(settings.marker_set) if settings.marker_set else None
        return fit_markers(
            recording,
            person,
            static=recording.static,
            marker_set=chosen,
            ground=ground,
            body=None if shared is None else shared.body,
        )
    if ground is not None:
        raise FitError(
            f"{recording.source.name} holds no markers; a ground can be given for markers only: "
            "leave out --ground"
        )
    if recording.skeleton is not None:
        return fit_skeleton(recording, person)
    if recording.coordinates is not None:
        return fit_coordinates(recording, person)
    held = "ground reactions alone" if recording.plates else "neither markers nor joint angles"
    raise NothingToFit(f"{recording.source} holds {held}: there is no motion to fit")


def given_ground(settings: RecordingSettings) -> GivenGround | None:
    """Return the ground that settings of a fit give; None where they give none."""
    word = settings.ground if isinstance(settings, FitSettings) else None
    if word is None:
        return None
    name, comma, turned = word.partition(",")
    try:
        heading = float(turned) if comma else 0.0
    except ValueError:
        heading = np.nan
    allowed = ("slope",) if comma else ("slope", "steps")
    if name.strip().partition(":")[0] in allowed and abs(heading) <= MAX_HEADING:
        shape = ground_named(name)
        if shape.slope or any(step.height for step in shape.steps):
            return GivenGround(shape, float(np.deg2rad(heading)))
    raise ParameterError(
        f"no ground {word!r} for a recording; give slope:DEG, slope:DEG,HEADING (from "
        f"-{MAX_HEADING:g} to {MAX_HEADING:g} degrees, to the left positive) or steps:CM, none of "
        "them zero; without --ground it is level"
    )


@on_one_thread
def fit_trial(
    path: str | Path,
    settings: RecordingSettings | None = None,
    step: Step = silent,
    shared: Shared | None = None,
    *,
    boxes: bool = True,
) -> tuple[Recording, Trial]:
    """Read, fit and analyse a recording; return it as it was read, and the trial.

    Without ``boxes`` the ground stays level where feet stand on one.

    Raises:
        ParameterError: If ``path`` is no path.
        FileError: If a file cannot be read.
        FitError: If it cannot be fitted; the message says why.
    """
    settings, path = settings or FitSettings(), as_path(path, "a recording")
    norm_signals(settings)  # refuses wrong norms before the work
    given_ground(settings)
    with step(f"reading {path.name}"):
        recording = load(path, settings)
        recording = recording if shared is None else shared.into(recording)
        require_memory(recording)
    with step("fitting"):
        fitted = fit_recording(recording, settings, shared)
    how = {"mass": settings.mass, "without_plates": settings.without_plates}
    with step("analysing"):
        trial = analyse(fitted, cutoff=settings.cutoff or "usual", **how)
    box = _box_below(trial) if boxes else None
    if box is None or shared is not None:
        return recording, trial
    with step("fitting again, on a box"):
        try:
            fitted = fit_recording(recording, settings, box=box)
        except FitError:  # the feet stand otherwise: the trial says so
            return recording, trial
        said = f"The feet stand on a box {100 * box.steps[0].height:.0f} cm high: it was put there."
        fitted = replace(fitted, warnings=(*fitted.warnings, Info(said)))
        return recording, analyse(fitted, cutoff=settings.cutoff or "usual", **how)


def _box_below(trial: Trial) -> Ground | None:
    """Return steps of the height of a box on which the feet of markers stand; None without one."""
    if trial.fit.source_kind != "markers" or trial.ground is None:
        return None
    height = box_height(trial.fit.human, trial.ground, trial.motion.time, trial.fit.ground)
    return None if height is None else Ground(steps=(GroundStep(0.0, height),))


@takes(FitSettings)
def fit(path: str | Path, settings: FitSettings | None = None, **options: Any) -> Run:
    """Fit a recording to a scaled Human: its motion, forces and joint moments.

    Args:
        path: The recording: C3D, TRC, MOT, AMC, BVH, SMPL, keypoints or DeepMimic JSON, or CSV.
        settings: What decides the result; options replace its fields.
        options: Fields of ``FitSettings``.

    Raises:
        ParameterError: If there is no such option, or a value is not allowed.
        FileError: If a file cannot be read.
        FitError: If the recording cannot be fitted; the message says why.

    Example:
        >>> import plantigrade as pg
        >>> run = pg.fit("walk.c3d", feet="multi-segment")  # doctest: +SKIP
    """
    return run_fit(path, FitSettings.given("fit", settings, options))


@on_one_thread
def run_fit(
    path: str | Path,
    how: FitSettings,
    *,
    step: Step = silent,
    command: str = "",
    shared: Shared | None = None,
) -> Run:
    """Fit a recording with given settings: what :func:`fit` and the command do.

    ``step`` shows progress, ``command`` is for the provenance, and ``shared`` are body and mass of
    the subject from several trials (:func:`plantigrade.workflows.one_subject.share`).
    """
    if how.model is not None:
        path = as_path(path, "a recording")
        with step(f"fitting {Path(how.model).name} to {path.name}"):
            return fit_own_model(load(path, how), how, command=command)
    began = time.perf_counter()
    run = run_of(*fit_trial(path, how, step, shared), how, command=command)
    return replace(run, seconds={"fit": time.perf_counter() - began})


def run_of(
    recording: Recording,
    trial: Trial,
    settings: RecordingSettings,
    *,
    title: str = "",
    command: str = "",
    seed: int | None = None,
) -> Run:
    """Return the run of a recording that was analysed with these settings.

    Its pages are called after the file where no title is given.
    """
    record = trial.record()
    cutoff = trial.cutoff or CUTOFF
    feet = foot_segment_signals(recording, trial, settings.marker_set, cutoff)
    signals = {**record.signals, **feet.signals, **norm_signals(settings)}
    plausibility = Plausibility.of(trial)
    notes = (*plausibility.notes, *record.notes, *limit_notes(record))
    record = replace(record, signals=signals, notes=notes)
    figures = {**trial.figures, **laboratory_figures(record), **feet.figures}
    figures |= limit_figures(record) | plausibility.figures
    figures |= personal_figures(settings)
    if trial.withheld is not None and trial.measured is not None and trial.ground is not None:
        record = replace(
            record, signals={**record.signals, **measured_signals(record, trial.measured)}
        )
        belt = moving_ground(trial.motion.time, trial.feet.heel, trial.feet.toe)
        compared = compare_forces(record, trial.measured, belt=belt).metrics()
        del compared["forced_root_residual_bw"]  # estimate_residual_… is more precise
        figures |= {k: v for k, v in compared.items() if np.isfinite(v)}
    return Run(
        record,
        "fit",
        title=title or recording.source.name,
        sentence=sentence(trial),
        status=status(trial),
        figures={**figures, **clinical_figures(record, figures)},
        provenance=provenance(recording, settings, command, seed),
        name=f"fit-{recording.source.stem}",
    )


def provenance(
    recording: Recording, settings: RecordingSettings, command: str = "", seed: int | None = None
) -> Provenance:
    """Return the provenance of a result on a recording: all files that were read."""
    own = norm_files(settings.norms)
    files = source_files([recording.source, *recording.companions, *own])
    return Provenance(command, settings.plain(), files, seed)


def norm_signals(settings: RecordingSettings) -> dict[str, Array]:
    """Return the user's own norms as signals of a record; none where they are not given.

    Raises:
        FileError: If they cannot be read.
        ParameterError: If they are a folder without runs of people who walk.
    """
    return {} if settings.norms is None else as_signals(read_norms(settings.norms))


def personal_figures(settings: Settings) -> dict[str, Any]:
    """Return what the settings say of a person, as figures of a run."""
    return Subject(age=settings.age, sex=settings.sex).figures


def status(trial: Trial) -> str:
    """Return ``"ok"``, or why the result cannot be called a fit."""
    kind = "marker" if trial.fit.source_kind == "markers" else "joint"
    error = _error(trial)
    fitted = verdict(None if error is None else 1e-3 * error, kind)
    return fitted if fitted != "ok" else Plausibility.of(trial).failure or "ok"


def sentence(trial: Trial) -> str:
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
    error = _error(trial)
    if error is not None:
        kind = "marker" if fitted.source_kind == "markers" else "joint centre"
        text += f"; RMS {kind} error {error:.1f} mm"
    if trial.forces is not None and bool(np.any(trial.forces.valid_side)):
        text += "; joint moments from the measured ground reactions"
        text += ", estimated where there was no plate" if trial.ground is not None else ""
    elif trial.ground is not None:
        text += "; ground reactions and joint moments estimated from the motion"
    return text[0].upper() + text[1:] + "."


def _error(trial: Trial) -> float | None:
    """Return the RMS error of markers (mean over frames) or of joint centres [mm]."""
    figures = trial.fit.metrics
    return figures.get("marker_rms_mean_mm", figures.get("joint_rms_mm"))
