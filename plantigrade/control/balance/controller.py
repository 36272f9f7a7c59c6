r"""Balance in place: every tick, accelerations, torques and contact forces in one program.

The objectives are those of Eq. 6 of [Park2020]_, after [Macchietto2009]_: follow a reference, move
the centre of mass, hold the points of support (Eq. 7); their angular momentum follows from these
here. The paper then prescribes the accelerations. Here they are found together with forces that the
ground can give, inside friction cones and therefore with the centre of pressure inside the base of
support, and with torques that the person has (:mod:`plantigrade.wbc.whole_body`).
"""

from dataclasses import replace
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.balance.flight import FlightClock, landing_rows
from plantigrade.control.balance.ground_contact import FootContacts, GroundContact, sphere_heights
from plantigrade.control.balance.recovery import Recovery
from plantigrade.control.balance.reference import Reference, ReferenceState, posture_reference
from plantigrade.control.balance.settings import BalanceSettings, JointStopSettings
from plantigrade.control.gait.tasks import within_foot
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import BodyState
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.tasks import LinearMomentumTask
from plantigrade.wbc.whole_body import WholeBody
from plantigrade.world import (
    Command,
    Controller,
    Drawing,
    Rates,
    SimulatedWorld,
    StablePD,
    State,
    Summary,
    Target,
)


