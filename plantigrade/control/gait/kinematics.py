"""Positions and velocities of centre of mass, feet and contact spheres over a motion."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.control.gait.edges import EdgeSettings, lifts
from plantigrade.record import Record


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Positions and velocities at every instant, world axes; feet right first."""

    com: Float[Array, "n 3"]  #: Centre of mass [m]
    com_velocity: Float[Array, "n 3"]  #: Its velocity [m/s]
    foot_position: Float[Array, "n 2 3"]  #: Origins of the feet [m]
    foot_velocity: Float[Array, "n 2 3"]  #: Their velocities [m/s]
    foot_rotation: Float[Array, "n 2 3 3"]  #: Rotation matrices of the feet, foot to world
    foot_angular_velocity: Float[Array, "n 2 3"]  #: Their angular velocities [rad/s]
    contact_position: Float[Array, "n k 3"]  #: Lowest points of the contact spheres [m]
    #: Their heights above the ground; 0 of points on a seat [m]
    contact_height: Float[Array, "n k"]
    contact_speed: Float[Array, "n k"]  #: Their speeds [m/s]

    @classmethod
    def of(
        cls,
        record: Record,
        sites: tuple[ContactSite, ...],
        qpos: Float[Array, "n nq"],
        qvel: Float[Array, "n nv"],
        step: float,
    ) -> "Kinematics":
        """Return those of configurations and velocities that are a time step apart [s]."""
        human, ground, n, k = record.human, record.ground, len(qpos), len(sites)
        model = human.model
        data = mujoco.MjData(model)
        feet = human.both("foot")
        body = np.array([human.body(s.body) for s in sites])
        local = np.array([s.position for s in sites])
        radius = np.array([s.radius for s in sites])
        com, com_velocity, low = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, k, 3))
        position, velocity, angular = (np.empty((n, 2, 3)) for _ in range(3))
        rotation, speed = np.empty((n, 2, 3, 3)), np.empty(6)
        for i in range(n):
            data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_subtreeVel(model, data)
            com[i], com_velocity[i] = data.subtree_com[1], data.subtree_linvel[1]
            for side, foot in enumerate(feet):
                mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, foot, speed, 0)
                position[i, side] = data.xpos[foot]
                rotation[i, side] = data.xmat[foot].reshape(3, 3)
                velocity[i, side], angular[i, side] = speed[3:], speed[:3]
            axes = data.xmat[body].reshape(-1, 3, 3)
            low[i] = data.xpos[body] + np.einsum("kij,kj->ki", axes, local)
        seated = np.array([s.side == "" for s in sites])[:, None]
        down = np.where(seated, [0.0, 0.0, 1.0], ground.normal) * radius[:, None]
        low -= down
        height = ground.gap(low)
        height[:, seated[:, 0]] = 0.0
        moving = np.linalg.norm(np.gradient(low, step, axis=0), axis=2)
        return cls(com, com_velocity, position, velocity, rotation, angular, low, height, moving)

    def lift_over_edges(
        self,
        record: Record,
        sites: tuple[ContactSite, ...],
        contact: Bool[Array, "n k"],
        step: float,
        settings: EdgeSettings,
    ) -> None:
        """Lift swing feet clear of the edges of steps in the ground.

        Args:
            record: The motion, with its ground.
            contact: When each of them is in contact.
            step: Time step of the grid [s].
        """
        for i, side in enumerate(SIDES):
            own = np.array([s.side == side for s in sites])
            low, stands = self.contact_position[:, own], np.asarray(contact[:, own].any(axis=1))
            lift = lifts(record.ground, low, stands, step, settings)
            self.foot_position[:, i, 2] += lift
            self.foot_velocity[:, i, 2] += np.gradient(lift, step)
