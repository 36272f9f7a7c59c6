"""A tour of twelve waypoints in a minute, with a punch on every leg.

The form in which 34 policies of a humanoid robot were compared in 2026: punches of up to 600 N for
0.08 s at a random body in a random direction; the best completed 77 % of its tours.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.guest import Guest, GuestWalk, gait_of
from experiments.walk_trial import WalkTrial, world_of
from experiments.walkers import Walker
from plantigrade.arrays import Array, Float
from plantigrade.threads import on_one_thread
from plantigrade.world import Push

N_WAYPOINTS = 12
"""Number of waypoints of a tour. Chosen."""
MAX_DURATION = 60.0
"""Greatest duration of a tour [s]. Chosen."""
MAX_PUNCH_FORCE = 600.0
"""Greatest force of a punch [N]."""
PUNCH_DURATION = 0.08
"""Duration of a punch [s]."""
REQUIRED_SPEED_FACTOR = 0.8
"""Speed that the distance of waypoints requires, relative to that of the gait [1]."""
WAYPOINT_RADIUS = 1.0
"""Distance from a waypoint at which it is reached [m]."""
MAX_TURN = np.deg2rad(30.0)
"""Maximum turn between legs of a tour, for controllers that follow waypoints [rad]."""
PUNCH_TIME_RANGE = (0.1, 0.9)
"""Range of the time of a punch, relative to the duration of a leg [1]."""


@dataclass(frozen=True)
class TourOutcome:
    """The outcome of a tour.

    Attributes:
        completed: Whether all waypoints were reached in time, on the feet.
        reached: Number of waypoints reached.
        end: Reason why it was not completed; empty if it was.
        seconds: Duration, or time until the fall [s].
        straight: Whether it was straight, because the controller follows no waypoints.
        punches: Body, force [N], direction [rad] and time [s] of each punch.
    """

    completed: bool
    reached: int
    end: str
    seconds: float
    straight: bool
    punches: tuple[tuple[str, float, float, float], ...]


def waypoints(
    speed: float, rng: np.random.Generator, n: int = N_WAYPOINTS, *, straight: bool = False
) -> Float[Array, "n 2"]:
    """Return waypoints [m] for a speed [m/s]; the tour starts at the origin along x."""
    far = REQUIRED_SPEED_FACTOR * speed * MAX_DURATION / N_WAYPOINTS
    turns = rng.uniform(-MAX_TURN, MAX_TURN, n)
    turns[0] = 0.0
    heading = np.zeros(n) if straight else np.cumsum(turns)
    return np.asarray(np.cumsum(far * np.stack([np.cos(heading), np.sin(heading)], 1), axis=0))


def punches(
    names: Sequence[str], rng: np.random.Generator, n: int = N_WAYPOINTS
) -> tuple[Push, ...]:
    """Return a punch for every leg, with random body of some, direction, force and time."""
    every = MAX_DURATION / N_WAYPOINTS
    return tuple(
        Push(
            body=str(names[int(rng.integers(len(names)))]),
            force=float(rng.uniform(0.0, MAX_PUNCH_FORCE)),
            duration=PUNCH_DURATION,
            direction=float(rng.uniform(0.0, 2 * np.pi)),
            time=every * (k + float(rng.uniform(*PUNCH_TIME_RANGE))),
        )
        for k in range(n)
    )


@on_one_thread
def tour(
    walker: Walker,
    seed: int = 0,
    *,
    n: int = N_WAYPOINTS,
) -> TourOutcome:
    """Simulate a tour.

    Controllers that follow waypoints turn at each; all others walk straight. The walk starts at the
    origin along x.

    Args:
        walker: The walker.
        seed: Seed of turns and punches.
        n: Number of waypoints, five seconds for each.
    """
    rng = np.random.default_rng(seed)
    controller = walker.controller()
    acting = punches(walker.record.human.body_names, rng, n)
    goals = waypoints(walker.speed, rng, n)
    straight = not controller.follow(goals)
    if straight:
        goals = waypoints(walker.speed, rng, n, straight=True)
    world = world_of(walker, controller, disturbances=acting, seed=seed)
    going, reached, last = WalkTrial(walker, controller, world), 0, n * MAX_DURATION / N_WAYPOINTS
    while going.on and reached < n and world.time < last - 1e-9:
        going.step()
        if np.linalg.norm(going.place - goals[reached]) < WAYPOINT_RADIUS:
            reached += 1
    found = going.walked()
    end = found.end or ("" if reached == n else "too late")
    came = tuple((p.body, p.force, p.direction, p.time) for p in acting if p.time < world.time)
    return TourOutcome(not end, reached, end, world.time, straight, came)


@on_one_thread
def guest_tour(make: Callable[[], Guest], seed: int = 0, *, n: int = N_WAYPOINTS) -> TourOutcome:
    """Simulate a straight tour of a guest, along the direction of its undisturbed walk.

    Args:
        make: Class of the guest.
        seed: Seed of the punches.
        n: Number of waypoints, five seconds for each.

    Raises:
        ParameterError: If the guest does not walk.
    """
    rng, gait, going = np.random.default_rng(seed), gait_of(make), GuestWalk(make)
    acting = punches(going.bodies(), rng, n)
    goals = np.linalg.norm(waypoints(gait.speed, rng, n, straight=True), axis=1)
    reached, last = 0, n * MAX_DURATION / N_WAYPOINTS
    half = 0.5 / going.guest.rate
    while going.on and reached < n and going.time < last - half:
        now = [p for p in acting if p.time - half <= going.time < p.time + p.duration - half]
        going.step([(p.body, p.vector) for p in now])
        if (
            going.on
            and np.linalg.norm(going.path[-1, :2] - goals[reached] * gait.axis) < WAYPOINT_RADIUS
        ):
            reached += 1
    end = going.end or ("" if reached == n else "too late")
    came = tuple((p.body, p.force, p.direction, p.time) for p in acting if p.time < going.time)
    return TourOutcome(not end, reached, end, going.time, True, came)
