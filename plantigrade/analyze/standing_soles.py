"""Height of the soles above the ground in stance, and a warning if it is large."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.plates import FootForces
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.fitted_soles import height_figures, heights_in_stance
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import MAX_REST_HEIGHT, find_rests
from plantigrade.motion import GaitEvent
from plantigrade.motion.recording import rate_of

STANCE_LOAD = 20.0  # [N] minimum load of a foot in stance
# Limits of the mean height [mm], and of the height [mm] that a share of frames may exceed, because
# contacts are timed to one or two frames.
MAX_MEAN_HEIGHT, MAX_HEIGHT, MAX_SHARE = 10.0, 25.0, 0.05


def standing_soles(
    fit: Fit, events: Sequence[GaitEvent], forces: FootForces | None
) -> Float[Array, "n_frames 2"]:
    """Return heights of the soles in stance (right, left) [m]; NaN in swing.

    Stance is detected by load on plates, or else by gait events, or else by rest of the foot.
    Between two steps a foot may kick, stamp or hop: where it is lifted and comes down again, it
    does not stand. (A belt that slopes lifts a foot that stands, too, but does not lower it again.)
    """
    contact, time = sole_paths(fit.human, fit.qpos, fit.ground), fit.time
    stance = np.zeros((len(time), 2), dtype=bool)
    for s, side in enumerate(SIDES):
        low = contact.lowest(side)
        for each in stances(events, side, float(time[0]), float(time[-1])):
            frames = each.frames(time)
            own = low[frames]
            before, after = np.minimum.accumulate(own), np.minimum.accumulate(own[::-1])[::-1]
            stance[frames, s] |= own < np.maximum(before, after) + MAX_REST_HEIGHT
    if not events and len(time) > 2:
        rests = find_rests(contact, rate_of(time))
        for rest in rests:
            stance[rest.start : rest.stop, SIDES.index(rest.side)] = True
    if forces is not None:
        order = [forces.sides.index(side) for side in SIDES]
        loaded = forces.force[:, order, 2] > STANCE_LOAD
        stance = np.where(np.asarray(forces.valid_side)[:, order], loaded, stance)
    return heights_in_stance(contact, stance)


def sole_notes(soles: Float[Array, "n_frames 2"]) -> list[str]:
    """Return a warning if the feet in stance are far from the ground."""
    figures = height_figures(soles)
    if not figures:
        return []
    mean, worst = figures["sole_in_stance_mean_mm"], figures["sole_in_stance_worst_mm"]
    away = np.abs(1e3 * soles[np.isfinite(soles)]) > MAX_HEIGHT
    if abs(mean) <= MAX_MEAN_HEIGHT and away.mean() <= MAX_SHARE:
        return []
    return [
        f"the lowest point of the soles in stance is {mean:+.0f} mm from the ground on average "
        f"({worst:+.0f} mm at most); the ground of the file does not match the feet."
    ]
