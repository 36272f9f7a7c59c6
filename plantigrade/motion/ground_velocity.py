"""The velocity of the ground under the feet: zero overground, the belt's on a treadmill.

A foot in stance moves with the ground, so the velocity that the feet's points share most often is
the ground's.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import derivative, fill_gaps, interpolate, lowpass
from plantigrade.motion.recording import rate_of

MIN_BELT_SPEED = 0.15  #: Minimum speed of a treadmill [m/s]; slower ground counts as stationary
MAX_DRIFT = 0.5
"""Maximum speed of a person on a treadmill in the room, relative to the belt's speed. Feet that
roll in short stances, as in running overground, appear to share a velocity."""
MAX_GAP = 0.1  #: Maximum gap of a marker that is filled before event detection [s]
CLUSTER_RADIUS = 0.15  #: Radius of a cluster of velocities [m/s]
CUTOFF = 12.0
"""Cut-off frequency for the points of the foot [Hz]; lower for low frame rates."""


def ground_velocity(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
) -> Float[Array, "n_frames 3"]:
    """Return the velocity of the ground under the feet [m/s].

    It is the velocity that the feet's points share most often (the densest spot of their
    velocities). On a treadmill it is tracked through the recording, so that the belt may change its
    speed or be inclined. The ground of a person who moves through the room is at rest.

    Args:
        time: Time of each frame [s].
        heel: Back of the heel, right then left, world [m].
        toe: Toe tip or metatarsal head, right then left, world [m].
    """
    still = np.zeros((len(time), 3))
    if len(time) < 8:
        return still
    velocity = derivative(time, smooth_feet(time, np.stack([heel, toe], axis=2)))
    samples = velocity.reshape(len(time), -1, 3)
    seen = np.asarray(np.isfinite(samples).all(axis=2))
    common = _densest(samples[seen])
    if common is None or np.linalg.norm(common) < MIN_BELT_SPEED:
        return still
    if np.linalg.norm(_drift(time, heel, toe)) > MAX_DRIFT * np.linalg.norm(common):
        return still  # who gets on in the room is not carried back by a belt
    # Track the belt by the densest cluster within two seconds on either side.
    centres = np.arange(time[0], time[-1] + 0.5, 0.5)
    followed = []
    for centre in centres:
        first, last = np.searchsorted(time, (centre - 2.1, centre + 2.1)).tolist()
        around = slice(first, last)
        near = (np.abs(time[around, None] - centre) <= 2.0) & seen[around]
        spot = _densest(samples[around][near]) if near.sum() > 50 else None
        lost = spot is None or np.linalg.norm(spot - common) > 0.5 * np.linalg.norm(common)
        followed.append(common if lost else spot)
    return interpolate(time, centres, np.array(followed))


def smooth_feet(time, points):
    """Return the points with short gaps closed, low-pass filtered."""
    rate = rate_of(time)
    return lowpass(time, fill_gaps(time, points, longest=MAX_GAP), cutoff=min(CUTOFF, rate / 4))


def travel(time, velocity):
    """Return the displacement of the ground since the first frame."""
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)[:, None]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _drift(time, heel, toe):
    """Return the mean velocity of the feet in the room over a recording [m/s], by regression."""
    middle = ((heel + toe) / 2).mean(axis=1)
    seen = np.isfinite(middle).all(axis=1)
    if seen.sum() < 2:
        return np.zeros(2)
    return np.polyfit(time[seen] - time[seen].mean(), middle[seen, :2], 1)[0]


def _densest(samples):
    """Return the densest cluster of velocities, or None if there are none."""
    from scipy.spatial.distance import cdist

    if len(samples) == 0:
        return None
    samples = samples[:: max(1, len(samples) // 800)]
    spot = samples[np.argmax((cdist(samples, samples) < CLUSTER_RADIUS).sum(axis=1))]
    for _ in range(5):
        spot = samples[np.linalg.norm(samples - spot, axis=1) < CLUSTER_RADIUS].mean(axis=0)
    return spot
