"""What a walk was, in words and figures: how fast, how well feet landed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.control.pendulum.path import Path, Waypoints

SHORT = 0.01
"""A step counts as shortened where it is farther than this from where the law has it [m]."""


@dataclass(frozen=True)
class Landed:
    """How a foot came down.

    Attributes:
        time: When [s].
        side: Which foot.
        error: How far from the predicted place [m]; None where none was predicted.
        short: How far that was from where the law had it, for its being out of reach [m].
    """

    time: float
    side: str
    error: float | None
    short: float


@dataclass(frozen=True)
class Switched:
    """A walk that was changed into another one.

    Attributes:
        name: Of the other one.
        time: When that began [s].
        foot: Which foot stood; empty for both.
        percent: Of the stride, from the right foot's strike on.
    """

    name: str
    time: float
    foot: str
    percent: float


def walk_told(landings: Sequence[Landed], speeds: tuple[float, float, float]) -> tuple[str, ...]:
    """Return sentences on a walk.

    Args:
        landings: Of the feet.
        speeds: Mean speed, that of the recording [m/s], and how far aside it ended [m].
    """
    if not landings:
        return ()
    own, recorded, aside = speeds
    step, they = ("step", "it was") if len(landings) == 1 else ("steps", "they were")
    told = [
        f"Walked at {own:.2f} m/s, the recording at {recorded:.2f} m/s; ended "
        f"{100 * abs(aside):.0f} cm {'left' if aside > 0 else 'right'} of its line. "
        f"{len(landings)} {step}"
    ]
    off = [x.error for x in landings if x.error is not None]
    if off:
        middle = 100 * float(np.median(off))
        told[0] += f", in the median {middle:.1f} cm from where {they} predicted"
    told[0] += "."
    short = sum(x.short > SHORT for x in landings)
    if short:
        were = "was" if short == 1 else "were"
        told.append(f"{short} of them {were} shortened, since their place was out of reach.")
    return tuple(told)


def led_told(
    speed: tuple[float, float] | None,
    astray: float | None,
    stood: Sequence[tuple[float, float]],
    path: Path | None = None,
) -> tuple[str, ...]:
    """Return sentences on a walk that was led.

    Args:
        speed: What was wanted at the end, and what it was then, over a stride [m/s]; None where
            none was wanted.
        astray: How far it was beside its way at most, over a stride [m]; None where it had none.
        stood: From when to when it stood [s].
        path: Where it was led.
    """
    told = []
    if speed is not None and speed[0] > 0.0:
        told.append(f"At the end {speed[0]:.2f} m/s were wanted, and it walked at {speed[1]:.2f}.")
    if astray is not None:
        told.append(f"It kept within {100 * astray:.0f} cm of its way.")
    if isinstance(path, Waypoints) and (points := len(path.points) - 1) > path.passed:
        told.append(
            f"It did not come to the end of its way: points passed, {path.passed} of {points}."
        )
    for start, end in stood:
        told.append(f"It stood from {start:.1f} to {end:.1f} s.")
    return tuple(told)


def switched_told(switched: Sequence[Switched], off: float) -> tuple[str, ...]:
    """Return sentences on walks that were changed into others.

    Args:
        switched: What was changed.
        off: How far the joints were from the last one afterwards, root mean square [rad].
    """
    told = []
    for each in switched:
        on = {"r": "the right foot", "l": "the left foot"}.get(each.foot)
        where = f" on {on}, at {each.percent:.0f} % of the stride" if on else ", standing"
        told.append(f"Went over to {each.name} at {each.time:.2f} s{where}.")
    if told and np.isfinite(off):
        told[-1] = f"{told[-1][:-1]}; afterwards its joints were {np.rad2deg(off):.1f}° off, RMS."
    return tuple(told)


def walk_figures(
    landings: Sequence[Landed], speeds: tuple[float, float, float]
) -> dict[str, float]:
    """Return figures of a walk; see :func:`walk_told`."""
    own, recorded, aside = speeds
    off = [x.error for x in landings if x.error is not None]
    return {
        "speed_m_s": own,
        "recorded_speed_m_s": recorded,
        "aside_m": aside,
        "landings": len(landings),
        **({"landing_error_median_m": float(np.median(off))} if off else {}),
        "landings_shortened": sum(x.short > SHORT for x in landings),
    }
