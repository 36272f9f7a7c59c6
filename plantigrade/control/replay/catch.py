"""Steps that no motion has: recovery steps while both feet are meant to stand.

When the capture point leaves the support and the motion has no step of its own to offer, the motion
waits, and steps are taken as in :mod:`plantigrade.control.gait.step` until the person rests.
Then the motion goes on from where the feet are.
"""

from collections.abc import Sequence
from math import exp

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.control.gait.phase import Foot, Gait, Touchdown
from plantigrade.control.gait.step import Pendulum, StepPlanner, StepSettings
from plantigrade.control.gait.support import beyond, inside
from plantigrade.control.gait.swing import SwingOffset
from plantigrade.control.gait.swing_foot import SwingFoot, SwingSettings
from plantigrade.kinematics.state import State as BodyState

SOON = 0.4
"""A motion that lifts a foot sooner than this has a step to offer [s]."""
MISSED = 0.08
"""No step for a divergent component that is less than this off [m]."""
NEAR = 0.006
"""A sphere that is no higher supports [m]."""
SLOW, CALM = 0.2, 0.2
"""At rest: slower than this [m/s] for so long [s]."""
WITHIN = -0.02
"""And with the capture point so far inside of the support [m]."""
UPRIGHT, FARTHEST = 0.2, 0.6
"""Feet farther than the first from under the centre of mass bend the legs, up to the second [leg
lengths]."""
BACK = 0.9
"""How far a foot may be set behind the other [leg lengths]: farther than in balance, for here the
heel of the leg behind may rise."""
STRAIGHTENS = 0.3
"""Time constant with which legs straighten again once the motion takes the feet elsewhere [s]."""


