"""The controller that walks as recorded: pendulum, landing, wanted velocities, torques."""

from dataclasses import replace
from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.clearance import clearance_of
from plantigrade.control.gait.person import Person
from plantigrade.control.gait.phase import Foot, Gait
from plantigrade.control.gait.reference import reference_of
from plantigrade.control.gait.tasks import com_rows, turn_error
from plantigrade.control.pendulum.disturbance import DisturbanceEstimator
from plantigrade.control.pendulum.foothold import Sole
from plantigrade.control.pendulum.frame import Terrain
from plantigrade.control.pendulum.hold import CommandHold
from plantigrade.control.pendulum.landing import Landing
from plantigrade.control.pendulum.landing_laws import LAWS, LandingLaw
from plantigrade.control.pendulum.plan import Plan, reaction_of, turned
from plantigrade.control.pendulum.scaled_reference import ScaledReference
from plantigrade.control.pendulum.settings import PendulumSettings
from plantigrade.control.pendulum.summary import Footfall, walk_summary
from plantigrade.control.pendulum.swing import SwingPath, limit_to_reach
from plantigrade.control.pendulum.velocities import BoxProgram
from plantigrade.control.pendulum.walk import with_feasible_com
from plantigrade.control.pendulum.wanted import (
    Weights,
    held_rows,
    joint_accelerations,
    mass_acceleration,
    place_rows,
    tilted,
    turn_rows,
)
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State as BodyState
from plantigrade.kinematics.stride import stood_apart
from plantigrade.record import Record
from plantigrade.spatial.conventions import about_vertical
from plantigrade.wbc.whole_body import PointRows, Rows, Touching
from plantigrade.world import (
    Command,
    Controller,
    Drawing,
    InitialState,
    Rates,
    StablePD,
    State,
    Summary,
    World,
)

AROUND = 0.3
"""The body goes by the mean height of the ground so far around it [leg lengths]."""
AMISS = 0.1
"""From this deviation on late feet come down where they are [leg lengths]."""
ASKEW = 0.06
"""From this deviation on pyramids of friction have a corner in the direction of the push that is
wanted; half way between corners they lack 0.3 of it [leg lengths]."""
GRAZED, LOWERS = 0.05, 0.1
"""A foot that grazes the ground on its way is lifted so much higher [leg lengths], and comes down
again in this time [s]."""
HERE, LOWERED = 0.3, 1.0
"""So near to its place one does so [leg lengths]; so fast a late foot is let down [m/s]."""
LEVEL = 0.06
"""Places where feet stand in a walk on level ground are no farther apart in height [m]."""
STILL = np.zeros(3)
AXES = np.eye(2)
"""The walk's way: ahead and to the left, as columns."""
LONG = 0.02
"""Ticks from which the soles are sampled at half the rate [s]."""
WALKS = 10.0
"""How long a walk is repeated where no duration is named [s]."""


