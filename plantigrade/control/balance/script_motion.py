r"""Scripts as motions: paths of ankles and centre of mass, and the postures over them.

Between frames every number runs along a quintic through values, slopes and accelerations: at rest
where it turns or stays, with the slope of a monotone cubic where it goes on. From rest to rest that
is the path of least jerk.

Where no foot presses the centre of mass falls freely: it leaves the ground and meets it with the
speed :math:`g T / 2` of a flight of :math:`T` between equal heights, and with the acceleration
:math:`-g`, which is to say with no force. The acceleration at the bottom of the crouch before it,
and of the landing after it, is the one that needs the least force.
"""

import numpy as np
from scipy.interpolate import BPoly, PchipInterpolator

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance.postures import PostureSolver, velocities_of
from plantigrade.control.balance.reference import MotionReference
from plantigrade.control.balance.script import RATE, Script, ScriptFrame, ScriptSettings
from plantigrade.control.gait.support import inside
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.coordinates import REFERENCE_HEIGHT
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs

N_SAMPLES = 60  # between two frames, where the force is looked at
MAX_COST_EXPONENT = 7.0  # of a force far from ``toward``: keeps the program well posed
MIN_RISE = 1e-4  # [m] rise up to which a foot stands: jumps rise by 13 cm, with 3 mm by 7 to 13
N_ACCELERATIONS = 31  # tried at the bottom of a crouch
FORCE_TOLERANCE = 0.05  # [body weights] of a pull that is the quintic's, not the script's


def scripted(
    human: Human, script: Script, settings: ScriptSettings | None = None
) -> MotionReference:
    """Return a script as a motion of a person on level ground.

    Args:
        human: The person; with multi-segment feet.
        script: The script.
        settings: Limits and weights.

    Raises:
        ParameterError: If the feet are of another kind, the script begins or ends in the air, or
            the ground cannot push as hard as a flight asks for.
    """
    s = settings or ScriptSettings()
    time = np.arange(round(script.duration * RATE) + 1) / RATE
    solver = PostureSolver(human, s.solver)
    frames, scale = script.frames, human.height / REFERENCE_HEIGHT
    at = np.array([f.time for f in frames])
    segment = np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(frames) - 2)
    presses = np.array([f.presses for f in frames])
    between = presses[:-1] & presses[1:]  # from each frame to the next
    flights = _flights(script.title, between)
    ankles = scale * np.array([f.ankle for f in frames])
    ankle = np.stack([ankle_path(at, ankles[:, k], flights, time, s) for k in (0, 1)], axis=1)
    body = scale * np.array([f.body for f in frames])
    rise = com_height(at, body[:, 2] + ankles[..., 2].min(axis=1), flights, time, s)
    goals = _goals(solver, frames, between, scale, {a for a, _ in flights}) + body[:, :2]
    for a, b in flights:  # straight up before a flight, and straight down after it
        goals[max(a - 1, 0)], goals[min(b + 1, len(goals) - 1)] = goals[a], goals[b]
    goal = np.column_stack([through(at, goals, time), solver.com[2] + rise])
    marked = between[segment]
    for a, b in flights:  # on the way to and from a flight feet are flat until their heels rise
        for k, flat in ((a - 1, a - 1), (b, b + 1)):
            own = segment == k
            low = np.abs(ankle[own, :, 2] - ankles[flat, :, 2]) < MIN_RISE
            marked[own] = np.where(low[..., None], presses[flat], marked[own])
    qpos = solver.path(ankle, marked, goal, RATE if flights else 0.0)
    motion = Motion(time, qpos, velocities_of(human, qpos, RATE), human.joint_names)
    spheres = solver.spheres_of(marked)
    reference = MotionReference(
        human, motion, spheres, flights=[(float(at[a]), float(at[b])) for a, b in flights]
    )
    toward = np.array([f.toward for f in frames])
    for k, side in enumerate(SIDES):
        if not np.isnan(toward[:, k]).all():
            own = spheres & (solver.side == side)
            path = _toward(at, toward[:, k], time, segment)
            reference.force_cost *= _force_cost(reference.spheres, own, path, s)
    return reference


def _flights(title: str, between: Array) -> list[tuple[int, int]]:
    """Return the first and last frame of every flight; refuse one at either end of a script."""
    flights = [(run.start, run.stop) for run in runs(np.atleast_1d(~between.any(axis=(1, 2))))]
    if flights and flights[-1][1] == len(between):
        raise ParameterError(f"{title} ends in the air: say which segments press in the end")
    if flights and flights[0][0] == 0:
        raise ParameterError(
            f"{title} is in the air from its beginning, where the person stands: say in a "
            "frame before the flight which segments press at take-off"
        )
    return flights


def _toward(at: Array, toward: Array, time: Array, segment: Array) -> Array:
    """Return the desired pressure within a foot at every time; NaN where that is open."""
    given = np.atleast_1d(~np.isnan(toward).any(axis=1))
    path = through(at, np.where(given[:, None], toward, 0.0), time)
    return np.where((given[segment] & given[segment + 1])[:, None], path, np.nan)


def _force_cost(spheres: Array, own: Array, toward: Array, settings: ScriptSettings) -> Array:
    """Return the factor of the cost of every force by its distance from the desired pressure."""
    cost = np.ones(own.shape)
    for i in np.flatnonzero(own.any(axis=1) & ~np.isnan(toward).any(axis=1)):
        points = spheres[i, own[i], :2]
        low, high = points.min(axis=0), points.max(axis=0)
        pressure = 0.5 * (low + high + toward[i] * (high - low))
        distance = (points - pressure) / (np.array(settings.cop_spread) * (high - low))
        exponent = np.minimum(0.5 * (distance**2).sum(axis=1), MAX_COST_EXPONENT)
        cost[i, own[i]] = np.exp(exponent)
    return cost


