"""The controller that walks as recorded: step plan, whole-body tasks, torques."""

from dataclasses import replace
from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.control.gait.clearance import SelfClearance, clearance_of
from plantigrade.control.gait.disturbance import DisturbanceEstimator
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.person import GaitPerson, leg_length
from plantigrade.control.gait.phase import GaitState
from plantigrade.control.gait.reference import STEP, ReferenceTables, reference_of
from plantigrade.control.pendulum.feet import Feet
from plantigrade.control.pendulum.footstep import Footstep
from plantigrade.control.pendulum.ground import LocalGround, Soles
from plantigrade.control.pendulum.hold import CommandHold
from plantigrade.control.pendulum.plan import StepPlan, turned_axes
from plantigrade.control.pendulum.reference import (
    ScaledReference,
    refuse_spins,
    with_feasible_com,
)
from plantigrade.control.pendulum.settings import MAX_TICK, WALK_DURATION, PendulumSettings
from plantigrade.control.pendulum.summary import Footfall, walk_summary
from plantigrade.control.pendulum.swing_clearance import with_clearance
from plantigrade.control.pendulum.tasks import WalkingTasks
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.kinematics.stride import stood_apart
from plantigrade.record import Record
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.whole_body import Answer, Touching, WholeBody
from plantigrade.world import (
    Command,
    Controller,
    Drawing,
    InitialState,
    Rates,
    SimulatedWorld,
    StablePD,
    State,
    Summary,
)


