"""Terms of inverse kinematics: positions of points, vectors between them."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human


class Terms(PointSet):
    """What inverse kinematics is to match, each term linear in points fixed to bodies.

    A term is the position of a point, or the vector from one point to another. An orientation is
    two vectors between points of one body.

    Args:
        human: The person.
        points: (body name, position in its frame [m]) of each point.
        pairs: Of each term, the point it ends in and the one it starts from; -1 for a position.
    """

    def __init__(
        self,
        human: Human,
        points: list[tuple[str, np.ndarray]],
        pairs: list[tuple[int, int]],
    ):
        super().__init__(human, [b for b, _ in points], np.array([p for _, p in points]))
        self._to = np.array([a for a, _ in pairs], dtype=int)
        start = np.array([b for _, b in pairs], dtype=int)
        self._vectors = np.flatnonzero(start >= 0)
        self._from = start[self._vectors]

    def values(self, state):
        """Return the terms' values [m] at a state (n_terms, 3)."""
        return self._combined(state.position(self))

    def jacobian(self, state):
        """Return the Jacobian of the terms with respect to MuJoCo's velocity."""
        return self._combined(state.jacobian(self))

    def _combined(self, values: np.ndarray) -> np.ndarray:
        result = values[self._to]
        result[self._vectors] -= values[self._from]
        return result


def follow(
    solver: InverseKinematics,
    targets: Float[Array, "n_frames n_terms 3"],
    start: Float[Array, "n_frames nq"],
    *,
    weights: Float[Array, "n_frames n_terms"],
    rest: Float[Array, "n_frames n_hinges"],
    progress=None,
) -> Float[Array, "n_frames nq"]:
    """Solve all frames, each from a start of its own, with its own weights and rest posture.

    Args:
        solver: Inverse kinematics on :class:`Terms`.
        targets: Values of the terms to reach [m]; NaN rows are left out.
        start: Configuration to start each frame from.
        weights: Weights of the terms.
        rest: Posture the hinges are pulled towards [rad].
        progress: Called with the number of frames done, now and then.
    """
    qpos = np.empty_like(start)
    for k, target in enumerate(targets):
        solver.weights, solver.rest = weights[k], rest[k]
        qpos[k] = solver.solve(target, start[k]).qpos
        if progress and k % 50 == 0:
            progress(k + 1)
    return qpos
