"""Comparison of a reproduced gait with the recorded one: joint angles, feet, centre of mass.

The recorded motion is the record's reference ``"recorded"``, for the same person, soles and times.
The tasks track the compared quantities only in part: joint angles at a few instants, and no heights
of the feet.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.analyze.curves import PELVIS
from plantigrade.analyze.statistics import compare_curves
from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.contacts import MID_STANCE, foot_flat_time
from plantigrade.kinematics.sole_paths import SitePoints, SolePaths
from plantigrade.kinematics.state import sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.cycles import PERCENT, Cycle, cut_cycles, normalise
from plantigrade.motion.filters import interpolate
from plantigrade.ordered_tasks.phases import Phase
from plantigrade.record import Record
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles

ROTATIONS = (
    ("HIP R Flex/Exte", "hip_flexion_r"),
    ("HIP R Abdu/Aduc", "hip_adduction_r"),
    ("HIP R Axial rotation", "hip_rotation_r"),
    ("Knee R Flex/Exte", "knee_angle_r"),
    ("Ankle R Dors/Plan", "ankle_angle_r"),
    ("Ankle R Ever/Inve", "subtalar_angle_r"),
    ("Hip L Flex/Exte", "hip_flexion_l"),
    ("Hip L Abdu/Aduc", "hip_adduction_l"),
    ("Hip L Axial rotation", "hip_rotation_l"),
    ("Knee L Flex/Exte", "knee_angle_l"),
    ("Ankle L Dors/Plan", "ankle_angle_l"),
    ("Ankle L Ever/Inve", "subtalar_angle_l"),
)
"""Rows of Table I of [Boukheddimi]_ in order, with printed label and coordinate."""

TOUCH_HEIGHT = 0.002  # [m] maximum height of a point of the sole that has touched the ground
STANDING_HEIGHT = 0.005  # [m] maximum height of the lowest point of a foot in stance


@dataclass(frozen=True)
class Comparison:
    """Comparison of one reproduced gait with the recorded one.

    Cycles start at recorded heel strikes of the coordinate's side (the right one for pelvis and
    trunk), or of the other side if there is no complete cycle. Without any complete cycle curves
    are empty, and ranges, differences and correlations are over the whole motion.
    """

    percent: Float[Array, " n_percent"]  #: Percent of the gait cycle
    #: Coordinate → reproduced angle of each cycle [deg] (n_cycles, n_percent)
    curves_simulated: dict[str, np.ndarray] = field(repr=False)
    curves_reference: dict[str, np.ndarray] = field(repr=False)  #: The same as recorded
    #: Coordinate → range of motion, reproduced and recorded [deg], mean over the cycles
    rom: dict[str, tuple[float, float]] = field(repr=False)
    rmse: dict[str, float] = field(repr=False)  #: Coordinate → root mean square difference [deg]
    #: Coordinate → Pearson's r; NaN if one of them is constant
    correlation: dict[str, float] = field(repr=False)
    cycles: tuple[Cycle, ...]  #: Complete cycles of both feet
    #: Distance of the centre of mass from its recorded path at each tick [m]
    com_error: Float[Array, " n"] = field(repr=False)
    #: Largest horizontal displacement of any point of the soles since touchdown, within one
    #: contact [m]
    contact_drift_m: float
    lowest_m: float  #: Height of the lowest point of the soles [m]; negative below the ground
    #: Share of each foot's planned stance in which it is on the ground
    contact_share: float
    #: Side → minimum height of forefoot and toes in midswing (the middle third), reproduced and
    #: recorded [m], mean over the swings; NaN without swings
    clearance: dict[str, tuple[float, float]]
    #: Side → maximum knee flexion in swing, reproduced and recorded [deg], mean over the swings;
    #: NaN without swings
    swing_knee: dict[str, tuple[float, float]]
    #: Height of the lowest point of each foot, right and left, at each tick [m]
    soles: Float[Array, "n_ticks 2"] = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    #: The same as recorded
    soles_reference: Float[Array, "n_ticks 2"] = field(
        default_factory=lambda: np.zeros((0, 2)), repr=False
    )
    #: Side → time from heel strike to foot flat, reproduced and recorded [s], mean over the
    #: stances; NaN without stances
    foot_flat: dict[str, tuple[float, float]] = field(default_factory=dict)
    #: Point and time [s] of :attr:`contact_drift_m`
    contact_drift_at: tuple[str, float] = ("", 0.0)

    @property
    def com_error_max_m(self) -> float:
        """Largest distance of the centre of mass from its path [m]."""
        return float(self.com_error.max())

    @property
    def com_error_rms_m(self) -> float:
        """Root mean square distance of the centre of mass from its path [m]."""
        return root_mean_square(self.com_error)

    @property
    def rom_error(self) -> dict[str, float]:
        """Coordinate → reproduced minus recorded range of motion [deg]."""
        return {name: ours - theirs for name, (ours, theirs) in self.rom.items()}

    def metrics(self) -> dict[str, Any]:
        """Return flat figures with units, for the coordinates of Table I."""
        flat: dict[str, Any] = {}
        for _, name in ROTATIONS:
            if name not in self.rom:
                continue
            stem, side = name[:-2], name[-1]
            flat[f"{stem}_rom_{side}_deg"] = self.rom[name][0]
            flat[f"{stem}_rom_reference_{side}_deg"] = self.rom[name][1]
            flat[f"{stem}_rom_error_{side}_deg"] = self.rom_error[name]
            flat[f"{stem}_rmse_{side}_deg"] = self.rmse[name]
            flat[f"{stem}_correlation_{side}"] = self.correlation[name]
        errors = [abs(self.rom_error[name]) for _, name in ROTATIONS if name in self.rom]
        if errors:
            flat["rmse_max_deg"] = max(self.rmse[name] for _, name in ROTATIONS if name in self.rom)
            flat["rom_error_mean_deg"] = float(np.mean(errors))
            flat["rom_error_max_deg"] = float(np.max(errors))
        flat["com_error_max_mm"] = 1e3 * self.com_error_max_m
        flat["com_error_rms_mm"] = 1e3 * self.com_error_rms_m
        flat["contact_drift_max_mm"] = 1e3 * self.contact_drift_m
        flat["sole_lowest_mm"] = 1e3 * self.lowest_m
        flat["contact_share_pct"] = 100.0 * self.contact_share
        for side in SIDES:
            flat[f"toe_clearance_{side}_mm"] = 1e3 * self.clearance[side][0]
            flat[f"toe_clearance_reference_{side}_mm"] = 1e3 * self.clearance[side][1]
            flat[f"knee_swing_peak_{side}_deg"] = self.swing_knee[side][0]
            flat[f"knee_swing_peak_reference_{side}_deg"] = self.swing_knee[side][1]
            ours, theirs = self.foot_flat.get(side, (np.nan, np.nan))
            flat[f"foot_flat_{side}_ms"] = 1e3 * ours
            flat[f"foot_flat_reference_{side}_ms"] = 1e3 * theirs
            flat[f"cycles_{side}_count"] = sum(c.side == side for c in self.cycles)
        return {k: v for k, v in flat.items() if not (isinstance(v, float) and not np.isfinite(v))}


def compare(record: Record) -> Comparison:
    """Compare a reproduced gait with the recorded one.

    Args:
        record: The reproduced gait, with the recorded motion as a reference.

    Raises:
        ReproduceError: If there is no reference, fewer than two ticks, or a tick is not finite.
    """
    motion, recorded = record.motion, _recorded(record)
    human, phases = record.human, phases_of(record)
    names, ours = angles_deg(human, motion.qpos)
    _, theirs = angles_deg(human, recorded.qpos)
    first, last = motion.time[[0, -1]]
    step = motion.time[1] - first
    cycles = tuple(
        c for c in cut_cycles(motion.events) if c.start > first - step and c.stop < last + step
    )
    spans = {side: _spans(cycles, side, first, last) for side in SIDES}
    own = [spans[split_side(name)[1] or "r"] for name in names]
    simulated, reference = (
        {
            name: np.array([normalise(m.time, values[:, i], *span) for span in own[i]])
            for i, name in enumerate(names)
        }
        for m, values in ((motion, ours), (recorded, theirs))
    )
    agreement = {name: compare_curves(simulated[name], reference[name]) for name in names}
    com, soles = _com_and_soles(human, motion.qpos)
    com_recorded, soles_recorded = _com_and_soles(human, recorded.qpos)
    knees = {side: names.index(f"knee_angle_{side}") for side in SIDES}

    def swings(side, mine, their, what, margin=0.0):
        pairs = ((motion.time, mine), (recorded.time, their))
        ours, theirs = (over_swings(phases, side, t, x, what, margin) for t, x in pairs)
        return ours, theirs

    def flat(side):
        struck = [e.time for e in motion.events if e.kind == "heel_strike" and e.side == side]
        struck = [t for t in struck if first - step < t < last - MID_STANCE[1]]
        pairs = ((motion.time, soles), (recorded.time, soles_recorded))
        ours, theirs = (foot_flat_time(time, _forefoot(x, side), struck) for time, x in pairs)
        return ours, theirs

    return Comparison(
        percent=PERCENT,
        curves_simulated={n: a if cycles else a[:0] for n, a in simulated.items()},
        curves_reference={n: a if cycles else a[:0] for n, a in reference.items()},
        rom={n: (_range(simulated[n]), _range(reference[n])) for n in names},
        rmse={n: found.rmse for n, found in agreement.items()},
        correlation={n: found.correlation for n, found in agreement.items()},
        cycles=cycles,
        com_error=_path_error(motion.time, com, Trajectory(recorded.time, com_recorded)),
        **_contacts(record, soles),
        clearance={
            s: swings(s, _forefoot(soles, s), _forefoot(soles_recorded, s), np.min, 1 / 3)
            for s in SIDES
        },
        swing_knee={s: swings(s, ours[:, i], theirs[:, i], np.max) for s, i in knees.items()},
        foot_flat={side: flat(side) for side in SIDES},
        soles=_lowest(soles),
        soles_reference=interpolate(motion.time, recorded.time, _lowest(soles_recorded)),
    )


def _recorded(record: Record) -> Motion:
    """Return the recorded motion of a reproduced gait; raise if the two cannot be compared."""
    motion, recorded = record.motion, record.references.get("recorded")
    if recorded is None:
        raise ReproduceError("this record has no recorded motion as reference")
    if len(motion.time) < 2 or not np.isfinite(motion.qpos).all():
        raise ReproduceError(
            f"the reproduced motion has {len(motion.time)} ticks, "
            f"{np.count_nonzero(~np.isfinite(motion.qpos).all(axis=1))} of them not finite; "
            "a comparison needs at least two finite ones"
        )
    return recorded


def phases_of(record: Record) -> tuple[Phase, ...]:
    """Return the planned phases of gait of a record."""
    spans, kinds, swings = (record.signals.get(f"phase.{k}", ()) for k in ("span", "kind", "swing"))
    return tuple(
        Phase(float(span[0]), float(span[1]), str(kind), str(swing))
        for span, kind, swing in zip(spans, kinds, swings, strict=True)
    )


def angles_deg(
    human: Human, qpos: Float[Array, "n nq"]
) -> tuple[tuple[str, ...], Float[Array, "n n_angles"]]:
    """Return names and values of the pelvis angles and of all hinges [deg], without jumps."""
    pelvis = np.unwrap(quaternion_to_pelvis_angles(qpos[:, 3:7]), axis=0)
    return PELVIS[:3] + tuple(human.joint_names[1:]), np.rad2deg(np.hstack([pelvis, qpos[:, 7:]]))


def _spans(cycles, side: str, first: float, last: float) -> list[tuple[float, float]]:
    """Return the spans of a side's cycles, or of the other side's, or the whole motion."""
    mine = [c for c in cycles if c.side == side] or list(cycles)
    return [(max(c.start, first), min(c.stop, last)) for c in mine] or [(first, last)]


def _range(rows: Float[Array, "n n_percent"]) -> float:
    """Return the range of a curve, mean over its cycles."""
    return float(np.ptp(rows, axis=1).mean())


def _path_error(
    time: Float[Array, " n"], com: Float[Array, "n 3"], path: Trajectory
) -> Float[Array, " n"]:
    """Return the distance of the centre of mass from its path [m]."""
    desired = np.array([path(float(t))[0] for t in time])
    return np.linalg.norm(com - desired, axis=1)


def _com_and_soles(human: Human, qpos: Float[Array, "n nq"]) -> tuple[Array, SolePaths]:
    """Return centre of mass and soles over a motion, from one sweep."""
    sites = contact_sites(human)
    points = SitePoints(human, sites)
    com, position = np.empty((len(qpos), 3)), np.empty((len(qpos), len(sites), 3))
    for k, state in enumerate(sweep(human, qpos)):
        com[k], position[k] = state.com, state.position(points)
    position[..., 2] -= points.radius
    return com, SolePaths(sites, position)


def _contacts(record: Record, soles: SolePaths) -> dict[str, Any]:
    """Return drift, penetration and duration of the planned contacts."""
    planned = np.zeros(soles.position.shape[:2], dtype=bool)
    if record.contact_planned is not None:
        names = [site.name for site in record.sites]
        for k, sole in enumerate(soles.sites):  # a plan may name spheres without prefix, and seats
            own = [i for i, n in enumerate(names) if sole.name == n or sole.name.endswith(f"_{n}")]
            if own:
                planned[:, k] = record.contact_planned[:, own[0]]
    feet = [soles.of(side) for side in SIDES]
    spot = np.full((len(soles.sites), 2), np.nan)  # position of each point at touchdown
    drift, place, due, standing = 0.0, ("", float(record.motion.time[0])), 0, 0
    for now, point, on in zip(record.motion.time, soles.position, planned, strict=True):
        height = point[:, 2]
        spot[~on] = np.nan
        new = on & np.isnan(spot[:, 0]) & (height < TOUCH_HEIGHT)
        spot[new] = point[new, :2]
        touching = np.isfinite(spot[:, 0])
        if touching.any():
            way = np.linalg.norm(point[touching, :2] - spot[touching], axis=1)
            if way.max() > drift:
                drift = float(way.max())
                place = soles.sites[int(np.flatnonzero(touching)[np.argmax(way)])].name, float(now)
        for foot in feet:
            if on[foot].any():
                due += 1
                standing += bool(height[foot].min() < STANDING_HEIGHT)
    return {
        "contact_drift_m": drift,
        "contact_drift_at": place,
        "lowest_m": float(soles.position[..., 2].min()),
        "contact_share": standing / due if due else float("nan"),
    }


def _lowest(soles: SolePaths) -> Float[Array, "n 2"]:
    """Return the height of the lowest point of each foot [m]."""
    height = soles.position[..., 2]
    return np.stack([height[:, soles.of(side)].min(axis=1) for side in SIDES], axis=1)


def _forefoot(soles: SolePaths, side: str) -> Float[Array, " n"]:
    """Return the height of the lowest point of ball and toes of a foot [m]."""
    front = [i for region in ("ball", "toes") for i in soles.of(side, region)]
    return soles.position[:, front, 2].min(axis=1)


def over_swings(
    phases: Sequence[Phase],
    side: str,
    time: Float[Array, " n"],
    values: Float[Array, " n"],
    what: Callable[[np.ndarray], float],
    margin: float = 0.0,
) -> float:
    """Return the mean over the swings of a foot of a figure of each; NaN without swings.

    Args:
        time: Time of each value [s].
        what: Function from the values within a swing to a figure.
        margin: Share of the swing omitted at either end.
    """
    found = []
    for phase in phases:
        if phase.kind == "single" and phase.swing == side:
            cut = margin * phase.duration
            inside = (time >= phase.start + cut) & (time <= phase.stop - cut)
            if inside.any():
                found.append(what(values[inside]))
    return float(np.mean(found)) if found else float("nan")
