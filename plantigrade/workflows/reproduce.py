"""Reproduce a recorded gait from prioritised tasks: fit, reproduce, compare."""

import time as clock
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.at_limit import limit_figures, limit_notes
from plantigrade.analyze.gait_forces import measured_signals
from plantigrade.analyze.plausibility import Plausibility
from plantigrade.analyze.recorded_walk import RecordedWalk, walk_to_reproduce
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.analyze.reproduction_status import force_figures, gait_figures, run_status
from plantigrade.analyze.trial import Trial
from plantigrade.kinematics.unmeasured_joints import SIGNAL as ASSUMED
from plantigrade.motion import Recording
from plantigrade.notes import Info
from plantigrade.ordered_tasks.gait import GaitTasks, gait_tasks
from plantigrade.ordered_tasks.gait_reference import GaitReference
from plantigrade.ordered_tasks.reproduced_gait import rebuild
from plantigrade.record import Record, Run
from plantigrade.signatures import takes
from plantigrade.threads import on_one_thread
from plantigrade.wbc.stepping import OrderedMotion
from plantigrade.workflows.fit import fit_trial, norm_signals, personal_figures, provenance, status
from plantigrade.workflows.settings import ReproduceSettings
from plantigrade.workflows.steps import Step, silent

MIN_TREADMILL_TRAVEL = 0.5  #: Ground that moves further is a treadmill's [m]


@takes(ReproduceSettings)
def reproduce(path: str | Path, settings: ReproduceSettings | None = None, **options: Any) -> Run:
    """Reproduce the recorded gait of a file from prioritised tasks.

    Args:
        path: The recording, as :func:`plantigrade.workflows.fit.fit` takes it.
        settings: What decides the result; options replace its fields.
        options: Fields of ``ReproduceSettings``.

    Raises:
        ParameterError: If there is no such option, or a value is not allowed.
        FileError: If the file cannot be read.
        FitError: If it cannot be fitted; the message says why.
        ReproduceError: If it shows no walking, or uneven ground.

    Example:
        >>> import plantigrade as pg
        >>> run = pg.reproduce("walk.c3d", no_dynamics=True)  # doctest: +SKIP
    """
    return run_reproduction(path, ReproduceSettings.given("reproduce", settings, options))


@on_one_thread
def run_reproduction(
    path: str | Path, how: ReproduceSettings, *, step: Step = silent, command: str = ""
) -> Run:
    """Reproduce a recording with given settings: what :func:`reproduce` and the command do.

    ``step`` shows progress, and ``command`` is for the provenance.
    """
    recording, trial = fit_trial(path, how, step)
    with step("reproducing"):
        return run_of(recording, trial, how, command=command)


def run_of(
    recording: Recording,
    trial: Trial,
    settings: ReproduceSettings,
    *,
    title: str = "",
    command: str = "",
    seed: int | None = None,
) -> Run:
    """Return the run of a gait reproduced from an analysed recording.

    Its record is the motion from the hierarchy of accelerations; ``others["forces"]`` is the
    motion moved by forces, with the measured forces as signals ``measured.…``. The status says
    the worst of both.

    Raises:
        ReproduceError: If it shows no walking, or uneven ground.
    """
    tasks, walk = gait_tasks(settings.tasks), walk_to_reproduce(trial)
    reference = walk.reference()
    started = clock.perf_counter()
    made = rebuild(reference, tasks)
    record = made.record()
    seconds = clock.perf_counter() - started
    held = compare(record)
    figures: dict[str, Any] = {
        **walk.figures,
        **personal_figures(settings),
        "frames": record.motion.n_frames,
        "duration_s": record.motion.duration,
        "tasks": settings.tasks,
        **gait_figures(record, held),
        **limit_figures(record),
    }
    doubts = Plausibility.of(trial).notes
    notes = [*doubts, *walk.notes, *_notes(walk, reference), *limit_notes(record)]
    assumed = {name: s for name, s in trial.record().signals.items() if name == ASSUMED}
    others: dict[str, Record] = {}
    if not settings.no_dynamics:
        others["forces"] = forced = _moved_by_forces(walk, reference, tasks)
        figures |= force_figures(forced, compare(forced), walk.measured, walk.ground)
        if figures["dynamics_status"] != "ok":
            notes.append(
                "the gait computed with forces is outside its limits (see the status): its ground "
                "reactions and joint moments are left out of the report."
            )
    signals = {**record.signals, **assumed, **norm_signals(settings)}
    forced_status = figures.get("dynamics_status", "ok")
    return Run(
        replace(record, notes=tuple(dict.fromkeys(notes)), signals=signals),
        "reproduce",
        title=title or f"{recording.source.name}, reproduced",
        sentence=_sentence(walk.name, record, held, settings.tasks),
        status=run_status(figures["motion_status"], forced_status, status(trial)),
        figures=figures,
        provenance=provenance(recording, settings, command, seed),
        others=others,
        seconds=_seconds(made.motion, held, seconds),
        name=f"reproduce-{recording.source.stem}",
    )


def _moved_by_forces(walk: RecordedWalk, reference: GaitReference, tasks: GaitTasks) -> Record:
    """Return the gait moved by forces, with the measured forces as signals."""
    forced = rebuild(reference, tasks, forces=True).record()
    if walk.measured is None:
        return forced
    return replace(forced, signals={**forced.signals, **measured_signals(forced, walk.measured)})


def _seconds(motion: OrderedMotion, held: Comparison, seconds: float) -> dict[str, float]:
    """Return the computing times: of the motion, of a gait cycle, medians of a tick [s]."""
    found = {
        "reproduce": seconds,
        "tick_solver": float(np.median(motion.solver_time)),
        "tick_kinematics": float(np.median(motion.kinematics_time)),
    }
    if held.cycles:
        stride = float(np.mean([c.duration for c in held.cycles]))
        found["cycle"] = seconds * stride / float(motion.time[-1] - motion.time[0])
    return found


def _sentence(name: str, record: Record, held: Comparison, tasks: str) -> str:
    """Return what was done, in one sentence."""
    human, motion, n, m = record.human, record.motion, len(held.cycles), held.metrics()
    text = (
        f"The gait of {name} ({motion.duration:.2f} s, {n} stride{'' if n == 1 else 's'}) "
        f"reproduced from the prioritised tasks “{tasks}” on a person of {human.height:.2f} m and "
        f"{human.mass:.1f} kg with {human.model.nv} degrees of freedom; the centre of mass within "
        f"{m['com_error_max_mm']:.1f} mm of its path"
    )
    if "rom_error_mean_deg" in m:
        text += f", ranges of motion {m['rom_error_mean_deg']:.1f}° off on average"
    return text + "."


def _notes(walk: RecordedWalk, reference: GaitReference) -> list[str]:
    """Return what the user should know of how the recording was used."""
    events, found = walk.motion.events, []
    if len(reference.events) < len(events):
        found.append(
            f"of {len(events)} gait events, the longest sequence of steps was reproduced: "
            f"{len(reference.events)} events, {reference.start:.2f} to {reference.stop:.2f} s."
        )
    way = float(np.linalg.norm(walk.ground[-1, :2] - walk.ground[0, :2]))
    if way > MIN_TREADMILL_TRAVEL:
        found.append(
            Info(
                f"the ground moves at {way / walk.motion.duration:.2f} m/s (a treadmill); the gait "
                "was reproduced over ground at rest."
            )
        )
    return found
