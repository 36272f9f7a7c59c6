"""Handles in the scene of a task: what is dragged there is a parameter.

A handle lies where its parameter shows: the seat of a chair, the target of a hand, the last
footprint, the top of a block, the highest point of a jump.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import FOOT_AHEAD_OF_ANKLE, FOOT_BEHIND_ANKLE
from plantigrade.models.landmarks import attachments
from plantigrade.pages.scene import Scene
from plantigrade.record import Record
from plantigrade.record.scene_objects import scene_objects_of
from plantigrade.spatial.conventions import rotation_matrix

UP, DOWN, AHEAD = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)


@dataclass(frozen=True)
class Handle:
    """A point that is dragged along a line, or freely."""

    parameter: str  #: Name of the parameter
    position: tuple[float, float, float]  #: Where it is at the present value [m]
    #: Direction in which it is dragged, world; None for a point that is dragged freely
    axis: tuple[float, float, float] | None
    value: float | None  #: Present value of the parameter; None for a point
    per_metre: float = 1.0  #: Change of the parameter [1/m]

    def plain(self) -> dict[str, Any]:
        """Return it for the script of the page."""
        return {
            "name": self.parameter,
            "at": [round(x, 4) for x in self.position],
            "axis": self.axis,
            "value": self.value,
            "per_metre": self.per_metre,
        }


def handles_of(
    task: str, record: Record, scene: Scene, values: Mapping[str, Any]
) -> tuple[Handle, ...]:
    """Return the handles of a solved task.

    Args:
        values: Values for which it was solved, by the name of their control.
    """
    makers = {
        "walk": _walk,
        "hop": _hop,
        "sit-to-stand": _chair,
        "stand-to-sit": _chair,
        "squat": _squat,
        "lift": _lift,
        "reach": _reach,
        "side-step": _side_step,
        "jump": _jump,
    }
    return makers[task](record, scene, values) if task in makers else ()


def _walk(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    found = []
    start, end = _feet(record, scene, 0), _feet(record, scene, -1)
    steps = values.get("steps") or 2 * values.get("strides", 1)
    last = end[int(np.argmax(end[:, 0]))]
    way = float(np.hypot(*(end.mean(axis=0) - start.mean(axis=0))[:2]))
    if not values.get("turn"):
        length = values.get("step_length")
        length = way / steps if length is None else length
        found.append(Handle("step_length", _triple(last), AHEAD, float(length), 1.0 / steps))
    edges = record.ground.steps
    if values.get("obstacle_height") and len(edges) > 1:
        top = ((edges[0].x + edges[1].x) / 2, 0.0, edges[0].height)
        found.append(Handle("obstacle_height", top, UP, float(values["obstacle_height"])))
    elif values.get("step_height") and edges:
        inward = FOOT_BEHIND_ANKLE if values["step_height"] > 0 else -FOOT_AHEAD_OF_ANKLE
        top = (edges[-1].x + inward, 0.0, edges[-1].height)
        found.append(Handle("step_height", top, UP, float(values["step_height"])))
    return tuple(found)


def _chair(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    seats = [seat for seat in record.ground.seats if not seat.board]
    if not seats:
        return ()
    place = _triple(np.mean([seat.position for seat in seats], axis=0))
    height = values.get("chair_height")
    return (Handle("chair_height", place, UP, place[2] if height is None else float(height)),)


def _lift(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    table = next(each for each in scene_objects_of(record) if each.scene_object.name == "table")
    edge = table.pose[0, :3] - [table.scene_object.size[0], 0.0, 0.0]
    return (Handle("table_height", _triple(edge), UP, float(values["table_height"])),)


def _squat(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    pelvis = scene.positions[:, record.human.body("pelvis")]
    lowest = int(np.argmin(pelvis[:, 2]))
    depth = values.get("depth")
    depth = float(pelvis[0, 2] - pelvis[lowest, 2]) if depth is None else float(depth)
    return (Handle("depth", _triple(pelvis[lowest]), DOWN, depth),)


def _reach(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    human = record.human
    hand = attachments(human)[f"hand_{values.get('side', 'r')}"]
    frame = int(np.argmin(np.abs(scene.time - scene.time[0] - values["duration"])))
    body = human.body(hand.body)
    turn = rotation_matrix(scene.quats[frame, body])
    place = values.get("target")
    if place is None:
        place = scene.positions[frame, body] + turn @ np.asarray(hand.position)
    return (Handle("target", _triple(np.asarray(place)), None, None),)


def _side_step(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    sign = -1.0 if values.get("side", "r") == "r" else 1.0
    feet = _feet(record, scene, -1)
    outer = feet[int(np.argmax(sign * feet[:, 1]))]
    return (Handle("distance", _triple(outer), (0.0, sign, 0.0), float(values["distance"])),)


def _jump(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    landing = _triple(_feet(record, scene, -1).mean(axis=0))
    return (
        Handle("distance", landing, AHEAD, float(values["distance"])),
        Handle("jump_height", _highest(scene), UP, float(values["jump_height"])),
    )


def _hop(record: Record, scene: Scene, values: Mapping[str, Any]) -> tuple[Handle, ...]:
    return (Handle("hop_height", _highest(scene), UP, float(values["hop_height"])),)


def _highest(scene: Scene) -> tuple[float, float, float]:
    """Return the highest position of the centre of mass [m]."""
    return _triple(scene.com[int(np.argmax(scene.com[:, 2]))])


def _feet(record: Record, scene: Scene, frame: int) -> Float[Array, "2 3"]:
    """Return the positions of the right and the left foot, on the ground [m]."""
    feet = np.array([scene.positions[frame, record.human.body(f"foot_{s}")] for s in "rl"])
    feet[:, 2] = record.ground.along(feet[:, 0])
    return feet


def _triple(position: Array) -> tuple[float, float, float]:
    x, y, z = (float(each) for each in position)
    return x, y, z
