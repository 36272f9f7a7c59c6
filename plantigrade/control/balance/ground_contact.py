"""Which points of the feet touch, and how near the others are: as the simulator sees them."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.contact.site import GEOM
from plantigrade.wbc.whole_body import Touching
from plantigrade.world import State, World

NEAR = 0.004
"""A point this near the ground is taken to touch [m]."""


@dataclass(frozen=True, eq=False)
class Standing:
    """What the feet touch at one instant.

    Attributes:
        site: Index of the contact sphere of each point that touches.
        touching: The points.
        gap: Distance to the ground; negative where it gives way [m].
        drift: Velocity of the ground there [m/s].
    """

    site: Int[Array, " k"]
    touching: Touching
    gap: Float[Array, " k"]
    drift: Float[Array, "k 3"]

    def at(self, which: Int[Array, " m"] | Bool[Array, " k"]) -> "Standing":
        """Return some of the points."""
        t = self.touching
        chosen = Touching(t.body[which], t.place[which], t.normal[which], t.friction)
        return Standing(self.site[which], chosen, self.gap[which], self.drift[which])


class GroundContact:
    """Reads the contacts of the feet of one world.

    Contacts are asked for from :data:`NEAR` on, where there is no force yet.

    Args:
        world: The world.
        friction: Part of its friction that is counted on.
    """

    def __init__(self, world: World, friction: float = 1.0):
        self.world, self.model = world, world.model
        self.friction = friction * world.ground.friction
        names = [GEOM + site.name for site in world.sites if site.side]
        self.geoms = np.array([self.model.geom(name).id for name in names], dtype=int)
        self.body = np.array(self.model.geom_bodyid)[self.geoms]
        self._site = np.full(self.model.ngeom, -1)
        self._site[self.geoms] = np.arange(len(names))
        self._owner = np.array(self.model.geom_bodyid)
        self._outside = (self._owner == 0) | (self._owner > len(world.human.body_names))
        self.model.geom_gap[self.geoms] = NEAR
        mujoco.mj_collision(self.model, world.data)  # those near it, at the first tick already

    def read(self) -> Standing:
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
        place = contact.pos[which]
        touching = Touching(self.body[own], place, normal, self.friction)
        under = self._owner[geom[which, 1 - second]]
        return Standing(own, touching, contact.dist[which], self._drift(under, place))

    def _drift(self, body: Array, place: Array) -> Array:
        """Return the velocity of bodies at places."""
        drift, velocity = np.zeros((len(body), 3)), np.zeros(6)
        if not body.any():
            return drift
        kind = mujoco.mjtObj.mjOBJ_XBODY
        for b in set(body[body > 0].tolist()):
            mine = body == b
            mujoco.mj_objectVelocity(self.model, self.world.data, kind, b, velocity, 0)
            arm = place[mine] - self.world.data.xpos[b]
            drift[mine] = velocity[3:] + np.cross(velocity[:3], arm)
        return drift


def heights(state: State, contact: GroundContact) -> tuple[Array, Array]:
    """Return how far the spheres of the feet are above the ground, and its normals there."""
    ground = state.world.ground
    centre = np.array(state.world.data.geom_xpos)[contact.geoms]
    normal = ground.normal_at(centre)
    low = centre - np.array(contact.model.geom_size)[contact.geoms, :1] * normal
    rise = low @ ground.normal - ground.under(low)
    return rise * (normal @ ground.normal), normal
