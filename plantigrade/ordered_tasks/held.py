"""How long each part of a foot stays where it rested.

The events of gait and the speed of a region say roughly when it leaves the ground. A heel that
begins to rise is slow at first, and the tip of the toes slides and lifts for some hundredths of a
second while the last few newtons fade: at the toe off of force plates it is 10 to 40 mm ahead of
where it stood. Held until then, they would bend knee and ankle further than the recorded ones. A
part is therefore held as long as it is where it rested, and no longer.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.sole_paths import SitePoints, region_of
from plantigrade.models import Human

LAST_TO_LEAVE = ("toe_1_", "toe_2_")  # the great toe leaves the ground last, and what is beside it


def held_contacts(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    contacts: Sequence[ContactInterval],
    *,
    max_displacement: float = 0.010,
) -> tuple[ContactInterval, ...]:
    """Return contacts that end when their part has left where it rested.

    Where a part rested is the median of the middle half of its contact. Contacts that reach the end
    of the recording are left as they are.

    Args:
        human: The person.
        time: Time of each frame [s].
        qpos: The recorded motion, over ground that rests.
        contacts: As gait events and speeds tell them.
        max_displacement: Distance from where it rested at which a part has left [m]: about as far
            as a sphere of the sole rolls between a flat foot and one that stands on its tip.
    """
    sites = contact_sites(human)
    path = SitePoints(human, sites).path(qpos)
    held = []
    for contact in contacts:
        mine = [i for i, s in enumerate(sites) if s.side == contact.side and _leads(s, contact)]
        quarter = (contact.stop - contact.start) / 4
        inside = (time >= contact.start) & (time <= contact.stop)
        middle = inside & (abs(time - contact.start - 2 * quarter) <= quarter)
        if not mine or not middle.any() or contact.stop >= time[-1]:
            held.append(contact)
            continue
        place = path[:, mine].mean(axis=1)
        away = np.linalg.norm(place - np.median(place[middle], axis=0), axis=1)
        there = time[inside & (away <= max_displacement)]
        middle_of_it = contact.start + 2 * quarter
        stop = max(float(there[-1]), middle_of_it) if len(there) else middle_of_it
        held.append(replace(contact, stop=min(stop, contact.stop)))
    return tuple(held)


def is_tip(site: ContactSite) -> bool:
    """Return whether a site is of those that leave the ground last."""
    return any(toe in site.name for toe in LAST_TO_LEAVE)


def _leads(site: ContactSite, contact: ContactInterval) -> bool:
    """Return whether a site tells when a region leaves: of the toes only the tip does."""
    return region_of(site) == contact.region and (contact.region != "toes" or is_tip(site))
