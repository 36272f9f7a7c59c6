"""A recorded gait rebuilt from ordered tasks: fit, reproduce, compare, write."""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.workflows.fit import FitSettings, analyse, fit, load
from plantigrade.workflows.walks import (
    events_in_order,
    reference_of_trial,
    refuse_standing,
    refuse_uneven,
    whole_cycles,
)

if TYPE_CHECKING:
    from plantigrade.analyze.reproduction import Comparison
    from plantigrade.analyze.trial import Trial
    from plantigrade.record import Record
    from plantigrade.report.reproduction import Reproduction
    from plantigrade.reproduce.forces import ForcedMotion
    from plantigrade.reproduce.reference import Reference
    from plantigrade.wbc.ordered_motion import OrderedMotion

COM_LIMIT = 0.05  # a centre of mass further off its path is not on it [m]
PELVIS_LIMIT = 0.30  # a pelvis further from the recorded one has wandered off [m]


FALLEN = 0.15  # a body moved by forces whose centre of mass is further off has fallen [m]
FORCES = "forces.npz"  # the gait moved by forces, in the run folder
SHOWN_MOMENTS = tuple(
    f"{name}_{side}"
    for name in ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
    for side in ("r", "l")
)


@dataclass(frozen=True)
class ReproduceSettings(FitSettings):
    """Everything that decides the result, as written into ``metrics.json``.

    Attributes:
        tasks: Which tasks, a name of :data:`plantigrade.reproduce.gait.TASKS`.
        dynamics: Whether forces and moments are found too.
    """

    tasks: str = "default"
    dynamics: bool = True


@dataclass(frozen=True)
class Reproduced:
    """A recorded gait and the one rebuilt from it.

    Attributes:
        trial: The recording, fitted and analysed; of one cycle that was repeated, as repeated.
        reference: What the tasks saw of it.
        motion: The gait from the hierarchy of accelerations.
        forced: The gait from the hierarchy of forces; None where it was not asked for.
        comparison: How near the first is to the recording.
        seconds: How long it took to make the first [s].
        tasks: Name of the set of tasks.
    """

    trial: "Trial"
    reference: "Reference"
    motion: "OrderedMotion"
    forced: "ForcedMotion | None"
    comparison: "Comparison"
    seconds: float
    tasks: str = "default"


def reproduce_trial(
    trial: "Trial",
    tasks: str = "default",
    dynamics: bool = True,
    *,
    progress: Callable[[float], None] | None = None,
) -> Reproduced:
    """Rebuild the gait of an analysed recording.

    Args:
        trial: The recording, analysed.
        tasks: Which tasks, a name of :data:`plantigrade.reproduce.gait.TASKS`.
        dynamics: Whether forces and moments are found too.
        progress: Called with the share that is done, now and then.

    Raises:
        ParameterError: If there is no such set of tasks.
        ReproduceError: If nobody walks in the recording.
    """
    from plantigrade.analyze.reproduction import compare
    from plantigrade.reproduce.gait import gait_order, gait_tasks
    from plantigrade.wbc.ordered_motion import move

    chosen = gait_tasks(tasks)
    trial = events_in_order(whole_cycles(trial))
    refuse_standing(trial)
    refuse_uneven(trial)
    reference = reference_of_trial(trial)
    started = clock.perf_counter()
    motion = move(
        reference.human,
        gait_order(reference, chosen),
        reference.at(reference.start),
        reference.velocity_at(reference.start),
        start=reference.start,
        stop=reference.stop,
        progress=progress,
    )
    seconds = clock.perf_counter() - started
    forced = None
    if dynamics:
        from plantigrade.reproduce.forces import gait_with_forces

        forced = gait_with_forces(reference, chosen)
    return Reproduced(trial, reference, motion, forced, compare(reference, motion), seconds, tasks)


def reproduce_file(path: str | Path, **settings) -> Reproduced:
    """Read, fit, analyse and reproduce one recording, and write nothing.

    Args:
        path: The recording.
        settings: Fields of :class:`ReproduceSettings`.

    Raises:
        FileError: If the file cannot be read.
        FitError: If it cannot be fitted; the message says why.
        ReproduceError: If nobody walks in it.
    """
    chosen = ReproduceSettings(**settings)
    loaded = load(Path(path), chosen)
    trial = analyse(fit(loaded, chosen), chosen)
    return reproduce_trial(trial, chosen.tasks, chosen.dynamics)


