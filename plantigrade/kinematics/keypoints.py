r"""Keypoints of a video before the fit: a low-pass that suits their noise, and the floor.

Cameras have no floor: it is where the feet stand. A point of a foot stands for a third of the time
or more in walking, so that its heights pile up there, and noise moves that pile less than it moves
the lowest point.

**Noise** shows in lengths that should be constant. The distance between the centres of two
neighbouring joints is that of a bone. Its variance over a recording is the sum of the variances of
both centres along the bone, and neither motion nor a constant offset of a centre adds to it:

.. math:: \operatorname{var} |x_a - x_b| = \sigma_a^2 + \sigma_b^2 .
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.errors import FitError
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.keypoints import KEYPOINTS, shows_toes
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers
from plantigrade.motion.filters import fill_gaps, lowpass, runs
from plantigrade.motion.recording import even_clock
from plantigrade.notes import Info
from plantigrade.spatial.conventions import about_axis

# Ends of a bone → its length among those of the body
BONES = {
    ("hip_joint", "knee_joint"): "thigh",
    ("knee_joint", "ankle_joint"): "shank",
    ("shoulder_joint", "elbow_joint"): "upper_arm",
    ("elbow_joint", "wrist_joint"): "forearm",
}
PER_DEVIATION = 1.4826  # [1] standard deviation over median absolute deviation, normal noise
MIN_FRAMES = 10  # [1] minimum number of frames that show both ends of a bone
USUAL_NOISE = 0.010  # [m] where no bone is seen for long enough


@dataclass(frozen=True)
class BonesOfVideo:
    """What the keypoints of a video tell of bones."""

    noise: float  #: Standard deviation of a keypoint in each direction [m]
    lengths: Mapping[str, float]  #: Median lengths, by name of the dimension [m]


def bones_of_video(markers: Markers) -> BonesOfVideo:
    """Return noise and lengths of bones of the keypoints of a video."""
    columns = {KEYPOINTS.get(name): i for i, name in enumerate(markers.names)}
    at = {mark: markers.positions[:, i] for mark, i in columns.items()}
    variances, found = [], {}
    for side in "rl":
        for ends, dimension in BONES.items():
            a, b = (at.get(f"{end}_{side}") for end in ends)
            if a is None or b is None:
                continue
            length = np.linalg.norm(a - b, axis=1)
            length = length[np.isfinite(length)]
            if len(length) >= MIN_FRAMES:
                spread = PER_DEVIATION * np.median(np.abs(length - np.median(length)))
                variances.append(spread**2 / 2)
                found.setdefault(dimension, []).append(float(np.median(length)))
    noise = float(np.sqrt(np.median(variances))) if variances else USUAL_NOISE
    return BonesOfVideo(noise, {name: float(np.mean(each)) for name, each in found.items()})


# [Hz] low-pass of keypoints with little noise, usual for walking, and the lowest one: below it, the
# swing of a leg is damped
CUTOFFS = (6.0, 4.0)
LITTLE_NOISE = 0.005  # [m] noise in each direction up to which the first of them is used
# [1/m] increase of the bands of estimated forces with the noise in each direction, above that at
# which they hold: a third at 14 mm. The program knows noise only where it contradicts the contacts,
# and that of the body's height does so little; settled on three people, recorded as video.
BAND_PER_NOISE, NOISE_OF_BANDS = 40.0, 0.006
UNSEEN_FEET_BAND = 1.55  # [1] factor of these bands without toes, whose events are less certain
LONGEST_GAP = 0.25  # [s] gap that is bridged while the keypoints are filtered
STANDING_SHARE = 0.3  # [1] share of the time for which a point of a foot stands in walking
MIN_DEPTH = 1e-4  # [m] spread of a keypoint over time along an axis that was measured
# [rad] tilt of the floor along the way from which it is removed: less is within the noise
MIN_TILT = np.radians(1.0)
MAX_TILT = np.radians(5.0)  # [rad] a board that stood by eye; steeper is a ramp, or stairs
MIN_WAY = 1.5  # [m] length of the way that shows a tilt: two steps
REST_SPEED = 0.3  # [m/s] of a point of a foot that stands; smoothed noise of video moves at 0.1
MIN_FRAMES = 10  # [1] minimum number of frames that show a point of a foot
TILT_OF_VIDEO = (
    "keypoints of a video do not show the tilt of the pelvis: it follows from the trunk and usual "
    "posture of people, who differ by 8° (standard deviation). Pelvis tilt and hip flexion have a "
    "constant error of that size; the shape of the curves is unaffected."
)
_OF_FOOT = ("ankle_joint", "heel", "hallux", "toe_5", "toe_tip")


def of_video(
    markers: Markers, human: Human, noise: float, *, grounded: bool
) -> tuple[Markers, list[str]]:
    """Return the keypoints of a video smoothed and above the floor z = 0, and notes.

    Args:
        human: A person of about the size.
        noise: Their noise in each direction [m].
        grounded: Whether force plates give the floor.

    Raises:
        FitError: If the keypoints lie in one plane, as those of one camera.
    """
    require_depth(markers)
    cutoff = cutoff_for(noise)
    markers = smoothed(markers, cutoff)
    notes: list[str] = [
        Info(
            f"keypoints of a video: noise {1e3 * noise:.0f} mm in each direction, by lengths of "
            f"bones; low-pass at {cutoff:.1f} Hz."
        )
    ]
    if not shows_toes(markers.names):
        notes.append(
            "no keypoint shows the toes: feet are assumed to stand flat, ankle angles in swing are "
            "assumed too."
        )
    floor = None if grounded else floor_under(markers, human)
    if floor is not None:
        markers = replace(markers, positions=markers.positions - [0.0, 0.0, floor])
        notes.append(
            Info(f"the floor was found {floor:+.2f} m from the file's origin, by the feet.")
        )
    return markers, notes


def levelled(markers: Markers) -> tuple[Markers, list[str]]:
    """Return keypoints of cameras whose floor is level along the way, and notes.

    The vertical of cameras is that of their calibration, often a board that stood by eye. Points of
    a foot that stands have one height on a level floor: their slope along the way is the tilt.
    """
    at = smoothed(markers, CUTOFFS[1]).positions
    feet = [k for k, n in enumerate(markers.names) if KEYPOINTS.get(n, "")[:-2] in _OF_FOOT]
    whole = np.flatnonzero(np.isfinite(at[:, feet]).all(axis=(1, 2)))
    if not feet or len(whole) < MIN_FRAMES:
        return markers, []
    way = np.diff(at[whole[[0, -1]]][:, feet, :2].mean(axis=1), axis=0)[0]
    length = float(np.linalg.norm(way))
    if length < MIN_WAY:
        return markers, []
    way /= length
    along, height = [], []
    for k in feet:
        speed = np.linalg.norm(np.gradient(at[:, k, :2], markers.time, axis=0), axis=1)
        stands = runs(np.isfinite(at[:, k]).all(axis=1) & (speed < REST_SPEED))
        x = np.array([np.median(at[stand, k, :2] @ way) for stand in stands])
        z = np.array([np.median(at[stand, k, 2]) for stand in stands])
        if len(x) > 1:  # each point of the foot has a height of its own
            along.append(x - np.mean(x))
            height.append(z - np.mean(z))
    if not along or np.ptp(x := np.concatenate(along)) < MIN_WAY / 2:
        return markers, []
    tilt = float(np.arctan(x @ np.concatenate(height) / (x @ x)))
    if not MIN_TILT < abs(tilt) < MAX_TILT:
        return markers, []
    axis = np.array([-way[1], way[0], 0.0])
    turn = about_axis(axis, np.array([tilt]))[0]
    note = (
        f"the floor of the file slopes by {np.degrees(tilt):+.1f}° along the way, as a tilted "
        "calibration of cameras does; this was removed. If it is a ramp, describe it with --ground."
    )
    return replace(markers, positions=markers.positions @ turn.T), [note]


def require_depth(markers: Markers) -> None:
    """Raise where keypoints of one camera lie in the plane of its image."""
    with np.errstate(all="ignore"):
        spread = np.nanmedian(np.nanstd(markers.positions[..., :2], axis=0), axis=0)
    if (spread < MIN_DEPTH).any() and (spread > 10 * MIN_DEPTH).any():
        raise FitError(
            "the keypoints move in one plane only (2-D, one camera): without depth no joint angle "
            "in space and no force follows; triangulate the views of two or more cameras"
        )


def cutoff_for(noise: float) -> float:
    """Return the cut-off frequency [Hz] of the low-pass for keypoints of a video.

    Keypoints with little noise are filtered at the first of :data:`CUTOFFS`. The frequency falls
    with the square root of the noise, down to the second.

    Args:
        noise: Noise of the keypoints in each direction, root mean square [m].
    """
    most, least = CUTOFFS
    return float(np.clip(most * np.sqrt(LITTLE_NOISE / max(noise, 1e-6)), least, most))


def force_band_factor(noise: float, names: Sequence[str]) -> float:
    """Return the factor of the bands of estimated forces [1].

    Args:
        noise: Noise of the keypoints in each direction [m].
    """
    unseen = 1.0 if shows_toes(names) else UNSEEN_FEET_BAND
    return unseen * (1.0 + BAND_PER_NOISE * max(0.0, noise - NOISE_OF_BANDS))


def smoothed(markers: Markers, cutoff: float) -> Markers:
    """Return the keypoints after a low-pass at a frequency [Hz]; gaps stay gaps."""
    if not cutoff < 0.45 * markers.rate:
        return markers
    filled = fill_gaps(markers.time, markers.positions, longest=LONGEST_GAP)
    smooth = lowpass(even_clock(markers.time), filled, cutoff=cutoff)
    return replace(markers, positions=np.where(np.isfinite(markers.positions), smooth, np.nan))


def floor_under(markers: Markers, human: Human) -> float | None:
    """Return the height of the floor [m] from the feet; None where none is seen for long enough."""
    standing, table = human.standing()[None], attachments(human)
    found = []
    for i, name in enumerate(markers.names):
        mark = KEYPOINTS.get(name)
        z = markers.positions[:, i, 2]
        z = np.sort(z[np.isfinite(z)])
        if mark is None or mark[:-2] not in _OF_FOOT or len(z) < MIN_FRAMES:
            continue
        count = round(STANDING_SHARE * len(z))
        first = int(np.argmin(z[count - 1 :] - z[: len(z) - count + 1]))  # the densest heights
        height = PointSet.of(human, [table[mark]]).path(standing)[0, 0, 2]
        found.append(float(np.median(z[first : first + count])) - height)
    return float(np.median(found)) if found else None
