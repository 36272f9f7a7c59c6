"""Summary of a walk: speed, footsteps, path and changes of gait, in sentences and figures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.control.pendulum.path import Path, Waypoints
from plantigrade.world import Summary

MIN_SHORTENING = 0.01  # [m] shortening of a footstep from which it is reported, in cm


@dataclass(frozen=True)
class Footfall:
    """A touchdown, compared with the planned footstep."""

    time: float  #: When [s]
    side: str  #: Which foot
    error: float | None  #: Distance from the planned footstep [m]; None where none was planned
    #: Distance of that from the one of the landing law, which was out of reach [m]
    shortening: float


@dataclass(frozen=True)
class StyleChange:
    """A change from one walk to another."""

    name: str  #: Name of the other one
    time: float  #: When it began [s]
    foot: str  #: Stance foot; empty for both
    percent: float  #: Percentage of the stride, from the right foot's strike on


def walk_summary(
    footfalls: Sequence[Footfall],
    speed: float,
    recorded: float,
    lateral_offset: float,
) -> Summary:
    """Return the summary of a walk.

    Args:
        speed: Mean speed [m/s].
        recorded: That of the recording [m/s].
        lateral_offset: From the line of the walk at the end, to the left [m].
    """
    n, side = len(footfalls), "left" if lateral_offset > 0 else "right"
    errors = [each.error for each in footfalls if each.error is not None]
    median = float(np.median(errors)) if errors else None
    shortened = sum(each.shortening > MIN_SHORTENING for each in footfalls)
    figures = {
        "speed_m_s": speed,
        "recorded_speed_m_s": recorded,
        "aside_m": lateral_offset,
        "landings": n,
        **({} if median is None else {"landing_error_median_m": median}),
        "landings_shortened": shortened,
    }
    if not n:
        return Summary((), figures)
    off = "" if median is None else f", landing {100 * median:.1f} cm from the plan (median)"
    sentences = [
        f"The person walked at {speed:.2f} m/s, in the recording at {recorded:.2f} m/s, and ended "
        f"{100 * abs(lateral_offset):.0f} cm to the {side} of the straight line. "
        f"{n} step{'s' if n > 1 else ''}{off}."
    ]
    if shortened:
        sentences.append(f"Steps shortened to what the legs reach: {shortened}.")
    return Summary(tuple(sentences), figures)


def command_summary(
    speed: tuple[float, float] | None,
    deviation: float | None,
    stops: Sequence[tuple[float, float]],
    path: Path | None = None,
) -> tuple[str, ...]:
    """Return sentences on a commanded walk.

    Args:
        speed: AnyCommand speed at the end, and mean speed over a stride then [m/s]; None where none
            was commanded.
        deviation: Greatest distance from the path, over a stride [m]; None where it had none.
        stops: From when to when it stood [s].
    """
    sentences = []
    if speed is not None and speed[0] > 0.0:
        sentences.append(
            f"At the end the person walked at {speed[1]:.2f} m/s; {speed[0]:.2f} m/s was commanded."
        )
    if deviation is not None:
        sentences.append(f"The person kept within {100 * deviation:.0f} cm of the path.")
    if isinstance(path, Waypoints) and (points := len(path.points) - 1) > path.passed:
        sentences.append(
            f"The person did not reach the end of the path: {path.passed} of {points} points "
            "passed."
        )
    sentences += [f"The person stood from {start:.1f} to {end:.1f} s." for start, end in stops]
    return tuple(sentences)


def style_summary(changes: Sequence[StyleChange], error: float) -> tuple[str, ...]:
    """Return sentences on changes of gait.

    Args:
        changes: The changes, in order.
        error: Joint angle error after the last one, root mean square [rad].
    """
    sentences = []
    for each in changes:
        foot = {"r": "the right foot", "l": "the left foot"}.get(each.foot)
        where = f" on {foot}, at {each.percent:.0f} % of the stride" if foot else ", standing"
        sentences.append(f"Changed to {each.name} at {each.time:.2f} s{where}.")
    if sentences and np.isfinite(error):
        angle = f"joint angle error afterwards {np.rad2deg(error):.1f}°, RMS."
        sentences[-1] = f"{sentences[-1][:-1]}; {angle}"
    return tuple(sentences)
