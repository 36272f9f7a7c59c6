"""The motion of a robot, its figures and what they say."""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.motion.filters import runs
from plantigrade.record.folder import write_folder
from plantigrade.record.run import RUNS
from plantigrade.robots.robot import Robot, part_contacts
from plantigrade.robots.targets import SWING, Targets
from plantigrade.spatial.conventions import rotation_matrix, unit_vectors, wxyz_to_xyzw

MAX_SLIP = 2.0  # [mm] of a point of a sole while it touches the ground; of a foot that stands
MAX_DEPTH = 1.0  # [mm] of a sole below the ground
MAX_SELF_CONTACT = 5.0  # [mm] of parts that are no neighbours; shapes are coarse
MAX_HIP_ERROR = 0.15  # [1] RMS in legs of the robot; .015 is usual
MAX_PELVIS_ERROR = 20.0  # [deg] RMS; below 1 is usual
TOUCHING_HEIGHT = 0.001  # [m] height of a point that touches the ground


@dataclass(frozen=True, eq=False)
class RobotMotion:
    """The motion of a robot that took over that of a person.

    It is no Record: a Record holds a :class:`~plantigrade.models.Human`.
    """

    robot: Robot  #: The robot
    targets: Targets  #: What it was to do
    qpos: Float[Array, "n_frames nq"]  #: Poses; the quaternion of the root is w x y z [m, rad]

    @property
    def time(self) -> Float[Array, " n_frames"]:
        """Instants from zero [s]."""
        return self.targets.time - self.targets.time[0]

    @property
    def rate(self) -> float:
        """Frames per second [Hz]."""
        return round(float(1.0 / np.median(np.diff(self.targets.time))), 6)

    @cached_property
    def qvel(self) -> Float[Array, "n_frames nv"]:
        """Velocities, from differences of the poses before and after [m/s, rad/s]."""
        model, n = self.robot.model, len(self.qpos)
        found = np.empty((n, model.nv))
        for k in range(n):
            a, b = max(k - 1, 0), min(k + 1, n - 1)
            mujoco.mj_differentiatePos(
                model, found[k], float(self.time[b] - self.time[a]), self.qpos[a], self.qpos[b]
            )
        return found

    @cached_property
    def bodies(self) -> dict[str, Float[Array, "n_frames n_bodies k"]]:
        """Pose and velocity of every body but the world: ``position``, ``quaternion`` (w x y z).

        With them go ``velocity`` and ``angular_velocity`` of the body's frame, world, and ``cvel``,
        the velocity of the centre of mass as MuJoCo states it [m, m/s, rad/s].
        """
        model, data = self.robot.model, mujoco.MjData(self.robot.model)
        rows = []
        for qpos, qvel in zip(self.qpos, self.qvel, strict=True):
            data.qpos, data.qvel = qpos, qvel
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            rows.append([data.xpos[1:], data.xquat[1:], data.cvel, data.subtree_com])
            rows[-1] = [array.copy() for array in rows[-1]]
        position, quaternion, cvel, com = (np.array(part) for part in zip(*rows, strict=True))
        # MuJoCo states the velocity of a body at the centre of mass of its tree.
        about = cvel[:, 1:, :3]
        arm = position - com[:, model.body_rootid[1:]]
        return {
            "position": position,
            "quaternion": quaternion,
            "velocity": cvel[:, 1:, 3:] + np.cross(about, arm),
            "angular_velocity": about,
            "cvel": cvel,
            "com": com,
        }

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures of the motion, with the unit as suffix."""
        slip, depth = self._feet()
        model = self.robot.model
        limited = model.jnt_limited[1:] != 0
        low, high = model.jnt_range[1:].T
        over = np.maximum(low - self.qpos[:, 7:], self.qpos[:, 7:] - high)[:, limited]
        hips, turn, limbs = self._errors()
        return {
            "duration_s": float(self.time[-1]),
            "rate_hz": self.rate,
            "scale": self.targets.scale,
            "arm_abduction_deg": float(np.degrees(self.targets.abduction)),
            "slip_max_mm": slip,
            "depth_max_mm": depth,
            "range_violation_deg": float(np.degrees(max(over.max(initial=0.0), 0.0))),
            "hip_error_mm": 1000.0 * hips,
            "pelvis_error_deg": turn,
            "limb_error_deg": limbs,
            "hinge_speed_max_rad_s": float(np.abs(self.qvel[:, 6:]).max()),
            "self_contact_max_mm": self._self_contact(),
        }

    @property
    def status(self) -> str:
        """``"ok"``, or what is wrong."""
        f, wrong = self.figures, []
        if f["slip_max_mm"] > MAX_SLIP:
            wrong.append(f"a foot slips by {f['slip_max_mm']:.1f} mm (allowed: {MAX_SLIP:g})")
        if f["depth_max_mm"] > MAX_DEPTH:
            wrong.append(f"a foot is {f['depth_max_mm']:.1f} mm below the ground")
        if f["range_violation_deg"] > 1e-6:
            wrong.append(f"a joint is {f['range_violation_deg']:.2g}° beyond its range")
        far = f["hip_error_mm"] > 1000.0 * MAX_HIP_ERROR * self.robot.leg_length
        if far or f["pelvis_error_deg"] > MAX_PELVIS_ERROR:
            wrong.append(
                f"the robot does not follow: its hips are {f['hip_error_mm']:.0f} mm and its "
                f"pelvis {f['pelvis_error_deg']:.0f}° off (RMS)"
            )
        return "; ".join(wrong) or "ok"

    @property
    def warnings(self) -> list[str]:
        """What a user should know, one sentence each."""
        f, found = self.figures, []
        if f["self_contact_max_mm"] > MAX_SELF_CONTACT:
            deep = f["self_contact_max_mm"]
            found.append(f"parts of the robot are {deep:.0f} mm inside one another at most")
        return found

    def save(
        self,
        out: str | Path | None = None,
        *,
        name: str = "retarget",
        metrics: Mapping[str, Any] | None = None,
        overwrite: bool = False,
    ) -> Path:
        """Write the folder, whole or not at all, and return it.

        Args:
            out: The folder; ``runs/<name>`` if absent, numbered where that is taken.
            name: Its name where ``out`` is absent.
            metrics: Contents of ``metrics.json``; status and figures if absent.
            overwrite: Replace an existing one.

        Raises:
            RunExists: If the folder exists and is not to be replaced, or is no run.
            FileError: If the place cannot be written.
        """
        return write_folder(
            RUNS / name if out is None else out,
            metrics={"status": self.status, **self.figures} if metrics is None else metrics,
            files=files_of(self.robot, self.rate, self.qpos, self.qvel, self.bodies),
            overwrite=overwrite,
            numbered=out is None and not overwrite,
        )

    def _frame(self, body: int) -> tuple[Float[Array, "n_frames 3"], Float[Array, "n_frames 3 3"]]:
        """Return the positions [m] and orientations of a body."""
        k = body - 1
        return self.bodies["position"][:, k], rotation_matrix(self.bodies["quaternion"][:, k])

    def _centre(self, joint: str) -> Float[Array, "n_frames 3"]:
        """Return the positions of the centre of a joint of a person [m]."""
        position, rotation = self._frame(self.robot.joints[joint])
        return position + rotation @ self.robot.points[joint]

    def _soles(self, side: str) -> Float[Array, "n_frames n_points 3"]:
        """Return the lowest points of the spheres of a sole [m]."""
        sole = self.robot.soles[side]
        position, rotation = self._frame(sole.body)
        local = sole.origin + sole.points @ sole.rotation.T
        found = position[:, None] + local @ np.moveaxis(rotation, -1, -2)
        found[..., 2] -= sole.radius
        return found

    def _feet(self) -> tuple[float, float]:
        """Return how far a point slips while it touches the ground, and how deep one is [mm]."""
        slip = depth = 0.0
        for side in SIDES:
            points = self._soles(side)
            depth = max(depth, float(-points[..., 2].min()))
            standing = self.targets.phase[side] != SWING
            for p in range(points.shape[1]):
                for contact in runs(standing & (points[:, p, 2] < TOUCHING_HEIGHT)):
                    path = points[contact, p, :2]
                    slip = max(slip, float(np.linalg.norm(path - path[0], axis=1).max()))
        return 1000.0 * slip, 1000.0 * depth

    def _errors(self) -> tuple[float, float, float]:
        """Return RMS errors of hips [m], pelvis [deg] and limbs [deg]."""
        robot, targets = self.robot, self.targets
        model, data = robot.model, mujoco.MjData(robot.model)
        data.qpos = robot.standing
        mujoco.mj_kinematics(model, data)
        pelvis = robot.joints["pelvis"]
        rest = robot.facing.T @ data.xmat[pelvis].reshape(3, 3)
        hips = (self._centre("hip_r") + self._centre("hip_l")) / 2 - targets.hips
        now = self._frame(pelvis)[1]
        trace = np.einsum("nij,nij->n", targets.rotation["pelvis"] @ rest, now)
        turns = np.arccos(np.clip((trace - 1) / 2, -1, 1))
        limbs = []
        for (a, b), goal in targets.direction.items():
            along = unit_vectors(self._centre(b) - self._centre(a))
            limbs.append(np.arccos(np.clip(np.sum(along * goal, axis=1), -1, 1)))
        turn, limb = (root_mean_square(np.array(v)) for v in (turns, limbs))
        hip = float(np.sqrt(np.mean(np.sum(np.square(hips), axis=1))))
        return hip, float(np.degrees(turn)), float(np.degrees(limb))

    def _self_contact(self) -> float:
        """Return how deep two parts are inside one another, more than standing, at most [mm]."""
        model, data, deepest = self.robot.model, mujoco.MjData(self.robot.model), 0.0
        usual: dict[tuple[int, int], float] = {}
        for k, qpos in enumerate((self.robot.standing, *self.qpos)):
            data.qpos = qpos
            mujoco.mj_kinematics(model, data)
            mujoco.mj_collision(model, data)
            for pair, contact in part_contacts(model, data):
                depth = -float(contact.dist)
                if k == 0:
                    usual[pair] = max(usual.get(pair, 0.0), depth)
                else:
                    deepest = max(deepest, depth - usual.get(pair, 0.0))
        return 1000.0 * deepest


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
