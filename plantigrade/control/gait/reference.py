"""A recorded motion as tables on an even grid: what a replay compares the present state with.

A periodic motion is repeated for ever, shifted by its own advance; any other one ends in its last
posture, at rest. Everything is looked up by *phase*, the time of the motion itself.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import ContactSite
from plantigrade.control.gait.clearance import Clearance, held_out
from plantigrade.control.gait.edges import lifts
from plantigrade.control.gait.instant import (
    Instant,
    Layout,
    derivative_order,
    layout_of,
    rows_of,
    width_of,
)
from plantigrade.control.gait.offsets import offset_weights
from plantigrade.control.gait.person import world_sites
from plantigrade.control.gait.schedule import Schedule, Stance, carrying, settled, stances_of
from plantigrade.errors import ParameterError
from plantigrade.record import Record

STEP = 0.002
"""Of the grid [s]."""
AFTER = 4.0
"""So long after the end (or the second period) offsets of the feet are looked ahead [s]."""
HIGH, ROLLS = 0.05, 0.1
"""A foot this high carries nothing [m]; one that strikes or rolls off is fast for so long [s]."""
SOON = 0.08
"""So long before a point is to be down it may stay down that touches [s]."""
MOVING = 0.2
"""A motion whose ends are slower than this does not repeat itself [m/s]."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Tables of a motion.

    Attributes:
        table: One row an instant, :data:`STEP` apart.
        layout: Columns and shape of every field of an instant.
        translation: How much of a translation of the world each column takes up.
        schedule: Stances of the feet, and the share of the load that each carries.
        omega: Rate of the linear pendulum, from the mean height of the centre of mass [1/s].
        period: Of a periodic motion [s]; None otherwise.
        duration: Of the motion, or of one period [s].
        advance: How far a periodic motion goes in a period [m].
        ends: Whether it ends at rest.
    """

    table: Float[Array, "n_rows n_columns"]
    layout: Layout
    translation: Float[Array, "n_columns 3"]
    schedule: Schedule
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
    record: Record, clearance: Clearance | None = None, *, lands: bool = False
) -> Reference:
    """Return the tables of a motion.

    Forces and torques are taken where the record has them; without them the load is where the feet
    are on the ground.

    Args:
        record: The motion.
        clearance: How it is kept from passing through itself; left as it is if absent.
        lands: Whether a motion that was cut off in a step ends with that foot on the ground: one
            that swings for ever lets the body fall.

    Raises:
        ParameterError: If the motion has less than two frames.
    """
    motion, human = record.motion, record.human
    if motion.n_frames < 2 or motion.duration < 5 * STEP:
        raise ParameterError("a replay needs a motion of several frames")
    period, advance = period_of(record)
    n = int(np.ceil(motion.duration / STEP - 1e-6)) + 1
    time = np.minimum(motion.time[0] + STEP * np.arange(n), motion.time[-1])
    even = motion.at(time)
    qpos, qvel = even.qpos, even.qvel
    if clearance is not None:
        qpos = held_out(record, qpos, clearance)
    qacc = even.qacc if even.qacc is not None else np.gradient(qvel, STEP, axis=0)
    sites = world_sites(record)
    force = site_forces(record, sites, time)
    tau = np.zeros_like(qvel)
    if record.qfrc_actuator is not None:
        tau = np.nan_to_num(linear(motion.time, record.qfrc_actuator, time))
    ends = period is None and float(np.abs(qvel[-1]).max()) < MOVING
    swept = sweep_tables(record, sites, qpos, qvel)
    load = loads(record, sites, swept, force)
    if lands and period is None:
        for own in (np.array([s.side == side for s in sites]) for side in SIDES):
            if not load[-1, own].any():
                load[-1, own] = record.weight / (2 * own.sum())
    if record.ground.steps:
        lift_over_edges(record, sites, swept, load)
    total = force.sum(axis=1)
    known = bool(force.any())
    com_acceleration = np.gradient(swept["com_velocity"], STEP, axis=0)
    if known:
        com_acceleration = total / human.mass - [0.0, 0.0, GRAVITY]
    height = swept["com"] @ record.ground.normal - record.ground.under(swept["com"])
    omega = float(np.sqrt(GRAVITY / np.mean(height)))
    on = carrying(load, record.weight, STEP, periodic=period is not None)
    stances = stances_of(sites, on, STEP, period)
    schedule = schedule_of(stances, sites, on, load, omega, period, ends)
    pressure = swept["com"] - com_acceleration * swept["com"][:, 2:] / GRAVITY
    vertical = load.sum(axis=1)
    heavy = vertical > 0.1 * record.weight
    pressure[heavy] = np.einsum("nk,nkc->nc", load, swept["low"])[heavy] / vertical[heavy, None]
    layout = layout_of(qpos.shape[1], qvel.shape[1], len(sites))
    table = np.empty((n + ends, width_of(layout)))
    rows = rows_of(table[:n], layout)
    rows.q, rows.v, rows.a, rows.tau, rows.force = qpos, qvel, qacc, tau[:, 6:], force
    rows.com, rows.com_velocity = swept["com"], swept["com_velocity"]
    rows.com_acceleration, rows.cop = com_acceleration, pressure
    rows.foot_position, rows.foot_velocity = swept["foot"], swept["foot_velocity"]
    rows.foot_acceleration = np.gradient(swept["foot_velocity"], STEP, axis=0)
    rows.foot_rotation, rows.foot_angular_velocity = swept["turn"], swept["turn_velocity"]
    rows.foot_angular_acceleration = np.gradient(swept["turn_velocity"], STEP, axis=0)
    rows.contact = on
    rows.contact_soon = before(on, round(SOON / STEP), periodic=period is not None)
    rows.contact_position = swept["low"]
    if ends:  # then it stands still
        table[n] = np.where(derivative_order(layout) > 0, 0.0, table[n - 1])
    translation = translation_of(layout)
    return Reference(
        table, layout, translation, schedule, omega, period, motion.duration, advance, ends
    )


def translation_of(layout: Layout) -> Float[Array, "n_columns 3"]:
    """Return how much of a translation of the world each column takes up: positions, all of it."""
    rows = rows_of(np.zeros((3, width_of(layout))), layout)
    for position in (rows.q[:, :3], rows.com, rows.cop):
        position[:] = np.eye(3)
    for position in (rows.foot_position, rows.contact_position):
        position[:] = np.eye(3)[:, None]
    return np.ascontiguousarray(rows.row.T)


def before(on: Bool[Array, "n k"], rows: int, *, periodic: bool) -> Bool[Array, "n k"]:
    """Return what is down now or within so many rows.

    Args:
        on: What is down.
        rows: How many.
        periodic: Whether the last row is the first one again.
    """
    more = on[1 : rows + 1] if periodic else np.repeat(on[-1:], rows, axis=0)
    ahead = np.concatenate([on, more])
    return np.any([ahead[i : i + len(on)] for i in range(len(ahead) - len(on) + 1)], axis=0)


def period_of(record: Record) -> tuple[float | None, Float[Array, " 3"]]:
    """Return the period of a motion that ends as it began, and how far it goes in it [s, m].

    The frames of a periodic walk begin and end with the same posture and the same velocities; the
    period of any other motion is None.
    """
    m, none = record.motion, np.zeros(3)
    speed = float(np.linalg.norm(m.qvel[0, :3]))
    if speed < MOVING:
        return None, none
    turned = 1.0 - abs(float(m.qpos[0, 3:7] @ m.qpos[-1, 3:7]))
    apart = np.abs(m.qpos[-1, 7:] - m.qpos[0, 7:]).max()
    faster = np.abs(m.qvel[-1] - m.qvel[0]).max()
    if max(turned, float(apart)) > 1e-4 or faster > 1e-2:
        return None, none
    return m.duration, m.qpos[-1, :3] - m.qpos[0, :3]


def linear(time: Array, values: Array, at: Array) -> Array:
    """Return values at other times, in straight lines between the given ones."""
    flat = values.reshape(len(values), -1)
    found = np.stack([np.interp(at, time, column) for column in flat.T], axis=1)
    return found.reshape(len(at), *values.shape[1:])


def site_forces(record: Record, sites: tuple[ContactSite, ...], time: Array) -> Array:
    """Return the known force at each sphere at some times [N]; zero where it is not known.

    Sites of a plan carry the names of the spheres. Forces measured for a whole foot are not
    divided here: see :func:`loads`.
    """
    force = np.zeros((len(time), len(sites), 3))
    if record.contact_force is None:
        return force
    for i, site in enumerate(record.sites):
        own = [k for k, s in enumerate(sites) if s.name.endswith(site.name)]
        if own and not site.measured:
            force[:, own[0]] += linear(record.motion.time, record.contact_force[:, i], time)
    return np.nan_to_num(force)


def loads(
    record: Record, sites: tuple[ContactSite, ...], swept: dict[str, Array], force: Array
) -> Array:
    """Return how much each sphere carries, along the normal [N].

    Where forces are known only for a foot, measured or estimated, they go to its spheres that are
    near the ground and slow, or to the lowest. A foot of which nothing is known carries where its
    spheres are near and slow, and then what is left of the weight.
    """
    normal = record.ground.normal
    load = np.maximum(force @ normal, 0.0)
    if load.any():
        return load
    n = len(load)
    near = (swept["gap"] < NEAR) & (swept["site_speed"] < SLOW)
    own = [np.array([s.side == side for s in sites]) for side in SIDES]
    feet = np.stack([foot_load(record, side, n) for side in SIDES], axis=1)
    touches = np.stack([near[:, mine].any(axis=1) for mine in own], axis=1)
    unknown = np.isnan(feet)
    rest = record.weight - np.nansum(feet, axis=1)
    share = np.maximum(rest, LEAST * record.weight) / np.maximum((unknown & touches).sum(axis=1), 1)
    feet = np.where(unknown, touches * share[:, None], np.nan_to_num(feet))
    feet[feet < LIFTED * record.weight] = 0.0
    for i, side in enumerate(SIDES):
        if record.has_forces and not record.foot(side).measured.any():
            feet[_swings(swept["gap"][:, own[i]].min(axis=1), touches[:, i]), i] = 0.0
    for i, mine in enumerate(own):
        low = swept["gap"][:, mine]
        carries = near[:, mine] | (low <= low.min(axis=1)[:, None] + LEVEL)
        part = carries / carries.sum(axis=1, keepdims=True)
        load[:, mine] = part * feet[:, i : i + 1]
    return load


def _swings(gap: Array, touches: Array) -> Array:
    """Return when a foot swings, whatever load was estimated for it.

    Args:
        gap: Height of its lowest sphere [m].
        touches: Whether a sphere is near the ground and slow.
    """
    return (gap > HIGH) | ~settled(touches, round(ROLLS / STEP))


def foot_load(record: Record, side: str, n: int) -> Float[Array, " n"]:
    """Return what is known of the load of a foot, measured or estimated; NaN where nothing is."""
    motion, normal = record.motion, record.ground.normal
    time = motion.time[0] + np.minimum(STEP * np.arange(n), motion.duration)
    known = np.zeros(motion.n_frames, dtype=bool)
    load = np.zeros(motion.n_frames)
    if record.has_forces:
        foot = record.foot(side)
        known, load = foot.known.copy(), foot.force @ normal
    told = record.signals.get("estimated.force")
    if told is not None:
        guess = told[:, SIDES.index(side)] @ normal
        fill = ~known & np.isfinite(guess)
        load, known = np.where(fill, guess, load), known | fill
    found = np.interp(time, motion.time, np.maximum(np.nan_to_num(load), 0.0))
    found[np.interp(time, motion.time, known.astype(float)) < 0.999] = np.nan
    return found


LEAST, LIFTED, LEVEL = 0.2, 0.03, 0.005
"""A foot of which nothing is known and that touches carries this part of the weight at least; one
that carries less than that part is in the air; spheres this near to the lowest carry too [m]."""
NEAR, SLOW = 0.02, 0.4
"""A sphere this near to the ground [m] and this slow [m/s] carries, where nobody says."""


def sweep_tables(record: Record, sites, qpos: Array, qvel: Array) -> dict[str, Array]:
    """Return places and velocities of the centre of mass, the feet and the spheres."""
    human, ground, n, k = record.human, record.ground, len(qpos), len(sites)
    model = human.model
    data = mujoco.MjData(model)
    feet = [human.body(f"foot_{side}") for side in SIDES]
    body = np.array([human.body(s.body) for s in sites])
    local = np.array([s.position for s in sites])
    radius = np.array([s.radius for s in sites])
    out = {
        "com": np.empty((n, 3)),
        "com_velocity": np.empty((n, 3)),
        "foot": np.empty((n, 2, 3)),
        "foot_velocity": np.empty((n, 2, 3)),
        "turn": np.empty((n, 2, 3, 3)),
        "turn_velocity": np.empty((n, 2, 3)),
        "low": np.empty((n, k, 3)),
    }
    speed = np.empty(6)
    for i in range(n):
        data.qpos[:], data.qvel[:] = qpos[i], qvel[i]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_subtreeVel(model, data)
        out["com"][i], out["com_velocity"][i] = data.subtree_com[1], data.subtree_linvel[1]
        for side, foot in enumerate(feet):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, foot, speed, 0)
            out["foot"][i, side], out["turn"][i, side] = (
                data.xpos[foot],
                data.xmat[foot].reshape(3, 3),
            )
            out["foot_velocity"][i, side], out["turn_velocity"][i, side] = speed[3:], speed[:3]
        turn = data.xmat[body].reshape(-1, 3, 3)
        out["low"][i] = data.xpos[body] + np.einsum("kij,kj->ki", turn, local)
    level = np.array([s.side == "" for s in sites])[:, None]
    down = np.where(level, [0.0, 0.0, 1.0], ground.normal) * radius[:, None]
    out["low"] -= down
    out["gap"] = out["low"] @ ground.normal - ground.under(out["low"])
    out["gap"][:, level[:, 0]] = 0.0
    moving = np.gradient(out["low"], STEP, axis=0)
    out["site_speed"] = np.linalg.norm(moving, axis=2)
    return out


def lift_over_edges(record: Record, sites, swept: dict[str, Array], load: Array) -> None:
    """Lead swinging feet clear of the edges of steps."""
    stands = carrying(load, record.weight, STEP, periodic=False)
    for i, side in enumerate(SIDES):
        own = np.array([s.side == side for s in sites])
        lift = lifts(
            record.ground, swept["low"][:, own], np.asarray(stands[:, own].any(axis=1)), STEP
        )
        swept["foot"][:, i, 2] += lift
        swept["foot_velocity"][:, i, 2] += np.gradient(lift, STEP)


def schedule_of(
    stances: tuple[Stance, ...],
    sites,
    on: Bool[Array, "n k"],
    load: Float[Array, "n k"],
    omega: float,
    period: float | None,
    ends: bool,
) -> Schedule:
    """Return the schedule: of a periodic motion over several periods, of which one is used."""
    n = len(load)
    whole = n - 1 if period is not None else n
    if period is not None:
        tiles = 2 + int(np.ceil(AFTER / period))
        rows = np.concatenate([np.arange(whole)] * tiles)
        first = whole
    else:
        rows = np.concatenate([np.arange(n), np.full(int(AFTER / STEP), n - 1)])
        tiles, first = 1, 0
    per_foot = {
        side: load[rows][:, [s.side == side for s in sites]].sum(axis=1) for side in (*SIDES, "")
    }
    time = STEP * np.arange(len(rows))
    if period is not None:
        time = np.concatenate([STEP * np.arange(whole) + t * period for t in range(tiles)])
    found: list[Stance] = []
    for t in range(tiles):
        found += [s.later(t * (period or 0.0)) for s in stances]
    found.sort(key=lambda s: s.start)
    alpha = np.zeros((len(rows), len(found)))
    for j, stance in enumerate(found):
        during = (time >= stance.start - 1e-9) & (time <= stance.stop + 1e-9)
        alpha[during, j] = per_foot[stance.side][during]
    total = alpha.sum(axis=1, keepdims=True)
    alpha = np.divide(alpha, total, out=np.zeros_like(alpha), where=total > 1.0)
    beta = offset_weights(alpha, omega, STEP)
    return Schedule(
        tuple(found),
        alpha[first : first + n],
        beta[first : first + n],
        STEP,
        period,
        len(stances),
        first * STEP if period is None else period,
    )
