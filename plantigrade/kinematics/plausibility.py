"""Whether a recording can be of a person at all: size, place, posture, error that is left.

Impossible recordings are refused with the likely cause; unusual ones give a warning.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from plantigrade.arrays import Array, Float
from plantigrade.errors import FitError
from plantigrade.motion import Recording

MIN_MARKERS = 6  # [1] minimum number of markers with known positions for a fit
PLAUSIBLE_EXTENT = (0.25, 4.0)  # [m] range of the diagonal of the bounding box of all markers
# [m] maximum distance from the origin; beyond it the precision is insufficient
MAX_COORDINATE = 1e5
MIN_UPRIGHT_COSINE = 0.35  # [1] minimum cosine of the trunk's lean in standing and walking
MAX_ERROR = {"marker": 0.04, "joint": 0.08}  # [m] maximum mean error of a fit
MAX_MARKER_DISTANCE = 3.0  # [m] maximum distance of a sample from the centre of the markers
HALF_WINDOW = 5  # [1] frames on each side for the running median of this centre


def require_one_person(known: Sequence[str], source: object) -> None:
    """Raise where markers of several people are in one file, distinguished by ``Name:LKNE``."""
    owners = Counter(name.rpartition(":")[0] for name in known)
    people = sorted(owner for owner, count in owners.items() if count >= MIN_MARKERS)
    if len(people) > 1:
        raise FitError(
            f"{source} holds the markers of {len(people)} people ({', '.join(people)}); one is "
            "fitted at a time: export each to a file of its own"
        )


def require_human_size(samples: Float[Array, "n_frames n_markers 3"], source: object) -> None:
    """Raise where the markers of a frame spread over no person."""
    seen = np.isfinite(samples[..., 0])
    frames = samples[seen.sum(axis=1) >= 3]
    if not len(frames):
        return
    farthest = float(np.nanmedian(np.nanmax(np.abs(frames), axis=(1, 2))))
    if farthest > MAX_COORDINATE:
        raise FitError(
            f"{source}: the markers lie {farthest:.3g} m from the origin, where rounding hides "
            f"millimetres; allowed are {MAX_COORDINATE:.0e} m: check the unit, or move the origin"
        )
    box = np.nanmax(frames, axis=1) - np.nanmin(frames, axis=1)
    spread = float(np.median(np.linalg.norm(box, axis=1)))
    if not PLAUSIBLE_EXTENT[0] <= spread <= PLAUSIBLE_EXTENT[1]:
        raise FitError(
            f"{source}: the markers of one frame spread over {spread:.3g} m; those of a person "
            f"over {PLAUSIBLE_EXTENT[0]} to {PLAUSIBLE_EXTENT[1]:.0f} m: "
            "check the file's unit of length"
        )


def without_far_samples(recording: Recording) -> tuple[Recording, int]:
    """Return the recording without samples out of the person's reach, and how many they were.

    The middle of the markers moves little within a few frames; a frame whose middle jumps, or a
    sample far from it, is a fault of the measurement, and would drag the body along.
    """
    markers = recording.markers
    assert markers is not None
    middle = np.full((markers.n_frames, 3), np.nan)
    some = np.any(np.isfinite(markers.positions[..., 0]), axis=1)
    middle[some] = np.nanmedian(markers.positions[some], axis=1)
    around = middle.copy()
    padded = np.pad(middle, ((HALF_WINDOW, HALF_WINDOW), (0, 0)), constant_values=np.nan)
    near = sliding_window_view(padded, 2 * HALF_WINDOW + 1, axis=0)  # (n_frames, 3, window)
    known = np.isfinite(near[:, 0]).any(axis=1)
    around[known] = np.nanmedian(near[known], axis=2)
    distance = np.linalg.norm(markers.positions - around[:, None], axis=2)
    far = distance > MAX_MARKER_DISTANCE
    if not far.any():
        return recording, 0
    kept = np.where(far[..., None], np.nan, markers.positions)
    return replace(recording, markers=replace(markers, positions=kept)), int(far.sum())


def lean_notes(rotations: Float[Array, "n_frames 3 3"]) -> list[str]:
    """Return a sentence where the trunk, whose z axis points to the head, is mostly not upright."""
    cosine = float(np.median(rotations[:, 2, 2]))
    if cosine >= MIN_UPRIGHT_COSINE:
        return []
    how = "upside down" if cosine < -MIN_UPRIGHT_COSINE else "lying"
    return [
        f"the person is {how} in most frames ({np.rad2deg(np.arccos(cosine)):.0f}° from upright); "
        "if this is wrong, the vertical axis of the file is not z: rotate it first."
    ]


def verdict(error: float | None, kind: str) -> str:
    """Return ``"ok"``, or why the result cannot be called a fit.

    Args:
        error: Mean error that is left [m], where there is one.
        kind: ``"marker"`` or ``"joint"``.
    """
    if error is None or error <= MAX_ERROR[kind]:
        return "ok"
    if np.isfinite(error):
        return (
            f"the body could not be fitted to the recording: mean {kind} error "
            f"{1e3 * error:.0f} mm, at most {1e3 * MAX_ERROR[kind]:.0f} is allowed; check "
            "names, units and that all frames are of one person"
        )
    return "the body could not be fitted to the recording: no error is known"
