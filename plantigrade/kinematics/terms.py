"""Terms of inverse kinematics: positions of points, vectors between them, single axes of either."""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.state import PointSet, integrate
from plantigrade.models import Human


class Terms(PointSet):
    """What inverse kinematics is to match, each term linear in points fixed to bodies.

    A term is the position of a point, or the vector from one point to another, with each of its
    three world axes on or off. An orientation is two vectors between points of one body.

    Args:
        human: The person.
        points: (body name, position in its frame [m]) of each point.
        pairs: Of each term, the point it ends in and the one it starts from; -1 for a position.
        axes: Which world axes of a term count; all where not given.
    """

    def __init__(
        self,
        human: Human,
        points: list[tuple[str, np.ndarray]],
        pairs: list[tuple[int, int]],
        axes: Float[Array, "n_terms 3"] | None = None,
    ):
        super().__init__(human, [b for b, _ in points], np.array([p for _, p in points]))
        self.n_terms = len(pairs)
        self._to = np.array([a for a, _ in pairs], dtype=int)
        start = np.array([b for _, b in pairs], dtype=int)
        self._vectors = np.flatnonzero(start >= 0)
        self._from = start[self._vectors]
        self.axes = np.ones((self.n_terms, 3)) if axes is None else np.asarray(axes, float)

    def values(self, state):
        """Return the terms' values [m] at a state (n_terms, 3)."""
        return self._combined(state.position(self)) * self.axes

    def jacobian(self, state):
        """Return the Jacobian of the terms with respect to MuJoCo's velocity."""
        return self._combined(state.jacobian(self)) * self.axes[:, :, None]

    def _combined(self, values: np.ndarray) -> np.ndarray:
        result = values[self._to]
        result[self._vectors] -= values[self._from]
        return result


def follow(
    solver: InverseKinematics,
    targets: Float[Array, "n_frames n_terms 3"],
    start: Float[Array, "n_frames nq"] | Float[Array, " nq"],
    *,
    weights: Float[Array, "n_frames n_terms"] | None = None,
    rest: Float[Array, "n_frames n_hinges"] | None = None,
    progress=None,
) -> Float[Array, "n_frames nq"]:
    """Solve all frames in order, with weights and rest postures that change over time.

    Args:
        solver: Inverse kinematics on :class:`Terms`.
        targets: Values of the terms to reach [m]; NaN rows are left out.
        start: Configuration to start every frame from, or only the first; the others then start
            from an extrapolation of the two before.
        weights: Weights of the terms; the solver's own where not given.
        rest: Posture the hinges are pulled towards [rad].
        progress: Called with the number of frames done, now and then.
    """
    points = solver.points
    model = points.model
    axes = points.axes if isinstance(points, Terms) else 1.0
    qpos = np.empty((len(targets), model.nq))
    step = np.zeros(model.nv)
    for k, target in enumerate(targets):
        if weights is not None:
            solver.weights = weights[k]
        if rest is not None:
            solver.rest = rest[k]
        if start.ndim == 2:
            guess = start[k]
        else:
            guess = integrate(model, qpos[k - 1], step) if k else start
        qpos[k] = solver.solve(target * axes, guess).qpos
        if k:
            mujoco.mj_differentiatePos(model, step, 1.0, qpos[k - 1], qpos[k])
        if progress and k % 50 == 0:
            progress(k + 1)
    return qpos
