"""The step plan of a walk: the next footstep, and the error of the centre of mass."""

from collections.abc import Callable
from dataclasses import replace
from math import atan, cos, exp, sin, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.divergent import effective_pivot
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.person import GaitPerson
from plantigrade.control.gait.phase import Foot, GaitState
from plantigrade.control.gait.tasks import heading
from plantigrade.control.pendulum.footstep import FootReach, Footstep, next_footstep
from plantigrade.control.pendulum.landing_laws import LAWS, ReferenceTouchdown
from plantigrade.control.pendulum.push_memory import PushMemory
from plantigrade.control.pendulum.reference import ScaledReference
from plantigrade.control.pendulum.settings import PendulumSettings
from plantigrade.control.pendulum.swing import Height, detours
from plantigrade.control.pendulum.turn import PredictedTurn
from plantigrade.kinematics.state import BodyState
from plantigrade.spatial.conventions import nearest_right_angle

MIN_TIME_LEFT = 0.01  # [s] to touchdown: keeps the growth of errors until then finite

Foothold = Callable[[int, Array, Array, float], Array]
"""Shift of a footstep to where a sole lies well [m]: side, footstep, stance foot [m], time [s]."""


class StepPlan:
    """The plan of one walk, made anew at every tick.

    Args:
        gait: Phase and feet of the walk; its swing foot is led to the footstep.
        step: Time from one tick to the next [s].
        settings: The numbers of the controller.

    Attributes:
        dcm_error: Error of the divergent component of motion, world [m].
        offset: Load-weighted offset of the stance feet from the reference, world [m].
        cop_offset: Offset of the centre of pressure for feet that stood before a turn, world [m].
        push: What the walk knows of the last push.
        lowering: Lowering of the body, for legs to reach their footsteps [m].
        turn_rate: Rate of turn, to the left [rad/s].
        predicted_turn: Returns the turn until a touchdown in a time [s].
        foot_angle: Rotation of the swing foot into the turn [rad].
        axes: Axes of the body in the walk, ahead and to the left, as columns (:func:`body_axes`).
    """

    def __init__(
        self,
        gait: GaitState,
        reference: ScaledReference,
        person: GaitPerson,
        step: float,
        settings: PendulumSettings,
    ):
        self.gait, self.reference, self.person, self.step = gait, reference, person, step
        self.settings = settings
        self.dcm_error, self.offset, self.axes = np.zeros(2), np.zeros(3), np.eye(2)
        self.cop_offset = np.zeros(2)
        self.lowering = self.turn_rate = self.foot_angle = 0.0
        self.predicted_turn: Callable[[float], PredictedTurn] = lambda time: PredictedTurn()
        self._turned = np.zeros(2)
        leg, stride = person.leg_length, settings.speed.stride_time
        self.push = PushMemory(leg, step, gait.settings.return_rate, stride, settings.push)
        self._crossing = 0  # the way on which the swing foot crosses
        lowered = settings.plan.recovery_lowering * leg
        rows = reference.recorded.rows
        crouched = person.least_flexion(rows.q, rows.foot_position) >= lowered
        self._recovery_lowering = 0.0 if crouched else lowered  # [m]

    def update(
        self,
        body: BodyState,
        ref: Instant,
        feet: Float[Array, "2 3"],
        slope: Float[Array, " 2"],
        ground: Height,
        disturbance: Float[Array, " 2"],
        foothold: Foothold | None = None,
    ) -> Footstep | None:
        r"""Return the next footstep; None where no single foot swings.

        A disturbance is expected to decay with the time constant of the pendulum. An acceleration
        :math:`a \, e^{-\omega t}` does to the walk what a velocity of :math:`a / (2 \omega)` does.

        Args:
            ref: The reference at the phase of the gait.
            feet: Positions of the feet, world [m].
            slope: Rise of the ground about the person along x and y, by distance.
            ground: Height of the ground at a position [m].
            disturbance: Acceleration of the person by it [m/s²].
            foothold: Shifts footsteps on uneven ground.
        """
        gait, omega = self.gait, self.reference.omega
        velocity = body.com_velocity[:2] + disturbance / (2.0 * omega)
        first, beta, offsets, self.offset = gait.load_offsets()
        push = self.push
        path = push.path_offset(self.offset[:2], bool(self.turn_rate))
        push.feel(disturbance)
        self.cop_offset = np.zeros(2)
        self._turned += self.turn_rate * self.step
        single = gait.single_support
        self.lowering *= 1.0 - self.step / self.settings.tasks.weights.rise_time
        if self.recovery_share >= 1.0 and push.felt:
            self.lowering = max(self.lowering, self._recovery_lowering)
        if single is None:
            self._crossing = 0
            self._without_swing(body, ref, velocity, feet, ground, path, (first, beta, offsets))
            return None
        return self._with_swing(*single, body, ref, velocity, feet, slope, ground, path, foothold)

    def _without_swing(self, body, ref, velocity, feet, ground, path, carried) -> None:
        """Find the error of the divergent component in double support, or in flight."""
        gait, omega, footsteps = self.gait, self.reference.omega, self.settings.footsteps
        for f in gait.stance_feet:
            k = SIDES.index(f.side)
            if len(gait.stance_feet) == 1 or feet[k, 0] > feet[1 - k, 0]:
                self._lower(ground, body.com[:2], feet[k, :2], ref.com, ref.foot_position[k])
        xi = body.com[:2] + velocity / omega
        error = xi - (ref.com + ref.com_velocity / omega)[:2] - path
        error = error - [0.0, self.predicted_turn(0.0).lateral_offset]
        if not gait.stance_feet:
            for f in gait.feet:
                if f.stance is not None:
                    left = (f.touchdown - gait.phase) / self.reference.cadence
                    f.swing.lead(error + path, left, self.step)
            self.dcm_error = np.zeros(2)
            return
        first, beta, offsets = carried
        last = gait.newest_stance(first)
        known, later = footsteps.split(first, beta, last + 1)
        later *= footsteps.offset_decay
        newest = gait.offset(last)[:2] - path
        self.dcm_error = error - beta[known] @ (offsets[known, :2] - path) - later * newest

    def _with_swing(
        self, foot: Foot, other: Foot, body, ref, velocity, feet, slope, ground, path, foothold
    ) -> Footstep:
        """Plan the footstep of a swing foot, and lead the foot to it."""
        gait, reference, settings = self.gait, self.reference, self.settings
        omega = reference.omega
        assert foot.stance is not None and other.stance is not None
        i, k = (SIDES.index(each.side) for each in (foot, other))
        left = max(foot.touchdown - gait.phase, MIN_TIME_LEFT) / reference.cadence
        then = reference.at(foot.touchdown)
        turn = self.predicted_turn(left)
        self.foot_angle = turn.foot_angle
        touchdown = self._touchdown(foot.touchdown, foot.stance, then, i, path, slope, turn)
        # At touchdown the walk has another heading.
        com, axes = body.com[:2], turned_axes(turn.angle)
        here = com + (feet[:, :2] - com) @ axes.T
        stance_foot = then.foot_position[k, :2] + gait.offset(other.stance)[:2]
        stance_foot = com + axes @ (stance_foot - com)
        self.axes = body_axes(then.q[3:7])
        apart = (touchdown.footstep - touchdown.stance_foot) @ self.axes[:, 1]
        lands = com + (touchdown.footstep - com) @ axes
        own = np.array([body.human.body(f"foot_{foot.side}")])
        foot_velocity = body.rigid_points(own, feet[[i]]).velocity[0, :2]
        level = float(then.foot_position[i, 2]) + ground(np.append(lands, 0.0))
        reach = replace(
            self._reach(foot, body, axes, foot.side_sign * float(apart), level),
            nominal=touchdown.footstep - stance_foot,
            swing_offset=here[i] - touchdown.footstep,
            foot_velocity=axes @ foot_velocity,
            offset=axes @ foot.swing.offset - path,
            may_cross=not turn.angle,
            way_taken=self._crossing if self.push.recovering else 0,
        )
        pivot = self._pivot(ref, then, exp(omega * left), k, feet)
        self._turned[i] = -self.foot_angle  # at touchdown
        found = next_footstep(
            LAWS[settings.law],
            com,
            axes @ velocity,
            com + axes @ (pivot - com),
            stance_foot,
            left,
            touchdown,
            reach,
        )
        self._crossing = found.crossing
        planned = touchdown.footstep + settings.footsteps.offset_decay * (self.offset[:2] - path)
        decay = exp(-omega * found.time) * touchdown.later_weight
        self.dcm_error = decay * (found.unconstrained - planned)
        self._lower(ground, found.com, found.position, then.com, then.foot_position[i])
        found = replace(
            found,
            position=com + (found.position - com) @ axes,
            unconstrained=com + (found.unconstrained - com) @ axes,
        )
        if foothold is not None:
            shift = foothold(i, found.position, feet[k, :2], found.time)
            found = replace(found, position=found.position + shift)
            self.dcm_error = self.dcm_error - decay * (axes @ shift)
        left /= max(gait.rate, settings.footsteps.rates[0])
        self._lead(foot, i, k, ref, then, feet, foot_velocity, found.position, left)
        return found

    def _reach(
        self,
        foot: Foot,
        body: BodyState,
        axes: Float[Array, "2 2"],
        width: float,
        level: float,
    ) -> FootReach:
        """Return the reach of a foot, but for its own motion and the footstep of the reference.

        Args:
            axes: From axes of now to those of the touchdown.
            width: Lateral distance of the recorded feet at touchdown [m].
            level: Height of the ankle then [m].
        """
        settings, own, none = self.settings, self.gait.settings.swing, np.zeros(2)
        leg, hip = self.person.leg_length, body.origin(f"femur_{foot.side}")
        return FootReach(
            axes=self.axes,
            nominal=none,
            side=foot.side_sign,
            leg_length=leg,
            min_width=min(own.min_foot_distance * leg, width),
            swing_offset=none,
            settings=settings.footsteps,
            reach=settings.plan,
            max_descent=settings.tasks.weights.max_vertical_acceleration,
            clear_way=self.person.sole.clear_way,
            foot_velocity=none,
            max_foot_acceleration=own.max_acceleration,
            hip=axes @ (hip - body.com)[:2],
            hip_height=float(hip[2]) - level,
            hip_rise=float(body.com_velocity[2]),
            offset=none,
            offset_velocity=axes @ foot.swing.velocity,
            leg_momentum=self.person.leg_momentum,
            min_arrival_time=own.min_arrival_time,
            lasting_room=settings.footsteps.lasting_room(self.reference.omega)
            if self.push.felt
            else 1.0,
            in_time=self.push.felt,
            by_acceleration=self.push.recovering,
        )

    def _touchdown(
        self, phase: float, number: int, then: Instant, i: int, path, slope, turn: PredictedTurn
    ) -> ReferenceTouchdown:
        """Return the reference at the touchdown of a foot."""
        head, _, weights = self.reference.schedule.weights(phase)
        before, later = self.settings.footsteps.split(head, weights, number)
        k = 1 - i
        stance = float(weights[before].sum())
        sooner = self._sooner(stance)
        return ReferenceTouchdown(
            com=then.com[:2] + path + [0.0, turn.lateral_offset],
            com_velocity=then.com_velocity[:2],
            height=float(then.com[2] - then.foot_position[k, 2]),
            stance_foot=then.foot_position[k, :2] + path,
            footstep=then.foot_position[i, :2] + path,
            omega=self.reference.omega,
            stance_weight=stance - sooner,
            later_weight=later + sooner,
            transferred=sooner,
            slope=(atan(slope[0]), atan(slope[1])),
        )

    def _sooner(self, stance_weight: float) -> float:
        """Return by how much the weight of the stance foot is less than in the reference [1].

        After a push it is lifted ``transfer_time`` after touchdown, while the recorded one gives
        its load away over a whole double support. With the recorded weight, slow walks, whose
        double support is long, stepped too far to one side and then to the other, and fell eight
        steps after the push.

        Args:
            stance_weight: Weight of the stance foot after touchdown in the reference [1].
        """
        if not self.push.felt:
            return 0.0
        least = 0.5 * self.reference.omega * self.gait.settings.contact.transfer_time
        return self.recovery_share * max(stance_weight - least, 0.0)

    def _pivot(self, ref: Instant, then: Instant, growth: float, k: int, feet) -> Array:
        """Return the reference's own effective pivot until touchdown, at the real stance foot [m].

        It is ahead of the ankle along the foot, which stays as it stands while the walk turns.
        """
        omega = self.reference.omega
        now, later = ((x.com + x.com_velocity / omega)[:2] for x in (ref, then))
        pivot = effective_pivot(now, later, growth) + self.offset[:2]
        if self._turned[k]:
            back = turned_axes(-self._turned[k])
            pivot = feet[k, :2] + (pivot - feet[k, :2]) @ back
            ahead = ref.cop[:2] - ref.foot_position[k, :2]
            self.cop_offset = ahead @ back - ahead
        return pivot

    def _lead(self, foot: Foot, i, k, ref, then, feet, velocity, footstep, time) -> None:
        """Lead a swing foot to its footstep: along with the reference, or on a way of its own."""
        outward = foot.side_sign * self.axes[:, 1]
        width = abs(float((ref.foot_position[i] - ref.foot_position[k])[:2] @ outward))
        stance_foot = feet[k, :2]
        step = feet[i, :2] - stance_foot, footstep - stance_foot
        inward = max(
            float((at.foot_position[i, :2] - at.foot_position[k, :2] - real) @ outward)
            for at, real in zip((ref, then), step, strict=True)
        )
        by = None
        if inward > self.settings.swing.max_inward_departure * self.person.leg_length:
            by = self.detour(foot.side_sign, *step, width)
        small = self.settings.tasks.weights.recovery_error * self.person.leg_length
        if by is None and foot.swing.own is None and abs(float(self.dcm_error[1])) < small:
            foot.swing.lead(footstep - then.foot_position[i, :2], time, self.step)
            return
        recorded = self.gait.rate * self.reference.cadence * ref.foot_velocity[i, :2]
        real = np.stack([feet[i, :2], velocity])
        motion = np.stack([ref.foot_position[i, :2], recorded])
        by = None if by is None else stance_foot + by
        foot.swing.go(real, motion, footstep, time, self.step, by)

    def detour(
        self, left: float, start: Float[Array, " 2"], end: Float[Array, " 2"], width: float
    ) -> Float[Array, " 2"] | None:
        """Return the point by which a foot goes around the stance foot; None if it goes straight.

        Args:
            left: 1 for the left foot, -1 for the right.
            start: Its position, from the stance foot [m].
            end: Its footstep, likewise [m].
            width: Lateral distance of the recorded feet now [m].
        """
        axes, size = self.axes * [1.0, left], self.person.sole.clear_way
        size = np.minimum(size, [np.inf, width])
        if size[1] <= 0.0:  # the recorded feet cross over themselves
            return None
        points, around = detours(start @ axes, (end @ axes)[None], size)
        return axes @ points[0] if around[0] else None

    def _lower(self, ground: Height, com, foot, com_ref, foot_ref) -> None:
        """Lower the body for one leg to reach its foot, unless the recorded one reaches as far.

        Where that does not reach the ground itself, the foot hangs over it, and the gait waits.

        Args:
            ground: Height of the ground at a position [m].
            com: Centre of mass, horizontal [m].
            foot: The foot, likewise.
            com_ref: Centre of mass in the reference [m].
            foot_ref: The foot in it [m].
        """
        leg = self.leg_reach
        height = []
        for c, f in ((com, foot), (com_ref, foot_ref)):
            x, y = (c - f).tolist()[:2]
            height.append(sqrt(max(leg**2 - x * x - y * y, 0.0)))
        drop = ground(np.array([*com, 0.0])) - ground(np.array([*foot, 0.0]))
        spare = height[1] + self.person.com_height - float(com_ref[2] - foot_ref[2])
        own, length = self.settings.plan, self.person.leg_length
        lowering = min(height[1] - height[0], own.max_lowering * length) + drop
        late = any(foot.wait > 0.0 for foot in self.gait.feet)
        lowering -= (spare if late else max(spare, 0.0)) + own.min_lowering * length
        self.lowering = max(self.lowering, lowering)

    @property
    def leg_reach(self) -> float:
        """Greatest distance of hip and ankle of a desired foot [m]; less in a recovery step."""
        own = self.settings.swing
        less = own.max_leg_extension - own.max_recovery_leg_extension
        return (own.max_leg_extension - self.recovery_share * less) * self.person.leg_length

    @property
    def recovery_share(self) -> float:
        """How much a step is a recovery, by the error of the divergent component."""
        own = self.settings.tasks.weights
        return own.recovery_share(self.dcm_error, self.person.leg_length)


def turned_axes(angle: float) -> Float[Array, "2 2"]:
    """Return the rotation to axes that are turned to the left."""
    c, s = cos(angle), sin(angle)
    return np.array([[c, s], [-s, c]])


def body_axes(quat: Float[Array, " 4"]) -> Float[Array, "2 2"]:
    """Return where a pelvis has ahead and left, as columns, to the nearest quarter turn.

    Legs pass each other along the body and step out across it, also where a walk leads backward or
    to a side.
    """
    x, y = nearest_right_angle(np.array([1.0, 0.0]), heading(quat)[:, 0]).tolist()
    return np.array([[x, -y], [y, x]])
