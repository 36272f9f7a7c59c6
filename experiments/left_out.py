"""Forces without plates with one source of recordings left out when constants are settled.

The curves of :class:`~plantigrade.dynamics.force_scales.UsualStance` are measured again on the
plates of all other sources, the factors of the bands are set to what 90 % of their measured values
need, and the recordings of the source left out are estimated with them. Scales of the program and
spreads of the curves stay as shipped: they were chosen by hand on the settled half.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.force_figures import FORCES, MOMENTS
from experiments.table import Row, sheet
from plantigrade.analyze.gait_forces import STANCE_LOAD, ForceComparison, compare_forces
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.force_scales import LEAN, PHASE, ForceScales, UsualStance
from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.loading import find_loading, usual_length
from plantigrade.dynamics.required_forces import RequiredForces, required_forces
from plantigrade.kinematics.ground_level import moving_ground

SOURCES = {
    "HC032": "HC032",
    "HC038": "HC038",
    "opensim_walking2": "opensim_walking2",
    "gaitalytics": "gaitalytics",
    "Rajagopal": "rajagopal_walk",
    "gait2392": "gait2392",
}
"""Source of walks → part of the names of its recordings."""
COMPARED_FIGURES = (FORCES[0], FORCES[1], FORCES[2], FORCES[7], MOMENTS[0], MOMENTS[2], MOMENTS[4])
LEFT_OUT = "left out, "
CURVES = ("cop_forward", "cop_outward", "force_inward", "rear_share", "roll_over")
COVERAGE_FIGURE = "measured values in the 90 % bands"
LEAST_COVERAGE_FIGURE = "least of a quantity"
WIDTHS = tuple(float(w) for w in np.round(np.arange(0.5, 2.05, 0.05), 2))
"""Widths of bands over the shipped ones [1]."""
BAND_LEVEL = 90.0  # measured values that a band is to hold [%]
MIN_POINTS = 3  # frames near a point of a curve [1]


@dataclass(frozen=True)
class Measured:
    """What plates show of the curves in one recording: place on the curve and value of frames."""

    of: Mapping[str, tuple[Array, Array]]


def measured(trial: Trial) -> Measured:
    """Return what the withheld plates of a walk show of each curve."""
    assert trial.withheld is not None
    human, motion, (forces, _) = trial.fit.human, trial.motion, trial.withheld
    assert motion.qacc is not None
    contacts = find_loading(human, motion).contacts
    needs = required_forces(human, motion, motion.qacc, contacts)
    usual, length = usual_length(contacts), human.dimensions.foot_length
    load = forces.force[..., 2] / needs.weight
    known = np.asarray(forces.valid_side)
    found: dict[str, list[Array]] = {name: [] for name in CURVES}
    for each in (c for c in contacts if c.rolls and c.whole):
        k, outward = SIDES.index(each.side), -1.0 if each.side == "r" else 1.0
        here = np.asarray(each.frames(motion.time)) & known[:, k] & (load[:, k] > STANCE_LOAD)
        if not here.any():
            continue
        share = each.share(motion.time[here], usual)
        along, left = _from_ankle(needs, forces.point[here, k], here, k)
        inward = -outward * _sideways(needs, forces.force[here, k], here)
        found["cop_forward"].append(np.stack([share, along / length]))
        found["cop_outward"].append(np.stack([share, outward * left / length]))
        found["force_inward"].append(np.stack([share, inward / needs.weight]))
        found["roll_over"].append(np.stack([needs.lean[here, k], along / length]))
        for rear in contacts:
            if rear.side == each.side or not rear.start < each.start < rear.stop < each.stop:
                continue
            phase = (motion.time - each.start) / (rear.stop - each.start)
            both = (phase >= 0) & (phase <= 1) & known.all(axis=1)
            share = load[both, 1 - k] / np.maximum(load[both].sum(axis=1), STANCE_LOAD)
            found["rear_share"].append(np.stack([phase[both], share]))
    empty = np.empty((2, 0))
    joined = {n: np.concatenate([empty, *parts], axis=1) for n, parts in found.items()}
    return Measured({name: (x[0], x[1]) for name, x in joined.items()})


def settled(people: Sequence[Sequence[Measured]]) -> UsualStance:
    """Return the mean curves of people, each with the recordings of one.

    Where nobody shows a part of a curve, it is as shipped.
    """
    shipped, curves = UsualStance(), {}
    for name in CURVES:
        grid = np.array(LEAN if name == "roll_over" else PHASE)
        own = [_binned(grid, [each.of[name] for each in person]) for person in people]
        known = np.isfinite(own)
        total = np.where(known, own, 0.0).sum(axis=0)
        count = known.sum(axis=0)
        usual = np.array(getattr(shipped, name))
        mean = np.where(count > 0, total / np.maximum(count, 1), usual)
        curves[name] = tuple(mean.tolist())
    return replace(shipped, **curves)


def left_out_rows(trials: Mapping[str, Trial]) -> list[Row]:
    """Return figures of each source with constants of the others, and with the shipped ones.

    Args:
        trials: Recordings of walks, with their plates withheld.
    """
    sources = {
        source: {name: trial for name, trial in trials.items() if part in name}
        for source, part in SOURCES.items()
    }
    sources = {source: own for source, own in sources.items() if own}
    seen = {s: [measured(trial) for trial in own.values()] for s, own in sources.items()}
    shipped = {s: [compared(trial) for trial in own.values()] for s, own in sources.items()}
    rows = []
    for source, own in sources.items():
        others = [s for s in sources if s != source]
        curves = settled([seen[s] for s in others])
        found = [compared(trial, curves) for trial in own.values()]
        widths = _widths([shipped[s] for s in others])
        for prefix, those, width in (("", shipped[source], {}), (LEFT_OUT, found, widths)):
            for figure in COMPARED_FIGURES:
                value = float(np.mean([figure.of(each[1.0]) for each in those]))
                rows.append(Row(source, prefix + figure.name, value, figure.unit))
            inside = [_coverage([those], q, width.get(q, 1.0)) for q in those[0][1.0].covered]
            rows.append(Row(source, prefix + COVERAGE_FIGURE, float(np.nanmean(inside)), "%"))
            rows.append(Row(source, prefix + LEAST_COVERAGE_FIGURE, float(np.nanmin(inside)), "%"))
    return rows


def left_out_sheet(rows: Sequence[Row]) -> str:
    """Return the rows as a table: shipped beside left out, a line for each source."""
    values = {(row.subject, row.quantity): row.value for row in rows}
    names = [
        *((f.name, f.short, f.digits) for f in COMPARED_FIGURES),
        (COVERAGE_FIGURE, "in bands %", 0),
    ]
    names.append((LEAST_COVERAGE_FIGURE, "least %", 0))
    lines = []
    for source in dict.fromkeys(row.subject for row in rows):
        cells = [
            f"{values[source, name]:.{digits}f} {values[source, LEFT_OUT + name]:.{digits}f}"
            for name, _, digits in names
        ]
        lines.append((source, *cells))
    title = "Each source with shipped constants, and with those of all other sources"
    return sheet(title, ("", *(short for _, short, _ in names)), lines)


def compared(trial: Trial, curves: UsualStance | None = None) -> dict[float, ForceComparison]:
    """Return a walk's forces by usual curves against its plates, for bands of each width."""
    human, motion = trial.fit.human, trial.motion
    assert motion.qacc is not None
    if curves is not None:
        scales = replace(ForceScales.of(walks=True), usual=curves)
        ground = estimate_forces(human, motion, scales=scales)
        moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, ground.forces)
        trial = replace(trial, ground=ground, moments=moments)
    record, true = trial.record(), trial.measured
    assert true is not None
    belt = moving_ground(motion.time, trial.feet.heel, trial.feet.toe)
    found = {}
    for width in WIDTHS:
        wider = {n: width * x if n.endswith("band") else x for n, x in record.signals.items()}
        found[width] = compare_forces(replace(record, signals=wider), true, belt=belt)
    return found


