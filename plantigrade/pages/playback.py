"""Selection of a part of a motion for an animation, its instants, and the path of its camera."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import cut_cycles
from plantigrade.motion.motion import resampled
from plantigrade.pages.scene import poses
from plantigrade.record import Record

FRAME_RATE = 20.0  # [Hz] of the motion; a browser interpolates between frames
MAX_FRAMES = 160  # of an animation
MAX_DURATION = 10.0  # [s] of a motion that are shown by default
LOOP_TOLERANCE = 0.08  # [m] between bodies and their position one stride before, for a loop
LOOP_PAUSE = 0.6  # [s] after the last frame of a motion without a loop
MIN_DURATION = 0.01  # [s] of a drawn part of a motion
MAX_STILL_DISTANCE = 0.9  # [m] that a body moves without being followed


@dataclass(frozen=True, eq=False)
class Playback:
    """Instants of an animation, and the path of its camera."""

    time: Float[Array, " n"]  #: Instants of the motion [s]; without a loop the last one is repeated
    seconds: float  #: Duration at real time [s]
    centre: Float[Array, "n 3"]  #: Point at which the camera looks at each instant, world [m]
    #: Displacement per stride, world [m]; None if the motion is not a loop
    loop: Float[Array, " 3"] | None


def playback(
    record: Record,
    *,
    start: float | None = None,
    stop: float | None = None,
    rate: float = FRAME_RATE,
) -> Playback:
    """Return one stride if strides repeat on plain ground, else the whole motion.

    Args:
        start: First instant [s].
        stop: Last instant [s].
    """
    time = record.motion.time
    if not (np.isfinite(rate) and 1.0 <= rate <= 100.0):
        raise ParameterError(f"rate={rate} [Hz] must be from 1 to 100 frames per second")
    if start is None and stop is None and (stride := _stride(record)) is not None:
        begin, end, loop = stride
    else:
        begin, end = part_of(time, start, stop, longest=MAX_DURATION)
        loop = None
    count = int(np.clip(round((end - begin) * rate), 2, MAX_FRAMES))
    instants = begin + (end - begin) * np.arange(count + 1) / count
    com = poses(record.human.model, resampled(record.motion, instants).qpos)[2]
    if loop is not None:
        centre = com.mean(axis=0) + np.outer(np.linspace(-0.5, 0.5, count + 1), loop)
        return Playback(instants, end - begin, centre, loop)
    centre = _follow(com)
    still = min(round(LOOP_PAUSE * count / (end - begin)), MAX_FRAMES)
    instants = np.concatenate([instants, np.full(still, instants[-1])])
    centre = np.concatenate([centre, np.tile(centre[-1], (still, 1))])
    return Playback(instants, (end - begin) * (len(instants) - 1) / count, centre, None)


def part_of(
    time: Float[Array, " n"], start: float | None, stop: float | None, *, longest: float = np.inf
) -> tuple[float, float]:
    """Return the first and last instant of a part of a motion [s].

    Args:
        time: Times of the motion [s].
        start: First instant; the motion's if None.
        stop: Last instant; by default that of the motion, or ``longest`` after the first.
        longest: Maximum duration if ``stop`` is None [s].
    """
    first, last = float(time[0]), float(time[-1])
    begin = first if start is None else start
    end = min(last, begin + longest) if stop is None else stop
    if not first - 1e-9 <= begin < end <= last + 1e-9:
        raise ParameterError(
            f"from {begin:g} s to {end:g} s is not within this motion, "
            f"which goes from {first:g} s to {last:g} s"
        )
    if (start, stop) != (None, None) and end - begin < MIN_DURATION:
        raise ParameterError(
            f"{end - begin:.2g} s from {begin:g} s on are too short for a picture; at least "
            f"{MIN_DURATION:g} s are needed"
        )
    return begin, end


def _stride(record: Record) -> tuple[float, float, np.ndarray] | None:
    """Return the most periodic stride of the right foot and its displacement, if there is one."""
    ground, motion = record.ground, record.motion
    if ground.steps or ground.bumps or ground.field or ground.seats:
        return None
    cycles = [
        c for c in cut_cycles(motion.events, side="r")
        if c.start >= motion.time[0] - 1e-6 and c.stop <= motion.time[-1] + 1e-6
    ]  # fmt: skip
    if not cycles:
        return None
    ends = resampled(motion, np.array([(c.start, c.stop) for c in cycles]).ravel()).qpos
    positions, _, com = poses(record.human.model, ends)
    loops = com[1::2] - com[::2]
    moved = positions[1::2, 1:] - positions[::2, 1:] - loops[:, None]
    off = np.linalg.norm(moved, axis=2).max(axis=1)
    best = int(np.argmin(off))
    return (
        (cycles[best].start, cycles[best].stop, loops[best]) if off[best] < LOOP_TOLERANCE else None
    )


def _follow(com: np.ndarray) -> np.ndarray:
    """Return the path of a camera, at rest or smoothly following the body."""
    level = np.ptp(com[:, :2], axis=0).max() < MAX_STILL_DISTANCE
    rise = np.ptp(com[:, 2]) < MAX_STILL_DISTANCE
    n = len(com)
    reach = max(1, n // 6)
    padded = np.pad(com, ((reach, reach), (0, 0)), mode="edge")
    smooth = np.stack([padded[i : i + 2 * reach + 1].mean(axis=0) for i in range(n)])
    middle = (com.min(axis=0) + com.max(axis=0)) / 2
    if level:
        smooth[:, :2] = middle[:2]
    if rise:
        smooth[:, 2] = middle[2]
    return smooth
