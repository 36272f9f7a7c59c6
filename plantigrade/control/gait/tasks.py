"""Whole-body tasks of a motion that is carried out: weights, gains, and what joints are to do."""

from dataclasses import dataclass
from math import hypot

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.gait.instant import Instant
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.wbc.rows import PointRows
from plantigrade.wbc.tasks import LinearMomentumTask, OrientationTask, PointTask
from plantigrade.wbc.tasks.task import Target

LEGS = ("hip_", "knee_", "ankle_", "subtalar_")
TRUNK = ("lumbar_", "lower_thorax_", "thorax_")


@dataclass(frozen=True, kw_only=True)
class GaitTaskSettings:
    """Weights and gains of tasks: a weight is the root of the cost of a squared unit missed.

    The weight of joints of the spine is 1 [per rad/s²].
    """

    arm_weight: float = 0.25
    """Joints of arms and neck [per rad/s²]. Chosen: arms are free to balance."""
    leg_weight: float = 0.6
    """Hips, knees and ankles [per rad/s²]. Chosen: tasks of feet and pelvis lead the legs."""
    toe_weight: float = 0.3
    """Joints within the foot [per rad/s²]. Chosen: they take the shape of the ground."""
    pelvis_weight: float = 3.0
    """Rotation of the pelvis [per rad/s²]. Chosen (±20 %: below 2 %)."""
    com_weight: tuple[float, float, float] = (12.0, 12.0, 30.0)
    """Centre of mass along world axes [per m/s²]: legs give way to its height, which is lowered for
    far footsteps."""
    foot_weight: float = 10.0
    """Position of a swinging foot, and of points held on the ground [per m/s²]. Chosen (±20 %:
    deviation 2 %)."""
    rotation_weight: float = 2.0
    """Rotation of a foot, of a standing one about horizontal axes [per rad/s²]. Chosen (±20 %:
    below 2 %): paths and contacts lead it."""

    torque_weight: float = 0.5
    """Torque off the motion's, as a part of the joint's strength. Chosen."""
    planned_force_weight: float = 0.07
    """Force along a pyramid's edge [per 0.1 body weights] off the motion's, where it has one.
    Chosen."""
    unplanned_force_weight: float = 0.35
    """The same where the motion has none. Chosen."""
    recovery_error: float = 0.1
    """Error of the divergent component from which a step is a recovery [leg lengths]: its foot
    leaves the recorded path, and a late one comes down where it is; or from which a motion waits
    for steps that it does not have. Trunk, arms and head balance in full from there, by the square
    of the error below: people use them when a step alone cannot help."""
    dcm_gain: float = 5.0
    """Feedback of the divergent component by the centre of pressure [1/s]."""
    com_height_stiffness: float = 400.0
    """Stiffness of the height of the centre of mass, critically damped [1/s²]."""
    max_vertical_acceleration: float = 3.5
    """Greatest vertical acceleration of the mass [m/s²]: a body that falls can neither press nor
    step, and one that rises faster would be thrown into the air. With 3, a person with legs of
    three quarters of their length fell; with 4, the ankle moment's peak was 16 % off."""
    rise_time: float = 0.5
    """Time constant with which a lowered body rises again [s]: faster, it was thrown up between
    steps."""
    joint_stiffness: float = 100.0
    """Stiffness of joints and of the pelvis' rotation, critically damped [1/s²]. Chosen."""
    foot_stiffness: float = 400.0
    """Stiffness of a foot's position [1/s²], and of the gap below points that are held; critically
    damped. Chosen."""
    rotation_stiffness: float = 200.0
    """Stiffness of a foot's rotation, critically damped [1/s²]. Chosen."""
    hanging_stiffness: float = 800.0
    """Rotational stiffness of a standing foot that hangs off the ground in part [1/s²]: until it
    lies, the pressure is under its heel (or toes) alone. With that of the others this takes half a
    step."""

    def posture(self, human: Human) -> Float[Array, " nv"]:
        """Return the cost of every coordinate's acceleration; none for the position of the root."""
        root = [0.0, 0.0, 0.0, *[self.pelvis_weight] * 3]
        return np.concatenate([root, joint_weights(human, self)]) ** 2

    def recovery_share(self, dcm_error: Float[Array, " 2"], leg_length: float) -> float:
        """Return how much a step is a recovery, from 0 to 1.

        Args:
            dcm_error: Error of the divergent component [m].
            leg_length: Length of the leg [m].
        """
        return min(hypot(*dcm_error) / (self.recovery_error * leg_length), 1.0) ** 2

    @property
    def joint_damping(self) -> float:
        """Critical damping of joints and of the pelvis' rotation [1/s]."""
        return 2.0 * self.joint_stiffness**0.5

    def com_acceleration(
        self,
        body: BodyState,
        ref: Instant,
        omega: float,
        dcm_error: Float[Array, " 2"],
        cop_offset: Float[Array, " 2"],
        contacts: Float[Array, "k 2"],
        beyond: float,
    ) -> Float[Array, " 3"]:
        """Return the desired acceleration of the centre of mass; upwards, that of the motion.

        The centre of pressure goes where it stops the error of the divergent component, and
        accelerates the pendulum.

        Args:
            ref: The motion at the phase of the gait.
            omega: Root of gravity by height [1/s].
            dcm_error: Error of the divergent component [m].
            cop_offset: Offset of the centre of pressure from the motion without it [m].
            contacts: Points that touch, over the ground [m].
            beyond: Distance by which the centre of pressure may be desired outside of these [m];
                negative for one that it keeps from their edge.
        """
        moved, cop = cop_offset + (1.0 + self.dcm_gain / omega) * dcm_error, ref.cop[:2]
        if len(contacts):
            nominal = cop + cop_offset
            low = np.minimum(contacts.min(axis=0) - beyond, nominal)
            high = np.maximum(contacts.max(axis=0) + beyond, nominal)
            moved = np.minimum(np.maximum(cop + moved, low), high) - cop
        desired = np.array(ref.com_acceleration)
        desired[:2] += omega**2 * ((body.com - ref.com)[:2] - moved)
        return desired

    def torque(self, human: Human) -> Float[Array, " n_hinges"]:
        """Return the cost of every torque [1/(N m)²]."""
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        return (self.torque_weight / np.maximum(-low, high)) ** 2

    def force_cost(self, held: Bool[Array, " k"]) -> Float[Array, " k"]:
        """Return the cost of a force [0.1 body weights], squared, at each contact.

        Args:
            held: Which are planned to stand.
        """
        return np.where(held, self.planned_force_weight, self.unplanned_force_weight) ** 2

    def still(self, points: RigidPoints, held: Array, gap: Array, normal: Array) -> PointRows:
        """Return rows that hold points on the ground still."""
        return PointRows.still(
            points,
            held,
            gap,
            normal,
            stiffness=self.foot_stiffness,
            damping=2.0 * self.foot_stiffness**0.5,
            weight=self.foot_weight**2,
        )


