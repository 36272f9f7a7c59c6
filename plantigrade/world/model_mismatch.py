"""What is otherwise than a motion was planned for, and than its controller knows."""

from collections import deque
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import Controller, State, World, WrappedController, fit_soles, on_ground
from plantigrade.world.command import AnyCommand

FARTHEST = 0.05
"""A start whose feet are farther from the ground than this is a flight, and left as it is [m]."""
REST, ON = 0.1, 0.02
"""Who starts slower than this [m/s, rad/s], both feet this near to the ground [m], stands."""
RATES = 10.0
"""Noise of rates, by that of angles [1/s]."""


@dataclass(frozen=True, kw_only=True)
class ModelMismatch:
    """What is otherwise than planned; the controller knows nothing of it but the ground's friction.

    Attributes:
        mass: Of every segment, by what was planned; strength is as planned.
        friction: Of the ground; None: as planned.
        ground: Another ground; None: as planned.
        delay: Of every command [s].
        sensors: Standard deviation of white noise on the angles that the controller sees [rad]; on
            their rates, and on those of the pelvis, :data:`RATES` times that [rad/s, m/s].
        start: Standard deviation of what is added to every velocity of the start [rad/s, m/s].
    """

    mass: float = 1.0
    friction: float | None = None
    ground: Ground | None = None
    delay: float = 0.0
    sensors: float = 0.0
    start: float = 0.0

    def under(self, planned: Ground) -> Ground:
        """Return the ground that is there; seats of the planned one stay where they are."""
        ground = planned
        if self.ground is not None:
            ground = replace(self.ground, seats=planned.seats)
        return ground if self.friction is None else replace(ground, friction=self.friction)

    def beginning(
        self, human: Human, motion: Motion, planned: Ground, seed: int
    ) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
        """Return where a motion starts, and how fast.

        Feet are brought to the ground, unless it starts in flight; who starts from standing on
        another ground than planned has the soles fit_soles on it.

        Args:
            human: Who does it.
            motion: The motion.
            planned: The ground it happened on.
            seed: Of the noise of the start.
        """
        ground, qpos, qvel = self.under(planned), motion.qpos[0], motion.qvel[0]
        placed = on_ground(human, ground, qpos)
        if self.ground is not None and stands(human, planned, qpos, qvel):
            qpos = fit_soles(human, ground, qpos)
        elif self.ground is not None or abs(placed[2] - qpos[2]) <= FARTHEST:
            qpos = placed
        return qpos, self.disturbed(qvel, seed)

    def disturbed(self, qvel: Float[Array, " nv"], seed: int) -> Float[Array, " nv"]:
        """Return the velocity of a start with its noise."""
        noise = np.random.default_rng(seed).standard_normal(len(qvel))
        return qvel + self.start * noise

    def change(self, world: World) -> None:
        """Give the person of a world the mass they have."""
        if self.mass != 1.0:
            own = slice(1, len(world.human.body_names) + 1)
            world.model.body_mass[own] *= self.mass
            world.model.body_inertia[own] *= self.mass
            mujoco.mj_setConst(world.model, mujoco.MjData(world.model))

    def seen(self, controller: Controller) -> Controller:
        """Return a controller that sees with noise and acts with delay."""
        return _Seen(controller, self) if self.delay or self.sensors else controller

    def told(self, record: Record) -> Record:
        """Return what happened, of the person as they were."""
        if self.mass == 1.0:
            return record
        return replace(record, human=record.human.with_mass(self.mass * record.human.mass))

    @property
    def words(self) -> str:
        """What is otherwise, but for the ground, as a part of a sentence; empty for nothing."""
        share = 100.0 * (self.mass - 1.0)
        said = [
            share and f"{abs(share):g} % {'heavier' if share > 0 else 'lighter'} than planned",
            self.friction is not None and f"with friction {self.friction:g}",
            self.delay and f"commands {1e3 * self.delay:g} ms late",
            self.sensors and f"sensor noise {np.rad2deg(self.sensors):.2g}°",
            self.start and f"initial velocities disturbed by {self.start:g} rad/s and m/s",
        ]
        return "".join(f", {words}" for words in said if words)


def stands(
    human: Human, ground: Ground, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]
) -> bool:
    """Return whether somebody is at rest, both feet on the ground."""
    if np.abs(qvel).max() > REST:
        return False
    sites = contact_sites(human)
    places = BodyState(human, qpos).position(PointSet.of(human, sites))
    gap = places @ ground.normal - ground.under(places) - [site.radius for site in sites]
    return all(min(g for g, s in zip(gap, sites, strict=True) if s.side == x) < ON for x in "rl")


class _Seen(WrappedController):
    """A controller that sees with noise and acts with delay; all else is that of its own."""

    def __init__(self, controller: Controller, how: ModelMismatch):
        super().__init__(controller)
        self._how = how
        self._waiting: deque[AnyCommand] = deque()

    def __call__(self, state: State) -> AnyCommand:
        world, noise = state.world, self._how.sensors
        if state.time == 0.0:
            self._waiting.clear()
        if noise:
            n = len(state.qvel)
            state.qvel = state.qvel + RATES * noise * world.random.standard_normal(n)
            state.qpos = state.qpos.copy()
            state.qpos[7:] += noise * world.random.standard_normal(n - 6)
        self._waiting.append(self.inner(state))
        if len(self._waiting) > round(self._how.delay * world.control_rate):
            return self._waiting.popleft()
        return self._waiting[0]
