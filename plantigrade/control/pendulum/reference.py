r"""The reference of a walk: a stride closed, a mass that feet can bear, and another speed.

From a recording the position of the centre of mass is known to a centimetre, its acceleration not:
some of it would need a centre of pressure outside the feet. The pressure, :math:`p`, is therefore
where that acceleration has it, drawn into the soles that touch. Between it and the mass of a linear
pendulum is

.. math:: \ddot x = \omega^2 (x - p),

whose periodic solution is the pressure without its high frequencies,
:math:`\hat x_k = \hat p_k \, \omega^2 / (\omega^2 + (2 \pi k / T)^2)`: the dynamics filter of a
walk that repeats itself. Without force plates the pressure is centimetres off on average; its mean
is therefore put under that of the mass, which posture tells.
A mass ahead of its posture would make the trunk lean.

The motion of a linear pendulum stays one when feet and mass are scaled alike: steps of another
length at the same cadence need no other pressure within the foot. Only movements are scaled; the
mean distance of feet and pelvis from the mass is that of the posture: scaled as well, it had short
steps bear the mass on the heels, and the trunk leaned back, by 1.9° at 0.7 of the recorded speed
(median of 16 walks; now 1.1°). At another cadence
:math:`c` accelerations are :math:`c^2` times as great, and so must the mass be as much farther from
the pressure, :math:`x - p' = c^2 (x - p)`; the sole is long enough for small changes.
"""

from dataclasses import replace
from math import atan2, cos, hypot, sin

import numpy as np
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant, Layout, derivative_order, width_of
from plantigrade.control.gait.reference import STEP, ReferenceTables, period_of
from plantigrade.control.gait.schedule import StanceSchedule
from plantigrade.control.pendulum.crouch import Crouch
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.control.pendulum.transition import Transition
from plantigrade.control.pendulum.upper_body import BlendedUpperBody
from plantigrade.errors import ParameterError
from plantigrade.kinematics.stride import stride_of
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.spatial.conventions import about_vertical, turned

MIN_HEADING = 0.01  # [rad] direction of a walk up to which it leads along x


def walk_of(record: Record) -> Record:
    """Return the most even stride of a walk, closed, along x on level ground, from mid-stance on.

    A walk that repeats itself already (a synthesised one) is turned to lead along x, and one that
    was not recorded on level ground is returned as it is. A motion without a stride that nearly
    closes is returned with a note: it ends where it ends.

    Args:
        record: The walk: fitted, reproduced or synthesised.

    Raises:
        ParameterError: If the motion has less than four frames, or gaps.
    """
    ground = record.ground
    uneven = ground.slope or ground.steps or ground.seats or ground.uneven
    if uneven:
        return record
    period, advance = period_of(record)
    if period is not None:
        return _along_x(record, atan2(float(advance[1]), float(advance[0])))
    stride = stride_of(record.human, record.motion)
    if not stride.cyclic:
        note = "No stride of the motion nearly closes; it is walked once, unchanged."
        return replace(record, notes=(*record.notes, note))
    stride = stride.from_single_support(record.human)
    motion, level = stride.motion(record.human), replace(ground, height=0.0)
    return Record(record.human, motion, ground=level, notes=record.notes)


def _along_x(record: Record, heading: float) -> Record:
    """Return a walk on level ground turned to lead along x, without its forces if it did not."""
    if abs(heading) < MIN_HEADING:
        return record
    motion, R = record.motion, about_vertical(-heading)
    qpos, qvel = motion.qpos.copy(), motion.qvel.copy()
    qpos[:, :3], qpos[:, 3:7] = qpos[:, :3] @ R.T, turned(qpos[:, 3:7], -heading)
    qvel[:, :3] = qvel[:, :3] @ R.T
    led = replace(motion, qpos=qpos, qvel=qvel, qacc=None)
    return Record(record.human, led, ground=record.ground, notes=record.notes)


def refuse_spins(reference: ReferenceTables, human: Human) -> None:
    """Refuse a walk that turns a foot on the ground farther than a hip rotates.

    The feet of a pendulum keep their heading while they stand, and the body could not follow.

    Raises:
        ParameterError: If a foot does.
    """
    joint, rows = human.model.joint(f"hip_rotation_{SIDES[0]}"), reference.rows
    most, last = float(np.ptp(joint.range)), len(reference.table) - 1
    for each in (each for each in reference.schedule.stances if each.side in SIDES):
        i, k = (int(min(max(time / STEP, 0.0), last)) for time in (each.start, each.stop))
        foot = rows.foot_rotation[i : k + 1, SIDES.index(each.side)]
        # The lateral axis is level in a foot on its toes, too, whose long axis points down.
        turn = float(np.ptp(np.unwrap(np.arctan2(-foot[:, 0, 1], foot[:, 1, 1]))))
        if turn > most:
            raise ParameterError(
                f"from {i * STEP:.1f} s on the walk turns by {np.rad2deg(turn):.0f}° on one foot; "
                f"a pendulum walks on feet that keep their heading, and a hip rotates by "
                f"{np.rad2deg(most):.0f}° at most: leave the spin out"
            )


