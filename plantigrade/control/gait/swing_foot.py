"""The swing foot of a recovery step."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.pendulum_state import PendulumState
from plantigrade.control.gait.phase import GaitPhaseSettings
from plantigrade.control.gait.step import PlannedStep, StepPlanner
from plantigrade.control.gait.swing import SwingOffsetSettings


@dataclass(frozen=True, kw_only=True)
class SwingSettings:
    """Motion of the swing foot of a recovery step."""

    clearance: float = 0.06
    """Height of a swing foot at mid-swing [leg lengths]. Chosen (±20 %: deviation 10 %)."""
    fixed_phase: float = 0.25
    """Last part of a swing, in which the footstep is no longer replanned. A foot that accelerates
    again there rises, too, and comes down late."""
    min_touchdown_phase: float = GaitPhaseSettings.min_touchdown_phase
    """Part of a swing after which ground contact ends it; as in walking."""
    late_descent_speed: float = GaitPhaseSettings.late_descent_speed
    """Speed at which a foot descends that has not met the ground in time [m/s]; as in walking."""
    arrival_lead: float = SwingOffsetSettings.arrival_lead
    """Time before touchdown at which the foot is over its footstep [s]; as in walking."""
    height_gain: float = 600.0
    """Stiffness of the height of a swing foot, critically damped [1/s²]. Chosen: with the 400 of
    walking, pushes of 120 N to eight sides ended in five falls in place of one."""

    @property
    def height_damping(self) -> float:
        """Critical damping of the height of a swing foot [1/s]."""
        return 2.0 * self.height_gain**0.5


@dataclass(frozen=True, eq=False)
class SwingFoot:
    """A foot on its way to a footstep."""

    planner: StepPlanner  #: The planner of the person
    settings: SwingSettings  #: Its motion
    footstep: PlannedStep  #: The footstep, its duration from lift-off on
    start: float  #: Time of lift-off [s]

    def phase(self, time: float) -> float:
        """Return the part of the swing that is over, 1 at touchdown."""
        return (time - self.start) / self.footstep.duration

    def may_end(self, time: float) -> bool:
        """Return whether ground contact ends the swing by now."""
        return self.phase(time) > self.settings.min_touchdown_phase

    def replanned(
        self, now: PendulumState, time: float, velocity: Float[Array, " 2"] | None = None
    ) -> "SwingFoot":
        """Return the swing to where the foot is needed now; unchanged in its last part.

        Args:
            time: Now [s].
            velocity: Velocity of the foot over the ground, which limits what it can reach; no
                limit if absent [m/s].
        """
        duration = self.footstep.duration
        left = duration - (time - self.start)
        if left < self.settings.fixed_phase * duration:
            return self
        side = self.footstep.side
        new = self.planner.footstep(now, side, left, swinging=True, velocity=velocity)
        return replace(self, footstep=replace(new, duration=duration))

    def acceleration(
        self,
        time: float,
        position: Float[Array, " 3"],
        velocity: Float[Array, " 3"],
        ground_height: float,
    ) -> Float[Array, " 3"]:
        """Return the acceleration that brings the foot to its footstep [m/s²].

        Over the ground by the cubic from where it is, in height along a parabola.

        Args:
            time: Now [s].
            position: Position of the middle of its sole [m].
            velocity: Its velocity [m/s].
            ground_height: Height of the middle of the sole at touchdown [m].
        """
        s, duration = self.settings, self.footstep.duration
        clearance = s.clearance * self.planner.leg_length
        elapsed = time - self.start
        left = max(duration - elapsed - s.arrival_lead, 2 * s.arrival_lead)
        level = (6 * (self.footstep.position - position[:2]) - 4 * velocity[:2] * left) / left**2
        u = float(np.clip(self.phase(time), 0.0, 1.0))
        late = max(elapsed - duration, 0.0)
        height = clearance * 4 * u * (1 - u) + ground_height
        height -= s.late_descent_speed * late
        climb = -s.late_descent_speed
        if u < 1:
            climb = clearance * 4 * (1 - 2 * u) / duration
        up = s.height_gain * (height - position[2]) + s.height_damping * (climb - velocity[2])
        limit = self.planner.settings.max_foot_acceleration
        return np.clip(np.array([*level, up]), -limit, limit)
