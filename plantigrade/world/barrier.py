"""A bar across the way, under which a person can pass who stoops."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.thing import Thing
from plantigrade.models import Human
from plantigrade.world.disturbance import Disturbance, written_numbers
from plantigrade.world.scene import LIMBS

if TYPE_CHECKING:
    import plantigrade.world.world

RADIUS, HALF = 0.02, 1.5
"""Of the bar, and half its length [m]."""
NEAR = 1.0
"""From so far on it is looked how near the person comes [m]."""
NAME = "barrier"


@dataclass(frozen=True, kw_only=True)
class Barrier(Disturbance):
    """A fixed bar across the x axis, which stops trunk, head and limbs.

    While the person is about it, the signal ``barrier.clearance`` is the distance from the bar to
    the skin of who passes, feet and legs too [m].

    Attributes:
        ahead: How far ahead of the origin it is [m].
        height: Height of its underside above level ground [m].

    Raises:
        ParameterError: If a number is out of range.
    """

    interval = 0.01
    ahead: float
    height: float

    def __post_init__(self):
        """Refuse what is no barrier."""
        number("ahead", self.ahead, 0.5, 1e3, "m", "a barrier")
        number("height", self.height, 0.3, 3.0, "m", "a barrier")

    @staticmethod
    def written(word: str) -> "Barrier":
        """Return the barrier of a word: how far ahead, and how high its underside is [m].

        Raises:
            ParameterError: If it is none.

        Example:
            >>> Barrier.written("5,1.6").height
            1.6
        """
        ahead, height = written_numbers(
            word, "barrier", "AHEAD_M,HEIGHT_M such as 5,1.6: 5 m ahead, 1.6 m high", 2
        )
        return Barrier(ahead=ahead, height=height)

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Put the bar there."""
        number = sum(body.name.startswith(NAME) for body in spec.bodies)
        place = [self.ahead, 0.0, self.height + RADIUS]
        body = spec.worldbody.add_body(name=f"{NAME}_{number}", pos=place)
        body.add_geom(
            name=f"{NAME}_{number}",
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[RADIUS, 0.0, 0.0],
            fromto=[0.0, -HALF, 0.0, 0.0, HALF, 0.0],
            contype=2 | LIMBS,
            conaffinity=2 | LIMBS,
            rgba=[0.72, 0.60, 0.45, 1.0],
            friction=[0.3, 0.005, 0.0001],
        )

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Find the bar, and what the person is drawn with."""
        own = [d for d in world.disturbances if isinstance(d, Barrier)]
        bar = world.model.geom(f"{NAME}_{next(i for i, d in enumerate(own) if d is self)}").id
        model, n = world.model, len(world.human.body_names)
        body = np.array(model.geom_bodyid)
        skin = (body > 0) & (body <= n) & (np.array(model.geom_contype) == 0)
        world.memory[self] = bar, np.flatnonzero(skin)

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Say how near the person is."""
        if abs(float(world.data.subtree_com[1, 0]) - self.ahead) < NEAR:
            world.say("barrier.clearance", clearance(world, *world.memory[self]))

    @property
    def thing(self) -> Thing:
        """The bar."""
        return Thing(NAME, "capsule", (RADIUS, HALF, 0.0))

    def place(self, world: "plantigrade.world.world.World") -> Float[Array, " 7"]:
        """Return where it is, lying across the way."""
        half = np.sqrt(0.5)
        return np.array([self.ahead, 0.0, self.height + RADIUS, half, half, 0.0, 0.0])


def clearance(world: "plantigrade.world.world.World", bar: int, skin: Array) -> float:
    """Return how far a bar is from geoms of a person, negative where it is in them [m]."""
    ends = np.zeros(6)
    return min(
        mujoco.mj_geomDistance(world.model, world.data, bar, int(g), 2.0 * NEAR, ends) for g in skin
    )