class Balance(Controller):
    """Keeps a person on the feet, in a posture or along a reference.

    Args:
        reference: Reference to follow; the posture of the first state if absent.
        settings: Weights, gains, and whether it may step.

    Attributes:
        targets: Offset of the goal of the centre of mass from the reference.
        goal: Goal of the centre of mass at the last tick [m].
    """

    rates = Rates(physics=1000.0, control=100.0)

    def __init__(
        self, reference: Reference | None = None, *, settings: BalanceSettings | None = None
    ):
        self.reference, self.settings = reference, settings or BalanceSettings()
        self._world: SimulatedWorld | None = None
        self.targets = (
            Target("weight forward", -6.0, 8.0, 0.0, "cm"),
            Target("weight to the left", -12.0, 12.0, 0.0, "cm"),
            Target("height", -15.0, 2.0, 0.0, "cm"),
        )

    def summary(self) -> Summary:
        """Return what steps were taken in the last simulation."""
        return Summary(() if self._world is None else self.recovery.sentences())

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return the goal of the centre of mass, and the line to it."""
        if self._world is not state.world:
            return ()
        line = np.array([[state.body.com, self.goal]])
        return (Drawing(name="goal of the centre of mass", points=self.goal[None], lines=line),)

    def _begin(self, state: State) -> None:
        """Make ready for a world."""
        world, human, s = state.world, state.human, self.settings
        self._world = world
        self.contact = GroundContact(world, s.contact)
        self.program = WholeBody(human, armature=world.actuators.armature)
        self._follows = self.reference or posture_reference(world, np.array(state.qpos))
        self._weight = s.joint_weights(human, flies=bool(self._follows.flights))
        self._gain = s.joint_gains.of(human)
        strength = np.abs(np.array(human.model.jnt_actfrcrange[1:])).max(axis=1)
        within = within_foot(human)
        self._damping = np.where(within, s.foot_joint_damping, s.joint_damping * strength)
        self._stiffness = np.where(within, s.foot_joint_stiffness, 0.0)
        self._com = LinearMomentumTask(state.body.mass, weight=s.com_weight)
        self.recovery = Recovery(human, self.contact, s.recovery)
        self._shift = np.zeros(3)
        self._stops = np.array(human.model.jnt_range[1:]).T
        self._flight = FlightClock(self._follows.flights, s.flight)

    def __call__(self, state: State) -> Command:
        """Return torques that keep balance, and springs about the motion they lead to."""
        if self._world is not state.world or state.time == 0.0:
            self._begin(state)
        body, world, s = state.body, state.world, self.settings
        contacts = self.contact.read()
        touches, falls = bool((contacts.gap < 0).any()), bool(body.com_velocity[2] < 0)
        desired = self._follows.at(self._flight.at(state.time, touches, falls))
        if s.stepping:
            contacts = self.recovery.update(state, contacts)
        points = body.rigid_points(contacts.touching.body, contacts.touching.place)
        acceleration, touching = self._com_acceleration(body, desired, contacts), contacts.touching
        stepped = self.recovery.stepped
        if stepped:  # the whole friction where it stops the body
            x, y = (acceleration - body.com_bias_acceleration)[:2]
            touching = replace(touching, along=float(np.arctan2(y, x)))
        rows: list[Rows | PointRows] = [
            self._com.rows(body, acceleration=acceleration),
            *self._stance_rows(contacts, desired, points),
            *self._landing_rows(state, desired, contacts),
        ]
        if stepped:
            rows += self.recovery.rows(state)
        if self._flight.airborne:
            rows += landing_rows(body, desired, self.recovery)
        qacc, weight = self._tracking(state, desired)
        factor = desired.force_cost
        factor = factor[contacts.spheres] if isinstance(factor, np.ndarray) else factor
        loads = desired.contact[contacts.spheres]
        answer = self.program.solve(
            body,
            touching,
            rows,
            desired=qacc,
            weight=weight,
            force_weight=np.where(loads, s.force_weight * factor, s.idle_force_weight),
            passive=world.actuators.passive(state.angles, state.rates),
            points=points,
        )
        step = 1.0 / world.control_rate
        velocity = state.rates + 0.5 * step * answer.qacc[6:]
        target = state.angles + 0.5 * step * velocity
        # The springs act about the plan: what they give now is taken off.
        torque = answer.torque - self._stiffness * (target - state.angles)
        torque -= self._damping * (velocity - state.rates)
        error = body.com - self.goal
        signals = {
            "com_error": hypot(*error[:2]),
            "contacts": float(len(contacts.spheres)),
            "limited": float(answer.limited),
            "solved": float(answer.ok),
            "steps": float(self.recovery.n_begun),
            "opposing": self.recovery.opposing_force(state),
        }
        return StablePD(target, velocity, torque, self._stiffness, self._damping, signals=signals)

    def _tracking(
        self, state: State, desired: ReferenceState
    ) -> tuple[Float[Array, " nv"], Float[Array, " nv"]]:
        """Return the generalised acceleration that leads to the reference, and its weight.

        Once there were steps, the legs are free until the body rests where these have led it.
        """
        body, recovery, s = state.body, self.recovery, self.settings
        error, velocity_error = -body.difference(desired.qpos), desired.qvel - body.qvel
        damping = 2 * np.sqrt(self._gain) * velocity_error
        if not recovery.stepped:
            return desired.qacc + self._gain * error + damping, self._weight
        weight, gain, legs = self._weight.copy(), self._gain.copy(), recovery.legs
        weight[3:6] = s.recovery.upright_weight
        weight[6:][recovery.spine] = s.recovery.spine_weight
        if recovery.rest_angles is None:
            gain[6:][legs] = 0.0
        else:
            error[6:][legs] = (recovery.rest_angles - state.angles)[legs]
        qacc = desired.qacc + gain * error + damping
        slow_at_stops(self._stops, state.angles, state.rates, qacc[6:], weight[6:], s.joint_stops)
        return qacc, weight

    def _com_acceleration(
        self, body: BodyState, desired: ReferenceState, contacts: FootContacts
    ) -> Float[Array, " 3"]:
        """Return the desired acceleration of the centre of mass [m/s²]."""
        s, recovery = self.settings, self.recovery
        assert self._world is not None  # it has begun
        limit = s.com_goal_speed / self._world.control_rate
        error = np.array([0.01 * target.value for target in self.targets]) - self._shift
        self._shift = self._shift + np.minimum(np.maximum(error, -limit), limit)
        self.goal = desired.com_goal(
            recovery.spheres(body),
            contacts.spheres,
            self._shift,
            s.com_centring,
            s.recovery.step.support_margin,
        )
        if recovery.stepped:
            self.goal[2] -= recovery.lowering(body)
        acceleration = s.com_gain * (self.goal - body.com) + s.com_damping * (
            desired.com_velocity - body.com_velocity
        )
        acceleration += desired.com_acceleration
        if recovery.stepped:
            limit = s.recovery.max_vertical_acceleration
            acceleration[:2] = recovery.com_acceleration(body, contacts, self.goal)
            acceleration[2] = np.clip(acceleration[2], -limit, limit)
        return acceleration

    def _stance_rows(
        self, contacts: FootContacts, desired: ReferenceState, points: RigidPoints
    ) -> list[PointRows]:
        """Return the rows of the points that stay where they are."""
        s, stays = self.settings, desired.contact[contacts.spheres]
        if not stays.any():
            return []
        rows = PointRows.still(
            points,
            stays,
            contacts.gap,
            contacts.touching.normal,
            stiffness=s.contact_gain,
            damping=2 * s.contact_gain**0.5,
            weight=s.com_weight,
            drift=contacts.ground_velocity,
        )
        return [rows]

    def _landing_rows(
        self, state: State, desired: ReferenceState, contacts: FootContacts
    ) -> list[Rows]:
        """Return the rows of points that come to the ground."""
        off = desired.contact.copy()
        off[contacts.spheres] = False
        swing = self.recovery.swing
        if swing is not None:
            off[self.recovery.foot_spheres[swing.footstep.side]] = False
        if not off.any():
            return []
        heights, normals = sphere_heights(state, self.contact)
        which = np.flatnonzero(off)
        positions = np.array(state.world.data.geom_xpos)[self.contact.geoms[which]]
        J, velocity, bias = state.body.touched(self.contact.body[which], positions)
        n, s = normals[which], self.settings
        gain, weight = s.contact_gain, s.landing_weight
        if self.recovery.stepped:
            gain, weight = s.recovery.contact_gain, s.recovery.foot_orientation_weight
        right = -gain * heights[which] - 2 * np.sqrt(gain) * np.einsum("kc,kc->k", n, velocity)
        right -= np.einsum("kc,kc->k", n, bias)
        return [Rows(np.einsum("kc,kcv->kv", n, J), right, weight)]


def slow_at_stops(
    stops: Float[Array, "2 n"],
    angles: Float[Array, " n"],
    velocity: Float[Array, " n"],
    acceleration: Float[Array, " n"],
    weight: Float[Array, " n"],
    settings: JointStopSettings,
) -> None:
    """Slow joints near a stop, in place: the program does not know of stops.

    They would come to rest at it, the more firmly the nearer they are. They are not led away from
    it: a leg that stands far behind has its ankle there, and would push the body over.

    Args:
        stops: Least and greatest angle of every joint [rad].
        angles: Joint angles [rad].
        velocity: Joint velocities [rad/s].
        acceleration: Desired joint accelerations [rad/s²].
        settings: How near, and how firmly.
    """
    gain, (low, high) = settings.gain, stops
    damping = 2 * np.sqrt(gain) * velocity
    least, most = gain * (low - angles) - damping, gain * (high - angles) - damping
    nearness = 1.0 - np.minimum(angles - low, high - angles) / settings.distance
    near = nearness > 0.0
    acceleration[near] = np.minimum(np.maximum(acceleration, least), most)[near]
    firm = settings.weight * np.minimum(nearness, 1.0) ** 2
    weight[near] = np.maximum(weight, firm)[near]
