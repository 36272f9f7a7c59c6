"""Warnings on markers of a fit: segments not seen, markers that slipped, axes of unequal scale.

**Scale of the vertical.** Markers on one segment keep their distance while it turns. Where heights
are multiplied by :math:`s`, what is constant is :math:`h^2 + z^2 / s^2`, with the horizontal
distance :math:`h` and the recorded vertical one :math:`z` of two markers: their squares fall on a
line of slope :math:`-1 / s^2`, whatever the distance.
"""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.joint_distances import segment_of_leg
from plantigrade.kinematics.state import PointSet, body_paths
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import other_side
from plantigrade.motion.filters import runs
from plantigrade.printable import listed
from plantigrade.side_names import without_side

MIN_UNSEEN_TIME = 0.2  # [s] gap in which a joint turns by some degrees
MAX_SLIP = 0.010
"""Largest shift of a marker on pelvis, legs or feet between the halves of a recording [m]; the skin
of walkers, runners and people who squat gives up to 6 mm."""
USUAL_ERROR = 0.015
"""Mean marker error above which some markers are in doubt [m]; fits have 4 to 11 mm."""
MIN_SLIP_FRAMES = 20  # [1] minimum number of frames with a marker in each half
MIN_CLUSTER = 3  # [1] number of markers of one name and number that show where one belongs
MIN_SLIP_TIME = 0.6
"""Minimum duration of each half [s]; skin shifts by 10 to 20 mm within a step."""
MAX_SCALE_ERROR = 0.07
"""Largest deviation of the vertical scale from 1; sound recordings of walking, running, squats and
jumps have up to 0.03, from skin that moves with the joints."""
MIN_TURN = 0.08
"""Smallest standard deviation of the squared vertical distance over the squared distance [1]; that
of a thigh in walking is about 0.1, of a shank 0.2."""
MIN_PAIRS = 6  # [1] number of pairs of markers that turn enough
MIN_FRAMES = 30  # [1] number of frames with both


def unseen_notes(
    places: Sequence[Attachment],
    time: Float[Array, " n_frames"],
    samples: Float[Array, "n_frames n_markers 3"],
) -> list[str]:
    """Return a sentence for each gap in which no marker of a segment of the legs was seen."""
    segments = [segment_of_leg(p.body) for p in places]
    notes = []
    for segment in dict.fromkeys(s for s in segments if s):
        own = [i for i, s in enumerate(segments) if s == segment]
        unseen = ~np.isfinite(samples[:, own, 0]).any(axis=1)
        for run in runs(np.asarray(unseen)):
            start, stop = time[run.start], time[run.stop - 1]
            if stop - start >= MIN_UNSEEN_TIME:
                notes.append(
                    f"no marker of the {segment} was seen from {start:.2f} to {stop:.2f} s; its "
                    "pose there, and the angles of its joints, are interpolated."
                )
    return notes


def error_notes(error: float) -> list[str]:
    """Return a sentence on an unusual mean marker error [m]."""
    if not error > USUAL_ERROR:
        return []
    return [
        f"the mean marker error is {1e3 * error:.0f} mm, usually 4 to 8 mm: names, positions or "
        "the unit of some markers may be wrong; do not trust the angles."
    ]


def twin_notes(attached: Mapping[str, str], names: Sequence[str]) -> list[str]:
    """Return a sentence where markers of unknown name move with other segments than their like.

    Args:
        attached: Markers of unknown name → the body they move with.
        names: The markers that were fitted.
    """
    # A joint's centre moves with both of its segments: either may be found.
    attached = {name: body for name, body in attached.items() if not _CENTRE.search(name.lower())}
    apart = []
    clusters: dict[str, list[str]] = {}
    for name in attached:
        clusters.setdefault(name.rstrip("0123456789"), []).append(attached[name])
    for name in attached:
        own = clusters[name.rstrip("0123456789")]
        if own.count(attached[name]) == 1 and len(own) >= MIN_CLUSTER and len({*own}) == 2:
            apart.append(f"{name} with {attached[name]}, others of its name with another")
            continue
        twin = other_side(name, names)
        if twin not in attached or twin is None or name > twin:
            continue
        one, two = attached[name], attached[twin]
        if without_side(one) != without_side(two) or (one == two) != (one == without_side(one)):
            apart.append(f"{name} with {one}, {twin} with {two}")
    if not apart:
        return []
    return [
        "markers of one name move with segments that do not correspond ("
        f"{listed(apart, 4)}): their labels may be exchanged with each other or with another's."
    ]