def write(
    reproduced: Reproduced,
    out: Path,
    *,
    title: str,
    command: Sequence[str],
    settings: ReproduceSettings,
    sources: Sequence[Path],
    seed: int = 0,
    overwrite: bool = False,
    extra: dict[str, Any] | None = None,
) -> tuple[Path, dict[str, Any]]:
    """Write the run folder of a reproduced gait; return it and its metrics."""
    from plantigrade import __version__
    from plantigrade.motion import Table
    from plantigrade.record.folder import source_files, write_run
    from plantigrade.record.npz import npz_bytes
    from plantigrade.report.reproduction import FILE

    human, record = reproduced.reference.human, record_of(reproduced)
    drawn = drawing(reproduced)
    metrics = {
        "status": status(reproduced),
        "version": __version__,
        "command": " ".join(command),
        "settings": {k: str(v) if isinstance(v, Path) else v for k, v in asdict(settings).items()},
        "seed": seed,
        "source_files": source_files(sources),
        **record.metrics,
        **(extra or {}),
        "warnings": list(record.warnings),
        "title": title,
        "sentence": sentence(reproduced),
    }
    record = replace(record, metrics=metrics)
    names, values = human.to_coordinates(record.motion.qpos)
    forces = forced_record(reproduced)
    files = pages(human.model, record, drawn, forces) | {FILE: drawn.to_npz()}
    folder = write_run(
        out,
        model_xml=human.xml,
        record=record,
        metrics=metrics,
        coordinates=Table(names, record.motion.time, values),
        files=files | ({FORCES: npz_bytes(forces)} if forces is not None else {}),
        overwrite=overwrite,
    )
    return folder, metrics


def pages(
    model, record: "Record", drawn: "Reproduction", forces: "Record | None" = None
) -> dict[str, str]:
    """Return the report and the viewer of a reproduced gait, by file name.

    Args:
        model: The body.
        record: The reproduced gait, with the run's metrics.
        drawn: What else the report draws.
        forces: The gait moved by forces; its forces are drawn on the reproduced gait, from which
            it hardly differs.
    """
    from plantigrade.report.reproduction import facts_of, reproduction_sections
    from plantigrade.report.run_report import run_pages

    shown = record
    if forces is not None and record.metrics.get("dynamics_status") == "ok":
        shown = replace(record, qfrc_actuator=forces.qfrc_actuator, **by_foot(forces))
    return run_pages(
        model,
        shown,
        title=record.metrics["title"],
        sentence=record.metrics["sentence"],
        first=reproduction_sections(drawn),
        facts=facts_of(record.metrics),
        reference="recorded",
    )


def by_foot(forces: "Record") -> dict[str, Any]:
    """Return the forces of a record, one to a foot at its centre of pressure, as its fields."""
    from plantigrade.report.scene import side_forces

    total, point = side_forces(forces, 0.0)
    assert total is not None and point is not None
    return {
        "contact_force": total[:, :2],
        "contact_point": point[:, :2],
        "contact_side": ("r", "l"),
        "contact_segment": ("foot", "foot"),
    }


def record_of(reproduced: Reproduced) -> "Record":
    """Return the reproduced gait as a record, the recorded one beside it."""
    from plantigrade.motion import Motion
    from plantigrade.record import Record

    reference, motion = reproduced.reference, reproduced.motion
    trial = reproduced.trial
    metrics = dict(trial.record.metrics)
    metrics |= {"frames": len(motion.time), "duration_s": float(motion.time[-1] - motion.time[0])}
    return Record(
        motion=Motion(
            motion.time,
            motion.qpos,
            motion.qvel,
            reference.human.joint_names,
            motion.qacc,
            reference.events,
        ),
        reference_qpos=reference.at(motion.time),
        metrics=metrics | figures(reproduced),
        warnings=(*trial.record.warnings, *notes(reproduced)),
    )


def forced_record(reproduced: Reproduced) -> "Record | None":
    """Return the gait moved by forces as a record of its own: they satisfy its motion alone."""
    from plantigrade.motion import Motion
    from plantigrade.record import Record

    forced, reference = reproduced.forced, reproduced.reference
    if forced is None:
        return None
    names = reference.human.joint_names
    return Record(
        motion=Motion(forced.time, forced.qpos, forced.qvel, names, forced.qacc, reference.events),
        qfrc_actuator=forced.tau,
        contact_force=forced.contact_force,
        contact_point=np.where(forced.contact_force[..., 2:] > 0, forced.contact_point, np.nan),
        contact_side=forced.side,
        contact_segment=forced.segment,
        reference_qpos=reference.at(forced.time),
    )


