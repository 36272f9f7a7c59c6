"""What somebody does to a person by hand: a body dragged on a rope, and a push."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.world import Disturbance
from plantigrade.world.disturbance import body_index
from plantigrade.world.simulated_world import SimulatedWorld

REACH = 0.25
"""A rope that is so long pulls with all the force that is allowed [m]."""
EASE = 0.05
"""Damping of a rope, by its stiffness [s]."""
LIGHT = 0.2
"""Greatest share of a body's speed that the damping takes within one interval."""


@dataclass(frozen=True, eq=False)
class Rope:
    """From a place of a body to a hand.

    Attributes:
        body: Index of the body.
        grip: Where it is held, in its own frame [m].
        end: Where the hand is, world [m].
    """

    body: int
    grip: Float[Array, " 3"]
    end: Float[Array, " 3"]

    def place(self, data: mujoco.MjData) -> Float[Array, " 3"]:
        """Return where it is held, world [m]."""
        turn = data.xmat[self.body].reshape(3, 3)
        return np.array(data.xpos[self.body] + turn @ self.grip)


class Hand(Disturbance):
    """A spring from a body to a hand, no stronger than is allowed, and pushes at the upper trunk.

    The rope pulls where the body is held; a push acts at the centre of mass of the trunk.

    Attributes:
        most: Greatest force of the rope, and force of a push [N].
        rope: What is held; None where nothing is.
        said: What is kept with the frames, as signals.
    """

    interval = 0.005

    def __init__(self, most: float = 100.0):
        self.most, self.rope = most, None
        self.said: dict[str, float] = {}
        self._push: tuple[float, Float[Array, " 3"]] | None = None

    def hold(self, rope: Rope | None) -> None:
        """Take hold of a body, pull it elsewhere, or let go of it."""
        self.rope = rope

    def push(self, until: float, direction: float) -> None:
        """Push until a time of the world [s] in a direction: 0 forward, a quarter turn left."""
        along = np.array([np.cos(direction), np.sin(direction), 0.0])
        self._push = until, self.most * along

    def reset(self, world: SimulatedWorld) -> None:
        """Let go."""
        self.rope = self._push = None

    def act(self, world: SimulatedWorld) -> None:
        """Pull, and push."""
        for name, value in self.said.items():
            world.record_signal(name, value)
        if self._push is not None:
            until, force = self._push
            if world.time >= until - 1e-9:
                self._push = None
            else:
                world.push(body_index(world.human), force)
        rope = self.rope
        if rope is not None:
            world.push(rope.body, *self.pull(world, rope))

    def pull(
        self, world: SimulatedWorld, rope: Rope
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return the force of a rope [N], and where it acts from the centre of mass [m]."""
        model, data = world.model, world.data
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, rope.body, velocity, 0)
        spin, speed = velocity[:3], velocity[3:]
        place = rope.place(data)
        arm = place - data.xipos[rope.body]
        stiffness = self.most / REACH
        damping = min(EASE * stiffness, LIGHT * float(model.body_mass[rope.body]) / self.interval)
        own = speed + np.cross(spin, arm)
        force = stiffness * (rope.end - place) - damping * own
        size = float(np.linalg.norm(force))
        return force * min(1.0, self.most / max(size, 1e-9)), arm