def with_feasible_com(reference: ReferenceTables, cop_smoothing: float = 0.0) -> ReferenceTables:
    """Return a walk whose centre of mass moves over the ground as its feet can bear it.

    Args:
        reference: The walk; one that does not repeat itself begins and ends where it does.
        cop_smoothing: Standard deviation of a Gaussian filter of the centre of pressure of a walk
            that repeats itself [s].
    """
    found, omega = replace(reference, table=reference.table.copy()), reference.omega
    rows = found.rows
    com, velocity, acceleration, cop = (
        each[:, :2] for each in (rows.com, rows.com_velocity, rows.com_acceleration, rows.cop)
    )
    if reference.period is None:  # the pendulum between its ends
        n = len(com) - int(reference.ends)  # the row after the end rests
        stiff = (omega * STEP) ** 2
        band = np.ones((3, n - 2))
        band[1] = -2.0 - stiff
        right = -stiff * cop[1 : n - 1]
        right[0] -= com[0]
        right[-1] -= com[n - 1]
        com[1 : n - 1] = solve_banded((1, 1), band, right)
        velocity[:n] = np.gradient(com[:n], STEP, axis=0)
        acceleration[:n] = omega**2 * (com - cop)[:n]
        return found
    n = len(com) - 1
    speed = reference.advance[:2] / reference.period
    if not rows.force.any():
        _fill_cop(rows, omega)
    time = STEP * np.arange(n)[:, None]
    # The mean position of the mass follows from the posture, that of the pressure is a guess.
    cop += (com - cop)[:-1].mean(axis=0)
    part = np.fft.rfft(cop[:-1] - speed * time, axis=0)
    frequency = 2.0 * np.pi * np.arange(len(part))[:, None] / reference.period
    part *= np.exp(-0.5 * (cop_smoothing * frequency) ** 2)
    cop[:-1] = np.fft.irfft(part, n, axis=0) + speed * time
    cop[-1] = cop[0] + reference.advance[:2]
    part *= omega**2 / (omega**2 + frequency**2)
    com[:-1] = np.fft.irfft(part, n, axis=0) + speed * time
    velocity[:-1] = np.fft.irfft(1j * frequency * part, n, axis=0) + speed
    acceleration[:-1] = omega**2 * (com - cop)[:-1]
    com[-1] = com[0] + reference.advance[:2]
    velocity[-1], acceleration[-1] = velocity[0], acceleration[0]
    return found


def _fill_cop(rows: Instant, omega: float) -> None:
    """Set the centre of pressure to what the acceleration of the mass needs, within the soles.

    The middle of the spheres that touch stays where it is while a foot lies flat, where the
    pressure of people rolls from heel to toes: the ankle moment had a second hump (r .87, now .94).

    Args:
        rows: The walk, of which no forces are known.
        omega: Root of gravity by height [1/s].
    """
    on = rows.contact > 0.5
    place, known = rows.contact_position[:, :, :2], on.any(axis=1)
    low = np.where(on[:, :, None], place, np.inf).min(axis=1)
    high = np.where(on[:, :, None], place, -np.inf).max(axis=1)
    needed = (rows.com - rows.com_acceleration / omega**2)[:, :2]
    rows.cop[known, :2] = np.minimum(np.maximum(needed, low), high)[known]


