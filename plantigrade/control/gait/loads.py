"""Load of the contact spheres over a motion: measured, estimated, or from their movement."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.control.gait.edges import EdgeSettings
from plantigrade.control.gait.kinematics import Kinematics
from plantigrade.control.gait.schedule import settled
from plantigrade.control.gait.step import StepSettings
from plantigrade.motion.filters import interpolate, runs
from plantigrade.record import Record
from plantigrade.wbc.forces import ForceSettings


@dataclass(frozen=True, kw_only=True)
class LoadSettings:
    """Where a motion without contact forces has load."""

    max_height: float = EdgeSettings.clearance
    """Height of a sphere above the ground up to which it may carry load [m]; swing feet are
    higher."""
    max_speed: float = 0.4
    """Speed up to which it may [m/s]. Chosen (±20 %: deviation 12 %)."""
    flies: bool = True
    """Whether no foot may carry load. Else the slower foot near the ground does: a stride that
    turns, closed, lets feet slide that stood, and a walk does not fly."""
    max_height_difference: float = 0.006
    """Height above the lowest sphere of a loaded foot up to which one shares its load [m]. Heels
    that were held down until they were 20 mm up rose late, and the stance leg was straight before
    (knee moment r .64, now .79); 10 mm is worse, both on the calibration half of ``experiment
    human-likeness``."""
    max_rest_speed: float = StepSettings.rest_speed
    """Speed below which a sphere near the ground is at rest, whatever its height [m/s], as is a
    body after its steps: soles of shoes are not flat, and with the load of standing feet on their
    lowest spheres alone, the toes, recorded sit-to-stands fell backward."""
    min_rest_time: float = 1.2
    """Time for which it then is at rest [s], that of a stride; soles of a walk are for less than
    half of it. Chosen."""
    min_unknown_load: float = 0.2
    """Least load shared by touching feet of which nothing is known [body weights]. Chosen (±20 %:
    not met)."""
    min_foot_load: float = ForceSettings.min_foot_load
    """Load below which a foot is in the air [body weights]; as where forces are planned."""


def site_forces(
    record: Record, sites: tuple[ContactSite, ...], time: Float[Array, " n"]
) -> Float[Array, "n k 3"]:
    """Return the known force on each sphere at some times [N]; zero where it is not known.

    Sites of a plan carry the names of the spheres. Forces measured for a whole foot are not divided
    here: see :func:`site_loads`.
    """
    force = np.zeros((len(time), len(sites), 3))
    if record.contact_force is None:
        return force
    for i, site in enumerate(record.sites):
        own = [k for k, s in enumerate(sites) if s.name.endswith(site.name)]
        if own and not site.measured:
            known = record.contact_force[:, i]
            force[:, own[0]] += interpolate(time, record.motion.time, known)
    return np.nan_to_num(force)


def site_loads(
    record: Record,
    sites: tuple[ContactSite, ...],
    kinematics: Kinematics,
    force: Float[Array, "n k 3"],
    step: float,
    settings: LoadSettings,
    min_duration: float,
) -> Float[Array, "n k"]:
    """Return the load of each sphere along the normal [N].

    Where forces are known only of a foot, measured or estimated, its spheres that are near the
    ground and slow share them, or the lowest do. A foot of which nothing is known carries load
    where its spheres are near and slow, and then what is left of the weight.

    Args:
        force: Known force on each of them [N].
        step: Time step of the grid [s].
        min_duration: Least duration of a stance [s].
    """
    load = np.maximum(force @ record.ground.normal, 0.0)
    on_foot = np.array([bool(s.side) for s in sites])
    if load[:, on_foot].any():
        return load
    height, weight = kinematics.contact_height, record.weight
    own = [np.array([s.side == side for s in sites]) for side in SIDES]
    near = _near(height, kinematics.contact_speed, own, settings)
    feet = np.stack([foot_load(record, side, len(load), step) for side in SIDES], axis=1)
    touches = np.stack([near[:, mine].any(axis=1) for mine in own], axis=1)
    unknown = np.isnan(feet)
    seat = load[:, ~on_foot].sum(axis=1)
    rest = weight - np.nansum(feet, axis=1) - seat
    share = np.maximum(rest, settings.min_unknown_load * weight)
    carried = transferred(touches) * (unknown & touches)
    carried /= np.maximum(carried.sum(axis=1, keepdims=True), 1e-9)
    feet = np.where(unknown, carried * share[:, None], np.nan_to_num(feet))
    least = settings.min_foot_load * weight
    rests = touches & (seat > 0.0)[:, None]  # in sitting, feet may bear next to nothing
    feet = np.where(rests, np.maximum(feet, least), feet)
    feet[feet < least] = 0.0
    for i, side in enumerate(SIDES):
        if record.has_forces and not record.foot(side).measured.any():
            feet[~settled(touches[:, i], round(min_duration / step)), i] = 0.0
    for i, mine in enumerate(own):
        low = height[:, mine]
        lowest = low <= low.min(axis=1)[:, None] + settings.max_height_difference
        lowest |= _resting(low, kinematics.contact_speed[:, mine], step, settings)
        part = lowest / lowest.sum(axis=1, keepdims=True)
        load[:, mine] = part * feet[:, i : i + 1]
    return load


def transferred(touches: Bool[Array, "n 2"]) -> Float[Array, "n 2"]:
    """Return the share of the load of each foot that touches.

    In a double support between single supports of both feet it goes evenly from one to the other;
    in any other they share it equally.
    """
    share = touches / np.maximum(touches.sum(axis=1, keepdims=True), 1)
    for both in runs(touches[:, 0] & touches[:, 1]):
        if both.start == 0 or both.stop == len(touches):
            continue
        before, after = touches[both.start - 1], touches[both.stop]
        if before.sum() == after.sum() == 1 and np.all(before != after):
            n = both.stop - both.start
            part = (np.arange(n) + 0.5)[:, None] / n
            share[both] = (1.0 - part) * before + part * after
    return share


def foot_load(record: Record, side: str, n: int, step: float) -> Float[Array, " n"]:
    """Return the known load of a foot, measured or estimated [N]; NaN where nothing is known."""
    motion, normal = record.motion, record.ground.normal
    time = motion.time[0] + np.minimum(step * np.arange(n), motion.duration)
    known = np.zeros(motion.n_frames, dtype=bool)
    load = np.zeros(motion.n_frames)
    if record.has_forces:
        foot = record.foot(side)
        known, load = foot.known.copy(), foot.force @ normal
    estimated = record.signals.get("estimated.force")
    if estimated is not None:
        guess = estimated[:, SIDES.index(side)] @ normal
        fill = ~known & np.isfinite(guess)
        load, known = np.where(fill, guess, load), known | fill
    found = np.interp(time, motion.time, np.maximum(np.nan_to_num(load), 0.0))
    found[np.interp(time, motion.time, known.astype(float)) < 0.999] = np.nan
    return found


def _resting(
    height: Float[Array, "n k"], speed: Float[Array, "n k"], step: float, settings: LoadSettings
) -> Bool[Array, "n k"]:
    """Return which spheres near the ground [m] are at rest for longer than those of a walk."""
    rests = (height < settings.max_height) & (speed < settings.max_rest_speed)
    for own in rests.T:
        for run in runs(own):
            own[run] = (run.stop - run.start) * step >= settings.min_rest_time
    return rests


def _near(height: Array, speed: Array, own: Sequence[Array], settings: LoadSettings) -> Array:
    """Return which spheres may carry load, by height [m] and speed [m/s]; ``own``: of each foot."""
    low = height < settings.max_height
    near = low & (speed < settings.max_speed)
    if settings.flies:
        return near
    sliding = np.where(low, speed, np.inf)
    slowest = np.stack([sliding[:, mine].min(axis=1) for mine in own], axis=1)
    alone = ~near.any(axis=1)
    for mine, each in zip(own, slowest.T, strict=True):
        bears = alone & (each <= slowest.min(axis=1))
        near[:, mine] |= bears[:, None] & np.isfinite(sliding[:, mine])
    return near
