"""Fit of a person to OpenSim's joint coordinates (MOT, STO).

The angles are unchanged except for joint limits. The stature puts the stance foot on the ground at
the pelvis height of the file. Without a pelvis position, the stance feet determine its path
(:func:`plantigrade.kinematics.coordinate_fit.forward_path`).
"""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import FitError
from plantigrade.io.opensim_coordinates import NO_ANGLE
from plantigrade.kinematics.foot_bones import with_bones
from plantigrade.kinematics.ground_level import level, moving_ground
from plantigrade.kinematics.result import Fit, filled, human_of
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.sole_rests import contact_metrics, find_rests
from plantigrade.kinematics.stature_estimate import stature_notes
from plantigrade.kinematics.unmeasured_joints import follow_the_legs, note, unmeasured
from plantigrade.models import Human
from plantigrade.models.person import Person
from plantigrade.motion import Recording
from plantigrade.motion.filters import lowpass
from plantigrade.motion.jumps import unwrapped
from plantigrade.motion.recording import Table, rate_of
from plantigrade.motion.spikes import spike_note, table_without_spikes
from plantigrade.notes import Info
from plantigrade.printable import listed
from plantigrade.spatial.conventions import PELVIS, facing

MIN_PASSING_SPEED = 0.3  # [m/s] minimum relative speed of feet that pass each other
MAX_STANCE_HEIGHT = 0.04  # [m] maximum height of the stance foot above the other
PELVIS_CUTOFF = 6.0  # [Hz] low-pass of the pelvis in walking [Winter2009]_
USUAL_HEIGHT = 1.74  # [m] stature without height in the file
PLAUSIBLE_STATURES = (1.2, 2.2)  # [m] accepted range of stature from the pelvis height
MAX_ANGLE = 2 * np.pi  # [rad] maximum hip or knee angle; larger values are not radians
MIN_FLIGHT_RISE = 0.08  # [m] common rise of both feet in flight
SYNONYMS = {"lumbar": "lumbar_extension", "torso_extension": "lumbar_extension"}
LEG_COORDINATES = ("hip_flexion_r", "hip_flexion_l", "knee_angle_r", "knee_angle_l")


def fit_coordinates(recording: Recording, person: Person | None = None) -> Fit:
    """Fit a person to joint coordinates.

    Args:
        recording: The recording; it must have coordinates.
        person: Known properties of the person; the recording's metadata supply others. By default
            the height follows from the pelvis height and the mass from the stature.
    """
    notes: list[str] = []
    table = _usable(recording, notes)
    person = filled(person or Person(), recording.subject)
    age, estimated = recording.subject.age, person.height is None
    height = person.height or _stature(person, table, age, notes)
    human = human_of(person, height, age=age)
    left_out = [n for n in table.names if n not in (*human.coordinates, *PELVIS)]
    if left_out:
        notes.append(
            f"{len(left_out)} columns are not coordinates of this person and were ignored: "
            f"{listed(left_out)}."
        )
    qpos = human.from_coordinates(table.names, table.values)
    qpos = _clipped(human, qpos, notes)
    rate = rate_of(table.time)
    if "pelvis_tx" not in table.names:
        # these files are assembled strides whose height is accurate to centimetres only
        flight = "pelvis_ty" in table.names and np.ptp(lowest(human, qpos)) > MIN_FLIGHT_RISE
        qpos = forward_path(human, qpos, rate=rate, vertical=not flight)
        notes.append("the file gives no pelvis path; it was computed from the standing feet.")
    qpos, way, shift = _on_ground(human, table.time, qpos, notes)
    seen = np.array([name in table.names for name in human.coordinates])
    assumed = unmeasured(human, seen)
    qpos = follow_the_legs(human, table.time, qpos, seen)
    notes += note(assumed, "no column of the file")
    contact = sole_paths(human, qpos)
    rests = find_rests(contact, rate, way=way)
    bones: dict[str, float] = {}
    if human.feet == "multi-segment":
        moving = [n for n, x in zip(table.names, table.values.T, strict=True) if np.ptp(x) > 0]
        qpos, bones = with_bones(human, table.time, qpos, rests, known=moving, turns=False)
        contact = sole_paths(human, qpos)
    return Fit(
        human=human,
        time=table.time,
        qpos=qpos,
        recording=replace(recording, coordinates=table),
        source_kind="coordinates",
        assumed=assumed,
        metrics={
            "height_m": human.height,
            "height_estimated": estimated,
            "ground_shift_mm": 1e3 * shift,
            "stances": len(rests),
            **contact_metrics(contact, rests, way),
            **bones,
        },
        warnings=tuple(recording.warnings) + tuple(notes),
    )


