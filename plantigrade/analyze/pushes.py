"""Pushes in a simulation: when they acted, and how strongly."""

from dataclasses import dataclass

import numpy as np

from plantigrade.motion.filters import runs
from plantigrade.record import Record

SIGNAL = "world.push"


@dataclass(frozen=True)
class PushInterval:
    """A time over which the body was pushed without a break."""

    start: float  #: Time of its first frame [s]
    stop: float  #: Time of its last frame [s]
    force: float  #: Largest force [N]


def push_intervals(record: Record) -> tuple[PushInterval, ...]:
    """Return the pushes that acted on the body, in order; none where the record knows of none.

    Pushes that overlap in time count as one, with the sum of their forces.
    """
    if SIGNAL not in record.signals:
        return ()
    size, time = np.linalg.norm(record.signals[SIGNAL], axis=1), record.motion.time
    return tuple(
        PushInterval(float(time[s.start]), float(time[s.stop - 1]), float(size[s].max()))
        for s in runs(size > 0.0)
    )
