"""A person in the physical world: who, on what, moved by what; simulate; a Run."""

import re
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass, replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.impact import force_on_feet, impact_notes
from plantigrade.control.choices import STANDING
from plantigrade.control.gait.reference import period_of
from plantigrade.control.numbers import numbers_of
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.kinematics.posture import lean_figures
from plantigrade.motion import Motion
from plantigrade.notes import Info
from plantigrade.options import shown
from plantigrade.record import Provenance, Record, Run
from plantigrade.signatures import Option, options_of, takes
from plantigrade.threads import on_one_thread
from plantigrade.workflows.controller_options import CLASSES
from plantigrade.workflows.fit import personal_figures
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulated_world import surroundings, world_of
from plantigrade.workflows.simulation_start import Start, controller_of, start_of
from plantigrade.workflows.steps import Step, silent
from plantigrade.workflows.styles import THEN, timed
from plantigrade.world import (
    AnyController,
    Controller,
    Disturbance,
    PhasePush,
    World,
    controller_from,
)
from plantigrade.world.model_mismatch import ModelMismatch

STANDING_DURATION = 5.0  # [s] how long a person stands where no duration is named
AFTER_FALL = 1.0  # [s] how long a simulation goes on after a fall, for the body to come to lie
MIN_DURATION = 0.01  # [s] shortest simulation of a motion
MAX_TRACKING_ERROR = 10.0
"""Root mean square error of joints from a motion above which a simulation does not show it [°]:
recorded walks, squats and chairs stay below 7°, runs and jumps reach 13° to 18°."""
FOLLOWED = "motion"  # Name of the reference that is followed
CONTROLLER_SETTINGS = Option(
    "controller_settings",
    Any,
    None,
    "Settings of the controller: its settings object, or values by dotted name, such as "
    '``{"swing.clearance": 0.05}`` [m].',
)
SIMULATION_OPTIONS = [
    *options_of(SimulateSettings, without=("norms", "own")),
    *(option for kind in dict.fromkeys(CLASSES.values()) for option in options_of(kind)),
    CONTROLLER_SETTINGS,
]
"""Options of a simulation: its own, then those of single controllers."""


