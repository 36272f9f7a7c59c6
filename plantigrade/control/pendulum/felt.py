r"""What pushes a person, beside the ground: felt from how the centre of mass speeds up.

Newton's law for the whole body has one unknown force, if those of the ground are known:
:math:`f = m (\ddot c - g) - \sum F`. Robots notice so that they are touched: the observer of
momentum of [Haddadin2017]_.
"""

from collections import deque

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import State

SAMPLES = 5
"""The median of so many samples is taken: feet that land make single ones wrong."""
LIGHT = 0.25
"""Less than this is not felt [m/s²]."""


class Felt:
    """The horizontal acceleration that a person gets from what pushes them.

    Attributes:
        push: That acceleration now, world [m/s²].
    """

    def __init__(self):
        self.push = np.zeros(2)
        self._was: Array | None = None
        self._samples: deque[Array] = deque(maxlen=SAMPLES)

    def feel(
        self, body: State, ground: Float[Array, "n 3"], step: float, turned: Float[Array, "2 2"]
    ) -> None:
        """Take another sample.

        Args:
            body: The person now.
            ground: Forces of the ground since the last sample [N].
            step: Since then [s].
            turned: Rotation from the axes of then to those of now.
        """
        velocity = body.com_velocity[:2].copy()
        if self._was is not None:
            gained = (velocity - turned @ self._was) / step
            self._samples.append(gained - ground[:, :2].sum(axis=0) / body.mass)
            push = np.median(self._samples, axis=0)
            self.push = push * max(1.0 - LIGHT / max(float(np.linalg.norm(push)), 1e-9), 0.0)
        self._was = velocity
