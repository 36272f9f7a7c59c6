r"""Balance as [Park2020]_ has it: accelerations by least squares, carried out by hybrid dynamics.

At every tick the accelerations are (Eq. 6)

.. math:: \ddot\theta^* = \arg\min w_t C_t + w_l C_l + w_h C_h
    \quad \text{subject to} \quad a_{sup} = J_{sup}\ddot\theta + \dot J_{sup}\dot\theta

with tracking of a posture, linear and angular momentum as objectives, and :math:`a_{sup}` a spring
and damper for the place and orientation of every supporting segment (Eq. 7). The world carries them
out by :class:`~plantigrade.world.Acceleration`: it solves contacts together with joints that move
as told, and reports the torques that this takes.

What the paper leaves open, and what is done here:

* Weights and gains are not printed. Those here stand in :class:`HybridWeights`: momentum goes far
  before posture. (With weights of one, pushes of two thirds the size are withstood.)
* The desired angular momentum is that of [Macchietto2009]_, whose system it is: none, as long as
  the force that the linear one asks for acts within the base of support; else the moment that
  brings it there. That is what swings trunk and arms.
* The constraint has more rows than a foot has degrees of freedom (four segments, 24 rows, 18
  degrees), so that plain Lagrange multipliers are singular. They are damped.
* How the force of the ground enters the "floating-base hybrid dynamics" is not said. Taken from the
  last step, everything falls; solved in the same step, as here, it stands.
* Joints stop within their ranges; the paper's had no limits.
* Joint torques are not limited, as there: the motor is an ideal one. What it would take is a signal
  of the record, and so is how many joints are beyond the strength of the person.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import ConvexHull

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance.carried import held
from plantigrade.control.balance.reference import Reference, Wanted
from plantigrade.control.balance.weights import FOOT
from plantigrade.kinematics.state import CROSS, PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.world import Acceleration, State

RATE = 30.0
"""Commands per second of the paper [1/s]."""
DAMPED = 1e-6
"""Damping of the multipliers of the constraint, by the mean of its diagonal."""
STOPPING = 40.0
"""Deceleration with which joints stop before the end of their range [rad/s²]."""
ROUNDS = 4
"""So often least squares are done anew with those joints held that went too fast."""
LEVER = 0.25
"""Radius of gyration of a body, of its height: makes angular momentum an angular acceleration."""


@dataclass(frozen=True, kw_only=True)
class HybridWeights:
    """Weights and gains, one set for all that is done standing.

    Attributes:
        root: Weight of the orientation of the pelvis; that of every hinge is 1.
        linear: Weight of the acceleration of the centre of mass [(rad/m)²].
        angular: Weight of the rate of angular momentum, divided by the inertia of a body of radius
            of gyration :data:`LEVER`.
        posture: Gain of the posture [1/s²]; damped critically.
        foot: The same of joints within the foot.
        com: Gain of the centre of mass [1/s²].
        com_damping: Its damping [1/s].
        spin: How fast angular momentum is to fade [1/s].
        inside: So far inside the base of support pressure is to stay [m].
        support: Gain of supporting segments, the paper's :math:`k_s` [1/s²]; damped critically.
    """

    root: float = 0.05
    linear: float = 1e4
    angular: float = 1e4
    posture: float = 80.0
    foot: float = 200.0
    com: float = 25.0
    com_damping: float = 10.0
    spin: float = 5.0
    support: float = 28.0
    inside: float = 0.01


class Hybrid:
    """Keeps standing in a posture by the paper's own formulation.

    Args:
        reference: What is to be done; the posture of the first state if absent. What presses in it
            supports.
        weights: Weights and gains.
    """

    def __init__(self, reference: Reference | None = None, weights: HybridWeights | None = None):
        self.weights, self.reference = weights or HybridWeights(), reference
        self._posture: _Posture | None = None

    def __call__(self, state: State) -> Acceleration:
        """Return the accelerations of the hinges."""
        if self._posture is None or state.time == 0.0:
            self._posture = _Posture(
                state, self.reference or held(state.world, np.array(state.qpos))
            )
        reference = self._posture
        reference.follow(state.time)
        qacc, missed = accelerations(state, reference, self.weights)
        beyond = _beyond(state)
        signals = {
            "support_residual": missed,
            "com_error": float(np.linalg.norm(state.body.com[:2] - reference.com[:2])),
            "joints_beyond_strength": float(beyond.sum()),
        }
        return Acceleration(qacc[6:], signals=signals)


def accelerations(
    state: State, reference: "_Posture", weights: HybridWeights
) -> tuple[Float[Array, " nv"], float]:
    """Return the accelerations of Eq. 6, and how far they miss the constraint [m/s², rad/s²]."""
    w, body = weights, state.body
    nv, mass = len(state.qvel), state.human.mass
    off = -body.difference(reference.qpos)  # to the reference
    gain = np.r_[np.full(6, w.posture), np.where(reference.within, w.foot, w.posture)]
    wanted = reference.qacc + gain * off + 2 * np.sqrt(gain) * (reference.qvel - state.qvel)
    weight = np.r_[np.zeros(3), np.full(3, w.root), np.ones(nv - 6)]
    Q, g = np.diag(weight), weight * wanted

    J = body.com_jacobian
    pull = w.com * (reference.com - body.com)
    pull += w.com_damping * (reference.speed - body.com_velocity)
    pull -= body.com_bias_acceleration
    Q += w.linear * J.T @ J
    g += w.linear * J.T @ pull

    unit = mass * (LEVER * state.human.height) ** 2
    H, bias = _spin(body)
    slow = -w.spin * body.angular_momentum - bias
    slow += reference.moment(body.com, pull + body.com_bias_acceleration, mass, w.inside)
    Q += w.angular / unit**2 * H.T @ H
    g += w.angular / unit**2 * H.T @ slow

    J, pull = reference.support(state, w.support)
    low, high = _bounds(state)
    free, qacc = np.ones(nv, bool), np.zeros(nv)
    for _ in range(ROUNDS):
        qacc[free] = _constrained(
            Q[np.ix_(free, free)], g[free] - Q[np.ix_(free, ~free)] @ qacc[~free],
            J[:, free], pull - J[:, ~free] @ qacc[~free],
        )  # fmt: skip
        beyond = free & ((qacc < low) | (qacc > high))
        if not beyond.any():
            break
        qacc[beyond] = np.clip(qacc, low, high)[beyond]
        free &= ~beyond
    return qacc, float(np.linalg.norm(J @ qacc - pull))


def _constrained(
    Q: Float[Array, "n n"], g: Float[Array, " n"], J: Float[Array, "m n"], pull: Float[Array, " m"]
) -> Float[Array, " n"]:
    """Return the least of a quadratic form under constraints that may depend on each other."""
    factor = cho_factor(Q)
    if not len(J):
        return cho_solve(factor, g)
    free, across = cho_solve(factor, g), cho_solve(factor, J.T)
    dual = J @ across
    dual[np.diag_indices_from(dual)] += DAMPED * np.trace(dual) / len(dual)
    return free + across @ np.linalg.solve(dual, pull - J @ free)


def _bounds(state: State) -> tuple[Float[Array, " nv"], Float[Array, " nv"]]:
    """Return the accelerations with which every hinge can still stop within its range."""
    step, (low, high) = 1.0 / state.world.control_rate, state.human.limits
    ahead = state.angles + step * state.rates
    least = (-np.sqrt(2 * STOPPING * np.maximum(ahead - low, 0.0)) - state.rates) / step
    most = (np.sqrt(2 * STOPPING * np.maximum(high - ahead, 0.0)) - state.rates) / step
    root = np.full(6, np.inf)
    return np.r_[-root, np.minimum(least, most)], np.r_[root, np.maximum(least, most)]


def _spin(body: BodyState) -> tuple[Float[Array, "3 nv"], Float[Array, " 3"]]:
    """Return what the rate of angular momentum about the centre of mass is made of.

    The moment that moves the root, about its origin and in its axes, less that of the force there.
    """
    arm, turn = body.com - body.qpos[:3], body.rotation(1)
    M, h = body.mass_matrix, body.bias
    across = (arm @ CROSS).reshape(3, 3)
    return turn @ M[3:6] - across @ M[:3], turn @ h[3:6] - across @ h[:3]


def _cross(a: Float[Array, "*n 3"], b: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
    """Return cross products; without what NumPy's does beside."""
    i, j = [1, 2, 0], [2, 0, 1]
    return a[..., i] * b[..., j] - a[..., j] * b[..., i]