@takes(more=SIMULATION_OPTIONS)
def simulate(
    source: str | Path | Run | None = None,
    settings: SimulateSettings | None = None,
    *,
    controller: str | AnyController | None = None,
    disturbances: Sequence[Disturbance] = (),
    **options: Any,
) -> Run:
    """Simulate a person in the physical world.

    Args:
        source: A recording, which is fitted first, or a run or its folder, which is taken as it
            is; without either a person stands.
        settings: What decides the result; options replace its fields.
        controller: One of :data:`plantigrade.control.CONTROLLERS` by name, or your own
            ``controller(state) -> command``.
        disturbances: Disturbances besides those of the settings.
        options: Fields of ``SimulateSettings``.

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
        options["controller"], controller = controller, None
    how = SimulateSettings.given("simulate", settings, options)
    return run_simulation(source, how, controller=controller, disturbances=disturbances)


@on_one_thread
def run_simulation(
    source: str | Path | Run | None,
    how: SimulateSettings,
    *,
    controller: AnyController | None = None,
    disturbances: Sequence[Disturbance] = (),
    step: Step = silent,
    command: str = "",
) -> Run:
    """Simulate with given settings: what :func:`simulate` and the command do.

    ``step`` shows progress, and ``command`` is for the provenance.
    """
    by_hand = [
        word for word in how.words.then if timed(word, "walk to go over to", THEN)[1] is None
    ]
    if by_hand:
        raise ParameterError(f"then={by_hand[0]!r} needs a time, except with --live: {THEN}")
    mismatch, acting = surroundings(how)
    own = None if controller is None else controller_from(controller)
    begin = start_of(source, how, step, command, own)
    ground, word = mismatch.ground_of(begin.ground), begin.controller
    moved_by = controller_of(begin, ground, how, word) if own is None else own
    how.refuse_unused(word)
    lasts = _duration(begin, how, moved_by)
    begins = [(_called(each), min(each.edges(), default=0.0)) for each in (*acting, *disturbances)]
    for what, first in (*begins, *(() if begin.walk is None else begin.walk.changes)):
        if first >= lasts:
            raise ParameterError(
                f"{what} would begin at {first:g} s, but the simulation lasts {lasts:g} s: give it "
                "a longer duration or an earlier time"
            )
    with step("simulating") as reached:
        began = clock.perf_counter()
        world = world_of(begin, mismatch, how, (*acting, *disturbances), moved_by)
        try:
            record = world.simulate(
                mismatch.wrapped(moved_by), lasts, after_fall=AFTER_FALL, reached=reached
            )
        except (ArithmeticError, ValueError, IndexError) as error:  # LinAlgError is a ValueError
            if not how.values or isinstance(error, PlantigradeError):
                raise
            raise ParameterError(
                f"with {', '.join(f'{n}={shown(v)}' for n, v in [*how.values.items()][:5])} the "
                f"controller {word} finds no command ({error!s:.80}): choose values nearer to the "
                "usual ones"
            ) from error
        seconds = clock.perf_counter() - began
    return run_of(begin, mismatch, how, world, record, word, seconds, moved_by)


def _called(disturbance: Disturbance) -> str:
    """Return what acts, by the name of its kind: a thrown box."""
    return "a " + re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(disturbance).__name__).lower()


def _duration(begin: Start, how: SimulateSettings, controller: Controller) -> float:
    if how.duration is not None:
        return how.duration
    if begin.motion is None:
        return STANDING_DURATION
    return max(controller.duration or begin.motion.duration, MIN_DURATION)


def _followed(motion: Motion, record: Record | None, lasts: float) -> Motion:
    """Return the motion that was followed from time zero on, as often as it was walked."""
    time = motion.time - motion.time[0]
    period, advance = (None, None) if record is None else period_of(record)
    if period is None:
        return replace(motion, time=time)
    again, n = max(ceil(lasts / period - 1e-6), 1), motion.n_frames - 1
    cycle, frame = np.divmod(np.arange(n * again + 1), n)
    cycle[-1], frame[-1] = again - 1, n
    qpos = motion.qpos[frame]
    qpos[:, :3] += cycle[:, None] * advance
    rates = motion.qvel[frame]
    return Motion(
        time[frame] + cycle * period, qpos, rates, motion.joint_names, None, motion.events
    )


def run_of(
    begin: Start,
    mismatch: ModelMismatch,
    how: SimulateSettings,
    world: World,
    record: Record,
    word: str,
    seconds: float,
    controller: Controller,
) -> Run:
    """Return the run of a simulation, with what its controller says of it."""
    summary = controller.summary()
    sentences = map(Info, summary.sentences)
    waited = [d.missed(world) for d in world.disturbances if isinstance(d, PhasePush)]
    missed = [sentence for sentence in waited if sentence]
    said = (*sentences, *missed, *_passed(record), *impact_notes(record))
    record = replace(record, notes=(*record.notes, *said))
    record, status = mismatch.corrected(record), "ok"
    if world.fall is not None:
        status = f"the person {world.fall}"
    if world.diverged is not None:
        status = f"the simulation diverged at {world.diverged:.2f} s"
    until = np.inf if world.fall is None else world.fall.time
    references: dict[str, Motion] = {}
    if begin.motion is not None and word not in ("passive", STANDING):
        references[FOLLOWED] = _followed(begin.motion, begin.record, record.motion.duration)
    figures = {
        "controller": word,
        "ground": how.ground or ("flat" if begin.motion is None else "of the motion"),
        "duration_s": record.motion.duration,
        "on_feet": world.fall is None and world.diverged is None,
        **({} if world.fall is None else {"fell_at_s": world.fall.time}),
        **({} if world.diverged is None else {"diverged_at_s": world.diverged}),
        **figures_of(record, until),
        **_leaning(record, references.get(FOLLOWED), until),
        **summary.figures,
        **personal_figures(how),
    }
    notes = tuple(dict.fromkeys((*begin.notes, *_unlike(figures), *record.notes)))
    return Run(
        replace(record, references=references, notes=notes),
        "simulate",
        title=f"{begin.name}, simulated",
        sentence=_sentence(begin, how, record, word, mismatch.summary),
        status=status,
        figures=figures,
        provenance=_with_numbers(begin.provenance, world, controller),
        seconds={"simulate": seconds},
        name=f"simulate-{begin.name}",
    )


def _with_numbers(provenance: Provenance, world: World, controller: Controller) -> Provenance:
    """Return where a run comes from, with its rates and the numbers of its controller."""
    settings = {**provenance.settings, "rate": world.rate, "control_rate": world.control_rate}
    if is_dataclass(controller.settings):
        numbers = {each.name: each.value for each in numbers_of(controller.settings)}
        settings["controller_settings"] = numbers
    return replace(provenance, settings=settings)


def figures_of(record: Record, until: float = np.inf) -> dict[str, float | bool]:
    """Return what a simulation shows: forces, torques, how far the controller was off.

    Args:
        until: Time of a fall [s], after which no motion is followed.
    """
    figures: dict[str, float | bool] = {}
    feet = force_on_feet(record)
    figures["vertical_force_mean_bw"] = float(np.mean(feet))
    figures["vertical_force_max_bw"] = float(np.max(feet))
    low, high = np.array(record.human.model.jnt_actfrcrange[1:]).T
    motor = record.signals["world.motor"]
    use = np.abs(motor) / np.where(motor > 0, high, -low)
    figures["motor_torque_max_pct"] = float(100.0 * use.max())
    if "barrier.clearance" in record.signals:
        figures["barrier_clearance_min_m"] = spare(record)
        figures["barrier_touched"] = touched(record)
    if "controller.tracking_error" in record.signals:
        error = record.signals["controller.tracking_error"][record.motion.time <= until]
        figures["tracking_error_rms_deg"] = float(np.rad2deg(np.sqrt(np.nanmean(error**2))))
    return figures


def _leaning(record: Record, followed: Motion | None, until: float) -> dict[str, float]:
    """Return how trunk and head leaned, and what was followed, until the person fell."""
    motion = record.motion
    figures = lean_figures(record.human, motion.qpos[motion.time <= until])
    own = {} if followed is None else lean_figures(record.human, followed.qpos)
    return figures | {name.replace("_deg", "_followed_deg"): own[name] for name in own}


def spare(record: Record) -> float:
    """Return how near the person came to a barrier, negative where they were in it [m]."""
    return float(np.nanmin(record.signals["barrier.clearance"]))


def touched(record: Record) -> bool:
    """Return whether a barrier stopped anything of the person."""
    into = record.signals["barrier.clearance"] < 0.0  # what stops is thinner than the skin
    force = record.contact_force
    others = [i for i, s in enumerate(record.sites) if s.name.startswith("touch_")]
    return force is not None and bool(np.abs(force[into][:, others]).any())


def _passed(record: Record) -> tuple[str, ...]:
    """Return a sentence on a barrier, if there was one near."""
    if "barrier.clearance" not in record.signals:
        return ()
    far = 100.0 * spare(record)
    if touched(record):
        return (f"The person hit the barrier, which pressed {-far:.1f} cm into the skin.",)
    return (Info(f"The person passed the barrier at a distance of {far:.1f} cm."),)


def _unlike(figures: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a warning where a person who stayed on the feet moved otherwise than the motion."""
    error = figures.get("tracking_error_rms_deg", 0.0)
    if not figures["on_feet"] or error <= MAX_TRACKING_ERROR:
        return ()
    return (
        f"joints are {error:.0f}° off the motion (root mean square): the person stayed on the feet "
        "by moving otherwise, and does not show how the recorded one moved.",
    )


def _sentence(begin: Start, how: SimulateSettings, record: Record, word: str, mismatch: str) -> str:
    human = begin.human
    what = "A person" if begin.motion is None else f"The person of {begin.name}"
    given = how.options
    asked = ", ".join(f"{n} {given[n]}" for n in ("speed", "path", "stoop") if n in given)
    led = f", {asked}" if asked else ""
    kinds = {"pushed": how.push, "pulled": how.rope, "hit": how.box}
    times = {1: "once", 2: "twice"}
    pushes = "".join(
        f", {what} {times.get(len(words), f'{len(words)} times')}"
        for what, words in kinds.items()
        if words
    )
    pushes += f", with a backpack of {how.load:g} kg" if how.load else ""
    pushes += (", on a shifting floor" if how.shift else "") + mismatch
    return (
        f"{what} of {human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees of "
        f"freedom and {human.feet} feet, simulated for {record.motion.duration:.2f} s with the "
        f"controller {word}{led}{pushes}."
    )
