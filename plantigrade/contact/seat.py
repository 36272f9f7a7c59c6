"""Contact sites of sitting: the ischia, below and slightly behind the hip joints."""

import numpy as np

from plantigrade.contact.site import CHAIR_PART, ContactSite
from plantigrade.models import Human

SEATED_PELVIS_TILT = float(np.deg2rad(15.0))
"""Posterior tilt of the pelvis in upright sitting [rad]. Estimate."""
HIP_ABOVE_SEAT = 0.055
"""Height of the hip joint above the seat, relative to stature [1]; 10 cm. Estimate."""
ISCHIAL_DISTANCE = 0.068
"""Distance between the ischial contacts, relative to stature [1]; 12 cm. Estimate."""
ISCHIAL_RADIUS = 0.025  # Radius of an ischial contact sphere, relative to stature [1]. Estimate.


def seat_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the two ischial contact sites."""
    hip = human.model.body_pos[human.body("femur_r")]
    radius = ISCHIAL_RADIUS * human.height
    drop = HIP_ABOVE_SEAT * human.height - radius
    # vertically below the hip joints with the pelvis tilted as in sitting
    x = hip[0] - drop * np.sin(SEATED_PELVIS_TILT)
    z = hip[2] - drop * np.cos(SEATED_PELVIS_TILT)
    half = ISCHIAL_DISTANCE * human.height / 2
    return tuple(
        ContactSite(
            body="pelvis", position=(x, y, z), radius=radius, name=f"seat_{side}", part=CHAIR_PART
        )
        for side, y in (("r", -half), ("l", half))
    )
