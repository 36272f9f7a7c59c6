r"""Balance by momentum: every tick, accelerations, torques and contact forces in one program.

The objectives are those of Eq. 6 of [Park2020]_, after [Macchietto2009]_: follow a reference, move
the centre of mass, bring the angular momentum to rest, hold the points of support (Eq. 7). The
paper then prescribes the accelerations. Here they are found together with forces that the ground
can give, inside friction cones and therefore with the centre of pressure inside the base of
support, and with torques that the person has (:mod:`plantigrade.wbc.whole_body`).
"""

from dataclasses import replace
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.balance.carried import held
from plantigrade.control.balance.flight import FlightClock, landing_rows
from plantigrade.control.balance.goal import goal_of
from plantigrade.control.balance.ground_contact import GroundContact, Standing, heights
from plantigrade.control.balance.recovery import PELVIS, SINKS, SPINE, Recovery
from plantigrade.control.balance.reference import Reference, Wanted
from plantigrade.control.balance.weights import FOOT, Weights
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import State as BodyState
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.whole_body import WholeBody
from plantigrade.world import Command, Drawing, StablePD, State, Target, World

LIGHT_DAMPING = 0.012
"""Damping about the planned rates, of a joint by its greatest torque [s]."""
FOOT_DAMPING, FOOT_STIFFNESS = 0.5, 30.0
"""Within a foot, damping and stiffness about the plan [N m s/rad, N m/rad]."""
SHIFTING = 0.1
"""How fast the centre of mass is led to where a target has it [m/s]."""
NEAR_STOP, STOP, STOP_GAIN = 0.15, 100.0, 400.0
"""So near to its stop a joint is slowed [rad], by what weight at the stop, and stiffness [1/s²]."""
STEPPED_GAIN, STEPPED_LEVEL = 800.0, 10.0
"""Stiffness with which points come to the ground once there were steps [1/s²], and their weight:
the heel of a foot that trails in a long stance cannot, and must not outweigh balance."""


