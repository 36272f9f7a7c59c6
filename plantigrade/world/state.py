"""The state of a world that is passed to its controller."""

from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.world.simulated_world import SimulatedWorld


class State:
    """State of the person at one instant.

    Attributes:
        time: Time since the start [s].
        qpos: Configuration, read only.
        qvel: Velocity, read only.
        world: The world, with MuJoCo's ``model`` and ``data`` and the ``ground``.
    """

    def __init__(self, world: SimulatedWorld):
        """Copy the present state of a world."""
        human = world.human
        self.world, self.time = world, world.time
        self.qpos = world.data.qpos[: human.model.nq].copy()
        self.qvel = world.data.qvel[: human.model.nv].copy()
        self.qpos.flags.writeable = self.qvel.flags.writeable = False

    @property
    def human(self) -> Human:
        """The person."""
        return self.world.human

    @property
    def angles(self) -> Float[Array, " n_hinges"]:
        """Angles of the hinges, in the order of :attr:`Human.coordinates` [rad]."""
        return self.qpos[7:]

    @property
    def rates(self) -> Float[Array, " n_hinges"]:
        """Their rates [rad/s]."""
        return self.qvel[6:]

    @cached_property
    def body(self) -> BodyState:
        """The evaluated body: centre of mass, positions, Jacobians, momentum."""
        return self.world.evaluated(self.qpos, self.qvel)

    @cached_property
    def contact_force(self) -> Float[Array, "n_sites 3"]:
        """Force of the ground at each contact sphere, in the last step of the physics [N].

        In the order of :func:`~plantigrade.contact.site.contact_sites`.
        """
        return self.world.contact_force()

    def foot_force(self, side: str) -> Float[Array, " 3"]:
        """Return the force of the ground on a foot, ``"r"`` or ``"l"`` [N]."""
        mine = [site.side == side for site in self.world.sites]
        return np.asarray(self.contact_force[np.array(mine)].sum(axis=0))

    def __repr__(self) -> str:
        return f"State(time={self.time:.3f})"
