"""Whole-body tasks of a walk, as desired velocities: joints, pelvis, feet, contacts, the mass.

[Tsai2010]_ gives every joint a desired velocity that depends on its error alone, and one program
finds the torques, within their limits, and the contact forces. Every task here reaches a desired
velocity in a time: its acceleration is the velocity error by that time, added
to the acceleration of the reference; :class:`~plantigrade.wbc.whole_body.WholeBody` serves all
tasks at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.step import StepSettings
from plantigrade.control.gait.tasks import TRUNK, GaitTaskSettings, root_error, within_foot
from plantigrade.control.pendulum.foot_task import FootTask
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.tasks import AngularMomentumTask, LinearMomentumTask
from plantigrade.wbc.tasks.contact import ContactSettings
from plantigrade.wbc.tasks.task import Target


@dataclass(frozen=True, kw_only=True)
class JointVelocitySettings:
    """The desired velocity of a joint: in proportion to its error.

    Limbs that are led to a goal move so (Fig. 7 of [Tsai2010]_, after [Flash1985]_), but for the
    slow beginning and the greatest velocity of a movement over more than a radian, which were never
    met.
    """

    time: float = 0.055
    """Time in which the velocity is reached [s], the stiffness being that of the pelvis, whose time
    is 0.05 s: damping is 0.91 of the critical one. With 0.05 s the median error of the peak of the
    ankle moment was 20 %, now 16 %, on the calibration half of ``experiment human-likeness``."""
    swing_toe_factor: float = 2.0
    """Factor of gain and rate within a foot that swings: its toes are needed again soon. It stands
    for the constants of joints of [Tsai2010]_, whose table the printed text lacks."""


@dataclass(frozen=True, kw_only=True)
class WalkingTaskSettings:
    """Weights and gains of the tasks; values were chosen where no reason is given.

    Springs are critically damped.
    """

    weights: GaitTaskSettings = GaitTaskSettings()
    """Weights and stiffnesses."""
    joints: JointVelocitySettings = JointVelocitySettings()
    """Desired velocities of joints."""
    max_reaching_descent: float = 7.0
    """Greatest downward acceleration where a footstep needs a low body [m/s²]: the foot hung over
    it, and the body fell over the foot."""
    max_landing_speed: float = 0.3
    """Greatest speed of the mass towards the ground at a touchdown for which the body is lowered
    [m/s]: at 0.7 m/s a straight leg, which does not yield, landed with up to 9 body weights."""
    min_braking_time: float = StepSettings.load_transfer_duration
    """Shortest time in which it is slowed to that speed [s], that in which a foot takes its load:
    more would throw it up. The upward acceleration for it is that of body weight at most."""
    neck_error_scale: float = 0.3
    """Error of a joint of the neck that doubles its weight [rad]: the head is the cheapest
    flywheel, but people hold it still in space [Pozzo1990]_."""
    trunk_error_scale: float = 0.1
    """The same for joints of the trunk, in proportion to how much it balances [rad]. Without it the
    back bent by up to 67° after pushes of up to 300 N, and by 46° backward after 100 N; people bend
    it by 30° backward and 35° sideways at most [AAOS1965]_."""
    max_cop_distance: float = 0.35
    """Greatest distance of the desired centre of pressure outside of the contacts [leg lengths]:
    the part that feet cannot give, trunk and arms give by angular momentum [Hof2007]_."""
    steady_arm_weight: float = GaitTaskSettings.leg_weight
    """Weight of joints of arms and neck without such an error [per rad/s²]; as of legs: lighter
    ones were raised to hold the centre of mass up."""
    knee_stop_time: float = 0.025
    """Time ahead in which a knee would be bent backwards, from which it resists [s]: near full
    extension a leg gains no length, and the height of the mass drove knees to -16°. Five ticks."""
    knee_stop_angle: float = 0.03
    """Angle beyond full extension at which the weight of a knee is that of the height of the
    mass [rad]."""
    steady_pelvis_weight: float = 6.0
    """Weight of the rotation of the pelvis without such an error [per rad/s²]: with 3, trunks
    leaned 2 to 7° farther forward than recorded; with 6 in every state, pushed people fell."""
    steady_trunk_weight: float = steady_pelvis_weight
    """Weight of joints of the trunk without such an error, as firm as the pelvis [per rad/s²]: with
    1, as of people who balance, trunks rocked to and fro by 7° in a stride (median of 13 walks; up
    to 19°), people's by 4°. It falls geometrically with how much the trunk balances: with the mean
    of both, which stays high for long, 12 of 20 tours with punches were completed, now 18."""
    momentum_weight: float = steady_pelvis_weight
    """Angular momentum about horizontal axes [per m/s² at a lever of 1 m], as firmly as the pelvis:
    people keep it small [Herr2008]_. Without it the pelvis was turned back after every touchdown,
    and the centre of pressure went to the toes and back to the heel (ankle moment r .91, now .93);
    with 12, a person with legs of half the length fell."""
    hanging_height: float = ContactSettings.guarded_depth
    """Height above which a point cannot press before it is down [m], as far as points may sink: the
    body leaned on heels that hung 2 mm over the ground, and fell on them with three times its
    weight."""
    hanging_force_cost: float = 20.0
    """Cost of a force [0.1 body weights], squared, at twice that height."""


class WalkingTasks:
    """The tasks of a walk.

    Args:
        leg: Length of their legs [m].

    Attributes:
        com: The centre of mass; its desired acceleration is given.
        position: Position of the origin of a foot.
        torque_cost: Cost of the torque of each hinge [1/(N m)²].
    """

    def __init__(self, human: Human, leg: float, settings: WalkingTaskSettings | None = None):
        self.settings = own = settings or WalkingTaskSettings()
        self.leg, names, weights = leg, human.coordinates, own.weights
        self._weight = weights.posture(human)
        steady = {"arm_weight": own.steady_arm_weight, "pelvis_weight": own.steady_pelvis_weight}
        self._steady_weight = replace(weights, **steady).posture(human)
        self._neck = 6 + np.flatnonzero(["neck_" in name for name in names])
        self._trunk = 6 + np.flatnonzero([name.startswith(TRUNK) for name in names])
        self._steady_weight[self._trunk] = own.steady_trunk_weight**2
        self._knees = 6 + np.flatnonzero(["knee_angle" in name for name in names])
        mass = float(human.model.body_mass.sum())
        self.com = LinearMomentumTask(mass, weight=np.array(weights.com_weight) ** 2)
        self.momentum = AngularMomentumTask()
        self._rotation = FootTask(slice(3), weights.rotation_stiffness, weights.rotation_weight)
        self.position = FootTask(slice(3, 6), weights.foot_stiffness, weights.foot_weight)
        sides = np.array([[name.endswith(f"_{side}") for name in names] for side in SIDES])
        self._toes = sides & within_foot(human)
        self.torque_cost = weights.torque(human)

    def flywheel_share(self, dcm_error: Float[Array, " 2"]) -> float:
        """Return how much trunk, arms and head balance, by the error of the divergent component."""
        return self.settings.weights.recovery_share(dcm_error, self.leg)

    def posture_cost(
        self, error: Float[Array, " n_hinges"], dcm_error: Float[Array, " 2"]
    ) -> Float[Array, " nv"]:
        """Return the cost of accelerations.

        Args:
            error: Errors of the hinges [rad].
            dcm_error: Error of the divergent component [m].
        """
        own, share = self.settings, self.flywheel_share(dcm_error)
        cost = self._steady_weight + share * (self._weight - self._steady_weight)
        cost[self._neck] *= 1.0 + (error[self._neck - 6] / own.neck_error_scale) ** 2
        trunk, firm, free = self._trunk, self._steady_weight, self._weight
        cost[trunk] = firm[trunk] ** (1.0 - share) * free[trunk] ** share
        cost[trunk] *= 1.0 + share * (error[trunk - 6] / own.trunk_error_scale) ** 2
        return cost

    def posture_acceleration(
        self,
        body: BodyState,
        ref: Instant,
        rate: float,
        swing: Sequence[bool],
        turn_rate: float = 0.0,
    ) -> Float[Array, " nv"]:
        """Return the desired accelerations of pelvis and joints.

        Args:
            ref: The reference at the phase of the gait.
            swing: Which feet swing, right and left.
            turn_rate: Rate of turn of the walk, to the left [rad/s].
        """
        own, joints = self.settings, self.settings.joints
        factor = np.ones(self._toes.shape[1])
        for inside, swings in zip(self._toes, swing, strict=True):
            if swings:
                factor[inside] = joints.swing_toe_factor
        desired = rate * ref.v - body.qvel
        desired[3:6] += turn_rate * body.rotations[1, 2]  # the vertical, in the axes of the pelvis
        error = root_error(ref.q[3:7], body.qpos[3:7])
        stiffness = own.weights.joint_stiffness
        desired[3:6] = stiffness * error + own.weights.joint_damping * desired[3:6]
        gain = joints.time * stiffness
        velocity = gain * (ref.q[7:] - body.qpos[7:])
        desired[6:] = (desired[6:] + factor * velocity) * (factor / joints.time)
        desired += rate**2 * ref.a
        desired[:3] = 0.0
        return desired

    def com_acceleration(
        self,
        body: BodyState,
        ref: Instant,
        rate: float,
        omega: float,
        dcm_error: Float[Array, " 2"],
        cop_offset: Float[Array, " 2"],
        lowering: float,
        contacts: Float[Array, "k 2"],
        ground: float,
        slope: Float[Array, " 2"],
        time: float | None = None,
    ) -> Float[Array, " 3"]:
        """Return the desired acceleration of the centre of mass [m/s²].

        The centre of pressure may be desired outside of the contacts, too.

        What is not said here is as in
        :meth:`~plantigrade.control.gait.tasks.GaitTaskSettings.com_acceleration`.

        Args:
            lowering: Lowering of the body, for far footsteps [m].
            ground: Height of the ground around [m].
            slope: Its rise along x and y, by distance.
            time: To the next touchdown [s]; None where no foot swings.
        """
        own, com, velocity = self.settings, body.com, body.com_velocity
        far = self.flywheel_share(dcm_error) * own.max_cop_distance * self.leg
        desired = own.weights.com_acceleration(
            body, ref, omega, dcm_error, cop_offset, contacts, far
        )
        rate = min(rate, 1.0)
        error = ref.com[2] + ground - lowering - com[2]
        stiffness = own.weights.com_height_stiffness
        rise = float(slope @ velocity[:2])  # of the ground under the body [m/s]
        climb = rate * ref.com_velocity[2] + rise
        recorded = rate**2 * ref.com_acceleration[2]
        lowest = -own.weights.max_vertical_acceleration
        if time is not None and lowering > 0.0:
            needed = 2.0 * (max(error, -lowering) + (rise - velocity[2]) * time) / time**2
            lowest = min(max(needed, -own.max_reaching_descent), lowest)
        back = stiffness * error + 2.0 * sqrt(stiffness) * (climb - velocity[2])
        back = min(max(back, lowest), own.weights.max_vertical_acceleration)
        if time is not None and lowering > 0.0:
            excess = rise - velocity[2] - own.max_landing_speed
            brake = min(excess / max(time, own.min_braking_time), GRAVITY)
            back = max(back, brake) if excess > 0.0 else back
        most = max(recorded, own.weights.max_vertical_acceleration, back)
        desired[2] = min(max(recorded + back, min(recorded, lowest)), most)
        return desired

    def momentum_rows(
        self, body: BodyState, ref: Instant, rate: float, dcm_error: Float[Array, " 2"]
    ) -> Rows:
        """Return rows of the angular momentum: as in the reference, unless the body balances by it.

        Args:
            ref: The reference at the phase of the gait.
            dcm_error: Error of the divergent component [m].
        """
        own, share = self.settings, self.flywheel_share(dcm_error)
        matrix = self.momentum.jacobian(body, 0.0)[:2]
        gain = 0.5 * sqrt(own.weights.com_height_stiffness)  # velocity by error, as of that height
        desired = rate**2 * ref.a + gain * (rate * ref.v - body.qvel)
        weight = ((1.0 - share) * own.momentum_weight) ** 2
        return Rows(matrix, matrix @ desired, weight, "angular momentum")

    def resist_hyperextension(
        self, body: BodyState, ref: Instant, desired: Array, cost: Array
    ) -> None:
        """Let knees that would soon be bent backwards, farther than the reference, resist."""
        own, at, time = self.settings, self._knees, self.settings.knee_stop_time
        angle, speed = body.qpos[at + 1], body.qvel[at]
        excess = np.minimum(ref.q[at + 1], 0.0) - angle - time * speed
        excess = np.maximum(excess, 0.0)
        least = 2.0 * excess / time**2
        desired[at] = np.where(excess > 0.0, np.maximum(desired[at], least), desired[at])
        weight = own.weights.com_weight[2]
        cost[at] += (weight * np.minimum(excess / own.knee_stop_angle, 1.0)) ** 2

    def rotation_rows(
        self,
        body: BodyState,
        points: RigidPoints,
        i: int,
        target: Target,
        normal: Array | None = None,
    ) -> Rows:
        """Return rows that rotate a foot; a stance foot, on its normal, keeps its heading."""
        rows = self._rotation.of(points, i, target).rows(body)
        return rows if normal is None else rows.along(np.eye(3) - normal[:, None] * normal)

    def contact_rows(self, points: RigidPoints, held, gap, normal) -> PointRows:
        """Return rows that bring points to rest on the ground."""
        return self.settings.weights.still(points, held, gap, normal)

    def force_cost(self, held: Bool[Array, " k"], gap: Float[Array, " k"]) -> Float[Array, " k"]:
        """Return the cost of a force at each contact.

        Args:
            held: Which are planned to stand.
            gap: Height of each above the ground [m].
        """
        own, weights = self.settings, self.settings.weights
        hanging = np.maximum(gap / own.hanging_height - 1.0, 0.0)
        more = own.hanging_force_cost * hanging**2
        return weights.force_cost(held) + more
