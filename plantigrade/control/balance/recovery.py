"""Recovery steps in a world: when one begins and ends, and what the tick of balance does then."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.balance.ground_contact import FootContacts, GroundContact, sphere_heights
from plantigrade.control.gait.disturbance import DisturbanceEstimator, DisturbanceSettings
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.pendulum_state import PendulumState
from plantigrade.control.gait.person import leg_length
from plantigrade.control.gait.step import StepPlanner, StepSettings
from plantigrade.control.gait.support import beyond, nearest
from plantigrade.control.gait.swing_foot import SwingFoot, SwingSettings
from plantigrade.control.gait.tasks import GaitTaskSettings, leg_joints
from plantigrade.kinematics.state import CROSS, BodyState, PointSet
from plantigrade.models import Human
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks import AlignmentTask, PointTask
from plantigrade.wbc.tasks.point import axis_error
from plantigrade.world import State

SPINE_JOINTS = ("lumbar", "thorax", "neck")
OVER_GROUND = np.eye(3)[:2]


@dataclass(frozen=True, kw_only=True)
class RecoverySettings:
    """Recovery steps of a person who stands."""

    step: StepSettings = StepSettings()
    """Planner of the steps."""
    swing: SwingSettings = SwingSettings()
    """Motion of the swing foot."""
    disturbance: DisturbanceSettings = DisturbanceSettings()
    """Estimator of the disturbance."""
    support_height: float = LoadSettings.max_height
    """Height up to which a sphere counts as support [m]; as in recordings. A foot that is lifted a
    little by leaning to the other one can still be stood upon."""
    foot_weight: float = 500.0
    """Weight of the position of a foot [per (m/s²)²]. Chosen (±20 %: deviation 10 %)."""
    foot_orientation_weight: float = 10.0
    """Weight of the orientation of a foot [per (rad/s²)²], and of points that come to the ground
    once there were steps [per (m/s²)²]: the heel of a foot that trails in a long stance cannot come
    down, and must not outweigh balance. Chosen (±20 %: deviation 8 %)."""
    foot_orientation_gain: float = GaitTaskSettings.rotation_stiffness
    """Stiffness of the orientation of a foot, critically damped [1/s²]; as in walking."""
    foot_stopping_rate: float = GaitTaskSettings.foot_stiffness**0.5
    """Rate at which a foot about to stand comes to rest over the ground [1/s]; that of feet in
    walking."""
    upright_weight: float = 50.0
    """Weight of pelvis and trunk upright [per (rad/s²)²]. Hips and arms may help, but a deep bow
    leaves nothing for the next step."""
    trunk_stiffness: float = GaitTaskSettings.joint_stiffness
    """Stiffness of the lean of the trunk, critically damped [1/s²]; as of other joints."""
    spine_weight: float = 5.0
    """Weight of joints of trunk and neck [per (rad/s²)²]. Arms may swing; a trunk that twists takes
    the pelvis along when it reaches its stops."""
    stance_cop_extent: float = 0.8
    """Centre of pressure of the stance foot, from its middle (0) to its edge (1). Chosen: with 1,
    pushes of 260 N to eight sides took 21 steps in place of 13."""
    momentum_reach: float = 0.05
    """Distance of desired pressure beyond the support: arms and trunk give the rest [m]. Chosen
    (±20 %: deviation 37 %)."""
    contact_gain: float = GaitTaskSettings.hanging_stiffness
    """Stiffness of the height of points that come to the ground, once there were steps [1/s²]; as
    of a standing foot that hangs off the ground, in walking."""
    max_vertical_acceleration: float = GaitTaskSettings.max_vertical_acceleration
    """Greatest vertical acceleration of the centre of mass [m/s²]; as in walking. A body that sinks
    fast has no load on its feet, and no friction that stops a fall."""
    crouch: float = SwingSettings.clearance
    """Lowering of the centre of mass once a step began [leg lengths]: as far as a leg is shortened
    by the foot that it lifts."""


@dataclass(frozen=True)
class TakenStep:
    """A step that was taken: lift-off and touchdown [s], foot, length ahead and to the left [m]."""

    start: float
    end: float
    side: int
    forward: float
    left: float

    def __str__(self) -> str:
        parts = [
            f"{100 * abs(length):.0f} cm {positive if length > 0 else negative}"
            for length, positive, negative in (
                (self.forward, "forward", "back"),
                (self.left, "to the left", "to the right"),
            )
            if round(100 * abs(length))
        ]
        foot, way = ("right", "left")[self.side], " and ".join(parts) or "on the spot"
        duration = 1e3 * (self.end - self.start)
        return f"{foot} foot at {self.start:.2f} s, {way}, in {duration:.0f} ms"


class Recovery:
    """Takes steps when standing in place can no longer succeed.

    Attributes:
        swing: The foot in the air; None where both stand.
        n_begun: Number of steps that began.
        taken: The steps that ended.
        rest_angles: Joint angles in which the body came to rest where the steps have led it, held
            from then on [rad]; None before.
        foot_spheres: Which spheres belong to each foot, right first.
    """

    def __init__(self, human: Human, contact: GroundContact, settings: RecoverySettings):
        self.human, self.contact, self.settings = human, contact, settings
        self.swing: SwingFoot | None = None
        self.n_begun, self._touchdown = 0, -np.inf
        self.rest_angles: Array | None = None
        self.taken: list[TakenStep] = []
        self.disturbance = DisturbanceEstimator(settings.disturbance)
        sides = [site.side for site in contact.world.sites if site.side]
        self.foot_spheres = np.array([[side == s for side in sides] for s in SIDES])
        self.feet = human.both("foot")
        owners = [human.body_names[i - 1] for i in contact.body]
        local = np.array(contact.model.geom_pos)[contact.geoms]
        self._spheres = PointSet(human, owners, local)
        stands = BodyState(human, human.standing())
        middles = [
            stands.rotation(f).T @ (self.spheres(stands)[own].mean(axis=0) - stands.origin(f))
            for f, own in zip(self.feet, self.foot_spheres, strict=True)
        ]
        self._soles = PointSet(human, [f"foot_{side}" for side in SIDES], np.array(middles))
        self._up = stands.rotation(human.trunk).T @ np.array([0.0, 0.0, 1.0])
        self.leg_length = leg_length(human)
        self._stance_width = float(np.linalg.norm(np.diff(self.soles(stands)[:, :2], axis=0)))
        s = settings
        gain, weight = s.foot_orientation_gain, s.upright_weight
        self._trunk = AlignmentTask(human.trunk, stiffness=s.trunk_stiffness, weight=weight)
        self._orientation, self._position = [], []
        for i, foot in enumerate(self.feet):
            turn = AlignmentTask(foot, stiffness=gain)
            turn.weight = s.foot_orientation_weight
            self._orientation.append(turn)
            self._position.append(PointTask(self._soles, which=i, weight=s.foot_weight))
        self.planner = StepPlanner(self.leg_length, settings.step)
        self.spine = np.array([name.startswith(SPINE_JOINTS) for name in human.coordinates])
        self.legs = leg_joints(human)

    @property
    def stepped(self) -> bool:
        """Whether a foot was lifted: the feet are elsewhere than at the start."""
        return self.n_begun > 0

    def sentences(self) -> tuple[str, ...]:
        """Return in words what steps were taken."""
        n = len(self.taken)
        count = "One recovery step" if n == 1 else f"{n} recovery steps"
        return (f"{count}: {'; '.join(map(str, self.taken))}.",) if n else ()

    def opposing_force(self, state: State) -> float:
        """Return the force with which the feet push against each other along the ground [N].

        Positive where they push apart, negative where they pull together; forces that cancel do not
        move the person.
        """
        forces = [state.contact_force[: on.size][on, :2].sum(axis=0) for on in self.foot_spheres]
        between = np.diff(self.soles(state.body)[:, :2], axis=0)[0]
        between /= max(float(np.linalg.norm(between)), 1e-9)
        right, left = float(forces[0] @ between), float(-forces[1] @ between)
        return min(right, left) if min(right, left) > 0 else max(min(right, 0.0), min(left, 0.0))

    def spheres(self, body: BodyState) -> Float[Array, "n_sites 3"]:
        """Return the positions of the spheres of the feet [m]."""
        return body.position(self._spheres)

    def soles(self, body: BodyState) -> Float[Array, "2 3"]:
        """Return the positions of the middles of the soles [m]."""
        return body.position(self._soles)

    def update(self, state: State, contacts: FootContacts) -> FootContacts:
        """Begin, go on with or end a step; return the contacts of the feet that carry."""
        step = 1.0 / state.world.control_rate
        self.disturbance.update(state.body, state.contact_force, step)
        body, spheres = state.body, self.spheres(state.body)
        now = self.pendulum(body, spheres, contacts)
        touches = np.array(
            [(contacts.gap[own[contacts.spheres]] <= 0).any() for own in self.foot_spheres]
        )
        if self.swing is not None:
            side = self.swing.footstep.side
            if self.swing.may_end(state.time) and touches[side]:
                step = self.soles(body)[side, :2] - self._lift_off
                forward, left = float(step @ now.heading), float(step @ now.left)
                self.taken.append(TakenStep(self.swing.start, state.time, side, forward, left))
                self.swing, self._touchdown = None, state.time
            else:
                velocity = body.velocity(self._soles)[side, :2]
                self.swing = self.swing.replanned(now, state.time, velocity)
        elif touches.any():
            self._stand(state, now, spheres, touches)
        if self.swing is None:
            return contacts
        return contacts.at(~self.foot_spheres[self.swing.footstep.side][contacts.spheres])

    def _stand(self, state: State, now: PendulumState, spheres: Array, touches: Array) -> None:
        """Come to rest on both feet, or begin a step with the better of the two."""
        s, since = self.settings, state.time - self._touchdown
        if since <= s.step.load_transfer_duration:
            return
        slow = np.linalg.norm(state.body.com_velocity) < s.step.rest_speed
        if self.rest_angles is None and self.stepped and slow:
            self.rest_angles = np.array(state.angles)
        near = sphere_heights(state, self.contact)[0] < s.support_height
        support = spheres[touches @ self.foot_spheres | near, :2]
        threshold = s.step.capture_margin if self.stepped else s.step.capture_threshold
        if beyond(support, now.capture_point + now.disturbance_shift) > threshold:
            footstep = self.planner.plan(now, [side for side in (0, 1) if touches[1 - side]])
            self.swing = SwingFoot(self.planner, s.swing, footstep, state.time)
            self.rest_angles, self._lift_off = None, now.feet[footstep.side]
            self.n_begun += 1

    def pendulum(self, body: BodyState, spheres: Array, contacts: FootContacts) -> PendulumState:
        """Return the person as a pendulum."""
        place = contacts.touching.place
        ground = float(np.mean(place[:, 2])) if len(place) else 0.0
        soles, feet = [spheres[own] for own in self.foot_spheres], self.soles(body)[:, :2]
        margin, disturbance = self.settings.step.support_margin, self.disturbance.acceleration
        return PendulumState.of(body, ground, soles, feet, _heading(body), margin, disturbance)

    def lowering(self, body: BodyState) -> float:
        """Return how much lower the centre of mass is for the legs to reach the feet [m].

        Measured over the ground: a pelvis that leans brings no foot nearer.
        """
        soles = self.soles(body).copy()
        if self.swing is not None:
            soles[self.swing.footstep.side, :2] = self.swing.footstep.position
        ahead, offset = _heading(body), (soles - body.com)[:, :2]
        forward, left = offset @ ahead, offset @ np.array([-ahead[1], ahead[0]])
        aside = np.maximum(np.abs(left) - 0.5 * self._stance_width, 0.0)
        crouch = self.settings.crouch * self.leg_length
        return self.planner.lowering(float(np.hypot(forward, aside).max())) + crouch

    def com_acceleration(
        self, body: BodyState, contacts: FootContacts, goal: Float[Array, " 3"]
    ) -> Float[Array, " 2"]:
        """Return the horizontal acceleration of the centre of mass once there were steps [m/s²].

        While a foot is in the air, pressure is as near to the capture point as the other allows.
        With both on the ground it leads the capture point to the goal of the centre of mass
        ([Englsberger2011]_), as far as the feet allow and a little more: arms and trunk help.
        """
        s, spheres = self.settings, self.spheres(body)
        now = self.pendulum(body, spheres, contacts)
        if self.swing is not None:
            side, edge = 1 - self.swing.footstep.side, s.stance_cop_extent
            pressure = edge * now.pressure[side] + (1 - edge) * now.feet[side]
        else:
            desired = now.capture_point + now.disturbance_shift
            desired = desired + (now.capture_point - goal[:2])  # [Englsberger2011]_, gain 1
            support = spheres[contacts.spheres, :2] if len(contacts.spheres) else now.feet
            pressure = nearest(support, desired, -s.momentum_reach)
        return now.omega**2 * (now.com - pressure)

    def rows(self, state: State) -> list[Rows]:
        """Return the rows of trunk and feet once there were steps."""
        body = state.body
        if self.swing is None:
            both = [rows for side in (0, 1) for rows in self._stance_rows(state, side)]
            return [self._trunk_rows(body), *both]
        side = self.swing.footstep.side
        position, velocity = self.soles(body)[side], body.velocity(self._soles)[side]
        target = np.array([*self.swing.footstep.position, position[2]])
        height = self._sole_height(state, target)
        acceleration = self.swing.acceleration(state.time, position, velocity, height)
        return [
            self._trunk_rows(body),
            self._position[side].rows(body, acceleration=acceleration),
            self._orientation_rows(state, side),
            *self._stance_rows(state, 1 - side),
        ]

    def _trunk_rows(self, body: BodyState) -> Rows:
        """Return the rows that keep the trunk from leaning."""
        x, y, _ = body.rotation(self._trunk.body) @ self._up
        self._trunk.target = np.array([y, -x, 0.0])  # the axis about which it leans, with its sine
        return self._trunk.rows(body).along(OVER_GROUND)

    def _stance_rows(self, state: State, side: int) -> list[Rows]:
        """Return the rows of a foot that stands, or is about to: flat, and at rest."""
        stop = -self.settings.foot_stopping_rate * state.body.velocity(self._soles)[side]
        rows = self._position[side].rows(state.body, acceleration=stop)
        return [self._orientation_rows(state, side), rows.along(OVER_GROUND)]

    def _orientation_rows(self, state: State, side: int) -> Rows:
        """Return the rows that lay a foot along the ground; a swinging one faces forward, too."""
        body, foot = state.body, self.feet[side]
        R = body.rotation(foot)
        normal = state.world.ground.normal_at(body.origin(foot))
        swings = self.swing is not None and self.swing.footstep.side == side
        ahead = body.rotation(1)[:, 0] if swings else R[:, 0]
        ahead = ahead - (ahead @ normal) * normal
        ahead /= np.sqrt(ahead @ ahead)
        desired = np.array([ahead, (normal @ CROSS).reshape(3, 3) @ ahead, normal]).T
        self._orientation[side].target = axis_error(desired, R)
        return self._orientation[side].rows(body)

    def _sole_height(self, state: State, position: Float[Array, " 3"]) -> float:
        """Return the height of the middle of a sole that stands at a position [m]."""
        ground = state.world.ground
        level = ground.under(position) - position[:2] @ ground.normal[:2]
        radius = self.contact.model.geom_size[self.contact.geoms[0], 0]
        return float(level / ground.normal[2]) + float(radius)


def _heading(body: BodyState) -> Float[Array, " 2"]:
    """Return the direction over the ground in which the pelvis faces."""
    ahead = body.rotation(1)[:2, 0]
    return ahead / np.linalg.norm(ahead)
