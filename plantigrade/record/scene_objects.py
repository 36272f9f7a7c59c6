"""Objects in the world, as a record has them: the signals ``things.*``, and seats that move."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.scene import SceneObject, boards
from plantigrade.record.record import Record
from plantigrade.spatial.conventions import rotation_quaternion

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
