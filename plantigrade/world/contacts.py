"""What touches the person: forces at the contact spheres of the feet, and on every other body."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.contact.site import GEOM, ContactSite
from plantigrade.models import Human

Wrench = tuple[int, Float[Array, " 3"], Float[Array, " 3"]]
"""Body, force [N] and where it acts [m]."""


@dataclass(frozen=True, eq=False)
class Taken:
    """Contacts of the person with what is outside, in one step, as MuJoCo keeps them.

    Attributes:
        geom: Both geoms.
        frame: Axes of the contact, the normal first, from the first geom to the second.
        place: Where it is, world [m].
        force: Force on the second geom, in these axes [N].
    """

    geom: Int[Array, "n 2"]
    frame: Float[Array, "n 9"]
    place: Float[Array, "n 3"]
    force: Float[Array, "n 3"]


@dataclass(frozen=True, eq=False)
class Touch:
    """Forces from outside in several steps.

    Attributes:
        force: At each contact sphere, world [N].
        point: Where it acts, world [m]; zero where nothing touches.
        others: Of each step, every contact of another part of the person with the ground.
        things: Likewise every contact of any part with something that is no ground.
    """

    force: Float[Array, "n_steps n_sites 3"]
    point: Float[Array, "n_steps n_sites 3"]
    others: list[list[Wrench]]
    things: list[list[Wrench]]


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
        self.thing = np.array([model.body(b).name.startswith("box_") for b in body], bool)
        self.owner = np.where(body <= len(human.body_names), body, 0)
        self._own = self.owner > 0

    def take(self, data: mujoco.MjData) -> tuple[Taken | None, Float[Array, " nv"] | None]:
        """Return the contacts of the last step, and the generalised force of what is inside.

        Inside are stops of joints and contact of the body with itself. Either is None where there
        is nothing.
        """
        taken, rows = None, None
        if data.ncon:
            contact = data.contact
            geom, address = contact.geom, contact.efc_address
            own = self._own[geom]
            which = ((own[:, 0] != own[:, 1]) & (address >= 0)).nonzero()[0]
            if len(which):
                rows = address[which][:, None] + _AXES
                force = data.efc_force[rows]
                taken = Taken(geom[which], contact.frame[which], contact.pos[which], force)
        if data.nefc == (0 if rows is None else rows.size):
            return taken, None
        pushes = data.efc_force.copy()
        if rows is not None:
            pushes[rows.ravel()] = 0.0
        inside = np.zeros(self.model.nv)
        mujoco.mj_mulJacTVec(self.model, data, inside, pushes)
        return taken, inside

    def loads(
        self, data: mujoco.MjData, group: Int[Array, " n_sites"], normal: Float[Array, " 3"]
    ) -> Float[Array, " n_groups"]:
        """Return what groups of spheres carried in the last step, for who asks at every tick [N].

        Args:
            data: The world.
            group: Of each sphere, to which it belongs.
            normal: Direction that counts.
        """
        contact, n = data.contact, int(group.max()) + 1
        site, address = self.site_of[contact.geom], contact.efc_address
        mine = np.maximum(site[:, 0], site[:, 1])
        which = ((mine >= 0) & (address >= 0)).nonzero()[0]
        local = data.efc_force[address[which][:, None] + _AXES]
        push = np.matmul(contact.frame[which].reshape(-1, 3, 3), normal)
        push = (local * push).sum(axis=1)
        push[site[which, 1] < 0] *= -1.0  # the force is that on the second geom
        load = np.bincount(group[mine[which]], push, n)
        return np.asarray(load, dtype=float)  # of no contact: whole numbers

    def forces(self, data: mujoco.MjData) -> Float[Array, "n_sites 3"]:
        """Return the force of the ground at each sphere in the last step [N]."""
        force = np.zeros((self.n_sites, 3))
        if not data.ncon:
            return force
        contact = data.contact
        geom, address = contact.geom, contact.efc_address
        own = self._own[geom]
        second = own[:, 1]
        site = self.site_of[np.where(second, geom[:, 1], geom[:, 0])]
        counts = (own[:, 0] != second) & (site >= 0) & (address >= 0)
        which = (counts & ~self.thing[geom].any(axis=1)).nonzero()[0]
        local = data.efc_force[address[which][:, None] + _AXES]
        each = np.einsum("ki,kij->kj", local, contact.frame[which].reshape(-1, 3, 3))
        each[~second[which]] *= -1.0
        for i in _AXES:
            force[:, i] = np.bincount(site[which], each[:, i], self.n_sites)
        return force

    def read(self, steps: Sequence[Taken | None]) -> Touch:
        """Return the forces of several steps."""
        n, k = len(steps), self.n_sites
        some = [(i, step) for i, step in enumerate(steps) if step is not None]
        others: list[list[Wrench]] = [[] for _ in range(n)]
        things: list[list[Wrench]] = [[] for _ in range(n)]
        if not some:
            return Touch(np.zeros((n, k, 3)), np.zeros((n, k, 3)), others, things)
        when = np.repeat([i for i, _ in some], [len(step.geom) for _, step in some])
        geoms, frame, place, local = (
            np.concatenate([getattr(step, name) for _, step in some])
            for name in ("geom", "frame", "place", "force")
        )
        force = np.einsum("ki,kij->kj", local, frame.reshape(-1, 3, 3))
        second = self._own[geoms[:, 1]]
        force[~second] *= -1.0
        geom = np.where(second, geoms[:, 1], geoms[:, 0])
        thing = np.any(self.thing[geoms], axis=1)
        site, load = self.site_of[geom], np.linalg.norm(force, axis=1)
        at = (site >= 0) & ~thing
        flat = when[at] * k + site[at]

        def summed(values: Float[Array, " m"]) -> Float[Array, "n_steps n_sites"]:
            return np.bincount(flat, values, n * k).astype(float).reshape(n, k)  # no values: whole

        total = summed(load[at])[..., None]
        point = np.stack([summed(load[at] * place[at, i]) for i in range(3)], axis=2)
        for i in np.flatnonzero(~at & (load > 0)):
            found = things if thing[i] else others
            found[when[i]].append((int(self.owner[geom[i]]), force[i], place[i]))
        return Touch(
            np.stack([summed(force[at, i]) for i in range(3)], axis=2),
            np.divide(point, total, out=np.zeros_like(point), where=total > 0),
            others,
            things,
        )


_AXES = np.arange(3)
