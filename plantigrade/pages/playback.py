"""Which part of a motion a moving picture plays, at which instants, and how its camera follows."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import cut_cycles
from plantigrade.motion.resample import resampled
from plantigrade.pages.scene import poses
from plantigrade.record import Record

RATE = 20.0  # frames per second of the motion; a browser draws what lies between them
MOST = 160  # frames in a picture
LONGEST = 10.0  # seconds of a motion that are shown where none are asked for
ALIKE = 0.08  # bodies lie within this of where they were a stride ago [m]: the stride is a loop
REST = 0.6  # how long the last frame stays before a motion that is no loop starts again [s]
MIN_PART = 0.01  # shortest part of a motion that is drawn [s]
ROAMS = 0.9  # a body that goes further than this is followed [m]


@dataclass(frozen=True, eq=False)
class Playback:
    """Instants of a motion, and where the camera is.

    Attributes:
        time: Instants on the clock of the motion [s]; the last one stays where it is no loop.
        seconds: How long they last, at true speed [s].
        centre: What the camera looks at in each of them, world [m].
        loop: How far a stride carries the body, world [m]; None where the motion is no loop.
    """

    time: Float[Array, " n"]
    seconds: float
    centre: Float[Array, "n 3"]
    loop: Float[Array, " 3"] | None


def playback(
    record: Record, *, start: float | None = None, stop: float | None = None, rate: float = RATE
) -> Playback:
    """Return what to play: one stride where strides repeat on plain ground, else all of it.

    Args:
        record: What happened.
        start: First instant, on the clock of the motion [s].
        stop: Last instant [s].
        rate: Frames per second.

    Raises:
        ParameterError: If the instants lie outside the motion or in the wrong order.
    """
    time = record.motion.time
    if not (np.isfinite(rate) and 1.0 <= rate <= 100.0):
        raise ParameterError(f"rate={rate} [Hz] must be from 1 to 100 frames per second")
    if start is None and stop is None and (stride := _stride(record)) is not None:
        begin, end, loop = stride
    else:
        begin, end = part_of(time, start, stop, longest=LONGEST)
        loop = None
    count = int(np.clip(round((end - begin) * rate), 2, MOST))
    instants = begin + (end - begin) * np.arange(count + 1) / count
    com = _com(record, instants)
    if loop is not None:
        centre = com.mean(axis=0) + np.outer(np.linspace(-0.5, 0.5, count + 1), loop)
        return Playback(instants, end - begin, centre, loop)
    centre = _follow(com)
    still = min(round(REST * count / (end - begin)), MOST)
    instants = np.concatenate([instants, np.full(still, instants[-1])])
    centre = np.concatenate([centre, np.tile(centre[-1], (still, 1))])
    return Playback(instants, (end - begin) * (len(instants) - 1) / count, centre, None)


def part_of(
    time: Float[Array, " n"],
    start: float | None,
    stop: float | None,
    *,
    longest: float = np.inf,
) -> tuple[float, float]:
    """Return the first and last instant of a part of a motion [s].

    Args:
        time: Times of the motion [s].
        start: First instant; the motion's if None.
        stop: Last instant; the motion's, or so long after the first, if None.
        longest: How long it is where ``stop`` is None [s].

    Raises:
        ParameterError: If the instants lie outside the motion or in the wrong order.
    """
    first, last = float(time[0]), float(time[-1])
    begin = first if start is None else start
    end = min(last, begin + longest) if stop is None else stop
    if not first - 1e-9 <= begin < end <= last + 1e-9:
        raise ParameterError(
            f"from {begin:g} s to {end:g} s is not within this motion, "
            f"which goes from {first:g} s to {last:g} s"
        )
    if (start, stop) != (None, None) and end - begin < MIN_PART:
        raise ParameterError(
            f"from {begin:g} s on, {end - begin:.2g} s are too short for a picture; at least "
            f"{MIN_PART:g} s are needed"
        )
    return begin, end


def _stride(record: Record) -> tuple[float, float, np.ndarray] | None:
    """Return the stride of the right foot that ends most as it began, and its way, if one does."""
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
    return (cycles[best].start, cycles[best].stop, loops[best]) if off[best] < ALIKE else None


def _com(record: Record, instants: np.ndarray) -> np.ndarray:
    return poses(record.human.model, resampled(record.motion, instants).qpos)[2]


def _follow(com: np.ndarray) -> np.ndarray:
    """Return the path of a camera: still where the body stays, else smoothly along with it."""
    level = np.ptp(com[:, :2], axis=0).max() < ROAMS
    rise = np.ptp(com[:, 2]) < ROAMS
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