def figures(reproduced: Reproduced) -> dict[str, Any]:
    """Return the figures of a reproduced gait: against the recorded one, and how long it took."""
    motion, comparison = reproduced.motion, reproduced.comparison
    ticks = 1e6 * motion.solver_time, 1e6 * motion.state_time
    found: dict[str, Any] = {
        "tasks": reproduced.tasks,
        "task_order": list(motion.names),
        "reproduced_from_s": float(motion.time[0]),
        "reproduced_to_s": float(motion.time[-1]),
        "cycles_count": len(comparison.cycles),
        **comparison.metrics(),
        "step_s": float(motion.time[1] - motion.time[0]),
        "reproduce_time_s": reproduced.seconds,
        "tick_solver_median_us": float(np.median(ticks[0])),
        "tick_kinematics_median_us": float(np.median(ticks[1])),
        "ticks_exact_pct": 100.0 * float(np.mean(motion.exact)),
    }
    seconds = seconds_per_cycle(reproduced)
    if seconds is not None:
        found["time_per_cycle_s"] = seconds
    return found | force_figures(reproduced)


def force_figures(reproduced: Reproduced) -> dict[str, Any]:
    """Return the figures of the gait moved by forces, beside the measured forces where known."""
    from plantigrade.analyze.gait_forces import compare_forces
    from plantigrade.analyze.reproduction import compare

    forced, reference = reproduced.forced, reproduced.reference
    if forced is None:
        return {}
    held = compare(reference, forced).metrics()
    weight = _weight(reference)
    found: dict[str, Any] = {
        "dynamics_status": dynamics_status(reproduced),
        "equations_residual_max_bw": float(np.abs(forced.root_residual[:, :3]).max() / weight),
        **{
            f"dynamics_{key}": held[key]
            for key in (
                "rom_error_mean_deg", "rom_error_max_deg", "com_error_max_mm",
                "contact_drift_max_mm", "sole_lowest_mm",
            )
            if key in held
        },
    }  # fmt: skip
    trial = reproduced.trial
    if trial.forces is None or found["dynamics_status"] != "ok":
        return found
    held = compare_forces(
        reference, forced, trial.forces, trial.moments, ground=_ground(reproduced)
    ).metrics()
    return found | {k: v for k, v in held.items() if np.isfinite(v) and not k.startswith("forced")}


def _ground(reproduced: Reproduced) -> np.ndarray:
    """Return the path of the ground, a treadmill's belt, over the recorded frames (n, 3) [m]."""
    way = reproduced.trial.record.motion.qpos[:, :3] - reproduced.reference.qpos[:, :3]
    return way - way[0]


def dynamics_status(reproduced: Reproduced) -> str:
    """Return ``"ok"``, or when and how the gait moved by forces was lost."""
    forced, reference = reproduced.forced, reproduced.reference
    if forced is None:
        return "not asked for"
    if forced.stopped:
        return f"it ended early, {_when(reference, forced.time[-1])}: {forced.stopped}"
    away = com_error(reference, forced)
    if away.max() > FALLEN:
        first = forced.time[np.argmax(away > FALLEN)]
        return (
            f"the body fell: its centre of mass was more than {100 * FALLEN:.0f} cm off its path, "
            f"{_when(reference, first)}"
        )
    return "ok"


def measured_forces(reproduced: Reproduced):
    """Return what was measured, at the ticks of the gait moved by forces; None without plates.

    Returns:
        Ground reaction on each foot, right and left (n, 2, 3) [body weights], and joint moments
        (n, n_moments) [N m/kg]; NaN where not known.
    """
    trial, forced, reference = reproduced.trial, reproduced.forced, reproduced.reference
    if forced is None or trial.forces is None or trial.moments is None:
        return None
    frames, now = trial.record.motion.time, forced.time
    force = np.full((len(now), 2, 3), np.nan)
    moment = np.full((len(now), len(SHOWN_MOMENTS)), np.nan)
    for k, side in enumerate(("r", "l")):
        row = trial.forces.sides.index(side)
        known = np.interp(now, frames, trial.forces.valid_side[:, row].astype(float)) > 0.999
        for axis in range(3):
            here = np.interp(now, frames, trial.forces.force[:, row, axis])
            force[known, k, axis] = here[known] / _weight(reference)
        for i, name in enumerate(SHOWN_MOMENTS):
            if name.endswith(f"_{side}"):
                tau = trial.moments.tau[:, 6 + trial.fit.human.hinge(name)] / reference.human.mass
                moment[known, i] = np.interp(now, frames, tau)[known]
    return (force, moment) if np.isfinite(force).any() else None