class Pendulum(Controller):
    """Walk as recorded, and stay on the feet.

    Args:
        record: The walk; a closed stride is repeated for ever
            (:func:`plantigrade.control.pendulum.walk.walk_of`), any other motion ends.
        settings: The numbers of the controller.

    Attributes:
        landing: Where and when the swinging foot is to land; None in double support.
        place: Where the centre of mass is [m].
        low: The lowest place of each contact sphere [m].
        height: How high that is above the ground [m].

    Raises:
        ParameterError: If the walk was not recorded on level ground, or its motion has less than
            two frames.
    """

    rates = Rates(physics=600.0, control=200.0, frames=100.0)

    def __init__(self, record: Record, *, settings: PendulumSettings | None = None):
        self.settings = settings or PendulumSettings()
        ground = record.ground
        if ground.slope or ground.steps or ground.uneven:
            raise ParameterError("a pendulum needs a walk that was recorded on level ground")
        apart = stood_apart(record.human, record.motion)
        if apart > LEVEL:
            raise ParameterError(
                f"the feet of this walk stand at heights {100 * apart:.0f} cm apart: it was "
                "recorded on uneven ground, and a pendulum needs one on level ground"
            )
        self.record, self.human = record, record.human
        self.law: LandingLaw = LAWS[self.settings.law]
        if self.settings.tick >= LONG:
            self.rates = replace(self.rates, control=0.5 * self.rates.control)
        self.clearance = clearance_of(record)
        recorded = with_feasible_com(reference_of(record, self.clearance, lands=True))
        self.reference = ScaledReference(recorded, self.settings.speed)
        repeats = self.reference.period is not None
        self.duration = max(record.motion.duration, WALKS if repeats else 0.0)
        human, person = self.human, Person.of(record)
        self.points, self.radius = person.points, person.radius
        self.side_of, self.of_side = person.side_of, person.of_side
        self.feet, self.hips = (
            np.array([human.body(f"{bone}_{s}") for s in SIDES]) for bone in ("foot", "femur")
        )
        self.weights = Weights.of(human)
        self.damping = self.settings.gait.joint_damping * person.strength
        self.leg, self.hip = person.leg_length, person.com_height
        self.reach = self.settings.swing.max_leg_extension * self.leg
        self.reaction = reaction_of(human)
        self.gravity = np.array(human.model.opt.gravity)
        self._world: World | None = None
        self.landing: Landing | None = None
        self.landings: list[Footfall] = []

    def summary(self) -> Summary:
        """Return speed and footsteps of the last simulation."""
        return walk_summary(self.landings, *self._speeds(), self.settings.reported_shortening)

    @property
    def shared(self) -> tuple[object, ...]:
        """The walk, as it was recorded and as it is followed."""
        return self.reference, self.record

    def _speeds(self) -> tuple[float, float, float]:
        """Return mean speed, that of the recording, and how far beside the line it ended."""
        if self._world is None:
            return 0.0, 0.0, 0.0
        motion = self.record.motion
        way = (motion.qpos[-1, :2] - motion.qpos[0, :2]) / motion.duration
        own = float(np.linalg.norm(way))
        ahead = way / own if own > 1e-6 else np.array([1.0, 0.0])
        went = (self.place - self._from) if self._now > 0.0 else np.zeros(2)
        side = float(ahead[0] * went[1] - ahead[1] * went[0]) - float(self.plan.path[1])
        return float(went @ ahead) / max(self._now, 1e-9), own, side

    def drawings(self, state: State) -> tuple[Drawing, ...]:
        """Return the pendulum, and where the swinging foot is to land."""
        if self._world is not state.world or self._now == 0.0:
            return ()
        com = state.body.com
        stands = [self._foot[i] for i, f in enumerate(self.gait.feet) if f.stands]
        legs = np.array([[com, foot] for foot in stands]).reshape(-1, 2, 3)
        drawn = [Drawing(name="pendulum", points=com[None], lines=legs)]
        if self.landing is not None:
            place = np.append(self.landing.place, 0.0)
            place[2] = self._level(place)
            drawn.append(Drawing(name="landing", points=place[None], colour="#ef6c00"))
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
        self.ground: Ground | Terrain = world.ground
        self.normal = self.ground.normal
        self.friction = self.settings.gait.contact.friction_fraction * self.ground.friction
        # What resists a rate holds a light toe back within a tick, as inertia does.
        still = np.zeros(len(state.rates))
        rests, turns = (world.actuators.passive(state.angles, v) for v in (still, still + 1.0))
        resisted = 0.5 / world.control_rate * (rests - turns)
        self.program = BoxProgram(self.human, world.actuators.armature + resisted)
        self.landings, self._now = [], 0.0
        self.disturbance = DisturbanceEstimator(self.settings.disturbance)
        self.place = self._from = state.body.com[:2].copy()
        self.resume(state.body, 0.0)

    def resume(self, body: BodyState, phase: float) -> None:
        """Go on, on the feet as they are, from a phase of the recording [s]."""
        assert self._world is not None  # it has begun
        gait = self.gait = Gait(
            self.reference.recorded, self.record.weight, phase, self.settings.gait
        )
        nv = self.human.model.nv
        self.hold = CommandHold(self.settings.tick, 1.0 / self._world.control_rate, nv)
        tick = 2.0 * self.hold.half
        self.plan = Plan(
            gait,
            self.reference,
            self.law,
            self.leg,
            self.hip,
            self.reaction,
            tick,
            self.settings.swing,
            self.settings.footsteps,
        )
        self.paths = [SwingPath(self.leg, self.settings.swing) for _ in gait.feet]
        self.soles = [Sole(self.leg, own.left, self.settings.foothold) for own in gait.feet]
        for path, at in zip(self.paths, body.origins[self.feet], strict=True):
            path.start(at)
        self.landing, self._clock = None, phase
        self._lifted = np.zeros(2)
        ref, foot = self.reference.at(phase), body.origins[self.feet]
        for i, own in enumerate(gait.feet):
            if own.stands and own.number is not None:
                gait.offset(own.number)[:2] = (foot[i] - ref.foot_position[i])[:2]

    def start(self, initial: InitialState) -> InitialState:
        """Return a start at which the centre of mass is as fast as in the walk that is followed.

        The feet can bear that velocity; the one of a recording's first frame is off by up to 1 m/s.
        """
        motion = self.record.motion
        own = BodyState(self.human, motion.qpos[0], motion.qvel[0]).com_velocity
        qvel = initial.qvel.copy()
        qvel[:2] += (self.reference.at(0.0).com_velocity - own)[:2]
        return replace(initial, qvel=qvel)

    def walk_on(self, gait: Gait) -> None:
        """Go on as the reference is now, with the gait of another walk at a like instant."""
        self._clock += gait.phase - self.gait.phase
        self.gait = self.plan.gait = gait
        self.plan.reference = self.reference

    def _level(self, place: Array) -> float:
        """Return the height of the ground at a place [m]."""
        (x, y, z), (ahead, left, _) = self.normal.tolist(), place.tolist()
        return (float(self.ground.under(place)) - x * ahead - y * left) / z

    @property
    def _rough(self) -> bool:
        """Whether the ground is more than a plane."""
        return bool(self.ground.uneven or self.ground.steps)

    def _foothold(self, i: int, place: Array, other: Array, left: float) -> Array:
        """Return how far from a place a foot is to land, to stand well [m]."""
        return self.soles[i].shift(self.ground, place, other, left)

    def _slope(self, place: Array) -> tuple[float, Array]:
        """Return height and rise of the ground about a place, over a step: it need not be even."""
        if not self._rough:
            return self._level(place), -self.normal[:2] / self.normal[2]
        half = AROUND * self.leg
        east, north = np.array([half, 0.0, 0.0]), np.array([0.0, half, 0.0])
        around = [self._level(place + way) for way in (east, -east, north, -north)]
        rise = np.array([around[0] - around[1], around[2] - around[3]]) / (2 * half)
        return float(np.mean(around)), rise

    def __call__(self, state: State) -> Command:
        """Return what the joints are to do for one control step."""
        if self._world is not state.world or (state.time == 0.0 and self._now > 0.0):
            self.begin(state)
        step = 1.0 / state.world.control_rate
        gait, reference, body = self.gait, self.reference, state.body
        foot = self._foot = body.origins[self.feet]
        low, height = self._soles(body)
        load = state.world.contacts.loads(state.world.data, self.side_of, self.normal)
        ref = reference.at(gait.phase)
        beside = foot - ref.foot_position
        self.low, self.height = low, height
        for i in (0, 1):
            beside[i, 2] = height[self.of_side[i]].min()
        landed = len(gait.touchdowns)
        grazes = [self._grazes(own, foot[i], load[i]) for i, own in enumerate(gait.feet)]
        self._lifted = np.where(grazes, GRAZED * self.leg, self._lifted * (1.0 - step / LOWERS))
        gait.look(state.time, step, load, beside, np.eye(2), grazes)
        if len(gait.touchdowns) > landed:
            self._landed(state.time)
        self.place, self._now = body.com[:2].copy(), self._now + step
        rotation = turned(self.plan.turning * step)
        self.disturbance.update(body, state.contact_force, step, rotation)
        touching = height < self.settings.gait.contact.max_height
        holds = self.hold.still_holds(touching, [f.stands for f in gait.feet])
        if not holds:
            rise, foothold = self._slope(body.com)[1], self._foothold if self._rough else None
            push = self.disturbance.acceleration
            self.landing = self.plan.next(body, ref, foot, rise, self._level, push, foothold)
        if self.landing is None:
            pace = self.settings.footsteps.double_support_rate(self.plan.error)
        else:
            pace = self.landing.rate
        own = step * reference.cadence  # seconds of the recording
        self._clock += own
        gait.advance(self._clock, own, pace)
        if holds:
            return self.hold.next()
        if self.hold.samples > 1:  # the middle of the tick is what counts
            body = body.integrated(self.hold.qacc, self.hold.half)
            foot, (low, height) = body.origins[self.feet], self._soles(body)
        ahead = max(self.hold.half - step, 0.0) * reference.cadence * gait.rate
        return self._command(state, body, reference.at(gait.phase + ahead), low, height, foot)

    def _grazes(self, own: Foot, place: Float[Array, " 3"], load: float) -> bool:
        """Return whether a swinging foot touches the ground far from where it is to land.

        Taken for a landing, such a touch in a hurried step ends it half way, and the body falls.
        """
        if own.stands or self.landing is None or load <= 0.0:
            return False
        return hypot(*(self.landing.place - place[:2])) > HERE * self.leg

    def _soles(self, body: BodyState) -> tuple[Array, Array]:
        """Return the lowest points of the spheres, and their heights over the ground [m]."""
        centre, ground = body.position(self.points), self.ground
        if not ground.uneven:
            self.normals = np.broadcast_to(self.normal, centre.shape)
            low = centre - self.radius * self.normal
            return low, low @ self.normal - ground.under(low)
        self.normals = ground.normal_at(centre)
        low = centre - self.radius * self.normals
        return low, (low @ self.normal - ground.under(low)) * (self.normals @ self.normal)

    def _landed(self, time: float) -> None:
        """Keep what a touchdown was beside what was predicted."""
        side = self.gait.touchdowns[-1].side
        off, short = None, 0.0
        if self.landing is not None:
            off = float(np.linalg.norm(self._foot[SIDES.index(side), :2] - self.landing.place))
            short = self.landing.short
        self.landings.append(Footfall(time, side, off, short))

    def _command(self, state, body, ref, low, height, foot) -> Command:
        """Return the command of the boxed program."""
        gait, settings = self.gait, self.settings.gait
        rate = min(gait.rate, settings.max_velocity_rate)
        on = ref.contact > 0.5
        for i, own in enumerate(gait.feet):
            if own.early:
                just = self.reference.at(max(gait.phase, own.touchdown + settings.early_lookahead))
                on[self.of_side[i]] = just.contact[self.of_side[i]] > 0.5
        stands = np.array([*(f.stands for f in gait.feet), False])[self.side_of]
        planned = on & stands & (height < settings.contact.max_planned_height)
        active = (planned | (stands & (height < settings.contact.max_height))).nonzero()[0]
        held = planned[active]
        where, up = low[active], self.normals[active]
        touching = Touching(self.points.body[active], where, up, self.friction)
        points = body.rigid_points(touching.body, where)
        M, h = body.mass_matrix, body.bias
        level, rise = self._slope(body.com)
        left = None if self.landing is None else self.landing.after
        centre = mass_acceleration(
            body, ref, rate, self.reference.omega, self.plan, low[active, :2], level, rise, left
        )
        if hypot(*self.plan.error) > ASKEW * self.leg:  # the whole friction where it stops the body
            touching = replace(touching, along=float(np.arctan2(centre[1], centre[0])))
        rows: list[Rows | PointRows] = [
            replace(com_rows(M, h, body.mass, self.gravity, centre), weight=self.weights.centre)
        ]
        feet = body.rigid_points(self.feet, foot)
        ways = body.rotations[self.feet]
        newest = max((f.touchdown for f in gait.standing), default=np.inf)
        for i, own in enumerate(gait.feet):
            k = feet.owner[i]
            J, speed, bias = feet.body_jacobian[k], feet.body_velocity[k], feet.body_bias[k]
            normal = self.normal
            if self._rough:
                ahead = ways[i, :2, 0]
                goal = None if self.landing is None else self.landing.place
                normal = self.soles[i].normal(self.ground, own, gait.phase, foot[i], ahead, goal)
            tilt = tilted(normal)
            way = ref.foot_rotation[i]
            if self.plan.toes and not own.stands:  # half of a turn's step before, half behind
                way = about_vertical(self.plan.toes) @ way
            error = turn_error(tilt @ way, ways[i])
            goal = tilt @ (rate * ref.foot_angular_velocity[i]) + self.plan.turning * normal
            push = tilt @ (rate**2 * ref.foot_angular_acceleration[i])
            across = normal if own.stands else None
            rows.append(turn_rows(J[:3], bias[:3], speed[:3], error, goal, push, across))
            if own.stands:
                self.paths[i].start(foot[i])
            else:
                place, pace, push = self._swing(own, i, ref, rate, foot)
                at = body.origins[self.hips[[i]]]
                goes = body.rigid_points(self.hips[[i]], at).velocity[0]
                limit_to_reach(self.reach, at[0], goes, place, pace, push)
                rows.append(place_rows(J[3:], bias[3:], speed[3:], place - foot[i], pace, push))
            if own.stands and own.touchdown >= newest and not (self.side_of[active] == i).any():
                # What carries has lost the ground: it is led back there.
                gap = -float(height[self.of_side[i]].min()) * normal
                rows.append(place_rows(J[3:], bias[3:], speed[3:], gap, STILL, STILL))
        if held.any():
            rows.append(held_rows(points, held, height[active], up))
        passive = state.world.actuators.passive(state.angles, state.rates)
        apart = state.angles - ref.q[7:]
        quick = self.weights.pace([not foot.stands for foot in gait.feet])
        answer = self.program.solve(
            body,
            touching,
            rows,
            wanted=joint_accelerations(body, ref, rate, quick, self.plan.turning),
            weight=self.weights.at(apart),
            passive=passive,
            points=points,
            held=held,
            gap=height[active],
        )
        half = 0.5 * (1.0 / state.world.control_rate + 1.0 / state.world.rate)
        found = self.landing
        place = np.full(2, np.nan) if found is None else found.place
        command = StablePD(
            state.angles,
            state.rates + half * answer.qacc[6:],
            torque=answer.torque,
            stiffness=0.0,
            damping=self.damping,
            signals={
                "tracking_error": sqrt(apart @ apart / len(apart)),
                "phase": gait.phase,
                "phase_rate": gait.rate,
                "capture_error": hypot(*self.plan.error),
                "landing": place,
                "landing_time": np.nan if found is None else found.after,
                "limited": float(answer.limited),
                "solved": float(answer.ok),
            },
        )
        return self.hold.keep(command, answer.qacc)

    def _swing(self, own, i: int, ref, rate: float, foot) -> tuple[Array, Array, Array]:
        """Return place, velocity and acceleration that a swinging foot is to have.

        The recorded path, rescaled to the predicted step; its height is kept above the ground.
        """
        place = np.array(ref.foot_position[i])
        pace, push = rate * ref.foot_velocity[i], rate**2 * ref.foot_acceleration[i]
        others = self.gait.standing
        amiss = hypot(*self.plan.error) > AMISS * self.leg
        if others:
            k = SIDES.index(others[0].side)
            planned = (ref.foot_position[i] - ref.foot_position[k])[:2]
            off, legs = place[:2] - foot[k, :2], self.clearance.legs
            if own.swing.own is None:
                own.swing.pass_beside(off, planned, AXES, own.left, self.leg, legs)
        place[:2] += own.swing.offset
        # The axes turn about the walker, and the goal with them.
        ahead, left = place[0] - self.place[0], place[1] - self.plan.path[1]
        if own.swing.own is None:
            pace[:2] += own.swing.velocity
            push[:2] += own.swing.acceleration
        else:
            pace[:2], push[:2] = own.swing.own
        pace[:2] += self.plan.turning * np.array([-left, ahead])
        goal = None if self.landing is None else self.landing.place
        near = goal is not None and hypot(*(goal - foot[i, :2])) < HERE * self.leg
        if amiss and own.lowered and near:
            place[:2], pace[:2], push[:2] = foot[i, :2], 0.0, 0.0
        plane = None if self._rough else self.normal
        high, rises = self.paths[i].height(
            own, self.gait.phase, rate, place, pace, goal, self._level, plane
        )
        place[2] += high + self._lifted[i]
        pace[2] += rises
        if own.lowered:
            place[2] -= own.lowered * LOWERED / self.gait.settings.late_descent_speed
            pace[2] = -0.8 * LOWERED
        return place, pace, push
