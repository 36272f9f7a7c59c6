"""Step length, stance and heel rise of a walk as free times, around what people prefer."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.gait_parameters import FOOT_FLAT_SHARE, GaitParameters, ball_off


@dataclass(frozen=True)
class WalkingTimeBounds:
    """How far the search goes from what people prefer; chosen."""

    step_length: float = 0.15  #: Share of the step length [1]
    stance: float = 0.03  #: Share of the stride [1]
    heel_off: float = 0.06  #: Share of the stride [1]


def free_walking_times(
    p: GaitParameters, bounds: WalkingTimeBounds | None = None
) -> tuple[FreeTime, ...]:
    """Return step length [m], foot off and heel off [strides] as free times, by their names."""
    bounds = bounds or WalkingTimeBounds()
    around = {
        "step_length": (p.step_length, p.step_length * bounds.step_length),
        "stance_fraction": (p.stance_fraction, bounds.stance),
        "heel_off": (p.heel_off, bounds.heel_off),
    }
    return tuple(FreeTime(n, x - far, x + far, x) for n, (x, far) in around.items())


def with_walking_times(p: GaitParameters, times: Mapping[str, float]) -> GaitParameters:
    """Return a walk of the same speed at values of these times."""
    step, stance = times["step_length"], times["stance_fraction"]
    flat = FOOT_FLAT_SHARE * (stance - 0.5)
    return replace(
        p,
        step_length=step,
        step_time=step / p.speed,
        stance_fraction=stance,
        foot_flat=flat,
        heel_off=times["heel_off"],
        forefoot_off=ball_off(stance, flat),
    )
