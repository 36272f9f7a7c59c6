"""Measured forces of a trial: on the feet, on one clock with the motion, and what they tell.

Plates time gait events and weigh the person.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.analyze.body_mass import (
    WEIGHINGS,
    MeasuredMass,
    weigh_gait,
    weigh_jumps,
    weigh_standing,
)
from plantigrade.analyze.feet import FootPath
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES
from plantigrade.dynamics.centroid import Centroid, centroid
from plantigrade.dynamics.plate_clock import MIN_CORRECTION, clock_note, clock_offset, on_one_clock
from plantigrade.dynamics.plates import FootForces, assign_plates, over_plates, sole_points
from plantigrade.models import Human
from plantigrade.models.stature import usual_mass
from plantigrade.motion import ForcePlate, GaitEvent
from plantigrade.motion.cycles import cut_cycles
from plantigrade.motion.event_sources import as_measured, clock_shift, with_measured
from plantigrade.motion.plate_events import plate_events
from plantigrade.notes import Info

MAX_MASS_DIFFERENCE = 0.1
"""Maximum relative difference between given and measured body mass without a warning
[1]. Chosen: above the effect of clothes and shoes."""


@dataclass(frozen=True)
class PlateResults:
    """Results of force plates; without plates, the events of the motion alone."""

    events: tuple[GaitEvent, ...]  #: Gait events, timed by plates where possible
    n_events: int = 0  #: Number of events timed by plates
    forces: FootForces | None = None  #: Measured ground reactions by foot
    clock_offset: float | None = None  #: Delay of the plates, if it can be estimated [s]
    weighed: MeasuredMass | None = None  #: Body mass in gait, quiet standing or jumps


def evaluate_plates(
    plates: tuple[ForcePlate, ...],
    time: Float[Array, " n_frames"],
    motion: tuple[Human, Array, Array, Array],
    feet: FootPath,
    events: tuple[GaitEvent, ...],
    *,
    cutoff: float | None,
    mass: float | None,
    notes: list[str],
) -> PlateResults:
    """Return forces on the feet, gait events and the body mass measured by plates.

    Args:
        time: Time of each frame [s].
        motion: The person, ``qpos``, ``qvel`` and ``qacc``.
        cutoff: Low-pass of the forces [Hz].
        mass: Body mass, if known [kg].
        notes: Notes, to which those on the plates are added.
    """
    human, qpos, body = *motion[:2], centroid(*motion)
    soles, lift = sole_points(human, qpos), required_lift(human, body)
    forces, on_clock, offset = on_feet(plates, time, soles, body, cutoff, mass, lift)
    if on_clock is not plates and offset is not None:
        notes.append(clock_note(offset))
    notes += forces.warnings
    events, n_events = _events_by_plates(events, time, feet, on_clock, forces, notes)
    weighed = (
        weigh_gait(time, forces, events, cut_cycles(events), lift)
        or weigh_standing(
            time,
            on_clock,
            over_plates(on_clock, soles) | forces.valid,
            body.com_vel,
            lift,
            _pelvis_height(human, qpos, soles),
        )
        or weigh_jumps(time, forces, lift)
    )
    return PlateResults(events, n_events, forces, offset, weighed)


def _events_by_plates(
    events: tuple[GaitEvent, ...],
    time: Float[Array, " n_frames"],
    feet: FootPath,
    plates: tuple[ForcePlate, ...],
    forces: FootForces,
    notes: list[str],
) -> tuple[tuple[GaitEvent, ...], int]:
    """Return events timed by plates where possible, and how many; add a note on their clock."""
    spoiled = forces.spoiled(time)
    shift = clock_shift(events, plate_events(plates, time, feet.heel, feet.toe, spoiled))
    if shift is None:
        measured = plate_events(as_measured(plates), time, feet.heel, feet.toe, spoiled)
        return with_measured(events, measured)
    notes.append(
        f"the force plates seem to be {abs(1e3 * shift):.0f} ms "
        f"{'late' if shift > 0 else 'early'} relative to the motion: loading of the feet "
        "does not match their landing and lift-off; joint moments are doubtful."
    )
    return events, 0


def on_feet(
    plates: tuple[ForcePlate, ...],
    time: Float[Array, " n_frames"],
    soles: dict[str, np.ndarray],
    body: Centroid,
    cutoff: float | None,
    mass: float | None,
    lift: Float[Array, " n_frames"],
) -> tuple[FootForces, tuple[ForcePlate, ...], float | None]:
    """Return forces on the feet, synchronised plates, and their delay [s].

    Plates whose delay is small or cannot be estimated are returned unchanged.
    """
    forces = assign_plates(plates, time, soles, cutoff=cutoff, lift=lift, mass=mass)
    assert body.force is not None
    offset = clock_offset(plates, time, body.force, np.asarray(forces.valid), cutoff)
    if offset is None or abs(offset) <= MIN_CORRECTION:
        return forces, plates, offset
    plates = on_one_clock(plates, offset)
    forces = assign_plates(plates, time, soles, cutoff=cutoff, lift=lift, mass=mass)
    return forces, plates, offset


def required_lift(human: Human, body: Centroid) -> Float[Array, " n_frames"]:
    """Return the required vertical force per body mass [m/s²]."""
    assert body.force is not None
    return body.force[:, 2] / human.mass


def add_mass_note(
    human: Human,
    weighed: MeasuredMass | None,
    given: bool,
    plates: bool,
    age: float | None,
    notes: list[str],
) -> None:
    """Add a note on the source of the body mass, or a warning if it is doubtful."""
    if given:
        if weighed is not None and abs(weighed.mass / human.mass - 1) > MAX_MASS_DIFFERENCE:
            notes.append(
                f"the body mass is given as {human.mass:.1f} kg, but the force plates measured "
                f"{weighed.mass:.1f} kg."
            )
    elif weighed is not None:
        notes.append(
            Info(
                f"the file gives no body mass; the force plates measured {weighed.mass:.1f} kg "
                f"over {weighed.seconds:.1f} s of {WEIGHINGS[weighed.method]}."
            )
        )
    else:
        why = (
            ", and there is no gait, quiet standing or jump on the force plates alone"
            if plates
            else ""
        )
        _, spread = usual_mass(human.height, age)
        notes.append(
            f"the body mass is unknown{why}; {human.mass:.1f} ± {spread:.1f} kg (standard "
            f"deviation) is usual at a stature of {human.height:.2f} m. Forces in newtons are as "
            "uncertain: set it with --mass."
        )


def off_plate_notes(forces: FootForces | None, estimated: bool) -> list[str]:
    """Return notes on frames in which a foot is on no plate."""
    notes = []
    for side, share in zip(forces.sides, forces.beside_plates, strict=True) if forces else ():
        foot = f"the {SIDE_NAMES[side]} foot"
        text = f"{foot} stands on no force plate in {share:.0%} of the frames; its "
        if share > 0 and estimated:
            notes.append(Info(f"{text}force and moments there are estimated from the motion."))
        elif share > 0:
            notes.append(f"{text}moments are unknown there.")
    return notes


def _pelvis_height(human: Human, qpos: np.ndarray, soles: dict[str, np.ndarray]) -> np.ndarray:
    """Return the height of the pelvis above the soles, as a fraction of that in standing."""
    neutral = human.standing()[None]
    low = min(float(points[..., 2].min()) for points in sole_points(human, neutral).values())
    lowest = np.min([points[..., 2].min(axis=1) for points in soles.values()], axis=0)
    return (qpos[:, 2] - lowest) / (neutral[0, 2] - low)
