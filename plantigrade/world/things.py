"""Ropes that pull at a person, and boxes that are dropped or thrown."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.disturbance import Disturbance, trunk
from plantigrade.world.scene import LIMBS

if TYPE_CHECKING:
    import plantigrade.world.world

AWAY = 50.0
"""Height at which a box waits until it is thrown [m]."""


@dataclass(frozen=True, kw_only=True)
class Rope(Disturbance):
    """A rope that pulls a body to a fixed place with a constant force.

    Attributes:
        force: Tension [N].
        anchor: Where it leads to, world [m].
        time: When it begins to pull [s].
        duration: How long it pulls; without end if absent [s].
        body: Name of the body at whose centre of mass it is tied; the upper trunk if empty.

    Raises:
        ParameterError: If a number is not finite, or the tension negative.
    """

    interval = 0.01
    force: float
    anchor: tuple[float, float, float]
    time: float = 0.0
    duration: float = np.inf
    body: str = ""

    def __post_init__(self):
        """Refuse what is no rope."""
        if not (np.isfinite([self.force, *self.anchor, self.time]).all() and self.duration > 0):
            raise ParameterError(f"{self} has a number that is not finite, or no duration")
        if self.force < 0:
            raise ParameterError(f"force={self.force:g} N: a rope only pulls")

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Refuse a body that is not there."""
        trunk(world.human, self.body)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends to pull [s]."""
        return tuple(t for t in (self.time, self.time + self.duration) if np.isfinite(t))

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Pull while it lasts."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            body = trunk(world.human, self.body)
            way = np.array(self.anchor) - world.data.xipos[body]
            far = float(np.linalg.norm(way))
            if far > 1e-6:
                world.push(body, self.force / far * way)


@dataclass(frozen=True, kw_only=True)
class Box(Disturbance):
    """A box that is dropped or thrown.

    Attributes:
        position: Where its centre starts, world [m].
        velocity: How fast, world [m/s].
        time: When [s].
        mass: Its mass [kg].
        size: Its edges [m].

    Raises:
        ParameterError: If a number is not finite, or mass or size not positive.
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time: float = 0.0
    mass: float = 2.0
    size: tuple[float, float, float] = (0.2, 0.2, 0.2)

    def __post_init__(self):
        """Refuse what is no box."""
        numbers = [*self.position, *self.velocity, self.time, self.mass, *self.size]
        if not (np.isfinite(numbers).all() and min(self.mass, *self.size) > 0 and self.time >= 0):
            raise ParameterError(f"{self} has a number that is not finite or not positive")

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add the box, far away."""
        number = sum(body.name.startswith("box_") for body in spec.bodies)
        body = spec.worldbody.add_body(name=f"box_{number}", pos=[3.0 * number, 0.0, AWAY])
        edge = np.array(self.size) ** 2
        body.mass, body.ipos = self.mass, [0.0, 0.0, 0.0]
        body.inertia = self.mass / 12.0 * (edge.sum() - edge)
        body.explicitinertial = True
        body.add_freejoint(name=f"box_{number}")
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * x for x in self.size],
            contype=2 | LIMBS,
            conaffinity=1 | 2 | LIMBS,
            rgba=[0.72, 0.60, 0.45, 1.0],
            friction=[0.6, 0.005, 0.0001],
        )

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Find its joint: boxes come in the order of the disturbances."""
        boxes = [d for d in world.disturbances if isinstance(d, Box)]
        number = next(i for i, box in enumerate(boxes) if box is self)
        joint = world.model.joint(f"box_{number}")
        world.memory[self] = [int(joint.qposadr[0]), int(joint.dofadr[0]), False]

    def edges(self) -> tuple[float, ...]:
        """Return when it is thrown [s]."""
        return (self.time,)

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Wait, then fly."""
        q, v, thrown = world.memory[self]
        if thrown:
            return
        data = world.data
        data.qvel[v : v + 6] = 0.0
        data.qpos[q + 2] = AWAY
        if world.time >= self.time - 1e-9:
            data.qpos[q : q + 7] = [*self.position, 1.0, 0.0, 0.0, 0.0]
            data.qvel[v : v + 3] = self.velocity
            world.memory[self][2] = True
