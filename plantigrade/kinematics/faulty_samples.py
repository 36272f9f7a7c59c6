"""Samples that no camera measured: repeated frames, straight fills, frozen markers, cuts.

Measured positions have noise. A marker that keeps its position or its velocity to the micrometre
for a tenth of a second was not measured, but repeated or interpolated by a program; such samples
are left out, and the fit interpolates the body instead. A recording in which the whole body jumps
lacks frames or was joined from parts; the longest part is kept.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float, spread
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import other_side
from plantigrade.motion import Markers
from plantigrade.motion.distances import MAX_FRAMES
from plantigrade.motion.filters import runs
from plantigrade.printable import listed

MICROMETRE = 2e-6  # [m] rounding of single-precision millimetres
MIN_FILL_TIME = 0.1  # [s] minimum duration of a fill; shorter ones are harmless
MIN_FILL_FRAMES = 8  # [1] and its minimum number of frames
MIN_TRAVEL = 0.03  # [m] minimum path that no marker covers at a constant velocity
MAX_SHARE = 0.8  # [1] share of markers that move alike: the body itself is at rest, or synthetic
MAX_NEIGHBOURS = 3  # [1] number of neighbours of a marker that is alone on its segment
MIN_SPEED = 0.2  # [m/s] speed of a body that does not come to rest from one frame to the next
MIN_REPEATED = 2  # [1] minimum number of repetitions of a frame; doubled frame rates have one
# [m] minimum jump of the middle marker of all, relative to constant velocity; 50 ms of walking
MIN_CUT = 0.05
CUT_FRAMES = 4  # [1] frames on each side of a jump that must be free of others
MAX_GLUED = 0.005  # [m] distance of two markers that are one; the radius of small markers
MIN_GLUED_FRAMES = 10  # [1] minimum number of frames with both


def without_faulty_samples(
    markers: Markers, placed: Mapping[str, Attachment | None]
) -> tuple[Markers, list[str]]:
    """Return the markers without samples that were not measured, and a sentence on each kind.

    Args:
        placed: Attachments of markers with known places.
    """
    x, notes = markers.positions, []
    if len(x) < MIN_FILL_FRAMES:
        return markers, []
    step = differences(x, 1)
    middle = _median(step)
    repeated = _repeated(step, middle, markers.rate)
    if repeated.any():
        x = np.where(repeated[:, None, None], np.nan, x)
        notes.append(
            f"{repeated.sum()} frames repeat the one before while the person moves "
            f"({_spans(repeated, markers)}); they were interpolated."
        )
    fills = _fills(x, markers, placed)
    if fills.any():
        x = np.where(fills[..., None], np.nan, x)
        columns = np.flatnonzero(fills.any(axis=0))
        named = [f"{markers.names[i]} ({_spans(fills[:, i], markers)})" for i in columns]
        notes.append(
            "positions that stand still or move straight to the micrometre were not measured and "
            f"were left out: {listed(named, 8)}."
        )
    part = _longest_part(x)
    if part.stop - part.start < len(x):
        x = np.array(x)
        x[: part.start] = x[part.stop :] = np.nan
        time = markers.time
        notes.append(
            "the whole body jumps from one frame to the next: frames are missing, or recordings "
            f"were joined; only {time[part.start]:.2f} to {time[part.stop - 1]:.2f} s was fitted."
        )
    return (replace(markers, positions=x) if notes else markers), notes


def glued(markers: Markers, names: Sequence[str], landmark: Mapping[str, str | None]) -> list[str]:
    """Return the markers that share one trajectory although their names mean different places.

    Either name may be the wrong one. Of two markers with one landmark the second is returned, and
    of one with a landmark and one with an unknown name, which has no twin on the other side, the
    latter: it may be a trajectory that was not labelled.
    """
    x = markers.select(list(names)).positions[spread(markers.n_frames, MAX_FRAMES)]
    apart = np.full((len(names), len(names)), np.inf)
    for i in range(len(names)):
        distance = np.linalg.norm(x - x[:, i, None], axis=2)
        both = np.isfinite(distance).sum(axis=0) >= MIN_GLUED_FRAMES
        apart[i, both] = np.nanmax(distance[:, both], axis=0)
    found: dict[str, None] = {}
    for i, j in np.argwhere(np.triu(apart < MAX_GLUED, 1)).tolist():
        a, b = names[i], names[j]
        known = [landmark.get(n) or other_side(n, names) for n in (a, b)]
        if None in known:
            found[a if known[0] is None and known[1] is not None else b] = None
        else:
            found |= {b: None} if known[0] == known[1] else {a: None, b: None}
    return list(found)


def differences(x: Float[Array, "n_frames n 3"], order: int) -> Float[Array, "n_less n"]:
    """Return the size of the first or second difference of every marker [m], one by one."""
    found = [np.linalg.norm(np.diff(x[:, i], order, axis=0), axis=1) for i in range(x.shape[1])]
    return np.stack(found, axis=1)


def _median(values: Float[Array, "n n_markers"]) -> Float[Array, " n"]:
    """Return the median over markers; 0 where fewer than three are seen."""
    common = np.isfinite(values).sum(axis=1) >= 3
    middle = np.zeros(len(values))
    middle[common] = np.nanmedian(values[common], axis=1)
    return middle


def _repeated(
    step: Float[Array, "n_less n"], middle: Float[Array, " n_less"], rate: float
) -> Bool[Array, " n_frames"]:
    """Return the frames in which all markers are where they were in the frame before."""
    largest = np.max(np.nan_to_num(step), axis=1)
    still = (np.isfinite(step).sum(axis=1) >= 3) & (largest < MICROMETRE)
    found = np.zeros(len(step) + 1, dtype=bool)
    for run in runs(still):
        edges = [k for k in (run.start - 1, run.stop) if 0 <= k < len(step)]
        moving = bool(edges) and bool((middle[edges] * rate > MIN_SPEED).all())
        if run.stop - run.start >= MIN_REPEATED and moving:
            found[run.start + 1 : run.stop + 1] = True
    return found


def _fills(
    x: Float[Array, "n_frames n 3"], markers: Markers, placed: Mapping[str, Attachment | None]
) -> Bool[Array, "n_frames n"]:
    """Return the samples of markers that stand still or move straight."""
    straight = differences(x, 2) < MICROMETRE
    count = np.isfinite(x[1:-1, :, 0]).sum(axis=1)
    straight[straight.sum(axis=1) > MAX_SHARE * count] = False
    found = np.zeros(x.shape[:2], dtype=bool)
    least = max(MIN_FILL_FRAMES, int(np.ceil(MIN_FILL_TIME * markers.rate)))
    bodies = [p.body if (p := placed.get(n)) else "" for n in markers.names]
    for i, body in enumerate(bodies):
        for run in runs(straight[:, i]):
            if run.stop - run.start < least:
                continue
            span = slice(run.start, run.stop + 2)
            own = np.linalg.norm(x[span.stop - 1, i] - x[span.start, i])
            mates = [j for j, b in enumerate(bodies) if b == body != "" and j != i]
            others = x[span, mates or _nearest(x[run.start], i)]
            travel = np.linalg.norm(np.nanmax(others, axis=0) - np.nanmin(others, axis=0), axis=1)
            if own > MIN_TRAVEL or np.median(travel) > MIN_TRAVEL:  # False if never seen
                stop = span.stop - (own > MIN_TRAVEL)  # a straight line ends where it was measured
                found[span.start + 1 : stop, i] = True
    return found


def _nearest(frame: Float[Array, "n 3"], i: int) -> list[int]:
    """Return the markers next to one in a frame."""
    distance = np.linalg.norm(frame - frame[i], axis=1)
    return [int(j) for j in np.argsort(distance)[1 : MAX_NEIGHBOURS + 1]]


def _longest_part(x: Float[Array, "n_frames n 3"]) -> slice:
    """Return the frames of the longest part without a jump of the whole body.

    A jump between two frames changes the second differences of both, one faulty frame those of
    three.
    """
    jumps = np.pad(_median(differences(x, 2)) > MIN_CUT, CUT_FRAMES)  # frame 1 is at CUT_FRAMES
    edges = [0, len(x)]
    for first in np.flatnonzero(jumps[:-1] & jumps[1:]):
        near = jumps[first - CUT_FRAMES + 1 : first + CUT_FRAMES + 1]
        if near.sum() == 2:
            edges.append(int(first) - CUT_FRAMES + 2)
    edges.sort()
    start = int(np.argmax(np.diff(edges)))
    return slice(edges[start], edges[start + 1])


def _spans(mask: Bool[Array, " n_frames"], markers: Markers) -> str:
    """Return the times of runs."""
    spans = [f"{markers.time[r.start]:.2f} to {markers.time[r.stop - 1]:.2f} s" for r in runs(mask)]
    return listed(spans, 3)
