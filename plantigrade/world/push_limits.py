"""How hard a push a controller withstands: any controller, body, direction and duration.

::

    def walking(disturbances):
        return World(human, disturbances=disturbances), MyController()

    test = PushTest(walking, duration=0.4)
    limits = push_map(test, directions(16), jobs=-1)

Everything is deterministic: the same test has the same limits, with any number of jobs.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import GEOM
from plantigrade.errors import ParameterError
from plantigrade.record.jobs import Done, run_jobs
from plantigrade.threads import on_one_thread
from plantigrade.world.controller import AnyController
from plantigrade.world.disturbance import Disturbance, Push, trunk
from plantigrade.world.world import World

Situation = Callable[[Sequence[Disturbance]], tuple[World, AnyController]]
"""What is pushed: a new world with these disturbances in it, and a new controller."""
NEAR = 0.005
"""What is no higher than this above the ground stands on it [m]."""
BELOW = (0.9, 0.75, 0.5)
"""Parts of a limit at which it is tried whether lighter pushes are withstood, too."""


@dataclass(frozen=True)
class PushLimit:
    """The largest push withstood.

    Attributes:
        force: The largest force withstood below the one that bisection found too large [N]; zero
            if the smallest is too large.
        tried: Every force tried, and whether it was withstood [N].
        open: Whether even the largest force allowed was withstood.
    """

    force: float
    tried: dict[float, bool]
    open: bool = False

    @property
    def gaps(self) -> tuple[float, ...]:
        """Forces below the limit that were not withstood; none where it is monotone [N]."""
        return tuple(sorted(f for f, ok in self.tried.items() if not ok and f < self.force))


def push_limit(
    withstands: Callable[[float], bool],
    *,
    guess: float = 60.0,
    step: float = 2.5,
    most: float = 2000.0,
    below: Sequence[float] = BELOW,
) -> PushLimit:
    """Return the largest force withstood, by doubling and bisection on a grid.

    Bisection takes for granted that whoever withstands a push withstands all lighter ones. So
    some lighter ones are tried as well.

    Args:
        withstands: Whether a force is withstood [N].
        guess: Where to begin [N].
        step: Distance of the forces of the grid [N].
        most: The largest that is tried [N].
        below: Parts of the limit that are tried after it.

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
    low, high = 0, min(max(1, round(guess / step)), top)
    while withstood(high):
        if high == top:
            break
        low, high = high, min(2 * high, top)
    is_open = tried[high * step]
    low = high if is_open else low
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if withstood(middle) else (low, middle)
    for part in below:
        if (k := int(part * low)) > 0:
            withstood(k)
    return PushLimit(low * step, dict(sorted(tried.items())), is_open)


def on_feet(world: World) -> bool:
    """Return whether a person has neither fallen nor left physics."""
    return world.fall is None and world.diverged is None


@dataclass(frozen=True, kw_only=True)
class PushTest:
    """A situation in which a person is pushed, and what counts as withstood.

    Attributes:
        situation: What is pushed.
        duration: How long the push acts [s].
        time: When it begins [s].
        watch: How long the person must last after its end [s].
        body: Which body is pushed at its centre of mass; the upper trunk if empty.
        push: Makes the disturbance in its place, from force [N] and direction [rad]: at a phase of
            the gait, for instance.
        withstood: Asked at the end of a simulation in which nobody fell.
    """

    situation: Situation
    duration: float = 0.4
    time: float = 0.5
    watch: float = 5.0
    body: str = ""
    push: Callable[[float, float], Push] | None = None
    withstood: Callable[[World], bool] = on_feet

    @on_one_thread
    def pushed(self, force: float, direction: float) -> World:
        """Return the world after a push: at its end, or where the person fell.

        Args:
            force: [N].
            direction: Where the push goes to, over the ground: 0 forward, a quarter turn to the
                left [rad].
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
        end = self.time + self.duration + self.watch
        while world.time < end - 0.5 / world.rate and on_feet(world):
            state = world.step(controller(state))
        return world

    def __call__(self, force: float, direction: float) -> bool:
        """Return whether a push is withstood."""
        world = self.pushed(force, direction)
        return on_feet(world) and bool(self.withstood(world))

    def limit(self, direction: float, **how: Any) -> PushLimit:
        """Return the largest push withstood in a direction; ``how`` goes to :func:`push_limit`."""
        return push_limit(lambda force: self(force, direction), **how)


def predicted_limit(world: World, direction: float, duration: float, body: str = "") -> float:
    r"""Return the force that a person who only shifts the pressure under their feet withstands [N].

    A pendulum of constant height :math:`z` with the pressure at the far edge of the base of
    support, at a distance :math:`d` from under the centre of mass, stops a force of duration
    :math:`T` that acts :math:`\Delta z` above the centre of mass up to

    .. math:: F = \frac{m \omega^2 d}{1 + \Delta z / z} \, \frac{e^{\omega T}}{e^{\omega T} - 1},
        \qquad \omega = \sqrt{g / z}

    if the body does not turn: then its divergent component is just at the edge when the force
    ends. What lies far above was won by swinging arms and trunk, or by a step.

    Args:
        world: In its first state, feet on the ground.
        direction: Where the push goes to [rad].
        duration: How long it lasts [s].
        body: What is pushed; the upper trunk if empty.
    """
    state = world.reset()
    low = np.array([world.data.geom(GEOM + site.name).xpos for site in world.sites])
    low -= np.array([[site.radius] for site in world.sites]) * world.ground.normal
    standing = low[low @ world.ground.normal - world.ground.under(low) < NEAR]
    com, mass = state.body.com, world.human.mass
    way = np.array([np.cos(direction), np.sin(direction)])
    edges = ConvexHull(standing[:, :2]).equations
    towards = edges[:, :2] @ way
    ahead = towards > 1e-9
    margin = float(np.min(-(edges[ahead, :2] @ com[:2] + edges[ahead, 2]) / towards[ahead]))
    height = float(com[2] - standing[:, 2].mean())
    above = float(world.data.xipos[trunk(world.human, body), 2] - com[2])
    omega = np.sqrt(GRAVITY / height)
    per_metre = mass * omega**2 / (1.0 - np.exp(-omega * duration))
    return float(per_metre * margin / (1.0 + above / height))


def directions(n: int) -> tuple[float, ...]:
    """Return so many directions all around, the first forward, the next to its left [rad]."""
    return tuple(float(2 * np.pi * k / n) for k in range(n))


def push_map(
    test: PushTest, towards: Sequence[float], *, jobs: int = 1, backend: str = "loky", **how: Any
) -> Iterator[Done[float, PushLimit]]:
    """Yield the limit in each direction, as soon as it is there.

    Args:
        test: What is pushed, and when it counts.
        towards: Directions [rad].
        jobs: How many at once; -1 for one per core.
        backend: ``loky``, ``ray`` or ``dask``.
        how: Goes to :func:`push_limit`.
    """

    def limit(direction: float) -> PushLimit:
        return test.limit(direction, **how)

    return run_jobs(limit, towards, jobs=jobs, backend=backend)
