"""Recordings of a laboratory as a video system would have them: keypoints with noise and gaps.

The keypoints are the joint centres and landmarks of the body that was fitted to the markers, so
that the angles of that fit are exact; noise, rate and gaps are those of several cameras.
"""

import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet
from plantigrade.models.keypoints import KEYPOINTS
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Recording

_ARMS_AND_LEGS = "Hip Knee Ankle Shoulder Elbow Wrist"
_FEET = "BigToe SmallToe Heel"


def _both(parts: str) -> tuple[str, ...]:
    return tuple(f"{side}{part}" for part in parts.split() for side in "RL")


SETS = {
    "HALPE_26": ("Hip", "Neck", "Head", "Nose", *_both(f"{_ARMS_AND_LEGS} {_FEET}")),
    "COCO": ("Nose", *_both(f"{_ARMS_AND_LEGS} Eye Ear")),
    "BlazePose": (
        "nose",
        *(
            f"{side}_{part}"
            for part in "hip knee ankle shoulder elbow wrist ear eye heel foot_index".split()
            for side in ("right", "left")
        ),
    ),
}
"""Names of the keypoints of a detector; without feet in COCO."""


@dataclass(frozen=True, kw_only=True)
class Video:
    """What a video system does to the points.

    Attributes:
        keypoints: Set of keypoints, a key of :data:`SETS`.
        rate: Frames per second [Hz].
        noise: RMS distance of a keypoint from its true place [m], equal in the three directions.
        correlation: Time after which the correlation of this noise has fallen to 1/e [s].
        jitter: RMS distance of further noise that is independent from frame to frame [m].
        gaps: Share of missing samples [1], in runs of :data:`GAP` seconds.
    """

    keypoints: str = "HALPE_26"
    rate: float = 60.0
    noise: float = 0.015
    correlation: float = 0.2
    jitter: float = 0.003
    gaps: float = 0.03


GAP = 0.15  # [s] duration of a gap


def as_video(fit: Fit, video: Video, seed: str = "") -> Recording:
    """Return the keypoints of a fitted recording; the same seed gives the same noise."""
    names = SETS[video.keypoints]
    table = attachments(fit.human)
    places = [table[KEYPOINTS[name]] for name in names]
    path = PointSet.of(fit.human, places).path(fit.qpos)
    time = np.arange(fit.time[0], fit.time[-1], 1.0 / video.rate)
    points = np.stack(
        [np.interp(time, fit.time, column) for column in path.reshape(len(path), -1).T], axis=1
    ).reshape(len(time), len(names), 3)
    rng = np.random.default_rng(zlib.crc32(f"{seed}{fit.recording.source.name}".encode()))
    points += video.noise * _slow_noise(rng, points.shape, video.correlation * video.rate)
    points += video.jitter / np.sqrt(3.0) * rng.standard_normal(points.shape)
    length = max(1, round(GAP * video.rate))
    starts = rng.random(points.shape[:2]) < video.gaps / length
    for frame, k in np.argwhere(starts):
        points[frame : frame + length, k] = np.nan
    return replace(
        fit.recording,
        source=Path(f"{fit.recording.source.stem}_{video.keypoints}.trc"),
        markers=Markers(names, time, points),
        static=None,
        plates=(),
        companions=(),
        warnings=(),
    )


def _slow_noise(rng, shape: tuple[int, ...], frames: float) -> Float[Array, "n_frames n 3"]:
    """Return noise of unit RMS length whose correlation decays exponentially over some frames."""
    kept = float(np.exp(-1.0 / frames))
    white = rng.standard_normal(shape)
    white[1:] *= np.sqrt(1.0 - kept**2)
    return lfilter([1.0], [1.0, -kept], white, axis=0) / np.sqrt(3.0)
