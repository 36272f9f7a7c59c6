r"""Recovery steps: foot, position and duration from the capture point.

A linear pendulum of height :math:`z` diverges from its centre of pressure :math:`p` with
:math:`\omega = \sqrt{g / z}`: the capture point :math:`\xi = c + \dot c / \omega` ([Pratt2006]_) is
after a time :math:`T` at

.. math:: \xi_T = p - s + (\xi + s - p)\, e^{\omega T} ,

with :math:`s = a / \omega^2` while a disturbance accelerates the body by :math:`a`, which an
estimated one is expected to do for :math:`1 / \omega`.
As long as :math:`\xi` lies within the support polygon, pressure there can bring the body to rest.
Once it has left it, nothing but a step can (or arms and trunk, for a little).

One step is not always enough. The capture error that a step leaves grows by :math:`e^{\omega T}`
until the next one ([Koolen2012]_: a person is *N-step capturable* where it comes within reach after
N steps). The planner therefore compares feet, durations and positions by the error that remains
after :attr:`StepSettings.n_steps` steps, each as near to its desired position as leg and speed of
the foot allow: the foot on the side of a lateral push steps first, the other follows, and the first
steps out again. A foot stays on its own side of the other: legs are solid.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.pendulum_state import PendulumState
from plantigrade.control.gait.support import drawn_to
from plantigrade.control.gait.swing import SwingOffsetSettings

N_AHEAD, N_ASIDE = 8, 6  # grid of positions among which the planner chooses


@dataclass(frozen=True, kw_only=True)
class StepSettings:
    """Limits and costs of recovery steps."""

    swing_durations: tuple[float, ...] = (0.22, 0.27, 0.33, 0.4)
    """Swing durations the planner compares, shortest first [s]. Chosen (±20 %: deviation 5 %)."""
    load_transfer_duration: float = SwingOffsetSettings.min_arrival_time
    """Time from a touchdown until the foot carries load, and from then until the other one may be
    lifted [s]; as of arriving."""
    max_foot_acceleration: float = SwingOffsetSettings.max_acceleration
    """Greatest acceleration of a swing foot along each axis [m/s²]; as in walking."""
    n_steps: int = 3
    """Number of steps the planner looks ahead. Chosen: lateral pushes take up to three."""
    capture_margin: float = 0.03
    """Distance of the capture point from the edge of the support at which a step begins [m]: for a
    first step inside, as a foot can be lifted only while the other one carries, and a push to the
    side takes the load off the one that has to stand; for later ones of balance outside."""
    max_step: float = 1.05
    """Half-axis of the ellipse of positions before the other foot, and to its side [leg lengths].
    Chosen (±20 %: deviation 23 %)."""
    max_step_back: float = 0.72
    """The same behind the other foot [leg lengths]. Farther back its hip is at the stop and pushes
    the body over the other foot: 1 step became 6."""
    min_step_width: float = 0.17
    """Least lateral distance of a foot from the other [leg lengths]. Chosen (±20 %: deviation
    3 %)."""
    max_leg_extension: float = 0.7
    """Greatest horizontal distance of a foot from the centre of mass [leg lengths]. Chosen (±20 %:
    deviation 15 %)."""
    capture_overshoot: float = 0.12
    """Distance of a footstep beyond the capture point [leg lengths]. Between two feet is more room
    than under one, and pushes last. Without it four steps took the place of one."""
    sole_radius: float = 0.05
    """Distance of the centre of pressure from the middle of a sole, at most [m]. Chosen (±20 %: not
    met)."""
    support_margin: float = 0.015
    """Distance of desired pressure and centre of mass from the edge of the support [m]. Chosen (±20
    %: deviation 72 %)."""
    capture_error_cost: float = 0.5
    """Cost of the capture error after this step, that after the last one costing 1. Chosen: without
    it, pushes of 180 N to eight sides took 20 steps and a fall in place of 15 steps."""
    rest_speed: float = 0.2
    """Speed of the centre of mass below which the body may be at rest after its steps [m/s].
    Chosen (±20 %: below 2 %)."""

    @property
    def capture_threshold(self) -> float:
        """Distance of the capture point outside the support at which a first step begins [m]."""
        return -self.capture_margin

    @property
    def step_time(self) -> float:
        """Least time from one touchdown to the next [s]."""
        return self.swing_durations[0] + 2.0 * self.load_transfer_duration

    def reached(self, duration: float) -> float:
        """Return how far a foot gets in a time, on a cubic from rest to rest [m]."""
        return self.max_foot_acceleration * duration**2 / 6


@dataclass(frozen=True, eq=False)
class PlannedStep:
    """A planned step."""

    side: int  #: The foot, 0 for the right one, 1 for the left one
    #: Position of the middle of its sole at touchdown, over the ground [m]
    position: Float[Array, " 2"]
    duration: float  #: Time until then [s]
    capture_error: float  #: Distance of the desired pressure from what both feet span [m]
    remaining_error: float = 0.0  #: The same after the steps that follow [m]
    cost: float = 0.0  #: Cost by which footsteps are compared [m]


class StepPlanner:
    """Plans recovery steps of one person; ``leg_length`` is the length of a leg [m]."""

    def __init__(self, leg_length: float, settings: StepSettings | None = None):
        self.leg_length, self.settings = leg_length, settings or StepSettings()
        s = self.settings
        self.min_width = s.min_step_width * leg_length
        self.width_range = (s.max_step - s.min_step_width) * leg_length
        self.max_forward = s.max_step * leg_length
        self.max_back = s.max_step_back * leg_length
        self.max_extension = s.max_leg_extension * leg_length
        self.overshoot = s.capture_overshoot * leg_length
        x = leg_length * np.linspace(-s.max_step_back, s.max_step, N_AHEAD)
        y = leg_length * np.linspace(s.min_step_width, s.max_step, N_ASIDE)
        self._grid = x[:, None, None], y[None, :, None]

    def lowering(self, distance: float) -> float:
        """Return how much lower the hips are for a leg to reach a foot at a distance [m].

        Args:
            distance: Horizontal distance of the foot from the hips [m].
        """
        reach = min(distance, self.max_extension)
        return self.leg_length - float(np.sqrt(self.leg_length**2 - reach**2))

    def plan(self, now: PendulumState, sides: Sequence[int] = (0, 1)) -> PlannedStep:
        """Return the footstep with the least cost."""
        durations = self.settings.swing_durations
        found = [self.footstep(now, side, time) for side in sides for time in durations]
        return min(found, key=lambda each: each.cost)

    def footstep(
        self,
        now: PendulumState,
        side: int,
        duration: float,
        *,
        swinging: bool = False,
        velocity: Float[Array, " 2"] | None = None,
    ) -> PlannedStep:
        """Return the best footstep of one foot and one duration.

        Args:
            duration: Time until touchdown [s].
            swinging: Whether the foot is in the air already; only the position nearest to the
                desired one is considered then.
            velocity: Velocity of a swinging foot over the ground, which limits what it can reach;
                no limit if absent [m/s].
        """
        s, other = self.settings, 1 - side
        pivot, disturbed = now.pressure[other], 1.0 / now.omega
        elapsed = duration + s.load_transfer_duration
        capture, com = now.moved(pivot, now.capture_point, now.com, elapsed, disturbed)
        desired = self._overshot(capture, pivot) + now.remaining_shift(disturbed - elapsed)
        accelerated = s.reached(duration)
        if swinging:
            tried = self.within_reach(now, side, desired[None])
            if velocity is not None:
                glides = now.feet[side] + velocity * duration * 2 / 3
                tried = drawn_to(tried, glides, accelerated)
        else:
            x, y = self._grid
            grid = now.feet[other] + (x * now.heading + y * _outward(now, side)).reshape(-1, 2)
            tried = self.within_reach(now, side, np.vstack([desired, grid]))
            tried = drawn_to(tried, now.feet[side], accelerated)
        tried = self.within_reach(now, side, drawn_to(tried, com, self.max_extension))
        first = self._error(desired, now.feet[other], tried)
        feet = np.empty((len(tried), 2, 2))
        feet[:, side], feet[:, other] = tried, now.feet[other]
        remaining = self._remaining(now, feet, side, capture, first, elapsed)
        overextended = max(float(np.linalg.norm(com - now.feet[other])) - self.max_extension, 0.0)
        cost = remaining + s.capture_error_cost * first + overextended
        k = int(cost.argmin())
        return PlannedStep(
            side, tried[k], duration, float(first[k]), float(remaining[k]), float(cost[k])
        )

    def _remaining(
        self,
        now: PendulumState,
        feet: Array,
        side: int,
        capture: Array,
        error: Array,
        elapsed: float,
    ) -> Array:
        """Return the capture errors after the steps that follow, each as fast as can be [m]."""
        s, swing = self.settings, self.settings.swing_durations[0]
        disturbed = 1.0 / now.omega
        for _ in range(s.n_steps - 1):
            left = disturbed - elapsed
            stance = feet[:, side]
            aims = np.broadcast_to(capture + now.remaining_shift(left), stance.shape)
            pivots = stance + drawn_to(aims - stance, np.zeros(2), s.sole_radius)
            capture, _ = now.moved(pivots, capture, capture, s.step_time, left)
            elapsed += s.step_time
            aim = self._overshot(capture, pivots) + now.remaining_shift(disturbed - elapsed)
            side = 1 - side
            limited = drawn_to(
                self._reached(stance, now, side, aim), feet[:, side], s.reached(swing)
            )
            feet[:, side] = self._reached(stance, now, side, limited)
            # A captured body needs no further step.
            error = np.where(error < 1e-9, 0.0, self._error(aim, stance, feet[:, side]))
        return error

    def within_reach(
        self, now: PendulumState, side: int, position: Float[Array, "*k 2"]
    ) -> Float[Array, "*k 2"]:
        """Return the nearest positions that a foot reaches, on its own side of the other foot."""
        return self._reached(now.feet[1 - side], now, side, position)

    def _reached(self, stance: Array, now: PendulumState, side: int, position: Array) -> Array:
        """Return positions drawn into the half-ellipse to the side of a stance foot."""
        ahead, outward = now.heading, _outward(now, side)
        offset = position - stance
        x, y = offset @ ahead, np.maximum(offset @ outward, self.min_width)
        aside = (y - self.min_width) / self.width_range
        size = np.hypot(x / np.where(x > 0, self.max_forward, self.max_back), aside)
        shrink = 1.0 / np.maximum(size, 1.0)
        y = self.min_width + (y - self.min_width) * shrink
        return stance + (x * shrink)[..., None] * ahead + y[..., None] * outward

    def _overshot(self, capture: Array, pivot: Array) -> Array:
        """Return the desired position of a foot for a capture point: a little beyond it."""
        away = capture - pivot
        distance = np.linalg.norm(away, axis=-1, keepdims=True)
        return capture + self.overshoot * away / np.maximum(distance, 1e-9)

    def _error(self, desired: Array, stance: Array, foot: Array) -> Array:
        """Return the distance of the desired pressure from what two feet span [m]."""
        along = foot - stance
        length = np.maximum((along**2).sum(axis=-1), 1e-9)
        part = ((desired - stance) * along).sum(axis=-1) / length
        nearest = stance + np.clip(part, 0.0, 1.0)[..., None] * along
        distance = np.linalg.norm(desired - nearest, axis=-1)
        return np.maximum(distance - self.settings.sole_radius, 0.0)


def _outward(now: PendulumState, side: int) -> Array:
    """Return the direction from the other foot to a foot."""
    return -now.left if side == 0 else now.left
