"""A motion as tables on an even grid, which controllers compare the present state with.

A periodic motion is repeated for ever, shifted by its own advance; any other one ends in its last
posture, at rest. Everything is looked up by *phase*, the time of the motion itself.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.control.gait.clearance import SelfClearance, held_out
from plantigrade.control.gait.edges import EdgeSettings
from plantigrade.control.gait.instant import (
    Instant,
    Layout,
    derivative_order,
    layout_of,
    rows_of,
    width_of,
)
from plantigrade.control.gait.kinematics import Kinematics
from plantigrade.control.gait.loads import LoadSettings, site_forces, site_loads
from plantigrade.control.gait.person import world_sites
from plantigrade.control.gait.schedule import (
    StanceSchedule,
    StanceSettings,
    carrying,
    contact_intervals,
    schedule_of,
)
from plantigrade.control.gait.step import StepSettings
from plantigrade.errors import ParameterError
from plantigrade.motion.filters import interpolate
from plantigrade.record import Record

STEP = 0.002  # [s] time step of the grid


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings:
    """How a motion is made a reference."""

    load: LoadSettings = LoadSettings()
    schedule: StanceSettings = StanceSettings()
    edges: EdgeSettings = EdgeSettings()
    rest_speed: float = StepSettings.rest_speed
    """Velocity below which a motion rests at its beginning or end [m/s, rad/s]; as after steps."""
    min_cop_load: float = LoadSettings.min_foot_load
    """Load from which the centre of pressure is that of the spheres [body weights]; as of a foot
    on the ground."""
    cop_smoothing: float = 0.03
    """Standard deviation of the filter of the centre of pressure of a walk that repeats itself [s]:
    estimated from the spheres that touch it leaps, where that of people rolls from heel to toes."""
    contact_lead_time: float = 0.08
    """Time before its contact from which a sphere that touches stays down [s]. Chosen (±20 %:
    deviation 12 %)."""


@dataclass(frozen=True, eq=False)
class ReferenceTables:
    """Tables of a motion.

    Attributes:
        table: One row an instant, :data:`STEP` apart.
        layout: Columns and shape of every field of an instant.
        translation: How much of a translation of the world each column takes up.
        schedule: Stances of the feet, and the share of the load that each carries.
        omega: Rate of the linear pendulum, from the mean height of the centre of mass [1/s].
        period: Period of a periodic motion [s]; None otherwise.
        duration: Duration of the motion, or of one period [s].
        advance: Displacement in a period of a periodic motion [m].
        ends: Whether the motion ends at rest.
    """

    table: Float[Array, "n_rows n_columns"]
    layout: Layout
    translation: Float[Array, "n_columns 3"]
    schedule: StanceSchedule
    omega: float
    period: float | None
    duration: float
    advance: Float[Array, " 3"]
    ends: bool

    @property
    def rows(self) -> Instant:
        """All instants: every field has an axis of them in front."""
        return rows_of(self.table, self.layout)

    def at(self, phase: float) -> Instant:
        """Return the motion at a phase."""
        cycle, phase = self.schedule.cycle(phase)
        place = min(max(phase / STEP, 0.0), len(self.table) - 1.000001)
        i = int(place)
        u = place - i
        row = (1.0 - u) * self.table[i] + u * self.table[i + 1]
        if cycle:
            row += self.translation @ (cycle * self.advance)
        return Instant(row, self.layout)


def reference_of(
    record: Record,
    clearance: SelfClearance | None = None,
    *,
    settings: ReferenceSettings | None = None,
) -> ReferenceTables:
    """Return the tables of a motion.

    Forces and torques are taken where the record has them; without them the load is where the feet
    are on the ground. A motion that was cut off in a step ends with that foot on the ground: one
    that swings for ever lets the body fall.

    Args:
        record: The motion.
        clearance: How it is kept from passing through itself; left as it is if absent.
        settings: The numbers of the tables.

    Raises:
        ParameterError: If the motion has less than two frames.
    """
    motion, weight, settings = record.motion, record.weight, settings or ReferenceSettings()
    if motion.n_frames < 2 or motion.duration < 5 * STEP:
        raise ParameterError("a replay needs a motion of several frames")
    period, advance = period_of(record, settings.rest_speed)
    periodic, n = period is not None, int(np.ceil(motion.duration / STEP - 1e-6)) + 1
    time = np.minimum(motion.time[0] + STEP * np.arange(n), motion.time[-1])
    even = motion.at(time)
    qpos, qvel = even.qpos, even.qvel
    qpos = qpos if clearance is None else held_out(record, qpos, clearance)
    ends = not periodic and float(np.abs(qvel[-1]).max()) < settings.rest_speed
    sites = world_sites(record)
    force = site_forces(record, sites, time)
    swept = Kinematics.of(record, sites, qpos, qvel, STEP)
    shortest = settings.schedule.min_duration
    load = site_loads(record, sites, swept, force, STEP, settings.load, shortest)
    force = _of_all(force, sites)
    if not periodic:
        _set_down(sites, load, weight)
    if record.ground.steps:
        down = carrying(load, weight, STEP, periodic=False, settings=settings.schedule)
        swept.lift_over_edges(record, sites, down, STEP, settings.edges)
    omega = _rate(record, swept.com)
    contact = carrying(load, weight, STEP, periodic=periodic, settings=settings.schedule)
    stances = contact_intervals(sites, contact, STEP, period, shortest)
    schedule = schedule_of(stances, sites, load, omega, STEP, period)
    layout = layout_of(qpos.shape[1], qvel.shape[1], len(sites))
    table = np.empty((n + ends, width_of(layout)))
    rows = rows_of(table[:n], layout)
    rows.q, rows.v, rows.force = qpos, qvel, force
    rows.a = even.qacc if even.qacc is not None else np.gradient(qvel, STEP, axis=0)
    rows.tau = _torques(record, time)
    _fill_com(rows, swept, force, load, record.human.mass, settings.min_cop_load * weight)
    _fill_feet(rows, swept)
    rows.contact, rows.contact_position = contact, swept.contact_position
    lead = settings.contact_lead_time
    rows.contact_soon = before(contact, round(lead / STEP), periodic=periodic)
    if ends:  # a last row at rest
        table[n] = np.where(derivative_order(layout) > 0, 0.0, table[n - 1])
    translation, duration = translation_of(layout), motion.duration
    return ReferenceTables(
        table, layout, translation, schedule, omega, period, duration, advance, ends
    )


def _of_all(force: Float[Array, "n k 3"], sites: tuple[ContactSite, ...]) -> Float[Array, "n k 3"]:
    """Return forces; none where only those of a seat are known, which alone move no body."""
    known = force[:, [bool(site.side) for site in sites]].any()
    return force if known else np.zeros_like(force)


def _rate(record: Record, com: Float[Array, "n 3"]) -> float:
    """Return the rate of the pendulum [1/s]."""
    return float(np.sqrt(GRAVITY / np.mean(record.ground.gap(com))))


def _set_down(sites: tuple[ContactSite, ...], load: Float[Array, "n k"], weight: float) -> None:
    """Let feet that swing in the last instant carry load there [N]."""
    for own in (np.array([s.side == side for s in sites]) for side in SIDES):
        if not load[-1, own].any():
            load[-1, own] = weight / (2 * own.sum())


def _torques(record: Record, time: Float[Array, " n"]) -> Float[Array, "n n_hinges"] | float:
    """Return the joint torques at some times; zero where they are not known [N m]."""
    if record.qfrc_actuator is None:
        return 0.0
    return np.nan_to_num(interpolate(time, record.motion.time, record.qfrc_actuator))[:, 6:]


def _fill_feet(rows: Instant, swept: Kinematics) -> None:
    """Set position and rotation of the feet, with their rates."""
    rows.foot_position, rows.foot_velocity = swept.foot_position, swept.foot_velocity
    rows.foot_acceleration = np.gradient(swept.foot_velocity, STEP, axis=0)
    rows.foot_rotation = swept.foot_rotation
    rows.foot_angular_velocity = swept.foot_angular_velocity
    rows.foot_angular_acceleration = np.gradient(swept.foot_angular_velocity, STEP, axis=0)


def _fill_com(
    rows: Instant, swept: Kinematics, force: Array, load: Array, mass: float, min_load: float
) -> None:
    """Set the centre of mass and the centre of pressure; that of the spheres from a load [N] on."""
    rows.com, rows.com_velocity = swept.com, swept.com_velocity
    if force.any():
        acceleration = force.sum(axis=1) / mass - [0.0, 0.0, GRAVITY]
    else:
        acceleration = np.gradient(swept.com_velocity, STEP, axis=0)
    rows.com_acceleration = acceleration
    cop = swept.com - acceleration * swept.com[:, 2:] / GRAVITY
    vertical = load.sum(axis=1)
    loaded = vertical > min_load
    moment = np.einsum("nk,nkc->nc", load, swept.contact_position)
    cop[loaded] = moment[loaded] / vertical[loaded, None]
    rows.cop = cop


def translation_of(layout: Layout) -> Float[Array, "n_columns 3"]:
    """Return how much of a translation of the world each column takes up: positions, all of it."""
    rows = rows_of(np.zeros((3, width_of(layout))), layout)
    for position in (rows.q[:, :3], rows.com, rows.cop):
        position[:] = np.eye(3)
    for position in (rows.foot_position, rows.contact_position):
        position[:] = np.eye(3)[:, None]
    return np.ascontiguousarray(rows.row.T)


def before(on: Bool[Array, "n k"], rows: int, *, periodic: bool) -> Bool[Array, "n k"]:
    """Return which spheres are in contact in a row or within some rows after it."""
    more = on[1 : rows + 1] if periodic else np.repeat(on[-1:], rows, axis=0)
    ahead = np.concatenate([on, more])
    return np.any([ahead[i : i + len(on)] for i in range(len(ahead) - len(on) + 1)], axis=0)


def period_of(
    record: Record, rest_speed: float = StepSettings.rest_speed
) -> tuple[float | None, Float[Array, " 3"]]:
    """Return the period of a motion that ends as it began, and how far it goes in it [s, m].

    A periodic motion begins and ends with the same posture and the same velocities, and moves; the
    period of any other motion is None.
    """
    m, none = record.motion, np.zeros(3)
    speed = float(np.linalg.norm(m.qvel[0, :3]))  # slow walks almost stop at times
    far = float(np.linalg.norm(m.qpos[-1, :2] - m.qpos[0, :2]))
    if speed < rest_speed and far <= rest_speed * m.duration:
        return None, none
    turned = 1.0 - abs(float(m.qpos[0, 3:7] @ m.qpos[-1, 3:7]))
    apart = np.abs(m.qpos[-1, 7:] - m.qpos[0, 7:]).max()
    faster = np.abs(m.qvel[-1] - m.qvel[0]).max()
    if max(turned, float(apart)) > 1e-4 or faster > 1e-2:
        return None, none
    return m.duration, m.qpos[-1, :3] - m.qpos[0, :3]
