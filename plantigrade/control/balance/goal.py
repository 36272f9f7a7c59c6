"""Where the centre of mass is to be: over the points that press."""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.control.balance.reference import Wanted
from plantigrade.control.gait.support import inside


def goal_of(
    wanted: Wanted,
    now: Float[Array, "n_sites 3"],
    touches: Int[Array, " k"],
    shift: Float[Array, " 3"],
    central: float = 0.0,
) -> Float[Array, " 3"]:
    """Return where the centre of mass is to be [m].

    As in the reference, moved with the points that press, and inside what they span; as far above
    those that touch as in the reference.

    Args:
        wanted: The reference.
        now: Where the spheres of the feet are.
        touches: Which of them touch.
        shift: So far from there [m].
        central: Part of the way from where the reference has it to the middle of those that press.
    """
    mine = wanted.presses.nonzero()[0]
    if not len(mine):
        return wanted.com + shift
    pressing, evenly = now[mine], np.full(len(mine), 1.0 / len(mine))
    goal = wanted.com + evenly @ (pressing - wanted.places[mine])
    goal[:2] += central * (evenly @ pressing[:, :2] - goal[:2])
    goal[:2] = inside(pressing[:, :2], goal[:2] + shift[:2])
    on = touches[wanted.presses[touches]]
    rise = (now[on, 2] - wanted.places[on, 2]).sum() / len(on) if len(on) else 0.0
    goal[2] = wanted.com[2] + shift[2] + rise
    return goal
