"""Scripts as motions: where ankles and body are at every time, and the postures of it."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.control.balance.paths import flights_of, lifted, rise, through
from plantigrade.control.balance.postures import Postures, rates_of
from plantigrade.control.balance.reference import MotionReference
from plantigrade.control.balance.script import Frame, Script
from plantigrade.control.gait.support import inside
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion

HEIGHT = 1.74
"""Stature that lengths in a script are meant for [m]."""
RATE = 50.0
"""Frames of a scripted motion [1/s]."""
FLAT = 0.003
"""A heel that is to rise has left the ground when its ankle is so far up [m]."""
NARROW = np.array([0.5, 0.15])
"""How far around where a foot presses most it presses, along and across what presses of it."""
DEAREST = 7.0
"""Logarithm of the greatest cost of a force elsewhere, by that of one there."""


def scripted(human: Human, script: Script) -> MotionReference:
    """Return a script as a motion of a person on level ground.

    Args:
        human: The person; with multi-segment feet.
        script: The script.

    Raises:
        ParameterError: If the feet are of another kind, the script begins or ends in the air, or
            the ground cannot push as hard as a flight asks for.
    """
    time = np.arange(round(script.duration * RATE) + 1) / RATE
    pose = Postures(human)
    frames, scale = script.frames, human.height / HEIGHT
    at = np.array([f.time for f in frames])
    segment = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(frames) - 2)
    presses = np.array([f.presses for f in frames])
    way = presses[:-1] & presses[1:]  # from each frame to the next
    flights = flights_of(np.atleast_1d(~way.any(axis=(1, 2))))
    if flights and flights[-1][1] == len(frames) - 1:
        raise ParameterError(f"{script.title} ends in the air: say which segments press in the end")
    if flights and flights[0][0] == 0:
        raise ParameterError(
            f"{script.title} is in the air from its beginning, where the person stands: say in a "
            "frame before the flight which segments press at take-off"
        )
    ankles = scale * np.array([f.ankle for f in frames])
    ankle = np.stack([lifted(at, ankles[:, k], flights, time) for k in (0, 1)], axis=1)
    body = scale * np.array([f.body for f in frames])
    high = rise(at, body[:, 2] + ankles[..., 2].min(axis=1), flights, time)
    off = {a for a, _ in flights}
    over = _targets(pose, frames, way, scale, off) + body[:, :2]
    for a, b in flights:  # pushed straight up, and caught straight down
        over[max(a - 1, 0)], over[min(b + 1, len(over) - 1)] = over[a], over[b]
    over = through(at, over, time)
    marked = way[segment]
    for a, b in flights:  # on the way to and from a flight feet are flat until their heels rise
        for k, flat in ((a - 1, a - 1), (b, b + 1)):
            if 0 <= k < len(way):
                own = segment == k
                low = np.abs(ankle[own, :, 2] - ankles[flat, :, 2]) < FLAT * scale
                marked[own] = np.where(low[..., None], presses[flat], marked[own])
    goal = np.column_stack([over, pose.high + high])
    # Who is to fly must not turn; who moves slowly need not care.
    qpos = pose.path(ankle, marked, goal, RATE if flights else 0.0)
    motion = Motion(time, qpos, rates_of(human, qpos, RATE), human.joint_names)
    spheres = pose.spheres_of(marked)
    follow = MotionReference(human, motion, spheres, flights=[(at[a], at[b]) for a, b in flights])
    toward = np.array([f.toward for f in frames])
    for k, side in enumerate(SIDES):
        if not np.isnan(toward[:, k]).all():
            own = spheres & (pose.side == side)
            follow.force_cost *= _dear(
                follow.spheres, own, _toward(at, toward[:, k], time, segment)
            )
    return follow


def _toward(at: Array, toward: Array, time: Array, segment: Array) -> Array:
    """Return where a foot presses most at every time; NaN where that is open."""
    told = np.atleast_1d(~np.isnan(toward).any(axis=1))
    path = through(at, np.where(told[:, None], toward, 0.0), time)
    return np.where((told[segment] & told[segment + 1])[:, None], path, np.nan)


def _dear(places: Array, own: Array, toward: Array) -> Array:
    """Return how much more a force costs that is far from where its foot presses most."""
    dear = np.ones(own.shape)
    for i in np.flatnonzero(own.any(axis=1) & ~np.isnan(toward).any(axis=1)):
        points = places[i, own[i], :2]
        low, high = points.min(axis=0), points.max(axis=0)
        place = 0.5 * (low + high + toward[i] * (high - low))
        off = (points - place) / (NARROW * (high - low))
        dear[i, own[i]] = np.exp(np.minimum(0.5 * (off**2).sum(axis=1), DEAREST))
    return dear


def _targets(
    pose: Postures, frames: tuple[Frame, ...], way: Array, scale: float, off: set[int]
) -> Array:
    """Return where the centre of mass is to be at every frame: over what presses before and after.

    Where nothing presses, as over the frame before; where a flight begins, over their middle, so
    that the last push is through the centre of mass and leaves the body without a turn.
    """
    targets = [pose.over]
    for i, frame in enumerate(frames[1:], start=1):
        lasting = frame.presses & way[i - 1] & way[min(i, len(way) - 1)]
        if not lasting.any():
            lasting = frame.presses
        if not lasting.any():
            targets.append(targets[-1])
            continue
        places, on = pose.places(scale * frame.ankle, frame.presses, lasting)
        middle = places[on, :2].mean(axis=0)
        targets.append(middle if i in off else inside(places[on, :2], pose.over, np.inf))
    return np.array(targets)
