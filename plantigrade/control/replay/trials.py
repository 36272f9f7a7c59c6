"""Trials of a replayed motion: whether the person stays upright, and under which pushes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.control.gait.clearance import MAX_LEG_OVERLAP, LegOverlap
from plantigrade.control.gait.person import world_sites
from plantigrade.control.replay import Replay
from plantigrade.notes import Info
from plantigrade.record import Record
from plantigrade.threads import on_one_thread
from plantigrade.world import Command, Disturbance, InitialState, Push, world_for
from plantigrade.world.model_mismatch import ModelMismatch

VELOCITY_NOISE_SD = 0.05  # Of every initial velocity [m/s, rad/s]. Chosen.
HOLD_DURATION = 1.0  # Time for which a motion that ends at rest is held [s]. Chosen.
PUSH_DURATION = 0.2  # Duration of a push [s]. Chosen.
CERTIFICATE_FORCES = (50.0, 100.0)  # Forces of the pushes of a certificate [N]. Chosen.
CERTIFICATE_WATCH = 1.5
"""Time for which the person must stay upright after such a push began [s]. Chosen."""
LATEST_PUSH = 2.0  # Latest time of such a push [s]. Chosen.
DIRECTIONS = {"forward": 0.0, "left": np.pi / 2, "back": np.pi, "right": -np.pi / 2}
"""Direction of a push → its angle from the heading, counter-clockwise [rad]."""


@dataclass(frozen=True)
class ReplayOutcome:
    """Outcome of a replay."""

    survived: bool  #: Whether the person was upright at the end
    seconds: float  #: Time for which they were [s]
    error: float  #: RMS error of the joint angles [rad]
    off_path: float  #: Horizontal error of the centre of mass at the end [m]
    figures: dict[str, float | int]  #: Figures of the touchdowns
    overlap: float = 0.0  #: Largest depth of one leg in the other [m]


@on_one_thread
def replay_once(
    record: Record | Replay,
    duration: float | None = None,
    *,
    seed: int = 0,
    acting: Sequence[Disturbance] = (),
    mismatch: ModelMismatch | None = None,
) -> ReplayOutcome:
    """Replay a motion in a world and return the outcome.

    Args:
        record: The motion, or its controller where the same one serves many replays.
        duration: Duration [s]; a motion that ends at rest is held a while if absent.
        seed: Of the noise; 0: an undisturbed start.
        acting: Further disturbances.
        mismatch: Differences from the plan.
    """
    controller = record if isinstance(record, Replay) else Replay(record)
    record = controller.record
    how = replace(mismatch or ModelMismatch(), start=VELOCITY_NOISE_SD if seed else 0.0)
    motion = record.motion
    qpos, qvel = how.initial_state(record.human, motion, record.ground, seed)
    world = world_for(
        controller,
        InitialState(record.human, how.ground_of(record.ground), qpos, qvel),
        acting,
        recording=False,
        sites=[s for s in world_sites(record) if not s.side],
        seed=seed,
    )
    how.apply(world)
    if duration is None:
        duration = motion.duration + HOLD_DURATION * controller.reference.ends
    acts, state = how.wrapped(controller), world.reset()
    squares: list[float] = []
    legs = LegOverlap(world)
    while world.time < duration - 1e-6 and world.fall is None and world.diverged is None:
        command = acts(state)
        assert isinstance(command, Command)  # of a replay
        squares.append(float(np.square(command.signals["tracking_error"])))
        state = world.step(command)
        legs.update()
    survived = world.fall is None and world.diverged is None
    figures = dict(controller.summary().figures)
    error = float(np.sqrt(np.mean(squares)))
    off = float(figures["off_path_end_m"])
    return ReplayOutcome(survived, world.time, error, off, figures, legs.deepest)


def largest_push(
    controller: Replay,
    time: float,
    direction: float,
    forces: Sequence[float],
    *,
    after: float = 3.5,
) -> float:
    """Return the largest push at the upper trunk that is survived from a disturbed start [N].

    Found by bisection: a person who survives a force is assumed to survive smaller ones. 0: not
    even the first. A push is not survived where one leg goes through the other
    (:data:`MAX_LEG_OVERLAP`).

    Args:
        time: When it begins [s].
        direction: Where to: 0 forward, a quarter turn to the left [rad].
        forces: To be tried, in rising order [N].
        after: Time that the person must stay on the feet after it began [s].
    """

    def survived(force: float) -> bool:
        push = Push(force=force, duration=PUSH_DURATION, direction=direction, time=time)
        found = replay_once(controller, time + after, seed=1, acting=(push,))
        return found.survived and found.overlap <= MAX_LEG_OVERLAP

    low, high = 0, len(forces)  # so many are survived: at least, at most
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if survived(forces[middle - 1]) else (low, middle - 1)
    return forces[low - 1] if low else 0.0


def certificate(record: Record) -> dict[str, Any]:
    """Return whether a motion survives in the physical world, its error, and what push it survives.

    One undisturbed and one disturbed start; pushes forward, back and to the sides in the middle of
    the motion, of 50 and 100 N.
    """
    controller = Replay(record)
    found = [replay_once(controller, seed=seed) for seed in (0, 1)]
    survived = all(each.survived for each in found)
    pushes: dict[str, float] = {}
    if survived:
        middle = min(0.5 * record.motion.duration, LATEST_PUSH)
        for name, angle in DIRECTIONS.items():
            pushes[name] = largest_push(
                controller, middle, angle, CERTIFICATE_FORCES, after=CERTIFICATE_WATCH
            )
    return {
        "replay_survived": survived,
        "replay_seconds": min(each.seconds for each in found),
        "replay_error_rms_deg": float(np.rad2deg(max(each.error for each in found))),
        "replay_off_path_end_m": max(each.off_path for each in found),
        **{f"replay_push_{name}_n": force for name, force in pushes.items()},
    }


def certified(figures: dict[str, Any]) -> str:
    """Return the certificate of a motion in one sentence."""
    if not figures["replay_survived"]:
        return f"In simulation the person falls after {figures['replay_seconds']:.2f} s."
    pushes = [v for k, v in figures.items() if k.startswith("replay_push_")]
    weakest = min(pushes)
    way = next(
        k.split("_")[2] for k, v in figures.items() if k.startswith("replay_push_") and v == weakest
    )
    held = (
        f"a push of {weakest:.0f} N for {PUSH_DURATION:g} s in every direction tried"
        if weakest
        else f"not every push of {CERTIFICATE_FORCES[0]:.0f} N (weakest: {way})"
    )
    off, beside = figures["replay_error_rms_deg"], 100.0 * figures["replay_off_path_end_m"]
    return Info(
        f"In simulation the person stays upright, {off:.1f}° off the motion and "
        f"{beside:.0f} cm beside its path at the end; on the way it withstands {held}."
    )
