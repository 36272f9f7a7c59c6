"""What disturbs those who learn: relief and pushes, other ones in every episode.

A policy that has been disturbed while it learned walks where it never was: the field calls that
domain randomisation.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.ground import Ground, HeightField
from plantigrade.world import Disturbance, World
from plantigrade.world.disturbance import MAX_FORCE, body_index
from plantigrade.world.grounds import GRID_SPACING, RELIEF_ASIDE, relief

HIGHEST = 0.2
"""Relief is at most so high and so deep [m]."""
LONG = (0.2, 0.4)
"""A push lasts between [s]."""
APART = (0.3, 2.5)
"""From one push to the next it takes between [s]."""
SHARE = (0.2, 1.0)
"""Of the greatest relief or force, an episode or a push has between."""


class Relief:
    """Bumps that are drawn anew: of random heights, smoothed, another landscape every time.

    Args:
        height: They are at most so high and so deep [m].

    Raises:
        ParameterError: If that is out of range.
    """

    def __init__(self, height: float):
        number("terrain", height, 1e-3, HIGHEST, "m", "learning")
        self.height = height

    def ground(self, friction: float = Ground().friction) -> Ground:
        """Return a ground on which any of them can lie."""
        z = np.full_like(relief(self.height, np.random.default_rng(0)), self.height)
        z[0, :2] = 0.0, 2.0 * self.height  # so that all have room
        return Ground(-self.height, field=_field(z), friction=friction)

    def lay(self, world: World, seed: int) -> None:
        """Lay new bumps in a world that was made with :meth:`ground`: a fifth as high at least.

        Args:
            world: The world.
            seed: By which they are drawn.
        """
        rng = np.random.default_rng([seed, 1])
        z = relief(self.height * float(rng.uniform(*SHARE)), rng) + self.height
        world.model.hfield_data[:] = (z / (2.0 * self.height)).ravel()
        world.ground = replace(world.ground, field=_field(z))


def _field(z: Float[Array, "n_y n_x"]) -> HeightField:
    return HeightField(
        (-RELIEF_ASIDE, -RELIEF_ASIDE), (GRID_SPACING, GRID_SPACING), tuple(map(tuple, z.tolist()))
    )


@dataclass(frozen=True, kw_only=True)
class RandomPushes(Disturbance):
    """Pushes at the upper trunk from anywhere, by the world's random numbers.

    From one to the next it takes 0.3 to 2.5 s. Each has a fifth of the
    greatest force or more and lasts 0.2 to 0.4 s.

    Attributes:
        force: The greatest [N].

    Raises:
        ParameterError: If it is out of range.
    """

    force: float

    def __post_init__(self):
        """Refuse what is no force."""
        number("pushes", self.force, 1e-3, MAX_FORCE, "N", "learning")

    def reset(self, world: World) -> None:
        """Draw the first."""
        world.memory[self] = self._drawn(world, 0.0)

    def act(self, world: World) -> None:
        """Push while one lasts; draw another after it."""
        start, end, force = world.memory[self]
        if world.time >= end - 1e-9:
            start, end, force = world.memory[self] = self._drawn(world, world.time)
        if world.time >= start - 1e-9:
            world.push(body_index(world.human), force)

    def _drawn(self, world: World, now: float) -> tuple[float, float, Float[Array, " 3"]]:
        """Return when a push begins and ends [s], and its force, world [N]."""
        draw = world.random.uniform
        start, turn = now + float(draw(*APART)), float(draw(0.0, 2.0 * np.pi))
        size = self.force * float(draw(*SHARE))
        force = size * np.array([np.cos(turn), np.sin(turn), 0.0])
        return start, start + float(draw(*LONG)), force
