"""A person who stands still on both feet, weight shared, and swings the arms a little."""

import copy
from functools import cache

import mujoco
import numpy as np

from plantigrade.models import Human
from plantigrade.record import Record
from tests.analyze.bodies import having, record_of, sites_of


@cache
def standing_record() -> Record:
    """Return 1.2 s of standing, with forces and torques."""
    from plantigrade import check

    human = Human.create(1.74, 70.0, joints="43")
    n = 241
    t = np.linspace(0.0, 1.2, n)
    model = human.model
    qpos = np.tile(human.standing(), (n, 1))
    for side in "rl":  # legs that lean, so that the weight is 4 cm before the ankles as in people
        qpos[:, 7 + human.hinge(f"hip_flexion_{side}")] = -0.055
        qpos[:, 7 + human.hinge(f"ankle_angle_{side}")] = 0.055
    qvel, qacc = np.zeros((n, model.nv)), np.zeros((n, model.nv))
    for name, amplitude, pace in (("arm_flex_r", 0.3, 6.0), ("arm_flex_l", -0.2, 5.0)):
        i = human.hinge(name)
        qpos[:, 7 + i] += amplitude * np.sin(pace * t)
        qvel[:, 6 + i] = amplitude * pace * np.cos(pace * t)
        qacc[:, 6 + i] = -amplitude * pace**2 * np.sin(pace * t)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(model, data)
    sites = sites_of(human)
    low = data.geom("contact_foot_metatarsal_1_r").xpos[2]
    qpos[:, 2] -= low - model.geom("contact_foot_metatarsal_1_r").size[0]
    forces = balancing_forces(free_of_limits(human), sites, qpos, qvel, qacc)
    stands = np.ones((n, len(sites)), bool)
    record = record_of(human, t, qpos, qvel, qacc, sites, forces, stands)
    verdict = check(record)
    return having(record, qfrc_actuator=verdict.tau, contact_point=verdict.contact_point)


def free_of_limits(human: Human) -> mujoco.MjModel:
    """Return the compiled model without contacts, as the laws of motion have it."""
    model = copy.deepcopy(human.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


def balancing_forces(model, sites, qpos, qvel, qacc, sideways=0.2):
    """Least forces at the sites that explain the root of a motion, found with MuJoCo's mj_jac.

    ``sideways``: how readily the ground pushes along itself.
    """
    data = mujoco.MjData(model)
    n, k = len(qpos), len(sites)
    forces = np.empty((n, k, 3))
    W = np.tile([sideways**2, sideways**2, 1.0], k)
    for f in range(n):
        data.qpos[:], data.qvel[:], data.qacc[:] = qpos[f], qvel[f], qacc[f]
        mujoco.mj_inverse(model, data)
        A = np.empty((6, 3 * k))
        for i, site in enumerate(sites):
            b = model.body(site.body).id
            point = data.xpos[b] + data.xmat[b].reshape(3, 3) @ site.position
            point[2] -= site.radius
            J = np.zeros((3, model.nv))
            mujoco.mj_jac(model, data, J, None, point, b)
            A[:, 3 * i : 3 * i + 3] = J[:, :6].T
        forces[f] = (W * (A.T @ np.linalg.solve((A * W) @ A.T, data.qfrc_inverse[:6])).T).reshape(
            k, 3
        )
    return forces
