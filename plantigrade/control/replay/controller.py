"""The controller that carries out a motion: reference, planner, whole-body program, world."""

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.control.gait.clearance import ClearanceSettings, clearance_of
from plantigrade.control.gait.person import SEAT, GaitPerson
from plantigrade.control.gait.phase import FootContactSettings, GaitPhaseSettings, GaitState
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.gait.reference import (
    STEP,
    ReferenceSettings,
    ReferenceTables,
    reference_of,
)
from plantigrade.control.gait.tasks import (
    GaitTaskSettings,
    TrackingTasks,
    desired_accelerations,
    heading,
    leg_joints,
)
from plantigrade.control.replay.approach import ApproachSettings, with_approach
from plantigrade.control.replay.com import com_acceleration, rise
from plantigrade.control.replay.footsteps import FootstepPlanner, PathReturnSettings
from plantigrade.control.replay.recovery import RecoverySteps, WaitingSettings
from plantigrade.control.replay.summary import (
    describe_end,
    describe_steps,
    describe_stray,
    describe_touchdowns,
    touchdown_figures,
)
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.record import Record
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.whole_body import Touching, WholeBody
from plantigrade.world import Command, Controller, Rates, StablePD, State, Summary


@dataclass(frozen=True, kw_only=True)
class ReplaySettings:
    """The settings of :class:`Replay`."""

    clearance: ClearanceSettings = ClearanceSettings()
    reference: ReferenceSettings = ReferenceSettings()
    approach: ApproachSettings = ApproachSettings()
    gait: GaitPhaseSettings = GaitPhaseSettings(
        contact=FootContactSettings(max_planned_height=0.015)
    )
    """Clock and contacts. A point that the motion has on the ground may be up to 1.5 cm above it
    [m]: soles yield by 8 mm under body weight, by twice that under one sphere, and tilt the foot.
    With the 5 mm of other walks one uphill fell after 5 s."""
    footsteps: FootstepSettings = FootstepSettings(
        rates=(0.8, 0.9, 1.0, 1.15, 1.3, 1.5, 1.75, 2.0), crossover_width=-0.04
    )
    """Footsteps, crossing over by 4 % of a leg at most: the path of a foot is that of the motion,
    and leads through the other leg, where walks that are planned go around it. Rates of the phase
    are no slower than 0.8: with the slower ones and farther crossing of these walks, the weakest of
    24 pushes at 0, 0.25 and 0.5 of a step was 50 N in place of 150."""
    path: PathReturnSettings = PathReturnSettings()
    recovery: WaitingSettings = WaitingSettings()
    tasks: GaitTaskSettings = GaitTaskSettings(
        com_weight=(20.0, 20.0, 5.0), com_height_stiffness=80.0, rotation_weight=0.5
    )
    """Tasks. Horizontally, the centre of mass counts for more than in planned walks: when a
    footstep changes shortly before touchdown, the accelerated swing foot pushes the centre of mass
    the other way, and the footstep changes again. With 12, a walk of 1.3 m/s is 5 cm beside its
    path after 8 s and one uphill 7 cm, with 20 3 and 4 cm. The rotation of feet is softer, as
    contacts lead it: with 2.0 a walk of 1.3 m/s was 2.6° off and 13 mm beside its path after 20 s,
    with 0.5 1.8° and 1 mm. The height of the mass is softer: held as firmly, three of 16 recorded
    walks fell, joints were 5 to 27° off in place of 4 to 17°, and standing people withstood 100 N
    in place of 200."""


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
        self.clearance = clearance_of(record, self.settings.clearance)
        human, person = self.human, GaitPerson.of(record)
        self.sites = person.sites
        self.points, self.radius = person.points, person.radius
        self.side_of, self.of_side = person.side_of, person.of_side
        found = reference_of(record, self.clearance, settings=self.settings.reference)
        self.reference: ReferenceTables = with_approach(
            found, self.of_side, self.ground, self.settings.approach
        )
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
        """Return the command for one control step."""
        world = state.world
        if self.program is None or state.time == 0.0:
            self._begin(state)
        step = 1.0 / world.control_rate
        gait, reference, footsteps = self.gait, self.reference, self.footsteps
        body = self.body = self.body.moved_to(state.qpos, state.qvel)
        feet = body.position(self.feet)
        low = body.position(self.points) - self.radius * self.normal
        loads = world.contacts.group_loads(world.data, self.side_of, self.normal)
        load, sits = loads[:SEAT], bool(loads[SEAT:].sum() > 0.0)
        ref = reference.at(gait.phase)
        height = self.ground.gap(low)
        height[self.of_side[SEAT]] = 0.0
        offsets = feet - ref.foot_position
        for i in (0, 1):
            offsets[i, 2] = height[self.of_side[i]].min()
        axes = heading(ref.q[3:7])
        gait.update(state.time, step, load, offsets, axes)
        plan = None
        if self.recovery.waiting:
            ref = ref.still()
            footsteps.rest(body, ref)
        else:
            footsteps.return_to_path(body, ref, step)
            plan = footsteps.plan(body, ref, feet, step)
        if self.recovery.waiting or not (sits or footsteps.seat_load > 0.0):
            own = [self.of_side[i] for i in (0, 1)]
            self.recovery.update(
                state.time,
                step,
                body,
                low=[low[each] for each in own],
                heights=[height[each] for each in own],
                heading=axes[:, 0],
                load=load,
                recovers=self._recovery_share >= 1.0,
            )
        if self.recovery.waiting:
            gait.rate, ref = 0.0, ref.still()
        else:
            rate = (
                footsteps.double_support_rate(self._recovery_share) if plan is None else plan.rate
            )
            gait.advance(state.time, step, rate)
            ref = reference.at(gait.phase)
        return self._command(state, body, ref, low, height, feet, step)

    def summary(self) -> Summary:
        """Return the steps of the last simulation, and how arms and legs were kept apart."""
        touchdowns = self.gait.touchdowns
        sentences = describe_steps(touchdowns)
        sentences.append(describe_touchdowns(touchdowns))
        sentences.append(describe_end(self.reference, self.gait.phase))
        sentences.append(describe_stray(self.off))
        apart = np.rad2deg(self.clearance.abduction)
        if apart.any():
            sentences.append(
                f"The motion has its arms up to {1e3 * self.clearance.arms:.0f} mm in the body; "
                f"they were held out by {apart[0]:.0f}° on the right and {apart[1]:.0f}° on the "
                "left."
            )
        if self.clearance.legs > self.settings.clearance.min_overlap:
            sentences.append(
                f"The motion has one leg up to {1e3 * self.clearance.legs:.0f} mm in the other; "
                "the swinging foot was led past it."
            )
        figures = touchdown_figures(touchdowns)
        off_path = {"off_path_end_m": float(np.linalg.norm(self.off))}
        return Summary(tuple(each for each in sentences if each), {**figures, **off_path})

    @property
    def _recovery_share(self) -> float:
        """How much a step is a recovery now."""
        return self.settings.tasks.recovery_share(self.footsteps.dcm_error, self.leg)

    @property
    def shared(self) -> tuple[object, ...]:
        """The motion, as it was given and as it is followed."""
        return self.reference, self.record

    def _stand(self) -> None:
        """Forget what was done."""
        self.gait = GaitState(self.reference, self.record.weight, settings=self.settings.gait)
        self.footsteps = FootstepPlanner(
            self.gait,
            self.leg,
            self.ground,
            self.side_of,
            self.settings.footsteps,
            self.settings.path,
            self.settings.reference.edges,
        )
        seat = self.of_side[SEAT]
        self.recovery = RecoverySteps(self.gait, self.leg, seat, self.settings.recovery)
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

    def _command(self, state, body, ref, low, height, feet, step) -> Command:
        """Return the command of the whole-body program."""
        gait, normal, tasks = self.gait, self.normal, self.tasks
        rate = min(gait.rate, self.settings.footsteps.rates[-1])
        on, soon = self._planned(ref)
        gap = height - self._lifted()
        active, held = self._touching(on, soon, gap)
        points = body.rigid_points(self.points.body[active], low[active])
        # Feet that steps have put elsewhere bend the legs otherwise than the motion has them.
        free = self.legs if self.recovery.displaced else None
        desired = desired_accelerations(ref, rate, body, tasks.settings, free)
        acceleration = com_acceleration(
            tasks.settings,
            body,
            ref,
            rate,
            self.footsteps,
            low[active, :2],
            normal,
            self.recovery.lowering,
            self.settings.recovery.step.support_margin,
        )
        rows: list[Rows | PointRows] = [
            self._balance(tasks.com.rows(body, acceleration=acceleration))
        ]
        hanging = self.side_of[on & (gap > self.settings.gait.contact.max_planned_height)]
        rows += self._foot_rows(body, ref, rate, feet, hanging, state.time)
        if held.any():
            rows.append(tasks.settings.still(points, held, gap[active], normal))
        touching = Touching(
            self.points.body[active], low[active], self.normals[: len(active)], self.friction
        )
        force = np.where(held[:, None], ref.force[active], 0.0)
        data = state.world.data
        passive = (data.qfrc_passive + data.qfrc_applied)[6 : 6 + len(self.damping)]
        assert self.program is not None
        answer = self.program.solve(
            body,
            touching,
            rows,
            desired=desired,
            weight=self.posture_cost,
            force=force,
            force_weight=tasks.settings.force_cost(held),
            torque=ref.tau - passive,
            torque_weight=self.torque_cost,
            passive=passive,
            points=points,
        )
        apart = state.angles - ref.q[7:]
        self.off = (body.com - ref.com)[:2]
        signals = {
            "tracking_error": sqrt(apart @ apart / len(apart)),
            "phase": gait.phase,
            "phase_rate": gait.rate,
            "off_path": self.off,
            "solved": float(answer.ok),
        }
        velocity = state.rates + 0.5 * (step + 1.0 / state.world.rate) * answer.qacc[6:]
        return StablePD(state.angles, velocity, answer.torque, 0.0, self.damping, signals=signals)

    def _balance(self, rows: Rows) -> Rows:
        """Return rows of the centre of mass, which count less the more a seat bears.

        A person who sits follows the motion, and need not keep the body over the feet.
        """
        return replace(rows, weight=(1.0 - self.footsteps.seat_load) ** 2 * rows.weight)

    def _planned(self, ref) -> tuple[Array, Array]:
        """Return which points are on the ground in the motion, now and soon."""
        on, soon = ref.contact > 0.5, ref.contact_soon > 0.5
        for i, own in enumerate(self.gait.feet):
            if own.early:
                just = self.reference.at(own.touchdown + STEP)
                on[self.of_side[i]] = just.contact[self.of_side[i]] > 0.5
                soon[self.of_side[i]] = just.contact_soon[self.of_side[i]] > 0.5
        return on, soon

    def _foot_rows(self, body, ref, rate: float, feet, hanging: Array, time: float) -> list[Rows]:
        """Return the rows of both feet; ``hanging`` are the sides of points that hang."""
        tasks, rows = self.tasks, []
        for i, own in enumerate(self.gait.feet):
            target = (
                ref.foot_rotation[i],
                rate * ref.foot_angular_velocity[i],
                rate**2 * ref.foot_angular_acceleration[i],
            )
            normal, hangs = self.normal if own.in_stance else None, bool((hanging == i).any())
            rows.append(tasks.rotation(i, target, normal, hangs).rows(body))
            if not own.in_stance:
                tasks.swing[i].target = self._swing(own, i, ref, rate, feet, time)
                rows.append(tasks.swing[i].rows(body))
        return rows

    def _touching(self, on: Array, soon: Array, gap: Array) -> tuple[Array, Array]:
        """Return which points touch, and which of them are held.

        A point that is down a little sooner than the motion has it stays down: to lift it again,
        as the motion does not yet have it there, leaves the foot on its heel for a whole step.
        """
        gait, contact = self.gait, self.settings.gait.contact
        stands = np.array([*(f.in_stance for f in gait.feet), True])[self.side_of]
        touches = stands & (gap < contact.max_height) & (self.side_of != SEAT)
        planned = (on & stands & (gap < contact.max_planned_height)) | (soon & touches)
        touching = planned | touches
        active = touching.nonzero()[0]
        return active, planned[active]

    def _lifted(self) -> Array:
        """Return how much higher the ground is under each point than planned [m].

        It is no lower where the sole is pressed in: toes on the ground do not hang then.
        """
        found = [
            0.0 if f.stance is None or not f.in_stance else max(self.gait.offset(f.stance)[2], 0.0)
            for f in self.gait.feet
        ]
        return np.array([*found, 0.0])[self.side_of]

    def _swing(
        self, own, i: int, ref, rate: float, feet, time: float
    ) -> tuple[Array, Array, Array]:
        """Return desired position, velocity and acceleration of a swing foot."""
        position = np.array(ref.foot_position[i])
        velocity = rate * ref.foot_velocity[i]
        acceleration = rate**2 * ref.foot_acceleration[i]
        stance = self.gait.stance_feet
        if stance:
            k = SIDES.index(stance[0].side)
            planned = (ref.foot_position[i] - ref.foot_position[k])[:2]
            off = ref.foot_position[i, :2] - feet[k, :2]
            axes = heading(ref.q[3:7])
            own.swing.pass_beside(off, planned, axes, own.side_sign, self.leg, self.clearance.legs)
        offset = own.swing.offset
        level = self.ground.under(position)
        position[:2] += offset
        velocity[:2] += own.swing.velocity
        acceleration[:2] += own.swing.acceleration
        position[2] += rise(self.normal, offset)
        climb = rise(self.normal, own.swing.velocity)
        velocity[2] += climb
        acceleration[2] += rise(self.normal, own.swing.acceleration)
        if not self.ground.steps:
            position[2] += float(self.ground.under(position) - level)
        if own.recovering:
            height, velocity[2] = self.recovery.foot_height(time)
            position[2] += height
        elif own.descent:
            position[2] -= own.descent
            velocity[2] = climb - self.settings.gait.late_descent_speed
        return position, velocity, acceleration
