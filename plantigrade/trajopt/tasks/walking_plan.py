r"""Where and when the feet stand in a walk, periodic or from and to standing.

Footprints lie to either side of a path, straight along x or turning at a constant rate; the
:math:`k`-th is :math:`k` step lengths along it and half a step width to its side. How a foot rolls
is in :class:`~plantigrade.trajopt.tasks.gait_parameters.GaitParameters`.

A walk from standing begins with both feet on the ground for :math:`2 \sqrt{l / g}`, two time
constants of the body as an inverted pendulum, while the weight shifts to the stance foot: 0.6 s for
an adult, about the measured time from the first change of the forces to the first foot off
[Breniere1986]_. The first and last swings are half as long as the others. The last foot is put down
flat next to the other, and both feet rest for the same time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import word
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.tasks.gait_parameters import GaitParameters
from plantigrade.trajopt.tasks.task_settings import Side

End = Literal["standing", "walking"]
MAX_TURN_PER_STEP = float(np.deg2rad(60.0))  # [rad] maximum turn between consecutive steps
MAX_STEP_RISE = 0.4  # [leg lengths] maximum step up or down


@dataclass(frozen=True)
class _Fall:
    """A foot put down: when [s], how far along the way [m], which, and how wide and high [m]."""

    strike: float
    place: float
    side: str
    width: float
    height: float = 0.0


def walk_plan(
    human: Human,
    parameters: GaitParameters,
    *,
    steps: int,
    start: End = "standing",
    stop: End = "standing",
    first: Side = "r",
    turn: float = 0.0,
    heights: Sequence[float] | None = None,
    delays: Sequence[float] | None = None,
) -> ContactPlan:
    """Return the stances of a walk of some steps, beginning at the origin along x.

    A walk that starts ``"walking"`` does so as the ``first`` foot strikes next to the origin; one
    that stops ``"walking"`` does so at its last strike.

    Args:
        parameters: Lengths and times of the walk.
        steps: How many times a foot is put down, without the strike at the start of a walk that
            begins walking; at least 2 from standing to standing.
        first: The foot that steps first, or that strikes as the walk begins.
        turn: Change of heading from the first to the last footprint, to the left positive [rad].
        heights: Ground below each of the steps [m], level where each foot stands; the ground is at
            zero before. A stair of three 15 cm steps up: ``(0.15, 0.30, 0.45, 0.45)``.
        delays: How much longer than usual each of the steps lasts [s]; its swing is longer by that.

    Raises:
        ParameterError: If a value is out of range.
    """
    p = parameters
    _check(steps, start, stop, first, heights)
    rest = 2.0 * float(np.sqrt(p.leg_length / p.gravity))  # [s] on both feet, before and after
    late = np.zeros(steps) if delays is None else np.asarray(delays, float)
    still, closing = start == "standing", stop == "standing"
    begin = rest + p.swing_time if still else p.step_time
    falls = _falls(human, p, begin, late, first, heights, still=still, closing=closing)
    distance = falls[-1].place
    _check_way(falls[1:], distance, turn, p)
    duration = falls[-1].strike + (rest if closing else 0.0)
    bend = turn / distance if distance > 0 else 0.0
    stances = []
    for k, fall in enumerate(falls):
        strike, following = fall.strike, max(k - 1, 0)  # the step of the other foot meanwhile
        longer = float(late[following]) if following < steps else 0.0
        flat, heel, forefoot, off = _walking_times(p, strike, longer)
        if still and k < 2:
            strike = flat = 0.0
            off = rest if k == 1 else begin + float(late[0]) + p.double_support
            heel = off - (p.stance_fraction - p.heel_off) * p.stride_time
            forefoot = off - (p.stance_fraction - p.forefoot_off) * p.stride_time
            if k == 1:
                heel = max(heel, 0.5 * rest)
                forefoot = max(forefoot, heel)
        if closing and k >= len(falls) - 2:
            heel = forefoot = off = duration
            flat = strike if k == len(falls) - 1 else flat
        stances.append(Stance(_footprint(fall, p.toe_out, bend), strike, flat, heel, forefoot, off))
    return ContactPlan(duration, tuple(stances))


def _walking_times(p: GaitParameters, strike: float, longer: float) -> tuple[float, ...]:
    """Return when a foot is flat and heel, forefoot and foot leave, how much later [s]."""
    shares = p.foot_flat, p.heel_off, p.forefoot_off, p.stance_fraction
    flat, *leaving = (strike + x * p.stride_time for x in shares)
    return flat, *(t + longer for t in leaving)


def _falls(
    human: Human,
    p: GaitParameters,
    begin: float,
    late: Float[Array, " n_steps"],
    first: Side,
    heights: Sequence[float] | None,
    *,
    still: bool,
    closing: bool,
) -> list[_Fall]:
    """Return the feet as they are put down; the first two stand, or struck, as the walk begins."""
    standing_width, steps = standing_distance(human), len(late)
    sides = first, opposite(first)
    width = standing_width if still else p.step_width
    falls = [
        _Fall(0.0, 0.0, sides[1], width)
        if still
        else _Fall(-p.step_time, -p.step_length, sides[1], width),
        _Fall(0.0, 0.0, first, width),
    ]
    for k in range(steps):
        place = (k if closing and k == steps - 1 else k + 1) * p.step_length
        width = standing_width if closing and k >= steps - 2 else p.step_width
        height = 0.0 if heights is None else float(heights[k])
        strike = begin + k * p.step_time + float(late[: k + 1].sum())
        falls.append(_Fall(strike, place, sides[(k + 1 - still) % 2], width, height))
    return falls


def periodic_walk_plan(human: Human, parameters: GaitParameters) -> ContactPlan:
    """Return the stances of half a stride of a periodic walk along x.

    It lasts from right to left heel strike and continues as its mirror image, a step further; both
    stances extend beyond it.
    """
    plan = walk_plan(human, parameters, steps=1, start="walking", stop="walking", first="r")
    behind, ahead = plan.stances[:2]
    advance = ahead.footprint.position[0] - behind.footprint.position[0]
    return ContactPlan(parameters.step_time, (behind, ahead), periodic=True, advance=advance)


def standing_distance(human: Human) -> float:
    """Return how far apart the ankles are in a person's quiet standing [m]."""
    origins = human.skeleton.origins
    return float(abs(origins["foot_l"][1] - origins["foot_r"][1]))


