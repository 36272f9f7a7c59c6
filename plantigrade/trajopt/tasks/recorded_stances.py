"""When and where recorded feet stand: contacts from events and rests, footprints from paths."""

from collections.abc import Sequence, Set
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.intervals import ContactInterval, grouped
from plantigrade.contact.plan import Footprint, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.loading import EARLY_LOAD
from plantigrade.kinematics.contacts import foot_contacts, foot_flat_time
from plantigrade.kinematics.sole_paths import SolePaths, sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.spatial.conventions import about_vertical

NODES_PER_SECOND = 50.0  # [1/s] nodes per second of a tracked motion

GRID = 1.0 / NODES_PER_SECOND  # [s] spacing of nodes where no contact changes
CHANGE_GRID = 0.5 * GRID
"""Contact changes are multiples of this [s], at most 5 ms from the recorded instants."""
MIN_CHANGE_INTERVAL = 2 * GRID  # [s] minimum interval between two contact changes of one foot
OUTSIDE_OFFSET = 10.0  # [s] distance from the motion of changes outside it
TOE_ROLL_TIME = 0.015
"""Time before toe-off at which toes begin to move [s]; toe-off is timed by the speed of the foot.
Toes fixed until 15 ms after it rotated the ankle by 5° to 10° too much (calibration half); with 20
ms before it the error of the vertical force is .006 to .009 body weights larger than with 10."""
REST_TIME = 0.020
"""Time from foot flat (:func:`~plantigrade.kinematics.contacts.foot_flat_time`, 4 mm above the
level of midstance) to rest of the forefoot [s]. A rigid foot that is at rest when the recorded one
is only that near was flat 23 ms earlier than it; with 20 ms it is on average 2 ms (calibration
half)."""
LOAD_SHIFTS = np.array([-EARLY_LOAD, REST_TIME, 0.0, 0.0, -TOE_ROLL_TIME])
"""Shift of the times of a stance from its events [s]: load grows from zero before heel strike is
detected."""
FLYING_SHIFTS = np.array([0.0, -0.01, 0.03, 0.01, -0.01])
"""The same for runs and jumps, from the times of their contacts [s]. A rigid foot that touches 10
ms earlier is ahead of the recorded one, which slides on for 40 ms when low-passed at 15 Hz: knees
of a runner at 3 m/s were 5.4° (RMS) off in place of 3.9°. Flat earlier and heel off later, as soles
yield, lower the peaks of force, from 2.8 to 2.5 body weights (plates 2.3): else the load waits for
the forefoot and leaves the heel at once, which the ankle does not bear."""

MAX_CONTACT_HEIGHT = 0.01  # [m] maximum height of a part of a foot in contact
HIGH_HEEL = 0.03
"""Height of a heel above ball and toes at which a foot that touches lands on these [m]. Chosen: a
foot that strikes with its heel has it lower than them, CMU 131_12 lands with it 130 mm higher."""


def contacts_of(human: Human, motion: Motion) -> tuple[ContactInterval, ...]:
    """Return which part of which foot touches when, from gait events or else from what rests.

    A slow part that has risen by :data:`MAX_CONTACT_HEIGHT`, such as a heel, no longer touches.
    Ball and toes of a foot that strikes with its heel touch from foot flat on. The heel of a foot
    that lands on its toes touches when it is down, if it comes down.
    """
    points = sole_paths(human, motion.qpos)
    rests = find_rests(points, motion.rate)
    time = np.asarray(motion.time, float)
    found = foot_contacts(time, motion.events, rests)
    seen = {c.side for c in found}
    found += tuple(rest.interval(time) for rest in rests if rest.side not in seen)
    strikes = [(c.side, c.start) for c in found if c.region == "heel" and c.start > time[0]]
    on_toes = {s for s in strikes if _lands_on_toes(*s, points, time)}
    settled = (_settled(c, points, time, on_toes) for c in found)
    return tuple(_after_foot_flat(c, strikes, points, time, on_toes) for c in settled if c)


def _lands_on_toes(
    side: str, touch: float, points: SolePaths, time: Float[Array, " n_frames"]
) -> bool:
    """Return whether the heel of a foot is up when it touches [s]."""
    at = points.position[int(np.argmin(np.abs(time - touch))), :, 2]
    front = [i for region in ("ball", "toes") for i in points.of(side, region)]
    return bool(at[points.of(side, "heel")].min() - at[front].min() > HIGH_HEEL)


