r"""Which segment a marker of unknown name sits on.

On its own segment a marker keeps its distances to the markers whose place is known, and it sits on
the skin, where that segment has landmarks. Over the segments :math:`b`,

.. math:: \min_b \; \Bigl(\frac{s_b}{\sigma_s}\Bigr)^2 + \Bigl(\frac{d_b}{\sigma_d}\Bigr)^2

with the spread :math:`s_b` of its distances to the known markers on :math:`b` and of its place in
the frame of :math:`b` (half and half), and the distance :math:`d_b` of its mean place to the
nearest landmark of :math:`b`. A name that has a counterpart on the other side determines the side.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models.landmarks import LOOSE_SPREAD, Attachment

SKIN_MOTION = 0.005  # [m] standard deviation of a marker relative to its segment
MAX_SEGMENT_SPREAD = 0.05  # [m] maximum spread of distances to the markers of its segment
# [m] maximum distance from the nearest landmark of its segment; wands, helmets
MAX_LANDMARK_DISTANCE = 0.35


def segment_of(
    marker: Float[Array, "n_frames 3"],
    known: Float[Array, "n_frames n_known 3"],
    bodies: Sequence[str],
    frames: Mapping[str, tuple[Float[Array, "n_frames 3"], Float[Array, "n_frames 3 3"]]],
    landmarks: Sequence[Attachment],
    side: str | None = None,
) -> Attachment | None:
    """Return the segment a marker sits on and its place there; None if it is on none.

    Args:
        marker: Its positions [m]; NaN where not seen.
        known: Positions of the markers whose place is known.
        bodies: The segment of each of those.
        frames: Segment → position of its origin and its rotation in each frame.
        landmarks: All landmarks of the person.
        side: ``"r"`` or ``"l"`` if the name determines the side.
    """
    seen = np.isfinite(marker[:, 0])
    best, least = None, np.inf
    apart = np.linalg.norm(marker[seen, None] - known[seen], axis=-1)
    moves = np.array([_spread(column) for column in apart.T])
    for body, (origins, rotations) in frames.items():
        local = np.einsum("nji,nj->ni", rotations[seen], marker[seen] - origins[seen])
        middle = np.median(local, axis=0)
        marks = [mark.position for mark in landmarks if mark.body == body]
        if not marks or (side and body.endswith("_l" if side == "r" else "_r")):
            continue
        far = float(np.linalg.norm(np.array(marks) - middle, axis=1).min())
        wander = float(np.linalg.norm(local - middle, axis=1).mean())
        own = moves[[b == body for b in bodies]]
        own = own[np.isfinite(own)]
        kept = float(np.mean(own**2)) if len(own) else wander**2
        spread = np.sqrt((kept + wander**2) / 2)
        if spread > MAX_SEGMENT_SPREAD or far > MAX_LANDMARK_DISTANCE:
            continue
        cost = (spread / SKIN_MOTION) ** 2 + (far / LOOSE_SPREAD) ** 2
        if cost < least:
            best, least = Attachment(body, middle, np.inf), cost
    return best


def _spread(values: Float[Array, " n"]) -> float:
    """Return the standard deviation of what was seen; NaN of fewer than three."""
    seen = values[np.isfinite(values)]
    return float(seen.std()) if len(seen) >= 3 else float("nan")
