"""Momentum and energy of a body are conserved without external forces."""

import mujoco
import numpy as np
import pytest

from tests.models.presets import PRESETS, person, random_state


@pytest.fixture(params=PRESETS, ids="-".join)
def flying(request):
    """A body in the air in a random state, its joint limits taken away."""
    human = person(*request.param)
    spec = mujoco.MjSpec.from_string(human.xml)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.timestep = 2e-4
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    model = spec.compile()
    data = mujoco.MjData(model)
    low, high = human.limits
    q, v = random_state(human, np.random.default_rng(3))
    q[2] += 50.0
    q[7:] = (low + high) / 2 + 0.2 * (q[7:] - (low + high) / 2)
    data.qpos, data.qvel = q, 0.5 * v
    return model, data


def quantities(model, data):
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    mass = model.body_subtreemass[1]
    return (
        data.energy.sum(),
        mass * data.subtree_linvel[1].copy(),
        data.subtree_angmom[1].copy(),
        data.energy[1],
    )


def test_free_fall(flying):
    """Energy and angular momentum stay; momentum grows with weight times time."""
    model, data = flying
    energy, momentum, spin, kinetic = quantities(model, data)
    steps = 250
    for _ in range(steps):
        mujoco.mj_step(model, data)
    time = steps * model.opt.timestep
    energy_1, momentum_1, spin_1, _ = quantities(model, data)
    assert energy_1 == pytest.approx(energy, abs=1e-4 * kinetic)
    weight = model.body_subtreemass[1] * model.opt.gravity
    np.testing.assert_allclose(momentum_1, momentum + weight * time, atol=1e-5)
    np.testing.assert_allclose(spin_1, spin, atol=1e-4)
