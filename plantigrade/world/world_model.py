"""The MuJoCo model of a world: a person with actuators on a ground.

It extends :func:`~plantigrade.contact.scene.scene_xml`, the exported model, by actuators with
variable gains, by contact of trunk and limbs with the ground, and by the bodies of disturbances.
"""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from plantigrade.contact.ground import Ground
from plantigrade.contact.scene import scene_xml
from plantigrade.contact.site import ContactSite
from plantigrade.contact.sole import SoleSettings, soften, soften_soles
from plantigrade.models import Human
from plantigrade.models.mjcf import read_mjcf

LIMB_BIT = 4  # Bit of ``contype`` for contact of the ground with all bodies except the feet
GROUND_PREFIXES = ("floor", "bump", "relief")
"""Prefixes of the ground's geoms; a seat supports the seat sites only."""
FOOT_PREFIXES = (
    "foot",
    "toes",
    "heel",
    "medial_phalanges",
    "lateral_metatarsal",
    "lateral_phalanges",
)


def world_model(
    human: Human,
    ground: Ground,
    *,
    step: float,
    sites: Sequence[ContactSite] = (),
    additions: Sequence[Callable[[mujoco.MjSpec], None]] = (),
) -> mujoco.MjModel:
    """Return the MuJoCo model of a person on a ground.

    The person's coordinates come first, those of ``additions`` after them.

    Args:
        step: Time step [s].
        additions: Functions that add bodies to a specification.
    """
    spec = read_mjcf(mujoco.MjSpec.from_string, scene_xml(human, ground, sites))
    for geom in spec.geoms:
        if geom.name.startswith(GROUND_PREFIXES) and geom.conaffinity:
            geom.conaffinity |= LIMB_BIT
        elif geom.name.startswith("core_"):
            if not geom.parent.name.startswith(FOOT_PREFIXES):
                geom.contype |= LIMB_BIT
    for add in additions:
        add(spec)
    if additions:
        for key in list(spec.keys):  # keyframes no longer fit the number of coordinates
            spec.delete(key)
    model = spec.compile()
    own = human.model.nv
    if model.nv > own:  # heavy bodies must not scale the solver's tolerance
        model.stat.meaninertia = float(np.mean(model.dof_M0[:own]))
    model.opt.timestep = step
    sole = SoleSettings()
    soften_soles(model, human, sole)
    for seat in ground.seats:
        if seat.stiffness is not None:
            soften(model, seat.site, seat.stiffness, sole.damping_time)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    # Sparse Jacobians are 25 % faster than dense ones in walking and up to 10 % slower in standing
    # on 14 spheres. (MuJoCo 4.0.0 has a bug with sparse Jacobians; the package excludes it.)
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    # Armature makes damping implicit; contacts are solved with the same mass matrix.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    # A diverged world stops; MuJoCo would reset it.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # A person is a single constraint island; the search for islands would cost 10 %.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    nu = model.nu
    model.actuator_biastype[:nu] = mujoco.mjtBias.mjBIAS_AFFINE
    model.actuator_ctrllimited[:nu] = 0
    model.actuator_forcelimited[:nu] = 1
    model.actuator_forcerange[:nu] = np.array(human.model.jnt_actfrcrange[1:])
    model.jnt_actfrclimited[:] = 0  # the actuators limit the torques
    return model
