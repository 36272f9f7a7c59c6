"""Steps in the ground: treads as high as the footprints on them, edges close to the higher ones."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan

HEEL, TOE = 0.13, 0.27
"""From the ankle of a footprint back and forth to an edge below it [m]: a foot and 5 cm."""


@dataclass(frozen=True)
class Treads:
    """Ground that is level but for steps across x.

    Attributes:
        edges: Where steps are, in order [m].
        heights: Height before, between and after them [m].
    """

    edges: Float[Array, " n"]
    heights: Float[Array, " n_plus_1"]

    def height(
        self, x: Float[Array, "..."], margin: Float[Array, "..."] | float = 0.0
    ) -> Float[Array, "..."]:
        """Return the height of the ground at places along x, of the highest within a margin [m]."""
        near = (x - margin, x + margin)  # treads are no narrower than a foot
        return np.maximum(*(self.heights[np.searchsorted(self.edges, each)] for each in near))


def treads(plan: ContactPlan) -> Treads:
    """Return the treads of a plan that goes along x; one if all footprints are equally high."""
    prints = sorted((s.footprint.position[0], s.footprint.position[2]) for s in plan.stances)
    edges, heights = [], [prints[0][1] if prints else 0.0]
    for (x0, z0), (x1, z1) in zip(prints[:-1], prints[1:], strict=True):
        if abs(z1 - z0) > 1e-9:
            edges.append(x1 - HEEL if z1 > z0 else x0 + TOE)
            heights.append(z1)
    return Treads(np.array(edges), np.array(heights))


def ground(plan: ContactPlan) -> float | Callable[[np.ndarray], np.ndarray]:
    """Return the height of the ground of a plan [m], or a function of points (…, 3) to it."""
    steps = treads(plan)
    if not len(steps.edges):
        return float(steps.heights[0])
    return lambda points: steps.height(points[..., 0])
