"""Contact intervals limited to the time in which each region of the foot is stationary.

Gait events and the speed of a region give the end of its contact only roughly. A rising heel is
slow at first, and the tip of the toes slides and lifts for some hundredths of a second while the
last few newtons fade: at the toe-off of force plates it is 10 to 40 mm ahead of its stance
position. Fixed until then, these regions would flex knee and ankle further than recorded. A contact
therefore ends when its region has left its stance position.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.sole_paths import SitePoints, region_of
from plantigrade.models import Human

LAST_CONTACT_TOES = ("toe_1_", "toe_2_")  # the great toe and its neighbour leave last
MAX_DISPLACEMENT = 0.01
"""Distance from the stance position that ends a contact [m]; about the rolling distance of a sole
sphere between foot flat and standing on the tip."""


def stationary_contacts(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    contacts: Sequence[ContactInterval],
) -> tuple[ContactInterval, ...]:
    """Return contacts that end when their region has left its stance position.

    The stance position is the median over the middle half of the contact. Contacts that reach the
    end of the recording are unchanged.

    Args:
        time: Time of each frame [s].
        qpos: The recorded motion over stationary ground.
        contacts: Contact intervals from gait events and speeds.
    """
    sites = contact_sites(human)
    path = SitePoints(human, sites).path(qpos)
    stationary = []
    for contact in contacts:
        mine = [
            i for i, s in enumerate(sites) if s.side == contact.side and _is_decisive(s, contact)
        ]
        quarter = (contact.stop - contact.start) / 4
        inside = (time >= contact.start) & (time <= contact.stop)
        middle = inside & (abs(time - contact.start - 2 * quarter) <= quarter)
        if not mine or not middle.any() or contact.stop >= time[-1]:
            stationary.append(contact)
            continue
        place = path[:, mine].mean(axis=1)
        displacement = np.linalg.norm(place - np.median(place[middle], axis=0), axis=1)
        at_rest = time[inside & (displacement <= MAX_DISPLACEMENT)]
        middle_time = contact.start + 2 * quarter
        stop = max(float(at_rest[-1]), middle_time) if len(at_rest) else middle_time
        stationary.append(replace(contact, stop=min(stop, contact.stop)))
    return tuple(stationary)


def is_tip(site: ContactSite) -> bool:
    """Return whether a site is among those that leave the ground last."""
    return any(toe in site.name for toe in LAST_CONTACT_TOES)


def _is_decisive(site: ContactSite, contact: ContactInterval) -> bool:
    """Return whether a site decides when a region leaves; among the toes only the tip does."""
    return region_of(site) == contact.region and (contact.region != "toes" or is_tip(site))
