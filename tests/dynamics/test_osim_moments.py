"""Moments of the coordinates of a person's own OpenSim model."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.osim_moments import osim_moments, osim_motion
from plantigrade.dynamics.plates import assign_plates, sole_points
from plantigrade.io import read
from plantigrade.io.mot import read_table
from plantigrade.io.osim_body import OsimHuman
from plantigrade.models import Human
from plantigrade.models.osim import to_osim
from tests.io.osim_files import every_joint

WALK = Path(__file__).parents[2] / "../shared/data/opensim/rajagopal_walk"


def swinging(human: OsimHuman, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Return time and coordinates that swing, each at its own frequency."""
    time, k = np.linspace(0, 1, n), len(human.every_coordinate)
    rate = np.random.default_rng(0).uniform(2.0, 6.0, k)
    return time, 0.3 * np.sin(rate * time[:, None] + np.arange(k))


def test_power_of_the_moments_is_the_change_of_energy_with_coupled_joints():
    human = OsimHuman.of(every_joint())
    time, u = swinging(human, 120)
    motion = osim_motion(human, time, u, None)
    torque = osim_moments(human, motion, None)
    model, data, energy = human.model, mujoco.MjData(human.model), []
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    for qpos, qvel in zip(motion.qpos, motion.qvel, strict=True):
        data.qpos, data.qvel = qpos, qvel
        mujoco.mj_forward(model, data)
        energy.append(data.energy.sum())
    power = np.einsum("ij,ij->i", torque, motion.qvel)
    change = np.gradient(energy, time)
    inner = slice(8, -8)
    assert np.ptp(power[inner]) > 10
    assert power[inner] == pytest.approx(change[inner], abs=0.01 * np.ptp(power[inner]))


def test_moments_are_those_of_the_human_that_was_written():
    human = Human.create(1.7, 65.0, joints="42")
    own = OsimHuman.of(to_osim(human))
    time, u = swinging(own)
    names = [c.name for c in own.every_coordinate]
    qpos = human.from_coordinates(names, u)
    theirs = differentiate(human, time, qpos, None)
    expected = inverse_dynamics(human, theirs.qpos, theirs.qvel, theirs.qacc)
    torque = osim_moments(own, osim_motion(own, time, u, None), None)
    for name in human.coordinates:
        mine = torque[5:-5, 6 + own.hinge(name)]
        scale = max(1.0, float(np.ptp(expected[name])))
        assert mine == pytest.approx(expected[name][5:-5], abs=2e-3 * scale), name


@pytest.mark.slow
@pytest.mark.skipif(not WALK.exists(), reason="needs the shared data")
def test_moments_agree_with_the_stored_ones_of_opensim():
    path = WALK / "subject_walk_scaled.osim"
    human = OsimHuman.of(path.read_text(encoding="utf-8"), path)
    stored, known = read_table(WALK / "coordinates.sto"), read_table(WALK / "id_walk.sto")
    every = slice(None, None, 20)
    u = np.tile(human.defaults(), (len(stored.time[every]), 1))
    for k, c in enumerate(human.every_coordinate):
        u[:, k] = stored[c.name][every] if c.name in stored.names else u[:, k]
    motion = osim_motion(human, stored.time[every], u, 6.0)  # OpenSim's moments were of 6 Hz
    soles = sole_points(human, motion.qpos)
    forces = assign_plates(read(WALK / "grf_walk.mot").plates, motion.time, soles)
    torque = osim_moments(human, motion, forces)
    inner = slice(3, -3)
    for name in human.coordinates:
        if f"{name}_moment" in known.names:
            theirs = np.interp(motion.time, known.time, known[f"{name}_moment"])
            mine = torque[:, 6 + human.hinge(name)]
            assert np.corrcoef(mine[inner], theirs[inner])[0, 1] > 0.99, name
