r"""Flight phases of a reference: its clock follows take-off and landing; feet prepare to land."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.control.balance.recovery import Recovery
from plantigrade.control.balance.reference import Wanted
from plantigrade.kinematics.state import State
from plantigrade.wbc.whole_body import Rows

EARLY = 0.06
"""A body that leaves the ground so long before it was to is taken to fly [s]."""
WAITS = 0.4
"""So long, at most, the clock waits for a landing [s]."""
GAIN, FOOT, TURN = 200.0, 100.0, 10.0
"""Stiffness with which feet are led to where they are to land [1/s²], and the weights of where they
are and of how they are turned."""
FARTHEST = 0.2
"""So far from where the reference has them, at most [m]."""


class FlightClock:
    """The time of a reference, led by take-off and landing.

    A flight begins when nothing touches, at :data:`EARLY` before its time or when that has come,
    and ends when something does while the body comes down, for toes may drag behind it on the way
    up; until then the reference stays at its last instant in the air.

    Args:
        flights: From when to when the reference flies [s].
    """

    def __init__(self, flights: Sequence[tuple[float, float]]):
        self._flights, self._last, self._time = list(flights), 0.0, 0.0
        self._off, self._waited = False, 0.0

    @property
    def airborne(self) -> bool:
        """Whether the reference is in a flight."""
        return bool(self._flights and self._time >= self._flights[0][0])

    def at(self, time: float, touches: bool, falls: bool) -> float:
        """Return the time of the reference.

        Args:
            time: That of the world [s].
            touches: Whether anything is pressed against the ground.
            falls: Whether the body comes down.
        """
        step, self._last = time - self._last, time
        self._time += step
        if not self._flights:
            return self._time
        begin, end = self._flights[0]
        if not self._off:
            if not touches and self._time > begin - EARLY:
                self._off, self._time = True, max(self._time, begin)
        elif touches and falls and self._time > begin:
            self._landed(end)
            return self._time
        if self._time >= end:
            self._waited += step
            if self._waited > WAITS or not self._off:
                self._landed(end)
            else:
                self._time = np.nextafter(end, begin)
        return self._time

    def _landed(self, end: float) -> None:
        self._time, self._off, self._waited = end, False, 0.0
        self._flights.pop(0)


def landing_rows(body: State, wanted: Wanted, feet: Recovery) -> list[Rows]:
    r"""Return the rows that bring the feet under where the body will come to rest.

    That is :math:`\dot c / \omega` ahead of the centre of mass, as in [Hof2005]_, wherever the
    reference has them: both move on with :math:`\dot c` until they land. The feet are turned as
    they are there.
    """
    omega = np.sqrt(GRAVITY / max(float(wanted.com[2]), 0.3))
    soles = feet.soles(body)
    J, velocity, bias = body.touched(np.array(feet.feet), soles)
    middle = np.array([wanted.places[own].mean(axis=0) for own in feet.own])
    ahead = body.com_velocity / omega
    ahead *= min(1.0, FARTHEST / max(float(np.linalg.norm(ahead[:2])), 1e-9))
    off: Float[Array, "2 3"] = middle - wanted.com + ahead - (soles - body.com)
    asked = GAIN * off - 2 * np.sqrt(GAIN) * (velocity - body.com_velocity)
    right = asked - bias + body.com_bias_acceleration
    rows = [Rows(J[k, :2] - body.com_jacobian[:2], right[k, :2], FOOT) for k in (0, 1)]
    posed = body.moved_to(wanted.qpos).rotations[feet.feet]
    for foot, turn in zip(feet.feet, posed, strict=True):
        spin = body.angular_jacobian(foot)
        away = 0.5 * np.cross(body.rotation(foot), turn, axis=0).sum(axis=1)
        rows.append(Rows(spin, GAIN * away - 2 * np.sqrt(GAIN) * (spin @ body.qvel), TURN))
    return rows