def _beyond(state: State) -> Bool[Array, " n_hinges"]:
    """Return which motors of the last step were beyond the strength of the person."""
    low, high = state.human.model.jnt_actfrcrange[1:].T
    torque = state.world.actuators.motor_torques(state.world.data)
    return (torque < low) | (torque > high)


class _Posture:
    """What is wanted at a time.

    Attributes:
        qpos: The posture.
        qvel: Its rate.
        qacc: The rate of that.
        com: Where its centre of mass is [m].
        speed: How fast that moves [m/s].
        within: Which hinges are within the feet.
        hull: Corners of the base of support, counterclockwise [m].
        level: Its height [m].
    """

    def __init__(self, state: State, reference: Reference):
        human = state.human
        self.reference, self.sites = reference, contact_sites(human)
        self._spheres = PointSet.of(human, self.sites)
        self.within = np.array([c.startswith(FOOT) for c in human.coordinates])
        self._body = BodyState(human, state.qpos)
        self._wanted: Wanted | None = None
        self._pressing: bytes | None = None

    def follow(self, time: float) -> None:
        """Go on to what is wanted now."""
        wanted = self.reference.at(time)
        if wanted is self._wanted:
            return
        self._wanted = wanted
        self._body = body = self._body.moved_to(wanted.qpos, wanted.qvel)
        self.qpos, self.qvel, self.qacc = wanted.qpos, wanted.qvel, wanted.qacc
        self.com, self.speed = body.com, body.com_velocity
        presses = wanted.presses
        if presses.tobytes() != self._pressing:
            self._pressing, human = presses.tobytes(), body.human
            carried = {s.body for s, on in zip(self.sites, presses, strict=True) if on}
            names = [name for name in human.body_names if name in carried]
            self.segments = [human.body(name) for name in names]
            self.points = PointSet(human, names, np.zeros((len(names), 3)))
        soles = body.position(self._spheres)[presses]
        self.hull = soles[:0, :2]
        if len(soles) > 2:
            self.hull = soles[ConvexHull(soles[:, :2]).vertices, :2]
            self.level = float(soles[:, 2].mean())
        self._place, self._turn = body.origins[self.segments], body.rotations[self.segments]
        self._rate = self._jacobian(body) @ wanted.qvel

    def moment(
        self, com: Float[Array, " 3"], acceleration: Float[Array, " 3"], mass: float, margin: float
    ) -> Float[Array, " 3"]:
        """Return the moment about the centre of mass that keeps pressure in the base of support.

        None where the acceleration alone keeps it there; else what brings it to the nearest point
        that is inside by a margin, as in [Macchietto2009]_ [N m].
        """
        lift = GRAVITY + acceleration[2]
        if not len(self.hull):
            return np.zeros(3)
        needed = com[:2] - (com[2] - self.level) * acceleration[:2] / lift
        off = inside(self.hull, needed, margin) - needed
        return mass * lift * np.array([off[1], -off[0], 0.0])

    def support(
        self, state: State, gain: float
    ) -> tuple[Float[Array, "n_rows nv"], Float[Array, " n_rows"]]:
        """Return the Jacobian of the supporting segments, and what it is to give (Eq. 7)."""
        body = state.body
        J, now = self._jacobian(body), body.rotations[self.segments]
        turned = 0.5 * _cross(now.swapaxes(1, 2), self._turn.swapaxes(1, 2)).sum(axis=1)
        off = np.hstack([self._place - body.origins[self.segments], turned]).ravel()
        names = body.human.body_names
        turning = [body.angular_bias_acceleration(names[i - 1]) for i in self.segments]
        bias = np.hstack([body.bias_acceleration(self.points), np.reshape(turning, (-1, 3))])
        slow = 2 * np.sqrt(gain) * (self._rate - J @ state.qvel)
        return J, gain * off + slow - bias.ravel()

    def _jacobian(self, body: BodyState) -> Float[Array, "n_rows nv"]:
        """Return the Jacobian of place and orientation of the segments."""
        spins = [body.angular_jacobian(i) for i in self.segments]
        turning = np.reshape(spins, (-1, 3, body.model.nv))
        rows = np.concatenate([body.jacobian(self.points), turning], axis=1)
        return rows.reshape(-1, body.model.nv)


def inside(
    hull: Float[Array, "n 2"], point: Float[Array, " 2"], margin: float
) -> Float[Array, " 2"]:
    """Return a point, moved into a convex polygon by projections on the edges it lies beyond.

    Args:
        hull: Corners, counterclockwise.
        point: The point.
        margin: So far inside it is to be.
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
