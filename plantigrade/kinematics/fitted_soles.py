"""The soles a recorded person stands on.

Markers determine the position of bones, not of the tissue below them: fitted feet rest some
centimetres above the floor or in it, a little pitched or tilted. The heights at which the points of
a foot come to rest while it stands flat determine its sole; joint angles are unchanged.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.sole_paths import SolePaths
from plantigrade.kinematics.sole_rests import ContactFrames
from plantigrade.models import Human
from plantigrade.motion.filters import runs

MAX_SOLE_DISTANCE = 0.06  # [m] maximum distance from the ground of a resting sole point


def on_own_soles(human: Human, contact: SolePaths, rests: list[ContactFrames]) -> Human:
    """Return the person with soles that touch the ground where the feet of a motion rest."""
    flat = {side: _flat(contact, rests, side) for side in SIDES}
    offsets = {}
    for i, (name, side, _) in enumerate(human.contact_points):
        frames = flat[side]
        if not frames.any():
            return human
        height = float(np.median(contact.position[frames, i, 2]))
        if abs(height) > MAX_SOLE_DISTANCE:
            return human
        offsets[name] = -height
    return human.with_soles(offsets)


def heights_in_stance(
    contact: SolePaths, stance: Bool[Array, "n_frames 2"]
) -> Float[Array, "n_frames 2"]:
    """Return how high the lowest point of each sole is above the ground [m]; NaN off the ground.

    Args:
        contact: The soles over a motion, above the ground.
        stance: Where each foot stands (right, left).
    """
    low = [contact.lowest(side) for side in SIDES]
    return np.where(stance, np.stack(low, axis=1), np.nan)


def height_figures(heights: Float[Array, "n_frames 2"]) -> dict[str, float]:
    """Return mean and worst height of the soles in stance as figures [mm]; none without stance."""
    seen = 1e3 * heights[np.isfinite(heights)]
    if not len(seen):
        return {}
    return {
        "sole_in_stance_mean_mm": float(seen.mean()),
        "sole_in_stance_worst_mm": float(seen[np.abs(seen).argmax()]),
    }


def _flat(contact: SolePaths, rests: list[ContactFrames], side: str) -> np.ndarray:
    """Return in which frames a foot stands flat: heel and ball rest, well within their rests."""
    flat = np.ones(len(contact.position), dtype=bool)
    for region in ("heel", "ball"):
        if not len(contact.of(side, region)):
            continue
        resting = np.zeros(len(flat), dtype=bool)
        for rest in rests:
            if rest.side == side and rest.region == region:
                resting[rest.start : rest.stop] = True
        flat &= resting
    inner = np.zeros_like(flat)  # without the frames in which the foot comes down or leaves
    for run in runs(flat):
        quarter = (run.stop - run.start) // 4
        inner[run.start + quarter : run.stop - quarter] = True
    return inner
