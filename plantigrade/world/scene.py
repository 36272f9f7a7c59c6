"""The model of a world: the person of a scene, made ready to be moved by commands.

To :func:`~plantigrade.contact.scene.scene_xml`, whose model anyone can load, it adds what a world
needs and an exported person does not: actuators whose gains commands set, trunk and limbs that the
ground stops, and the bodies of disturbances.
"""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from plantigrade.contact.ground import Ground
from plantigrade.contact.scene import scene_xml
from plantigrade.contact.site import ContactSite
from plantigrade.models import Human

LIMBS = 4
"""Bit of ``contype`` by which all but the feet touch the ground."""
GROUND = ("floor", "bump", "relief")
"""What the names of the ground's geoms begin with; a seat carries only what is to rest on it."""
FOOT = ("foot", "toes", "heel", "medial_phalanges", "lateral_metatarsal", "lateral_phalanges")


def world_model(
    human: Human,
    ground: Ground,
    *,
    step: float,
    sites: Sequence[ContactSite] = (),
    additions: Sequence[Callable[[mujoco.MjSpec], None]] = (),
) -> mujoco.MjModel:
    """Return the model of a person on a ground.

    The person's coordinates come first; what ``additions`` bring comes after them.

    Args:
        human: The person.
        ground: What they stand on.
        step: Length of a step [s].
        sites: Further places by which a seat carries them.
        additions: What adds bodies, each to the specification it is given.
    """
    spec = mujoco.MjSpec.from_string(scene_xml(human, ground, sites))
    for geom in spec.geoms:
        if geom.name.startswith(GROUND) and geom.conaffinity:
            geom.conaffinity |= LIMBS
        elif geom.name.startswith("core_"):
            if not geom.parent.name.startswith(FOOT):
                geom.contype |= LIMBS
    for add in additions:
        add(spec)
    if additions:
        for key in list(spec.keys):  # has too few coordinates now
            spec.delete(key)
    model = spec.compile()
    own = human.model.nv
    if model.nv > own:  # what is heavy must not set the scale of the solver's tolerance
        model.stat.meaninertia = float(np.mean(model.dof_M0[:own]))
    model.opt.timestep = step
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    # For who walks a quarter faster than dense, for who stands on 14 spheres up to a tenth slower.
    # (4.0.0 is wrong where Jacobians are sparse; the package does not install it.)
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    # Damping is made implicit by armature, with contacts solved in the same metric.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    # A world that diverges stops; MuJoCo would start it anew.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # A person is one piece: looking for islands of contact costs a tenth and finds none.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    nu = model.nu
    model.actuator_biastype[:nu] = mujoco.mjtBias.mjBIAS_AFFINE
    model.actuator_ctrllimited[:nu] = 0
    model.actuator_forcelimited[:nu] = 1
    model.actuator_forcerange[:nu] = np.array(human.model.jnt_actfrcrange[1:])
    model.jnt_actfrclimited[:] = 0  # said once, by the actuators
    return model
