"""The seat that carries a sitting person: its estimated force in inverse dynamics and in a Record.

The force is taken to act on the pelvis. Thighs rest on a seat too, how much is not known: the
moments of the hips while sitting are those of thighs that hang from the pelvis.
"""

from typing import Any

import numpy as np

from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.ground_forces import GroundForces
from plantigrade.dynamics.inverse import BodyLoad
from plantigrade.dynamics.loading import SEAT


def seat_loads(ground: GroundForces | None) -> tuple[BodyLoad, ...]:
    """Return the force of the seat on the pelvis; none where nobody sits."""
    if ground is None or SEAT not in ground.supports:
        return ()
    i = ground.supports.index(SEAT)
    force, point = ground.support_force[:, i], ground.support_point[:, i]
    return (BodyLoad("pelvis", force, point, ground.support_torque[:, i]),)


def with_seat(contact: dict[str, Any], ground: GroundForces) -> dict[str, Any]:
    """Return the contact fields of a Record with the seat among them, as site and as board.

    Args:
        contact: Sites, forces, points and torques of the feet.
        ground: The estimated forces.
    """
    loads = seat_loads(ground)
    if not loads or not np.isfinite(loads[0].point).all(axis=1).any():
        return contact
    (load,) = loads
    fields = {
        "contact_force": load.force,
        "contact_point": load.point,
        "contact_torque": load.torque,
        "contact_known": np.ones(len(load.force), dtype=bool),
    }
    x, y, z = (float(each) for each in np.nanmedian(load.point, axis=0))
    site = ContactSite(body=load.body, name=SEAT, part="chair", measured=True)
    return {
        "sites": (*contact["sites"], site),
        **{n: np.concatenate([contact[n], v[:, None]], axis=1) for n, v in fields.items()},
        "ground": Ground(seats=(Seat(SEAT, (x, y, z)),)),
    }
