r"""Inverse dynamics of a person's own OpenSim model: moments of its coordinates.

With :math:`q = f(u)`, :math:`\dot q = G \dot u` and the wrenches of the plates on the feet,
:math:`\tau_u = G^T (M \ddot q + h - \sum_k J_k^T w_k)`. For the root these are the residuals.
Coordinates are smoothed, joints follow them, so that coupled joints stay coupled.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.derivatives import slopes, smoothed
from plantigrade.dynamics.plates import FootForces
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.osim_shapes import foot_bodies
from plantigrade.kinematics.state import sweep
from plantigrade.motion.recording import even_clock
from plantigrade.spatial.conventions import continuous_poses


@dataclass(frozen=True)
class OsimMotion:
    """A motion of a person's own model with its derivatives."""

    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    u: Float[Array, "n_frames n_coordinates"]  #: Coordinates [rad, m], smoothed
    qpos: Float[Array, "n_frames nq"]  #: Configurations of MuJoCo
    qvel: Float[Array, "n_frames nv"]  #: Their velocities
    qacc: Float[Array, "n_frames nv"]  #: Their accelerations


def osim_motion(
    human: OsimHuman,
    time: Float[Array, " n_frames"],
    u: Float[Array, "n_frames n_coordinates"],
    cutoff: float | None,
) -> OsimMotion:
    """Return a motion from coordinates over time.

    Args:
        time: Time of each frame [s].
        u: Coordinates [rad, m].
        cutoff: Zero-lag fourth-order low-pass [Hz]; None for no filter.
    """
    time = even_clock(time)
    u = u if cutoff is None else smoothed(time, u, cutoff)
    qpos = continuous_poses(human.poses(u))
    rates, _ = slopes(time, u)
    qvel = np.stack([human.slopes(now) @ rate for now, rate in zip(u, rates, strict=True)])
    return OsimMotion(time, u, qpos, qvel, slopes(time, qvel)[0])


def osim_moments(
    human: OsimHuman, motion: OsimMotion, forces: FootForces | None
) -> Float[Array, "n_frames nv"]:
    """Return the generalised forces of the coordinates at their joints of MuJoCo [N m, N].

    They are zero at joints that follow a coordinate; the first six are the residual at the root,
    world force and body moment.

    Args:
        forces: Ground reactions on the feet; none if absent.
    """
    feet = foot_bodies(human.links)
    found = np.zeros((len(motion.time), human.model.nv))
    names = [c.name for c in human.every_coordinate]
    coordinates = [names.index(c) for c in human.coordinates]
    joints = [6 + human.hinge(c) for c in human.coordinates]
    for f, state in enumerate(sweep(human, motion.qpos, motion.qvel)):
        tau = state.inverse_dynamics(motion.qacc[f])
        for k, side in enumerate(SIDES):
            if forces is None or side not in feet or not np.isfinite(forces.point[f, k]).all():
                continue
            wrench = forces.point[f, k], forces.force[f, k], forces.torque[f, k]
            tau = tau - state.generalised_force(human.body(feet[side]), *wrench)
        found[f, :6] = tau[:6]
        found[f, joints] = (human.signs * (human.slopes(motion.u[f]).T @ tau))[coordinates]
    return found


def moment_names(human: OsimHuman) -> tuple[str, ...]:
    """Return OpenSim's names of the generalised forces, ``…_moment`` or ``…_force``."""
    axes = [axis for joint in human.osim.joints for axis in joint.axes]
    slides = {a.coordinate for a in axes if a.slides and a.function.line is not None}
    turns = {axis.coordinate for axis in axes if not axis.slides}
    return tuple(
        f"{c.name}_{'force' if c.name in slides - turns else 'moment'}"
        for c in human.every_coordinate
    )
