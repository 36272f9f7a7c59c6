"""The files in which learning frameworks read the motion of a robot."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.robots.robot import Robot
from plantigrade.spatial.conventions import wxyz_to_xyzw


def files_of(
    robot: Robot,
    rate: float,
    qpos: Float[Array, "n_frames nq"],
    qvel: Float[Array, "n_frames nv"],
    bodies: Mapping[str, Float[Array, "n_frames n_bodies k"]],
) -> dict[str, bytes]:
    """Return the files by name.

    ``motion.npz`` is in the layout of mjlab's and Isaac Lab's motion tracking, ``motion.csv`` in
    that of Unitree's retargeted LAFAN1 (position and x y z w of the root, then the hinges),
    ``trajectory.npz`` in that of loco-mujoco.

    Args:
        rate: Frames per second [Hz].
        qpos: Poses, root w x y z [m, rad].
        qvel: Velocities [m/s, rad/s].
        bodies: Poses and velocities of the bodies, as :attr:`RobotMotion.bodies
            <plantigrade.robots.RobotMotion.bodies>` has them.
    """
    root = np.hstack([qpos[:, :3], wxyz_to_xyzw(qpos[:, 3:7])])
    text = io.StringIO()
    np.savetxt(text, np.hstack([root, qpos[:, 7:]]), "%.6f", ",")
    return {
        "motion.npz": _npz(_mjlab(robot, rate, qpos, qvel, bodies)),
        "motion.csv": text.getvalue().encode(),
        "trajectory.npz": _npz(_loco(robot, rate, qpos, qvel, bodies)),
    }


def _mjlab(robot: Robot, rate: float, qpos, qvel, bodies) -> dict[str, Any]:
    return {
        "fps": np.array([rate]),
        "joint_pos": qpos[:, 7:].astype(np.float32),
        "joint_vel": qvel[:, 6:].astype(np.float32),
        "body_pos_w": bodies["position"].astype(np.float32),
        "body_quat_w": bodies["quaternion"].astype(np.float32),
        "body_lin_vel_w": bodies["velocity"].astype(np.float32),
        "body_ang_vel_w": bodies["angular_velocity"].astype(np.float32),
        "joint_names": np.array(robot.hinges),
        "body_names": np.array(robot.bodies),
    }


def _loco(robot: Robot, rate: float, qpos, qvel, bodies) -> dict[str, Any]:
    model, n = robot.model, len(qpos)
    world = np.zeros((n, 1, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (n, 1, 1))
    names = [model.joint(0).name or "root", *robot.hinges]
    fields = ("rootid", "weldid", "mocapid", "pos", "quat", "ipos", "iquat")
    return {
        "joint_names": np.array(names),
        "body_names": np.array(["world", *robot.bodies]),
        "frequency": np.array(rate),
        "njnt": np.array(model.njnt),
        "jnt_type": model.jnt_type,
        "nbody": np.array(model.nbody),
        **{f"body_{name}": getattr(model, f"body_{name}") for name in fields},
        "qpos": qpos,
        "qvel": qvel,
        "xpos": np.concatenate([world[0], bodies["position"]], axis=1),
        "xquat": np.concatenate([world[1], bodies["quaternion"]], axis=1),
        "cvel": bodies["cvel"],
        "subtree_com": bodies["com"],
        "split_points": np.array([0, n]),
    }


def _npz(arrays: dict[str, Any]) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()
