"""Footsteps of a replay, and what is left to the centre of pressure.

:mod:`plantigrade.control.gait.planner` decides on one step. This module gives it the state of the
gait, and returns the error of the divergent component of motion that the centre of pressure has to
correct, whether one foot swings, both stand, or none.
"""

from dataclasses import dataclass
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.edges import EdgeSettings, on_one_side
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.phase import Foot, GaitState
from plantigrade.control.gait.planner import (
    FootstepLimits,
    FootstepSettings,
    StepAdjustment,
    next_step,
)
from plantigrade.control.gait.tasks import heading
from plantigrade.kinematics.state import BodyState


@dataclass(frozen=True, kw_only=True)
class PathReturnSettings:
    """How the person returns to the planned path."""

    max_com_offset: float = 0.12
    """Saturation of the offset of the centre of mass from the path that is followed [m]. Chosen."""


class FootstepPlanner:
    """Plans footsteps, and computes the error of the divergent component of motion.

    Args:
        leg_length: Length of the leg [m].
        side_of: Side of each contact sphere, as in ``SIDES``.
        settings: Limits and costs of footsteps.
        path: Return to the planned path.
        edges: Distances from the edges of steps in the ground.

    Attributes:
        stance_offset: Load-weighted offset of the stance feet from the motion, world [m].
        dcm_error: Error of the divergent component that the feet's offsets do not explain [m].
        path_offset: Offset of the path that is followed from the planned one [m].
    """

    def __init__(
        self,
        gait: GaitState,
        leg_length: float,
        ground: Ground,
        side_of: Int[Array, " k"],
        settings: FootstepSettings,
        path: PathReturnSettings,
        edges: EdgeSettings,
    ):
        self.gait, self.reference = gait, gait.reference
        self.leg_length, self.ground, self.side_of = leg_length, ground, side_of
        self.settings, self.path, self.edges = settings, path, edges
        self.stance_offset, self.dcm_error, self.path_offset = np.zeros(3), np.zeros(2), np.zeros(2)
        self._seats = np.array([not s.side for s in self.reference.schedule.stances], float)
        self._at_touchdown: tuple[float, Instant | None] = (np.nan, None)

    @property
    def seat_load(self) -> float:
        """Share of the load that the seat carries now."""
        return float(self.reference.schedule.weights(self.gait.phase)[1] @ self._seats)

    def rest(self, body: BodyState, ref: Instant) -> None:
        """Update the error of the divergent component while the motion waits at rest."""
        first, alpha, _ = self.reference.schedule.weights(self.gait.phase)
        own = [f.stance - first for f in self.gait.stance_feet if f.stance is not None]
        share = np.zeros(len(alpha))
        share[own] = np.maximum(alpha[own], 1e-3)
        self.stance_offset = share @ self.gait.offsets(first, len(alpha)) / share.sum()
        xi = (body.com + body.com_velocity / self.reference.omega)[:2]
        self.dcm_error = xi - ref.com[:2] - self.stance_offset[:2]

    def return_to_path(self, body: BodyState, ref: Instant, dt: float) -> None:
        """Move the path that is followed back to the planned one, slowly.

        Args:
            dt: Time since the last call [s].
        """
        off = (body.com - ref.com)[:2]
        self.path_offset = self.path_offset - dt * self.gait.settings.return_rate * off
        away = off - self.path_offset
        far, limit = hypot(*away), self.path.max_com_offset
        if far > limit:
            self.path_offset = self.path_offset + away * (1.0 - limit / far)

    def double_support_rate(self, recovery_share: float) -> float:
        """Return the rate of the phase in double support; 1 where no step follows."""
        if self.reference.schedule.after("r", self.gait.phase) is None:
            return 1.0
        return self.gait.settings.double_support_rate(recovery_share)

    def plan(
        self, body: BodyState, ref: Instant, feet: Float[Array, "2 3"], dt: float
    ) -> StepAdjustment | None:
        """Return the next step, and lead the swing foot there; None where no single foot swings.

        Args:
            feet: Positions of the feet, world [m].
            dt: Time until the next plan [s].
        """
        gait, omega = self.gait, self.reference.omega
        xi = (body.com + body.com_velocity / omega)[:2]
        xi_ref = (ref.com + ref.com_velocity / omega)[:2]
        first, beta, offsets, self.stance_offset = gait.load_offsets(self._seats)
        single = gait.single_support
        if single is not None:
            return self._step(xi, xi_ref, *single, feet, dt)
        if gait.stance_feet:
            last = gait.newest_stance(first)
            known, later = self.settings.split(first, beta, last + 1)
            later *= self.settings.offset_decay
            newest = gait.offset(last)[:2] - self.path_offset
            coming = float(beta[~known].sum()) * self.path_offset + later * newest
            self.dcm_error = xi - xi_ref - beta[known] @ offsets[known, :2] - coming
            return None
        for f in gait.feet:
            if f.stance is not None:
                f.swing.lead(xi - xi_ref, f.touchdown - gait.phase, dt)
        self.dcm_error = np.zeros(2)
        return None

    def _step(
        self, xi: Array, xi_ref: Array, foot: Foot, other: Foot, feet: Array, dt: float
    ) -> StepAdjustment:
        """Return the step of the one foot that swings, and lead it there."""
        gait, reference, path = self.gait, self.reference, self.path_offset
        omega = reference.omega
        assert foot.stance is not None and other.stance is not None
        left = max(foot.touchdown - gait.phase, 0.01)
        then = self._touchdown(foot.touchdown)
        head, _, weights = reference.schedule.weights(foot.touchdown)
        before, later = self.settings.split(head, weights, foot.stance)
        stays = float(weights[before].sum())
        other_offset = kept = gait.offset(other.stance)[:2]
        if stays > 1e-9:
            kept = weights[before] @ gait.offsets(head, len(weights))[before, :2] / stays
        axes = heading(then.q[3:7])
        i, k = SIDES.index(foot.side), SIDES.index(other.side)
        planned = then.foot_position[i, :2] - then.foot_position[k, :2]
        width = foot.side_sign * float(planned @ axes[:, 1])
        limits = FootstepLimits(
            axes=axes,
            nominal=planned - other_offset + path,
            side=foot.side_sign,
            leg_length=self.leg_length,
            min_width=min(gait.settings.swing.min_foot_distance * self.leg_length, width),
            swing_offset=foot.swing.offset - path,  # along the motion it goes by itself
            foot_velocity=foot.swing.velocity,
            settings=self.settings,
            max_foot_acceleration=gait.settings.swing.max_acceleration,
        )
        step = next_step(
            xi - path,
            xi_ref,
            (then.com + then.com_velocity / omega)[:2],
            omega,
            left,
            self.stance_offset[:2] - path,
            kept - path,
            stays,
            later,
            limits,
        )
        home = self.settings.offset_decay * (self.stance_offset[:2] - path)
        decay = np.exp(-omega * left / step.rate)
        self.dcm_error = decay * later * (step.unconstrained - home)
        offset = step.offset + path
        if self.ground.steps:
            low = then.contact_position[self.side_of == i]
            offset = on_one_side(self.ground, low, offset, axes[:, 0], self.edges)
        foot.swing.lead(offset, left / max(gait.rate, self.settings.rates[0]), dt)
        return step

    def _touchdown(self, phase: float) -> Instant:
        """Return the motion at a touchdown; every tick until then needs it."""
        when, then = self._at_touchdown
        if then is None or when != phase:
            then = self.reference.at(phase)
            self._at_touchdown = (phase, then)
        return then