def _widths(people: Sequence[Sequence[Mapping[float, ForceComparison]]]) -> dict[str, float]:
    """Return for each quantity the least width of its band that holds 90 % of what is measured."""
    return {
        q: next((w for w in WIDTHS if _coverage(people, q, w) >= BAND_LEVEL), WIDTHS[-1])
        for q in people[0][0][1.0].covered
    }


def _coverage(
    people: Sequence[Sequence[Mapping[float, ForceComparison]]], quantity: str, width: float
) -> float:
    """Return the mean coverage of people, each with some recordings [%]."""
    own = [np.nanmean([x[width].covered.get(quantity, np.nan) for x in each]) for each in people]
    return 100.0 * float(np.nanmean(own))


def _from_ankle(needs: RequiredForces, point: Array, here: Array, k: int) -> tuple[Array, Array]:
    """Return centres of pressure ahead and to the left of the ankle in the foot's heading [m]."""
    arm, heading = (point - needs.base[here, k])[:, :2], needs.heading[here, k]
    return (arm * heading).sum(axis=1), arm[:, 1] * heading[:, 0] - arm[:, 0] * heading[:, 1]


def _sideways(needs: RequiredForces, force: Array, here: Array) -> Array:
    """Return the force to the left of the way [N]."""
    ahead = needs.rotation[here, :2, 0].mean(axis=0)
    x, y = ahead / np.linalg.norm(ahead)
    return force[:, 1] * x - force[:, 0] * y


def _binned(grid: Array, parts: Sequence[tuple[Array, Array]]) -> Float[Array, " n"]:
    """Return mean values near the points of a curve; NaN where too few frames are."""
    place = np.concatenate([part[0] for part in parts])
    value = np.concatenate([part[1] for part in parts])
    nearest = np.rint(np.interp(place, grid, np.arange(len(grid)))).astype(int)
    inside = (place >= 1.5 * grid[0] - 0.5 * grid[1]) & (place <= 1.5 * grid[-1] - 0.5 * grid[-2])
    known = np.isfinite(value) & inside
    mean = np.full(len(grid), np.nan)
    for i in range(len(grid)):
        own = value[known & (nearest == i)]
        if len(own) >= MIN_POINTS:
            mean[i] = own.mean()
    return mean
