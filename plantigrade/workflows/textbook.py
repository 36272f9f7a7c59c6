"""The textbook walk as a motion on a person, and as the marker recording a laboratory would make.

The angles are published means (:mod:`plantigrade.models.textbook_gait`); this module stands the
person on the ground with feet that do not slide, and puts on markers with the faults of real ones:
placed beside their landmarks, riding on skin, noisy, now and then hidden.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.motion import GaitEvent, Markers, Recording, Subject
from plantigrade.motion.filters import lowpass

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
PLACEMENT = 0.006  # of a marker beside its landmark, standard deviation [m]
NOISE = 0.0004  # of a camera system, standard deviation [m]
# How far skin carries markers over the cycle, amplitude [m]; after [Leardini2005]_.
SKIN = {"femur": 0.010, "tibia": 0.004, "humerus": 0.005}
HIDDEN = 0.25  # share of the markers with a gap; gaps last up to a tenth of a second


@dataclass(frozen=True)
class TextbookWalk:
    """The walk on a person."""

    human: Human  #: The person
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    qpos: Float[Array, "n_frames nq"]  #: Configurations
    events: tuple[GaitEvent, ...]  #: Heel strikes and toe offs as the book has them
    speed: float  #: Walking speed [m/s]


def textbook_walk(
    human: Human, *, speed: float = 1.25, rate: float = 100.0, cycles: int = 3
) -> TextbookWalk:
    """Return so many strides of the published mean walk, on a person who stands on the ground.

    The speed is in m/s, the frames per second in Hz.
    """
    d = human.dimensions
    walk = textbook_gait(speed, d.thigh + d.shank + d.ankle_height, rate=rate, cycles=cycles)
    names = tuple(walk.coordinates)
    qpos = human.from_coordinates(names, np.stack([walk.coordinates[n] for n in names], axis=1))
    for _ in range(2):
        depth = lowest(human, qpos)
        qpos[:, 2] -= lowpass(walk.time, depth, cutoff=6.0)
    stance = np.stack([walk.stance(side) for side in ("r", "l")], axis=1)
    qpos = plant_feet(human, qpos, stance, rate=rate)
    events = [
        GaitEvent(float(t), side, kind)
        for table, kind in ((walk.heel_strikes, "heel_strike"), (walk.toe_offs, "toe_off"))
        for side, times in table.items()
        for t in times
    ]
    events.sort(key=lambda e: (e.time, e.side))
    return TextbookWalk(human, walk.time, qpos, tuple(events), speed)


def recorded(walk: TextbookWalk, path: Path, *, seed: int = 0) -> Recording:
    """Return the walk as a laboratory would have recorded it, into the file ``path``.

    ``seed`` is that of placement, noise and gaps.
    """
    rng = np.random.default_rng(seed)
    human = walk.human
    table = attachments(human)
    places = [table[m] for m in MARKERS.values()]
    local = np.array([p.position for p in places])
    local = local + PLACEMENT * rng.normal(size=local.shape)
    points = PointSet(human, [p.body for p in places], local)
    x = points.path(walk.qpos)
    rotations = [state.rotations[points.body] for state in sweep(human, walk.qpos)]
    x += np.einsum("fmij,fmj->fmi", np.array(rotations), _skin(walk, places, rng))
    x += NOISE * rng.normal(size=x.shape)
    _hide(x, walk.time, rng)
    subject = Subject(height=human.height, mass=human.mass, sex=human.sex)
    return Recording(path, Markers(tuple(MARKERS), walk.time, x), subject=subject)


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
    for i in rng.permutation(x.shape[1])[: int(HIDDEN * x.shape[1])]:
        length = int(rng.integers(2, longest + 1))
        start = int(rng.integers(0, max(1, len(x) - length)))
        x[start : start + length, i] = np.nan
