"""Scripts as motions: paths of ankles and body, and the postures over them."""

from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.control.balance.paths import (
    PathSettings,
    ankle_path,
    com_height,
    flights_of,
    through,
)
from plantigrade.control.balance.postures import (
    PostureSolver,
    PostureSolverSettings,
    velocities_of,
)
from plantigrade.control.balance.reference import MotionReference
from plantigrade.control.balance.script import Frame, Script
from plantigrade.control.gait.support import inside
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ScriptMotionSettings:
    """How a script becomes a motion."""

    path: PathSettings = field(default_factory=PathSettings)
    """Paths between frames."""
    solver: PostureSolverSettings = field(default_factory=PostureSolverSettings)
    """Postures over the feet."""
    reference_height: float = 1.74
    """Stature that lengths in a script are meant for [m]. Chosen."""
    rate: float = 50.0
    """Frames of the motion [1/s]. Chosen."""
    heel_off_height: float = 0.003
    """Rise of an ankle from which its heel has left the ground [m], at the reference height."""
    cop_spread: tuple[float, float] = (0.5, 0.15)
    """Standard deviation of pressure about ``toward``, along and across what presses. Chosen."""
    max_cost_exponent: float = 7.0
    """Logarithm of the greatest factor of the cost of a force far from ``toward``. Chosen."""


def scripted(
    human: Human, script: Script, settings: ScriptMotionSettings | None = None
) -> MotionReference:
    """Return a script as a motion of a person on level ground.

    Args:
        human: The person; with multi-segment feet.
        script: The script.
        settings: How it becomes a motion.

    Raises:
        ParameterError: If the feet are of another kind, the script begins or ends in the air, or
            the ground cannot push as hard as a flight asks for.
    """
    s = settings or ScriptMotionSettings()
    time = np.arange(round(script.duration * s.rate) + 1) / s.rate
    solver = PostureSolver(human, s.solver)
    frames, scale = script.frames, human.height / s.reference_height
    at = np.array([f.time for f in frames])
    segment = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(frames) - 2)
    presses = np.array([f.presses for f in frames])
    between = presses[:-1] & presses[1:]  # from each frame to the next
    flights = flights_of(np.atleast_1d(~between.any(axis=(1, 2))))
    if flights and flights[-1][1] == len(frames) - 1:
        raise ParameterError(f"{script.title} ends in the air: say which segments press in the end")
    if flights and flights[0][0] == 0:
        raise ParameterError(
            f"{script.title} is in the air from its beginning, where the person stands: say in a "
            "frame before the flight which segments press at take-off"
        )
    ankles = scale * np.array([f.ankle for f in frames])
    ankle = np.stack([ankle_path(at, ankles[:, k], flights, time, s.path) for k in (0, 1)], axis=1)
    body = scale * np.array([f.body for f in frames])
    rise = com_height(at, body[:, 2] + ankles[..., 2].min(axis=1), flights, time, s.path)
    goals = _goals(solver, frames, between, scale, {a for a, _ in flights}) + body[:, :2]
    for a, b in flights:  # straight up before a flight, and straight down after it
        goals[max(a - 1, 0)], goals[min(b + 1, len(goals) - 1)] = goals[a], goals[b]
    marked = between[segment]
    for a, b in flights:  # on the way to and from a flight feet are flat until their heels rise
        for k, flat in ((a - 1, a - 1), (b, b + 1)):
            if 0 <= k < len(between):
                own = segment == k
                low = np.abs(ankle[own, :, 2] - ankles[flat, :, 2]) < s.heel_off_height * scale
                marked[own] = np.where(low[..., None], presses[flat], marked[own])
    goal = np.column_stack([through(at, goals, time), solver.com[2] + rise])
    qpos = solver.path(ankle, marked, goal, s.rate if flights else 0.0)
    motion = Motion(time, qpos, velocities_of(human, qpos, s.rate), human.joint_names)
    spheres = solver.spheres_of(marked)
    reference = MotionReference(
        human, motion, spheres, flights=[(at[a], at[b]) for a, b in flights]
    )
    toward = np.array([f.toward for f in frames])
    for k, side in enumerate(SIDES):
        if not np.isnan(toward[:, k]).all():
            own = spheres & (solver.side == side)
            path = _toward(at, toward[:, k], time, segment)
            reference.force_cost *= _force_cost(reference.spheres, own, path, s)
    return reference


def _toward(at: Array, toward: Array, time: Array, segment: Array) -> Array:
    """Return the desired pressure within a foot at every time; NaN where that is open."""
    given = np.atleast_1d(~np.isnan(toward).any(axis=1))
    path = through(at, np.where(given[:, None], toward, 0.0), time)
    return np.where((given[segment] & given[segment + 1])[:, None], path, np.nan)


def _force_cost(spheres: Array, own: Array, toward: Array, settings: ScriptMotionSettings) -> Array:
    """Return the factor of the cost of every force by its distance from the desired pressure."""
    cost = np.ones(own.shape)
    for i in np.flatnonzero(own.any(axis=1) & ~np.isnan(toward).any(axis=1)):
        points = spheres[i, own[i], :2]
        low, high = points.min(axis=0), points.max(axis=0)
        pressure = 0.5 * (low + high + toward[i] * (high - low))
        distance = (points - pressure) / (np.array(settings.cop_spread) * (high - low))
        exponent = np.minimum(0.5 * (distance**2).sum(axis=1), settings.max_cost_exponent)
        cost[i, own[i]] = np.exp(exponent)
    return cost


def _goals(
    solver: PostureSolver, frames: tuple[Frame, ...], between: Array, scale: float, off: set[int]
) -> Array:
    """Return the goal of the centre of mass at every frame: over what presses before and after.

    Where nothing presses, as over the frame before; where a flight begins, over the middle, so that
    the last push is through the centre of mass and leaves the body without a turn.
    """
    standing = solver.com[:2]
    goals = [standing]
    for i, frame in enumerate(frames[1:], start=1):
        lasting = frame.presses & between[i - 1] & between[min(i, len(between) - 1)]
        if not lasting.any():
            lasting = frame.presses
        if not lasting.any():
            goals.append(goals[-1])
            continue
        spheres = solver.spheres(scale * frame.ankle, frame.presses)
        support = spheres[solver.spheres_of(lasting[None])[0], :2]
        goals.append(support.mean(axis=0) if i in off else inside(support, standing, np.inf))
    return np.array(goals)
