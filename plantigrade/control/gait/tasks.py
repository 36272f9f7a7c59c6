"""What a replay asks of the whole body at an instant: rows, weights and forces of its program."""

from dataclasses import dataclass
from math import hypot

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.gait.instant import Instant
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.models import Human
from plantigrade.wbc.rows import PointRows, Rows

SPINE, LIGHT, LEG, TOES = 1.0, 0.25, 0.6, 0.3
"""Weights of joints: spine; arms and neck; hips, knees and ankles; toes and bones of the foot."""
PELVIS, FOOT, SWING_TURN, STANCE_TURN, HELD = 3.0, 10.0, 2.0, 0.5, 30.0
"""Weights: turn of the pelvis, place and turn of a swinging foot, turn of a standing one, what
touches."""
COM = np.array([12.0, 12.0, 5.0])
"""Weights of the acceleration of the centre of mass."""
TORQUE = 0.01 * 50.0
"""Weight of a torque off the motion's, by the strength of the joint."""
PLANNED, UNPLANNED = 0.07, 0.35
"""Weights of a force [0.1 body weights] off the motion's, where it plans one and where not."""
JOINT_GAINS, PELVIS_GAINS = (100.0, 18.0), (100.0, 20.0)
PLACE_GAINS, TURN_GAINS = (400.0, 40.0), (200.0, 28.0)
"""Stiffness and damping by mass [1/s², 1/s]."""
HANGING_GAINS = (800.0, 40.0)
"""The same of the turn of a foot that stands and hangs off the ground in part: until it lies, the
pressure is under its heel (or toes) alone. With those of the others that takes half a step."""
FARTHEST = 0.15
"""A foot's error counts no further than this [m]."""
_ONE = np.eye(3)
LEGS = ("hip_", "knee_", "ankle_", "subtalar_")
TRUNK = ("lumbar_", "thor")


def joint_weights(human: Human) -> Float[Array, " n_hinges"]:
    """Return the weight of every hinge."""
    weights = []
    foot = {name for name in human.coordinates if _below_ankle(human, name)}
    for name in human.coordinates:
        if name.startswith(TRUNK):
            weights.append(SPINE)
        elif name in foot:
            weights.append(TOES)
        elif name.startswith(LEGS):
            weights.append(LEG)
        else:
            weights.append(LIGHT)
    return np.array(weights)


def _below_ankle(human: Human, name: str) -> bool:
    """Return whether a hinge moves a part of the foot against its hindfoot."""
    model = human.model
    body = int(model.jnt_bodyid[model.joint(name).id])
    feet = {human.body(f"foot_{side}") for side in ("r", "l")}
    parent = int(model.body_parentid[body])
    while parent > 0:
        if parent in feet:
            return True
        parent = int(model.body_parentid[parent])
    return False


def turn_error(wanted: Float[Array, "3 3"], now: Float[Array, "3 3"]) -> Float[Array, " 3"]:
    """Return the rotation vector that leads one orientation to another, world axes [rad]."""
    goal, have, error = np.empty(4), np.empty(4), np.empty(3)
    mujoco.mju_mat2Quat(goal, wanted.ravel())
    mujoco.mju_mat2Quat(have, now.ravel())
    mujoco.mju_subQuat(error, goal, have)  # in the axes of what is now
    return now @ error


def root_error(wanted: Float[Array, " 4"], now: Float[Array, " 4"]) -> Float[Array, " 3"]:
    """Return the rotation vector that leads one quaternion to another, in axes of the second."""
    error, goal = np.empty(3), wanted.copy()
    mujoco.mju_normalize4(goal)
    mujoco.mju_subQuat(error, goal, now)
    return error


def heading(quat: Float[Array, " 4"]) -> Float[Array, "2 2"]:
    """Return the horizontal directions ahead and to the left of a pelvis, as columns."""
    w, x, y, z = quat.tolist()
    ahead, left = w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z)
    size = max(hypot(ahead, left), 1e-9)
    c, s = ahead / size, left / size
    return np.array([[c, -s], [s, c]])


def place_rows(J, bias, wanted, error, rate_error) -> Rows:
    """Return rows that lead a point: its acceleration with stiffness and damping."""
    error = error * min(1.0, FARTHEST / max(hypot(*error), 1e-9))
    k, d = PLACE_GAINS
    return Rows(J, wanted + k * error + d * rate_error - bias, FOOT**2)


def turn_rows(J, bias, wanted, error, rate_error, *, normal=None, hangs: bool = False) -> Rows:
    """Return rows that turn a foot; one that stands is left to its own heading.

    One that stands but hangs off the ground, in part, is laid on it as firmly as one that swings.
    """
    k, d = HANGING_GAINS if hangs and normal is not None else TURN_GAINS
    right = wanted + k * error + d * rate_error - bias
    if normal is None:
        return Rows(J, right, SWING_TURN**2)
    across = _ONE - normal[:, None] * normal
    return Rows(across @ J, across @ right, (SWING_TURN if hangs else STANCE_TURN) ** 2)


def held_rows(points: RigidPoints, held, gap, normal) -> PointRows:
    """Return rows that hold points on the ground still."""
    right = -40.0 * points.velocity - points.bias
    right -= 400.0 * np.maximum(gap, 0.0)[:, None] * normal
    return PointRows(points, held, right, HELD**2)


def com_rows(M, h, mass: float, gravity, wanted) -> Rows:
    """Return rows of the acceleration of the centre of mass: the root's own equations."""
    return Rows(M[:3] / mass, wanted - (h[:3] / mass + gravity), COM**2)


@dataclass(frozen=True)
class Weights:
    """Weights of a person's joints, by coordinate.

    Attributes:
        posture: Cost of accelerations off what is wanted.
        torque: Cost of torques off the motion's [1/(N m)²].
    """

    posture: Float[Array, " nv"]
    torque: Float[Array, " n_hinges"]

    @classmethod
    def of(cls, human: Human) -> "Weights":
        """Return those of a person."""
        joints = joint_weights(human)
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        root = np.array([0.0, 0.0, 0.0, PELVIS, PELVIS, PELVIS])
        return cls(np.concatenate([root, joints]) ** 2, (TORQUE / np.maximum(-low, high)) ** 2)


def leg_joints(human: Human) -> Bool[Array, " n_hinges"]:
    """Return which hinges are those of hips, knees and ankles."""
    return np.array([name.startswith(LEGS) for name in human.coordinates])


def wanted_accelerations(
    ref: Instant, rate: float, qpos: Array, qvel: Array, slack: Array | None = None
) -> Array:
    """Return the accelerations of pelvis and joints that lead back to the motion.

    Joints that are slack are only slowed: they are where something else has led them.
    """
    wanted = rate**2 * ref.a
    late = rate * ref.v - qvel
    k, d = JOINT_GAINS
    off = ref.q[7:] - qpos[7:]
    if slack is not None:
        off[slack] = 0.0
    wanted[6:] += k * off + d * late[6:]
    k, d = PELVIS_GAINS
    wanted[3:6] += k * root_error(ref.q[3:7], qpos[3:7]) + d * late[3:6]
    wanted[:3] = 0.0
    return wanted