def _moments(reproduced: Reproduced) -> np.ndarray:
    """Return the computed joint moments that are shown (n, n_moments) [N m/kg]."""
    human, forced = reproduced.reference.human, reproduced.forced
    assert forced is not None
    return forced.tau[:, [6 + human.hinge(name) for name in SHOWN_MOMENTS]] / human.mass


def _weight(reference: "Reference") -> float:
    """Return the body weight [N]."""
    return reference.human.mass * float(np.linalg.norm(reference.human.model.opt.gravity))


def seconds_per_cycle(reproduced: Reproduced) -> float | None:
    """Return how long one gait cycle took to reproduce [s]; None where there is no whole one."""
    time, cycles = reproduced.motion.time, reproduced.comparison.cycles
    if not cycles:
        return None
    stride = float(np.mean([c.duration for c in cycles]))
    return reproduced.seconds * stride / float(time[-1] - time[0])


def status(reproduced: Reproduced) -> str:
    """Return ``"ok"``, or what went wrong, where and when."""
    motion, reference = reproduced.motion, reproduced.reference
    look = "; the report's “What each level missed” shows which task gave way first"
    if motion.stopped:
        return (
            f"the motion ended early, {_when(reference, motion.time[-1])}: {motion.stopped}{look}"
        )
    away = com_error(reference, motion)
    if away.max() > COM_LIMIT:
        first = motion.time[np.argmax(away > COM_LIMIT)]
        return (
            f"the centre of mass left its path by more than {100 * COM_LIMIT:.0f} cm, "
            f"{_when(reference, first)} (at most {100 * away.max():.0f} cm off){look}"
        )
    off = np.linalg.norm(motion.qpos[:, :3] - reference.at(motion.time)[:, :3], axis=1)
    if off.max() > PELVIS_LIMIT:
        first = motion.time[np.argmax(off > PELVIS_LIMIT)]
        return (
            f"the pelvis wandered more than {100 * PELVIS_LIMIT:.0f} cm from the recorded one, "
            f"{_when(reference, first)}{look}"
        )
    return "ok"


def _when(reference: "Reference", time: float) -> str:
    """Return an instant in words."""
    words = f"{time:.2f} s into the recording"
    for phase in reference.phases:
        if phase.start <= time <= phase.stop:
            side = {"r": "right", "l": "left"}[phase.swing]
            what = "in double support before the" if phase.kind == "double" else "while the"
            verb = "foot swings"
            return f"{words}, {what} {side} {verb}"
    return words


def sentence(reproduced: Reproduced) -> str:
    """Return what was done, in one sentence."""
    motion, comparison = reproduced.motion, reproduced.comparison
    human = reproduced.reference.human
    n = len(comparison.cycles)
    m = comparison.metrics()
    text = (
        f"The gait of {reproduced.trial.fit.recording.source.name} "
        f"({motion.time[-1] - motion.time[0]:.2f} s, {n} stride{'' if n == 1 else 's'}) "
        f"rebuilt from the ordered tasks “{reproduced.tasks}” on a person of "
        f"{human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees of freedom, "
        f"in {reproduced.seconds:.1f} s; the centre of mass within "
        f"{m['com_error_max_mm']:.1f} mm of its path"
    )
    if "rom_error_mean_deg" in m:
        text += f", ranges of motion {m['rom_error_mean_deg']:.1f}° off on the mean"
    return text + "."


def notes(reproduced: Reproduced) -> list[str]:
    """Return what the user should know of how the recording was used."""
    reference, motion = reproduced.reference, reproduced.trial.record.motion
    found = []
    if len(reference.events) < len(motion.events):
        found.append(
            f"of {len(motion.events)} gait events the longest run of steps was reproduced: "
            f"{len(reference.events)} events, {reference.start:.2f} to {reference.stop:.2f} s."
        )
    moved = (
        motion.qpos[-1, :2] - motion.qpos[0, :2] - reference.qpos[-1, :2] + reference.qpos[0, :2]
    )
    way = float(np.linalg.norm(moved))
    if way > 0.5:
        speed = way / (motion.time[-1] - motion.time[0])
        found.append(
            f"the ground moves at {speed:.2f} m/s (a treadmill); the gait was reproduced over "
            "ground that rests."
        )
    fallen = dynamics_status(reproduced)
    if reproduced.forced is not None and fallen != "ok":
        found.append(
            f"of the gait moved by forces: {fallen}; its ground reactions and joint moments are "
            "drawn up to there only."
        )
    return found