class TrackingTasks:
    """The tasks of feet and centre of mass.

    Attributes:
        com: The centre of mass; its desired acceleration is given.
        swing: Position of each foot.
    """

    def __init__(self, feet: PointSet, settings: GaitTaskSettings):
        s = self.settings = settings
        self.com = LinearMomentumTask(feet.human.mass, weight=np.array(s.com_weight) ** 2)
        sides, stiffness = range(len(feet)), (s.rotation_stiffness, s.hanging_stiffness)
        self.swing = [
            PointTask(
                feet,
                which=i,
                stiffness=s.foot_stiffness,
                weight=s.foot_weight**2,
            )
            for i in sides
        ]
        weight = s.rotation_weight**2
        self._turns = [
            [OrientationTask(int(feet.body[i]), stiffness=k, weight=weight) for k in stiffness]
            for i in sides
        ]

    def rotation(
        self, i: int, target: Target, normal: Array | None, hangs: bool
    ) -> OrientationTask:
        """Return the task of a foot's rotation; one that stands is left to its own heading.

        Args:
            i: Which foot.
            target: Rotation, angular velocity and acceleration.
            normal: Normal of the ground where the foot stands; none where it swings.
            hangs: Whether a standing foot hangs off the ground in part.
        """
        task = self._turns[i][hangs and normal is not None]
        task.target = target
        task.directions = None if normal is None else np.eye(3) - normal[:, None] * normal
        return task


def joint_weights(human: Human, settings: GaitTaskSettings) -> Float[Array, " n_hinges"]:
    """Return the weight of every hinge [per rad/s²]."""
    weights = []
    for name, within in zip(human.coordinates, within_foot(human), strict=True):
        if name.startswith(TRUNK):
            weights.append(1.0)
        elif within:
            weights.append(settings.toe_weight)
        elif name.startswith(LEGS):
            weights.append(settings.leg_weight)
        else:
            weights.append(settings.arm_weight)
    return np.array(weights)


def within_foot(human: Human) -> Bool[Array, " n_hinges"]:
    """Return which hinges move a part of the foot against its hindfoot."""
    model, feet = human.model, {human.body(f"foot_{side}") for side in ("r", "l")}

    def below(body: int) -> bool:
        parent = int(model.body_parentid[body])
        return parent > 0 and (parent in feet or below(parent))

    bodies = [int(model.jnt_bodyid[model.joint(name).id]) for name in human.coordinates]
    return np.array([below(body) for body in bodies])


def leg_joints(human: Human) -> Bool[Array, " n_hinges"]:
    """Return which hinges are those of hips, knees and ankles."""
    return np.array([name.startswith(LEGS) for name in human.coordinates])


def root_error(desired: Float[Array, " 4"], now: Float[Array, " 4"]) -> Float[Array, " 3"]:
    """Return the rotation vector that leads one quaternion to another, in axes of the second."""
    error, goal = np.empty(3), desired.copy()
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


def desired_accelerations(
    ref: Instant,
    rate: float,
    body: BodyState,
    settings: GaitTaskSettings,
    free: Bool[Array, " n_hinges"] | None = None,
) -> Float[Array, " nv"]:
    """Return the accelerations of pelvis and joints that lead back to the motion [rad/s²].

    Args:
        free: Joints that are only slowed: they are where something else has led them.
    """
    desired = rate**2 * ref.a
    late = rate * ref.v - body.qvel
    off = ref.q[7:] - body.qpos[7:]
    if free is not None:
        off[free] = 0.0
    desired[6:] += settings.joint_stiffness * off + settings.joint_damping * late[6:]
    turn = settings.joint_stiffness * root_error(ref.q[3:7], body.qpos[3:7])
    desired[3:6] += turn + settings.joint_damping * late[3:6]
    desired[:3] = 0.0
    return desired
