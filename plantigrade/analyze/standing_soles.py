"""How far the soles of standing feet are from the ground, and whether that is worth a word."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.plates import FootForces
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.fitted_soles import height_figures, heights_in_stance
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.motion import GaitEvent

LOADED = 20.0  # a foot with this much under it stands [N]
# Soles this far from the ground on average, or that far in more than a few frames (a contact is
# timed to a frame or two), are worth a word [mm].
FAR, FARTHEST, OFTEN = 10.0, 25.0, 0.05


def standing_soles(
    fit: Fit, events: Sequence[GaitEvent], forces: FootForces | None
) -> Float[Array, "n_frames 2"]:
    """Return how high the soles are while their feet stand (right, left) [m]; NaN in swing.

    A foot stands where plates carry it; without plates between its gait events; without events
    where it rests.
    """
    contact, time = sole_paths(fit.human, fit.qpos, fit.ground), fit.time
    stance = np.zeros((len(time), 2), dtype=bool)
    for s, side in enumerate(SIDES):
        for each in stances(events, side, float(time[0]), float(time[-1])):
            stance[:, s] |= each.frames(time)
    if not events and len(time) > 2:
        rests = find_rests(contact, (len(time) - 1) / (time[-1] - time[0]))
        for rest in rests:
            stance[rest.start : rest.stop, SIDES.index(rest.side)] = True
    if forces is not None:
        order = [forces.sides.index(side) for side in SIDES]
        loaded = forces.force[:, order, 2] > LOADED
        stance = np.where(np.asarray(forces.valid_side)[:, order], loaded, stance)
    return heights_in_stance(contact, stance)


def sole_notes(soles: Float[Array, "n_frames 2"]) -> list[str]:
    """Return a sentence where the standing feet are far from the ground."""
    figures = height_figures(soles)
    if not figures:
        return []
    mean, worst = figures["sole_in_stance_mean_mm"], figures["sole_in_stance_worst_mm"]
    away = np.abs(1e3 * soles[np.isfinite(soles)]) > FARTHEST
    if abs(mean) <= FAR and away.mean() <= OFTEN:
        return []
    return [
        f"the lowest point of the standing soles is {mean:+.0f} mm from the ground on average "
        f"({worst:+.0f} mm at most): the feet do not stand on the ground of the file."
    ]
