r"""Scale a person to the markers of a few frames.

Joint steps of lengths, marker positions and poses
(:mod:`plantigrade.kinematics.calibrator`) start from poses of standing people.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import FitError
from plantigrade.kinematics.calibrator import Calibrator
from plantigrade.kinematics.posture_prior import PosturePrior
from plantigrade.kinematics.standing_poses import standing_poses
from plantigrade.models import Dimensions, Human
from plantigrade.models.landmarks import Attachment
from plantigrade.printable import listed

MAX_STEPS = 25  # [1] maximum number of joint steps


@dataclass(frozen=True)
class Calibration:
    """A person scaled to markers."""

    human: Human  #: The person with the lengths found
    places: tuple[Attachment, ...]  #: Attachment of each marker
    names: tuple[str, ...]  #: Marker names, in the order of ``places``
    qpos: Float[Array, "n_frames nq"]  #: Poses of the frames used
    #: Marker distances on these frames [m]; NaN where not seen
    residual: Float[Array, "n_frames n_markers"]
    attached: dict[str, str]  #: Markers of unknown name → the body they were put on


def calibrate(
    human: Human,
    names: Sequence[str],
    placed: dict[str, Attachment | None],
    measured: Float[Array, "n_frames n_markers 3"],
    *,
    height: float | None,
    standing: Bool[Array, " n_frames"] | None = None,
    prior: PosturePrior | None = None,
) -> Calibration:
    """Scale a person to the markers of a few frames.

    Args:
        human: The person to start from (average for stature and sex).
        placed: Attachment of each marker, None if unknown.
        measured: Marker positions of the frames to use [m]; NaN where not seen.
        height: Stature to keep [m]; found from the markers if None.
        standing: Frames of a standing trial, with straight legs and trunk.
        prior: What is known of the posture before any marker, for keypoints of video.

    Raises:
        FitError: If too few markers have a known name to give the pose.
    """
    require_known(names, placed)
    c = Calibrator(
        human,
        names,
        placed,
        measured,
        height=height,
        standing=np.zeros(len(measured), bool) if standing is None else standing,
        prior=prior,
    )
    c.qpos = standing_poses(human, c.places, measured, c.points(c.known()))
    if height is None:
        _overall_size(c)
    c.start_from_seen_lengths()
    c.solve_poses()
    attached = _refined(c)
    residual = c.solve_poses()
    scaled = _scaled_person(human, c.dimensions, height)
    _, base = c.geometry(scaled.dimensions)
    places = tuple(
        Attachment(p.body, base[i] + c.offsets[i], p.spread)
        for i, p in enumerate(c.places)
        if p is not None
    )
    which = c.known()
    return Calibration(
        scaled, places, tuple(c.names[i] for i in which), c.qpos, residual[:, which], attached
    )


def _refined(c: Calibrator) -> dict[str, str]:
    """Take joint steps until the error stays; return bodies of markers of unknown name."""
    last = np.inf
    attached: dict[str, str] = {}
    for k in range(MAX_STEPS):
        rms = c.refine()
        if k == 4:
            attached = c.attach_unknown()
        if k > 6 and abs(last - rms) < 1e-5:
            break
        last = rms
    return attached


def _scaled_person(human: Human, d: Dimensions, height: float | None) -> Human:
    """Return the person with lengths of its own, those above the legs adapted to a given height."""
    stature = d.height
    lengths = dict(zip(d.names(), d.as_array(), strict=True))
    if height is not None:
        upper = {n: lengths[n] for n in ("pelvis_height", "trunk", "head")}
        factor = 1 + (height - stature) / sum(upper.values())
        if 0.8 < factor < 1.25:
            lengths |= {n: length * factor for n, length in upper.items()}
            lengths.pop("head")
            stature = height
    return Human.create(stature, human.mass, human.sex, human.joints, human.feet, lengths=lengths)


def require_known(names: Sequence[str], placed: dict[str, Attachment | None]) -> None:
    """Raise a FitError unless enough markers have known positions to determine a body pose."""
    known = [n for n in names if placed[n] is not None]
    bodies = {p.body for p in placed.values() if p is not None}
    if len(known) < 6 or len(bodies) < 3:
        raise FitError(
            f"only {len(known)} of {len(names)} markers ({listed(names)}) have a name that "
            "a marker set knows; at least 6 on three segments are needed: give your own set with "
            "--marker-set FILE"
        )


def _overall_size(c: Calibrator) -> None:
    """Scale all lengths by the median ratio of distances between markers on one body or two."""
    which = c.known()
    points = c.points(which)
    model_points = points.path(c.human.standing()[None])[0]
    parent = points.model.body_parentid
    ratios = []
    for i, j in combinations(range(len(which)), 2):
        a, b = points.body[i], points.body[j]
        rest = np.linalg.norm(model_points[i] - model_points[j])
        near = a == b or parent[a] == b or parent[b] == a
        distance = np.linalg.norm(c.measured[:, which[i]] - c.measured[:, which[j]], axis=1)
        if near and rest >= 0.15 and np.isfinite(distance).any():
            ratios.append(np.nanmedian(distance) / rest)
    if ratios:
        c.start = c.start * float(np.clip(np.median(ratios), 0.45, 1.6))
