"""Curves of a record over the gait cycle: angles, moments, powers, ground reactions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from plantigrade.analyze.foot_progression import MIN_DISPLACEMENT
from plantigrade.analyze.laboratory_angles import marker_angles
from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.motion import Table
from plantigrade.motion.cycles import PERCENT, Cycle, cut_cycles, frames_near, normalise_cycles
from plantigrade.record import Record
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import PELVIS, quaternion_to_pelvis_angles, turned

MAX_STRAIGHT_HEADING = np.deg2rad(10.0)
"""Maximum heading of a cycle along the forward axis of the laboratory [rad]."""
AXES = ("forward", "left", "up")
LOADED_JOINTS = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
"""Joints whose moments and powers are plotted and compared over the gait cycle."""


@dataclass(frozen=True)
class GaitCurves:
    """Curves by name, one row per cycle of their side (the right one for the midline)."""

    percent: Float[Array, " n_percent"]  #: Percent of the gait cycle
    cycles: tuple[Cycle, ...]  #: The cycles of both feet, by start
    #: Coordinate → angle [deg], including
    #: :func:`~plantigrade.analyze.laboratory_angles.marker_angles`
    angles: dict[str, np.ndarray]
    #: Coordinate → internal moment [N m/kg]; NaN if the force is unknown
    moments: dict[str, np.ndarray]
    powers: dict[str, np.ndarray]  #: Coordinate → power [W/kg]
    #: ``forward_r``, ``left_r``, ``up_r``, … → ground reaction [body weights]
    forces: dict[str, np.ndarray]

    def loads(self) -> dict[str, np.ndarray]:
        """Return moments and powers of :data:`LOADED_JOINTS`, and forces, by names of norms."""
        found = {
            f"{stem}{ending}_{side}": table[f"{stem}_{side}"]
            for ending, table in (("_moment", self.moments), ("_power", self.powers))
            for stem in LOADED_JOINTS
            for side in SIDES
            if f"{stem}_{side}" in table
        }
        for axis in ("up", "forward"):
            for side in SIDES:
                if f"{axis}_{side}" in self.forces:
                    found[f"ground_force_{axis}_{side}"] = self.forces[f"{axis}_{side}"]
        return found


def coordinates_of(record: Record) -> Table:
    """Return OpenSim's coordinates of a record [rad, m], pelvis first."""
    names, values = record.human.to_coordinates(record.motion.qpos)
    return Table(names, record.motion.time, values)


def pelvis_cycles(
    record: Record, cycles: Sequence[Cycle]
) -> dict[str, Float[Array, "n_cycles n_percent"]]:
    """Return tilt, list and rotation of the pelvis over cycles [deg], by coordinate.

    They refer to the axes of the laboratory, or to the direction of walking if the heading of a
    cycle exceeds :data:`MAX_STRAIGHT_HEADING`, as in a turn.
    """
    time, qpos = record.motion.time, record.motion.qpos
    straight = coordinates_of(record).values[:, :3]
    rows = np.rad2deg(normalise_cycles(time, straight, cycles))
    for k, cycle in enumerate(cycles):
        start, stop = (int(np.argmin(np.abs(time - t))) for t in (cycle.start, cycle.stop))
        x, y = qpos[stop, :2] - qpos[start, :2]
        heading = float(np.arctan2(y, x)) if np.hypot(x, y) > MIN_DISPLACEMENT else 0.0
        if abs(heading) > MAX_STRAIGHT_HEADING:
            near = frames_near(time, cycle)
            values = quaternion_to_pelvis_angles(turned(qpos[near, 3:7], -heading))
            values[:, 2] -= 2.0 * np.pi * np.round(values[start - near.start, 2] / (2.0 * np.pi))
            rows[k] = np.rad2deg(normalise_cycles(time[near], values, [cycle])[0])
    return {name: rows[:, :, i] for i, name in enumerate(PELVIS[:3])}