def com_error(reference: "Reference", motion: "OrderedMotion") -> np.ndarray:
    """Return the distance of the centre of mass from its path at each tick [m]."""
    from plantigrade.kinematics.state import State

    state = State(reference.human, motion.qpos[0])
    away = np.empty(len(motion.time))
    for k, (time, qpos, qvel) in enumerate(zip(motion.time, motion.qpos, motion.qvel, strict=True)):
        state.move_to(qpos, qvel)
        away[k] = np.linalg.norm(state.com - reference.com(float(time))[0])
    return away


def drawing(reproduced: Reproduced) -> "Reproduction":
    """Return what the report draws of a reproduced gait."""
    from plantigrade.kinematics.sole_paths import sole_paths
    from plantigrade.report.reproduction import SIDES, Reproduction, stacked
    from plantigrade.reproduce.gait import gait_order, gait_tasks, phase_ends

    reference, motion, comparison = reproduced.reference, reproduced.motion, reproduced.comparison
    chosen = gait_tasks(reproduced.tasks)
    order = gait_order(reference, chosen)
    level = [k for k, tasks in enumerate(order.levels, start=1) for _ in tasks]
    tasks = list(order.tasks)
    if order.posture is not None:
        level.append(len(order.levels) + 1)
        tasks.append(order.posture)
    names = tuple(comparison.rom)
    ground = [
        sole_paths(reference.human, qpos) for qpos in (motion.qpos, reference.at(motion.time))
    ]
    soles = [
        np.stack(
            [g.position[:, [s == side for s in g.side], 2].min(axis=1) for side in SIDES], axis=1
        )
        for g in ground
    ]
    return Reproduction(
        tasks=reproduced.tasks,
        names=motion.names,
        level=np.array(level),
        meanings=tuple(_meaning(task) for task in tasks),
        time=motion.time,
        active=motion.active,
        residual=motion.residual,
        phase=np.array([(p.start, p.stop) for p in reference.phases]),
        phase_kind=tuple(p.kind for p in reference.phases),
        phase_swing=tuple(p.swing for p in reference.phases),
        posture_end=phase_ends(reference, chosen.phases) if chosen.posture else np.zeros(0),
        contact=np.array([(c.start, c.stop) for c in reference.contacts]).reshape(-1, 2),
        contact_place=tuple(f"{c.region}_{c.side}" for c in reference.contacts),
        percent=comparison.percent,
        coordinates=names,
        simulated=stacked([comparison.curves_simulated[n] for n in names]),
        recorded=stacked([comparison.curves_reference[n] for n in names]),
        rom=np.array([comparison.rom[n] for n in names]),
        rmse=np.array([comparison.rmse[n] for n in names]),
        correlation=np.array([comparison.correlation[n] for n in names]),
        com_error=com_error(reference, motion),
        sole=soles[0],
        sole_recorded=soles[1],
        **_drawn_forces(reproduced),
    )


def _drawn_forces(reproduced: Reproduced) -> dict[str, Any]:
    """Return the fields of the forces, up to where the body fell if it did."""
    forced, reference = reproduced.forced, reproduced.reference
    if forced is None:
        return {}
    fell = com_error(reference, forced) > FALLEN
    upto = int(np.argmax(fell)) if fell.any() else len(forced.time)
    feet = np.stack([forced.foot(side)[0] for side in ("r", "l")], axis=1)
    fields: dict[str, Any] = {
        "force_time": forced.time[:upto],
        "force": feet[:upto] / _weight(reference),
        "moment_names": SHOWN_MOMENTS,
        "moment": _moments(reproduced)[:upto],
    }
    measured = measured_forces(reproduced)
    if measured is not None:
        fields |= {"force_measured": measured[0][:upto], "moment_measured": measured[1][:upto]}
    return fields


def _meaning(task) -> str:
    """Return the first line of what a kind of task says of itself."""
    return (type(task).__doc__ or "").strip().split("\n")[0].replace("`", "")
