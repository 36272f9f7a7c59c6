"""Contact sites of hands, which rest on an armrest, a wall or a rail."""

import numpy as np

from plantigrade.bounds import word
from plantigrade.constants import SIDES
from plantigrade.contact.site import ContactSite, Point
from plantigrade.models import Human

REFERENCE_HEIGHT = 1.75  # [m] stature of the person whom the following length belongs to
PALM = 0.08  # [m] middle of the palm below the wrist
HAND_PART = "hand"  #: Part name of a site that rests on an armrest, a wall or a rail
SUPPORTED_PARTS = tuple(f"hand_{side}" for side in SIDES)
"""Parts of the body that a support of a task may carry, besides feet and seat."""


def palm(human: Human, side: str) -> Point:
    """Return the middle of the palm."""
    body, origin = human.skeleton.parts[f"hand_{side}"]
    return Point(body, origin + np.array([0.0, 0.0, -PALM * human.height / REFERENCE_HEIGHT]))


def limb_site(human: Human, part: str) -> ContactSite:
    """Return the contact site of a hand: the palm, as a point.

    Raises:
        ParameterError: If the part is none of :data:`SUPPORTED_PARTS`.
    """
    word("part", part, SUPPORTED_PARTS)
    point = palm(human, part[-1])
    return ContactSite(body=point.body, position=point.position, name=part, part=HAND_PART)
