"""Ground that is given for a recording: a slope or steps, put below the feet that stand on it.

The shape is given: the inclination of a slope, the height of steps. The standing feet determine its
position: a foot stands while heel and ball rest together. The height of a slope is that of the feet
on it; the edge of a step lies next to the upper of two feet, which the lower one had to clear, or
at the end of the lower foot where the upper one overhangs.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.errors import FitError
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import MIN_REST_TIME, STILL_SPEED, point_speed
from plantigrade.models import Human
from plantigrade.motion.filters import runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import even_clock

MIN_STANDING = 2  # Fewest standing feet that determine the position of a given ground
MAX_RAMP_SLOPE = np.deg2rad(18)
"""Steepest slope [rad]; feet in a steeper line stand on steps. Laboratories build ramps up to 15°,
stairs are steeper than 25°."""
MAX_LINE_ERROR = 0.03
"""Largest distance of feet on one slope from a straight line, root mean square [m]."""
MIN_BELT_SLOPE = np.deg2rad(2.0)
"""Smallest inclination of a belt [rad]; soft tissue and shoes show 0.8° on level belts."""
SPHERE_TO_EDGE = 0.03
"""Distance from the outermost contact sphere of a foot to the edge of its step [m]: flesh, shoe."""
MIN_STEP_HEIGHT = 0.06  # [m] smallest difference of height between two levels


@dataclass(frozen=True)
class GivenGround:
    """Given ground of a recording."""

    shape: Ground  #: A slope, or steps of the height of the first one; its position is not used
    #: Where it rises, to the left from the axis of the laboratory that is nearest to where the
    #: person faces [rad]
    heading: float = 0.0


@dataclass(frozen=True)
class Standing:
    """Where feet stand, in axes of a ground whose height is zero, by place along x."""

    x: Float[Array, "n_stands 2"]  #: From the rear to the front end of each foot [m]
    #: Height of heel or ball above the plane, whichever is lower (people stand on tiptoe) [m]
    height: Float[Array, " n_stands"]
    slope: float  #: How far what they stand on rises while it moves, as a belt does [rad]


def standing_feet(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    slope: float = 0.0,
) -> Standing:
    """Return where the feet of a motion stand, each as often as it does.

    Args:
        time: Time of each frame [s].
        slope: Inclination of the plane above which heights are measured [rad].
    """
    soles = sole_paths(human, qpos, Ground(slope=slope))
    time = even_clock(time)
    way = moving_ground(time, *soles.ends)
    position = soles.position - way[:, None]
    places, heights, moves = [], [], np.zeros((0, 2))
    for side in SIDES:
        still, low = np.ones(len(time), dtype=bool), []
        for region in ("heel", "ball"):
            points = position[:, soles.of(side, region)]
            if not points.shape[1]:  # a foot of one segment without a ball
                continue
            still &= point_speed(time, points.mean(axis=1)) < STILL_SPEED
            low.append(points[..., 2].min(axis=1))
        own = position[:, soles.of(side)]
        for run in runs(still):
            if time[run.stop - 1] - time[run.start] >= MIN_REST_TIME:
                x = np.median(own[run, :, 0], axis=0)
                places.append([x.min(), x.max()])
                height = np.min([z[run] for z in low], axis=0)
                heights.append(float(np.median(height)))
                move = np.stack([soles.position[run, soles.of(side), 0].mean(axis=1), height], 1)
                moves = np.concatenate([moves, move - move.mean(axis=0)])
    order = np.argsort([p[0] for p in places]) if places else []
    along, up = moves.T
    rises = float(np.arctan2(along @ up, along @ along)) if len(moves) else 0.0
    return Standing(np.array(places).reshape(-1, 2)[order], np.array(heights)[order], rises)


def below_feet(
    shape: Ground, human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> Ground:
    """Return a ground of this shape where the feet of a motion stand on it.

    Args:
        shape: A slope, or steps of the height of the first one.
        time: Time of each frame [s].
        qpos: The motion, facing x.
    """
    feet = standing_feet(human, time, qpos, shape.slope)
    if len(feet.height) < MIN_STANDING:
        raise FitError(
            f"the feet stand still {len(feet.height)} times; {MIN_STANDING} are needed to place "
            "the given ground: leave out --ground, or record two steps"
        )
    if not shape.steps:
        height = float(np.median(feet.height))
        off = root_mean_square(feet.height - height)
        if off > MAX_LINE_ERROR:
            seems = suggested(human, time, qpos)
            remedy = f"they suggest {seems}" if seems else "on level ground leave out --ground"
            raise FitError(
                f"the feet do not stand on a slope of {np.rad2deg(shape.slope):g}°: they are "
                f"{100 * off:.0f} cm off it (root mean square), {100 * MAX_LINE_ERROR:.0f} cm are "
                f"allowed; {remedy}"
            )
        return replace(shape, height=height)
    rise = abs(shape.steps[0].height)
    low = float(feet.height.min())
    level = np.round((feet.height - low) / rise)
    base = float(np.median(feet.height - rise * level))
    found: list[GroundStep] = []
    for i, j in pairwise(range(len(level))):
        if level[i] == level[j]:
            continue
        rear, front = feet.x[i, 1], feet.x[j, 0]
        edge = (
            max(front - SPHERE_TO_EDGE, rear)
            if level[j] > level[i]
            else min(rear + SPHERE_TO_EDGE, front)
        )
        found.append(GroundStep(float(edge), base + rise * float(level[j])))
    if any(b.x < a.x for a, b in pairwise(found)):
        raise FitError(
            f"the feet do not stand on steps of {100 * rise:.0f} cm across the way: at one place "
            "they stand at different heights"
        )
    return Ground(base + rise * float(level[0]), steps=tuple(found), friction=shape.friction)


def suggested(
    human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> str:
    """Return options for the ground that a motion suggests; empty for level ground.

    Feet in line at different heights, or a belt that carries the feet down, suggest a slope; other
    feet suggest steps.

    Args:
        time: Time of each frame [s].
        qpos: The motion, facing x.
    """
    feet = standing_feet(human, time, qpos)
    if np.any(ground_velocity(time, *sole_paths(human, qpos).ends)):
        return _sloping(feet.slope) if abs(feet.slope) > MIN_BELT_SLOPE else ""
    if len(feet.height) < MIN_STANDING or np.ptp(feet.height) < MIN_STEP_HEIGHT:
        return ""
    x = feet.x.mean(axis=1)
    line = np.polyfit(x, feet.height, 1) if np.ptp(x) > 0.3 else None
    words = []
    if line is not None and abs(np.arctan(line[0])) < MAX_RAMP_SLOPE:
        off = feet.height - np.polyval(line, x)
        if root_mean_square(off) < MAX_LINE_ERROR:
            words.append(_sloping(float(np.arctan(line[0]))))
    levels = np.sort(feet.height)
    jumps = np.diff(levels)[np.diff(levels) > MIN_STEP_HEIGHT]
    if len(jumps):
        rise = float(np.median(jumps))
        words.append(f"--ground steps:{100 * rise:.0f}")
    return " or ".join(word for word in words if word)


def _sloping(slope: float) -> str:
    """Return the option for a slope, to half a degree; empty for a level one."""
    degrees = np.round(2 * np.rad2deg(slope)) / 2
    return f"--ground slope:{degrees:g}" if degrees else ""
