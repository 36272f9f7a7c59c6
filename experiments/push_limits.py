"""Largest push that a controller withstands, for any body, direction and duration.

::

    def walking(disturbances):
        return World(human, disturbances=disturbances), MyController()

    test = PushTest(walking, duration=0.4)
    limits = push_map(test, directions(16), jobs=-1)

Results are deterministic and independent of the number of jobs.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import GEOM_PREFIX
from plantigrade.errors import ParameterError
from plantigrade.record.jobs import Done, run_jobs
from plantigrade.threads import on_one_thread
from plantigrade.world.controller import AnyController
from plantigrade.world.disturbance import Disturbance, Push, body_index
from plantigrade.world.world import World

__all__ = ["PushTest", "directions", "push_map"]

Situation = Callable[[Sequence[Disturbance]], tuple[World, AnyController]]
"""Function that returns a new world with the given disturbances, and a new controller."""
CONTACT_HEIGHT = 0.005  # [m] above the ground below which a contact sphere supports the person
CHECKED_PARTS = (0.9, 0.75, 0.5)
"""Fractions of a limit at which monotonicity is checked."""


@dataclass(frozen=True)
class PushLimit:
    """The largest push withstood.

    Attributes:
        force: Largest force withstood according to bisection [N]; zero if even the smallest is too
            large.
        tried: Every force tried [N] and whether it was withstood.
        open: Whether even the maximum force was withstood.
    """

    force: float
    tried: dict[float, bool]
    open: bool = False

    @property
    def gaps(self) -> tuple[float, ...]:
        """Forces below the limit that were not withstood [N]; none if the result is monotone."""
        return tuple(sorted(f for f, ok in self.tried.items() if not ok and f < self.force))


def push_limit(
    withstands: Callable[[float], bool],
    *,
    guess: float = 60.0,
    step: float = 2.5,
    most: float = 2000.0,
    below: Sequence[float] = CHECKED_PARTS,
) -> PushLimit:
    """Return the largest force withstood, by doubling and bisection on a grid.

    Bisection assumes that all smaller pushes are withstood, too; some of them are checked.

    Args:
        withstands: Function that returns whether a force [N] is withstood.
        guess: Initial guess [N].
        step: Grid spacing of the forces [N].
        most: Maximum force [N].
        below: Fractions of the limit at which monotonicity is checked.

    Raises:
        ParameterError: If a number is not positive, or ``most`` is below ``step``.

    Example:
        >>> push_limit(lambda force: force < 71.0, step=5.0).force
        70.0
    """
    if not (0 < step <= most < np.inf and guess > 0):
        raise ParameterError(f"step={step}, guess={guess} and most={most} N must be positive")
    tried: dict[float, bool] = {}

    def withstood(k: int) -> bool:
        if k * step not in tried:
            tried[k * step] = bool(withstands(k * step))
        return tried[k * step]

    top = int(most / step + 1e-9)
    lowest, high = 0, min(max(1, round(guess / step)), top)
    while withstood(high):
        if high == top:
            break
        lowest, high = high, min(2 * high, top)
    is_open = tried[high * step]
    lowest = high if is_open else lowest
    while high - lowest > 1:
        middle = (lowest + high) // 2
        lowest, high = (middle, high) if withstood(middle) else (lowest, middle)
    for part in below:
        if (k := int(part * lowest)) > 0:
            withstood(k)
    return PushLimit(lowest * step, dict(sorted(tried.items())), is_open)


def on_feet(world: World) -> bool:
    """Return whether the person has not fallen and the simulation has not diverged."""
    return world.fall is None and world.diverged is None


@dataclass(frozen=True, kw_only=True)
class PushTest:
    """A test in which a person is pushed.

    Attributes:
        situation: Makes the world and the controller.
        duration: Duration of the push [s].
        time: Start time of the push [s].
        watch_time: Time after the push during which the person must not fall [s].
        body: Body that is pushed at its centre of mass; the upper trunk if empty.
        push: Makes another disturbance from force [N] and direction [rad], for instance at a phase
            of the gait.
        withstood: Additional criterion at the end of a simulation without a fall.
    """

    situation: Situation
    duration: float = 0.4
    time: float = 0.5
    watch_time: float = 5.0
    body: str = ""
    push: Callable[[float, float], Push] | None = None
    withstood: Callable[[World], bool] = field(default_factory=lambda: on_feet)

    @on_one_thread
    def pushed(self, force: float, direction: float) -> World:
        """Return the world at the end of a test, or at the fall.

        Args:
            force: Force [N].
            direction: Horizontal direction, 0 forward, a quarter turn to the left [rad].
        """
        if self.push is not None:
            push = self.push(force, direction)
        else:
            push = Push(
                force=force,
                duration=self.duration,
                direction=direction,
                time=self.time,
                body=self.body,
            )
        world, controller = self.situation((push,))
        state = world.reset()
        end = self.time + self.duration + self.watch_time
        while world.time < end - 0.5 / world.rate and on_feet(world):
            state = world.step(controller(state))
        return world

    def __call__(self, force: float, direction: float) -> bool:
        """Return whether a push is withstood."""
        world = self.pushed(force, direction)
        return on_feet(world) and bool(self.withstood(world))

    def limit(self, direction: float, **options: Any) -> PushLimit:
        """Return the largest push withstood in a direction, with options of :func:`push_limit`."""
        return push_limit(lambda force: self(force, direction), **options)


def predicted_limit(world: World, direction: float, duration: float, body: str = "") -> float:
    r"""Return the largest force withstood with the ankle strategy alone [N].

    A pendulum of constant height :math:`z` with the centre of pressure at the far edge of the base
    of support, at a distance :math:`d` from under the centre of mass, stops a force of duration
    :math:`T` that acts :math:`\Delta z` above the centre of mass up to

    .. math:: F = \frac{m \omega^2 d}{1 + \Delta z / z} \, \frac{e^{\omega T}}{e^{\omega T} - 1},
        \qquad \omega = \sqrt{g / z}

    if the body does not rotate: the divergent component of motion is at the edge when the force
    ends. Larger forces require angular momentum of arms and trunk, or a step.

    Args:
        world: World in its first state, feet on the ground.
        direction: Direction of the push [rad].
        duration: Duration of the push [s].
        body: Body that is pushed; the upper trunk if empty.
    """
    state = world.reset()
    lowest = np.array([world.data.geom(GEOM_PREFIX + site.name).xpos for site in world.sites])
    lowest -= np.array([[site.radius] for site in world.sites]) * world.ground.normal
    standing = lowest[lowest @ world.ground.normal - world.ground.under(lowest) < CONTACT_HEIGHT]
    com, mass = state.body.com, world.human.mass
    direction_vector = np.array([np.cos(direction), np.sin(direction)])
    edges = ConvexHull(standing[:, :2]).equations
    directions = edges[:, :2] @ direction_vector
    ahead = directions > 1e-9
    margin = float(np.min(-(edges[ahead, :2] @ com[:2] + edges[ahead, 2]) / directions[ahead]))
    height = float(com[2] - standing[:, 2].mean())
    above = float(world.data.xipos[body_index(world.human, body), 2] - com[2])
    omega = np.sqrt(GRAVITY / height)
    per_metre = mass * omega**2 / (1.0 - np.exp(-omega * duration))
    return float(per_metre * margin / (1.0 + above / height))


def directions(n: int) -> tuple[float, ...]:
    """Return ``n`` equally spaced directions, from 0 (forward) to the left [rad]."""
    return tuple(float(2 * np.pi * k / n) for k in range(n))


def push_map(
    test: PushTest,
    directions: Sequence[float],
    *,
    jobs: int = 1,
    backend: str = "loky",
    **options: Any,
) -> Iterator[Done[float, PushLimit]]:
    """Yield the limit in each direction when it is known.

    Args:
        test: The test.
        directions: Directions [rad].
        jobs: Number of parallel jobs; -1 for one per core.
        backend: ``loky``, ``ray`` or ``dask``.
        options: Options of :func:`push_limit`.
    """

    def limit(direction: float) -> PushLimit:
        return test.limit(direction, **options)

    return run_jobs(limit, directions, jobs=jobs, backend=backend)
