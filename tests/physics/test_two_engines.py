"""MuJoCo and Pinocchio read the same MJCF file and must find the same mechanics in it."""

import mujoco
import numpy as np
import pytest

from plantigrade.spatial.conventions import rotation_matrix
from tests.models.presets import PRESETS, person, random_state
from tests.spatial.pinocchio_state import (
    configuration_to_pinocchio,
    free_joint_velocity_to_pinocchio,
)

pin = pytest.importorskip("pinocchio")


class BothEngines:
    """One MJCF file in both engines, and the way from MuJoCo's order to Pinocchio's."""

    def __init__(self, path):
        self.m = mujoco.MjModel.from_xml_path(str(path))
        self.d = mujoco.MjData(self.m)
        self.pm = pin.buildModelFromMJCF(str(path))
        self.pd = self.pm.createData()
        self.order = self._order()

    def _order(self):
        """Pinocchio's velocity index of each MuJoCo velocity; Pinocchio names a joint of several
        hinges after the first of them."""
        m, order = self.m, list(range(6))
        for body in range(2, m.nbody):
            first = m.body_jntadr[body]
            count = m.body_jntnum[body]
            name = m.joint(first).name
            joint = self.pm.getJointId(name if count == 1 else f"Composite_{name}")
            assert joint < self.pm.njoints, name
            assert self.pm.nvs[joint] == count
            order.extend(self.pm.idx_vs[joint] + k for k in range(count))
        return np.array(order)

    def set(self, q, v):
        """Put both engines in one state; return Pinocchio's configuration and velocity."""
        self.d.qpos, self.d.qvel = q, v
        mujoco.mj_forward(self.m, self.d)
        qp, vp = np.empty(self.pm.nq), np.empty(self.pm.nv)
        qp[:7] = configuration_to_pinocchio(q)[:7]
        qp[self.order[6:] + 1] = q[7:]
        vp[self.order] = free_joint_velocity_to_pinocchio(q, v)
        # d(vp)/d(v), which is also how forces go back
        self.T = np.zeros((self.m.nv, self.m.nv))
        self.T[self.order, np.arange(self.m.nv)] = 1.0
        self.T[:3, :3] = rotation_matrix(q[3:7]).T
        return qp, vp


def close(ours, theirs, scale=None):
    """Agreement to 1e-9 of the largest entry."""
    scale = np.abs(theirs).max() if scale is None else scale
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * scale)


@pytest.fixture(scope="module", params=PRESETS, ids="-".join)
def both(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("mjcf") / "model.xml"
    path.write_text(person(*request.param).xml)
    return BothEngines(path), person(*request.param)


@pytest.fixture(params=range(3))
def state(request, both):
    engines, human = both
    q, v = random_state(human, np.random.default_rng(request.param))
    return engines, q, v, *engines.set(q, v)


def test_sizes_masses_and_limits_are_the_same(both):
    engines, human = both
    m, pm = engines.m, engines.pm
    assert (m.nq, m.nv) == (pm.nq, pm.nv) == (human.model.nq, human.model.nv)
    total = sum(inertia.mass for inertia in pm.inertias)
    assert total == pytest.approx(human.mass, rel=1e-12)
    hinges = engines.order[6:]
    close(m.jnt_range[1:, 0], pm.lowerPositionLimit[hinges + 1])
    close(m.jnt_range[1:, 1], pm.upperPositionLimit[hinges + 1])
    np.testing.assert_allclose(engines.pm.gravity.linear, m.opt.gravity)


def test_mass_matrix(state):
    engines, q, v, qp, vp = state
    M = np.zeros((engines.m.nv, engines.m.nv))
    mujoco.mj_fullM(engines.m, engines.d, M)
    upper = np.triu(pin.crba(engines.pm, engines.pd, qp))
    Mp = upper + np.triu(upper, 1).T
    close(M, engines.T.T @ Mp @ engines.T)


def test_inverse_dynamics_of_any_acceleration(state):
    """M a + bias: the acceleration of the root differs by the turning of its axes."""
    engines, q, v, qp, vp = state
    a = np.random.default_rng(7).normal(size=engines.m.nv)
    engines.d.qacc = a
    tau = np.zeros(engines.m.nv)
    mujoco.mj_rne(engines.m, engines.d, 1, tau)
    ap = engines.T @ a
    ap[:3] -= np.cross(v[3:6], vp[:3])  # d/dt (R^T v) = R^T (dv/dt) - omega x (R^T v)
    close(tau, engines.T.T @ pin.rnea(engines.pm, engines.pd, qp, vp, ap))


def test_bias_forces(state):
    engines, q, v, qp, vp = state
    a0 = np.zeros(engines.m.nv)
    a0[:3] = -np.cross(v[3:6], vp[:3])
    theirs = engines.T.T @ pin.rnea(engines.pm, engines.pd, qp, vp, a0)
    close(engines.d.qfrc_bias, theirs)


def test_positions_and_jacobians_of_every_body(state):
    engines, q, v, qp, vp = state
    m, d = engines.m, engines.d
    pin.computeJointJacobians(engines.pm, engines.pd, qp)
    pin.updateFramePlacements(engines.pm, engines.pd)
    for body in range(1, m.nbody):
        frame = engines.pm.getFrameId(m.body(body).name, pin.FrameType.BODY)
        assert frame < engines.pm.nframes, m.body(body).name
        placement = engines.pd.oMf[frame]
        close(d.xpos[body], placement.translation, scale=1.0)
        close(d.xmat[body].reshape(3, 3), placement.rotation, scale=1.0)
        linear, angular = np.zeros((3, m.nv)), np.zeros((3, m.nv))
        mujoco.mj_jacBody(m, d, linear, angular, body)
        theirs = pin.getFrameJacobian(
            engines.pm, engines.pd, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        close(np.vstack([linear, angular]), theirs @ engines.T, scale=1.0)


def test_centre_of_mass_and_centroidal_momentum(state):
    engines, q, v, qp, vp = state
    m, d = engines.m, engines.d
    mujoco.mj_subtreeVel(m, d)
    pin.ccrba(engines.pm, engines.pd, qp, vp)
    mass = m.body_subtreemass[1]
    close(d.subtree_com[1], engines.pd.com[0], scale=1.0)
    close(mass * d.subtree_linvel[1], engines.pd.hg.linear)
    close(d.subtree_angmom[1], engines.pd.hg.angular)


def test_kinetic_and_potential_energy(state):
    engines, q, v, qp, vp = state
    m, d = engines.m, engines.d
    mujoco.mj_energyPos(m, d)
    mujoco.mj_energyVel(m, d)
    theirs = (
        pin.computePotentialEnergy(engines.pm, engines.pd, qp),
        pin.computeKineticEnergy(engines.pm, engines.pd, qp, vp),
    )
    np.testing.assert_allclose(d.energy, theirs, rtol=1e-9)
