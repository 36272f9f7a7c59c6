"""Recovery steps while both feet are in stance and the motion has no step of its own.

When the capture point leaves the support the motion waits, and the person takes steps as in
:mod:`plantigrade.control.gait.step` until they are at rest. Then the motion goes on from where the
feet are.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.pendulum_state import PendulumState
from plantigrade.control.gait.phase import Foot, GaitState, Touchdown
from plantigrade.control.gait.step import StepPlanner, StepSettings
from plantigrade.control.gait.support import beyond
from plantigrade.control.gait.swing import SwingOffset
from plantigrade.control.gait.swing_foot import SwingFoot, SwingSettings
from plantigrade.control.gait.tasks import GaitTaskSettings
from plantigrade.kinematics.state import BodyState


@dataclass(frozen=True, kw_only=True)
class WaitingSettings:
    """When a replay takes recovery steps, and when its motion goes on."""

    step: StepSettings = StepSettings()
    swing: SwingSettings = SwingSettings()
    min_stance_time: float = StepSettings.swing_durations[-1]
    """Time until the motion's next lift-off, or until it sits, from which it has no support of its
    own to come [s]: that of the slowest recovery step."""
    seat_time: float = LoadSettings.min_rest_time
    """Time before and after sitting for which the seat supports the capture point, because a person
    who falls towards it sits down [s]; about that of a stride."""
    rest_time: float = 0.2
    """Time for which they do before the motion goes on [s]. Chosen."""
    rise_time: float = GaitTaskSettings.rise_time
    """Time constant of the return to full height when the motion moves the feet again [s]."""


class RecoverySteps:
    """Takes steps while the motion waits.

    Args:
        leg_length: Length of the leg [m].
        seat: Contact spheres that a seat bears.

    Attributes:
        waiting: Whether the motion waits.
        swing: The swing foot; None in double support.
        steps: Number of steps taken.
        lowering: Lowering of the body for legs to reach feet that are far apart [m].
    """

    def __init__(
        self,
        gait: GaitState,
        leg_length: float,
        seat: Int[Array, " _"],
        settings: WaitingSettings | None = None,
    ):
        self.gait, self.leg_length, self.seat = gait, leg_length, seat
        self.settings = settings or WaitingSettings()
        self.planner = StepPlanner(leg_length, self.settings.step)
        self.waiting, self.steps = False, 0
        self.swing: SwingFoot | None = None
        self.lowering = 0.0
        self._rest_start = self._last_touchdown = 0.0
        self._stances: list[int | None] = []

    @property
    def displaced(self) -> bool:
        """Whether the feet are where recovery steps have put them, and not the motion."""
        return self.waiting or self._stances == [foot.stance for foot in self.gait.feet]

    def update(
        self,
        time: float,
        step: float,
        body: BodyState,
        *,
        low: Sequence[Float[Array, "_ 3"]],
        heights: Sequence[Float[Array, " _"]],
        heading: Float[Array, " 2"],
        load: Float[Array, " 2"],
        recovers: bool,
    ) -> None:
        """Begin, continue or end a step, and let the motion wait or go on.

        Args:
            time: Now [s].
            step: Time since the last update [s].
            low: Lowest points of the contact spheres of each foot, world [m].
            heights: Their heights above the ground [m].
            heading: Horizontal direction in which the person faces.
            load: Load of each foot along the normal [N].
            recovers: Whether the error of the divergent component asks for a step.
        """
        own, steps = self.settings, self.planner.settings
        if not self.displaced:
            self.lowering *= exp(-step / own.rise_time)
        if not self.waiting and not (recovers and self._motion_stands()):
            return
        now = self._pendulum(body, low, heading)
        if self.swing is not None:
            self._continue(time, step, now, load)
        elif self._motion_stands():
            reach = self.gait.settings.contact.max_planned_height
            touching = [bool((height < reach).any()) for height in heights]
            support = [p[height < reach] for p, height in zip(low, heights, strict=True)]
            support.append(self._near_seat())
            outside = beyond(np.concatenate(support)[:, :2], now.capture_point)
            rested = time - self._last_touchdown > steps.load_transfer_duration
            if outside > steps.capture_threshold and recovers and rested:
                self._lift_off(time, now, touching)
            slow = float(np.linalg.norm(now.velocity)) < steps.rest_speed
            if not (outside < -steps.capture_margin and slow):
                self._rest_start = time
            elif time - self._rest_start > own.rest_time:
                self.waiting = False
                self._stances = [foot.stance for foot in self.gait.feet]
        if not self.waiting:
            return
        distance = float(np.linalg.norm(now.feet - now.com, axis=1).max())
        self.lowering = self.planner.lowering(distance)

    def _pendulum(self, body: BodyState, low, heading: Array) -> PendulumState:
        """Return the person as a pendulum."""
        ground = min(float(own[:, 2].min()) for own in low)
        feet = np.array([own[:, :2].mean(axis=0) for own in low])
        margin = self.planner.settings.support_margin
        return PendulumState.of(body, ground, low, feet, heading, margin)

    def _near_seat(self) -> Float[Array, "_ 3"]:
        """Return the ischia on the seat, onto which one may fall soon before or after sitting."""
        gait = self.gait
        sits = gait.reference.schedule.near("", gait.phase, self.settings.seat_time)
        if sits is None:
            return np.empty((0, 3))
        return gait.reference.at(sits).contact_position[self.seat]

    def _motion_stands(self) -> bool:
        """Return whether both feet are in stance, and none is lifted nor a seat reached soon."""
        gait = self.gait
        schedule = gait.reference.schedule
        ends = [
            schedule.stance(foot.stance, gait.phase).stop
            for foot in gait.feet
            if foot.in_stance and foot.stance is not None
        ]
        sits = schedule.after("", gait.phase)
        until = min([*ends, np.inf if sits is None else sits[1]]) - gait.phase
        return len(ends) == len(gait.feet) and until > self.settings.min_stance_time

    def _lift_off(self, time: float, now: PendulumState, touching: Sequence[bool]) -> None:
        """Begin a step with the better foot.

        The other one need not carry load yet: after a push to the side a person stands on one foot,
        and that one has to step.
        """
        sides = [side for side in (0, 1) if touching[1 - side]]
        if not sides:
            return
        footstep = self.planner.plan(now, sides)
        self.swing = SwingFoot(self.planner, self.settings.swing, footstep, time)
        foot = self.gait.feet[footstep.side]
        assert foot.stance is not None
        foot.in_stance, foot.recovering = False, True
        foot.swing = SwingOffset(self.gait.offset(foot.stance)[:2], self.gait.settings.swing)
        self.waiting, self.steps, self._rest_start = True, self.steps + 1, time
        self._sole = now.feet[footstep.side] - foot.swing.offset

    def _continue(self, time: float, step: float, now: PendulumState, load: Array) -> None:
        """Lead the foot to the footstep needed now; end the step when it touches."""
        assert self.swing is not None
        side, gait = self.swing.footstep.side, self.gait
        foot, phase = gait.feet[side], self.swing.phase(time)
        touches = load[side] > gait.settings.contact.touchdown_load * gait.weight
        if self.swing.may_end(time) and touches:
            self._touch_down(time, foot, now)
            return
        self.swing = self.swing.replanned(now, time)
        left = self.swing.footstep.duration * (1.0 - phase)
        foot.swing.lead(self.swing.footstep.position - self._sole, left, step)

    def _touch_down(self, time: float, foot: Foot, now: PendulumState) -> None:
        """Put a foot in stance where it is."""
        assert foot.stance is not None
        foot.in_stance, foot.recovering, foot.early = True, False, False
        own = self.gait.offset(foot.stance)
        own[:2] = now.feet[self.gait.feet.index(foot)] - self._sole
        axes = np.stack([now.heading, now.left], axis=1)
        self.gait.touchdowns.append(Touchdown(time, foot.side, 0.0, own.copy(), axes))
        self.swing, self._last_touchdown, self._rest_start = None, time, time

    def foot_height(self, time: float) -> tuple[float, float]:
        """Return height of the swing foot above its lift-off, and its velocity [m, m/s]."""
        assert self.swing is not None
        phase, duration, swing = self.swing.phase(time), self.swing.footstep.duration, self.swing
        late_speed = swing.settings.late_descent_speed
        u = min(max(phase, 0.0), 1.0)
        late = max(phase - 1.0, 0.0) * duration
        high = 4.0 * (swing.settings.clearance * self.leg_length)
        velocity = high * (1.0 - 2.0 * u) / duration if phase < 1.0 else -late_speed
        return high * u * (1.0 - u) - late_speed * late, velocity
