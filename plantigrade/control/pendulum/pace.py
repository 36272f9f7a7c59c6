r"""A walk at another speed: longer steps, and quicker ones.

What a linear pendulum does stays true when its way is multiplied, feet and mass alike: steps of
another length at the same cadence need no other pressure within the foot. At another cadence
:math:`c` accelerations are :math:`c^2` times as great, and so must the mass be as much farther from
the pressure, :math:`x - p' = c^2 (x - p)`; the sole is long enough for small changes.
"""

from math import atan2, cos, hypot, sin

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.reference import Instant, Reference
from plantigrade.control.gait.schedule import Schedule
from plantigrade.control.pendulum.crouch import Crouch
from plantigrade.control.pendulum.switch import Crossing
from plantigrade.control.pendulum.upper import Upper

RATES = ("v", "com_velocity", "foot_velocity", "turn_velocity")
"""What is faster at another cadence."""
CHANGES = ("a", "com_acceleration", "foot_acceleration", "turn_acceleration")
"""What is so twice."""
PLACES = ("com", "pressure", "foot", "low")
"""Places along the walk."""
MOTIONS = ("com_velocity", "foot_velocity", "com_acceleration", "foot_acceleration")
"""Their rates, and rates of these."""

WIDER = 0.6
"""Feet that are no longer ahead of each other are so much farther apart sideways, by the part that
steps are shorter."""
LIFTED = 0.5
"""Feet are lifted less in shorter steps by this part of what these are shorter."""


class Paced:
    """A reference walked at another speed; everything else as :class:`Reference`.

    Attributes:
        stride: Length of its steps, by the recorded ones.
        cadence: Steps in a time, by the recorded ones.
        crouch: The crouched posture; None if it is as recorded.
        upper: What spine, neck and arms do instead; None if as recorded.
        crossing: The walk before, as long as it turns into this one.
    """

    def __init__(self, reference: Reference):
        self.recorded = reference
        self.schedule: Schedule = reference.schedule
        self.omega, self.period = reference.omega, reference.period
        self.duration, self.ends = reference.duration, reference.ends
        self.stride, self.cadence = 1.0, 1.0
        self.crouch: Crouch | None = None
        self.upper: Upper | None = None
        self.crossing: Crossing | None = None
        feet = reference.table[:, reference.columns["foot"][0]].reshape(-1, 2, 3)
        self._low = feet[:, :, 2].min(axis=0)
        width = reference.table.shape[1]
        self._along, self._moving = np.zeros(width, dtype=bool), np.zeros(width, dtype=bool)
        self._order = np.zeros(width)
        self._across = np.zeros(width, dtype=bool)
        for name in PLACES:
            self._along[self._cut(name, 0)] = True
        for name in MOTIONS:
            self._moving[self._cut(name, 0)] = True
        for name in (*PLACES, *MOTIONS):
            self._across[self._cut(name, 1)] = True
        for name in ("q", "v", "a"):
            first = reference.columns[name][0].start
            (self._along if name == "q" else self._moving)[first] = True
            self._across[first + 1] = True
        for names, order in ((RATES, 1.0), (CHANGES, 2.0)):
            for name in names:
                self._order[reference.columns[name][0]] = order
        self._com, self._pressure = reference.columns["com"][0], reference.columns["pressure"][0]
        ends = reference.table[[0, -1], reference.columns["q"][0].start]
        self._own = self._speed = float(ends[1] - ends[0]) / reference.duration
        self._phase = self._ahead = 0.0
        self._settle()

    @property
    def speed(self) -> float:
        """Mean speed of the recording along its line, at its own cadence [m/s]."""
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

    def cross(self, crossing: Crossing | None, phase: float) -> None:
        """Let another walk turn into this one; to be called whenever its part is another.

        Args:
            crossing: The walk before; None once this one is reached.
            phase: That of now [s].
        """
        self.set(self.stride, self.cadence, phase)
        self.crossing, part = crossing, 1.0 if crossing is None else crossing.part
        before = 0.0 if crossing is None else crossing.speed
        self._speed = part * self._own + (1.0 - part) * before

    def shift(self, ahead: float) -> None:
        """Move it along its line [m]."""
        self._ahead += ahead

    def start(self, stride: float, phase: float, ahead: float) -> None:
        """Begin anew.

        Args:
            stride: Length of steps, by the recorded ones; the cadence is the recorded one.
            phase: With which [s].
            ahead: Where the mean place of the recording is then, along its line [m].
        """
        self._phase, self._ahead = phase, ahead
        self.stride, self.cadence = stride, 1.0
        self._settle()

    def at(self, phase: float) -> Instant:
        """Return everything at a phase: arrays by name."""
        found = self.recorded.at(phase)
        if self.crossing is not None:
            found = self.crossing.at(found, phase, self.cadence)
        same = self.stride == self.cadence == 1.0 and self._shift == 0.0
        if same and self.crouch is None and self.upper is None:
            return found
        row: Array = found.row * self._factor
        row[self._along] += self._shift
        if self.cadence != 1.0:
            com, pressure = row[self._com], row[self._pressure]
            pressure[:2] = com[:2] - self.cadence**2 * (com - pressure)[:2]
        if self.upper is not None:
            self.upper.put(Instant(row, self.recorded.columns), phase, self.cadence)
        if self.crouch is not None:
            row[self._com.start + 2] -= self.crouch.lowering
            q = self.recorded.columns["q"][0]
            row[q.start + 2] -= self.crouch.lowering
            row[q.start + 7 : q.stop] += self.crouch.angles
        if self.stride < 1.0:
            self._flatten(row)
        return Instant(row, self.recorded.columns)

    def _flatten(self, row: Array) -> None:
        """Let feet roll and lift less, in steps that are shorter: nobody pushes off in place."""
        columns, less = self.recorded.columns, 1.0 - self.stride
        place = row[columns["foot"][0]].reshape(2, 3)
        place[:, 2] -= LIFTED * less * (place[:, 2] - self._low)
        turns = row[columns["turn"][0]].reshape(2, 3, 3)
        for i, turn in enumerate(turns):
            x, y, z = turn[:, 2]
            far = hypot(x, y)
            if far > 1e-6:
                back = less * atan2(far, z)
                turns[i] = rotated(-y / far, x / far, -back) @ turn
        for name in ("turn_velocity", "turn_acceleration"):
            row[columns[name][0]].reshape(2, 3)[:, :2] *= self.stride
        for name in ("foot_velocity", "foot_acceleration"):
            row[columns[name][0]].reshape(2, 3)[:, 2] *= 1.0 - LIFTED * less

    @property
    def _shift(self) -> float:
        return self._ahead - self.stride * self._speed * self._phase

    def _cut(self, name: str, axis: int) -> slice:
        where = self.recorded.columns[name][0]
        return slice(where.start + axis, where.stop, 3)

    def _settle(self) -> None:
        self._factor = np.where(self._along | self._moving, self.stride, 1.0)
        self._factor *= self.cadence**self._order
        self._factor[self._across] *= 1.0 + WIDER * max(1.0 - self.stride, 0.0)


def rotated(x: float, y: float, angle: float) -> Float[Array, "3 3"]:
    """Return the rotation about a level axis.

    Args:
        x: Of the axis.
        y: Likewise; together of length one.
        angle: By how much [rad].
    """
    c, s = cos(angle), sin(angle)
    k = 1.0 - c
    return np.array(
        [[c + k * x * x, k * x * y, s * y], [k * x * y, c + k * y * y, -s * x], [-s * y, s * x, c]]
    )
