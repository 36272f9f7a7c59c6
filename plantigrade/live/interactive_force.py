"""Interactive forces on a person: a rope that drags a body, and a push."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.world import Disturbance
from plantigrade.world.disturbance import body_index
from plantigrade.world.simulated_world import SimulatedWorld

FULL_FORCE_LENGTH = 0.25  # [m] of a rope at which it pulls with the maximum force
DAMPING_TIME = 0.05  # [s] ratio of damping to stiffness of a rope
MAX_DAMPED_SHARE = 0.2  # of a body's velocity removed by damping per interval, for stability


@dataclass(frozen=True, eq=False)
class DragRope:
    """A rope between a point of a body and the hand of the user."""

    body: int  #: Index of the body
    grip: Float[Array, " 3"]  #: Point of the body, in its own frame [m]
    end: Float[Array, " 3"]  #: Position of the hand, world [m]

    def position(self, data: mujoco.MjData) -> Float[Array, " 3"]:
        """Return the point of the body, world [m]."""
        turn = data.xmat[self.body].reshape(3, 3)
        return np.array(data.xpos[self.body] + turn @ self.grip)


class InteractiveForce(Disturbance):
    """Interactive forces: a rope with limited force, and pushes at the upper trunk.

    The rope pulls at its point of the body; a push acts at the centre of mass of the trunk.

    Attributes:
        max_force: Maximum force of the rope, and force of a push [N].
        rope: The rope; None if no body is held.
        signals: Signals to be recorded with the frames.
    """

    interval = 0.005

    def __init__(self, max_force: float = 100.0):
        self.max_force, self.rope = max_force, None
        self.signals: dict[str, float] = {}
        self._push: tuple[float, Float[Array, " 3"]] | None = None

    def hold(self, rope: DragRope | None) -> None:
        """Hold a body by a rope, move the rope, or release the body with None."""
        self.rope = rope

    def push(self, until: float, direction: float) -> None:
        """Push until a time [s] in a direction, 0 forward, a quarter turn to the left [rad]."""
        along = np.array([np.cos(direction), np.sin(direction), 0.0])
        self._push = until, self.max_force * along

    def reset(self, world: SimulatedWorld) -> None:
        """Release the body and end a push."""
        self.rope = self._push = None

    def act(self, world: SimulatedWorld) -> None:
        """Apply rope and push, and record the signals."""
        for name, value in self.signals.items():
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
        self, world: SimulatedWorld, rope: DragRope
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return the force of a rope [N] and its lever arm from the centre of mass [m]."""
        model, data = world.model, world.data
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, rope.body, velocity, 0)
        spin, speed = velocity[:3], velocity[3:]
        place = rope.position(data)
        arm = place - data.xipos[rope.body]
        stiffness = self.max_force / FULL_FORCE_LENGTH
        damping = min(
            DAMPING_TIME * stiffness,
            MAX_DAMPED_SHARE * float(model.body_mass[rope.body]) / self.interval,
        )
        own = speed + np.cross(spin, arm)
        force = stiffness * (rope.end - place) - damping * own
        size = float(np.linalg.norm(force))
        return force * min(1.0, self.max_force / max(size, 1e-9)), arm
