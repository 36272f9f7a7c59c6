"""Objects in the world, as a record has them: the signals ``things.*``, and seats that move."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.scene import SceneObject, boards
from plantigrade.notes import Info
from plantigrade.record.record import Record
from plantigrade.spatial.conventions import rotation_quaternion

PLACE = "ground.place"
"""Shift forward and left [m], tilt up in front and up on the left [rad], of every frame."""

MOVED = Info(
    "The ground moved. The viewer and the checker follow it; the drawings of the report show it at "
    "rest."
)
"""Note on a record whose ground moved."""

MIN_MOVEMENT = 1e-3  # [m, rad] ground that moves less is at rest
PLACES = "things.place"
"""Middle [m] and rotation, ``wxyz``, of every object in every frame; NaN while it is absent."""


@dataclass(frozen=True, eq=False)
class PlacedObject:
    """An object and its path."""

    scene_object: SceneObject  #: Shape and size
    #: Its middle, world [m], and rotation ``wxyz`` in every frame; NaN while it is not there
    pose: Float[Array, "n 7"]

    @property
    def fixed(self) -> bool:
        """Whether it never moved."""
        return bool(len(self.pose)) and bool(np.all(self.pose == self.pose[0]))


def scene_objects_of(record: Record) -> tuple[PlacedObject, ...]:
    """Return the objects of a record, then the boards of seats that move."""
    if PLACES not in record.signals:
        return _moving_boards(record)
    signals = record.group("things")
    places = np.asarray(signals["place"], dtype=float)
    shapes = zip(
        signals["name"], signals["kind"], np.asarray(signals["size"], dtype=float), strict=True
    )
    things = tuple(
        PlacedObject(
            SceneObject(str(name), str(kind), (float(x), float(y), float(z))), places[:, i]
        )
        for i, (name, kind, (x, y, z)) in enumerate(shapes)
    )
    return things + _moving_boards(record)


def _moving_boards(record: Record) -> tuple[PlacedObject, ...]:
    """Return the boards of seats that move."""
    found, shifts = [], record.ground.shifts(record.motion.time)
    for k, seats in enumerate(record.ground.moving_seats):
        for board in boards(seats):
            x, y, z = map(float, board.half_sizes)
            turned = rotation_quaternion(board.axes)
            pose = np.hstack([board.centre + shifts[:, k], np.tile(turned, (len(shifts), 1))])
            found.append(PlacedObject(SceneObject("support", "box", (x, y, z)), pose))
    return tuple(found)


def object_signals(objects: Sequence[SceneObject]) -> dict[str, Array]:
    """Return the signals of names, shapes and sizes; :data:`PLACES` holds the poses."""
    return {
        "things.name": np.array([each.name for each in objects], dtype=str),
        "things.kind": np.array([each.kind for each in objects], dtype=str),
        "things.size": np.array([each.size for each in objects], dtype=float),
    }


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
        rotation = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
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
