"""Reduced equations agree with MuJoCo; the integration conserves energy and converges."""

import subprocess
import sys
from importlib.util import find_spec

import mujoco
import numpy as np
import pytest

from plantigrade.dynamics.centroid import without_constraints
from plantigrade.vaulting import VaultResult
from plantigrade.vaulting.compiled_steps import Stepper
from plantigrade.vaulting.segments import COORDINATES


def test_inverse_dynamics_of_the_whole_body_recovers_torques_and_forces(vault):
    human = vault.segments.human
    mass = sum(link.mass for link in vault.segments.tree().links)
    assert mass == pytest.approx(human.mass, rel=1e-12)
    model = without_constraints(human)
    data = mujoco.MjData(model)
    state = vault.equations.function("acceleration", "torque", "stop", "extras")
    rng = np.random.default_rng(1)
    touched = 0
    for _ in range(5):
        theta = vault.start[:8] + rng.normal(scale=0.1, size=8)
        rate, activation = rng.normal(scale=3.0, size=8), rng.uniform(-1, 1, 5)
        found = state(theta, rate, activation)
        a, muscle, stop, extras = (x.full().ravel() for x in found)
        q, v, acc = vault.segments.whole(theta[None], rate[None], a[None])
        data.qpos[:], data.qvel[:], data.qacc[:] = q[0], v[0], acc[0]
        mujoco.mj_inverse(model, data)
        left = data.qfrc_inverse.copy()
        for site in vault.segments.sites():
            body, pushed = human.body(site.body), np.zeros(model.nv)
            place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array(site.position)
            height = vault.table.table_height
            assert place[[0, 2]] == pytest.approx([extras[4], height + extras[5]], abs=1e-12)
            force = np.array([extras[0], 0.0, extras[1]]) / 2
            mujoco.mj_applyFT(model, data, force, np.zeros(3), place, body, pushed)
            left -= pushed
        touched += extras[1] > 0
        assert np.abs(left[:6]).max() < 1e-10 * human.mass * 9.81
        for i, name in enumerate(COORDINATES):
            for side in "rl":
                torque = 2 * left[6 + human.hinge(f"{name}_{side}")]
                assert torque == pytest.approx(muscle[i] + stop[i], abs=1e-8)
    assert touched


def test_energy_is_balanced_and_steps_converge(vault, nodes):
    rises, errors = [], []
    for step in (5e-4, 2e-4, 1e-4):
        fine = vault.with_step(step)
        vaulted = VaultResult(fine, fine.contact(nodes))
        rises.append(vaulted.contact.rise)
        errors.append(vaulted.energy_error)
    assert errors[-1] < 1e-6 and errors[-1] < errors[0] / 20
    assert abs(rises[2] - rises[1]) < 1e-5


def test_without_contact_only_weight_changes_the_linear_momentum(vault, nodes):
    start = vault.start.copy()
    start[1] += 1.0
    u = vault.activation(nodes)[:101]
    y, e = vault.stepper(start, u, vault.step, min_steps=100)
    fall = np.diff(e[[0, 50], 3])[0]
    assert fall == pytest.approx(-9.81 * 50 * vault.step, rel=1e-5)
    assert np.ptp(e[:99, 2]) < 1e-4 and not e[:99, :2].any()
    assert np.abs(y[-1, 3:8] - y[0, 3:8]).max() > 0.05


def test_machine_code_agrees_with_casadi(vault, nodes):
    slow = Stepper(vault.equations.step, end_index=1)
    if not slow.compiled:
        pytest.skip("LLVM is not installed")
    slow.compiled = False
    u = vault.activation(nodes)[:30]
    for ours, theirs in zip(
        vault.stepper(vault.start, u, 1e-3), slow(vault.start, u, 1e-3), strict=True
    ):
        assert ours.shape == theirs.shape
        assert np.allclose(ours[:-1], theirs[:-1], rtol=1e-9, atol=1e-9)


def test_machine_code_is_made_where_a_process_has_mapped_much():
    """PyTorch maps so much memory that LLVM's own manager puts code out of reach of constants."""
    if not find_spec("torch"):
        pytest.skip("PyTorch is not installed")
    lines = (
        "import torch, numpy as np",
        "from plantigrade.models import Human",
        "from plantigrade.vaulting import Approach, Segments, VaultingTable, Vault",
        "human = Human.create(1.66, 63.0, 'male', '42', 'rigid')",
        "vault = Vault(Segments(human), VaultingTable(), Approach())",
        "print(vault.objective(np.zeros((6, 5))))",
    )
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-500:]
    assert np.isfinite(float(done.stdout))
