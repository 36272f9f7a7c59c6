"""Forces on the feet of a simulation that are far above what people bear."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.record import Record

WALKING_PEAK = 1.2  # [BW] usual peak of the vertical force of people who walk
RUNNING_PEAK = 2.5  # [BW] usual peak of the vertical force of people who run
MIN_IMPACT_FORCE = 5.0  # [BW] from which a warning is due: twice that of running. Chosen


def force_on_feet(record: Record) -> Float[Array, " n"]:
    """Return the vertical force on both feet in body weights."""
    force = np.sum([record.foot(side).force[:, 2] for side in SIDES], axis=0)
    return force / record.weight


def impact_notes(record: Record) -> tuple[str, ...]:
    """Return a warning of a force on the feet far above what people bear, if there is one."""
    force = force_on_feet(record)
    peak = int(np.argmax(force))
    if not force[peak] > MIN_IMPACT_FORCE:
        return ()
    return (
        f"impact: the feet bear {force[peak]:.1f} body weights at {record.motion.time[peak]:.2f} "
        f"s; people bear about {WALKING_PEAK:g} in walking and {RUNNING_PEAK:g} in running. Feet "
        "of the model are stiffer than those of people: do not use forces and moments of that "
        "instant",
    )
