"""Scripts as motions: where ankles and body are at every time, and the postures of it."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.control.balance.paths import flights_of, lifted, rise, through
from plantigrade.control.balance.postures import Postures
from plantigrade.control.balance.reference import Followed
from plantigrade.control.balance.script import Frame, Script
from plantigrade.control.balance.support import inside
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.motion import Motion

HEIGHT = 1.74
"""Stature that lengths in a script are meant for [m]."""
RATE = 50.0
"""Frames of a scripted motion [1/s]."""
FLAT = 0.003
"""A heel that is to rise has left the ground when its ankle is so far up [m]."""


def scripted(human: Human, script: Script) -> Followed:
    """Return a script as a motion of a person on level ground.

    Args:
        human: The person; with multi-segment feet.
        script: The script.

    Raises:
        ParameterError: If the feet are of another kind, or the ground cannot push as hard as a
            flight asks for.
    """
    time = np.arange(round(script.duration * RATE) + 1) / RATE
    pose = Postures(human)
    frames, scale = script.frames, human.height / HEIGHT
    at = np.array([f.time for f in frames])
    segment = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(frames) - 2)
    presses = np.array([f.presses for f in frames])
    way = presses[:-1] & presses[1:]  # from each frame to the next
    flights = flights_of(~way.any(axis=(1, 2)))
    if flights and flights[-1][1] == len(frames) - 1:
        raise ParameterError(f"{script.title} ends in the air: say which segments press in the end")
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
    qpos = pose.path(ankle, marked, goal, 1.0 / RATE)
    motion = Motion(time, qpos, _rates(human, qpos), human.joint_names)
    spheres = pose.spheres_of(marked)
    return Followed(human, motion, spheres, flights=[(at[a], at[b]) for a, b in flights])


def _rates(human: Human, qpos: Array) -> Array:
    """Return the velocities of a motion sampled at :data:`RATE`."""
    state = State(human, qpos[0])
    steps = np.array(
        [state.moved_to(b).difference(a) for a, b in zip(qpos[:-1], qpos[1:], strict=True)]
    )
    ends = np.vstack([steps[:1], steps, steps[-1:]])
    return RATE * 0.5 * (ends[:-1] + ends[1:])


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
