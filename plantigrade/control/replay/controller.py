"""The controller that carries out a motion: reference, planner, whole-body program, world."""

from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.control.gait.clearance import clearance_of
from plantigrade.control.gait.person import SEAT, Person
from plantigrade.control.gait.phase import Gait, GaitSettings
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.gait.reference import Reference, reference_of
from plantigrade.control.gait.tasks import (
    TaskSettings,
    TrackingTasks,
    heading,
    leg_joints,
    wanted_accelerations,
)
from plantigrade.control.replay.catch import Catch
from plantigrade.control.replay.footsteps import FootstepPlanner, PathSettings
from plantigrade.control.replay.words import replay_figures, steps_told, touchdowns_told
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.record import Record
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.whole_body import Touching, WholeBody
from plantigrade.world import Command, Controller, Rates, StablePD, State, Summary

FIRM = 3.0
"""Feedback of the divergent component by the centre of pressure, by its own rate."""
INSIDE = 0.01
"""The centre of pressure stays so far inside of what touches [m]."""
VERTICAL = (80.0, 16.0)
"""Stiffness and damping of the height of the centre of mass, by mass [1/s², 1/s]."""
HEIGHTS = (-7.0, 12.0)
"""Limits of its vertical acceleration [m/s²]."""
BACK_UP = (-3.0, 8.0)
"""Limits of the part of it that leads back to the motion: who falls cannot press [m/s²]."""
BOUNCE = 1.2
"""Rate by which the height's own acceleration is scaled, at most."""
OVERLAP = 0.002
"""Legs that overlap more than this in the motion are told of [m]."""


@dataclass(frozen=True, kw_only=True)
class ReplaySettings:
    """The settings of :class:`Replay`."""

    gait: GaitSettings = GaitSettings()
    footsteps: FootstepSettings = FootstepSettings()
    path: PathSettings = PathSettings()
    tasks: TaskSettings = TaskSettings()