def gait_curves(
    record: Record,
    *,
    estimated: bool = False,
    keep_incomplete: bool = False,
    side: str | None = None,
) -> GaitCurves:
    """Return the curves of a record over its gait cycles; empty if it has none.

    Args:
        estimated: Whether estimated forces, and moments and powers by them, are included.
        keep_incomplete: Whether cycles with less than half of their samples known are included, NaN
            where unknown.
        side: Side to which the curves are restricted, with those of the midline over its cycles;
            both if absent.
    """
    motion = record.motion
    cycles, middle = cut_cycles(motion.events), side or "r"
    sides = SIDES if side is None else (side,)

    def included(name: str) -> bool:
        return (split_side(name)[1] or middle) in sides

    def known_rows(rows: np.ndarray) -> np.ndarray:
        if keep_incomplete or not len(rows):
            return rows
        return rows[np.isfinite(rows).mean(axis=1) > 0.5]

    def over(signals: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return signals over the cycles of their sides; those of one side share their splines."""
        found: dict[str, np.ndarray] = dict.fromkeys(signals, np.empty(0))
        for own in SIDES:
            names = [n for n in signals if (split_side(n)[1] or middle) == own]
            if names:
                mine = [c for c in cycles if c.side == own]
                stacked = np.stack([signals[n] for n in names], axis=1)
                rows = normalise_cycles(motion.time, stacked, mine)
                found |= {n: known_rows(rows[:, :, k]) for k, n in enumerate(names)}
        return found

    table = coordinates_of(record)
    hinges = [n for n in table.names if n not in PELVIS and included(n)]
    angles = over({n: np.rad2deg(table[n]) for n in hinges})
    pelvis = pelvis_cycles(record, [c for c in cycles if c.side == middle])
    angles |= {name: known_rows(rows) for name, rows in pelvis.items()}
    shown = marker_angles(record) if cycles else None
    if shown is not None:
        angles |= over({n: np.rad2deg(shown[n]) for n in shown.names if included(n)})
    if nothing_measured(record) and not estimated:
        return GaitCurves(PERCENT, cycles, angles, {}, {}, {})
    names = list(filter(included, record.human.coordinates))
    loads = _loads(record, cycles, sides, names, estimated)
    return GaitCurves(PERCENT, cycles, angles, *map(over, loads))


def _loads(
    record: Record,
    cycles: tuple[Cycle, ...],
    sides: Sequence[str],
    names: Sequence[str],
    estimated: bool,
) -> tuple[dict[str, Array], dict[str, Array], dict[str, Array]]:
    """Return moments and powers of coordinates and ground reactions over time, where known."""
    forces: dict[str, Array] = {}
    swing = {s: _unloaded_swing(record, cycles, s, estimated) for s in sides}
    moments, powers = joint_loads(record, names, estimated=estimated, unloaded=swing)
    if record.contact_force is not None:
        for foot in (s for s in sides if any(site.side == s for site in record.sites)):
            known_here = known(record, foot, estimated=estimated)
            known_here[swing[foot]] = 1.0
            share = record.foot(foot).force * known_here[:, None] / record.weight
            forces |= {f"{a}_{foot}": x for a, x in zip(AXES, share.T, strict=True)}
    return moments, powers, forces


def joint_loads(
    record: Record,
    names: Sequence[str],
    *,
    estimated: bool,
    unloaded: Mapping[str, Bool[Array, " n_frames"]] = MappingProxyType({}),
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return moments [N m/kg] and powers [W/kg] of coordinates over time, by name.

    They are NaN where the forces they depend on are unknown; without torques there are none.

    Args:
        record: The record.
        names: The coordinates.
        estimated: Whether estimated forces count.
        unloaded: Side → frames in which its foot is known to bear nothing.
    """
    moments: dict[str, Array] = {}
    powers: dict[str, Array] = {}
    for name in () if record.qfrc_actuator is None else names:
        there = known_above(record, name, estimated=estimated)
        there[unloaded.get(split_side(name)[1], slice(0))] = 1.0
        moments[name] = there * record.torque(name) / record.human.mass
        powers[name] = moments[name] * record.motion.velocity(name)
    return moments, powers


def _unloaded_swing(
    record: Record, cycles: tuple[Cycle, ...], side: str, estimated: bool
) -> np.ndarray:
    """Return the frames from toe-off to heel strike of a foot without measured force.

    The force is zero there by definition of heel strike, even if the low heel could touch the
    ground off the plates.
    """
    time, inside = record.motion.time, np.zeros(record.motion.n_frames, dtype=bool)
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    for cycle in cycles:
        if cycle.side == side and cycle.toe_off is not None:
            inside |= (time > cycle.toe_off) & (time < cycle.stop + step)
    foot = record.foot(side)
    measured = foot.known if estimated else foot.measured
    return inside & ~(np.any(foot.force, axis=1) & measured)


def nothing_measured(record: Record) -> bool:
    """Return whether all forces of a record were estimated."""
    measured = record.signals.get("forces.measured")
    return measured is not None and not measured.any()


def known(
    record: Record, side: str | None, *, estimated: bool = False
) -> Float[Array, " n_frames"]:
    """Return 1 where the forces on a foot, or on both if ``side`` is None, are known, else NaN.

    Estimated forces count only if ``estimated``.
    """
    mine = [k for k, s in enumerate(record.sites) if side in (None, s.side)]
    return _known(record, mine, estimated)


def known_above(
    record: Record, joint: str, *, estimated: bool = False
) -> Float[Array, " n_frames"]:
    """Return 1 where the forces that a joint's moment depends on are known, else NaN.

    They are the forces on segments distal to the joint: those under a leg for its joints, none for
    trunk and arms. Estimated forces count only if ``estimated``.
    """
    model = record.human.model
    moved = int(model.joint(joint).bodyid[0])
    mine = []
    for k, site in enumerate(record.sites):
        body = record.human.body(site.body)
        while body > moved:  # parents come before their children
            body = model.body_parentid[body]
        if body == moved:
            mine.append(k)
    return _known(record, mine, estimated)


def _known(record: Record, sites: list[int], estimated: bool) -> Float[Array, " n_frames"]:
    there = np.ones(record.motion.n_frames, dtype=bool)
    if record.contact_known is not None:
        there &= record.contact_known[:, sites].all(axis=1)
    measured = record.signals.get("forces.measured")
    if measured is not None and not estimated:
        sides = [SIDES.index(record.sites[k].side) for k in sites if record.sites[k].side in SIDES]
        there &= measured[:, sides].all(axis=1)
    return np.where(there, 1.0, np.nan)
