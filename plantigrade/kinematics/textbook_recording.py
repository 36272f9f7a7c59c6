"""The textbook walk as the marker recording a laboratory would make of it.

Markers are put on the walk of :mod:`plantigrade.kinematics.textbook_walk` with the faults of real
ones: off their landmarks, moving with the skin, noisy, hidden at times.
"""

from pathlib import Path

import numpy as np

from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.kinematics.textbook_walk import TextbookWalk, textbook_walk
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Recording, Subject
from plantigrade.spatial.conventions import about_vertical

__all__ = ["TextbookWalk", "recorded", "textbook_walk"]

# Plug-in Gait with medial knees and ankles and a few foot markers: marker → landmark.
MARKERS = {
    "C7": "c7", "T10": "t10", "CLAV": "suprasternale", "STRN": "xiphoid", "SACR": "sacrum",
    **{
        f"{side.upper()}{name}": f"{mark}_{side}"
        for side in ("l", "r")
        for name, mark in {
            "FHD": "head_front", "BHD": "head_back", "SHO": "acromion", "UPA": "upper_arm",
            "ELB": "elbow_lateral", "FRM": "forearm", "WRA": "wrist_radial", "WRB": "wrist_ulnar",
            "FIN": "hand", "ASI": "asis", "PSI": "psis", "THI": "thigh", "KNE": "knee_lateral",
            "KNM": "knee_medial", "TIB": "shank", "ANK": "ankle_lateral", "MED": "ankle_medial",
            "HEE": "heel", "TOE": "metatarsal_2_head", "D5M": "metatarsal_5_head",
            "HLX": "hallux",
        }.items()
    },
}  # fmt: skip
PLACEMENT_SD = 0.006  # [m] standard deviation of a marker's distance from its landmark
CAMERA_NOISE_SD = 0.0004  # of a camera system, standard deviation [m]
# How far skin carries markers over the cycle, amplitude [m]; after [Leardini2005]_.
SKIN = {"femur": 0.010, "tibia": 0.004, "humerus": 0.005}
GAP_SHARE = 0.25  # share of the markers with a gap; gaps last up to a tenth of a second


def recorded(
    walk: TextbookWalk,
    path: Path,
    *,
    seed: int = 0,
    placement: float = PLACEMENT_SD,
    torsion: float = 0.0,
    mirrored: bool = False,
) -> Recording:
    """Return the walk as a laboratory would have recorded it.

    Args:
        path: File of the recording.
        seed: Seed of placement, noise and gaps.
        placement: Distance of a marker from its landmark, standard deviation along each axis [m].
        torsion: Outward torsion of the shanks, which the body has not: markers of the feet are
            turned by so much [rad].
        mirrored: Whether markers of the left are placed, and ride on skin, as those of the right.
    """
    rng = np.random.default_rng(seed)
    human = walk.human
    table = attachments(human)
    places = [table[m] for m in MARKERS.values()]
    local = np.array([p.position for p in places])
    offset = placement * rng.normal(size=local.shape)
    skin = _skin(walk, places, rng)
    if mirrored:
        offset, skin = _mirrored(offset[None], 0)[0], _mirrored(skin, _half_stride(walk))
    local = _turned(human, places, local + offset, torsion)
    points = PointSet(human, [p.body for p in places], local)
    x = points.path(walk.qpos)
    rotations = [state.rotations[points.body] for state in sweep(human, walk.qpos)]
    x += np.einsum("fmij,fmj->fmi", np.array(rotations), skin)
    x += CAMERA_NOISE_SD * rng.normal(size=x.shape)
    _hide(x, walk.time, rng)
    subject = Subject(height=human.height, mass=human.mass, sex=human.sex)
    return Recording(path, Markers(tuple(MARKERS), walk.time, x), subject=subject)


def _half_stride(walk: TextbookWalk) -> int:
    """Return half a stride in frames."""
    strikes = [e.time for e in walk.events if e.kind == "heel_strike"]
    return round((strikes[1] - strikes[0]) / (walk.time[1] - walk.time[0]))


def _mirrored(values: np.ndarray, later: int) -> np.ndarray:
    """Return vectors of markers (n_frames, n_markers, 3) with the left those of the right.

    They are mirrored, and ``later`` by some frames.
    """
    values, names = values.copy(), list(MARKERS)
    for i, name in enumerate(names):
        if name.startswith("L"):
            right = values[:, names.index(f"R{name[1:]}")]
            values[:, i] = np.roll(right, later, axis=0) * [1.0, -1.0, 1.0]
    return values


def _turned(human: Human, places, local: np.ndarray, torsion: float) -> np.ndarray:
    """Return marker places with the feet turned outward about the vertical of the ankle."""
    origins = human.skeleton.origins
    local = local.copy()
    for i, place in enumerate(places):
        side = place.body[-1]
        if not place.body.startswith(("foot_", "toes_")):
            continue
        angle = torsion if side == "l" else -torsion
        centre = origins[f"foot_{side}"] - origins[place.body]
        local[i] = centre + about_vertical(angle) @ (local[i] - centre)
    return local


def _skin(walk: TextbookWalk, places, rng) -> np.ndarray:
    """Return how far skin has carried each marker, in its body's frame (n_frames, n_markers, 3)."""
    duration = walk.time[-1] - walk.time[0]
    n_cycles = max(1.0, round(duration * walk.speed / 1.3))
    phase = 2 * np.pi * n_cycles * (walk.time - walk.time[0]) / duration
    moved = np.zeros((len(walk.time), len(places), 3))
    for i, place in enumerate(places):
        size = SKIN.get(place.body[:-2], 0.0)
        if size:
            shift, direction = rng.uniform(0, 2 * np.pi), rng.normal(size=3)
            direction /= np.linalg.norm(direction)
            wave = np.sin(phase + shift) + 0.4 * np.sin(2 * phase + 2 * shift)
            moved[:, i] = size * wave[:, None] * direction
    return moved


def _hide(x: np.ndarray, time: np.ndarray, rng) -> None:
    """Hide some markers for a moment, never two at once on purpose."""
    frame = time[1] - time[0]
    longest = max(2, round(0.1 / frame))
    for i in rng.permutation(x.shape[1])[: int(GAP_SHARE * x.shape[1])]:
        length = int(rng.integers(2, longest + 1))
        start = int(rng.integers(0, max(1, len(x) - length)))
        x[start : start + length, i] = np.nan
