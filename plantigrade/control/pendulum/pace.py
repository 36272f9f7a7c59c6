r"""A walk at another speed: longer steps, and quicker ones.

What a linear pendulum does stays true when its way is multiplied, feet and mass alike: steps of
another length at the same cadence need no other pressure within the foot. At another cadence
:math:`c` accelerations are :math:`c^2` times as great, and so must the mass be as much farther from
the pressure, :math:`x - p' = c^2 (x - p)`; the sole is long enough for small changes.
"""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.control.replay.reference import Instant, Reference
from plantigrade.control.replay.schedule import Schedule

RATES = ("v", "com_velocity", "foot_velocity", "turn_velocity")
"""What is faster at another cadence."""
CHANGES = ("a", "com_acceleration", "foot_acceleration", "turn_acceleration")
"""What is so twice."""
PLACES = ("com", "pressure", "foot", "low")
"""Places along the walk."""
MOTIONS = ("com_velocity", "foot_velocity", "com_acceleration", "foot_acceleration")
"""Their rates, and rates of these."""


class Paced:
    """A reference walked at another speed; everything else as :class:`Reference`.

    Attributes:
        stride: Length of its steps, by the recorded ones.
        cadence: Steps in a time, by the recorded ones.
        inward: How far the mass is nearer to the centre of a turn, to the left [m].
    """

    def __init__(self, reference: Reference):
        self.recorded = reference
        self.schedule: Schedule = reference.schedule
        self.omega, self.period = reference.omega, reference.period
        self.duration, self.ends = reference.duration, reference.ends
        self.stride, self.cadence, self.inward = 1.0, 1.0, 0.0
        width = reference.table.shape[1]
        self._along, self._moving = np.zeros(width, dtype=bool), np.zeros(width, dtype=bool)
        self._order = np.zeros(width)
        for name in PLACES:
            self._along[self._cut(name, 0)] = True
        for name in MOTIONS:
            self._moving[self._cut(name, 0)] = True
        self._along[reference.columns["q"][0].start] = True
        for name in ("v", "a"):
            self._moving[reference.columns[name][0].start] = True
        for names, order in ((RATES, 1.0), (CHANGES, 2.0)):
            for name in names:
                self._order[reference.columns[name][0]] = order
        self._com, self._pressure = reference.columns["com"][0], reference.columns["pressure"][0]
        self._push = reference.columns["com_acceleration"][0]
        ends = reference.table[[0, -1], reference.columns["q"][0].start]
        self._speed = float(ends[1] - ends[0]) / reference.duration
        self._phase = self._ahead = 0.0
        self._settle()

    @property
    def speed(self) -> float:
        """Mean speed of the recording along its line [m/s]."""
        return self._speed

    def set(self, stride: float, cadence: float, phase: float) -> None:
        """Walk otherwise from a phase on.

        Args:
            stride: Length of steps, by the recorded ones.
            cadence: Steps in a time, by the recorded ones.
            phase: That of now [s].
        """
        # What is at the mean place of the recording now, stays there.
        self._ahead += self.stride * self._speed * (phase - self._phase)
        self._phase = phase
        if (stride, cadence) != (self.stride, self.cadence):
            self.stride, self.cadence = stride, cadence
            self._settle()

    def start(self, stride: float, phase: float, ahead: float) -> None:
        """Begin anew.

        Args:
            stride: Length of steps, by the recorded ones; the cadence is the recorded one.
            phase: With which [s].
            ahead: Where the mean place of the recording is then, along its line [m].
        """
        self._phase, self._ahead = phase, ahead
        self.stride, self.cadence, self.inward = stride, 1.0, 0.0
        self._settle()

    def at(self, phase: float) -> Instant:
        """Return everything at a phase: arrays by name."""
        found = self.recorded.at(phase)
        if self.stride == self.cadence == 1.0 and self._shift == self.inward == 0.0:
            return found
        row: Array = found.row * self._factor
        row[self._along] += self._shift
        if self.cadence != 1.0:
            com, pressure = row[self._com], row[self._pressure]
            pressure[:2] = com[:2] - self.cadence**2 * (com - pressure)[:2]
        if self.inward:  # the pressure pushes the mass to that side
            row[self._com.start + 1] += self.inward
            row[self._push.start + 1] += self.omega**2 * self.inward
        return Instant(row, self.recorded.columns)

    @property
    def _shift(self) -> float:
        return self._ahead - self.stride * self._speed * self._phase

    def _cut(self, name: str, axis: int) -> slice:
        where = self.recorded.columns[name][0]
        return slice(where.start + axis, where.stop, 3)

    def _settle(self) -> None:
        self._factor = np.where(self._along | self._moving, self.stride, 1.0)
        self._factor *= self.cadence**self._order
