"""The desired motion of both feet: swing paths led to footsteps, and soles on the ground."""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.phase import Foot
from plantigrade.control.pendulum.footstep import Footstep
from plantigrade.control.pendulum.ground import LocalGround, SoleOnGround, Soles
from plantigrade.control.pendulum.plan import StepPlan
from plantigrade.control.pendulum.swing import SwingPath, limit_to_reach
from plantigrade.control.pendulum.tasks import WalkingTasks
from plantigrade.kinematics.state import BodyState
from plantigrade.spatial.conventions import about_vertical, less_tilted, tilt_to
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks.point import rotation_to


class Feet:
    """The feet of a walk; ``positions`` are the positions of the feet, right and left [m]."""

    def __init__(
        self,
        plan: StepPlan,
        ground: LocalGround,
        tasks: WalkingTasks,
        positions: Float[Array, "2 3"],
    ):
        self.plan, self.ground, self.leg = plan, ground, plan.person.leg_length
        self.tasks, self.settings, human = tasks, plan.settings.swing, plan.person.human
        self._feet, self._hips = (np.array(human.both(bone)) for bone in ("foot", "femur"))
        shape = plan.person.sole
        self._foot_length = shape.length
        self._soles = [
            SoleOnGround(self.leg, shape, foot.side_sign, plan.settings.ground)
            for foot in plan.gait.feet
        ]
        self._paths = [SwingPath(self.leg, shape, self.settings) for _ in SIDES]
        self._lift = np.zeros(len(SIDES))
        for path, position in zip(self._paths, positions, strict=True):
            path.start(position)

    def grazing(
        self,
        positions: Float[Array, "2 3"],
        load: Float[Array, " _"],
        footstep: Footstep | None,
        step: float,
    ) -> list[bool]:
        """Return which swing feet touch the ground a foot's length from the footstep or farther.

        These are lifted.

        Taken for a touchdown, such a contact in a hurried step ends it half way, and the body
        falls.

        Args:
            positions: Positions of the feet [m].
            load: On each [N].
            step: Time since the last call [s].
        """
        own = self.settings
        found = [
            not foot.in_stance
            and footstep is not None
            and bool(load[i] > 0.0)
            and hypot(*(footstep.position - positions[i, :2])) > self._foot_length
            for i, foot in enumerate(self.plan.gait.feet)
        ]
        lowered = self._lift * (1.0 - step / own.grazing_time)
        self._lift = np.where(found, own.grazing_lift * self.leg, lowered)
        return found

    def foothold(self, i: int, footstep: Array, other: Array, time: float) -> Array:
        """Return how far from a planned footstep a foot lands better [m]."""
        return self._soles[i].shift(self.ground.ground, footstep, other, self.plan.axes, time)

    def _normal(
        self, i: int, positions, ahead, soles: Soles, footstep: Footstep | None
    ) -> Float[Array, " 3"]:
        """Return the normal of a sole whose foot points ahead, over the ground."""
        if self.ground.is_plane:
            return self.ground.normal
        gait, goal = self.plan.gait, None if footstep is None else footstep.position
        ground, foot, place = self.ground.ground, gait.feet[i], positions[i, :2]
        if foot.in_stance:  # a heel that has struck stays there while the foot comes down
            person, ahead = self.plan.person, ahead / max(hypot(*ahead), 1e-6)
            heel = ((soles.low[person.of_side[i], :2] - place) @ ahead).min()
            place = place + (heel - person.sole.heel_centre) * ahead
        return self._soles[i].normal(
            ground, foot, gait.phase, place, ahead, goal, self.plan.axes[:, 0]
        )

    def _swing(self, i: int, ref: Instant, rate, positions, com, footstep, overlap):
        """Return desired position, velocity and acceleration of a swing foot.

        The recorded path, scaled to the planned footstep; its height is kept above the ground.
        """
        plan, gait = self.plan, self.plan.gait
        foot, goal = gait.feet[i], None if footstep is None else footstep.position
        position = np.array(ref.foot_position[i])
        velocity, acceleration = rate * ref.foot_velocity[i], rate**2 * ref.foot_acceleration[i]
        if gait.stance_feet and foot.swing.own is None:
            k = SIDES.index(gait.stance_feet[0].side)
            planned = (ref.foot_position[i] - ref.foot_position[k])[:2]
            off = position[:2] - positions[k, :2]
            foot.swing.pass_beside(off, planned, plan.axes, foot.side_sign, self.leg, overlap)
        position[:2] += foot.swing.offset
        # The axes turn about the walker, and the footstep with them.
        ahead, left = position[0] - com[0], position[1] - plan.push.line[1]
        if foot.swing.own is None:
            velocity[:2] += foot.swing.velocity
            acceleration[:2] += foot.swing.acceleration
        else:
            velocity[:2], acceleration[:2] = foot.swing.own
        velocity[:2] += plan.turn_rate * np.array([-left, ahead])
        recovers = plan.recovery_share >= 1.0
        if recovers and foot.descent and goal is not None:
            if hypot(*(goal - positions[i, :2])) < self._foot_length:
                position[:2], velocity[:2], acceleration[:2] = positions[i, :2], 0.0, 0.0
        normal = self.ground.normal if self.ground.is_plane else None
        height, rises = self._paths[i].height(
            foot, gait.phase, rate, position, velocity, goal, self.ground.height, normal
        )
        position[2] += height + self._lift[i]
        velocity[2] += rises
        if foot.descent:
            position[2] -= foot.descent
            velocity[2] = -gait.settings.late_descent_speed
        return position, velocity, acceleration

    def _within_reach(self, now: Float[Array, " 3"], desired: Float[Array, " 3"]) -> Array:
        """Return the directions in which a swing foot is led, as a matrix of three rows.

        A straight leg gets no longer: near full extension a foot is not led along its leg, as it
        would pull the body down instead. In a recovery step it is.

        Args:
            now: Position of the foot, from its hip [m].
            desired: Desired position, likewise [m].
        """
        own = self.settings
        far = max(float(np.sqrt(now @ now)), float(np.sqrt(desired @ desired))) / self.leg
        part = min(max((far - 1.0) / own.extension_fading + 1.0, 0.0), 1.0)
        part *= 1.0 - self.plan.recovery_share
        return np.eye(3) - part / (now @ now) * np.outer(now, now)

    def _levelling(self, foot: Foot) -> float:
        """Return how far a foot is levelled, at the end of the swing of a recovery step.

        After a far step the heel throws the forefoot down, and the ankle cannot hold it.
        """
        if foot.in_stance:
            return 0.0
        duration = max(foot.touchdown - foot.lift_off, 1e-3)
        left = (foot.touchdown - self.plan.gait.phase) / duration / self.settings.landing_share
        return self.plan.recovery_share * min(max(1.0 - left, 0.0), 1.0)

    def rows(
        self,
        body: BodyState,
        ref: Instant,
        rate: float,
        com: Float[Array, " 2"],
        footstep: Footstep | None,
        overlap: float,
        soles: Soles,
        active: Array,
    ) -> list[Rows]:
        """Return the rows of both feet.

        Args:
            ref: The reference at the phase of the gait.
            com: Centre of mass [m].
            overlap: Greatest depth of one leg in the other in the recording [m].
            active: Which of them touch.
        """
        plan, tasks, person, rows, still = self.plan, self.tasks, self.plan.person, [], np.zeros(3)
        positions = body.origins[self._feet]
        points, rotations = body.rigid_points(self._feet, positions), body.rotations
        newest = max((f.touchdown for f in plan.gait.stance_feet), default=np.inf)
        for i, foot in enumerate(plan.gait.feet):
            now = rotations[self._feet[i]]
            normal = self._normal(i, positions, now[:2, 0], soles, footstep)
            tilt, rotation = tilt_to(normal), ref.foot_rotation[i]
            if plan.foot_angle and not foot.in_stance:  # half of a turn's step before, half behind
                rotation = about_vertical(plan.foot_angle) @ rotation
            desired, change = rate * ref.foot_angular_velocity[i], ref.foot_angular_acceleration[i]
            level = self._levelling(foot)
            if level > 0.0:  # a foot that is level no longer turns as recorded
                rotation = less_tilted(rotation, level)
                slower = np.array([1.0 - level, 1.0 - level, 1.0])
                desired, change = slower * desired, slower * change
            error = rotation_to(tilt @ rotation, now)
            desired = tilt @ desired + plan.turn_rate * normal
            change = tilt @ (rate**2 * change)
            across = normal if foot.in_stance else None
            rows.append(tasks.rotation_rows(body, points, i, (error, desired, change), across))
            if not foot.in_stance:
                swing = self._swing(i, ref, rate, positions, com, footstep, overlap)
                hip = body.origins[self._hips[[i]]]
                hip_velocity = body.rigid_points(self._hips[[i]], hip).velocity[0]
                limit_to_reach(
                    plan.leg_reach, hip[0], hip_velocity, *swing, self.settings.reach_braking
                )
                target = swing[0] - positions[i], *swing[1:]
                foot = tasks.position.of(points, i, target).rows(body)
                now, then = positions[i] - hip[0], swing[0] - hip[0]
                rows.append(foot.along(self._within_reach(now, then)))
                continue
            self._paths[i].start(positions[i])
            if foot.touchdown >= newest and not (person.side_of[active] == i).any():
                # The foot that bears the body has lost the ground: it is led back there.
                gap = -float(soles.height[person.of_side[i]].min()) * normal
                rows.append(tasks.position.of(points, i, (gap, still, still)).rows(body))
        return rows
