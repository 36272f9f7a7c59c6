"""Where the feet of a replay are put: the divergent component of motion beside that of the motion.

:mod:`plantigrade.control.gait.planner` decides on one step; here is what it is told, and what
remains to be done by the centre of pressure, whether one foot swings, both stand, or none.
"""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.edges import on_one_side
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.phase import Foot, Gait
from plantigrade.control.gait.planner import (
    AGAIN,
    BACK,
    LandingBox,
    Step,
    decayed,
    hurried,
    next_step,
)
from plantigrade.control.gait.swing import NARROW
from plantigrade.control.gait.tasks import heading
from plantigrade.kinematics.state import State as BodyState

RETURN, RETURNING, FAR = 0.2, 0.06, 0.12
"""The path that is walked is led back to the planned one: at this rate [1/s] and speed at most
[m/s]; the person is taken to be off it by so much at most [m]."""


class Footsteps:
    """Plans steps, and says by how much the divergent component is missed.

    Args:
        gait: With the feet and the motion.
        leg: Length of the leg [m].
        ground: As the motion has it.
        side_of: Side of each sphere of the feet, as in ``SIDES``.

    Attributes:
        shift: How far the feet that stand move the centre of pressure [m].
        error: How far the divergent component is off what the feet explain [m].
        path: How far the path that is walked is beside the planned one [m].
    """

    def __init__(self, gait: Gait, leg: float, ground: Ground, side_of: Int[Array, " k"]):
        self.gait, self.reference = gait, gait.reference
        self.leg, self.ground, self.side_of = leg, ground, side_of
        self.shift, self.error, self.path = np.zeros(3), np.zeros(2), np.zeros(2)
        self._seats = np.array([not s.side for s in self.reference.schedule.stances], float)
        self._grows = float(np.exp(self.reference.omega * AGAIN))
        self._kept: tuple[float, Instant | None] = (np.nan, None)

    @property
    def seat(self) -> float:
        """Share of the load that the seat carries now."""
        return float(self.reference.schedule.weights(self.gait.phase)[1] @ self._seats)

    def rest(self, body: BodyState, ref: Instant) -> None:
        """Find out how far the divergent component is from rest, while the motion waits."""
        first, alpha, _ = self.reference.schedule.weights(self.gait.phase)
        own = [f.number - first for f in self.gait.standing if f.number is not None]
        share = np.zeros(len(alpha))
        share[own] = np.maximum(alpha[own], 1e-3)
        self.shift = share @ self.gait.offsets(first, len(alpha)) / share.sum()
        xi = (body.com + body.com_velocity / self.reference.omega)[:2]
        self.error = xi - ref.com[:2] - self.shift[:2]

    def lead_back(self, body: BodyState, ref: Instant, dt: float) -> None:
        """Move the path that is walked back to the planned one, slowly.

        Args:
            body: The person now.
            ref: The motion now.
            dt: Since the last time [s].
        """
        off = (body.com - ref.com)[:2]
        size = hypot(*off)
        self.path = self.path - dt * off * min(RETURN, RETURNING / max(size, 1e-9))
        away = off - self.path
        far = hypot(*away)
        if far > FAR:
            self.path = self.path + away * (1.0 - FAR / far)

    def hurried(self) -> float:
        """Return the rate at which the weight goes over to the other foot."""
        if self.reference.schedule.after("r", self.gait.phase) is None:
            return 1.0
        return hurried(self.error)

    def plan(
        self, body: BodyState, ref: Instant, places: Float[Array, "2 3"], dt: float
    ) -> Step | None:
        """Return where and when the swinging foot lands; None where no single foot swings.

        Args:
            body: The person now.
            ref: The motion now.
            places: Where the feet are, world [m].
            dt: Until the next plan [s].
        """
        gait, reference = self.gait, self.reference
        omega = reference.omega
        xi = (body.com + body.com_velocity / omega)[:2]
        xi_ref = (ref.com + ref.com_velocity / omega)[:2]
        first, beta, offsets, self.shift = gait.carried(self._seats)
        standing = gait.standing
        swinging = [f for f in gait.feet if not f.stands and f.number is not None]
        if len(standing) == 1 and len(swinging) == 1:
            return self._step(xi, xi_ref, swinging[0], standing[0], places, dt)
        if standing:
            last = max((f.number for f in standing if f.number is not None), default=first)
            known = np.arange(first, first + len(beta)) <= last
            later = decayed(beta[~known], BACK) * BACK
            rest = float(beta[~known].sum())
            newest = gait.offset(last)[:2]
            coming = rest * self.path + later * (newest - self.path)
            self.error = xi - xi_ref - beta[known] @ offsets[known, :2] - coming
            return None
        for f in swinging:
            f.swing.lead(xi - xi_ref, f.touchdown - gait.phase, dt)
        self.error = np.zeros(2)
        return None

    def _step(
        self, xi: Array, xi_ref: Array, foot: Foot, other: Foot, places: Array, dt: float
    ) -> Step:
        """Return the step of the one foot that swings, and lead it there."""
        gait, reference, path = self.gait, self.reference, self.path
        omega = reference.omega
        assert foot.number is not None and other.number is not None
        left = max(foot.touchdown - gait.phase, 0.01)
        then = self._then(foot.touchdown)
        head, _, weights = reference.schedule.weights(foot.touchdown)
        before = np.arange(head, head + len(weights)) < foot.number
        at_other = gait.offsets(head, len(weights))[:, :2]
        later = decayed(weights[~before])
        stays = float(weights[before].sum())
        other_offset = gait.offset(other.number)[:2]
        kept = weights[before] @ at_other[before] / stays if stays > 1e-9 else other_offset
        axes = heading(then.q[3:7])
        i, k = SIDES.index(foot.side), SIDES.index(other.side)
        nominal = then.foot_position[i, :2] - then.foot_position[k, :2] - other_offset
        side = foot.left
        apart = side * float((then.foot_position[i, :2] - then.foot_position[k, :2]) @ axes[:, 1])
        narrowest = min(NARROW * self.leg, apart)
        here = places[i, :2] - then.foot_position[i, :2] - path
        box = LandingBox(axes, nominal + path, side, self.leg, narrowest, here)
        step = next_step(
            xi - path,
            xi_ref,
            (then.com + then.com_velocity / omega)[:2],
            omega,
            left,
            self.shift[:2] - path,
            kept - path,
            stays,
            later,
            box,
            grows=self._grows,
        )
        grown = np.exp(-omega * left / step.rate)
        self.error = grown * later * (step.free - BACK * (self.shift[:2] - path))
        landing = step.offset + path
        if self.ground.steps:
            low = then.contact_position[self.side_of == i]
            landing = on_one_side(self.ground, low, landing, axes[:, 0])
        foot.swing.lead(landing, left / max(gait.rate, 0.2), dt)
        return step

    def _then(self, phase: float) -> Instant:
        """Return the motion at a touchdown, which is asked for at every tick until then."""
        when, kept = self._kept
        if kept is None or when != phase:
            kept = self.reference.at(phase)
            self._kept = (phase, kept)
        return kept