def _footprint(fall: _Fall, toe_out: float, bend: float) -> Footprint:
    """Return a footprint next to the path that turns by ``bend`` [rad/m] from the origin on."""
    left = 1.0 if fall.side == "l" else -1.0
    heading = bend * max(fall.place, 0.0)
    if abs(heading) > 1e-12:
        x, y = np.sin(heading) / bend, (1.0 - np.cos(heading)) / bend
    else:
        x, y = fall.place, 0.0
    x -= np.sin(heading) * left * fall.width / 2
    y += np.cos(heading) * left * fall.width / 2
    return Footprint(fall.side, (float(x), float(y), fall.height), float(heading + left * toe_out))


def _check_way(falls: list[_Fall], distance: float, turn: float, p: GaitParameters) -> None:
    """Refuse a way that turns or climbs too much between two steps."""
    n_steps = max(distance / p.step_length, 1.0)
    if not abs(turn) <= MAX_TURN_PER_STEP * n_steps:
        raise ParameterError(
            f"a turn of {np.rad2deg(turn):.0f}° is {np.rad2deg(abs(turn)) / n_steps:.0f}° for each "
            f"step that goes on; allowed are {np.rad2deg(MAX_TURN_PER_STEP):.0f}°: take more steps"
        )
    for a, b in zip(falls[:-1], falls[1:], strict=True):
        if abs(b.height - a.height) > MAX_STEP_RISE * p.leg_length:
            raise ParameterError(
                f"the ground goes from {a.height:g} to {b.height:g} m in one step; a leg of "
                f"{p.leg_length:.2f} m steps {MAX_STEP_RISE * p.leg_length:.2f} m at most"
            )


def _check(steps, start, stop, first, heights) -> None:
    """Refuse settings that make no walk."""
    for name, value in (("start", start), ("stop", stop)):
        word(name, value, ("standing", "walking"))
    word("first", first, SIDES)
    least = 2 if start == stop == "standing" else 1
    if not (steps == int(steps) and steps >= least):
        raise ParameterError(f"{steps=}: a walk from {start} to {stop} takes at least {least}")
    if heights is not None:
        if len(heights) != steps:
            raise ParameterError(f"{len(heights)} heights for {steps} steps: give one for each")
        if not np.isfinite(heights).all():
            raise ParameterError("every height must be a finite number [m]")
