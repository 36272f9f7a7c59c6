"""Contacts of the feet as the simulator sees them."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.contact.site import GEOM_PREFIX
from plantigrade.control.gait.phase import FootContactSettings
from plantigrade.wbc.whole_body import Touching
from plantigrade.world import SimulatedWorld, State


@dataclass(frozen=True, kw_only=True)
class GroundContactSettings:
    """Contacts that balance relies on."""

    max_gap: float = FootContactSettings.max_planned_height
    """Distance from the ground up to which a point counts as touching [m]; as in walking."""
    friction_fraction: float = FootContactSettings.friction_fraction
    """Part of the friction of the ground that is relied on; as in walking."""


@dataclass(frozen=True, eq=False)
class FootContacts:
    """Contacts of the feet at one instant."""

    spheres: Int[Array, " k"]  #: Index of the contact sphere of each point that touches
    touching: Touching  #: The points
    gap: Float[Array, " k"]  #: Distance to the ground; negative where it gives way [m]
    ground_velocity: Float[Array, "k 3"]  #: Velocity of the ground there [m/s]

    def at(self, which: Int[Array, " m"] | Bool[Array, " k"]) -> "FootContacts":
        """Return some of the points."""
        t = self.touching
        chosen = Touching(t.body[which], t.place[which], t.normal[which], t.friction)
        return FootContacts(
            self.spheres[which], chosen, self.gap[which], self.ground_velocity[which]
        )


class GroundContact:
    """Reads the contacts of the feet of one world.

    The simulator reports contacts within :attr:`GroundContactSettings.max_gap`, where there is no
    force yet.
    """

    def __init__(self, world: SimulatedWorld, settings: GroundContactSettings):
        self.world, self.model = world, world.model
        self.friction = settings.friction_fraction * world.ground.friction
        names = [GEOM_PREFIX + site.name for site in world.sites if site.side]
        self.geoms = np.array([self.model.geom(name).id for name in names], dtype=int)
        self.body = np.array(self.model.geom_bodyid)[self.geoms]
        self._site = np.full(self.model.ngeom, -1)
        self._site[self.geoms] = np.arange(len(names))
        self._owner = np.array(self.model.geom_bodyid)
        self._outside = (self._owner == 0) | (self._owner > len(world.human.body_names))
        self.model.geom_gap[self.geoms] = settings.max_gap
        mujoco.mj_collision(self.model, world.data)  # at the first tick already

    def read(self) -> FootContacts:
        """Return what touches now: of every sphere its deepest contact with the ground."""
        contact = self.world.data.contact
        geom = contact.geom
        # The foot may be the first geom of a contact or the second.
        which, second = ((self._site[geom] >= 0) & self._outside[geom[:, ::-1]]).nonzero()
        order = np.argsort(-contact.dist[which])
        which, second = which[order], second[order]
        deepest = np.full(len(self.geoms), -1)
        deepest[self._site[geom[which, second]]] = np.arange(len(which))
        own = (deepest >= 0).nonzero()[0]
        which, second = which[deepest[own]], second[deepest[own]]
        normal = (2.0 * second[:, None] - 1.0) * contact.frame[which, :3]
        position = contact.pos[which]
        touching = Touching(self.body[own], position, normal, self.friction)
        velocity = self._velocity(self._owner[geom[which, 1 - second]], position)
        return FootContacts(own, touching, contact.dist[which], velocity)

    def _velocity(self, body: Array, position: Array) -> Array:
        """Return the velocity of bodies at positions."""
        velocity, spatial = np.zeros((len(body), 3)), np.zeros(6)
        if not body.any():
            return velocity
        kind = mujoco.mjtObj.mjOBJ_XBODY
        for b in set(body[body > 0].tolist()):
            own = body == b
            mujoco.mj_objectVelocity(self.model, self.world.data, kind, b, spatial, 0)
            arm = position[own] - self.world.data.xpos[b]
            velocity[own] = spatial[3:] + np.cross(spatial[:3], arm)
        return velocity


def sphere_heights(state: State, contact: GroundContact) -> tuple[Array, Array]:
    """Return the heights of the spheres of the feet above the ground, and its normals there."""
    ground = state.world.ground
    centre = np.array(state.world.data.geom_xpos)[contact.geoms]
    normal = ground.normal_at(centre)
    low = centre - np.array(contact.model.geom_size)[contact.geoms, :1] * normal
    rise = ground.gap(low)
    return rise * (normal @ ground.normal), normal
