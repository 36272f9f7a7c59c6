"""Simple bodies for the checker: a ball, a box, an arm on a box, each as a Human and a Record."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np

from plantigrade.contact.site import ContactSite
from plantigrade.models import Human
from plantigrade.models.parts import SoleSphere, combine
from plantigrade.models.skeleton import Body, Hinge, Skeleton
from plantigrade.motion import Motion
from plantigrade.record import Record

MOTION = ("time", "qpos", "qvel", "qacc")


@cache
def person(xml: str) -> Human:
    """Return the body of an MJCF text as a Human: one free body with hinges, contact spheres."""
    model = mujoco.MjModel.from_xml_string(xml)
    bodies = []
    for b in range(1, model.nbody):
        name = model.body(b).name
        hinges = [model.joint(j) for j in range(1, model.njnt) if model.jnt_bodyid[j] == b]
        geoms = [model.geom(g) for g in range(model.ngeom) if model.geom_bodyid[g] == b]
        bodies.append(
            Body(
                name,
                "" if b == 1 else model.body(int(model.body_parentid[b])).name,
                model.body_pos[b],
                tuple(Hinge(h.name, h.axis, *h.range, (-1.0, 1.0)) for h in hinges),
                combine(()),
                (),
                tuple(
                    SoleSphere(g.name[len("contact_box_") : -2], g.pos, g.size[0], "box")
                    for g in geoms
                ),
            )
        )
    mass = float(model.body_subtreemass[1])
    real = Human.create(1.7, 70.0)
    return replace(real, mass=mass, skeleton=Skeleton(tuple(bodies), {}, {}), xml=xml)


def sites_of(human: Human) -> tuple[ContactSite, ...]:
    """Return every contact sphere, as a site of the body it is on."""
    sites = []
    for g in range(human.model.ngeom):
        geom = human.model.geom(g)
        if geom.name.startswith("contact_"):
            body = human.model.body(int(geom.bodyid[0])).name
            name = geom.name.removeprefix("contact_").removeprefix(f"{body[:-2]}_")
            sites.append(
                ContactSite(
                    body=body,
                    position=geom.pos,
                    radius=float(geom.size[0]),
                    name=name,
                    side=name[-1],
                )
            )
    return tuple(sites)


def record_of(human: Human, time, qpos, qvel, qacc, sites, force, planned) -> Record:
    """Return a Record of arrays."""
    motion = Motion(time, qpos, qvel, human.joint_names, qacc)
    return Record(human, motion, sites=sites, contact_force=force, contact_planned=planned)


def having(record: Record, **changes) -> Record:
    """Return a Record with other fields, of its motion or its own."""
    moved = {name: changes.pop(name) for name in MOTION if name in changes}
    return replace(record, motion=replace(record.motion, **moved), **changes)


def still(human: Human, qpos, n=61, duration=0.6):
    """Return time, states and sites of a body that does not move."""
    t = np.linspace(0.0, duration, n)
    zero = np.zeros((n, human.model.nv))
    return t, np.tile(np.asarray(qpos, float), (n, 1)), zero, zero.copy(), sites_of(human)
