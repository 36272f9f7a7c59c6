"""Violations of a motion of the paper between its sample times.

The paper states all conditions at 4 to 7 instants and shows curves in between. Here the same motion
is looked at on a grid ten times as fine, by MuJoCo's inverse dynamics, not by the functions that it
was optimised with. A foot counts as standing where Λ is one at both neighbouring samples and it
has not moved; what it can then do is judged generously: the support polygon is the convex hull of
all its contact points. The remainder cannot come from contact with the ground.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.spatial.conventions import rotation_matrix
from plantigrade.trajopt.zhakatayev2023 import conditions
from plantigrade.trajopt.zhakatayev2023.conditions import MAX_LOAD, MAX_RATE, MAX_TORQUE
from plantigrade.trajopt.zhakatayev2023.formulation import PaperProblem
from plantigrade.trajopt.zhakatayev2023.polygons import convex, outside

REFINEMENT_FACTOR = 10  # [1] instants examined per sample of the conditions


@dataclass(frozen=True, eq=False)
class Between:
    """Faults on the finer grid, each at its worst; zero where there is none."""

    zmp: float  # how far the zero-moment point is outside the hull of the standing feet [m]
    moment: float  # the root moment that is therefore unexplained, part of body weight times metre
    pull: float  # the vertical force that pulls at the ground, part of body weight
    load: float  # vertical force beyond 1.4 body weights, part of body weight
    # largest horizontal force over vertical force, where at least a tenth of the body weight is
    # carried
    friction: float
    penetration: float  # how deep a contact point is in the ground [m]
    drift: float  # how far a point of a standing foot is from its place [m]
    angle: float  # how far a coordinate is beyond its limits [rad, m]
    rate: float  # how far a rate is beyond ±5 [rad/s]
    torque: float  # how far a joint torque is beyond ±200 [N m]


@dataclass(frozen=True, eq=False)
class Course:
    """A motion on the finer grid."""

    times: Float[Array, " n_times"]  # the grid [s]
    q: Float[Array, "n_times nv"]  # coordinates [rad, m]
    qd: Float[Array, "n_times nv"]  # rates [rad/s, m/s]
    # force on the body and moment about the pelvis required by the motion, world axes [N, N m]
    wrench: Float[Array, "n_times 6"]
    torques: Float[Array, "n_times n_hinges"]  # torques of the joints [N m]
    # zero-moment point, NaN where nothing is carried [m]
    zmp: Float[Array, "n_times 2"]
    points: Float[Array, "n_times 12 3"]  # contact points [m]


def course(paper: PaperProblem, c: Float[Array, "n_coefficients nv"]) -> Course:
    """Return a motion on a grid ten times as fine as its samples."""
    body, motion = paper.body, paper.motion
    times = np.linspace(0.0, motion.duration, (motion.n_samples - 1) * REFINEMENT_FACTOR + 1)
    q, qd, qdd = paper.problem.states(c, times)
    qpos, qvel, qacc = body.symbolic.to_mujoco(q, qd, qdd)
    tau = inverse_dynamics(body.human, qpos, qvel, qacc).tau
    moment = np.einsum("nij,nj->ni", rotation_matrix(qpos[:, 3:7]), tau[:, 3:6])
    force = tau[:, :3]
    pelvis = np.column_stack([q[:, 3], -q[:, 5], q[:, 4]])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = pelvis[:, 0] - (pelvis[:, 2] * force[:, 0] + moment[:, 1]) / force[:, 2]
        y = pelvis[:, 1] - (pelvis[:, 2] * force[:, 1] - moment[:, 0]) / force[:, 2]
    zmp = np.column_stack([x, y])
    zmp[force[:, 2] < 1e-6 * body.weight] = np.nan
    positions = body.symbolic.positions(body.contacts).map(len(times))(q.T).full()
    points = positions.T.reshape(len(times), 12, 3)
    return Course(times, q, qd, np.hstack([force, moment]), tau[:, 6:], zmp, points)


def between(paper: PaperProblem, c: Float[Array, "n_coefficients nv"]) -> Between:
    """Return the faults of a motion on the finer grid."""
    body, motion, k = paper.body, paper.motion, course(paper, c)
    places, stands = conditions.footholds(body, motion), conditions.standing(motion)
    still = stands[1:] & stands[:-1] & (places[1:] == places[:-1]).all(axis=2)
    zmp = moment = drift = 0.0
    for i in range(len(k.times)):
        sample, inside = divmod(i, REFINEMENT_FACTOR)
        where = places[sample]
        on = still[sample] if inside else stands[sample]
        drift = max(drift, float(np.abs(k.points[i] - where)[on].max(initial=0.0)))
        if on.any() and np.isfinite(k.zmp[i]).all():
            far = max(float(outside(k.zmp[i][None], convex(where[on, :2]))[0]), 0.0)
            lever = far * float(k.wrench[i, 2]) / body.weight
            if lever > moment:
                zmp, moment = far, lever
    force = k.wrench[:, :3] / body.weight
    carried = force[:, 2] > 0.1
    low, high = conditions.limits(body, motion, paper.start, paper.end)
    return Between(
        zmp=zmp,
        moment=moment,
        pull=_over(-force[:, 2]),
        load=_over(force[:, 2] - MAX_LOAD),
        friction=float(np.max(np.linalg.norm(force[carried, :2], axis=1) / force[carried, 2])),
        penetration=_over(-k.points[..., 2]),
        drift=drift,
        angle=_over(np.maximum(low - k.q, k.q - high)),
        rate=_over(np.abs(k.qd) - MAX_RATE),
        torque=_over(np.abs(k.torques) - MAX_TORQUE),
    )


def _over(values: Array) -> float:
    return max(float(np.max(values)), 0.0)
