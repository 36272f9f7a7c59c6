"""The judge of motions: what is physical passes, every single fault is found and named."""


import mujoco
import numpy as np
import pytest

from plantigrade.analyze.motion_check import (
    ContactSite,
    MotionUnderTest,
    examine,
)
from plantigrade.models import Human

G = 9.81
BALL = """
<mujoco><worldbody><body name="ball_r" pos="0 0 0.1"><freejoint/>
<inertial pos="0 0 0" mass="2" diaginertia="0.008 0.008 0.008"/>
<geom name="contact_ball_r" type="sphere" size="0.1"/></body></worldbody></mujoco>
"""
BOX = """
<mujoco><worldbody><body name="box_r"><freejoint/>
<inertial pos="0 0 0.2" mass="5" diaginertia="0.1 0.1 0.1"/>
<geom name="contact_a_r" type="sphere" size="0.02" pos="0.1 0.1 0"/>
<geom name="contact_b_r" type="sphere" size="0.02" pos="0.1 -0.1 0"/>
<geom name="contact_c_r" type="sphere" size="0.02" pos="-0.1 0.1 0"/>
<geom name="contact_d_r" type="sphere" size="0.02" pos="-0.1 -0.1 0"/>
</body></worldbody></mujoco>
"""


def sites_of(model) -> tuple[ContactSite, ...]:
    """Every contact sphere of a model, as a site of the body it is on."""
    sites = []
    for g in range(model.ngeom):
        geom = model.geom(g)
        if geom.name.startswith("contact_"):
            body = model.body(int(geom.bodyid[0])).name
            name = geom.name.removeprefix("contact_").removeprefix(f"{body[:-2]}_")
            position = tuple(float(x) for x in geom.pos)
            sites.append(ContactSite(name, name[-1], body, position, float(geom.size[0])))
    return tuple(sites)


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


@pytest.fixture(scope="module")
def human() -> Human:
    return Human.create(1.74, 70.0, joints="43")


def free_of_limits(human):
    """The compiled model without contacts, as the laws of motion have it."""
    import copy

    model = copy.deepcopy(human.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


@pytest.fixture(scope="module")
def standing(human) -> MotionUnderTest:
    """A person who stands still on both feet, weight shared, and swings the arms a little."""
    n = 241
    t = np.linspace(0.0, 1.2, n)
    model = human.model
    qpos = np.tile(human.standing(), (n, 1))
    qvel, qacc = np.zeros((n, model.nv)), np.zeros((n, model.nv))
    for name, amplitude, pace in (("arm_flex_r", 0.3, 6.0), ("arm_flex_l", -0.2, 5.0)):
        i = human.hinge(name)
        qpos[:, 7 + i] += amplitude * np.sin(pace * t)
        qvel[:, 6 + i] = amplitude * pace * np.cos(pace * t)
        qacc[:, 6 + i] = -amplitude * pace**2 * np.sin(pace * t)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(model, data)
    sites = sites_of(model)
    low = min(data.geom(f"contact_{s}").xpos[2] for s in ("foot_metatarsal_1_r",))
    low -= model.geom("contact_foot_metatarsal_1_r").size[0]
    qpos[:, 2] -= low
    forces = balancing_forces(free_of_limits(human), sites, qpos, qvel, qacc)
    return MotionUnderTest(
        model, t, qpos, qvel, qacc, sites, forces, np.ones((n, len(sites)), bool)
    )


def test_standing_with_the_weight_shared_is_fine(standing):
    check = examine(standing)
    assert check.ok, check.words()
    assert len(check.words()) == 1
    total = standing.contact_force.sum(axis=1)[:, 2]
    assert abs(total - 70.0 * G).max() < 0.1 * 70.0 * G  # it is indeed a body that stands
