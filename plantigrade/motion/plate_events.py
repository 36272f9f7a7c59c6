"""Heel strike and toe off from force plates."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.motion.events import check_frames
from plantigrade.motion.filters import crossing, lowpass, runs
from plantigrade.motion.recording import ForcePlate, GaitEvent, rate_of

THRESHOLD = 20.0
"""Minimum force of a contact [N]."""
MIN_CONTACT = 0.08
"""Minimum duration of a contact [s]; gaps shorter than a quarter of it are closed."""
PLATE_MARGIN = 0.02
"""Maximum distance of a marker outside the plate, because markers are offset from the foot [m]."""
PULL_FACTOR = 5.0  #: Minimum ratio of the threshold to the negative force of the plate
MAX_THRESHOLD_FACTOR = 2.5  #: Maximum factor of the threshold, to 50 N, as usual on treadmills
MAX_EDGE_TIME = 0.08
"""Maximum time between the threshold and :data:`EDGE_LEVEL` [s]."""
EDGE_LEVEL = 0.25
"""Force at the upper end of an edge, as a fraction of the maximum on the plates. At touchdown and
lift-off it is reached within 10 to 60 ms; with a second foot or drift of the plate the force
changes slowly."""
TOE_TIP = 0.2  #: Length of the foot beyond the toe point, as a fraction of heel to toe point


@dataclass(frozen=True)
class PlateContact:
    """One contact with a force plate."""

    #: Time at which the force rises above the threshold [s]; None if loaded from the first sample
    start: float | None
    stop: float | None  #: Time at which it falls below it [s]; None if loaded at the last sample
    peak: float  #: Maximum vertical force [N]


def contact_events(
    time: Float[Array, " n_samples"],
    vertical_force: Float[Array, " n_samples"],
    threshold: float = THRESHOLD,
) -> tuple[PlateContact, ...]:
    """Return the contacts with a plate.

    The force is smoothed (50 Hz, no lag) so that noise around the threshold makes no contacts, and
    the offset of the unloaded plate is subtracted if it is below the threshold.

    Args:
        time: Time of each sample [s].
        vertical_force: Force of the ground on the body, upward positive [N].
        threshold: Minimum force of a contact [N].
    """
    if not threshold > 0:
        raise ParameterError(f"{threshold=} [N] must be positive")
    if len(time) < 4:
        return ()
    force = np.nan_to_num(np.asarray(vertical_force, dtype=float))
    rate = rate_of(time)
    if rate > 250:
        force = lowpass(time, force, cutoff=50.0)
    low = force[force < threshold]
    if len(low) > 0.05 * len(force):
        force = force - np.median(low)
    loaded = force > threshold
    for gap in runs(~loaded):
        if 0 < gap.start and gap.stop < len(loaded):
            if time[gap.stop] - time[gap.start] < MIN_CONTACT / 4:
                loaded[gap] = True
    contacts = []
    for on in runs(loaded):
        first, last = on.start, on.stop - 1
        if time[last] - time[first] < MIN_CONTACT and first > 0 and last < len(time) - 1:
            continue
        start = crossing(time, force, first - 1, threshold) if first > 0 else None
        stop = crossing(time, force, last, threshold) if last < len(time) - 1 else None
        contacts.append(PlateContact(start, stop, float(force[on].max())))
    return tuple(contacts)


def plate_events(
    plates: Sequence[ForcePlate],
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    spoiled: Sequence[tuple[str, float, float]] = (),
) -> tuple[GaitEvent, ...]:
    """Return the heel strikes and toe offs that were recorded by force plates.

    A contact (above :data:`THRESHOLD`) belongs to the foot nearest to its centre of pressure. It
    gives a heel strike only if the heel landed inside the plate, a toe off only if the toe tip left
    inside it, and neither while the other foot is on the same plate: a partial hit would be late or
    early. Nor is there an event if the force passes the threshold slowly (:data:`MAX_EDGE_TIME`): a
    foot that lands or leaves changes it fast, so something else was on the plate.

    Args:
        plates: Measured ground reactions. A plate without corners counts as unbounded; a foot named
            by the plate is trusted.
        time: Time of each marker frame [s].
        heel: Back of the heel, right then left, world [m].
        toe: Toe tip or metatarsal head, right then left, world [m].
        spoiled: Name of the plate, start and end [s] of contacts that are not to be used.
    """
    check_frames(time, heel, toe, None)
    contacts = [
        contact_events(plate.time, plate.force[:, 2], _above_noise(plate.force[:, 2]))
        for plate in plates
    ]
    peaks = [contact.peak for found in contacts for contact in found]
    upper = max(2 * THRESHOLD, EDGE_LEVEL * max(peaks, default=0.0))
    tip = toe + TOE_TIP * (toe - heel)
    events = []
    for plate, found in zip(plates, contacts, strict=True):
        for contact in found:
            first = -np.inf if contact.start is None else contact.start
            last = np.inf if contact.stop is None else contact.stop
            if any(name == plate.name and first < b and last > a for name, a, b in spoiled):
                continue
            side = plate.side or _foot_on(plate, contact, time, heel, toe)
            if side is None:
                continue
            own, other = SIDES.index(side), 1 - SIDES.index(side)
            ends = ((contact.start, heel, "heel_strike", 1), (contact.stop, tip, "toe_off", -1))
            for instant, point, kind, direction in ends:
                if instant is None or not time[0] <= instant <= time[-1]:
                    continue
                frame = int(np.argmin(np.abs(time - instant)))
                if plate.side is None and (
                    not _inside(plate.corners, point[frame, own], PLATE_MARGIN)
                    or _is_on(plate.corners, time, heel, toe, frame, other)
                ):
                    continue
                if _is_steep(plate, instant, direction, upper):
                    events.append(GaitEvent(instant, side, kind))
    return tuple(sorted(events, key=lambda event: (event.time, event.side)))


def _above_noise(force):
    """Return the threshold, raised if the record of the plate is too noisy for it [N].

    The ground cannot pull: a force below zero load is the error of the record near the edges
    (noise, or ringing of a low-pass filter).
    """
    low = force[np.isfinite(force) & (force < THRESHOLD)]
    if len(low) == 0:
        return THRESHOLD
    below = np.median(low) - np.percentile(low, 1)
    return float(np.clip(PULL_FACTOR * below, THRESHOLD, MAX_THRESHOLD_FACTOR * THRESHOLD))


def _is_on(corners, time, heel, toe, frame, side):
    """Return whether an end of a foot rests inside a plate."""
    return any(
        _inside(corners, p[frame, side], -1e-9) and _rests(time, p, frame, side)
        for p in (heel, toe)
    )


def _is_steep(plate, instant, direction, upper):
    """Return whether the force rises fast from threshold to `upper`, or falls (direction -1).

    Also True if the record ends too early to decide.
    """
    since = direction * (plate.time - instant)
    if since.max() < MAX_EDGE_TIME:
        return True
    inside = (since >= 0) & (since <= MAX_EDGE_TIME)
    return bool((plate.force[inside, 2] >= upper).any())


def _foot_on(plate, contact, time, heel, toe):
    """Return the side of the foot nearest to the centre of pressure under load."""
    start = plate.time[0] if contact.start is None else contact.start
    stop = plate.time[-1] if contact.stop is None else contact.stop
    instants = np.linspace(start, stop, 11)[2:-2]
    best, side = np.inf, None
    frames = [int(np.argmin(np.abs(time - t))) for t in instants]
    cop = plate.cop[[int(np.argmin(np.abs(plate.time - t))) for t in instants], :2]
    for k, name in enumerate(SIDES):
        a, along = heel[frames, k, :2], (toe - heel)[frames, k, :2]
        part = ((cop - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-9)
        apart = np.linalg.norm(cop - a - np.clip(part, 0.0, 1.0)[:, None] * along, axis=1)
        if np.isfinite(apart).any() and np.nanmedian(apart) < best:
            best, side = float(np.nanmedian(apart)), name
    return side if best < 0.3 else None


def _inside(corners, point, margin):
    """Return whether a point is over the plate, extended by the margin; True without corners."""
    if corners is None:
        return margin >= 0
    known = bool(np.isfinite(point[:2]).all())
    return known and bool(outside_of(corners, point[None, None]) <= margin)


def outside_of(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distance of points outside a plate, negative inside (n_frames, n_points) [m].

    Args:
        corners: Corners of the plate in order, around it either way (4, 3), world [m].
        points: Places, of which x and y count (n_frames, n_points, 2 or 3), world [m].
    """
    c = corners[:, :2]
    centre = c.mean(axis=0)
    far = np.full(points.shape[:2], -np.inf)
    for a, b in zip(c, np.roll(c, -1, axis=0), strict=True):
        edge = b - a
        length = np.linalg.norm(edge)
        if length < 1e-9:
            continue
        normal = np.array([edge[1], -edge[0]]) / length
        normal = -normal if normal @ (centre - a) > 0 else normal
        far = np.maximum(far, (points[..., :2] - a) @ normal)
    return far


def _rests(time, point, frame, side):
    a, b = max(frame - 2, 0), min(frame + 2, len(time) - 1)
    way = np.linalg.norm(point[b, side] - point[a, side])
    return bool(way < 0.3 * (time[b] - time[a]))
