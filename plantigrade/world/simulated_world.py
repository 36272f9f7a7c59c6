"""A simulated world as controllers and disturbances see it."""

from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import ContactSite
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.record.signals import signal_of
from plantigrade.world.actuators import Actuators
from plantigrade.world.contacts import Contacts
from plantigrade.world.falls import Fall


class SimulatedWorld:
    """A person on a ground at the present instant, and the forces that act until the next one.

    :class:`~plantigrade.world.World` steps it.

    Attributes:
        human: The person.
        ground: The ground.
        disturbances: Disturbances that act on the person.
        rate: Steps of the physics per second [1/s].
        control_rate: Commands per second [1/s].
        model: MuJoCo's model; the person's coordinates come first.
        data: MuJoCo's data.
        sites: The contact spheres of the feet, and additional sites.
        actuators: The motors of the joints.
        contacts: The contacts of the feet with the ground.
        memory: State of disturbances and controllers until the next reset.
        random: Generator of random numbers for disturbances and controllers.
        seed: Its seed.
        fall: The fall of the person; None before it.
        diverged: Time at which the simulation diverged [s]; None before that.
    """

    human: Human
    ground: Ground
    disturbances: tuple[Any, ...]
    rate: float
    control_rate: float
    model: mujoco.MjModel
    data: mujoco.MjData
    sites: tuple[ContactSite, ...]
    actuators: Actuators
    contacts: Contacts
    memory: dict[Any, Any]
    random: np.random.Generator
    seed: int
    fall: Fall | None
    diverged: float | None
    _steps: int
    _pushed: list[tuple[int, Array, Array]]
    _last_pushes: list[tuple[int, Array, Array]]
    _signals: dict[str, Any]
    _body: BodyState

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps / self.rate

    def push(
        self, body: int, force: Float[Array, " 3"], arm: Float[Array, " 3"] | None = None
    ) -> None:
        """Apply a force to a body until the next control step or edge of a disturbance.

        For disturbances and interactive forces; call it before :meth:`step`.

        Args:
            force: Force, world [N].
            arm: Lever arm from the centre of mass of the body, world [m]; zero if absent.
        """
        lever = np.zeros(3) if arm is None else np.array(arm, dtype=float)
        self._pushed.append((body, np.array(force, dtype=float), lever))

    @property
    def pushes(self) -> Float[Array, "n 2 3"]:
        """Points [m] and forces [N] of the pushes at the end of the last control step."""
        place = self.data.xipos
        acted = [(place[body] + arm, force) for body, force, arm in self._last_pushes]
        return np.array(acted).reshape(-1, 2, 3)

    def record_signal(self, name: str, value: float | Array) -> None:
        """Record a number or array of a disturbance as a signal.

        Raises:
            ParameterError: If no signal has this name; your own begin with ``user.``.
        """
        signal_of(name)
        self._signals[name] = value

    def contact_force(self) -> Float[Array, "n_sites 3"]:
        """Return the ground reaction force at each contact sphere in the last step [N]."""
        return self.contacts.forces(self.data)

    def evaluated(self, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]) -> BodyState:
        """Return the evaluated body at a configuration and velocity."""
        self._body = self._body.moved_to(qpos, qvel)
        return self._body
