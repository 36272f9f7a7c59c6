r"""The offset between the clocks of force plates and markers, estimated from dynamics.

The net ground reaction equals the force required by the centre of mass, :math:`m (a - g)`. While
the plates carry the whole person, the shift with the best correlation of both signals is the offset
of the clocks. Soft tissue delays only the vertical component, by up to 13 ms; an offset of the
clocks affects the vertical and the horizontal component.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.motion.filters import lowpass, runs, vertex
from plantigrade.motion.recording import ForcePlate, rate_of
from plantigrade.notes import Info

MAX_OFFSET = 0.04  # Largest offset of the search [s]; gait events reveal larger ones
SEARCH_STEP = 0.001  # Step of the search [s]; a parabola interpolates the maximum
MIN_CORRECTION = 0.004  # Smallest offset that is corrected [s]: twice the error of the estimate
MAX_DISAGREEMENT = 0.006
"""Largest difference between the offsets of the vertical and the horizontal force [s]."""
MIN_CARRIED_TIME = 0.5  # [s] shortest total time in which plates carry the whole person
MAX_CLOCK_RATE = 0.015
"""Largest difference of the rates of both clocks [1]. Settled on one treadmill walk, with 0.005;
four recordings of three others have up to 0.001, and with an error of 3 % 0.026 to 0.032."""
MIN_RATE_TIME = 1.2  # [s] shortest span for the rate; spans below 1 s are off by up to 0.06
MAX_RATE_ERROR = 0.06  # [1] range of the search for the rate
RATE_STEP = 0.005  # [1] step of that search
MAX_RATE_OFFSET = 0.12  # [s] largest offset in this search: 5 % of the time before the middle
MIN_SAMPLES = 12  # [1] fewest samples of a plate that can be filtered
MIN_CORRELATION = 0.9
"""Smallest correlation of force and motion at the best shift; below it there is no estimate."""


def clock_offset(
    plates: Sequence[ForcePlate],
    time: Float[Array, " n_frames"],
    needed: Float[Array, "n_frames 3"],
    carried: Bool[Array, " n_frames"],
    cutoff: float | None,
) -> float | None:
    """Return the delay of the clock of plates relative to that of the motion [s].

    Args:
        plates: The plates, all on one clock.
        time: Time of each frame of the motion [s].
        needed: Force required by the motion, filtered [N].
        carried: Frames in which the plates carry the whole person.
        cutoff: Low-pass of the motion [Hz].

    Returns:
        The offset, positive for delayed plates; None if it cannot be estimated.
    """
    if len(time) < 2 or not plates or min(len(plate.time) for plate in plates) < MIN_SAMPLES:
        return None
    clock, net = _net_force(plates, cutoff)
    inner = np.zeros(len(time), dtype=bool)
    edge = int(np.ceil((MAX_OFFSET + 0.03) * rate_of(time)))
    for run in runs(carried & (time >= clock[0]) & (time <= clock[-1])):
        inner[run.start + edge : max(run.stop - edge, run.start + edge)] = True
    if inner.sum() < MIN_CARRIED_TIME * rate_of(time):
        return None
    level = needed[inner, :2] - needed[inner, :2].mean(axis=0)
    way = np.linalg.eigh(level.T @ level)[1][:, -1]  # direction of braking and propulsion
    shifts = np.arange(-MAX_OFFSET, MAX_OFFSET + SEARCH_STEP / 2, SEARCH_STEP)
    found = []
    for axis in (np.array([0.0, 0.0, 1.0]), np.array([*way, 0.0])):
        required = needed[inner] @ axis
        force = [np.interp(time[inner] + s, clock, net @ axis) for s in shifts]
        correlation = np.array([np.corrcoef(required, f)[0, 1] for f in force])
        k = int(np.nanargmax(correlation)) if np.isfinite(correlation).any() else 0
        if not 0 < k < len(shifts) - 1 or correlation[k] < MIN_CORRELATION:
            return None
        before, best, after = correlation[k - 1 : k + 2]
        found.append((shifts[k] + vertex(correlation, k) * SEARCH_STEP, 2 * best - before - after))
    offsets, sharp = np.array(found).T
    if abs(offsets[0] - offsets[1]) > MAX_DISAGREEMENT:
        return None
    return float(sharp @ offsets / sharp.sum())


def clock_rate(
    plates: Sequence[ForcePlate],
    time: Float[Array, " n_frames"],
    needed: Float[Array, " n_frames"],
    carried: Bool[Array, " n_frames"],
    cutoff: float | None,
) -> float | None:
    """Return by which share the clock of plates runs slower than that of the motion [1].

    Args:
        plates: The plates, all on one clock.
        time: Time of each frame of the motion [s].
        needed: Vertical force required by the motion, filtered [N].
        carried: Frames in which the plates carry the whole person.
        cutoff: Low-pass of the motion [Hz].
    """
    at = time[carried]
    if (
        not plates
        or min(len(plate.time) for plate in plates) < MIN_SAMPLES
        or not len(at)
        or np.ptp(at) < MIN_RATE_TIME
    ):
        return None
    clock, net = _net_force(plates, cutoff)
    middle, required = at.mean(), needed[carried]
    rates = np.arange(-MAX_RATE_ERROR, MAX_RATE_ERROR + RATE_STEP / 2, RATE_STEP)
    shifts = np.arange(-MAX_RATE_OFFSET, MAX_RATE_OFFSET + SEARCH_STEP, 4 * SEARCH_STEP)
    best = np.empty(len(rates))
    for k, rate in enumerate(rates):
        clocks = middle + (at - middle) * (1 + rate)
        force = [np.interp(clocks + s, clock, net[:, 2]) for s in shifts]
        best[k] = max(np.corrcoef(required, f)[0, 1] for f in force)
    k = int(np.argmax(best))
    if not 0 < k < len(rates) - 1 or not best[k] > MIN_CORRELATION:
        return None
    return float(rates[k] + vertex(best, k) * RATE_STEP)


def _net_force(
    plates: Sequence[ForcePlate], cutoff: float | None
) -> tuple[Float[Array, " n_samples"], Float[Array, "n_samples 3"]]:
    """Return the clock of the plates and their net force, filtered like the motion."""
    clock = plates[0].time
    net = np.sum(
        [
            [np.interp(clock, p.time, np.nan_to_num(axis), left=0, right=0) for axis in p.force.T]
            for p in plates
        ],
        axis=0,
    ).T
    if cutoff is not None and cutoff < 0.4 * rate_of(clock):
        net = lowpass(clock, net, cutoff=cutoff)
    return clock, net


def on_one_clock(plates: Sequence[ForcePlate], offset: float) -> tuple[ForcePlate, ...]:
    """Return plates whose clock was late by ``offset`` [s] on the clock of the motion."""
    return tuple(replace(plate, time=plate.time - offset) for plate in plates)


def clock_note(offset: float) -> str:
    """Return the note that the plates' clock was corrected."""
    return Info(
        f"the clock of the force plates is {abs(1e3 * offset):.0f} ms "
        f"{'late' if offset > 0 else 'early'} against that of the motion: measured forces and what "
        "the centre of mass needs fit best with this shift; it was corrected."
    )
