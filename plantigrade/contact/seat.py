"""Where a person sits: the ischia, below and a little behind the hip joints."""

import numpy as np

from plantigrade.contact.site import ContactSite
from plantigrade.models import Human

SEATED_TILT = float(np.deg2rad(15.0))
"""Pelvis tilted back, seated upright [rad]."""
H_POINT = 0.055
"""Hip joint above the seat, of stature: 10 cm (estimate)."""
ISCHIA = 0.068
"""Between the ischial points, of stature: 12 cm (estimate)."""
BUTTOCK = 0.025
"""Radius of an ischial point, of stature."""


def seat_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the two points a person sits on, below and a little behind the hip joints."""
    hip = human.model.body_pos[human.body("femur_r")]
    radius = BUTTOCK * human.height
    drop = H_POINT * human.height - radius
    # below the hip joints when the pelvis is tilted back as in sitting
    x = hip[0] - drop * np.sin(SEATED_TILT)
    z = hip[2] - drop * np.cos(SEATED_TILT)
    half = ISCHIA * human.height / 2
    return tuple(
        ContactSite(
            body="pelvis", position=(x, y, z), radius=radius, name=f"seat_{side}", part="chair"
        )
        for side, y in (("r", -half), ("l", half))
    )