def _settled(
    contact: ContactInterval,
    points: SolePaths,
    time: Float[Array, " n_frames"],
    on_toes: Set[tuple[str, float]],
) -> ContactInterval | None:
    """Return a contact without what is too high at its ends; heel strikes and toe offs stay.

    None of a heel that stays up from when the toes strike (``on_toes``: side and time [s]).
    """
    index = points.of(contact.side, contact.region)
    height = points.position[:, index, 2].min(axis=1)
    inside = (time >= contact.start) & (time <= contact.stop)
    low = np.flatnonzero(inside & (height < MAX_CONTACT_HEIGHT))
    struck = contact.region == "heel"
    if struck and (contact.side, contact.start) in on_toes:
        struck = False
        if not len(low):
            return None
    if len(low) < 3:
        return contact
    start = contact.start if struck else float(time[low[0]])
    stop = contact.stop if contact.region == "toes" else float(time[low[-1]])
    return replace(contact, start=start, stop=stop)


def _after_foot_flat(
    contact: ContactInterval,
    strikes: Sequence[tuple[str, float]],
    points: SolePaths,
    time: Float[Array, " n_frames"],
    on_toes: Set[tuple[str, float]],
) -> ContactInterval:
    """Return a contact of ball or toes from foot flat on; others, and in cut stances, unchanged."""
    before = [t for side, t in strikes if side == contact.side and t < contact.stop]
    if contact.region == "heel" or not before or (contact.side, max(before)) in on_toes:
        return contact
    front = [i for region in ("ball", "toes") for i in points.of(contact.side, region)]
    flat = max(before) + foot_flat_time(
        time, points.position[:, front, 2].min(axis=1), [max(before)]
    )
    return replace(contact, start=flat) if flat < contact.stop else contact


def recorded_stances(
    human: Human,
    motion: Motion,
    contacts: Sequence[ContactInterval],
    start: float,
    duration: float,
    *,
    flies: bool = False,
) -> tuple[Stance, ...]:
    """Return the stances of both feet within ``duration`` [s] from ``start`` on.

    Their times count from ``start`` and are multiples of :data:`CHANGE_GRID`. In runs and jumps
    (``flies``), a foot may land with its toes; so does one whose heel is up when it touches.
    """
    first, last = float(motion.time[0]), float(motion.time[-1])
    paths, points = _Paths(human, motion), sole_paths(human, motion.qpos)
    found = []
    for side in SIDES:
        for group in grouped(c for c in contacts if c.side == side):
            heel = min((c.start for c in group if c.region == "heel"), default=np.inf)
            touch = min(c.start for c in group)
            up = first < touch and _lands_on_toes(side, touch, points, motion.time)
            toes_first = touch < heel and (flies or up)
            times = _times(group, first, last, heel if toes_first else None)
            if times is None:
                continue
            shifts = FLYING_SHIFTS if flies else LOAD_SHIFTS
            snapped = _snapped(np.array(times) - start + shifts)
            if snapped[-1] <= MIN_CHANGE_INTERVAL or snapped[0] >= duration - MIN_CHANGE_INTERVAL:
                continue  # hardly begun, or nearly over
            strike, flat, heel_off, forefoot_off, off = (float(t) for t in snapped)
            if toes_first and heel == np.inf:  # it stays up
                flat = heel_off
            nowhere = Footprint(side, (0.0, 0.0, 0.0))
            stance = Stance(nowhere, strike, flat, heel_off, forefoot_off, off, toes_first)
            found.append(replace(stance, footprint=paths.footprint(side, stance, start)))
    return tuple(sorted(found, key=lambda s: (s.heel_strike, s.footprint.side)))


