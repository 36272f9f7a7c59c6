"""Domain randomisation: random terrain and pushes, different in every episode."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.ground import Ground
from plantigrade.contact.relief import HeightField
from plantigrade.world import Disturbance, World
from plantigrade.world.disturbance import MAX_FORCE, body_index
from plantigrade.world.grounds import GRID_SPACING, RELIEF_ASIDE, relief

MAX_RELIEF = 0.2  # [m] magnitude of the terrain height
PUSH_DURATIONS = (0.2, 0.4)  # [s] range
PUSH_PAUSES = (0.3, 2.5)  # [s] range of the time between pushes
STRENGTH_RANGE = (0.2, 1.0)  # of the maximum height of an episode or force of a push


class RandomTerrain:
    """Smooth random bumps, drawn for every episode.

    Args:
        height: Maximum magnitude of the height [m].

    Raises:
        ParameterError: If the height is out of range.
    """

    def __init__(self, height: float):
        number("terrain", height, 1e-3, MAX_RELIEF, "m", "learning")
        self.height = height

    def ground(self, friction: float = Ground().friction) -> Ground:
        """Return a ground with room for any of the terrains."""
        z = np.full_like(relief(self.height, np.random.default_rng(0)), self.height)
        z[0, :2] = 0.0, 2.0 * self.height  # range of all terrains
        return Ground(-self.height, field=_field(z), friction=friction)

    def lay(self, world: World, seed: int) -> None:
        """Draw new bumps, with at least a fifth of the maximum height.

        Args:
            world: A world with the ground of :meth:`ground`.
        """
        rng = np.random.default_rng([seed, 1])
        z = relief(self.height * float(rng.uniform(*STRENGTH_RANGE)), rng) + self.height
        world.model.hfield_data[:] = (z / (2.0 * self.height)).ravel()
        world.ground = replace(world.ground, field=_field(z))


def _field(z: Float[Array, "n_y n_x"]) -> HeightField:
    return HeightField(
        (-RELIEF_ASIDE, -RELIEF_ASIDE), (GRID_SPACING, GRID_SPACING), tuple(map(tuple, z.tolist()))
    )


@dataclass(frozen=True, kw_only=True)
class RandomPushes(Disturbance):
    """Random pushes at the upper trunk, in horizontal directions.

    Intervals are 0.3 to 2.5 s, durations 0.2 to 0.4 s, forces at least a fifth of the maximum.

    Raises:
        ParameterError: If the force is out of range.
    """

    force: float  #: Maximum force [N]

    def __post_init__(self):
        number("pushes", self.force, 1e-3, MAX_FORCE, "N", "learning")

    def reset(self, world: World) -> None:
        """Draw the first push."""
        world.memory[self] = self._drawn(world, 0.0)

    def act(self, world: World) -> None:
        """Apply the present push, and draw the next one after it."""
        start, end, force = world.memory[self]
        if world.time >= end - 1e-9:
            start, end, force = world.memory[self] = self._drawn(world, world.time)
        if world.time >= start - 1e-9:
            world.push(body_index(world.human), force)

    def _drawn(self, world: World, now: float) -> tuple[float, float, Float[Array, " 3"]]:
        """Return start and end time [s] of a push, and its force, world [N]."""
        draw = world.random.uniform
        start, turn = now + float(draw(*PUSH_PAUSES)), float(draw(0.0, 2.0 * np.pi))
        size = self.force * float(draw(*STRENGTH_RANGE))
        force = size * np.array([np.cos(turn), np.sin(turn), 0.0])
        return start, start + float(draw(*PUSH_DURATIONS)), force
