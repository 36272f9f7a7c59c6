"""Legs that penetrate each other: a walk in which they do is not possible."""

import numpy as np

from plantigrade.control.gait.clearance import part_of
from plantigrade.world import SimulatedWorld

MAX_LEG_OVERLAP = 0.03  # [m] depth that flesh could yield; deeper, legs are no longer solid


class LegOverlap:
    """Depth to which one leg penetrates the other.

    Attributes:
        deepest: Maximum depth [m].
    """

    def __init__(self, world: SimulatedWorld):
        model = world.model
        kind = np.array([part_of(model.body(int(b)).name) for b in model.geom_bodyid])
        self._leg = (kind == "leg_r") * 1 + (kind == "leg_l") * 2
        self._contact, self.deepest = world.data.contact, 0.0

    def update(self) -> None:
        """Take the contacts of the last step into account."""
        both = self._leg[self._contact.geom].sum(axis=1) == 3
        if both.any():
            self.deepest = max(self.deepest, -float(self._contact.dist[both].min()))
