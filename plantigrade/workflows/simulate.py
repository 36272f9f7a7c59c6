"""A person in the physical world: who, on what, moved by what; simulate; a Run."""

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import ContactSite
from plantigrade.control import Posture, Situation, controller_named
from plantigrade.control.choices import STANDING, usual
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.options import as_path
from plantigrade.record import Provenance, Record, Run
from plantigrade.record.folder import METRICS
from plantigrade.record.provenance import source_files
from plantigrade.workflows.fit import Step, fit_trial, personal_figures, silent
from plantigrade.workflows.fit import provenance as fit_provenance
from plantigrade.workflows.settings import SimulateSettings
from plantigrade.workflows.threads import on_one_thread
from plantigrade.world import Controller, Disturbance, Push, World, on_ground, standing_on
from plantigrade.world.grounds import ground_named, platform_named

STANDS = 5.0
"""How long a person stands where no duration is named [s]."""
SETTLING = 1.0
"""So long a person stands before the first frame, until soles and springs are at rest [s]."""
FARTHEST = 0.05
"""A start whose feet are farther from the ground than this is a flight, and left as it is [m]."""
FOLLOWED = "motion"
"""Name of the reference that is followed."""


@dataclass(frozen=True)
class Start:
    """Who starts, and from what.

    Attributes:
        human: The person.
        ground: What the motion happened on.
        motion: What they did there; None where they just stand.
        sites: Further places of the body that seats carry.
        name: What it is called.
        provenance: Where it comes from.
        figures: What is known of the person.
        notes: What the user should know of it.
    """

    human: Human
    ground: Ground
    name: str
    provenance: Provenance
    motion: Motion | None = None
    sites: tuple[ContactSite, ...] = ()
    figures: Mapping[str, Any] | None = None
    notes: tuple[str, ...] = ()


@on_one_thread
def simulate(
    source: str | Path | Run | None = None,
    settings: SimulateSettings | None = None,
    *,
    controller: str | Controller | None = None,
    disturbances: Sequence[Disturbance] = (),
    step: Step = silent,
    command: str = "",
    **options: Any,
) -> Run:
    """Simulate a person in the physical world.

    Args:
        source: A recording, which is fitted first, or a run or its folder, which is taken as it
            is; without either a person stands.
        settings: What decides the result.
        controller: One of :data:`plantigrade.control.CONTROLLERS` by name, or your own
            ``controller(state) -> command``.
        disturbances: What acts beside the pushes of the settings.
        step: Shows progress.
        command: The command line, for the provenance.
        options: Fields of ``settings`` by name, such as ``height=1.80`` [m], ``ground="slope:5"``
            or ``push=("100,0.2,90,1",)``; they replace those of ``settings``.

    Returns:
        A run; its ``status`` says whether, when and how the person fell.

    Raises:
        ParameterError: If there is no such option, or a value is not allowed.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.

    Example:
        >>> import plantigrade as pg
        >>> run = pg.simulate(duration=2.0, push=("60,0.2,0,0.5",))  # doctest: +SKIP
    """
    if isinstance(controller, str):
        options["controller"] = controller
    how = SimulateSettings.given("simulate", settings, options)
    pushes = tuple(Push.written(word) for word in how.push)
    plate = None if how.ground is None else platform_named(how.ground)
    level = "flat" if plate else how.ground
    named = None if level is None else ground_named(level, seed=how.seed)
    moving = () if plate is None else (plate,)
    begin = _start(source, how, step, command)
    ground = begin.ground if named is None else named
    moved_by = controller if callable(controller) else None
    word = how.controller or usual(begin.motion)
    if moved_by is None:
        moved_by = controller_named(word, situation(begin, ground, how))
    elif how.controller is None:
        word = getattr(controller, "__name__", type(controller).__name__)
    with step("simulating"):
        began = clock.perf_counter()
        qpos, qvel = _state(begin, ground, how)
        world = World(
            begin.human,
            ground,
            (*moving, *pushes, *disturbances),
            rate=how.rate,
            control_rate=how.control_rate,
            torque_rise=how.torque_rise,
            seed=how.seed,
            sites=begin.sites,
            qpos=qpos,
            qvel=qvel,
        )
        record = world.simulate(moved_by, _duration(begin, how))
        seconds = clock.perf_counter() - began
    return _run(begin, how, world, record, word, seconds)


def _start(source: Any, how: SimulateSettings, step: Step, command: str) -> Start:
    """Return who starts."""
    if source is None:
        human = how.human()
        return Start(human, Ground(), "standing", Provenance(command, how.plain(), seed=how.seed))
    if not isinstance(source, Run):
        path = as_path(source, "what is simulated")
        if not (path / METRICS).is_file():
            recording, trial = fit_trial(path, how, step)
            origin = fit_provenance(recording, how, command, how.seed)
            return _of_trial(recording.source.name, trial, origin)
        source = Run.load(path)
    if how.known:
        raise ParameterError(
            f"a run has its own person: leave out {', '.join(how.known)}, or name the recording"
        )
    record, folder = source.record, source.folder
    files = {} if folder is None else source_files([folder / METRICS])
    return Start(
        record.human,
        record.ground,
        source.name or source.kind,
        Provenance(command, how.plain(), files, how.seed),
        record.motion,
        _carriers(record),
    )


