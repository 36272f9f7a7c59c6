"""A reproduced gait held against the recorded one: ranges of motion, curves, feet, centre of mass.

The recorded gait is the :class:`~plantigrade.reproduce.reference.Reference`, so both move the same
person on the same soles and the same clock. What is compared was tracked only in part: of the
joint angles the tasks know a few instants, of the feet's heights nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.analyze.curves import PELVIS, side_of
from plantigrade.analyze.statistics import correlation, rmse
from plantigrade.arrays import Array, Float
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.motion.cycles import PERCENT, Cycle, cut_cycles, normalise
from plantigrade.reproduce.gait import ContactSchedule
from plantigrade.reproduce.reference import SIDES, Reference
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles
from plantigrade.wbc.ordered_motion import OrderedMotion

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
"""Rows of Table I of [Boukheddimi]_, label as printed and our coordinate, in its order."""

SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")
TOUCHING = 0.002  # a point of the sole no higher than this has touched the ground [m]
STANDING = 0.005  # a foot whose lowest point is no higher than this stands on the ground [m]


@dataclass(frozen=True)
class Comparison:
    """One reproduced gait against the recorded one.

    Curves are cut at the recorded heel strikes of the coordinate's own side (pelvis and trunk: the
    right's); of the other side where the own has no whole cycle. Without any whole cycle they
    are empty, and ranges, differences and correlations are over the whole motion.

    Attributes:
        percent: Percent of the gait cycle.
        curves_simulated: Coordinate → reproduced angle of each cycle [deg] (n_cycles, n_percent).
        curves_reference: Likewise as recorded.
        rom: Coordinate → range of motion, reproduced and recorded [deg], mean over the cycles.
        rmse: Coordinate → root mean square difference [deg].
        correlation: Coordinate → Pearson's r; NaN where one of both does not move.
        cycles: The whole cycles, both feet.
        com_error_max_m: Largest distance of the centre of mass from its path [m].
        com_error_rms_m: Root mean square of it [m].
        contact_drift_m: Largest horizontal way of any point of the soles from where it first
            touched, during one unbroken contact [m].
        lowest_m: Height of the lowest point of the soles [m]; negative below the ground.
        contact_share: Share of each foot's planned stance in which it does stand on the ground:
            feet that never come down would not drift either.
        clearance: Side → least height of the forefoot and toes in mid swing (the middle third),
            reproduced and recorded [m], mean over the swings; NaN where none was seen.
        swing_knee: Side → greatest knee flexion in swing, reproduced and recorded [deg], mean over
            the swings; NaN where none was seen.
    """

    percent: Float[Array, " n_percent"]
    curves_simulated: dict[str, np.ndarray] = field(repr=False)
    curves_reference: dict[str, np.ndarray] = field(repr=False)
    rom: dict[str, tuple[float, float]] = field(repr=False)
    rmse: dict[str, float] = field(repr=False)
    correlation: dict[str, float] = field(repr=False)
    cycles: tuple[Cycle, ...]
    com_error_max_m: float
    com_error_rms_m: float
    contact_drift_m: float
    lowest_m: float
    contact_share: float
    clearance: dict[str, tuple[float, float]]
    swing_knee: dict[str, tuple[float, float]]

    @property
    def rom_error(self) -> dict[str, float]:
        """Coordinate → reproduced minus recorded range of motion [deg]."""
        return {name: ours - theirs for name, (ours, theirs) in self.rom.items()}

    def metrics(self) -> dict[str, Any]:
        """Return flat figures with units; of the coordinates those of Table I."""
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
            flat[f"cycles_{side}_count"] = sum(c.side == side for c in self.cycles)
        return {k: v for k, v in flat.items() if not (isinstance(v, float) and not np.isfinite(v))}


def compare(reference: Reference, motion: OrderedMotion) -> Comparison:
    """Hold a reproduced gait against the recorded one.

    Args:
        reference: The recorded gait.
        motion: The reproduced one, on the same clock.

    Raises:
        ReproduceError: If there is nothing to compare: fewer than two ticks, or not finite.
    """
    if len(motion.time) < 2 or not np.isfinite(motion.qpos).all():
        raise ReproduceError(
            f"the reproduced motion has {len(motion.time)} ticks, "
            f"{np.count_nonzero(~np.isfinite(motion.qpos).all(axis=1))} of them not finite; "
            "a comparison needs two finite ones or more"
        )
    names, ours = angles_deg(reference.human, motion.qpos)
    _, theirs = angles_deg(reference.human, reference.qpos)
    first, last = motion.time[[0, -1]]
    step = motion.time[1] - first
    cycles = tuple(
        c for c in cut_cycles(reference.events) if c.start > first - step and c.stop < last + step
    )
    spans = {side: _spans(cycles, side, first, last) for side in SIDES}
    simulated, recorded, rom, difference, r = {}, {}, {}, {}, {}
    for i, name in enumerate(names):
        mine = spans[side_of(name) or "r"]
        a, b = _cut(motion.time, ours[:, i], mine), _cut(reference.time, theirs[:, i], mine)
        rom[name] = (float(np.ptp(a, axis=1).mean()), float(np.ptp(b, axis=1).mean()))
        difference[name], r[name] = rmse(a, b), correlation(a, b)
        keep = len(a) if cycles else 0
        simulated[name], recorded[name] = a[:keep], b[:keep]
    return Comparison(
        percent=PERCENT,
        curves_simulated=simulated,
        curves_reference=recorded,
        rom=rom,
        rmse=difference,
        correlation=r,
        cycles=cycles,
        **_feet_and_com(reference, motion),
        clearance=_clearance(reference, motion),
        swing_knee={
            side: (
                over_swings(reference, side, motion.time, ours[:, names.index(knee)], np.max),
                over_swings(reference, side, reference.time, theirs[:, names.index(knee)], np.max),
            )
            for side, knee in ((s, f"knee_angle_{s}") for s in SIDES)
        },
    )


def angles_deg(
    human: Human, qpos: Float[Array, "n nq"]
) -> tuple[tuple[str, ...], Float[Array, "n n_angles"]]:
    """Return names and values of the pelvis angles and of all hinges [deg], without jumps."""
    pelvis = np.unwrap(quaternion_to_pelvis_angles(qpos[:, 3:7]), axis=0)
    return PELVIS[:3] + tuple(human.joint_names[1:]), np.rad2deg(np.hstack([pelvis, qpos[:, 7:]]))


def _spans(cycles, side: str, first: float, last: float) -> list[tuple[float, float]]:
    """Return the spans of a side's cycles; of the other side's, or the whole motion, failing it."""
    mine = [c for c in cycles if c.side == side] or list(cycles)
    return [(max(c.start, first), min(c.stop, last)) for c in mine] or [(first, last)]


def _cut(time, values, spans) -> np.ndarray:
    """Return a curve over each span on percent (n_spans, n_percent)."""
    return np.array([normalise(time, values, start, stop) for start, stop in spans])


def _feet_and_com(reference: Reference, motion: OrderedMotion) -> dict[str, float]:
    """Return how well contacts, the ground and the centre of mass were kept."""
    schedule = ContactSchedule(reference)
    state = State(reference.human, motion.qpos[0])
    spot = np.full((len(schedule.radius), 2), np.nan)  # where each point that touches did so first
    away, drift, lowest = [], 0.0, np.inf
    planned = standing = 0
    for time, qpos, qvel in zip(motion.time, motion.qpos, motion.qvel, strict=True):
        state.move_to(qpos, qvel)
        away.append(np.linalg.norm(state.com - reference.com(float(time))[0]))
        point = state.position(schedule.points)
        height = point[:, 2] - schedule.radius
        lowest = min(lowest, float(height.min()))
        on = schedule(float(time))
        spot[~on] = np.nan
        new = on & np.isnan(spot[:, 0]) & (height < TOUCHING)
        spot[new] = point[new, :2]
        held = np.isfinite(spot[:, 0])
        if held.any():
            way = np.linalg.norm(point[held, :2] - spot[held], axis=1)
            drift = max(drift, float(way.max()))
        for side in SIDES:
            foot = schedule.side == side
            if on[foot].any():
                planned += 1
                standing += bool(height[foot].min() < STANDING)
    return {
        "com_error_max_m": float(np.max(away)),
        "com_error_rms_m": float(np.sqrt(np.mean(np.square(away)))),
        "contact_drift_m": drift,
        "lowest_m": lowest,
        "contact_share": standing / planned if planned else float("nan"),
    }


def _clearance(reference: Reference, motion: OrderedMotion) -> dict[str, tuple[float, float]]:
    """Return the least height of each forefoot in mid swing, reproduced and recorded [m]."""
    ours = sole_paths(reference.human, motion.qpos)
    theirs = sole_paths(reference.human, reference.qpos)
    result = {}
    for side in SIDES:
        front = [i for region in ("ball", "toes") for i in ours.of(side, region)]
        low, low_recorded = (f.position[:, front, 2].min(axis=1) for f in (ours, theirs))
        result[side] = (
            over_swings(reference, side, motion.time, low, np.min, 1 / 3),
            over_swings(reference, side, reference.time, low_recorded, np.min, 1 / 3),
        )
    return result


def over_swings(
    reference: Reference,
    side: str,
    time: Float[Array, " n"],
    values: Float[Array, " n"],
    what: Callable[[np.ndarray], float],
    margin: float = 0.0,
) -> float:
    """Return a figure of each swing of a foot, mean over the swings; NaN where there is none.

    Args:
        reference: The recorded gait, for its phases.
        side: The foot.
        time: Time of each value [s].
        values: A signal.
        what: Makes one figure of the values within a swing.
        margin: Share of the swing left out at either end.
    """
    found = []
    for phase in reference.phases:
        if phase.kind == "single" and phase.swing == side:
            cut = margin * phase.duration
            inside = (time >= phase.start + cut) & (time <= phase.stop - cut)
            if inside.any():
                found.append(what(values[inside]))
    return float(np.mean(found)) if found else float("nan")
