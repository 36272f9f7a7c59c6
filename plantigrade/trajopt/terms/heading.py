"""Heading of a walk over time."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan


def path_heading(plan: ContactPlan, times: Float[Array, " n_times"]) -> Float[Array, " n_times"]:
    """Return the heading of the way at times [s], left positive [rad].

    In the middle of a double support it is the mean of both footprints, so that toes that point
    outwards cancel; in between it changes evenly. Without footprints of both feet it is zero.
    """
    when, heading = [], []
    stances = sorted(plan.stances, key=lambda s: s.heel_strike)
    for one, two in zip(stances[:-1], stances[1:], strict=True):
        if one.footprint.side != two.footprint.side:
            when.append((two.heel_strike + one.toe_off) / 2)
            heading.append((one.footprint.heading + two.footprint.heading) / 2)
    if not when:
        return np.zeros(len(times))
    order = np.argsort(when)
    return np.interp(times, np.array(when)[order], np.array(heading)[order])
