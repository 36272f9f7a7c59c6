"""Gait cycles: from heel strike to heel strike of one foot, normalised to 0 to 100 percent."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.motion.filters import resample
from plantigrade.motion.recording import GaitEvent

PERCENT = np.linspace(0.0, 100.0, 101)
"""Default percentages of the cycle at which curves are sampled."""
MAX_CYCLE = 3.0  #: Maximum stride time [s]; a longer interval contains standing
MIN_CYCLE = 0.4  #: Minimum stride time [s], shorter than in sprinting
SPLINE_REACH = 50
"""Distance at which a frame has no effect on a cubic spline [frames]; the effect decays by 2 - √3
per frame, to 1e-28 here."""


@dataclass(frozen=True)
class Cycle:
    """One stride of one foot: heel strike to its next heel strike."""

    side: str  #: ``"l"`` or ``"r"``
    start: float  #: First heel strike [s]
    stop: float  #: Next heel strike of the same foot [s]
    toe_off: float | None = None  #: Toe-off in between [s]; None if not observed
    #: Toe-off of the other foot [s], end of the first double support
    opposite_toe_off: float | None = None
    #: Heel strike of the other foot [s], start of the second double support
    opposite_heel_strike: float | None = None

    @property
    def duration(self) -> float:
        """Stride time [s]."""
        return self.stop - self.start

    def percent(self, instant: float) -> float:
        """Return the percentage of the cycle at an instant [s]."""
        return 100.0 * (instant - self.start) / self.duration


def cut_cycles(events: Iterable[GaitEvent], *, side: str | None = None) -> tuple[Cycle, ...]:
    """Return the cycles enclosed by gait events, of both feet or one, in order of start.

    A pair of heel strikes with no toe off of that foot between them is still a cycle (some files
    store heel strikes only), unless toe offs of that foot are known elsewhere: then a step was
    missed and the pair is left out, as are pairs with two toe offs.
    """
    events = sorted(events, key=lambda event: event.time)

    def times(of_side, kind):
        return np.array([e.time for e in events if e.side == of_side and e.kind == kind])

    cycles = []
    for own, other in (SIDES, SIDES[::-1]):
        if side not in (None, own):
            continue
        strikes, offs = times(own, "heel_strike"), times(own, "toe_off")
        for start, stop in zip(strikes[:-1].tolist(), strikes[1:].tolist(), strict=True):
            inside = offs[(offs > start) & (offs < stop)].tolist()
            if not MIN_CYCLE <= stop - start <= MAX_CYCLE:
                continue
            if len(inside) > 1 or (len(offs) and not inside):
                continue
            opposite = (_only(times(other, k), start, stop) for k in ("toe_off", "heel_strike"))
            cycles.append(Cycle(own, start, stop, inside[0] if inside else None, *opposite))
    return tuple(sorted(cycles, key=lambda cycle: cycle.start))


def normalise(
    time: Float[Array, " n_frames"],
    values: Float[Array, " n_frames *channels"],
    start: float,
    stop: float,
) -> Float[Array, " n_percent *channels"]:
    """Return a signal between two instants as a function of percent of the cycle (cubic splines).

    Args:
        time: Time of each frame [s].
        values: Signal, NaN in gaps; so is the result.
        start: Instant of 0 % [s].
        stop: Instant of 100 % [s].
    """
    return resample(time, values, _instants(start, stop))


def normalise_cycles(
    time: Float[Array, " n_frames"],
    values: Float[Array, " n_frames *channels"],
    cycles: Iterable[Cycle],
) -> Float[Array, "n_cycles n_percent *channels"]:
    """Return a signal over each cycle as a function of percent; NaN where it is unknown."""
    # One spline for all cycles, because one for each would take quadratic time.
    instants = [_instants(c.start, c.stop) for c in cycles]
    curves = resample(time, values, np.concatenate([*instants, np.empty(0)]))
    return curves.reshape((len(instants), len(PERCENT), *np.shape(values)[1:]))


def frames_near(time: Float[Array, " n_frames"], cycle: Cycle) -> slice:
    """Return the frames that the splines of a signal over a cycle depend on.

    They reach :data:`SPLINE_REACH` frames beyond both ends.
    """
    first, last = np.searchsorted(time, (cycle.start, cycle.stop))
    return slice(max(0, int(first) - SPLINE_REACH), int(last) + SPLINE_REACH)


def _instants(start: float, stop: float) -> Array:
    """Return the instants of every percent of a cycle [s]."""
    if not stop > start:
        raise ParameterError(f"a cycle must end after it starts: {start=} s, {stop=} s")
    return start + (stop - start) * PERCENT / 100.0


def _only(times, start, stop):
    inside = times[(times >= start) & (times < stop)]
    return float(inside[0]) if len(inside) == 1 else None
