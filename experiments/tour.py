"""A tour of twelve waypoints in a minute, with a punch on every leg.

The form in which 34 policies of a humanoid robot were compared in 2026: punches of up to 600 N for
0.08 s at a random body in a random direction; the best completed 77 % of its tours.
"""

from dataclasses import dataclass

import numpy as np

from experiments.walk_trial import WalkTrial, world_of
from experiments.walkers import Walker
from plantigrade.arrays import Array, Float
from plantigrade.threads import on_one_thread
from plantigrade.world import Push

WAYPOINTS, SECONDS = 12, 60.0
"""Number of waypoints of a tour, and its maximum duration [s]. Chosen."""
HARDEST, PUNCH = 600.0, 0.08
"""Maximum force [N] and duration [s] of a punch."""
EASY = 0.8
"""Speed that the distance of waypoints requires, relative to that of the gait [1]."""
REACHED = 1.0
"""Distance from a waypoint at which it is reached [m]."""
TURN = np.deg2rad(30.0)
"""Maximum turn between legs of a tour, for controllers that follow waypoints [rad]."""
LATE = (0.1, 0.9)
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
    walker: Walker, rng: np.random.Generator, n: int = WAYPOINTS, *, straight: bool = False
) -> Float[Array, "n 2"]:
    """Return waypoints [m]; the tour starts at the origin along x."""
    far = EASY * walker.speed * SECONDS / WAYPOINTS
    turns = rng.uniform(-TURN, TURN, n)
    turns[0] = 0.0
    heading = np.zeros(n) if straight else np.cumsum(turns)
    return np.asarray(np.cumsum(far * np.stack([np.cos(heading), np.sin(heading)], 1), axis=0))


def punches(walker: Walker, rng: np.random.Generator, n: int = WAYPOINTS) -> tuple[Push, ...]:
    """Return a punch for every leg, with random body, direction, force and time."""
    every = SECONDS / WAYPOINTS
    names = walker.record.human.body_names
    return tuple(
        Push(
            body=str(names[int(rng.integers(len(names)))]),
            force=float(rng.uniform(0.0, HARDEST)),
            duration=PUNCH,
            direction=float(rng.uniform(0.0, 2 * np.pi)),
            time=every * (k + float(rng.uniform(*LATE))),
        )
        for k in range(n)
    )


@on_one_thread
def tour(
    walker: Walker,
    seed: int = 0,
    *,
    n: int = WAYPOINTS,
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
    acting = punches(walker, rng, n)
    goals = waypoints(walker, rng, n)
    straight = not controller.follow(goals)
    if straight:
        goals = waypoints(walker, rng, n, straight=True)
    world = world_of(walker, controller, disturbances=acting, seed=seed)
    going, reached, last = WalkTrial(walker, controller, world), 0, n * SECONDS / WAYPOINTS
    while going.on and reached < n and world.time < last - 1e-9:
        going.step()
        if np.linalg.norm(going.place - goals[reached]) < REACHED:
            reached += 1
    found = going.walked()
    end = found.end or ("" if reached == n else "too late")
    came = tuple((p.body, p.force, p.direction, p.time) for p in acting if p.time < world.time)
    return TourOutcome(not end, reached, end, world.time, straight, came)