def _goals(
    solver: PostureSolver,
    frames: tuple[ScriptFrame, ...],
    between: Array,
    scale: float,
    off: set[int],
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


def through(
    at: Float[Array, " k"], values: Float[Array, "k m"], time: Float[Array, " n"]
) -> Float[Array, "n m"]:
    """Return values between frames.

    Args:
        at: Times of the frames [s].
        time: Times of the result [s].
    """
    return _quintic(at, values, _slopes(at, values), np.zeros_like(values))(time)


def _quintic(at: Array, values: Array, slopes: Array, accelerations: Array) -> BPoly:
    return BPoly.from_derivatives(at, np.stack([values, slopes, accelerations], axis=1))


def _slopes(at: Array, values: Array) -> Array:
    slopes = np.asarray(PchipInterpolator(at, values).derivative()(at))
    slopes[[0, -1]] = 0.0
    return slopes


def com_height(
    at: Float[Array, " k"],
    height: Float[Array, " k"],
    flights: list[tuple[int, int]],
    time: Float[Array, " n"],
    settings: ScriptSettings,
) -> Float[Array, " n"]:
    """Return the height of the centre of mass between frames, in flight that of a fall [m].

    Args:
        at: Times of the frames [s].
        height: Height in each; what is within a flight does not count [m].
        flights: First and last frame of every flight.
        time: Times of the result [s].
        settings: Limit of the force.

    Raises:
        ParameterError: If that needs a pull of the ground, or a push beyond the limit.
    """
    if not flights:
        return through(at, height[:, None], time)[:, 0]
    airborne = np.zeros(len(at), dtype=bool)
    for a, b in flights:
        airborne[a + 1 : b] = True
    keep = np.flatnonzero(~airborne)
    number = {int(k): i for i, k in enumerate(keep)}
    edges = [(number[a], number[b]) for a, b in flights]
    at = at[keep]
    path = _falling(at, height[keep], edges, settings.max_force)
    taken_off = {a for a, _ in edges}
    for k in sorted(set(range(len(at) - 1)) - taken_off):
        force = 1.0 + _between(path, at, k) / GRAVITY
        if not (force.min() > -FORCE_TOLERANCE and force.max() <= settings.max_force):
            raise ParameterError(
                f"from {at[k]:g} to {at[k + 1]:g} s the ground would have to push with "
                f"{force.min():.1f} to {force.max():.1f} body weights, and it can with 0 to "
                f"{settings.max_force:g}: give the body more time or way before and after a flight"
            )
    return path(time)


def _falling(at: Array, height: Array, edges: list[tuple[int, int]], max_force: float) -> BPoly:
    """Return the height between frames, of which ``edges`` begin and end a flight.

    Where the body turns before and after a flight, it does so with the least force.
    """
    slopes, accelerations = _slopes(at, height), np.zeros(len(at))
    for a, b in edges:
        span = at[b] - at[a]
        mean = (height[b] - height[a]) / span
        slopes[[a, b]] = mean + 0.5 * GRAVITY * span, mean - 0.5 * GRAVITY * span
        accelerations[[a, b]] = -GRAVITY
    taken_off, bound = {a for a, _ in edges}, {i for pair in edges for i in pair}
    tried = np.linspace(0.0, max_force - 1.0, N_ACCELERATIONS) * GRAVITY
    for turn in (i for a, b in edges for i in (a - 1, b + 1)):
        if not 0 < turn < len(at) - 1 or turn in bound:
            continue
        slopes[turn] = 0.0
        near = [k for k in (turn - 1, turn) if k not in taken_off]
        needed = []
        for acceleration in tried:
            accelerations[turn] = acceleration
            path = _quintic(at, height, slopes, accelerations)
            needed.append(max(float(np.abs(_between(path, at, k)).max()) for k in near))
        accelerations[turn] = tried[int(np.argmin(needed))]
    return _quintic(at, height, slopes, accelerations)


def _between(path: BPoly, at: Array, k: int) -> Array:
    """Return accelerations from a frame to the next."""
    return path(np.linspace(at[k], at[k + 1], N_SAMPLES), 2)


def ankle_path(
    at: Float[Array, " k"],
    ankle: Float[Array, "k 3"],
    flights: list[tuple[int, int]],
    time: Float[Array, " n"],
    settings: ScriptSettings,
) -> Float[Array, "n 3"]:
    """Return the position of an ankle: along with the body in flight, rising late before it.

    Args:
        at: Times of the frames [s].
        ankle: Its position in each; in flight, from where the body has taken it [m].
        flights: First and last frame of every flight.
        time: Times of the result [s].
    """
    out = through(at, ankle, time)
    for a, b in flights:
        span = at[b] - at[a]
        own = (time >= at[a]) & (time <= at[b])
        s = time[own] - at[a]
        out[own, 2] += 0.5 * GRAVITY * s * (span - s)
        speed = 0.5 * GRAVITY * span
        for i, j in ((a - 1, a), (b + 1, b)):
            if not 0 <= i < len(at) or ankle[j, 2] <= ankle[i, 2]:
                continue
            duration, up = abs(at[j] - at[i]), ankle[j, 2] - ankle[i, 2]
            own = (time >= min(at[i], at[j])) & (time <= max(at[i], at[j]))
            power = float(np.clip(speed * duration / up, *settings.heel_rise_powers))
            out[own, 2] = ankle[i, 2] + up * (np.abs(time[own] - at[i]) / duration) ** power
    return out