_CENTRE = re.compile("cent(er|re)|jc")


def slip_notes(
    human: Human,
    names: Sequence[str],
    places: Sequence[Attachment],
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    samples: Float[Array, "n_frames n_markers 3"],
) -> list[str]:
    """Return a sentence where markers shift on their segments between the halves of a recording."""
    which = [i for i, p in enumerate(places) if segment_of_leg(p.body)]
    short = len(qpos) < 2 * MIN_SLIP_FRAMES or time[-1] - time[0] < 2 * MIN_SLIP_TIME
    if not which or short:
        return []
    off = samples[:, which] - PointSet.of(human, [places[i] for i in which]).path(qpos)
    bodies = [human.body(places[i].body) for i in which]
    unique = sorted(set(bodies))
    axes = body_paths(human, qpos, unique)[1]
    half, slips = len(qpos) // 2, {}
    for k, (i, body) in enumerate(zip(which, bodies, strict=True)):
        local = np.einsum("nji,nj->ni", axes[:, unique.index(body)], off[:, k])
        first, second = (x[np.isfinite(x[:, 0])] for x in (local[:half], local[half:]))
        if min(len(first), len(second)) >= MIN_SLIP_FRAMES:
            slip = float(np.linalg.norm(second.mean(axis=0) - first.mean(axis=0)))
            if slip > MAX_SLIP:
                slips[names[i]] = slip
    if not slips:
        return []
    worst = sorted(slips, key=lambda name: -slips[name])
    return [
        f"markers shift on the body by up to {1e3 * slips[worst[0]]:.0f} mm from the first to the "
        f"second half of the recording ({listed(worst, 6)}): markers of these or of neighbouring "
        "segments slipped, or were exchanged; angles may be off by several degrees."
    ]


def scale_notes(
    places: Sequence[Attachment], samples: Float[Array, "n_frames n_markers 3"]
) -> list[str]:
    """Return a sentence where lengths of thighs and shanks change with their inclination.

    Args:
        samples: Positions of the markers [m]; NaN where not seen.
    """
    scale = vertical_scale(places, samples)
    if scale is None or abs(scale - 1) <= MAX_SCALE_ERROR:
        return []
    return [
        f"heights are {scale:.2f} times what they should be beside the horizontal distances: "
        "thighs and shanks change their lengths as they lean; the unit or the calibration "
        "of one axis is wrong, and so are lengths, mass and angles."
    ]


def vertical_scale(
    places: Sequence[Attachment], samples: Float[Array, "n_frames n_markers 3"]
) -> float | None:
    """Return the scale of the vertical to that of the horizontal axes; None where unknown [1]."""
    segments = [segment_of_leg(p.body) for p in places]
    found = []
    for i, j in zip(*np.triu_indices(len(places), 1), strict=True):
        if segments[i] != segments[j] or not segments[i].endswith(("thigh", "shank")):
            continue
        apart = samples[:, i] - samples[:, j]
        apart = apart[np.isfinite(apart[:, 0])]
        h2, z2 = (apart[:, :2] ** 2).sum(axis=1), apart[:, 2] ** 2
        if len(apart) < MIN_FRAMES or z2.std() < MIN_TURN * (h2 + z2).mean():
            continue
        slope = -float(np.cov(h2, z2)[0, 1] / z2.var(ddof=1))
        found.append(slope)
    if len(found) < MIN_PAIRS or (middle := float(np.median(found))) <= 0:
        return None
    return middle**-0.5
