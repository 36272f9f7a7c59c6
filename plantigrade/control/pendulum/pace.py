r"""A walk at another speed: longer steps, and quicker ones.

What a linear pendulum does stays true when its way is multiplied, feet and mass alike: steps of
another length at the same cadence need no other pressure within the foot. At another cadence
:math:`c` accelerations are :math:`c^2` times as great, and so must the mass be as much farther from
the pressure, :math:`x - p' = c^2 (x - p)`; the sole is long enough for small changes.
"""

from math import atan2, cos, hypot, sin

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.gait.instant import Instant, Layout, derivative_order, width_of
from plantigrade.control.gait.reference import Reference
from plantigrade.control.gait.schedule import Schedule
from plantigrade.control.pendulum.crouch import Crouch
from plantigrade.control.pendulum.transition import Transition
from plantigrade.control.pendulum.upper_body import UpperBody

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
        upper: Of spine, neck and arms; None if as recorded.
        transition: From the walk before, as long as it turns into this one.
    """

    def __init__(self, reference: Reference):
        self.recorded = reference
        self.schedule: Schedule = reference.schedule
        self.omega, self.period = reference.omega, reference.period
        self.duration, self.ends = reference.duration, reference.ends
        self.stride, self.cadence = 1.0, 1.0
        self.crouch: Crouch | None = None
        self.upper: UpperBody | None = None
        self.transition: Transition | None = None
        self._low = reference.rows.foot_position[:, :, 2].min(axis=0)
        self._along, self._moving = _on_axis(reference.layout, 0)
        self._across = np.logical_or(*_on_axis(reference.layout, 1))
        self._order = derivative_order(reference.layout)
        ends = reference.rows.q[[0, -1], 0]
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

    def blend(self, transition: Transition | None, phase: float) -> None:
        """Let another walk turn into this one; to be called whenever its weight changes.

        Args:
            transition: The walk before; None once this one is reached.
            phase: That of now [s].
        """
        self.set(self.stride, self.cadence, phase)
        self.transition, part = transition, 1.0 if transition is None else transition.part
        before = 0.0 if transition is None else transition.speed
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
        """Return the walk at a phase."""
        found = self.recorded.at(phase)
        if self.transition is not None:
            found = self.transition.at(found, phase, self.cadence)
        same = self.stride == self.cadence == 1.0 and self._shift == 0.0
        if same and self.crouch is None and self.upper is None:
            return found
        row: Array = found.row * self._factor
        row[self._along] += self._shift
        found = Instant(row, self.recorded.layout)
        if self.cadence != 1.0:
            com, pressure = found.com, found.cop
            pressure[:2] = com[:2] - self.cadence**2 * (com - pressure)[:2]
        if self.upper is not None:
            self.upper.apply(found, phase, self.cadence)
        if self.crouch is not None:
            found.com[2] -= self.crouch.lowering
            found.q[2] -= self.crouch.lowering
            found.q[7:] += self.crouch.angles
        if self.stride < 1.0:
            self._flatten(found)
        return found

    def _flatten(self, found: Instant) -> None:
        """Let feet roll and lift less, in steps that are shorter: nobody pushes off in place."""
        less = 1.0 - self.stride
        place = found.foot_position
        place[:, 2] -= LIFTED * less * (place[:, 2] - self._low)
        for turn in found.foot_rotation:
            x, y, z = turn[:, 2]
            far = hypot(x, y)
            if far > 1e-6:
                back = less * atan2(far, z)
                turn[:] = rotated(-y / far, x / far, -back) @ turn
        found.foot_angular_velocity[:, :2] *= self.stride
        found.foot_angular_acceleration[:, :2] *= self.stride
        found.foot_velocity[:, 2] *= 1.0 - LIFTED * less
        found.foot_acceleration[:, 2] *= 1.0 - LIFTED * less

    @property
    def _shift(self) -> float:
        return self._ahead - self.stride * self._speed * self._phase

    def _settle(self) -> None:
        self._factor = np.where(self._along | self._moving, self.stride, 1.0)
        self._factor *= self.cadence**self._order
        self._factor[self._across] *= 1.0 + WIDER * max(1.0 - self.stride, 0.0)


def _on_axis(
    layout: Layout, axis: int
) -> tuple[Bool[Array, " n_columns"], Bool[Array, " n_columns"]]:
    """Return which columns are positions along an axis of the world, and which their rates."""
    places, rates = (Instant(np.zeros(width_of(layout), dtype=bool), layout) for _ in range(2))
    places.q[axis] = rates.v[axis] = rates.a[axis] = True
    for each in (places.com, places.cop, places.foot_position, places.contact_position):
        each[..., axis] = True
    for each in (
        rates.com_velocity,
        rates.com_acceleration,
        rates.foot_velocity,
        rates.foot_acceleration,
    ):
        each[..., axis] = True
    return places.row, rates.row


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
