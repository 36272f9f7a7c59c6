"""Seat contacts of a recorded person at the rest positions of the ischia."""

from collections.abc import Sequence

import numpy as np

from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.limb_sites import seat_sites
from plantigrade.contact.plan import PointSupport
from plantigrade.dynamics.loading import SEAT
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.trajopt.tasks.chair import resting_place
from plantigrade.trajopt.tasks.recorded_stances import GRID, MIN_CHANGE_INTERVAL, OUTSIDE_OFFSET

MAX_SEATED_HEIGHT = 0.01  # [m] maximum height of the ischia above their rest in sitting


def supports_of(
    human: Human, motion: Motion, contacts: Sequence[ContactInterval], start: float, duration: float
) -> tuple[PointSupport, ...]:
    """Return the seat of a recorded motion, one support for each ischium and each sit.

    The load begins while cushion and buttocks give way; the rigid seat of a task carries from when
    the ischia are within :data:`MAX_SEATED_HEIGHT` of where they rest.

    Args:
        contacts: Intervals of load, from :func:`~plantigrade.dynamics.loading.find_loading`.
        start: Time zero of the task [s].
        duration: Duration of the task [s].
    """
    sits = [c for c in contacts if c.region == SEAT]
    if not sits:
        return ()
    time, sites = np.asarray(motion.time, float), seat_sites(human)
    q = human.to_coordinates(motion.qpos)[1]
    points = SitePoints(human, sites)
    height = (points.path(motion.qpos)[..., 2] - points.radius).mean(axis=1)
    inside = [(time >= sit.start - 1e-9) & (time <= sit.stop + 1e-9) for sit in sits]
    level = float(np.median(height[np.any(inside, axis=0)]))  # one chair has one height
    found = []
    for sit, frames in zip(sits, inside, strict=True):
        low = np.flatnonzero(frames & (height - level < MAX_SEATED_HEIGHT))
        if len(low) < 3:
            continue
        began = float(time[low[0]]) if sit.begins else -OUTSIDE_OFFSET
        ended = float(time[low[-1]]) if sit.ends else float(time[-1]) + OUTSIDE_OFFSET
        first, last = (round((t - start) / GRID) * GRID for t in (began, ended))
        if (
            last - first < MIN_CHANGE_INTERVAL
            or last <= MIN_CHANGE_INTERVAL
            or first >= duration - MIN_CHANGE_INTERVAL
        ):
            continue
        for site in sites:
            place = np.mean([resting_place(human, site, q[i]) for i in low], axis=0)
            where = (float(place[0]), float(place[1]), level)
            found.append(PointSupport(site, where, float(first), float(last)))
    return tuple(found)
