r"""What the distances of markers to a joint of the next segment show of their clocks and places.

A marker keeps its distance :math:`\rho_i` to a joint centre :math:`s` of the neighbouring segment.
With its position :math:`p_i(t)` in the frame of that segment,

.. math:: p_i(t) \cdot s + \tfrac12 (\rho_i^2 - \lVert s \rVert^2)
    = \tfrac12 \lVert p_i(t) \rVert^2 ,

which is linear in :math:`s` and one constant per marker [Gamage2002]_. Markers that are later than
those of the segment keep no distance to any point of it: :math:`s` is estimated for a range of
delays, and the delay with the smallest error is that of the markers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, Int, root_mean_square, spread
from plantigrade.constants import SIDE_NAMES
from plantigrade.kinematics.exchanged_labels import ARM_BODIES
from plantigrade.models.landmarks import Attachment
from plantigrade.motion.filters import vertex

# Segments whose angles are those of a gait analysis; what follows the shank belongs to the foot.
LEG = {"pelvis": "pelvis", "femur": "thigh", "tibia": "shank"}


def segment_of_leg(body: str) -> str:
    """Return the segment of pelvis and legs to which a body belongs; empty for others.

    Example:
        >>> segment_of_leg("femur_r"), segment_of_leg("calcn_l"), segment_of_leg("torso")
        ('right thigh', 'left foot', '')
    """
    stem, _, side = body.rpartition("_")
    if body == "pelvis":
        return "pelvis"
    if side not in SIDE_NAMES or stem.startswith((*ARM_BODIES, "clavicle")):
        return ""
    return f"{SIDE_NAMES[side]} {LEG.get(stem, 'foot')}"


MAX_DELAY = 0.1  # [s] largest delay of a leg that is considered
MIN_DELAY = 0.025
"""Delay from which markers are called late [s]; sound recordings have up to 0.010, which is the
skin's."""
MAX_ERROR_RATIO = 0.75
"""Maximum ratio of the error with the delay to that without; 0.43 to 0.51 in a leg 50 ms late,
above 0.9 in sound walks, runs, squats and jumps."""
MIN_ERROR = 0.001  # [m] minimum error without a delay; people at rest have less
MIN_SEEN = 0.9  # [1] minimum share of frames in which a marker is seen
MIN_CLUSTER = 3  # [1] markers that give the pose of a segment
MIN_FRAMES = 40  # [1] minimum number of frames with all of them
MAX_FRAMES = 300  # [1] maximum number of frames that are looked at, evenly spread


@dataclass(frozen=True)
class SegmentPoses:
    """Poses of a segment from its markers in some frames."""

    frames: Int[Array, " n_frames"]  #: Frames, as indices
    rotation: Float[Array, "n_frames 3 3"]  #: Axes of the segment in the laboratory
    origin: Float[Array, "n_frames 3"]  #: Middle of its markers [m]

    @classmethod
    def of(cls, x: Float[Array, "n_frames n_markers 3"], margin: int = 0) -> "SegmentPoses | None":
        """Return the poses in frames that show all markers; None where there are too few.

        Args:
            x: Positions [m]; NaN where not seen.
            margin: Frames at both ends that are left out.
        """
        frames = np.flatnonzero(np.isfinite(x[..., 0]).all(axis=1))
        frames = frames[(frames >= margin) & (frames < len(x) - margin)]
        if len(frames) < MIN_FRAMES or x.shape[1] < MIN_CLUSTER:
            return None
        frames = frames[spread(len(frames), MAX_FRAMES)]
        seen = x[frames]
        origin = seen.mean(axis=1)
        arms = seen - origin[:, None]
        shape = arms[len(arms) // 2]
        u, _, v = np.linalg.svd(np.einsum("nij,ik->njk", arms, shape))
        proper = np.sign(np.linalg.det(u @ v))
        rotation = (u * np.stack([0 * proper + 1, 0 * proper + 1, proper], axis=1)[:, None]) @ v
        return cls(frames, rotation, origin)

    def seen_from_here(
        self, x: Float[Array, "n_frames n_markers 3"], later: int = 0
    ) -> Float[Array, "n_here n_markers 3"]:
        """Return markers some frames later in the frame of the segment [m]."""
        return np.einsum(
            "nji,nmj->nmi", self.rotation, x[self.frames + later] - self.origin[:, None]
        )


def joint_centre(p: Float[Array, "n_frames n_markers 3"]) -> tuple[Float[Array, " 3"], float]:
    """Return the point to which all markers keep their distances, and the error left [m]."""
    n = p.shape[1]
    length = np.sqrt(np.nanmean((p**2).sum(axis=2), axis=0))
    A = np.zeros((*p.shape[:2], 3 + n))
    A[..., :3] = p / length[:, None]
    A[:, np.arange(n), 3 + np.arange(n)] = 1.0
    b = 0.5 * (p**2).sum(axis=2) / length
    seen = np.isfinite(b)
    A, b = A[seen], b[seen]
    found = np.linalg.lstsq(A, b, rcond=None)[0]
    return found[:3], root_mean_square(A @ found - b)


def late_notes(
    places: Sequence[Attachment], rate: float, samples: Float[Array, "n_frames n_markers 3"]
) -> list[str]:
    """Return a sentence for each segment of the legs whose markers are late to its neighbour.

    Args:
        rate: Frames per second [Hz].
        samples: Positions of the markers [m]; NaN where not seen.
    """
    margin = int(MAX_DELAY * rate)
    notes = []
    for side in SIDE_NAMES.values():
        pairs = [("pelvis", f"{side} thigh")]
        pairs += [(f"{side} shank", f"{side} {other}") for other in ("thigh", "foot")]
        for one, other in pairs:
            segment = SegmentPoses.of(samples[:, seen_markers(places, samples, one)], margin)
            x = samples[:, seen_markers(places, samples, other)]
            if segment is None or not x.shape[1]:
                continue
            delay = _delay(segment, x, margin) / rate
            if abs(delay) >= MIN_DELAY:
                how = "later" if delay > 0 else "earlier"
                notes.append(
                    f"the markers of the {other} are {1e3 * abs(delay):.0f} ms {how} than those of "
                    f"the {one}: two clocks or systems were joined with an offset; shift one of "
                    "them in time, and do not trust the angles between them."
                )
    return notes


def _delay(segment: SegmentPoses, x: Float[Array, "n_frames n_markers 3"], margin: int) -> float:
    """Return by how many frames markers are later than a segment; 0 where nothing shows it."""
    steps = np.arange(-margin, margin + 1)
    error = np.array([joint_centre(segment.seen_from_here(x, int(k)))[1] for k in steps])
    best, now = int(error.argmin()), error[margin]
    if not 0 < best < len(steps) - 1 or now < MIN_ERROR or error[best] > MAX_ERROR_RATIO * now:
        return 0.0
    return float(steps[best]) + vertex(error**2, best)


def seen_markers(
    places: Sequence[Attachment], samples: Float[Array, "n_frames n_markers 3"], segment: str
) -> list[int]:
    """Return the markers of a segment that are seen nearly always."""
    often = np.isfinite(samples[..., 0]).mean(axis=0) >= MIN_SEEN
    return [i for i, p in enumerate(places) if often[i] and segment_of_leg(p.body) == segment]
