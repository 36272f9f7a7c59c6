"""A standing body laid on markers: where a fit starts, before any joint is known."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.spatial.conventions import rotation_matrix


def standing_poses(
    human: Human,
    places: Sequence[Attachment | None],
    measured: Float[Array, "n_frames n_markers 3"],
    points: PointSet | None = None,
) -> Float[Array, "n_frames nq"]:
    """Return the standing body moved to each frame's pelvis and trunk markers, upright.

    Only position and heading are free, so that a few markers cannot tip the body over.

    Args:
        places: Where the markers sit; those without a place are not used.
        measured: Their positions [m].
        points: The markers that have a place, on other segment lengths than the person's.
    """
    which = [i for i, p in enumerate(places) if p is not None]
    known = [p for p in places if p is not None]
    if points is None:
        points = PointSet.of(human, known)
    standing = human.standing()
    model_points = points.path(standing[None])[0]
    trunk = {"pelvis", "torso", "abdomen", "lower_thorax", "thorax"}
    on_trunk = np.array([p.body in trunk for p in known])
    qpos = np.tile(standing, (len(measured), 1))
    for f in range(len(measured)):
        target = measured[f, which]
        seen = np.isfinite(target[:, 0])
        use = seen & on_trunk if (seen & on_trunk).sum() >= 4 else seen
        if use.sum() < 3:
            continue
        a, b = model_points[use], target[use]
        da, db = a - a.mean(0), b - b.mean(0)
        yaw = np.arctan2(
            (da[:, 0] * db[:, 1] - da[:, 1] * db[:, 0]).sum(), (da[:, :2] * db[:, :2]).sum()
        )
        qpos[f, 3:7] = [np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
        heading = rotation_matrix(qpos[f, 3:7])
        qpos[f, :3] = b.mean(0) + heading @ (standing[:3] - a.mean(0))
    return qpos
