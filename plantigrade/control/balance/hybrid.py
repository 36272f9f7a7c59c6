r"""Balance as [Park2020]_ has it: accelerations by least squares, carried out by hybrid dynamics.

At every tick the accelerations are (Eq. 6)

.. math:: \ddot\theta^* = \arg\min w_t C_t + w_l C_l + w_h C_h
    \quad \text{subject to} \quad a_{sup} = J_{sup}\ddot\theta + \dot J_{sup}\dot\theta

with tracking of a posture, linear and angular momentum as objectives, and :math:`a_{sup}` a
spring and damper for the position and orientation of every supporting segment (Eq. 7). The world
carries them out by :class:`~plantigrade.world.Acceleration`: it solves contacts together with
joints that move as commanded, and reports the torques that this takes.

The paper leaves open, and this module adds:

* Weights and gains are not printed. Those of :class:`HybridSettings` put momentum far before
  posture. (With weights of one, pushes of two thirds the size are withstood.)
* The desired angular momentum is that of [Macchietto2009]_, whose system it is: none, as long as
  the force of the linear one acts within the base of support; else the moment that
  brings it there. That is what swings trunk and arms.
* The constraint has more rows than a foot has degrees of freedom (four segments, 24 rows, 18
  degrees), so that plain Lagrange multipliers are singular. They are damped.
* The paper does not say how the ground force enters the "floating-base hybrid dynamics". Taken from
  the last step, everything falls; solved in the same step, as here, it stands.
* Joints stop within their ranges; the paper's had no limits.
* Joint torques are not limited, as there: the motor is an ideal one. Its torque
  and the number of joints beyond the strength of the person are signals of the record.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import ConvexHull

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance.reference import Reference, ReferenceState, posture_reference
from plantigrade.control.balance.settings import BalanceSettings, JointGains, JointStopSettings
from plantigrade.control.gait.step import StepSettings
from plantigrade.kinematics.state import CROSS, BodyState, PointSet
from plantigrade.wbc.tasks.point import axis_error
from plantigrade.world import Acceleration, Controller, State

MAX_SOLVES = 4  # of a tick: joints too fast for their range are held
REGULARISATION = 1e-6  # of the multipliers of the constraint, by the mean of its diagonal


@dataclass(frozen=True, kw_only=True)
class HybridSettings:
    """Weights and gains, one set for all that is done standing; the weight of a hinge is 1."""

    momentum_weight: float = BalanceSettings.com_weight
    """Weight of the acceleration of the centre of mass [(rad/m)²], and of the rate of angular
    momentum over the inertia of the body; as for balance."""
    pelvis_weight: float = BalanceSettings.pelvis_weight
    """Weight of the orientation of the pelvis; as for balance."""
    joint_gains: JointGains = JointGains()
    """Stiffness about the posture."""
    com_gain: float = 25.0
    """Stiffness of the centre of mass, critically damped; angular momentum decays at the rate of
    its root [1/s²]. Chosen: with the 50 of balance, 9 of 16 pushes of 35 and 45 N were withstood in
    place of 14."""
    support_gain: float = 28.0
    """Stiffness of supporting segments, :math:`k_s` of the paper, critically damped [1/s²]."""
    support_margin: float = StepSettings.support_margin
    """Distance of the centre of pressure from the edge of the support [m]; as for balance."""
    stopping_deceleration: float = JointStopSettings.gain * JointStopSettings.distance
    """Deceleration with which joints stop before the end of their range [rad/s²]; that with which
    balance begins to slow them."""


class Hybrid(Controller):
    """Keeps standing in a posture by the paper's own formulation.

    Args:
        reference: Reference to follow; the posture of the first state if absent. The spheres on the
            ground in it support.
        settings: Weights and gains.
    """

    def __init__(
        self, reference: Reference | None = None, *, settings: HybridSettings | None = None
    ):
        self.reference, self.settings = reference, settings or HybridSettings()
        self._tracked: _Tracked | None = None

    def __call__(self, state: State) -> Acceleration:
        """Return the accelerations of the hinges."""
        if self._tracked is None or state.time == 0.0:
            posture = self.reference or posture_reference(state.world, np.array(state.qpos))
            self._tracked = _Tracked(state, posture, self.settings)
        tracked = self._tracked
        tracked.follow(state.time)
        qacc, residual = accelerations(state, tracked, self.settings)
        signals = {
            "support_residual": residual,
            "com_error": float(np.linalg.norm(state.body.com[:2] - tracked.com[:2])),
            "joints_beyond_strength": float(_beyond_strength(state).sum()),
        }
        return Acceleration(qacc[6:], signals=signals)


def accelerations(
    state: State, tracked: "_Tracked", settings: HybridSettings
) -> tuple[Float[Array, " nv"], float]:
    """Return the accelerations of Eq. 6, and how far they miss the constraint [m/s², rad/s²]."""
    s, body = settings, state.body
    nv, mass = len(state.qvel), state.human.mass
    error, gain = -body.difference(tracked.qpos), tracked.gain
    desired = tracked.qacc + gain * error + 2 * np.sqrt(gain) * (tracked.qvel - state.qvel)
    weight = np.r_[np.zeros(3), np.full(3, s.pelvis_weight), np.ones(nv - 6)]
    Q, g = np.diag(weight), weight * desired

    J = body.com_jacobian
    right = s.com_gain * (tracked.com - body.com)
    right += 2 * np.sqrt(s.com_gain) * (tracked.com_velocity - body.com_velocity)
    right -= body.com_bias_acceleration
    Q += s.momentum_weight * J.T @ J
    g += s.momentum_weight * J.T @ right

    inertia = float(np.linalg.norm(body.angular_momentum_jacobian[:, 3:6], 2))
    H, bias = _momentum_rate(body)
    rate = -np.sqrt(s.com_gain) * body.angular_momentum - bias
    rate += tracked.moment(body.com, right + body.com_bias_acceleration, mass)
    Q += s.momentum_weight / inertia**2 * H.T @ H
    g += s.momentum_weight / inertia**2 * H.T @ rate

    J, right = tracked.support(state)
    low, high = _bounds(state, s.stopping_deceleration)
    free, qacc = np.ones(nv, bool), np.zeros(nv)
    for _ in range(MAX_SOLVES):
        qacc[free] = _constrained(
            Q[np.ix_(free, free)], g[free] - Q[np.ix_(free, ~free)] @ qacc[~free],
            J[:, free], right - J[:, ~free] @ qacc[~free],
        )  # fmt: skip
        beyond = free & ((qacc < low) | (qacc > high))
        if not beyond.any():
            break
        qacc[beyond] = np.clip(qacc, low, high)[beyond]
        free &= ~beyond
    return qacc, float(np.linalg.norm(J @ qacc - right))


def _constrained(
    Q: Float[Array, "n n"], g: Float[Array, " n"], J: Float[Array, "m n"], right: Float[Array, " m"]
) -> Float[Array, " n"]:
    """Return the least of a quadratic form under constraints that may depend on each other."""
    factor = cho_factor(Q)
    if not len(J):
        return cho_solve(factor, g)
    free, across = cho_solve(factor, g), cho_solve(factor, J.T)
    dual = J @ across
    dual[np.diag_indices_from(dual)] += REGULARISATION * np.trace(dual) / len(dual)
    return free + across @ np.linalg.solve(dual, right - J @ free)


def _bounds(state: State, deceleration: float) -> tuple[Float[Array, " nv"], Float[Array, " nv"]]:
    """Return the accelerations with which every hinge can still stop within its range."""
    step, (low, high) = 1.0 / state.world.control_rate, state.human.limits
    next_angles = state.angles + step * state.rates
    slowest = np.sqrt(2 * deceleration * np.maximum(next_angles - low, 0.0))
    fastest = np.sqrt(2 * deceleration * np.maximum(high - next_angles, 0.0))
    least, most = (-slowest - state.rates) / step, (fastest - state.rates) / step
    root = np.full(6, np.inf)
    return np.r_[-root, np.minimum(least, most)], np.r_[root, np.maximum(least, most)]


def _momentum_rate(body: BodyState) -> tuple[Float[Array, "3 nv"], Float[Array, " 3"]]:
    """Return matrix and bias of the rate of angular momentum about the centre of mass.

    The moment that moves the root, about its origin and in its axes, less that of the force there.
    """
    arm, rotation = body.com - body.qpos[:3], body.rotation(1)
    M, h = body.mass_matrix, body.bias
    across = (arm @ CROSS).reshape(3, 3)
    return rotation @ M[3:6] - across @ M[:3], rotation @ h[3:6] - across @ h[:3]


def _beyond_strength(state: State) -> Bool[Array, " n_hinges"]:
    """Return which motors of the last step were beyond the strength of the person."""
    low, high = state.human.model.jnt_actfrcrange[1:].T
    torque = state.world.actuators.motor_torques(state.world.data)
    return (torque < low) | (torque > high)


class _Tracked:
    """The reference at a time.

    Attributes:
        qpos: Configuration.
        qvel: Its velocity.
        qacc: Its acceleration.
        gain: Stiffness of every coordinate [1/s²].
        com: Centre of mass [m].
        com_velocity: Its velocity [m/s].
        hull: Corners of the support polygon, counterclockwise [m].
        ground_height: Its height [m].
    """

    def __init__(self, state: State, reference: Reference, settings: HybridSettings):
        human, self.settings = state.human, settings
        self.reference, self.sites = reference, contact_sites(human)
        self._spheres = PointSet.of(human, self.sites)
        self.gain = settings.joint_gains.of(human)
        self._body = BodyState(human, state.qpos)
        self._state: ReferenceState | None = None
        self._contact: bytes | None = None

    def follow(self, time: float) -> None:
        """Go on to a time since the start [s]."""
        state = self.reference.at(time)
        if state is self._state:
            return
        self._state = state
        self._body = body = self._body.moved_to(state.qpos, state.qvel)
        self.qpos, self.qvel, self.qacc = state.qpos, state.qvel, state.qacc
        self.com, self.com_velocity = body.com, body.com_velocity
        contact = state.contact
        if contact.tobytes() != self._contact:
            self._contact, human = contact.tobytes(), body.human
            loaded = {s.body for s, on in zip(self.sites, contact, strict=True) if on}
            names = [name for name in human.body_names if name in loaded]
            self.segments = [human.body(name) for name in names]
            self.points = PointSet(human, names, np.zeros((len(names), 3)))
        soles = body.position(self._spheres)[contact]
        self.hull = soles[:0, :2]
        if len(soles) > 2:
            self.hull = soles[ConvexHull(soles[:, :2]).vertices, :2]
            self.ground_height = float(soles[:, 2].mean())
        self._origins, self._rotations = body.origins[self.segments], body.rotations[self.segments]
        self._velocity = self._jacobian(body) @ state.qvel

    def moment(
        self, com: Float[Array, " 3"], acceleration: Float[Array, " 3"], mass: float
    ) -> Float[Array, " 3"]:
        """Return the moment about the centre of mass that keeps pressure in the support [N m].

        None where the acceleration alone keeps it there; else what brings it to the nearest point
        that is inside by the margin, as in [Macchietto2009]_.
        """
        lift = GRAVITY + acceleration[2]
        if not len(self.hull):
            return np.zeros(3)
        needed = com[:2] - (com[2] - self.ground_height) * acceleration[:2] / lift
        offset = _into(self.hull, needed, self.settings.support_margin) - needed
        return mass * lift * np.array([offset[1], -offset[0], 0.0])

    def support(self, state: State) -> tuple[Float[Array, "n_rows nv"], Float[Array, " n_rows"]]:
        """Return the Jacobian of the supporting segments, and its right-hand side (Eq. 7)."""
        body, gain = state.body, self.settings.support_gain
        J, now = self._jacobian(body), body.rotations[self.segments]
        turned = axis_error(self._rotations, now)
        error = np.hstack([self._origins - body.origins[self.segments], turned]).ravel()
        names = body.human.body_names
        turning = [body.angular_bias_acceleration(names[i - 1]) for i in self.segments]
        bias = np.hstack([body.bias_acceleration(self.points), np.reshape(turning, (-1, 3))])
        damping = 2 * np.sqrt(gain) * (self._velocity - J @ state.qvel)
        return J, gain * error + damping - bias.ravel()

    def _jacobian(self, body: BodyState) -> Float[Array, "n_rows nv"]:
        """Return the Jacobian of position and orientation of the segments."""
        spins = [body.angular_jacobian(i) for i in self.segments]
        turning = np.reshape(spins, (-1, 3, body.model.nv))
        rows = np.concatenate([body.jacobian(self.points), turning], axis=1)
        return rows.reshape(-1, body.model.nv)


def _into(
    hull: Float[Array, "n 2"], point: Float[Array, " 2"], margin: float
) -> Float[Array, " 2"]:
    """Return a point, moved into a convex polygon by projections on the edges it lies beyond.

    Args:
        hull: Corners, counterclockwise [m].
        point: The point [m].
        margin: Distance to keep from the edges [m].
    """
    along = np.roll(hull, -1, axis=0) - hull
    along /= np.linalg.norm(along, axis=1)[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    for _ in range(len(hull)):
        depth = np.sum(inward * (point - hull), axis=1) - margin
        worst = int(depth.argmin())
        if depth[worst] >= 0.0:
            break
        point = point - depth[worst] * inward[worst]
    return point
