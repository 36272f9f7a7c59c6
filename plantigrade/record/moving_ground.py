"""Moving ground of a record: planned, or of a simulation, with the signal ``ground.place``."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.notes import Info
from plantigrade.record.record import Record
from plantigrade.spatial.conventions import matrices

PLACE = "ground.place"
"""Shift forward and left [m], tilt up in front and up on the left [rad], of every frame."""

MOVED = Info(
    "The ground moved. The viewer and the checker follow it; the drawings of the report show it at "
    "rest."
)
"""Note on a record whose ground moved."""

MIN_MOVEMENT = 1e-3  # [m, rad] ground that moves less is at rest


@dataclass(frozen=True, eq=False)
class GroundPath:
    """How the ground moved."""

    time: Float[Array, " n"]  #: Time of each frame [s]
    shift: Float[Array, "n 3"]  #: Where its origin was, world [m]
    rotation: Float[Array, "n 3 3"]  #: How it was turned
    #: How fast its origin moved, where that is known exactly [m/s]
    speed: Float[Array, "n 3"] | None = None

    @classmethod
    def of(cls, record: Record) -> "GroundPath | None":
        """Return how the ground of a record moved; None where it did not."""
        if record.ground.motion is not None:
            time, straight = record.motion.time, np.tile(np.eye(3), (record.motion.n_frames, 1, 1))
            shift, speed = record.ground.displacement(time), record.ground.velocity(time)
            return cls(time, shift, straight, speed)
        place = np.nan_to_num(np.asarray(record.signals.get(PLACE, [0.0]), dtype=float))
        if np.abs(place).max(initial=0.0) <= MIN_MOVEMENT:
            return None
        x, y, front, left = place.T
        c, s, k, m = np.cos(front), np.sin(front), np.cos(left), np.sin(left)
        zero = np.zeros_like(x)
        # First up in front, about the axis to the right, then up on the left, about its own x.
        rows = [[c, -s * m, -s * k], [zero, k, -m], [s, c * m, c * k]]
        rotation = matrices(rows)
        return cls(record.motion.time, np.stack([x, y, zero], axis=1), rotation)

    def inward(self, points: Float[Array, "n k 3"]) -> Float[Array, "n k 3"]:
        """Return world points of every frame in axes that move with the ground [m]."""
        return np.einsum("nij,nki->nkj", self.rotation, points - self.shift[:, None])

    def velocity_at(self, points: Float[Array, "n k 3"]) -> Float[Array, "n k 3"]:
        """Return how fast the ground moved at world points of every frame [m/s]."""
        if self.speed is not None:
            return np.broadcast_to(self.speed[:, None], points.shape)
        if len(self.time) < 3:
            return np.zeros_like(points)
        speed, turn = self._rates
        return speed[:, None] + np.einsum("nij,nkj->nki", turn, points - self.shift[:, None])

    @cached_property
    def _rates(self) -> tuple[Float[Array, "n 3"], Float[Array, "n 3 3"]]:
        """Velocity of the origin, and the matrix of the angular velocity."""
        speed = np.gradient(self.shift, self.time, axis=0, edge_order=2)
        rate = np.gradient(self.rotation, self.time, axis=0, edge_order=2)
        return speed, rate @ self.rotation.transpose(0, 2, 1)
