"""Everything MuJoCo says about a motion under test, frame by frame."""

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.analyze.under_test import MotionUnderTest, contact_geoms


@dataclass(frozen=True, eq=False)
class Sweep:
    """Everything MuJoCo says about the motion, frame by frame, world axes.

    Attributes:
        weight: Body weight [N].
        root: What the motion asks for at the root: force [N] and moment about com [N m] (n, 6).
        tau, root_force, root_moment, com, point, gap: As in :class:`MotionCheck`.
        velocity: Of the material at the sites' points [m/s] (n, k, 3).
        momentum: Linear and about the centre of mass (n, 6).
        energy: Kinetic and potential [J] (n,).
        power: Of all generalised forces [W] (n,).
        normal: What each site stands on pushes this way (k, 3).
        spheres: Centres of the spheres that must not sink [m] (n, s, 3).
        sphere_names: Their names.
        sphere_radii: Their radii [m] (s,).
    """

    weight: float
    root: np.ndarray
    tau: np.ndarray
    root_force: np.ndarray
    root_moment: np.ndarray
    com: np.ndarray
    point: np.ndarray
    gap: np.ndarray
    velocity: np.ndarray
    momentum: np.ndarray
    energy: np.ndarray
    power: np.ndarray
    normal: np.ndarray
    spheres: np.ndarray
    sphere_names: tuple[str, ...]
    sphere_radii: np.ndarray


def sweep(motion: MotionUnderTest) -> Sweep:
    """Run MuJoCo's inverse dynamics, contacts and joint limits off, over all frames."""
    model = copy.deepcopy(motion.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_INVDISCRETE)
    data = mujoco.MjData(model)
    body = int(model.jnt_bodyid[0])
    n, k, nv = len(motion.time), len(motion.sites), model.nv
    carriers = np.array([model.body(site.body).id for site in motion.sites], int)
    local = np.array([site.position for site in motion.sites]).reshape(k, 3)
    radius = np.array([site.radius for site in motion.sites])
    normal = np.array([s.normal or motion.ground.normal for s in motion.sites]).reshape(k, 3)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    down = radius[:, None] * normal
    loaded = [np.flatnonzero(row) for row in np.any(motion.contact_force != 0.0, axis=2)]
    geoms = contact_geoms(model)

    wanted, explained = np.empty((n, nv)), np.zeros((n, nv))
    com, point, velocity = np.empty((n, 3)), np.empty((n, k, 3)), np.empty((n, k, 3))
    momentum, energy, power = np.empty((n, 6)), np.empty(n), np.empty(n)
    spheres, turn = np.empty((n, len(geoms), 3)), np.empty((n, 3, 3))
    for f in range(n):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion.qpos[f], motion.qvel[f], motion.qacc[f]
        mujoco.mj_inverse(model, data)
        mujoco.mj_subtreeVel(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        wanted[f] = data.qfrc_inverse
        power[f] = (data.qfrc_inverse + data.qfrc_passive) @ data.qvel
        energy[f] = data.energy.sum()
        centre = data.subtree_com[body]
        com[f], turn[f] = centre, data.xmat[body].reshape(3, 3)
        momentum[f, :3] = model.body_subtreemass[body] * data.subtree_linvel[body]
        momentum[f, 3:] = data.subtree_angmom[body]
        spheres[f] = data.geom_xpos[geoms]
        if k:
            rotation = data.xmat[carriers].reshape(k, 3, 3)
            at = data.xpos[carriers] + np.einsum("kij,kj->ki", rotation, local) - down
            twist = data.cvel[carriers]  # angular, then linear where the body's centre of mass is
            point[f] = at
            velocity[f] = twist[:, 3:] + cross(twist[:, :3], at - centre)
            for i in loaded[f]:
                mujoco.mj_applyFT(
                    model,
                    data,
                    motion.contact_force[f, i],
                    np.zeros(3),
                    at[i],
                    int(carriers[i]),
                    explained[f],
                )
    tau = wanted - explained
    height = _heights(motion, point)
    return Sweep(
        float(model.body_subtreemass[body] * np.linalg.norm(model.opt.gravity)),
        _wrench(wanted, turn, motion.qpos, com),
        tau,
        _wrench(tau, turn, motion.qpos, com)[:, :3],
        _wrench(tau, turn, motion.qpos, com)[:, 3:],
        com,
        point,
        np.einsum("nki,ki->nk", point, normal) - height,
        velocity,
        momentum,
        energy,
        power,
        normal,
        spheres,
        tuple(model.geom(g).name for g in geoms),
        np.array(model.geom_size[geoms, 0]),
    )


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product of rows (NumPy's own costs more than all the rest of a frame)."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def _wrench(tau: np.ndarray, turn: np.ndarray, qpos: np.ndarray, com: np.ndarray) -> np.ndarray:
    """Return the generalised force of the free joint as force and moment about ``com`` (n, 6)."""
    force = tau[:, :3]
    moment = np.einsum("nij,nj->ni", turn, tau[:, 3:6]) + cross(qpos[:, :3] - com, force)
    return np.hstack([force, moment])


def _heights(motion: MotionUnderTest, point: np.ndarray) -> np.ndarray:
    """Return the height of what each site stands on, along its normal [m] (n, k)."""
    height = motion.ground.under(point).copy()
    for i, site in enumerate(motion.sites):
        if site.height is not None:
            height[:, i] = site.height
    return height
