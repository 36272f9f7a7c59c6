"""The chair of a recording: the one force on its seat becomes two ischia on a board."""

from dataclasses import replace

import numpy as np

from plantigrade.contact.ground import Seat
from plantigrade.contact.limb_sites import seat_sites
from plantigrade.contact.site import CHAIR_PART
from plantigrade.dynamics.loading import SEAT_COMPRESSION
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.record import Record


def with_ischia(record: Record) -> Record:
    """Return a record whose seat carries the two ischia, which a simulation can support.

    A fit finds one force on the pelvis where a person sits. The ischia bear half of it each, as in
    a planned rise from a chair. The seat yields by :data:`SEAT_COMPRESSION` under what it carries,
    as the fit assumes where it finds when a person leaves it.

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
    ischia = SitePoints(record.human, seat_sites(record.human))
    low = ischia.path(record.motion.qpos)
    low[..., 2] -= ischia.radius
    rest = np.median(low[sits], axis=0)
    stiffness = 0.5 * float(np.median(force[sits, 2])) / SEAT_COMPRESSION
    boards = tuple(
        Seat(site.name, (float(x), float(y), float(z) + SEAT_COMPRESSION), stiffness=stiffness)
        for site, (x, y, z) in zip(ischia.sites, rest, strict=True)
    )
    own = record.sites[seat].name
    others = tuple(s for s in record.ground.seats if s.site != own)
    keep = [i for i in range(len(record.sites)) if i != seat]
    low[~sits] = np.nan

    def replaced(values: np.ndarray | None, new: np.ndarray) -> np.ndarray | None:
        return None if values is None else np.concatenate([values[:, keep], new], axis=1)

    return replace(
        record,
        ground=replace(record.ground, seats=(*others, *boards)),
        sites=(*(record.sites[i] for i in keep), *ischia.sites),
        contact_force=replaced(record.contact_force, np.stack([0.5 * force] * 2, axis=1)),
        contact_point=replaced(record.contact_point, low),
        contact_torque=replaced(record.contact_torque, np.zeros_like(low)),
        contact_known=replaced(record.contact_known, np.ones(low.shape[:2], dtype=bool)),
    )
