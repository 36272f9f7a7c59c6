"""When the regions of the feet rest on the ground.

A foot is in contact region by region: heel, ball (metatarsal heads) and toes come down and leave
one after another. A region rests while its lowest point is near the ground and nearly still.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.sole_paths import SolePaths
from plantigrade.motion.filters import lowpass, runs
from plantigrade.motion.recording import rate_of

MAX_REST_HEIGHT = 0.035  # [m] maximum height above the ground of a resting region
MAX_REST_SPEED = 0.35  # [m/s] maximum speed within a rest …
STILL_SPEED = 0.22  # [m/s] … and maximum of its lowest speed
MIN_REST_TIME = 0.06  # [s] minimum duration of a rest
SPEED_CUTOFF = 10.0  # [Hz] low-pass of points before differentiation


@dataclass(frozen=True)
class ContactFrames:
    """Frames ``start`` to before ``stop`` in which a region of a foot rests on the ground."""

    side: str
    region: str
    start: int
    stop: int

    def interval(self, time: Float[Array, " n_frames"]) -> ContactInterval:
        """Return the interval from the first of the frames to the last."""
        first, last = float(time[self.start]), float(time[self.stop - 1])
        return ContactInterval(self.side, self.region, first, last)


def find_rests(
    contact: SolePaths,
    rate: float,
    *,
    way: Float[Array, "n_frames 3"] | None = None,
    stance: Bool[Array, "n_frames 2"] | None = None,
) -> list[ContactFrames]:
    """Return when each region of each foot rests on the ground.

    Args:
        rate: Frames per second [Hz].
        way: Path of the ground itself (a treadmill's belt) [m].
        stance: Where the foot stands at all (right, left), if that is known.
    """
    n = len(contact.position)
    position = contact.position - (0.0 if way is None else way[:, None])
    time = np.arange(n) / rate
    rests = []
    for s, side in enumerate(SIDES):
        for region in ("heel", "ball", "toes"):
            index = contact.of(side, region)
            if not len(index):
                continue
            speed = point_speed(time, position[:, index].mean(axis=1))
            near = position[:, index, 2].min(axis=1) < MAX_REST_HEIGHT
            calm = _hysteresis(speed, STILL_SPEED, MAX_REST_SPEED) & near
            if stance is not None:
                calm &= stance[:, s]
            for run in runs(calm):
                if run.stop - run.start >= max(2, MIN_REST_TIME * rate):
                    rests.append(ContactFrames(side, region, run.start, run.stop))
    return rests


def point_speed(time: Float[Array, " n"], path: Float[Array, "n 3"]) -> Float[Array, " n"]:
    """Return the speed of a point along its smoothed path [m/s]."""
    if len(time) < 3:
        return np.zeros(len(time))
    if len(time) > 15 and rate_of(time) > 2.5 * SPEED_CUTOFF:
        path = lowpass(time, path, cutoff=SPEED_CUTOFF)
    return np.linalg.norm(np.gradient(path, time, axis=0), axis=-1)


def _hysteresis(value: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return where the value is below ``high`` in a run that is somewhere below ``low``."""
    below = value < high
    for run in runs(below):
        if value[run].min() >= low:
            below[run] = False
    return below


def contact_metrics(
    contact: SolePaths,
    rests: list[ContactFrames],
    way: Float[Array, "n_frames 3"] | None = None,
    suffix: str = "",
) -> dict[str, float]:
    """Return how far resting feet drift and how deep they sink, as figures [mm]."""
    drift = 1e3 * drift_of(contact, rests, way) if rests else np.zeros(1)
    depth = 1e3 * contact.penetration
    return {
        f"foot_drift_mean_mm{suffix}": float(drift.mean()),
        f"foot_drift_max_mm{suffix}": float(drift.max()),
        f"penetration_mean_mm{suffix}": float(depth.mean()),
        f"penetration_max_mm{suffix}": float(depth.max()),
    }


def drift_of(
    contact: SolePaths, rests: list[ContactFrames], way: Float[Array, "n_frames 3"] | None = None
) -> Float[Array, " n_rests"]:
    """Return how far each resting region strays from its mean place on the ground [m]."""
    position = contact.position - (0.0 if way is None else way[:, None])
    result = []
    for rest in rests:
        index = contact.of(rest.side, rest.region)
        centre = position[rest.start : rest.stop, index, :2].mean(axis=1)
        result.append(float(np.linalg.norm(centre - centre.mean(axis=0), axis=1).max()))
    return np.array(result)