class Catch:
    """Takes steps while the motion waits.

    Args:
        leg: Length of the leg [m].
        weight: Of the person [N].

    Attributes:
        waits: Whether the motion does.
        swing: The foot in the air; None where both stand.
        steps: How many were taken.
        bent: How much lower the body is for the legs to reach feet that are far apart [m].
    """

    def __init__(self, leg: float, weight: float):
        self.leg, self.weight = leg, weight
        self.planner = StepPlanner(leg, StepSettings(max_step_back=BACK))
        self.swing_settings = SwingSettings()
        self.waits, self.steps = False, 0
        self.swing: SwingFoot | None = None
        self.bent = 0.0
        self._since = self._landed = 0.0
        self._stances: list[int | None] = []

    def look(
        self,
        time: float,
        step: float,
        gait: Gait,
        body: BodyState,
        low: Sequence[Float[Array, "_ 3"]],
        gaps: Sequence[Float[Array, " _"]],
        ahead: Float[Array, " 2"],
        load: Float[Array, " 2"],
        missed: float,
    ) -> None:
        """Begin, go on with or end a step, and let the motion wait or go on.

        Args:
            time: Now [s].
            step: Since the last look [s].
            gait: With the feet.
            body: The person now.
            low: Lowest points of the spheres of each foot, world.
            gaps: Their heights above the ground [m].
            ahead: Where the person faces, over the ground.
            load: Of the feet along the normal [N].
            missed: How far the divergent component is off [m].
        """
        if not self.displaced(gait):
            self.bent *= exp(-step / STRAIGHTENS)
        if not self.waits and (missed < MISSED or not self._may(gait)):
            return
        now = self._pendulum(body, low, ahead)
        if self.swing is not None:
            self._go_on(time, step, gait, now, load)
        elif self._may(gait):
            touching = [bool((gap < NEAR).any()) for gap in gaps]
            support = np.concatenate([own[gap < NEAR] for own, gap in zip(low, gaps, strict=True)])
            outside = beyond(support[:, :2], now.capture_point)
            steps = self.planner.settings
            rested = time - self._landed > steps.double_support_duration
            if outside > steps.capture_threshold and missed > MISSED and rested:
                self._lift(time, gait, now, touching)
            calm = outside < WITHIN and float(np.linalg.norm(now.velocity)) < SLOW
            if not calm:
                self._since = time
            elif time - self._since > CALM:
                self.waits = False
                self._stances = [foot.number for foot in gait.feet]
        if not self.waits:
            return
        off = float(np.linalg.norm(now.feet - now.com, axis=1).max()) - UPRIGHT * self.leg
        reach = min(max(off, 0.0), FARTHEST * self.leg)
        self.bent = self.leg - float(np.sqrt(self.leg**2 - reach**2))

    def displaced(self, gait: Gait) -> bool:
        """Return whether the feet are where steps have put them, and not the motion."""
        return self.waits or self._stances == [foot.number for foot in gait.feet]

    def _pendulum(self, body: BodyState, low, ahead: Array) -> Pendulum:
        """Return the person as a pendulum."""
        com, velocity = body.com, body.com_velocity
        height = float(com[2]) - min(float(own[:, 2].min()) for own in low)
        height = max(height, self.planner.settings.min_pendulum_height)
        xi = com[:2] + velocity[:2] * np.sqrt(height / GRAVITY)
        margin = self.planner.settings.support_margin
        feet = np.array([own[:, :2].mean(axis=0) for own in low])
        pressure = np.array([inside(own[:, :2], xi, margin) for own in low])
        return Pendulum(com[:2], velocity[:2], height, feet, pressure, ahead)

    def _may(self, gait: Gait) -> bool:
        """Return whether the motion has no step of its own to offer."""
        stops = [
            gait.reference.schedule.stance(foot.number, gait.phase).stop - gait.phase
            for foot in gait.feet
            if foot.stands and foot.number is not None
        ]
        return len(stops) == len(gait.feet) and min(stops) > SOON

    def _lift(self, time: float, gait: Gait, now: Pendulum, touching: Sequence[bool]) -> None:
        """Begin a step with the better foot.

        The other one need not carry yet: who is pushed to the side stands on one foot, and that is
        the one which has to go.
        """
        sides = [side for side in (0, 1) if touching[1 - side]]
        if not sides:
            return
        self.swing = SwingFoot(
            self.planner, self.swing_settings, self.planner.plan(now, sides), time
        )
        foot = gait.feet[self.swing.footstep.side]
        assert foot.number is not None
        foot.stands, foot.caught = False, True
        foot.swing = SwingOffset(gait.offset(foot.number)[:2], gait.settings.swing)
        self.waits, self.steps, self._since = True, self.steps + 1, time
        self._sole = now.feet[self.swing.footstep.side] - foot.swing.offset

    def _go_on(self, time: float, step: float, gait: Gait, now: Pendulum, load: Array) -> None:
        """Lead the foot to where it is needed now; let it stand where it touches."""
        assert self.swing is not None
        side = self.swing.footstep.side
        foot, part = gait.feet[side], self.swing.phase(time)
        if (
            self.swing.may_end(time)
            and load[side] > gait.settings.contact.touchdown_load * self.weight
        ):
            self.land(time, foot, gait, now)
            return
        self.swing = self.swing.replanned(now, time)
        left = self.swing.footstep.duration * (1.0 - part)
        foot.swing.lead(self.swing.footstep.position - self._sole, left, step)

    def land(self, time: float, foot: Foot, gait: Gait, now: Pendulum) -> None:
        """Let a foot stand where it is."""
        assert foot.number is not None
        foot.stands, foot.caught, foot.early = True, False, False
        own = gait.offset(foot.number)
        own[:2] = now.feet[gait.feet.index(foot)] - self._sole
        ahead = now.heading
        axes = np.array([[ahead[0], -ahead[1]], [ahead[1], ahead[0]]])
        gait.touchdowns.append(Touchdown(time, foot.side, 0.0, own.copy(), axes))
        self.swing, self._landed, self._since = None, time, time

    def height(self, time: float) -> tuple[float, float]:
        """Return height of the foot above where it stood and its vertical velocity [m, m/s]."""
        assert self.swing is not None
        part, duration = self.swing.phase(time), self.swing.footstep.duration
        u = min(max(part, 0.0), 1.0)
        late = max(part - 1.0, 0.0) * duration
        settings = self.swing_settings
        high, late_speed = 4.0 * (settings.clearance * self.leg), settings.late_descent_speed
        rise = high * (1.0 - 2.0 * u) / duration if part < 1.0 else -late_speed
        return high * u * (1.0 - u) - late_speed * late, rise
