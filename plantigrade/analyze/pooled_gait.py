"""The gait of a person in one run or pooled over several trials, and its two sides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from plantigrade.analyze.clinical import known_curves
from plantigrade.analyze.curves import LOADED_JOINTS, gait_curves
from plantigrade.analyze.gait_profile import ANGLES
from plantigrade.arrays import Array
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.errors import ParameterError
from plantigrade.options import is_real
from plantigrade.record import Run

TRUNK = ("lumbar_extension", "lumbar_bending", "lumbar_rotation")
CURVES = (
    *(*ANGLES, "subtalar_angle", "mtp_angle", *TRUNK),
    *(f"{name}_moment" for name in LOADED_JOINTS),
    *("ground_force_up", "ground_force_forward"),
)
"""Names of the compared curves, without side."""
SYNTHESISED_KINDS = ("synthesize",)
"""Kinds of runs whose strides have no variability, because they are synthesised."""
MAX_HEIGHT_DIFFERENCE = 0.05
"""Difference of body heights above which trials are not of one person [m].
Chosen: above the error of a fit."""
Affected = Literal["right", "left"]


@dataclass(frozen=True)
class ComparedGait:
    """One of the compared gaits: of one run, or pooled over trials of one person."""

    name: str  #: Name of the gait
    curves: Mapping[str, Array] = field(repr=False)  #: Curve → one row per cycle
    foot_off: Mapping[str, float]  #: Side → foot off, mean over trials [% of the cycle]
    exact: bool = False  #: Whether its strides have no variability, because it is synthesised
    #: Curve → trial of each row, counted from 0
    trials: Mapping[str, Array] = field(default_factory=dict, repr=False)
    runs: tuple[Run, ...] = field(default=(), repr=False)  #: The trials
    side: str = ""  #: ``"r"`` or ``"l"`` if it is one side, whose curves are named without it

    def figure(self, key: str) -> float | None:
        """Return a figure of the gait, the mean over its trials; None if no trial has it."""
        known = [float(v) for run in self.runs if is_real(v := run.figures.get(key))]
        return float(np.mean(known)) if known else None


def gait_of(run: Run, name: str) -> ComparedGait:
    """Return the gait of a run."""
    curves, loaded = gait_curves(run.record), gait_curves(run.with_forces)
    if not curves.cycles:
        raise ParameterError(
            f"{name} shows no complete gait cycle; runs are compared over the gait cycle, so give "
            "walks"
        )
    known = {
        n: v
        for n, v in known_curves(run.record, curves, loaded).items()
        if "_power_" not in n and (n[:-2] in ANGLES or np.nanmax(v) - np.nanmin(v) > 1e-6)
    }
    offs = {side: run.figures.get(f"stance_{side}_pct") for side in SIDES}
    return ComparedGait(
        name,
        known,
        {side: float(value) for side, value in offs.items() if isinstance(value, float)},
        run.kind in SYNTHESISED_KINDS,
        {n: np.zeros(len(rows), int) for n, rows in known.items()},
        (run,),
    )


def pooled(gaits: Sequence[ComparedGait], name: str) -> ComparedGait:
    """Return trials of one person as one gait, with the cycles of all of them.

    Curves that a trial lacks are those of the other trials.
    """
    if not gaits:
        raise ParameterError(f"{name}: there is no trial to pool")
    runs = tuple(run for gait in gaits for run in gait.runs)
    heights = [run.record.human.height for run in runs]
    if max(heights) - min(heights) > MAX_HEIGHT_DIFFERENCE:
        raise ParameterError(
            f"{name}: the trials have bodies of {min(heights):.2f} to {max(heights):.2f} m, but "
            "pooled trials must be of one person; fit them together with --subject one"
        )
    names = dict.fromkeys(n for gait in gaits for n in gait.curves)
    rows = {n: [(k, g.curves[n]) for k, g in enumerate(gaits) if n in g.curves] for n in names}
    offs = {s: [g.foot_off[s] for g in gaits if s in g.foot_off] for s in SIDES}
    return ComparedGait(
        name,
        {n: np.concatenate([values for _, values in each]) for n, each in rows.items()},
        {side: float(np.mean(values)) for side, values in offs.items() if values},
        all(gait.exact for gait in gaits),
        {n: np.repeat([k for k, _ in e], [len(v) for _, v in e]) for n, e in rows.items()},
        runs,
    )


def sides_of(
    gait: ComparedGait, affected: Affected | None = None
) -> tuple[ComparedGait, ComparedGait]:
    """Return the sides of a gait, as two gaits whose curves have no side.

    Args:
        affected: The affected side, which comes second; without it right comes first.
    """
    order = ("l", "r") if affected == "right" else SIDES
    found = []
    for k, side in enumerate(order):
        word = SIDE_NAMES[side]
        ending = f"_{side}"
        mine = {n[:-2]: rows for n, rows in gait.curves.items() if n.endswith(ending)}
        if not mine:
            raise ParameterError(
                f"{gait.name} shows no complete gait cycle of the {word} foot: its sides cannot be "
                "compared; name a second run"
            )
        name = word if affected is None else f"{('unaffected', 'affected')[k]} ({word})"
        found.append(
            replace(
                gait,
                name=name,
                curves=mine,
                foot_off={s: off for s, off in gait.foot_off.items() if s == side},
                trials={n[:-2]: t for n, t in gait.trials.items() if n.endswith(ending)},
                side=side,
            )
        )
    first, second = found
    return first, second
