"""A recorded gait rebuilt from ordered tasks: fit, reproduce, compare, write."""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from plantigrade.workflows.fitting import FitSettings, analyse, fit, load

if TYPE_CHECKING:
    from plantigrade.analyze.reproduction import Comparison
    from plantigrade.analyze.trial import Trial
    from plantigrade.reproduce.dynamics import ForcedMotion
    from plantigrade.reproduce.ordered_motion import OrderedMotion
    from plantigrade.reproduce.reference import Reference

COM_LIMIT = 0.05  # a centre of mass further off its path is not on it [m]
PELVIS_LIMIT = 0.30  # a pelvis further from the recorded one has wandered off [m]


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
    from plantigrade.reproduce.ordered_motion import move

    chosen = gait_tasks(tasks)
    trial = whole_cycles(trial)
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
    return Reproduced(trial, reference, motion, forced, compare(reference, motion), seconds, tasks)


def reference_of_trial(trial: "Trial") -> "Reference":
    """Return what the tasks see of an analysed recording: on ground that rests.

    Raises:
        ReproduceError: If nobody walks in it.
    """
    from plantigrade.kinematics.ground import moving_ground
    from plantigrade.reproduce.reference import reference_of

    motion = trial.record.motion
    return reference_of(
        trial.fit.human,
        motion.time,
        motion.qpos,
        motion.events,
        ground=moving_ground(trial.fit.time, trial.feet.heel, trial.feet.toe),
    )


def whole_cycles(trial: "Trial") -> "Trial":
    """Return the recording, repeated where it is one cycle that shows no whole stride of a foot."""
    from plantigrade.analyze.trial import analyse as analyse_trial
    from plantigrade.motion.cycles import cut_cycles
    from plantigrade.reproduce.phases import walking_events
    from plantigrade.reproduce.unroll import find_loop, unroll

    if cut_cycles(walking_events(trial.record.motion.events)):
        return trial
    fitted = trial.fit
    loop = find_loop(fitted.human, fitted.time, fitted.qpos)
    if loop is None:
        return trial
    time, qpos = unroll(fitted.time, fitted.qpos, loop)
    repeated = replace(
        fitted,
        time=time,
        qpos=qpos,
        recording=replace(fitted.recording, plates=()),
        markers=None,
        residual=None,
        kept=None,
        warnings=(
            *fitted.warnings,
            f"the recording is one cycle of {loop.period:.2f} s that closes on itself; it was "
            "repeated three times, and the gait was found in the repetition.",
        ),
    )
    return analyse_trial(repeated, mass=fitted.human.mass)


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
