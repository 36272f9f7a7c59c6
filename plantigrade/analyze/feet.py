"""Paths of the feet, for gait measures and the timing of events."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.models.markers import landmarks_of
from plantigrade.motion import Motion
from plantigrade.spatial.conventions import facing

MAX_MARKER_DISTANCE = 0.08
"""Maximum distance of a marker from the landmark of its name [m]; others are ignored."""


@dataclass(frozen=True)
class FootPath:
    """Paths of feet and pelvis."""

    heel: Float[Array, "n_frames 2 3"]  #: Back of the heel, right then left [m]
    #: Forefoot, right then left: midway between second metatarsal head and hallux [m]
    toe: Float[Array, "n_frames 2 3"]
    pelvis: Float[Array, "n_frames 3"]  #: Middle of the pelvis [m]


def foot_path(human: Human, qpos: Float[Array, "n_frames nq"]) -> FootPath:
    """Return heel, toe and pelvis of a motion [m]."""
    marks = ("heel", "metatarsal_2_head", "hallux", "asis", "psis")
    heel, ball, hallux, asis, psis = _paths(human, qpos, *marks)
    return FootPath(heel, (ball + hallux) / 2, np.concatenate([asis, psis], axis=1).mean(axis=1))


def progress_in_stance(human: Human, motion: Motion) -> float:
    """Return the mean displacement of the pelvis relative to the stance foot in a stance [m].

    It is positive in the direction in which the pelvis faces and negative in backward walking, also
    on a treadmill; NaN without a complete stance.
    """
    stances = _stances(motion)
    if not stances:
        return float("nan")
    feet = foot_path(human, motion.qpos)
    side, start, stop = np.array(stances).T
    ahead = feet.pelvis[:, None] - feet.heel
    moved = (ahead[stop, side] - ahead[start, side])[:, :2]
    return float(np.mean((moved * facing(motion.qpos[(start + stop) // 2, 3:7])).sum(axis=1)))


def pitch_in_stance(human: Human, motion: Motion) -> float:
    """Return the median pitch of the feet in midstance relative to standing [rad].

    The result is NaN without a complete stance.
    """
    stances = _stances(motion)
    if not stances:
        return float("nan")

    def pitch(qpos: Float[Array, "n nq"]) -> Float[Array, "n 2"]:
        feet = foot_path(human, qpos)
        along = feet.toe - feet.heel
        return np.arctan2(along[..., 2], np.linalg.norm(along[..., :2], axis=-1))

    flat, seen = pitch(human.standing()[None])[0], pitch(motion.qpos)
    found = [
        np.median(np.abs(seen[start + (stop - start) // 3 : stop - (stop - start) // 3, k]
                         - flat[k]))
        for k, start, stop in stances
    ]  # fmt: skip
    return float(np.median(found))


def _stances(motion: Motion) -> list[tuple[int, int, int]]:
    """Return side, first and last frame of every stance from heel strike to toe-off."""
    found = []
    for k, side in enumerate(SIDES):
        events = [event for event in motion.events if event.side == side]
        for first, last in pairwise(events):
            if (first.kind, last.kind) == ("heel_strike", "toe_off"):
                start, stop = np.searchsorted(motion.time, (first.time, last.time))
                stop = min(stop, motion.n_frames - 1)
                if stop - start > 3:
                    found.append((k, int(start), int(stop)))
    return found


def event_points(fit: Fit) -> tuple[Float[Array, "n_frames 2 3"], Float[Array, "n_frames 2 3"]]:
    """Return paths of heel and second metatarsal head for the timing of gait events [m].

    Measured markers of these landmarks are preferred, because a fitted body smooths the impact of a
    landing; frames or feet without them use the landmarks of the body.
    """
    marks = ("heel", "metatarsal_2_head")
    paths = dict(zip(marks, _paths(fit.human, fit.qpos, *marks), strict=True))
    if fit.markers is not None:
        known = landmarks_of(fit.markers.names)
        for mark, path in paths.items():
            for k, side in enumerate(SIDES):
                if f"{mark}_{side}" in known:
                    column = fit.markers.index(known[f"{mark}_{side}"])
                    _use_marker(path[:, k], fit.markers.positions[:, column])
    return paths["heel"], paths["metatarsal_2_head"]


def _use_marker(path: np.ndarray, marker: np.ndarray) -> None:
    """Replace the path of a landmark by that of its marker, if they are close."""
    seen = np.isfinite(marker).all(axis=1)
    if (
        not seen.any()
        or np.median(np.linalg.norm((marker - path)[seen], axis=1)) > MAX_MARKER_DISTANCE
    ):
        return
    path += (marker - path)[seen].mean(axis=0)
    path[seen] = marker[seen]


def _paths(human: Human, qpos: np.ndarray, *marks: str) -> np.ndarray:
    """Return the paths of landmarks of both sides, (n_marks, n_frames, 2, 3) [m]."""
    table = attachments(human)
    places = [table[f"{mark}_{side}"] for mark in marks for side in SIDES]
    path = PointSet.of(human, places).path(qpos)
    return np.moveaxis(path.reshape(len(qpos), len(marks), len(SIDES), 3), 1, 0)