class Replay(Controller):
    """Carry out a whole motion and stay on the feet.

    Args:
        record: The motion, with its forces and torques where it has them.
        settings: The numbers of the controller.

    """

    rates = Rates(physics=1000.0, control=500.0, frames=100.0)

    def __init__(self, record: Record, *, settings: ReplaySettings | None = None):
        self.settings = settings or ReplaySettings()
        self.record, self.human, self.ground = record, record.human, record.ground
        self.clearance = clearance_of(record)
        self.reference: Reference = reference_of(record, self.clearance)
        human, person = self.human, Person.of(record)
        self.points, self.radius = person.points, person.radius
        self.side_of, self.of_side = person.side_of, person.of_side
        self.normal = self.ground.normal
        self.normals = np.tile(self.normal, (len(self.points), 1))
        self.feet = PointSet(human, [f"foot_{s}" for s in SIDES], np.zeros((2, 3)))
        weights = self.settings.tasks
        self.tasks, self.legs = TrackingTasks(self.feet, weights), leg_joints(human)
        self.posture_cost, self.torque_cost = weights.posture(human), weights.torque(human)
        self.damping = self.settings.gait.joint_damping * person.strength
        self.body = BodyState(human, human.standing())
        self.leg = person.leg_length
        self.friction = self.settings.gait.contact.friction_fraction * self.ground.friction
        self.program: WholeBody | None = None
        self._stand()

    def __call__(self, state: State) -> Command:
        """Return what the joints are to do for one control step."""
        world = state.world
        if self.program is None or state.time == 0.0:
            self._begin(state)
        step = 1.0 / world.control_rate
        gait, reference, footsteps = self.gait, self.reference, self.footsteps
        body = self.body = self.body.moved_to(state.qpos, state.qvel)
        foot = body.position(self.feet)
        low = body.position(self.points) - self.radius * self.normal
        load = world.contacts.loads(world.data, self.side_of, self.normal)[:SEAT]
        ref = reference.at(gait.phase)
        height = low @ self.normal - self.ground.under(low)
        height[self.of_side[SEAT]] = 0.0
        beside = foot - ref.foot_position
        for i in (0, 1):
            beside[i, 2] = height[self.of_side[i]].min()
        gait.look(state.time, step, load, beside, heading(ref.q[3:7]))
        if self.catch.waits:
            plan, ref = None, ref.still()
            footsteps.rest(body, ref)
        else:
            footsteps.return_to_path(body, ref, step)
            plan = footsteps.plan(body, ref, foot, step)
        self._catch(state.time, step, body, ref, low, height, load)
        if self.catch.waits:
            gait.rate, ref = 0.0, ref.still()
        else:
            gait.advance(
                state.time, step, footsteps.double_support_rate() if plan is None else plan.rate
            )
            ref = reference.at(gait.phase)
        return self._command(state, body, ref, low, height, foot, step)

    def summary(self) -> Summary:
        """Return the steps of the last simulation, and what was moved apart."""
        told = [*steps_told(self.gait.touchdowns), touchdowns_told(self.gait.touchdowns)]
        apart = np.rad2deg(self.clearance.abduction)
        if apart.any():
            told.append(
                f"The motion has its arms up to {1e3 * self.clearance.arms:.0f} mm in the body; "
                f"they were held out by {apart[0]:.0f}° on the right and {apart[1]:.0f}° on the "
                "left."
            )
        if self.clearance.legs > OVERLAP:
            told.append(
                f"The motion has one leg up to {1e3 * self.clearance.legs:.0f} mm in the other; "
                "the swinging foot was led past it."
            )
        figures = replay_figures(self.gait.touchdowns)
        off_path = {"off_path_end_m": float(np.linalg.norm(self.off))}
        return Summary(tuple(each for each in told if each), {**figures, **off_path})

    @property
    def shared(self) -> tuple[object, ...]:
        """The motion, as it was given and as it is followed."""
        return self.reference, self.record

    def _stand(self) -> None:
        """Forget what was done."""
        self.gait = Gait(self.reference, self.record.weight, settings=self.settings.gait)
        self.footsteps = FootstepPlanner(
            self.gait,
            self.leg,
            self.ground,
            self.side_of,
            self.settings.footsteps,
            self.settings.path,
        )
        self.catch = Catch(self.leg, self.record.weight)
        self.off = np.zeros(2)

    def _begin(self, state: State) -> None:
        """Start anew."""
        world = state.world
        if world.human.model.nv != self.human.model.nv:
            raise ParameterError(
                f"the motion is of a person with {self.human.model.nv} degrees of freedom; the one "
                f"in the world has {world.human.model.nv}"
            )
        self._stand()
        self.program = WholeBody(self.human, armature=world.actuators.armature)

    def _catch(self, time: float, step: float, body: BodyState, ref, low, height, load) -> None:
        """Take a step that the motion does not have, where nothing else helps."""
        if self.footsteps.seat_load > 0.0 and not self.catch.waits:
            return
        feet = [low[self.of_side[i]] for i in (0, 1)]
        gaps = [height[self.of_side[i]] for i in (0, 1)]
        missed, ahead = hypot(*self.footsteps.dcm_error), heading(ref.q[3:7])[:, 0]
        self.catch.look(time, step, self.gait, body, feet, gaps, ahead, load, missed)

    def _command(self, state, body, ref, low, height, foot, step) -> Command:
        """Return the command of the whole-body program."""
        gait, reference, normal = self.gait, self.reference, self.normal
        qvel = state.qvel
        rate = min(gait.rate, self.settings.gait.max_velocity_rate)
        on, soon = ref.contact > 0.5, ref.contact_soon > 0.5
        for i, own in enumerate(gait.feet):
            if own.early:
                just = reference.at(own.touchdown + self.settings.gait.early_lookahead)
                on[self.of_side[i]] = just.contact[self.of_side[i]] > 0.5
                soon[self.of_side[i]] = just.contact_soon[self.of_side[i]] > 0.5
        gap = height - self._lifted()
        active, held = self._touching(on, soon, gap)
        points = body.rigid_points(self.points.body[active], low[active])
        # Feet that steps have put elsewhere bend the legs otherwise than the motion has them.
        free = self.legs if self.catch.displaced(gait) else None
        tasks = self.tasks
        wanted = wanted_accelerations(ref, rate, body, tasks.settings, free)
        centre = self._com_acceleration(body, ref, rate, low, active)
        rows: list[Rows | PointRows] = [tasks.com.rows(body, acceleration=centre)]
        hanging = self.side_of[on & (gap > self.settings.gait.contact.max_planned_height)]
        for i, own in enumerate(gait.feet):
            target = (
                ref.foot_rotation[i],
                rate * ref.foot_angular_velocity[i],
                rate**2 * ref.foot_angular_acceleration[i],
            )
            hangs = bool((hanging == i).any())
            rotation = tasks.rotation(i, target, normal if own.stands else None, hangs)
            rows.append(rotation.rows(body))
            if not own.stands:
                tasks.swing[i].target = self._swing(own, i, ref, rate, foot, state.time)
                rows.append(tasks.swing[i].rows(body))
        if held.any():
            rows.append(tasks.held(points, held, gap[active], normal))
        touching = Touching(
            self.points.body[active],
            low[active],
            self.normals[: len(active)],
            self.friction,
        )
        planned, unplanned = (
            tasks.settings.planned_force_weight,
            tasks.settings.unplanned_force_weight,
        )
        weight = np.where(held, planned, unplanned) ** 2
        goal = np.where(held[:, None], ref.force[active], 0.0)
        data = state.world.data
        passive = (data.qfrc_passive + data.qfrc_applied)[6 : 6 + len(self.damping)]
        assert self.program is not None
        answer = self.program.solve(
            body,
            touching,
            rows,
            wanted=wanted,
            weight=self.posture_cost,
            force=goal,
            force_weight=weight,
            torque=ref.tau - passive,
            torque_weight=self.torque_cost,
            passive=passive,
            points=points,
        )
        ahead = 0.5 * (step + 1.0 / state.world.rate)
        apart = state.angles - ref.q[7:]
        self.off = (body.com - ref.com)[:2]
        return StablePD(
            state.angles,
            qvel[6:] + ahead * answer.qacc[6:],
            torque=answer.torque,
            stiffness=0.0,
            damping=self.damping,
            signals={
                "tracking_error": sqrt(apart @ apart / len(apart)),
                "phase": gait.phase,
                "phase_rate": gait.rate,
                "off_path": self.off,
                "solved": float(answer.ok),
            },
        )

    def _touching(self, on: Array, soon: Array, gap: Array) -> tuple[Array, Array]:
        """Return which points touch, and which of them are held.

        A point that is down a little sooner than the motion has it stays down: to lift it again,
        as the motion does not yet have it there, leaves the foot on its heel for a whole step.
        """
        gait, contact = self.gait, self.settings.gait.contact
        stands = np.array([*(f.stands for f in gait.feet), True])[self.side_of]
        touches = stands & (gap < contact.max_height) & (self.side_of != SEAT)
        planned = (on & stands & (gap < contact.max_planned_height)) | (soon & touches)
        touching = planned | touches
        active = touching.nonzero()[0]
        return active, planned[active]

    def _lifted(self) -> Array:
        """Return how much higher the ground is under each point than planned [m]."""
        found = [
            0.0 if f.number is None or not f.stands else self.gait.offset(f.number)[2]
            for f in self.gait.feet
        ]
        return np.array([*found, 0.0])[self.side_of]

    def _com_acceleration(self, body, ref, rate, low, active) -> Array:
        """Return the acceleration of the centre of mass that is wanted."""
        omega, shift = self.reference.omega, self.footsteps.stance_offset
        moved = shift[:2] + (1.0 + FIRM / omega) * self.footsteps.dcm_error
        if len(active):
            moved = self._inside(ref.cop[:2], moved, low[active, :2])
        c, v = body.com, body.com_velocity
        wanted = np.array(ref.com_acceleration)
        wanted[:2] += omega**2 * ((c - ref.com)[:2] - moved)
        k, d = VERTICAL
        rate = min(rate, BOUNCE)
        dz = ref.com[2] + shift[2] + self._rise(shift) - self.catch.bent - c[2]
        back = k * dz + d * (rate * ref.com_velocity[2] - v[2])
        up = rate**2 * ref.com_acceleration[2] + min(max(back, BACK_UP[0]), BACK_UP[1])
        wanted[2] = min(max(up, HEIGHTS[0]), HEIGHTS[1])
        return wanted

    def _rise(self, moved: Array) -> float:
        """Return how much higher the slope is a step away [m]."""
        n = self.normal
        return float(-(n[0] * moved[0] + n[1] * moved[1]) / n[2])

    def _inside(self, pressure: Array, moved: Array, places: Array) -> Array:
        """Return a shift of the centre of pressure that stays among what touches."""
        wanted = pressure + moved
        low, high = places.min(axis=0) + INSIDE, places.max(axis=0) - INSIDE
        nominal = pressure + self.footsteps.stance_offset[:2]
        low, high = np.minimum(low, nominal), np.maximum(high, nominal)
        return np.minimum(np.maximum(wanted, low), high) - pressure

    def _swing(
        self, own, i: int, ref, rate: float, foot, time: float
    ) -> tuple[Array, Array, Array]:
        """Return place, velocity and acceleration that a swinging foot is to have."""
        place = np.array(ref.foot_position[i])
        pace, push = rate * ref.foot_velocity[i], rate**2 * ref.foot_acceleration[i]
        others = self.gait.standing
        if others:
            k = SIDES.index(others[0].side)
            axes = heading(ref.q[3:7])
            planned = (ref.foot_position[i] - ref.foot_position[k])[:2]
            off = ref.foot_position[i, :2] - foot[k, :2]
            own.swing.pass_beside(off, planned, axes, own.left, self.leg, self.clearance.legs)
        moved = own.swing.offset
        level = self.ground.under(place)
        place[:2] += moved
        pace[:2] += own.swing.velocity
        push[:2] += own.swing.acceleration
        place[2] += self._rise(moved)
        if not self.ground.steps:
            place[2] += float(self.ground.under(place) - level)
        if own.caught:
            high, pace[2] = self.catch.height(time)
            place[2] += high
        elif own.lowered:
            place[2] -= own.lowered
            pace[2] = -0.4
        return place, pace, push
