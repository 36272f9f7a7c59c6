"""Where the feet were: for the figures of a gait, and for the timing of its events."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion.recording import Markers

NEAR = 0.05
"""A marker that is usually this near a landmark of the foot stands for it [m]."""


@dataclass(frozen=True)
class FootPath:
    """Where the feet were."""

    heel: Float[Array, "n_frames 2 3"]  #: Back of the heel, right then left [m]
    #: Forefoot, right then left: midway between second metatarsal head and hallux [m]
    toe: Float[Array, "n_frames 2 3"]
    pelvis: Float[Array, "n_frames 3"]  #: Middle of the pelvis [m]


def foot_path(human: Human, qpos: Float[Array, "n_frames nq"]) -> FootPath:
    """Return heel, toe and pelvis of a motion [m]."""
    heel, ball, hallux = (_path(human, qpos, m) for m in ("heel", "metatarsal_2_head", "hallux"))
    pelvis = np.concatenate([_path(human, qpos, m) for m in ("asis", "psis")], axis=1)
    return FootPath(heel, (ball + hallux) / 2, pelvis.mean(axis=1))


def event_points(
    fit: Fit,
) -> tuple[Float[Array, "n_frames 2 3"], Float[Array, "n_frames 2 3"]]:
    """Return heel and second metatarsal head, by which gait events are timed [m].

    Where a marker lies on the landmark it is taken as measured, for a fitted body spreads the jerk
    of a landing over the whole foot; frames without it, and feet without such a marker, take the
    landmark of the body.
    """
    heel, ball = (_path(fit.human, fit.qpos, mark) for mark in ("heel", "metatarsal_2_head"))
    if fit.markers is not None:
        for path in (heel, ball):
            for k in range(len(SIDES)):
                _measure(path[:, k], fit.markers)
    return heel, ball


def _measure(path: np.ndarray, markers: Markers) -> None:
    """Put the marker nearest to a landmark in its place, where it was seen."""
    apart = np.linalg.norm(markers.positions - path[:, None], axis=-1)
    seen = np.isfinite(apart)
    usual = np.array(
        [
            np.median(d[s]) if s.mean() > 0.5 else np.inf
            for d, s in zip(apart.T, seen.T, strict=True)
        ]
    )
    best = int(np.argmin(usual)) if len(usual) else -1
    if best < 0 or usual[best] > NEAR:
        return
    marker, shown = markers.positions[:, best], seen[:, best]
    path += (marker - path)[shown].mean(axis=0)
    path[shown] = marker[shown]


def _path(human: Human, qpos: np.ndarray, mark: str) -> np.ndarray:
    """Return the path of a landmark of both sides, (n_frames, 2, 3) [m]."""
    table = attachments(human)
    places = [table[f"{mark}_{side}"] for side in SIDES]
    points = PointSet(human, [p.body for p in places], np.array([p.position for p in places]))
    return points.path(qpos)