def _on_ground(
    human: Human, time: Float[Array, " n"], qpos: Float[Array, "n nq"], notes: list[str]
) -> tuple[Float[Array, "n nq"], Float[Array, "n 3"], float]:
    """Return the motion on the ground, the path of the ground, and its shift upwards [m]."""
    ends = sole_paths(human, qpos).ends
    way = moving_ground(time, *(each[:, ::-1] for each in ends))
    if np.abs(way).max() > 0:
        notes.append(Info("the ground moves under the feet (a treadmill, or walking in place)."))
    qpos, rise = level(human, qpos, rate_of(time), way=way)
    shift = float(np.median(rise))
    if abs(shift) > 0.02:
        notes.append(Info(f"the motion was shifted by {1e3 * shift:+.0f} mm onto the ground."))
    return qpos, way, shift


def _usable(recording: Recording, notes: list[str]) -> Table:
    """Return the table with our names and without empty rows."""
    table = recording.coordinates
    if table is None:
        what = "ground reactions only" if recording.plates else "no joint coordinates"
        raise FitError(
            f"{recording.source} holds {what}: a motion needs angles such as hip_flexion_r; "
            "give the file of joint coordinates"
        )
    names = tuple(SYNONYMS.get(n, n) for n in table.names)
    names = tuple(n if names.count(n) == 1 else o for n, o in zip(names, table.names, strict=True))
    known = [c for c in names if c in LEG_COORDINATES]
    if not known:
        raise FitError(
            f"{recording.source} has no coordinate of hips or knees "
            f"({', '.join(LEG_COORDINATES)}); its columns are {listed(table.names, 12)}"
        )
    if len(table.time) < 2:
        raise FitError(f"{recording.source} has {len(table.time)} rows; two are needed")
    good = np.flatnonzero(np.isfinite(table.values).all(axis=1))
    if len(good) < 2:
        raise FitError(f"{recording.source}: no row has all its values")
    if len(good) < len(table.time):
        notes.append(f"{len(table.time) - len(good)} rows lack values and were interpolated.")
    keep = slice(good[0], good[-1] + 1)
    time, values = table.time[keep], table.values[keep].copy()
    for column in values.T:
        own = np.isfinite(column)
        column[~own] = np.interp(time[~own], time[own], column[own])
    angles = [k for k, name in enumerate(names) if not NO_ANGLE.search(name)]
    smooth = unwrapped(values[:, angles])
    off = np.abs(smooth - values[:, angles]).max(axis=0, initial=0.0)
    wrapped = [names[k] for k, by in zip(angles, off, strict=True) if by > np.pi]
    if wrapped:
        notes.append(Info(f"angles that jump by a full turn were unwrapped: {listed(wrapped)}."))
        values[:, angles] = smooth
    table, found_spikes = table_without_spikes(Table(names, time, values), angles)
    if found_spikes:
        notes.append(spike_note(found_spikes))
    _require_angles(table, recording)
    return table


def _require_angles(table: Table, recording: Recording) -> None:
    """Raise for impossible leg angles."""
    for name in LEG_COORDINATES:
        if name in table.names and (largest := np.abs(table[name]).max()) > MAX_ANGLE:
            raise FitError(
                f"{recording.source}: {name} reaches {np.rad2deg(largest):.3g}°, more than a turn; "
                "check that the header says degrees where the angles are in degrees"
            )


def _stature(person: Person, table: Table, age: float | None, notes: list[str]) -> float:
    """Return the stature with the stance foot on the ground at the file's pelvis height [m]."""
    if "pelvis_ty" not in table.names:
        notes.append(
            f"the file does not determine body height; {USUAL_HEIGHT:.2f} m was assumed "
            "(set it with --height)."
        )
        return USUAL_HEIGHT
    stature, ty = USUAL_HEIGHT, table["pelvis_ty"]
    for _ in range(4):
        human = human_of(person, stature)
        qpos = human.from_coordinates(table.names, table.values)
        qpos[:, 7:] = np.clip(qpos[:, 7:], *human.limits)
        qpos[:, 2] = 0.0
        leg = -lowest(human, qpos)  # pelvis above the lowest point of the soles [m]
        ratio = ty / leg
        # Nearly straight legs are the most reliable; in flight the pelvis is higher, but two in
        # five of those frames are not in flight.
        usual = float(np.quantile(ratio[leg > 0.9 * leg.max()], 0.4))
        stature *= usual
        if not PLAUSIBLE_STATURES[0] <= stature <= PLAUSIBLE_STATURES[1]:
            notes.append(
                f"the pelvis's height ({np.median(ty):.2f} m) fits no person standing on ground at "
                f"0; {USUAL_HEIGHT:.2f} m was assumed as body height (set it with --height)."
            )
            return USUAL_HEIGHT
        if abs(usual - 1) < 1e-3:
            break
    notes += stature_notes(stature, None, "the pelvis height", age)
    return float(stature)