class ScaledReference:
    """A reference walked at another speed; everything else as :class:`Reference`.

    Attributes:
        recorded: The reference.
        step_scale: Length of steps [recorded steps].
        cadence: Steps in a time, by the recorded ones.
        crouch: The crouched posture; None if it is as recorded.
        upper: Upper of spine, neck and arms; None if as recorded.
        transition: From the walk before, as long as it turns into this one.
    """

    def __init__(self, reference: ReferenceTables, settings: SpeedSettings | None = None):
        self.settings = settings or SpeedSettings()
        self.recorded = reference
        self.schedule: StanceSchedule = reference.schedule
        self.omega, self.period = reference.omega, reference.period
        self.duration, self.ends = reference.duration, reference.ends
        self.step_scale, self.cadence = 1.0, 1.0
        self.crouch: Crouch | None = None
        self.upper: BlendedUpperBody | None = None
        self.transition: Transition | None = None
        self._low = reference.rows.foot_position[:, :, 2].min(axis=0)
        self._along, self._moving = _on_axis(reference.layout, 0)
        self._across = np.logical_or(*_on_axis(reference.layout, 1))
        mean = Instant(reference.table.mean(axis=0), reference.layout)
        mean.cop[:] = mean.com  # what moves the mass is its distance from the pressure
        self._mean_ahead = mean.row[self._along] - mean.com[0]  # of the mass [m]
        self._order = derivative_order(reference.layout)
        ends = reference.rows.q[[0, -1], 0]
        self._own = self._speed = float(ends[1] - ends[0]) / reference.duration
        self._phase = self._ahead = 0.0
        self._update_factors()

    @property
    def speed(self) -> float:
        """Mean speed of the recording along its line, at its own cadence [m/s]."""
        return self._speed

    def scale(self, step_scale: float, cadence: float, phase: float) -> None:
        """Scale the walk from a phase on.

        Args:
            step_scale: Length of steps [recorded steps].
            cadence: Steps in a time, by the recorded ones.
            phase: Now [s].
        """
        # The mean position of the recording stays where it is now.
        self._ahead += self.step_scale * self._speed * (phase - self._phase)
        self._phase = phase
        if (step_scale, cadence) != (self.step_scale, self.cadence):
            self.step_scale, self.cadence = step_scale, cadence
            self._update_factors()

    def blend(self, transition: Transition | None, phase: float) -> None:
        """Let another walk turn into this one; to be called whenever its weight changes.

        Args:
            transition: The walk before; None once this one is reached.
            phase: Now [s].
        """
        self.scale(self.step_scale, self.cadence, phase)
        self.transition, part = transition, 1.0 if transition is None else transition.part
        before = 0.0 if transition is None else transition.speed
        self._speed = part * self._own + (1.0 - part) * before

    def shift(self, ahead: float) -> None:
        """Move it along its line [m]."""
        self._ahead += ahead

    def start(self, step_scale: float, phase: float, ahead: float) -> None:
        """Begin anew.

        Args:
            step_scale: Length of steps [recorded steps]; the cadence is the recorded one.
            phase: At the beginning [s].
            ahead: Mean position of the recording then, along its line [m].
        """
        self._phase, self._ahead = phase, ahead
        self.step_scale, self.cadence = step_scale, 1.0
        self._update_factors()

    def at(self, phase: float) -> Instant:
        """Return the walk at a phase."""
        found = self.recorded.at(phase)
        if self.transition is not None:
            found = self.transition.at(found, phase, self.cadence)
        same = self.step_scale == self.cadence == 1.0 and self._shift == 0.0
        if same and self.crouch is None and self.upper is None:
            return found
        row: Array = found.row * self._factor
        row[self._along] += self._shift + (1.0 - self.step_scale) * self._mean_ahead
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
        if self.step_scale < 1.0:
            self._flatten(found)
        return found

    def _flatten(self, found: Instant) -> None:
        """Roll and lift feet less in shorter steps: there is no push-off in place."""
        less = 1.0 - self.step_scale
        lower = self.settings.lift_reduction * less
        height = found.foot_position[:, 2]
        height -= lower * (height - self._low)
        for turn in found.foot_rotation:
            x, y, z = turn[:, 2]
            far = hypot(x, y)
            if far > 1e-6:
                back = less * atan2(far, z)
                turn[:] = _rotation(-y / far, x / far, -back) @ turn
        found.foot_angular_velocity[:, :2] *= self.step_scale
        found.foot_angular_acceleration[:, :2] *= self.step_scale
        found.foot_velocity[:, 2] *= 1.0 - lower
        found.foot_acceleration[:, 2] *= 1.0 - lower

    @property
    def _shift(self) -> float:
        return self._ahead - self.step_scale * self._speed * self._phase

    def _update_factors(self) -> None:
        self._factor = np.where(self._along | self._moving, self.step_scale, 1.0)
        self._factor *= self.cadence**self._order
        self._factor[self._across] *= 1.0 + self.settings.step_widening * max(
            1.0 - self.step_scale, 0.0
        )


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


def _rotation(x: float, y: float, angle: float) -> Float[Array, "3 3"]:
    """Return the rotation by an angle about the horizontal axis (x, y) of length one."""
    c, s = cos(angle), sin(angle)
    k = 1.0 - c
    return np.array(
        [[c + k * x * x, k * x * y, s * y], [k * x * y, c + k * y * y, -s * x], [-s * y, s * x, c]]
    )