def _of_trial(name: str, trial: Trial, origin: Provenance) -> Start:
    record = trial.record()
    sites = _carriers(record)
    stem = Path(name).stem
    return Start(
        record.human, record.ground, stem, origin, record.motion, sites, None, record.notes
    )


def _carriers(record: Record) -> tuple[ContactSite, ...]:
    """Return the places on no foot that a seat carries."""
    seats = {seat.site for seat in record.ground.seats}
    return tuple(site for site in record.sites if site.name in seats and not site.measured)


def situation(begin: Start, ground: Ground, how: SimulateSettings) -> Situation:
    """Return what a controller is made for."""
    stands = None if begin.motion is not None else standing_on(begin.human, ground)
    return Situation(
        human=begin.human,
        ground=ground,
        motion=begin.motion,
        standing=stands,
        stiffness=how.stiffness,
    )


def _duration(begin: Start, how: SimulateSettings) -> float:
    if how.duration is not None:
        return how.duration
    return STANDS if begin.motion is None else max(begin.motion.duration, 1.0 / how.control_rate)


def _state(begin: Start, ground: Ground, how: SimulateSettings) -> tuple[Array, Array]:
    """Return where the person starts, and how fast."""
    if begin.motion is not None:
        qpos = begin.motion.qpos[0]
        placed = on_ground(begin.human, ground, qpos)
        near = abs(placed[2] - qpos[2]) <= FARTHEST or how.ground is not None
        return placed if near else qpos, begin.motion.qvel[0]
    # Settled: the soles pressed into the ground as far as they will be.
    world = World(
        begin.human, ground, rate=how.rate, control_rate=how.control_rate, recording=False
    )
    hold, state = Posture(how.stiffness, standing_on(begin.human, ground)), world.reset()
    while world.time < SETTLING and world.fall is None and world.diverged is None:
        state = world.step(hold(state))
    if world.fall is not None or world.diverged is not None:  # nobody can stand there: so be it
        return standing_on(begin.human, ground), np.zeros(begin.human.model.nv)
    return np.array(state.qpos), np.array(state.qvel)


def _run(
    begin: Start, how: SimulateSettings, world: World, record: Record, word: str, seconds: float
) -> Run:
    """Return the run of a simulation."""
    status = "ok"
    if world.fall is not None:
        status = f"the person {world.fall}"
    if world.diverged is not None:
        status = f"the simulation diverged at {world.diverged:.2f} s"
    references: dict[str, Motion] = {}
    if begin.motion is not None and word not in ("passive", STANDING):
        motion = begin.motion
        references[FOLLOWED] = replace(motion, time=motion.time - motion.time[0])
    figures = {
        "controller": word,
        "ground": how.ground or ("flat" if begin.motion is None else "of the motion"),
        "duration_s": record.motion.duration,
        "on_feet": world.fall is None and world.diverged is None,
        **({} if world.fall is None else {"fell_at_s": world.fall.time}),
        **({} if world.diverged is None else {"diverged_at_s": world.diverged}),
        **figures_of(record),
        **personal_figures(how),
    }
    notes = tuple(dict.fromkeys((*begin.notes, *record.notes)))
    return Run(
        replace(record, references=references, notes=notes),
        "simulate",
        title=f"{begin.name}, simulated",
        sentence=_sentence(begin, how, record, word),
        status=status,
        figures=figures,
        provenance=begin.provenance,
        seconds={"simulate": seconds},
        name=f"simulate-{begin.name}",
    )


def figures_of(record: Record) -> dict[str, float]:
    """Return what a simulation shows: forces, torques, how far the controller was off."""
    figures: dict[str, float] = {}
    feet = sum(record.foot(side).force[:, 2] for side in SIDES)
    figures["vertical_force_mean_bw"] = float(np.mean(feet) / record.weight)
    figures["vertical_force_max_bw"] = float(np.max(feet) / record.weight)
    low, high = np.array(record.human.model.jnt_actfrcrange[1:]).T
    motor = record.signals["world.motor"]
    use = np.abs(motor) / np.where(motor > 0, high, -low)
    figures["motor_torque_max_pct"] = float(100.0 * use.max())
    if "controller.tracking_error" in record.signals:
        error = record.signals["controller.tracking_error"]
        figures["tracking_error_rms_deg"] = float(np.rad2deg(np.sqrt(np.nanmean(error**2))))
    return figures


def _sentence(begin: Start, how: SimulateSettings, record: Record, word: str) -> str:
    human = begin.human
    what = "A person" if begin.motion is None else f"The person of {begin.name}"
    pushes = {0: "", 1: ", pushed once"}.get(len(how.push), f", pushed {len(how.push)} times")
    return (
        f"{what} of {human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees of "
        f"freedom and {human.feet} feet, moved by {word}{pushes}: {record.motion.duration:.2f} s "
        f"of physics at {how.rate:g} Hz, commands at {how.control_rate:g} Hz."
    )
