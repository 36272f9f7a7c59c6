"""The soles a recorded person stands on.

Markers tell where the bones are, not how thick the shoe below them is: fitted feet rest some
centimetres above the floor or in it. The heights at which heel, ball and toes come to rest tell
the sole; joint angles are not touched.
"""

import numpy as np

from plantigrade.kinematics.ground import ContactPoints, Rest
from plantigrade.models import Human

THICKEST = 0.06  # a foot that rests higher than this does not rest on a sole [m]


def on_own_soles(human: Human, contact: ContactPoints, rests: list[Rest]) -> Human:
    """Return the person with soles that touch the ground where the feet rest.

    Args:
        human: The person.
        contact: The points of the soles over the recorded motion.
        rests: What rests when.
    """
    heights = {r: _height(contact, rests, r) for r in ("heel", "ball", "toes")}
    heights["middle"] = (heights["heel"] + heights["ball"]) / 2
    if max(abs(h) for h in heights.values()) > THICKEST:
        return human
    return human.with_soles(
        {
            name: -heights[region]
            for (name, _, _), region in zip(human.contact_points, contact.region, strict=True)
        }
    )


def _height(contact: ContactPoints, rests: list[Rest], region: str) -> float:
    """Return the height at which a region rests, both feet alike [m]; zero where it never does."""
    heights = []
    for rest in rests:
        if rest.region != region:
            continue
        quarter = (rest.stop - rest.start) // 4
        core = slice(rest.start + quarter, rest.stop - quarter)
        index = contact.of(rest.side, region)
        heights.append(np.median(contact.position[core][:, index, 2].min(axis=1)))
    return float(np.median(heights)) if heights else 0.0
