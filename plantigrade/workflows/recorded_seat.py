"""The chair of a recording: the one force on its seat becomes four points on a cushion."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Seat
from plantigrade.contact.limb_sites import cushioned_sites
from plantigrade.contact.site import CHAIR_PART
from plantigrade.dynamics.loading import SEAT_COMPRESSION
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.record import Record


def with_cushion(record: Record) -> Record:
    """Return a record whose seat carries ischia and buttocks, which a simulation can support.

    A fit finds one force on the pelvis where a person sits. The ischia and the buttocks behind them
    share it by its centre of pressure, right and left alike. The seat yields by
    :data:`SEAT_COMPRESSION` under what it carries, as the fit assumes where it finds when a person
    leaves it.

    Returns:
        The record itself if it has no such seat.
    """
    found = [i for i, s in enumerate(record.sites) if s.part == CHAIR_PART and s.measured]
    if len(found) != 1 or record.contact_force is None or record.contact_point is None:
        return record
    seat = found[0]
    force = np.nan_to_num(record.contact_force[:, seat])
    sits = np.asarray(force @ record.ground.normal > 0.0)
    if not sits.any():
        return record
    points = SitePoints(record.human, cushioned_sites(record.human))
    low = points.path(record.motion.qpos)
    low[..., 2] -= points.radius
    rest = np.median(low[sits], axis=0)
    top = float(rest[:, 2].mean()) + SEAT_COMPRESSION  # of the one board that all of them share
    stiffness = float(np.median(force[sits, 2])) / len(rest) / SEAT_COMPRESSION
    boards = tuple(
        Seat(site.name, (float(x), float(y), top), stiffness=stiffness)
        for site, (x, y, _) in zip(points.sites, rest, strict=True)
    )
    own = record.sites[seat].name
    others = tuple(s for s in record.ground.seats if s.site != own)
    keep = [i for i in range(len(record.sites)) if i != seat]
    share = _shares(np.nan_to_num(record.contact_point[:, seat]), low)
    low[~sits] = np.nan

    def replaced(values: np.ndarray | None, new: np.ndarray) -> np.ndarray | None:
        return None if values is None else np.concatenate([values[:, keep], new], axis=1)

    return replace(
        record,
        ground=replace(record.ground, seats=(*others, *boards)),
        sites=(*(record.sites[i] for i in keep), *points.sites),
        contact_force=replaced(record.contact_force, share[:, :, None] * force[:, None]),
        contact_point=replaced(record.contact_point, low),
        contact_torque=replaced(record.contact_torque, np.zeros_like(low)),
        contact_known=replaced(record.contact_known, np.ones(low.shape[:2], dtype=bool)),
    )


def _shares(centre: Float[Array, "n 3"], points: Float[Array, "n 4 3"]) -> Float[Array, "n 4"]:
    """Return which part of a force acts on each point: two in front, and two behind them.

    Args:
        centre: Centre of pressure [m].
        points: The points [m].
    """
    front, rear = points[:, :2, :2].mean(axis=1), points[:, 2:, :2].mean(axis=1)
    way = front - rear
    ahead = np.einsum("ij,ij->i", centre[:, :2] - rear, way) / np.sum(way**2, axis=1)
    part = 0.5 * np.clip(ahead, 0.0, 1.0)[:, None]
    return np.concatenate([part, part, 0.5 - part, 0.5 - part], axis=1)