def _clipped(
    human: Human, qpos: Float[Array, "n_frames nq"], notes: list[str]
) -> Float[Array, "n_frames nq"]:
    low, high = human.limits
    result = qpos.copy()
    result[:, 7:] = np.clip(qpos[:, 7:], low, high)
    over = np.rad2deg(np.abs(result[:, 7:] - qpos[:, 7:]).max(axis=0))
    beyond = [(v, c) for v, c in zip(over, human.coordinates, strict=True) if v > 0.1]
    if beyond:
        beyond.sort(reverse=True)
        cut = listed([f"{c} by up to {v:.1f}°" for v, c in beyond])
        notes.append(f"joint limits clipped {cut}.")
    return result


def forward_path(
    human: Human, qpos: Float[Array, "n_frames nq"], *, rate: float, vertical: bool = True
) -> Float[Array, "n_frames nq"]:
    """Return the motion with a root path on which the standing foot stays where it is.

    For motions that say nothing of where the pelvis goes. In every step of time the points of
    the soles nearest to the ground stand still on the mean. The standing foot is the lower one; of
    two feet that pass each other near the ground it is the one that falls behind the pelvis (in
    walking backward: that gets ahead of it), for a swinging foot may come as near to the ground as
    the standing one. How fast the pelvis goes is smoothed: with angles that are not those of this
    body it would jump by 1 m/s from one foot to the other.

    Args:
        qpos: The motion; its horizontal root position is replaced.
        rate: Frames per second [Hz].
        vertical: Whether the height is replaced too: lowest point of the standing foot at 0.
    """
    n = len(qpos)
    result = qpos.copy()
    result[:, :2] = 0.0
    contact = sole_paths(human, result)
    position, sides = contact.position, np.array([SIDES.index(s.side) for s in contact.sites])
    bottom = position[..., 2].min(axis=1)
    close = np.exp(-(position[..., 2] - bottom[:, None]) / 0.006)
    close *= _falls_behind(result, position, sides, rate)
    step = np.zeros((n, 2))
    for k in range(n - 1):
        w = close[k] + close[k + 1]
        moved = position[k + 1, :, :2] - position[k, :, :2]
        step[k + 1] = -(w @ moved) / w.sum()
    if rate > 3.0 * PELVIS_CUTOFF:
        step[1:] = lowpass(np.arange(1, n) / rate, step[1:], cutoff=PELVIS_CUTOFF)
    result[:, :2] = np.cumsum(step, axis=0)
    if vertical:
        result[:, 2] -= bottom
    return result


def _falls_behind(qpos, position, sides, rate: float) -> Float[Array, "n_frames n_points"]:
    """Return 1 for points of feet that may stand, nearly 0 for those of a foot that swings past.

    The motion has the pelvis on one spot.
    """
    ahead = facing(qpos[:, 3:7])
    speed, low = np.empty((len(qpos), 2)), np.empty((len(qpos), 2))
    for k in (0, 1):
        mine = position[:, sides == k]
        moved = np.gradient(mine[..., :2].mean(axis=1), axis=0) * rate
        speed[:, k] = np.einsum("nd,nd->n", moved, ahead)
        low[:, k] = mine[..., 2].min(axis=1)
    apart = np.abs(speed[:, 0] - speed[:, 1]) > MIN_PASSING_SPEED
    passing = apart & (np.abs(low[:, 0] - low[:, 1]) < MAX_STANCE_HEIGHT)
    behind, rows = speed.argmin(axis=1), np.arange(len(qpos))
    # Walking forward, the foot that falls behind is the lower one on the mean; backward, the other.
    if np.sum((low[rows, behind] - low[rows, 1 - behind])[apart]) > 0:
        behind = 1 - behind
    may = np.ones(position.shape[:2])
    may[passing[:, None] & (sides[None] != behind[:, None])] = 1e-3
    return may
