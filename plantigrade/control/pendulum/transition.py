r"""The transition from one walk to another, at a like instant of the stride, blended.

Two walks of one person are brought to one clock: strikes and lifts of the feet fall on each other,
and times in between are stretched evenly. The old walk changes into the new one in postures, feet,
speed and rhythm, while feet land and leave as they do in both. With a part
:math:`p` of the new walk, a second of its clock takes

.. math:: dt = (1 - p)\, dt_{old} + p\, dt_{new},

so that at :math:`p = 0` the old walk goes on as it was.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant, derivative_order
from plantigrade.control.gait.reference import STEP, ReferenceTables
from plantigrade.control.gait.schedule import StanceSchedule
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.errors import ParameterError
from plantigrade.motion.blends import cubic_rise

N_INSTANTS = 50  # of a stride, by which both walks are laid over each other


class PhaseMap:
    """Maps instants of the stride of one walk to like instants of another.

    Args:
        lifts: Whether feet also lift at like instants, not only strike; in a run, which has no
            double support, they do not.

    Attributes:
        period: Period of the new walk [s].
        mean_rate: Mean seconds of the old walk in one of the new.

    Raises:
        ParameterError: If one of them is not repeated, or a foot does not stand once in a stride.
    """

    def __init__(self, new: StanceSchedule, old: StanceSchedule, *, lifts: bool = True):
        ours, theirs = instants(new), instants(old)
        self._begin = float(ours[0])
        self.period, self._period = float(new.period or 0.0), float(old.period or 0.0)
        self.mean_rate = self._period / self.period
        order = [np.argsort(x) for x in (ours, theirs)]
        near = min(float(np.diff(np.sort(x)).min()) for x in (ours, theirs))
        if not lifts or (order[0] != order[1]).any() or near < STEP:
            ours, theirs = ours[:2], theirs[:2]
        rounds = np.arange(-2, 4)[:, None]
        self._new = (np.sort(ours) + rounds * self.period).ravel()
        self._old = (np.sort(theirs) + rounds * self._period).ravel()
        self._rate_between = np.diff(self._old) / np.diff(self._new)

    def to_old(self, phase: float) -> float:
        """Return the instant of the old walk that is like one of the new [s]."""
        cycle = np.floor(phase / self.period)
        own = np.interp(phase - cycle * self.period, self._new, self._old)
        return float(own + cycle * self._period)

    def to_new(self, phase: float) -> float:
        """Return the instant of the new walk that is like one of the old [s]."""
        cycle = np.floor(phase / self._period)
        own = np.interp(phase - cycle * self._period, self._old, self._new)
        return float(own + cycle * self.period)

    def share(self, phase: float) -> float:
        """Return what part of the new stride is over, from the right foot's strike on."""
        return (phase - self._begin) / self.period % 1.0

    def rate(self, phase: float) -> float:
        """Return seconds of the old walk in one of the new, at a phase of the new."""
        i = int(np.searchsorted(self._new, phase % self.period, side="right")) - 1
        return float(self._rate_between[i])


def instants(schedule: StanceSchedule) -> Float[Array, " 4"]:
    """Return when feet strike, right and left, and lift, from the first right strike on [s]."""
    period = schedule.period
    own = {s: [x for x in schedule.stances if x.side == s and np.isfinite(x.stop)] for s in SIDES}
    if period is None or schedule.per_period != len(SIDES) or not all(own.values()):
        raise ParameterError(
            "only walks in which every foot stands once in a stride that is repeated can be "
            "changed into each other"
        )
    begin = own["r"][0].start - schedule.first
    strikes = [own[side][0].start - schedule.first for side in SIDES]
    lifts = [own[side][0].stop - schedule.first for side in SIDES]
    after = (np.array([*strikes, *lifts]) - begin) % period
    return begin % period + after


class Transition:
    """One walk that turns into another.

    Attributes:
        phases: From the new walk to the old one.
        speed: Speed of the old walk, on the clock of the new one [m/s].
        part: Weight of the new one, from 0 to 1.
        duration: Duration of the transition [s].
    """

    def __init__(
        self, new: ReferenceTables, old: ReferenceTables, settings: SpeedSettings | None = None
    ):
        if new.layout != old.layout:
            raise ParameterError("only walks of the same joints and feet can be compared")
        self.phases, self._old = PhaseMap(new.schedule, old.schedule), old
        self.part, self._rate = 0.0, 0.0
        self.speed = float(old.advance[0]) / new.duration
        self._order = derivative_order(new.layout)
        self._along = new.translation[:, 0] != 0.0
        own = float(new.advance[0]) / new.duration
        change = own - float(old.advance[0]) / old.duration
        self.duration = (settings or SpeedSettings()).transition_time(change)
        phases = np.arange(N_INSTANTS) / N_INSTANTS * new.duration
        self._off = float(
            np.mean(
                [
                    new.at(p).q[0] - old.at(self.phases.to_old(p)).q[0] - (own - self.speed) * p
                    for p in phases.tolist()
                ]
            )
        )

    def advance(self, since: float) -> bool:
        """Advance to a time since the beginning [s]; return whether it goes on."""
        u = min(since / self.duration, 1.0)
        self.part = float(cubic_rise(u))
        self._rate = 6.0 * u * (1.0 - u) / self.duration
        return u < 1.0

    @property
    def mean_cadence(self) -> float:
        """Strides in a time, by those of the new walk."""
        return 1.0 / ((1.0 - self.part) * self.phases.mean_rate + self.part)

    def cadence(self, phase: float) -> float:
        """Return the strides in a time, by those of the new walk, at a phase of it."""
        return 1.0 / ((1.0 - self.part) * self.phases.rate(phase) + self.part)

    def at(self, new: Instant, phase: float, cadence: float) -> Instant:
        """Return the walk between both, for a cadence that it will be multiplied by.

        Args:
            phase: That [s].
            cadence: Factor by which rates will be multiplied, and changes of rates twice.
        """
        old, rate = self._old.at(self.phases.to_old(phase)), self.phases.rate(phase)
        faster = self.cadence(phase) / cadence
        q, before = np.array(new.q), old.q
        if before[3:7] @ q[3:7] < 0.0:
            before[3:7] *= -1.0
        for walk, times in ((new, faster), (old, faster * rate)):
            off = walk.cop[:2] - walk.com[:2]
            walk.cop[:2] = walk.com[:2] + times**2 * off
            walk.row[:] *= times**self._order
        old.row[self._along] += self._off
        row = (1.0 - self.part) * old.row + self.part * new.row
        found = Instant(row, self._old.layout)
        found.v[6:] += self._rate * (q - before)[7:] / cadence
        quat = found.q[3:7]
        quat /= np.linalg.norm(quat)
        turn = found.foot_rotation
        turn[:] = 1.5 * turn - 0.5 * turn @ turn.transpose(0, 2, 1) @ turn  # to the next rotation
        return found
