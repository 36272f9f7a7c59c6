"""External contact forces of a person, at the contact spheres of the feet and on other bodies."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.contact.site import GEOM_PREFIX, ContactSite
from plantigrade.models import Human

Wrench = tuple[int, Float[Array, " 3"], Float[Array, " 3"]]
"""Body index, force [N] and point of application [m]."""


@dataclass(frozen=True, eq=False)
class StepContacts:
    """External contacts of the person in one step, in MuJoCo's form."""

    geom: Int[Array, "n 2"]  #: Indices of both geoms
    frame: Float[Array, "n 9"]  #: Contact axes, the normal first, from the first geom to the second
    position: Float[Array, "n 3"]  #: Contact point, world [m]
    force: Float[Array, "n 3"]  #: Force on the second geom, in contact axes [N]


@dataclass(frozen=True, eq=False)
class ExternalForces:
    """External forces in several steps."""

    force: Float[Array, "n_steps n_sites 3"]  #: Force at each contact sphere, world [N]
    #: Point of application, world [m]; zero without contact
    point: Float[Array, "n_steps n_sites 3"]
    others: list[list[Wrench]]  #: Contacts of other body parts with the ground, in each step
    objects: list[list[Wrench]]  #: Contacts of any body part with scene objects, in each step


class Contacts:
    """Reads the contact forces of a person from MuJoCo."""

    def __init__(self, human: Human, model: mujoco.MjModel, sites: tuple[ContactSite, ...]):
        self.model, self.n_sites = model, len(sites)
        self.site_of = np.full(model.ngeom, -1)
        for i, site in enumerate(sites):
            self.site_of[model.geom(GEOM_PREFIX + site.name).id] = i
        body = np.array(model.geom_bodyid)
        self.is_object = np.array([model.body(b).name.startswith("box_") for b in body], bool)
        self.body_of = np.where(body <= len(human.body_names), body, 0)
        self._own = self.body_of > 0

    def read_step(
        self, data: mujoco.MjData
    ) -> tuple[StepContacts | None, Float[Array, " nv"] | None]:
        """Return the external contacts of the last step and the internal constraint force.

        Internal constraints are joint stops and contacts of the body with itself. Each is None if
        there is none.
        """
        step_contacts, rows = None, None
        if data.ncon:
            contact = data.contact
            geom, address = contact.geom, contact.efc_address
            own = self._own[geom]
            which = ((own[:, 0] != own[:, 1]) & (address >= 0)).nonzero()[0]
            if len(which):
                rows = address[which][:, None] + _AXES
                force = data.efc_force[rows]
                step_contacts = StepContacts(
                    geom[which], contact.frame[which], contact.pos[which], force
                )
        if data.nefc == (0 if rows is None else rows.size):
            return step_contacts, None
        pushes = data.efc_force.copy()
        if rows is not None:
            pushes[rows.ravel()] = 0.0
        constraint = np.zeros(self.model.nv)
        mujoco.mj_mulJacTVec(self.model, data, constraint, pushes)
        return step_contacts, constraint

    def group_loads(
        self, data: mujoco.MjData, group: Int[Array, " n_sites"], normal: Float[Array, " 3"]
    ) -> Float[Array, " n_groups"]:
        """Return the load on groups of spheres in the last step, fast enough for every tick [N]."""
        contact, n = data.contact, int(group.max()) + 1
        site, address = self.site_of[contact.geom], contact.efc_address
        own_site = np.maximum(site[:, 0], site[:, 1])
        which = ((own_site >= 0) & (address >= 0)).nonzero()[0]
        local = data.efc_force[address[which][:, None] + _AXES]
        push = np.matmul(contact.frame[which].reshape(-1, 3, 3), normal)
        push = (local * push).sum(axis=1)
        push[site[which, 1] < 0] *= -1.0  # MuJoCo gives the force on the second geom
        load = np.bincount(group[own_site[which]], push, n)
        return np.asarray(load, dtype=float)  # without contacts bincount returns integers

    def forces(self, data: mujoco.MjData) -> Float[Array, "n_sites 3"]:
        """Return the ground reaction force at each sphere in the last step [N]."""
        force = np.zeros((self.n_sites, 3))
        if not data.ncon:
            return force
        contact = data.contact
        geom, address = contact.geom, contact.efc_address
        own = self._own[geom]
        second = own[:, 1]
        site = self.site_of[np.where(second, geom[:, 1], geom[:, 0])]
        counts = (own[:, 0] != second) & (site >= 0) & (address >= 0)
        which = (counts & ~self.is_object[geom].any(axis=1)).nonzero()[0]
        local = data.efc_force[address[which][:, None] + _AXES]
        each = np.einsum("ki,kij->kj", local, contact.frame[which].reshape(-1, 3, 3))
        each[~second[which]] *= -1.0
        for i in _AXES:
            force[:, i] = np.bincount(site[which], each[:, i], self.n_sites)
        return force

    def external_forces(self, steps: Sequence[StepContacts | None]) -> ExternalForces:
        """Return the external forces in several steps."""
        n, k = len(steps), self.n_sites
        some = [(i, step) for i, step in enumerate(steps) if step is not None]
        others: list[list[Wrench]] = [[] for _ in range(n)]
        objects: list[list[Wrench]] = [[] for _ in range(n)]
        if not some:
            return ExternalForces(np.zeros((n, k, 3)), np.zeros((n, k, 3)), others, objects)
        when = np.repeat([i for i, _ in some], [len(step.geom) for _, step in some])
        geoms, frame, position, local = (
            np.concatenate([getattr(step, name) for _, step in some])
            for name in ("geom", "frame", "position", "force")
        )
        force = np.einsum("ki,kij->kj", local, frame.reshape(-1, 3, 3))
        second = self._own[geoms[:, 1]]
        force[~second] *= -1.0
        geom = np.where(second, geoms[:, 1], geoms[:, 0])
        is_object = np.any(self.is_object[geoms], axis=1)
        site, load = self.site_of[geom], np.linalg.norm(force, axis=1)
        at = (site >= 0) & ~is_object
        flat = when[at] * k + site[at]

        def summed(values: Float[Array, " m"]) -> Float[Array, "n_steps n_sites"]:
            return (
                np.bincount(flat, values, n * k).astype(float).reshape(n, k)
            )  # empty input: integers

        total = summed(load[at])[..., None]
        point = np.stack([summed(load[at] * position[at, i]) for i in range(3)], axis=2)
        for i in np.flatnonzero(~at & (load > 0)):
            found = objects if is_object[i] else others
            found[when[i]].append((int(self.body_of[geom[i]]), force[i], position[i]))
        return ExternalForces(
            np.stack([summed(force[at, i]) for i in range(3)], axis=2),
            np.divide(point, total, out=np.zeros_like(point), where=total > 0),
            others,
            objects,
        )


_AXES = np.arange(3)
