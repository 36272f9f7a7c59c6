"""Loadings of force plates, each smoothed separately and resampled to the frames."""

from dataclasses import dataclass

import numpy as np

from plantigrade.motion.filters import interpolate, lowpass
from plantigrade.motion.plate_events import contact_events
from plantigrade.motion.recording import ForcePlate, rate_of


@dataclass
class PlateLoading:
    """One loading of one plate on the frames: wrench at the centre of pressure, and its owner."""

    plate: ForcePlate
    frames: np.ndarray
    force: np.ndarray
    cop: np.ndarray
    free: np.ndarray
    peak: float
    owner: np.ndarray  # side index per frame, -1 for neither
    problem: str = ""
    left_out: bool = False  # nothing of it is used


MIN_CONTACT_FORCE = 20.0  # [N] vertical, of a contact; usual for force plates


def loadings_of(
    plate: ForcePlate, frame_time: np.ndarray, cutoff: float | None
) -> list[PlateLoading]:
    """Return a plate's contacts, smoothed and on the frames."""
    found = []
    for contact in contact_events(plate.time, plate.force[:, 2], MIN_CONTACT_FORCE):
        start = plate.time[0] if contact.start is None else contact.start
        stop = plate.time[-1] if contact.stop is None else contact.stop
        inside = np.flatnonzero((plate.time >= start) & (plate.time <= stop))
        frames = np.flatnonzero((frame_time >= start - 1e-9) & (frame_time <= stop + 1e-9))
        if len(inside) < 2 or len(frames) == 0:
            continue
        force, cop = plate.force[inside], plate.cop[inside]
        known = np.isfinite(cop).all(axis=1) & np.isfinite(force).all(axis=1)
        if known.sum() < 2:
            continue
        inside, force, cop = inside[known], force[known], cop[known]
        time = plate.time[inside]
        about = cop.mean(axis=0)  # reference point near the foot, to limit round-off
        moment = np.cross(cop - about, force)
        moment[:, 2] += plate.free_moment[inside]
        load = (force[:, 2] * (cop[:, 2] - about[2]))[:, None]
        signal = np.hstack([force, moment, load])
        even = np.arange(inside[0], inside[-1] + 1)
        if len(even) != len(inside):  # samples without centre of pressure inside a contact
            signal = interpolate(plate.time[even], time, signal)
            time = plate.time[even]
        if cutoff is not None and len(time) >= 4 and cutoff < 0.4 * rate_of(time):
            signal = lowpass(time, signal, cutoff=cutoff)
        signal = interpolate(frame_time[frames], time, signal)
        force, moment, load = signal[:, :3], signal[:, 3:6], signal[:, 6]
        up = force[:, 2] > 0.05 * MIN_CONTACT_FORCE
        if not up.any():
            continue
        frames, force, moment, load = frames[up], force[up], moment[up], load[up]
        cop, free = centres(force, moment, load / force[:, 2])
        found.append(
            PlateLoading(
                plate, frames, force, cop + about, free, contact.peak, np.full(len(frames), -1)
            )
        )
    return found


def centres(force, moment, height) -> tuple[np.ndarray, np.ndarray]:
    """Return centre of pressure at ``height`` and free moment of wrenches about the origin."""
    x = (height * force[:, 0] - moment[:, 1]) / force[:, 2]
    y = (height * force[:, 1] + moment[:, 0]) / force[:, 2]
    free = moment[:, 2] - (x * force[:, 1] - y * force[:, 0])
    return np.stack([x, y, height], axis=1), free


def plate_level(loadings: list[PlateLoading]) -> float:
    """Return the height of the plates [m]; NaN without any."""
    heights = [np.median(loading.cop[:, 2]) for loading in loadings]
    return float(np.median(heights)) if heights else float("nan")


def seen_frames(plates, frame_time) -> np.ndarray:
    """Return the frames that every plate covers."""
    seen = np.ones(len(frame_time), dtype=bool)
    for plate in plates:
        if len(plate.time):
            step = 1.0 / rate_of(plate.time) if len(plate.time) > 1 else 0.0
            seen &= frame_time >= plate.time[0] - step
            seen &= frame_time <= plate.time[-1] + step
    return seen
