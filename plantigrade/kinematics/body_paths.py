"""Positions and rotations of bodies over a motion."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human


def body_paths(
    human: Human, qpos: Float[Array, "n_frames nq"], bodies: Sequence[int]
) -> tuple[Float[Array, "n_frames n_bodies 3"], Float[Array, "n_frames n_bodies 3 3"]]:
    """Return origins [m] and rotations of bodies, world axes, in every frame of a motion."""
    chosen = list(bodies)
    origins = np.empty((len(qpos), len(bodies), 3))
    rotations = np.empty((len(qpos), len(bodies), 3, 3))
    for f, state in enumerate(sweep(human, qpos)):
        origins[f], rotations[f] = state.origins[chosen], state.rotations[chosen]
    return origins, rotations
