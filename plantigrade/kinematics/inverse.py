r"""Inverse kinematics: the configuration whose points come closest to measured ones.

Per frame, Eq. 1 of [Boukheddimi]_,

.. math:: \min_q \sum_i w_i \lVert x_i^{exp} - x_i(q) \rVert^2
    \quad \text{s.t.} \quad \underline q \le q \le \bar q,

solved by Gauss-Newton steps, each a bounded least-squares problem, so the joint limits are hard.
Coordinates that no marker sees are held by a weak pull towards the standing posture; each frame
starts from where the ones before it lead, and arms that are held out keep their angles as far as
the markers allow (:mod:`plantigrade.kinematics.shoulders`).
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.linalg.lapack import dposv  # pyright: ignore[reportAttributeAccessIssue] (compiled)
from scipy.spatial.transform import Rotation, Slerp

from plantigrade.arrays import Array, Bool, Float
from plantigrade.data_files import named_numbers
from plantigrade.kinematics.shoulders import ShoulderHold
from plantigrade.kinematics.state import BodyState, PointSet, integrate
from plantigrade.models import Human
from plantigrade.motion.filters import bridged_gaps
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import wxyz_to_xyzw, xyzw_to_wxyz

MIN_POINTS = 3  # [1] minimum number of measured points that determine the root

# [m²/rad²] weight of each hinge's deviation from the rest posture; a centimetre of marker error
# equals two radians of posture
POSTURE_WEIGHT = 2.5e-5
# [rad] standard deviation of small joints, which move little and depend on few nearby markers;
# their weight is relative to a marker noise of 6 mm. The lateral rays rotate about 10 deg each way
# against the tarsus in cadavers [Ouzounian1989]_; toes with one marker mainly flex.
SMALL_JOINTS = named_numbers("plantigrade.kinematics", "small_joints.csv")
# [1] number of markers on both segments of a foot joint that replaces its posture weight
MIN_JOINT_MARKERS = 3
_FOOT_JOINTS = ("subtalar_", "ankle_", "heel_", "cuboid_", "mtp")
_NOISE = 0.006  # [m] standard deviation of a measured point


def posture_weights(points: PointSet) -> Float[Array, " n_hinges"]:
    """Return the default weights of the hinges towards the rest posture.

    Its unit is [m^2/rad^2].
    """
    model, human = points.model, points.human
    count = np.bincount(points.body, minlength=model.nbody)
    body = model.jnt_bodyid[1:]
    driven = np.minimum(count[body], count[model.body_parentid[body]]) >= MIN_JOINT_MARKERS
    driven &= human.feet == "multi-segment"
    weights = np.full(len(human.coordinates), POSTURE_WEIGHT)
    for i, name in enumerate(human.coordinates):
        usual = SMALL_JOINTS.get(split_side(name)[0])
        if usual is not None and not (driven[i] and name.startswith(_FOOT_JOINTS)):
            weights[i] = (_NOISE / usual) ** 2
    return weights


class Terms(PointSet):
    """Targets of inverse kinematics, each linear in points fixed to bodies.

    A term is the position of a point, or the vector from one point to another. An orientation is
    two vectors between points of one body.

    Args:
        points: (body name, position in its frame [m]) of each point.
        pairs: End point and start point of each term; -1 as start for a position.
    """

    def __init__(
        self, human: Human, points: list[tuple[str, np.ndarray]], pairs: list[tuple[int, int]]
    ):
        super().__init__(human, [b for b, _ in points], np.array([p for _, p in points]))
        self._to = np.array([a for a, _ in pairs], dtype=int)
        start = np.array([b for _, b in pairs], dtype=int)
        self._vectors = np.flatnonzero(start >= 0)
        self._from = start[self._vectors]

    def values(self, state):
        """Return the terms at a state [m]."""
        return self._combined(state.position(self))

    def jacobian(self, state):
        """Return their Jacobian."""
        return self._combined(state.jacobian(self))

    def _combined(self, values: np.ndarray) -> np.ndarray:
        result = values[self._to]
        result[self._vectors] -= values[self._from]
        return result


@dataclass(frozen=True)
class InverseSolution:
    """Result of inverse kinematics for one frame."""

    qpos: Float[Array, " nq"]  #: The configuration
    #: Distance of each point to its measurement [m]; NaN where not measured
    residual: Float[Array, " n_points"]
    iterations: int  #: Gauss-Newton steps taken


class InverseKinematics:
    """Solves frame after frame, warm-started with the one before.

    Args:
        points: The points on the body that were measured.
        weights: Weight of each point; one each if not given.
        tolerance: Stop when no coordinate moves by more than this in a step [rad, m].
        max_iterations: Steps per frame at most.

    Attributes:
        rest: Posture the hinges are pulled towards [rad]; standing unless set otherwise.
        posture: Strength of that pull on each hinge [m^2/rad^2].
    """

    def __init__(
        self,
        points: PointSet,
        weights: Float[Array, " n_points"] | None = None,
        *,
        tolerance: float = 2e-5,
        max_iterations: int = 60,
    ):
        self.points = points
        self._state = BodyState(points.human, points.human.standing(), model=points.model)
        self.weights = np.ones(len(points.body)) if weights is None else np.asarray(weights, float)
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self.low, self.high = points.human.limits
        self.rest = points.human.standing()[7:]
        self.posture = posture_weights(points)

    def solve(
        self, measured: Float[Array, "n_points 3"], start: Float[Array, " nq"]
    ) -> InverseSolution:
        """Return the configuration closest to ``measured``.

        Args:
            measured: World positions [m]; NaN rows are left out.
        """
        seen = np.all(np.isfinite(measured), axis=1)
        target = np.where(seen[:, None], measured, 0.0)
        w = np.where(seen, self.weights, 0.0)
        root_w = np.sqrt(np.repeat(w, 3))
        q = np.array(start)
        q[7:] = np.clip(q[7:], self.low, self.high)
        damping = 1e-9
        state = self._state.moved_to(q)
        cost = self._cost(state, target, w)
        iterations = 0
        for iterations in range(1, self.max_iterations + 1):  # noqa: B007 (reported below)
            J = self.points.jacobian(state).reshape(-1, len(state.qvel)) * root_w[:, None]
            r = (target - self.points.values(state)).ravel() * root_w
            H, g = J.T @ J, J.T @ r
            diagonal = np.einsum("ii->i", H)
            diagonal += damping
            diagonal[6:] += self.posture
            g[6:] += self.posture * (self.rest - q[7:])
            step = bounded_step(H, g, self.low - q[7:], self.high - q[7:])
            candidate = integrate(state.model, q, step)
            candidate[7:] = np.clip(candidate[7:], self.low, self.high)
            reached = state.moved_to(candidate)
            new_cost = self._cost(reached, target, w)
            if new_cost <= cost * (1 + 1e-12) + 1e-16:
                q, state = candidate, reached
                damping = max(damping / 10, 1e-9)
                small = np.abs(step).max() < self.tolerance or cost - new_cost < 1e-5 * cost
                cost = new_cost
                if small:
                    break
            else:
                damping = max(damping * 30, 1e-5)
                if damping > 1e3:
                    break
        away = np.linalg.norm(target - self.points.values(state), axis=1)
        residual = np.where(seen, away, np.nan)
        return InverseSolution(q, residual, iterations)

    def values(self, qpos: Float[Array, " nq"]) -> Float[Array, "n_points 3"]:
        """Return where the points are at a configuration [m]."""
        return self.points.values(self._state.moved_to(qpos))

    def _cost(self, state: BodyState, target, w) -> float:
        error = target - self.points.values(state)
        posture = state.qpos[7:] - self.rest
        return float(w @ np.einsum("ij,ij->i", error, error) + self.posture @ (posture * posture))


def bounded_step(
    H: Float[Array, "nv nv"],
    g: Float[Array, " nv"],
    low: Float[Array, " n_bounded"],
    high: Float[Array, " n_bounded"],
) -> Float[Array, " nv"]:
    r"""Return the minimiser of :math:`\tfrac12 d^T H d - g^T d` with bounds on the last entries.

    A primal active-set method: a hinge that would leave its range is held at the limit; it is
    released when its multiplier changes sign.

    Args:
        H: Positive definite matrix.
        g: Right-hand side.
        low: Lower bounds on the last entries of ``d``, the hinges.
    """
    n = len(g)
    first = n - len(low)
    held = np.full(n, np.nan)
    for _ in range(2 * n):
        free = np.isnan(held)
        d = np.where(free, 0.0, held)
        if free.all():
            _, d, info = dposv(H, g, lower=1)
        else:
            sub = H[np.ix_(free, free)]
            _, x, info = dposv(sub, (g - H @ d)[free], lower=1)
            d[free] = x
        if info:
            return np.zeros(n)
        below, above = d[first:] < low - 1e-12, d[first:] > high + 1e-12
        out = below | above
        if out.any():
            bound = np.where(below, low, high)
            held[first:][out] = bound[out]
            continue
        slope = g - H @ d  # where the solution would go if it were let go
        fixed = ~free[first:]
        inside = fixed & (
            ((held[first:] <= low) & (slope[first:] > 1e-10))
            | ((held[first:] >= high) & (slope[first:] < -1e-10))
        )
        inside &= high > low
        if not inside.any():
            return d
        worst = int(np.argmax(np.where(inside, np.abs(slope[first:]), -1.0)))
        held[first + worst] = np.nan
    return d


def track(
    solver: InverseKinematics,
    measured: Float[Array, "n_frames n_points 3"],
    start: Float[Array, " nq"],
) -> tuple[Float[Array, "n_frames nq"], Float[Array, "n_frames n_points"]]:
    """Solve all frames in order, each from an extrapolation of the two before it.

    A hinge that no point of a frame determines, though points of other frames do, keeps its angle
    while the next frames are solved; afterwards it is interpolated linearly across the gap, as is
    the whole body in frames with fewer than three points.

    Args:
        measured: World positions over time [m]; NaN where not measured.
        start: Configuration to start the first frame from.

    Returns:
        Configurations and the distance of each point to its measurement [m].
    """
    model = solver.points.model
    n = len(measured)
    qpos = np.empty((n, model.nq))
    residual = np.empty(measured.shape[:2])
    previous = start
    velocity = np.zeros(model.nv)
    seen = np.all(np.isfinite(measured), axis=2)
    placed = seen.sum(axis=1) >= MIN_POINTS
    determined = ((seen @ solver.points.moved[:, 0, 6:]) > 0) & placed[:, None]
    lost = ~determined & determined.any(axis=0)
    usual = solver.posture, solver.rest
    hold = ShoulderHold(solver.points.human, *usual)
    for k in range(n):
        if k:
            solver.posture, solver.rest = hold.after(previous[7:])
        if placed[k] or not placed.any():
            guess = integrate(model, previous, velocity)
            solution = solver.solve(measured[k], guess)
            qpos[k], residual[k] = solution.qpos, solution.residual
            qpos[k, 7:][lost[k]] = previous[7:][lost[k]]
            if k:
                mujoco.mj_differentiatePos(model, velocity, 1.0, previous, qpos[k])
        else:
            qpos[k], residual[k], velocity[:] = previous, np.nan, 0.0
        previous = qpos[k]
    solver.posture, solver.rest = usual
    if lost.any() or not placed.all():
        _bridge(qpos, placed, determined)
        for k in np.flatnonzero(lost.any(axis=1) | ~placed):
            distance = np.linalg.norm(measured[k] - solver.values(qpos[k]), axis=1)
            residual[k] = np.where(seen[k], distance, np.nan)
    return qpos, residual


def follow(
    solver: InverseKinematics,
    targets: Float[Array, "n_frames n_terms 3"],
    start: Float[Array, "n_frames nq"],
    *,
    weights: Float[Array, "n_frames n_terms"],
    rest: Float[Array, "n_frames n_hinges"],
) -> Float[Array, "n_frames nq"]:
    """Solve all frames, each from a start of its own, with its own weights and rest posture.

    Args:
        solver: Inverse kinematics on :class:`Terms`.
        targets: Values of the terms to reach [m]; NaN rows are left out.
        start: Configuration to start each frame from.
        rest: Posture the hinges are pulled towards [rad].
    """
    qpos = np.empty_like(start)
    for k, target in enumerate(targets):
        solver.weights, solver.rest = weights[k], rest[k]
        qpos[k] = solver.solve(target, start[k]).qpos
    return qpos


def _bridge(
    qpos: Float[Array, "n_frames nq"],
    placed: Bool[Array, " n_frames"],
    determined: Bool[Array, "n_frames n_hinges"],
) -> None:
    """Lead roots and hinges that were not seen straight to their next seen value, in place."""
    frames = np.arange(len(qpos))
    if placed.any() and not placed.all():
        qpos[:, :3] = bridged_gaps(qpos[:, :3], placed)
        turns = Rotation.from_quat(wxyz_to_xyzw(qpos[placed, 3:7]))
        if placed.sum() > 1:
            between = np.clip(frames[~placed], frames[placed][0], frames[placed][-1])
            quat = Slerp(frames[placed], turns)(between).as_quat()
        else:
            quat = np.tile(turns.as_quat(), ((~placed).sum(), 1))
        qpos[~placed, 3:7] = xyzw_to_wxyz(quat)
    for i in range(determined.shape[1]):
        known = determined[:, i]
        if known.any() and not known.all():
            qpos[:, 7 + i] = bridged_gaps(qpos[:, 7 + i], known)