class Balance:
    """Keeps a person on the feet, in a posture or along a reference.

    Args:
        reference: What is to be done; the posture of the first state if absent.
        weights: What counts how much.
        stepping: Whether a step is taken where standing in place can no longer succeed.

    Attributes:
        targets: Where the centre of mass is to be, from where the reference has it.
    """

    rate, control_rate = 1000.0, 100.0
    """Steps of the physics and of the controller [1/s], where no others are asked for."""

    def __init__(
        self,
        reference: Reference | None = None,
        weights: Weights | None = None,
        *,
        stepping: bool = False,
    ):
        self.reference, self.weights, self.stepping = reference, weights or Weights(), stepping
        self._world: World | None = None
        self.targets = (
            Target("weight forward", -6.0, 8.0, 0.0, "cm"),
            Target("weight to the left", -12.0, 12.0, 0.0, "cm"),
            Target("height", -15.0, 2.0, 0.0, "cm"),
        )

    def said(self) -> tuple[str, ...]:
        """Return what steps were taken in the last simulation."""
        return () if self._world is None else self.recovery.said()

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return where the centre of mass is to be, and the way there."""
        if self._world is not state.world:
            return ()
        way = np.array([[state.body.com, self.goal]])
        return (Drawing(name="centre of mass wanted", points=self.goal[None], lines=way),)

    def _begin(self, state: State) -> None:
        """Make ready for a world."""
        world, human = state.world, state.human
        self._world, w = world, self.weights
        self.contact = GroundContact(world, w.friction)
        self.program = WholeBody(human, armature=world.actuators.armature)
        self._weight, self._gain = w.joints(human), w.gains(human)
        self._slowing = 2 * np.sqrt(self._gain)
        self._following = self.reference or held(world, np.array(state.qpos))
        most = np.abs(np.array(human.model.jnt_actfrcrange[1:])).max(axis=1)
        within = np.array([n.startswith(FOOT) for n in human.coordinates])
        self._damping = np.where(within, FOOT_DAMPING, LIGHT_DAMPING * most)
        self._stiffness = np.where(within, FOOT_STIFFNESS, 0.0)
        self.recovery = Recovery(human, self.contact)
        self._shift = np.zeros(3)
        self._stops = np.array(human.model.jnt_range[1:]).T
        self._flight = FlightClock(getattr(self._following, "flights", ()))

    def __call__(self, state: State) -> Command:
        """Return torques that keep balance, and springs about the motion they lead to."""
        if self._world is not state.world or state.time == 0.0:
            self._begin(state)
        body, world, w = state.body, state.world, self.weights
        standing = self.contact.read()
        touches, falls = bool((standing.gap < 0).any()), bool(body.com_velocity[2] < 0)
        wanted = self._following.at(self._flight.at(state.time, touches, falls))
        if self.stepping:
            self.recovery.feel(state)
            standing = self.recovery.look(state, standing)
        points = body.rigid_points(standing.touching.body, standing.touching.place)
        centre, touching = self._centre(body, wanted, standing), standing.touching
        if self.recovery.stepped:  # the whole friction where it stops the body
            way = centre.right[:2]
            touching = replace(touching, along=float(np.arctan2(way[1], way[0])))
        tasks = [
            centre,
            momentum_rows(body, w),
            self._held(standing, wanted, points),
            *self._lowered(state, wanted, standing),
            *(self.recovery.rows(state) if self.recovery.stepped else []),
            *(landing_rows(body, wanted, self.recovery) if self._flight.airborne else []),
        ]
        weight, gain = self._weight, self._gain
        if self.recovery.stepped:
            weight, gain = weight.copy(), gain.copy()
            weight[3:6] = PELVIS
            if self.recovery.settled is None:
                gain[6:][self.recovery.legs] = 0.0
            weight[6:][self.recovery.spine] = SPINE
        tracked = self._tracked(body, wanted, gain)
        if self.recovery.stepped:
            kept_from_stops(self._stops, state.angles, state.rates, tracked[6:], weight[6:])
        dear = wanted.dear[standing.site] if isinstance(wanted.dear, np.ndarray) else wanted.dear
        cost = np.where(wanted.presses[standing.site], w.force * dear, w.unasked)
        passive = world.actuators.passive(state.angles, state.rates)
        answer = self.program.solve(
            body,
            touching,
            [t for t in tasks if t is not None],
            wanted=tracked,
            weight=weight,
            force_weight=cost,
            passive=passive,
            points=points,
        )
        step = 1.0 / world.control_rate
        rate = state.rates + 0.5 * step * answer.qacc[6:]
        target = state.angles + 0.5 * step * rate
        # The springs act about the plan: what they give now is taken off.
        torque = answer.torque - self._stiffness * (target - state.angles)
        torque -= self._damping * (rate - state.rates)
        error = body.com - self.goal
        signals = {
            "com_error": hypot(*error[:2]),
            "contacts": float(len(standing.site)),
            "limited": float(answer.limited),
            "solved": float(answer.ok),
            "steps": float(self.recovery.steps),
            "opposing": self.recovery.opposing(state),
        }
        return StablePD(target, rate, torque, self._stiffness, self._damping, signals=signals)

    def _tracked(self, body: BodyState, wanted: Wanted, gain: Array) -> Float[Array, " nv"]:
        """Return the accelerations that lead to the reference."""
        off, slow = -body.difference(wanted.qpos), wanted.qvel - body.qvel
        if self.recovery.settled is not None:
            legs = self.recovery.legs
            off[6:][legs] = (self.recovery.settled - body.qpos[7:])[legs]
        return wanted.qacc + gain * off + self._slowing * slow

    def _centre(self, body: BodyState, wanted: Wanted, standing: Standing) -> Rows:
        """Return the rows of the centre of mass."""
        w = self.weights
        assert self._world is not None  # it has begun
        far = SHIFTING / self._world.control_rate
        off = np.array([0.01 * target.value for target in self.targets]) - self._shift
        self._shift = self._shift + np.minimum(np.maximum(off, -far), far)
        now = self.recovery.spheres(body)
        self.goal = goal_of(wanted, now, standing.site, self._shift, w.central)
        if self.recovery.stepped:
            self.goal[2] -= self.recovery.lowered(body)
        asked = w.com_gain * (self.goal - body.com) + w.com_damping * (
            wanted.com_velocity - body.com_velocity
        )
        asked += wanted.com_acceleration
        if self.recovery.stepped:
            asked[:2] = self.recovery.centre(body, standing, self.goal)
            asked[2] = np.clip(asked[2], -SINKS, SINKS)
        return Rows(body.mass_matrix[:3] / body.mass, asked - body.com_bias_acceleration, w.com)

    def _held(self, standing: Standing, wanted: Wanted, points: RigidPoints) -> PointRows | None:
        """Return the rows of the points that are to stay where they are."""
        w, stays = self.weights, wanted.presses[standing.site]
        if not stays.any():
            return None
        damping = 2 * np.sqrt(w.contact_gain)
        asked = damping * (standing.drift - points.velocity) - points.bias
        fall = w.contact_gain * np.maximum(standing.gap, 0.0)
        asked -= fall[:, None] * standing.touching.normal
        return PointRows(points, stays, asked, w.contact)

    def _lowered(self, state: State, wanted: Wanted, standing: Standing) -> list[Rows]:
        """Return the rows of points that are to come to the ground."""
        w = self.weights
        off = wanted.presses.copy()
        off[standing.site] = False
        if self.recovery.swing is not None:
            off[self.recovery.own[self.recovery.swing.step.side]] = False
        if not off.any() or not w.level:
            return []
        gap, normal = heights(state, self.contact)
        which = np.flatnonzero(off)
        place = np.array(state.world.data.geom_xpos)[self.contact.geoms[which]]
        J, velocity, bias = state.body.touched(self.contact.body[which], place)
        n = normal[which]
        k, weight = w.level_gain, w.level
        if self.recovery.stepped:
            k, weight = STEPPED_GAIN, STEPPED_LEVEL
        asked = -k * gap[which]
        asked -= 2 * np.sqrt(k) * np.einsum("kc,kc->k", n, velocity)
        asked -= np.einsum("kc,kc->k", n, bias)
        return [Rows(np.einsum("kc,kcv->kv", n, J), asked, weight)]


def momentum_rows(body: BodyState, weights: Weights) -> Rows:
    r"""Return the rows that bring the angular momentum to rest, over body mass.

    With the rows of the equations of motion of the root, linear :math:`l` and angular :math:`a`,
    :math:`\dot L = R (M_a \dot v + h_a) - (c - p) \times (M_l \dot v + h_l)`.
    """
    x, y, z = body.com - body.qpos[:3]
    lever = np.empty((3, 6))
    lever[:, :3], lever[:, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]], body.rotation(1)
    lever /= body.mass
    asked = -weights.momentum_damping / body.mass * body.angular_momentum
    asked -= lever @ body.bias[:6]
    return Rows(lever @ body.mass_matrix[:6], asked, weights.momentum)


def kept_from_stops(
    stops: Float[Array, "2 n"],
    angles: Float[Array, " n"],
    rates: Float[Array, " n"],
    asked: Float[Array, " n"],
    weight: Float[Array, " n"],
) -> None:
    """Let joints near a stop not run into it, in place: the program does not know of stops.

    They are slowed so that they would come to rest at it, the more firmly the nearer they are, and
    not led away from it: a leg that stands far behind has its ankle there, and would push the body
    over.

    Args:
        stops: Least and greatest angle of every joint [rad].
        angles: Where the joints are [rad].
        rates: How fast they are [rad/s].
        asked: Their wanted accelerations [rad/s²].
        weight: Of those.
    """
    low, high = stops
    slowing = 2 * np.sqrt(STOP_GAIN) * rates
    least, most = STOP_GAIN * (low - angles) - slowing, STOP_GAIN * (high - angles) - slowing
    near = 1.0 - np.minimum(angles - low, high - angles) / NEAR_STOP
    at = near > 0.0
    asked[at] = np.minimum(np.maximum(asked, least), most)[at]
    weight[at] = np.maximum(weight, STOP * np.minimum(near, 1.0) ** 2)[at]
