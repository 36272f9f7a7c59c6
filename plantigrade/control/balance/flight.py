"""Flight phases of a reference: its clock follows take-off and touchdown; feet prepare for it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.control.balance.recovery import Recovery
from plantigrade.control.balance.reference import ReferenceState
from plantigrade.control.gait.pendulum_state import MIN_PENDULUM_HEIGHT
from plantigrade.control.gait.phase import GaitPhaseSettings
from plantigrade.control.gait.support import drawn_to
from plantigrade.kinematics.state import BodyState
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks import AlignmentTask
from plantigrade.wbc.tasks.point import axis_error


@dataclass(frozen=True, kw_only=True)
class FlightSettings:
    """The clock in flight."""

    max_wait: float = GaitPhaseSettings.max_wait
    """Longest time the clock waits for a touchdown after the planned one [s]; as in walking."""


class FlightClock:
    """The time of a reference, led by take-off and touchdown.

    A flight begins when nothing touches, at the earliest at its time. It ends when something
    touches while the body comes down, for toes may drag on the way up; until then the reference
    stays at its last instant in the air.

    Args:
        flights: From when to when the reference flies [s].
    """

    def __init__(
        self, flights: Sequence[tuple[float, float]], settings: FlightSettings | None = None
    ):
        self.settings = settings or FlightSettings()
        self._flights, self._last, self._time = list(flights), 0.0, 0.0
        self._off, self._waited = False, 0.0

    @property
    def airborne(self) -> bool:
        """Whether the reference is in a flight."""
        return bool(self._flights and self._time >= self._flights[0][0])

    def at(self, time: float, touches: bool, falls: bool) -> float:
        """Return the time of the reference.

        Args:
            time: Time of the world [s].
            touches: Whether anything is pressed against the ground.
            falls: Whether the body comes down.
        """
        step, self._last = time - self._last, time
        self._time += step
        if not self._flights:
            return self._time
        begin, end = self._flights[0]
        if not self._off:
            self._off = not touches and self._time > begin
        elif touches and falls and self._time > begin:
            self._landed(end)
            return self._time
        if self._time >= end:
            self._waited += step
            if self._waited > self.settings.max_wait or not self._off:
                self._landed(end)
            else:
                self._time = np.nextafter(end, begin)
        return self._time

    def _landed(self, end: float) -> None:
        self._time, self._off, self._waited = end, False, 0.0
        self._flights.pop(0)


def landing_rows(body: BodyState, desired: ReferenceState, feet: Recovery) -> list[Rows]:
    r"""Return the rows that bring the feet under where the body will come to rest.

    That is :math:`\dot c / \omega` ahead of the centre of mass, as in [Hof2005]_, wherever the
    reference has them: both move on with :math:`\dot c` until touchdown. The feet are turned as
    they are in the reference. Position and orientation have the stiffness that orientation has in
    recovery steps, critically damped.
    """
    gain = feet.settings.foot_orientation_gain
    damping = 2 * np.sqrt(gain)
    omega = np.sqrt(GRAVITY / max(float(desired.com[2]), MIN_PENDULUM_HEIGHT))
    soles = feet.soles(body)
    J, velocity, bias = body.touched(np.array(feet.feet), soles)
    middle = np.array([desired.spheres[own].mean(axis=0) for own in feet.foot_spheres])
    ahead = body.com_velocity / omega
    ahead[:2] = drawn_to(ahead[:2], np.zeros(2), feet.planner.max_extension)
    error: Float[Array, "2 3"] = middle - desired.com + ahead - (soles - body.com)
    acceleration = gain * error - damping * (velocity - body.com_velocity)
    right = acceleration - bias + body.com_bias_acceleration
    weight, J = feet.settings.foot_weight, J[:, :2] - body.com_jacobian[:2]
    rows = [Rows(J[k], right[k, :2], weight) for k in (0, 1)]
    rotations = body.moved_to(desired.qpos).rotations[feet.feet]
    weight = feet.settings.foot_orientation_weight
    for foot, rotation in zip(feet.feet, rotations, strict=True):
        task = AlignmentTask(
            foot, axis_error(rotation, body.rotation(foot)), stiffness=gain, weight=weight
        )
        rows.append(task.rows(body))
    return rows