def _times(
    group: list[ContactInterval], first: float, last: float, heel: float | None = None
) -> tuple[float, ...] | None:
    """Return strike, foot flat, heel off, ball off and toe off of a stance [s].

    Changes outside the recording are moved far beyond its ends. With ``heel``, the foot is flat
    when its heel comes down then [s].
    """
    near = 1e-6 + 0.5 * GRID
    when: dict[str, tuple[float, float]] = {}
    for c in group:
        start, stop = when.get(c.region, (c.start, c.stop))
        when[c.region] = min(start, c.start), max(stop, c.stop)
    touch, leave = min(c.start for c in group), max(c.stop for c in group)
    begun, open_ = touch <= first + near, leave >= last - near
    if not begun and when.keys() == {"toes"}:
        return None
    before, after = first - OUTSIDE_OFFSET, last + OUTSIDE_OFFSET
    strike = before if begun else touch
    ball = when.get("ball", when.get("toes"))
    flat = before if begun and (ball is None or ball[0] <= first + near) else None
    if heel is not None:
        flat = min(heel, leave)
    elif flat is None:
        flat = after if ball is None else ball[0]
    off = after if open_ else leave

    def end(region: str, otherwise: float) -> float:
        if region not in when:
            return otherwise
        return after if when[region][1] >= last - near else when[region][1]

    heel_off = end("heel", before if begun else flat)
    forefoot_off = end("ball", before if begun and not open_ else off)
    return strike, flat, heel_off, forefoot_off, off


def _snapped(times: Float[Array, " 5"]) -> Float[Array, " 5"]:
    """Return times on the grid, in order and apart."""
    on_grid = np.round(times / CHANGE_GRID) * CHANGE_GRID
    t = on_grid.copy()
    for i in range(1, 5):
        t[i] = max(t[i], t[i - 1] + MIN_CHANGE_INTERVAL)
    late = t[4] - max(on_grid[4], t[0] + 4 * MIN_CHANGE_INTERVAL)
    if late > 0:  # the foot leaves when it leaves: what comes before is moved forward
        t[4] -= late
        for i in (3, 2, 1):
            t[i] = min(t[i], t[i + 1] - MIN_CHANGE_INTERVAL)
    return np.round(t / CHANGE_GRID) * CHANGE_GRID


class _Paths:
    """Where the sites of the feet were on the ground in every frame."""

    def __init__(self, human: Human, motion: Motion):
        self.sites, self.time = foot_sites(human), np.asarray(motion.time, float)
        self.flat = {side: flat_sites(human, self.sites, side) for side in SIDES}
        bodies = [s.body for s in self.sites]
        points = PointSet(human, bodies, np.array([s.position for s in self.sites]))
        rho = np.array([s.radius for s in self.sites])
        self.place = np.empty((len(self.time), len(self.sites), 2))
        for k, state in enumerate(sweep(human, motion.qpos)):
            R = state.rotations[points.body]
            heading = np.arctan2(R[:, 1, 0], R[:, 0, 0])
            along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
            left = np.stack([-along[:, 1], along[:, 0]], axis=1)
            pitch, roll = np.arcsin(R[:, 2, 0]), np.arctan2(R[:, 2, 1], R[:, 2, 2])
            rolled = pitch[:, None] * along + roll[:, None] * left
            self.place[k] = state.position(points)[:, :2] + rho[:, None] * rolled

    def footprint(self, side: str, stance: Stance, start: float) -> Footprint:
        """Return the footprint that fits best while the foot was flat, or else while it stood."""
        time = self.time - start
        flat = (time >= stance.foot_flat) & (time <= stance.heel_off)
        inner = flat.copy()
        if flat.sum() >= 8:
            quarter = flat.sum() // 4
            inner[np.flatnonzero(flat)[:quarter]] = inner[np.flatnonzero(flat)[-quarter:]] = False
        target, seen = [], []
        for k, site in enumerate(self.sites):
            if site.side != side:
                continue
            a, b = stance.interval(site.part)
            frames = inner if flat.sum() >= 3 else (time >= a) & (time <= b)
            seen.append(self.place[frames, k])
            target.append(np.tile(self.flat[side][site.name][:2], (frames.sum(), 1)))
        x, y = np.concatenate(target), np.concatenate(seen)
        if not len(x):
            nearest = int(np.argmin(np.abs(time - (stance.heel_strike + stance.toe_off) / 2)))
            names = [k for k, s in enumerate(self.sites) if s.side == side]
            x = np.array([self.flat[side][self.sites[k].name][:2] for k in names])
            y = self.place[nearest, names]
        dx, dy = x - x.mean(axis=0), y - y.mean(axis=0)
        cosine, sine = (dx * dy).sum(), (dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]).sum()
        heading = float(np.arctan2(sine, cosine))
        px, py = y.mean(axis=0) - about_vertical(heading)[:2, :2] @ x.mean(axis=0)
        return Footprint(side, (float(px), float(py), 0.0), heading)