class Pendulum(Controller):
    """Walk as recorded, and stay on the feet.

    Args:
        record: The walk; a closed stride is repeated for ever
            (:func:`plantigrade.control.pendulum.reference.walk_of`), any other motion ends.
        settings: The numbers of the controller.

    Attributes:
        footstep: The next footstep; None in double support.
        footfalls: Touchdowns of the last simulation.
        position: Position of the centre of mass over the ground [m].
        soles: Contact spheres over the ground.
        foot_positions: Positions of both feet, right first [m].
        foot_bodies: Bodies of both feet, likewise.

    Raises:
        ParameterError: If the walk was not recorded on level ground or spins on a foot, or its
            motion has less than two frames.
    """

    rates = Rates(physics=600.0, control=200.0, frames=100.0)

    def __init__(self, record: Record, *, settings: PendulumSettings | None = None):
        self.settings = own = settings or PendulumSettings()
        ground = record.ground
        if ground.slope or ground.steps or ground.uneven:
            raise ParameterError("a pendulum needs a walk that was recorded on level ground")
        apart = stood_apart(record.human, record.motion)
        if apart > own.max_height_difference * leg_length(record.human):
            raise ParameterError(
                f"the feet of this walk stand at heights {100 * apart:.0f} cm apart: it was "
                "recorded on uneven ground, and a pendulum needs one on level ground"
            )
        self.record, self.human = record, record.human
        if own.tick >= MAX_TICK:
            self.rates = replace(self.rates, control=0.5 * self.rates.control)
        self.clearance = clearance_of(record)
        human, self.person = self.human, GaitPerson.of(record)
        self.reference = ScaledReference(self.reference_for(record, self.clearance), own.speed)
        repeats = self.reference.period is not None
        self.duration = max(record.motion.duration, WALK_DURATION if repeats else 0.0)
        self.foot_bodies = np.array(human.both("foot"))
        self._tasks = WalkingTasks(human, self.person.leg_length, own.tasks)
        self._damping = own.gait.joint_damping * self.person.strength
        self._world: SimulatedWorld | None = None
        self.footstep: Footstep | None = None
        self.footfalls: list[Footfall] = []

    def reference_for(self, record: Record, clearance: SelfClearance) -> ReferenceTables:
        """Return a walk of this person as it is followed: one that mass and feet can follow.

        Raises:
            ParameterError: If it spins on a foot.
        """
        own, person = self.settings, self.person
        found = reference_of(record, clearance, settings=own.reference)
        refuse_spins(found, self.human)
        found = with_feasible_com(found, own.reference.cop_smoothing)
        return with_clearance(found, person.leg_length, person.of_side, own.swing)

    def summary(self) -> Summary:
        """Return speed and footsteps of the last simulation."""
        return walk_summary(self.footfalls, *self._speeds())

    @property
    def shared(self) -> tuple[object, ...]:
        """The walk, as it was recorded and as it is followed."""
        return self.reference, self.record

    def _speeds(self) -> tuple[float, float, float]:
        """Return mean speed, that of the recording, and offset from the line at the end."""
        if self._world is None:
            return 0.0, 0.0, 0.0
        motion = self.record.motion
        way = (motion.qpos[-1, :2] - motion.qpos[0, :2]) / motion.duration
        recorded = float(np.linalg.norm(way))
        ahead = way / recorded if recorded > 1e-6 else np.array([1.0, 0.0])
        went = (self.position - self._from) if self._now > 0.0 else np.zeros(2)
        left = float(ahead[0] * went[1] - ahead[1] * went[0]) - float(self.plan.push.line[1])
        return float(went @ ahead) / max(self._now, 1e-9), recorded, left

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return the pendulum, and the next footstep."""
        if self._world is not state.world or self._now == 0.0:
            return ()
        com = state.body.com
        stance = [self.foot_positions[i] for i, f in enumerate(self.gait.feet) if f.in_stance]
        legs = np.array([[com, foot] for foot in stance]).reshape(-1, 2, 3)
        drawn = [Drawing(name="pendulum", points=com[None], lines=legs)]
        if self.footstep is not None:
            point = np.append(self.footstep.position, 0.0)
            point[2] = self.ground.height(point)
            drawn.append(Drawing(name="landing", points=point[None], colour="#ef6c00"))
        return tuple(drawn)

    def begin(self, state: State) -> None:
        """Start anew, as the recording does.

        Raises:
            ParameterError: If the world is another person's.
        """
        world = self._world = state.world
        if world.human.model.nv != self.human.model.nv:
            raise ParameterError(
                f"the walk is of a person with {self.human.model.nv} degrees of freedom; the one "
                f"in the world has {world.human.model.nv}"
            )
        own = self.settings
        self.ground = LocalGround(self.person, world.ground, own.ground.slope_distance)
        self._friction = own.gait.contact.friction_fraction * world.ground.friction
        # Passive damping holds a light toe back within a tick, as inertia does.
        rest = np.zeros(len(state.rates))
        torque, damped = (world.actuators.passive(state.angles, v) for v in (rest, rest + 1.0))
        inertia = 0.5 / world.control_rate * (torque - damped)
        self.program = WholeBody(self.human, armature=world.actuators.armature + inertia)
        self.footfalls, self._now = [], 0.0
        self.disturbance = DisturbanceEstimator(own.disturbance, held=True)
        self.position = self._from = state.body.com[:2].copy()
        self.resume(state.body, 0.0)

    def resume(self, body: BodyState, phase: float) -> None:
        """Go on, on the feet as they are, from a phase of the recording [s]."""
        assert self._world is not None  # it has begun
        own, feet = self.settings, body.origins[self.foot_bodies]
        gait = self.gait = GaitState(self.reference.recorded, self.record.weight, phase, own.gait)
        step = 1.0 / self._world.control_rate
        self._hold = CommandHold(own.tick, step, self.human.model.nv)
        self.plan = StepPlan(gait, self.reference, self.person, 2.0 * self._hold.half, own)
        self._feet = Feet(self.plan, self.ground, self._tasks, feet)
        self.footstep, self._clock = None, phase
        offset = feet - self.reference.at(phase).foot_position
        for i, foot in enumerate(gait.feet):
            if foot.in_stance and foot.stance is not None:
                gait.offset(foot.stance)[:2] = offset[i, :2]

    def start(self, initial: InitialState) -> InitialState:
        """Return a start at which the centre of mass is as fast as in the walk that is followed.

        The feet can bear that velocity; the one of a recording's first frame is off by up to 1 m/s.
        """
        motion = self.record.motion
        own = BodyState(self.human, motion.qpos[0], motion.qvel[0]).com_velocity
        qvel = initial.qvel.copy()
        qvel[:2] += (self.reference.at(0.0).com_velocity - own)[:2]
        return replace(initial, qvel=qvel)

    def walk_on(self, gait: GaitState) -> None:
        """Go on as the reference is now, with the gait of another walk at a like instant."""
        self._clock += gait.phase - self.gait.phase
        self.gait = self.plan.gait = gait
        self.plan.reference = self.reference

    def __call__(self, state: State) -> Command:
        """Return the command for one control step."""
        if self._world is not state.world or (state.time == 0.0 and self._now > 0.0):
            self.begin(state)
        step = 1.0 / state.world.control_rate
        gait, reference, body, hold = self.gait, self.reference, state.body, self._hold
        feet = self.foot_positions = body.origins[self.foot_bodies]
        soles = self.soles = self.ground.soles(body)
        load = state.world.contacts.group_loads(
            state.world.data, self.person.side_of, self.ground.normal
        )
        ref = reference.at(gait.phase)
        offset = feet - ref.foot_position
        for i in range(len(SIDES)):
            offset[i, 2] = soles.height[self.person.of_side[i]].min()
        n_touchdowns = len(gait.touchdowns)
        grazing = self._feet.grazing(feet, load, self.footstep, step)
        recovers = self.plan.recovery_share >= 1.0
        pushed = self.plan.push.felt
        gait.update(state.time, step, load, offset, np.eye(2), grazing, recovers, pushed)
        if len(gait.touchdowns) > n_touchdowns:
            self._record_footfall(state.time)
        self.position, self._now = body.com[:2].copy(), self._now + step
        rotation = turned_axes(self.plan.turn_rate * step)
        self.disturbance.update(body, state.contact_force, step, rotation)
        touching = soles.height < self.settings.gait.contact.max_height
        holds = hold.still_holds(touching, [f.in_stance for f in gait.feet])
        if not holds:
            ground, disturbance = self.ground, self.disturbance.acceleration
            slope, foothold = ground.slope(body.com)[1], self._feet.foothold
            self.footstep = self.plan.update(
                body,
                ref,
                feet,
                slope,
                ground.height,
                disturbance,
                None if ground.is_plane else foothold,
            )
        if self.footstep is None:
            rate = self.settings.gait.double_support_rate(self.plan.recovery_share)
        else:
            rate = self.footstep.rate
        own = step * reference.cadence  # seconds of the recording
        self._clock += own
        gait.advance(self._clock, own, rate)
        if holds:
            return hold.next()
        if hold.samples > 1:  # the middle of the tick is what counts
            body = body.integrated(hold.qacc, hold.half)
            soles = self.ground.soles(body)
        ahead = max(hold.half - step, 0.0) * reference.cadence * gait.rate
        return self._command(state, body, reference.at(gait.phase + ahead), soles)

    def _record_footfall(self, time: float) -> None:
        """Record a touchdown, with its distance from the planned footstep."""
        side, planned = self.gait.touchdowns[-1].side, self.footstep
        error, shortening = None, 0.0
        if planned is not None:
            position = self.foot_positions[SIDES.index(side), :2]
            error = float(np.linalg.norm(position - planned.position))
            shortening = planned.shortening
        self.footfalls.append(Footfall(time, side, error, shortening))

    def _command(self, state: State, body: BodyState, ref: Instant, soles: Soles) -> Command:
        """Return the command of the whole-body program."""
        gait, plan, tasks, own = self.gait, self.plan, self._tasks, self.settings.gait
        rate = min(gait.rate, self.settings.footsteps.rates[-1])
        planned = self._planned_contacts(ref, soles)
        touching = self._stance & (soles.height < own.contact.max_height)
        active = (planned | touching).nonzero()[0]
        held, low, height = planned[active], soles.low[active], soles.height[active]
        bodies = self.person.points.body[active]
        contacts = Touching(bodies, low, soles.normal[active], self._friction)
        points = body.rigid_points(contacts.body, low)
        level, slope = self.ground.slope(body.com)
        footstep = self.footstep
        com = tasks.com_acceleration(
            body,
            ref,
            rate,
            self.reference.omega,
            plan.dcm_error,
            plan.offset[:2] + plan.cop_offset,
            plan.lowering,
            low[:, :2],
            level,
            slope,
            None if footstep is None else footstep.time,
        )
        if plan.recovery_share >= 1.0:  # half way between corners, pyramids lack 0.3 of friction
            contacts = replace(contacts, along=float(np.arctan2(com[1], com[0])))
        rows: list[Rows | PointRows] = [
            tasks.com.rows(body, acceleration=com),
            tasks.momentum_rows(body, ref, rate, plan.dcm_error),
            *self._feet.rows(
                body, ref, rate, self.position, footstep, self.clearance.legs, soles, active
            ),
        ]
        if held.any():
            rows.append(tasks.contact_rows(points, held, height, soles.normal[active]))
        posture_error = state.angles - ref.q[7:]
        swing = [not foot.in_stance for foot in gait.feet]
        desired = tasks.posture_acceleration(body, ref, rate, swing, plan.turn_rate)
        weight = tasks.posture_cost(posture_error, plan.dcm_error)
        tasks.resist_hyperextension(body, ref, desired, weight)
        actuators = state.world.actuators
        if actuators.slows:
            self.program.limit(actuators.limits(state.rates))
        answer = self.program.solve(
            body,
            contacts,
            rows,
            desired=desired,
            weight=weight,
            force_weight=tasks.force_cost(held, height),
            torque_weight=tasks.torque_cost,
            passive=actuators.passive(state.angles, state.rates),
            points=points,
        )
        return self._springs(state, answer, posture_error)

    def _springs(self, state: State, answer: Answer, posture_error: Array) -> Command:
        """Return the torques of an answer, with dampers about the motion that it leads to."""
        gait, footstep = self.gait, self.footstep
        half = 0.5 * (1.0 / state.world.control_rate + 1.0 / state.world.rate)
        signals = {
            "tracking_error": sqrt(posture_error @ posture_error / len(posture_error)),
            "phase": gait.phase,
            "phase_rate": gait.rate,
            "capture_error": hypot(*self.plan.dcm_error),
            "landing": np.full(2, np.nan) if footstep is None else footstep.position,
            "landing_time": np.nan if footstep is None else footstep.time,
            "limited": float(answer.limited),
            "solved": float(answer.ok),
        }
        velocity = state.rates + half * answer.qacc[6:]
        command = StablePD(
            state.angles, velocity, answer.torque, 0.0, self._damping, signals=signals
        )
        return self._hold.keep(command, answer.qacc)

    @property
    def _stance(self) -> Array:
        """Which contact spheres are of stance feet."""
        return np.array([*(f.in_stance for f in self.gait.feet), False])[self.person.side_of]

    def _planned_contacts(self, ref: Instant, soles: Soles) -> Array:
        """Return which contact spheres the reference has on the ground."""
        own, of_side, contact = self.settings.gait, self.person.of_side, ref.contact > 0.5
        for i, foot in enumerate(self.gait.feet):
            if foot.early:
                phase = max(self.gait.phase, foot.touchdown + STEP)
                contact[of_side[i]] = self.reference.at(phase).contact[of_side[i]] > 0.5
        return contact & self._stance & (soles.height < own.contact.max_planned_height)
