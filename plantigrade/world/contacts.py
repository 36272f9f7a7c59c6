"""What touches the person: forces at the contact spheres of the feet, and on every other body."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.contact.site import GEOM, ContactSite
from plantigrade.models import Human

Wrench = tuple[int, Float[Array, " 3"], Float[Array, " 3"]]
"""Body, force [N] and where it acts [m]."""


@dataclass(frozen=True, eq=False)
class Touch:
    """Forces from outside in one step.

    Attributes:
        force: At each contact sphere, world [N].
        point: Where it acts, world [m]; zero where nothing touches.
        others: (body, force, point) of every contact of another part of the person with the
            ground.
        things: Likewise of every contact of any part with something that is no ground.
        internal: Generalised force of what is no force from outside: stops of joints, contact of
            the body with itself.
    """

    force: Float[Array, "n_sites 3"]
    point: Float[Array, "n_sites 3"]
    others: tuple[Wrench, ...]
    things: tuple[Wrench, ...]
    internal: Float[Array, " nv"]


class Contacts:
    """Reads MuJoCo's contacts of a person.

    Args:
        human: The person.
        model: The model of the world.
        sites: Its contact spheres.
    """

    def __init__(self, human: Human, model: mujoco.MjModel, sites: tuple[ContactSite, ...]):
        self.model, self.n_sites = model, len(sites)
        self.site_of = np.full(model.ngeom, -1)
        for i, site in enumerate(sites):
            self.site_of[model.geom(GEOM + site.name).id] = i
        body = np.array(model.geom_bodyid)
        self.thing = np.array(
            [model.body(b).name.startswith("box_") for b in model.geom_bodyid], bool
        )
        self.owner = np.where((body >= 1) & (body <= len(human.body_names)), body, 0)

    def read(self, data: mujoco.MjData, *, internal: bool = True) -> Touch:
        """Return the forces of the last step.

        Args:
            data: The world.
            internal: Whether the generalised force of what is inside is asked for.
        """
        force, point = np.zeros((self.n_sites, 3)), np.zeros((self.n_sites, 3))
        others: tuple[list[Wrench], list[Wrench]] = ([], [])
        outside: Int[Array, " k"] = np.zeros(0, int)
        if data.ncon:
            contact = data.contact
            geoms = np.array(contact.geom)
            address = np.array(contact.efc_address)
            owner = self.owner[geoms]
            mine = (address >= 0) & ((owner[:, 0] > 0) != (owner[:, 1] > 0))
            which = np.flatnonzero(mine)
            address = address[which]
            rows = address[:, None] + np.arange(3)
            local = data.efc_force[rows]
            world = np.einsum("ki,kij->kj", local, np.array(contact.frame)[which].reshape(-1, 3, 3))
            second = owner[which, 1] > 0  # the frame points from the first geom to the second
            world[~second] *= -1.0
            geom = np.where(second, geoms[which, 1], geoms[which, 0])
            thing = np.any(self.thing[geoms[which]], axis=1)
            places, site = np.array(contact.pos)[which], self.site_of[geom]
            at = (site >= 0) & ~thing
            np.add.at(force, site[at], world[at])
            load = np.linalg.norm(world, axis=1)
            np.add.at(point, site[at], load[at, None] * places[at])
            total = np.bincount(site[at], load[at], self.n_sites)[:, None]
            point = np.divide(point, total, out=np.zeros_like(point), where=total > 0)
            for i in np.flatnonzero(~at & (load > 0)):
                others[int(thing[i])].append((int(self.owner[geom[i]]), world[i], places[i]))
            outside = rows.ravel()
        inside = np.zeros(self.model.nv)
        if internal and data.nefc:
            pushes = data.efc_force.copy()
            pushes[outside] = 0.0
            if pushes.any():
                mujoco.mj_mulJacTVec(self.model, data, inside, pushes)
        return Touch(force, point, tuple(others[0]), tuple(others[1]), inside)
