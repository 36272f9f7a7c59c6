"""The textbook walk as the marker recording a laboratory would make of it.

Markers are put on the walk of :mod:`plantigrade.kinematics.textbook_walk` with the faults of real
ones: placed beside their landmarks, riding on skin, noisy, now and then hidden.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.force_program import FORWARD, OUTWARD, SHARE
from plantigrade.kinematics.planting import lead_pelvis
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.kinematics.textbook_walk import ADULT_SPREAD, TextbookWalk, textbook_walk
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Recording, Subject

__all__ = ["TextbookWalk", "adult_walk", "recorded", "textbook_walk"]

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
BALANCINGS = 1  # times that the pelvis is led to where the forces of the ground carry it
HARMONICS = 6  # of the stride, in the path of the pelvis
CUTOFF = 6.0  # of the motion whose forces are looked at [Hz]
HIDDEN = 0.25  # share of the markers with a gap; gaps last up to a tenth of a second


def adult_walk(human: Human, *, speed: float = 1.25) -> TextbookWalk:
    """Return three strides of the mean walk of adults, which forces on the feet could drive.

    Mean curves of angles say little of the path of the pelvis over the feet, a matter of
    millimetres. It is led to where the zero-moment point is the centre of pressure of people.
    """
    walk = textbook_walk(human, speed=speed, adult=True)
    spread = {name: float(np.deg2rad(value)) for name, value in ADULT_SPREAD.items()}
    for _ in range(BALANCINGS):
        led = lead_pelvis(human, walk.qpos, _off_balance(walk), spread)
        walk = replace(walk, qpos=led)
    return walk


def _off_balance(walk: TextbookWalk) -> np.ndarray:
    r"""Return how the pelvis is to be shifted for balance (n_frames, 2) [m].

    A shift :math:`\delta` of the body at height :math:`h` moves its zero-moment point by
    :math:`\delta - (h / g) \ddot\delta`; harmonic by harmonic of the middle stride that makes up
    for the distance from the centre of pressure.
    """
    human, time = walk.human, walk.time
    smooth = differentiate(human, time, walk.qpos, CUTOFF)
    body = centroid(human, smooth.qpos, smooth.qvel, smooth.qacc)
    assert body.zmp is not None
    error = body.zmp[:, :2] - _pressure(walk)
    strikes = [e.time for e in walk.events if (e.side, e.kind) == ("r", "heel_strike")]
    start, stop = strikes[1:3]
    at = np.linspace(start, stop, 128, endpoint=False)
    waves = np.fft.rfft([np.interp(at, time, e) for e in error.T])[:, : HARMONICS + 1] / len(at)
    rate = 2 * np.pi * np.arange(HARMONICS + 1) / (stop - start)
    waves = -waves / (1 + body.com[:, 2].mean() / GRAVITY * rate**2)
    waves[:, 1:] *= 2
    return (waves[:, :, None] * np.exp(1j * rate[:, None] * (time - start))).sum(axis=1).real.T


def _pressure(walk: TextbookWalk) -> np.ndarray:
    """Return the centre of pressure of people on these feet (n_frames, 2) [m].

    It rolls over each foot as people's does, and goes over to the next in double support.
    """
    human, time = walk.human, walk.time
    ankle = PointSet(human, ["foot_r", "foot_l"], np.zeros((2, 3))).path(walk.qpos)[..., :2]
    load, point = np.zeros((2, len(time))), np.zeros((2, len(time), 2))
    for k, side in enumerate(("r", "l")):
        strikes, offs = (
            np.array([e.time for e in walk.events if (e.side, e.kind) == (side, kind)])
            for kind in ("heel_strike", "toe_off")
        )
        period = strikes[1] - strikes[0]
        length = (offs[offs > strikes[0]][0] - strikes[0]) / period
        both = length - 0.5  # of the cycle, each double support
        phase = (time - strikes[0]) / period
        cycle = np.floor(phase)
        share = (phase - cycle) / length
        for c in np.unique(cycle):
            stance = (cycle == c) & (share <= 1)
            middle = stance & (share > 0.25) & (share < 0.6)
            if not middle.any():  # the edge of the walk shows less than a stance
                continue
            spot = np.median(ankle[middle, k], axis=0)
            out = -1.0 if side == "r" else 1.0
            ahead, aside = (np.interp(share[stance], SHARE, path) for path in (FORWARD, OUTWARD))
            own = human.dimensions.foot_length * np.stack([ahead, out * aside], axis=1)
            point[k, stance] = spot + own
            near = np.minimum(share[stance], 1 - share[stance]) * length / both
            near = np.clip(near, 0.0, 1.0)
            load[k, stance] = near**2 * (3 - 2 * near)
    total = load.sum(axis=0)
    known = total > 0.5
    pressure = (load[..., None] * point).sum(axis=0)[known] / total[known, None]
    return np.stack([np.interp(time, time[known], x) for x in pressure.T], axis=1)


def recorded(
    walk: TextbookWalk,
    path: Path,
    *,
    seed: int = 0,
    placement: float = PLACEMENT,
    torsion: float = 0.0,
    mirrored: bool = False,
) -> Recording:
    """Return the walk as a laboratory would have recorded it.

    Args:
        walk: The walk.
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
    beside = placement * rng.normal(size=local.shape)
    skin = _skin(walk, places, rng)
    if mirrored:
        beside, skin = _mirrored(beside[None], 0)[0], _mirrored(skin, _half_stride(walk))
    local = _turned(human, places, local + beside, torsion)
    points = PointSet(human, [p.body for p in places], local)
    x = points.path(walk.qpos)
    rotations = [state.rotations[points.body] for state in sweep(human, walk.qpos)]
    x += np.einsum("fmij,fmj->fmi", np.array(rotations), skin)
    x += NOISE * rng.normal(size=x.shape)
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
        c, s = np.cos(angle), np.sin(angle)
        x, y = (local[i] - centre)[:2]
        local[i, :2] = centre[:2] + [c * x - s * y, s * x + c * y]
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
    for i in rng.permutation(x.shape[1])[: int(HIDDEN * x.shape[1])]:
        length = int(rng.integers(2, longest + 1))
        start = int(rng.integers(0, max(1, len(x) - length)))
        x[start : start + length, i] = np.nan
