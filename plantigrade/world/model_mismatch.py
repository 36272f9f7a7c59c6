"""Differences between the world and the model that a controller was planned with."""

from collections import deque
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import Controller, State, World, WrappedController, fit_soles, on_ground
from plantigrade.world.command import AnyCommand

MAX_FOOT_GAP = 0.05
"""Distance of the feet from the ground above which a motion starts in flight [m]. Chosen."""
MAX_STANDING_SPEED = 0.1  # Largest velocity of a person who stands [m/s, rad/s]. Chosen.
MAX_STANDING_GAP = 0.02
"""Largest distance of both feet from the ground of a person who stands [m]. Chosen."""
RATE_NOISE = 10.0
"""Noise of the rates over that of the angles [1/s]. Chosen."""


@dataclass(frozen=True, kw_only=True)
class ModelMismatch:
    """Model mismatch of a simulation; a controller knows only the friction of the ground."""

    mass: float = 1.0  #: Mass of every segment over the planned one; strength is as planned
    friction: float | None = None  #: Friction coefficient of the ground; None: as planned
    ground: Ground | None = None  #: Ground of the simulation; None: as planned
    delay: float = 0.0  #: Delay of every command [s]
    #: Standard deviation of white noise on the angles that the controller observes [rad]; on their
    #: rates, and on those of the pelvis, :data:`RATE_NOISE` times that [rad/s, m/s]
    sensors: float = 0.0
    start: float = 0.0  #: Standard deviation of the noise of every initial velocity [rad/s, m/s]

    def ground_of(self, planned: Ground) -> Ground:
        """Return the ground of the simulation; seats stay where they are planned."""
        ground = planned
        if self.ground is not None:
            ground = replace(self.ground, seats=planned.seats)
        return ground if self.friction is None else replace(ground, friction=self.friction)

    def initial_state(
        self, human: Human, motion: Motion, planned: Ground, seed: int
    ) -> tuple[Float[Array, " nq"], Float[Array, " nv"]]:
        """Return initial configuration and velocity of a motion.

        Feet are moved to the ground unless the motion starts in flight. A person who stands on
        another ground than planned has the soles fitted to it.
        """
        ground, qpos, qvel = self.ground_of(planned), motion.qpos[0], motion.qvel[0]
        placed = on_ground(human, ground, qpos)
        if self.ground is not None and stands(human, planned, qpos, qvel):
            qpos = fit_soles(human, ground, qpos)
        elif self.ground is not None or abs(placed[2] - qpos[2]) <= MAX_FOOT_GAP:
            qpos = placed
        return qpos, self.disturbed(qvel, seed)

    def disturbed(self, qvel: Float[Array, " nv"], seed: int) -> Float[Array, " nv"]:
        """Return an initial velocity with noise."""
        noise = np.random.default_rng(seed).standard_normal(len(qvel))
        return qvel + self.start * noise

    def apply(self, world: World) -> None:
        """Scale mass and inertia of the person of a world."""
        if self.mass != 1.0:
            own = slice(1, len(world.human.body_names) + 1)
            world.model.body_mass[own] *= self.mass
            world.model.body_inertia[own] *= self.mass
            mujoco.mj_setConst(world.model, mujoco.MjData(world.model))

    def wrapped(self, controller: Controller) -> Controller:
        """Return the controller with sensor noise and delay."""
        return _Disturbed(controller, self) if self.delay or self.sensors else controller

    def corrected(self, record: Record) -> Record:
        """Return the record with the mass that the person had."""
        if self.mass == 1.0:
            return record
        return replace(record, human=record.human.with_mass(self.mass * record.human.mass))

    @property
    def summary(self) -> str:
        """Differences besides the ground, as part of a sentence; empty if there are none."""
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
    """Return whether a person is at rest with both feet on the ground."""
    if np.abs(qvel).max() > MAX_STANDING_SPEED:
        return False
    sites = contact_sites(human)
    places = BodyState(human, qpos).position(PointSet.of(human, sites))
    gap = ground.gap(places) - [site.radius for site in sites]
    return all(
        min(g for g, s in zip(gap, sites, strict=True) if s.side == x) < MAX_STANDING_GAP
        for x in "rl"
    )


class _Disturbed(WrappedController):
    """A controller with sensor noise and delay."""

    def __init__(self, controller: Controller, mismatch: ModelMismatch):
        super().__init__(controller)
        self._mismatch = mismatch
        self._waiting: deque[AnyCommand] = deque()

    def __call__(self, state: State) -> AnyCommand:
        world, noise = state.world, self._mismatch.sensors
        if state.time == 0.0:
            self._waiting.clear()
        if noise:
            n = len(state.qvel)
            state.qvel = state.qvel + RATE_NOISE * noise * world.random.standard_normal(n)
            state.qpos = state.qpos.copy()
            state.qpos[7:] += noise * world.random.standard_normal(n - 6)
        self._waiting.append(self.inner(state))
        if len(self._waiting) > round(self._mismatch.delay * world.control_rate):
            return self._waiting.popleft()
        return self._waiting[0]
