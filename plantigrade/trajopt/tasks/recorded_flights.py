"""When the parts of the feet stand in runs and jumps, from their heights.

A foot that lands from a flight is braked within some 20 ms; low-passed, it slides and sinks for 40
ms, and nothing of it rests long enough for the rests of walking. When the whole foot carries is
known (:mod:`plantigrade.dynamics.loading`); in between, a part is down while it is low.
"""

from collections.abc import Sequence

import numpy as np

from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.contacts import DOWN_HEIGHT
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import crossing
from plantigrade.trajopt.tasks.recorded_stances import MAX_CONTACT_HEIGHT


def flying_contacts(
    human: Human, motion: Motion, loaded: Sequence[ContactInterval]
) -> tuple[ContactInterval, ...]:
    """Return which part of which foot touches when.

    Args:
        loaded: When which foot carries.
    """
    points, time = sole_paths(human, motion.qpos), np.asarray(motion.time, float)
    found = []
    for foot in (c for c in loaded if c.side):
        inside = foot.frames(time)
        for region in ("heel", "ball", "toes"):
            height = points.lowest(foot.side, region)
            least = float(height[inside].min(initial=np.inf))
            down = np.flatnonzero(inside & (height <= max(least, 0.0) + DOWN_HEIGHT))
            if least > MAX_CONTACT_HEIGHT or len(down) < 2:
                continue
            above = height - max(least, 0.0) - DOWN_HEIGHT
            start, stop = foot.start, foot.stop
            if down[0] > 0 and inside[down[0] - 1]:
                start = crossing(time, above, int(down[0]) - 1, 0.0)
            if region != "toes" and down[-1] + 1 < len(time) and inside[down[-1] + 1]:
                stop = crossing(time, above, int(down[-1]), 0.0)
            found.append(ContactInterval(foot.side, region, start, stop))
    return tuple(found)
