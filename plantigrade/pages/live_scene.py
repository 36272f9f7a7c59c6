"""Data that the live page draws: shapes and skin of a world once, and one message per frame."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.constants import SIDES
from plantigrade.live.frame import MIN_LOAD, LiveFrame
from plantigrade.pages.scene import height_below
from plantigrade.pages.shapes import PLATE, convex_hull, shapes_of
from plantigrade.pages.viewer import COLOURS, ground_data, shape_data
from plantigrade.pages.viewer_skin import foot_data, skin_data
from plantigrade.spatial.conventions import rotation_matrix
from plantigrade.world import World

HEADROOM = 0.1  # [m] of the view above the person; chosen
DIGITS = 4  # of positions [m] and quaternions: 0.1 mm


def weight_of(world: World) -> float:
    """Return the weight of the person [N]."""
    return world.human.mass * float(-world.model.opt.gravity[2])


def world_data(world: World) -> dict[str, Any]:
    """Return what the scripts of both viewers need of a world; the pack is one more body."""
    human, model = world.human, world.model
    return {
        "bodies": model.nbody + 1,
        "shapes": [shape_data(s) for s in shapes_of(model) if not s.is_plate],
        "skin": skin_data(human),
        "foot": foot_data(human),
        "colours": COLOURS | {"rope": theme.FITTED, "support": theme.RECORDED},
        "contact_colours": [theme.SIDE_COLOURS.get(s.side, theme.MIDDLE) for s in world.sites],
        "side_colours": theme.BY_SIDE,
        "weight": weight_of(world),
        "height": human.height + HEADROOM,
        "heading": 0.0,
        "ground": ground_data(world.ground, plane=not world.ground.steps),
    }


def frame_data(frame: LiveFrame) -> dict[str, Any]:
    """Return everything that moves with the body, to be drawn together."""
    world, pack = frame.world, frame.pack
    ground = plate_data(frame)
    positions, quats = [frame.positions], [frame.quats]
    if pack is not None:
        positions.append(frame.pack_pose[None, :3])
        quats.append(frame.pack_pose[None, 3:])
    return {
        "time": round(frame.time, 4),
        "positions": rounded(np.concatenate(positions)),
        "quats": rounded(np.concatenate(quats)),
        "com": rounded(frame.com),
        "floor": round(floor_below(frame, ground), DIGITS),
        "ground": ground,
        "reactions": [reaction(frame, side) for side in SIDES],
        "pressure": centre_of_pressure(frame, np.ones(len(world.sites), dtype=bool)),
        "contacts": contacts(frame),
        "support": rounded(support_polygon(frame.point[frame.force[:, 2] > 0.0])),
        "rope": None if frame.rope is None else rounded(frame.rope),
        "pushes": rounded(frame.pushes),
        "pack": None if pack is None else list(pack.size),
        "drawings": [
            {
                "colour": drawing.colour,
                "lines": _listed(drawing.lines),
                "points": _listed(drawing.points),
            }
            for drawing in frame.drawings
        ],
    }


def plate_data(frame: LiveFrame) -> dict[str, Any] | None:
    """Return the ground where it is a plate that moves; None where it is still."""
    model = frame.world.model
    for geom in range(model.ngeom):
        if model.geom(geom).name == PLATE:
            body = int(model.geom_bodyid[geom])
            return {
                "axes": rounded(rotation_matrix(frame.quats[body]).T.ravel(), 6),
                "plane": True,
                "height": float(model.geom_pos[geom, 2] + model.geom_size[geom, 2]),
                "origin": rounded(frame.positions[body]),
            }
    return None


def floor_below(frame: LiveFrame, plate: dict[str, Any] | None) -> float:
    """Return the height of the ground under the centre of mass [m]."""
    if plate is None:
        return float(height_below(frame.world.ground, frame.com[None])[0])
    normal, origin = np.array(plate["axes"][6:]), np.array(plate["origin"])
    aside = normal[:2] @ (frame.com[:2] - origin[:2])
    return float(origin[2] + (plate["height"] - aside) / normal[2])


def reaction(frame: LiveFrame, side: str) -> list[list[float]] | None:
    """Return centre of pressure [m] and ground reaction [N] of a side; None if it is unloaded."""
    own = np.array([site.side == side for site in frame.world.sites], dtype=bool)
    point = centre_of_pressure(frame, own)
    return None if point is None else [point, rounded(frame.force[own].sum(axis=0), 1)]


def centre_of_pressure(frame: LiveFrame, sites: Array) -> list[float] | None:
    """Return the centre of pressure of some sites [m]; None if they are unloaded."""
    up = np.where(sites, np.maximum(frame.force[:, 2], 0.0), 0.0)
    load = float(up.sum())
    if load <= MIN_LOAD * weight_of(frame.world):
        return None
    return rounded(up @ frame.point / load)


def contacts(frame: LiveFrame) -> list[list[Any]]:
    """Return index, point [m] and force [N] of every site that presses."""
    return [
        [int(k), rounded(frame.point[k]), rounded(frame.force[k], 1)]
        for k in np.flatnonzero(frame.force[:, 2] > 0.0)
    ]


def support_polygon(points: Float[Array, "n 3"]) -> Float[Array, "m 3"]:
    """Return the corners of the convex hull of points over the ground, in order [m]."""
    if len(points) < 2:
        return np.zeros((0, 3))
    corners = convex_hull(points[:, :2])
    return points[np.abs(corners[:, None] - points[None, :, :2]).sum(axis=2).argmin(axis=1)]


def rounded(values: Array | Sequence[float], digits: int = DIGITS) -> list[Any]:
    """Return numbers as lists, rounded."""
    return np.round(np.nan_to_num(np.asarray(values, dtype=float)), digits).tolist()


def _listed(values: Array | None) -> list[Any]:
    return [] if values is None else rounded(values)
