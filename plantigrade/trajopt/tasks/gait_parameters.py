r"""How people walk at a speed: lengths, times and angles of a step, from published measurements.

With leg length :math:`l` (hip to ground) and dimensionless speed :math:`v^* = v / \sqrt{g l}`:

- **Step length** :math:`s / l = 1.16 \sqrt{v^*}`: step length over cadence is the same at all
  speeds, as in adults who walk over ground at more than 1 m/s [Murakami2017]_; their 62 m/min with
  98 steps/min are 1.16 for a leg of 0.93 m. Published laws disagree: :math:`(v^*)^{0.42}`
  [Kuo2001]_ gives shorter steps, by 6 % at 1.0 and 8 % at 1.3 m/s, as those of adults on treadmills
  [Fukuchi2018]_: 120 a minute at 1.3 m/s instead of 110. As the excursion of the centre of mass is
  the force's over the square of the cadence, it stays smaller than people's there.
  ``step_length`` gives others.
- **Gravity**: at a quarter of it and the same speed, people on a treadmill who are lifted at the
  trunk take steps that are 16 % shorter; stance follows from the dimensionless speed, because at
  equal ones people have nearly the same [Donelan1997]_.
- **Stance** as the fraction of the stride until foot off, by dimensionless speed
  [Schwartz2008]_: 68 % when very slow, 59 % at free speed, 56 % when very fast.
- **Step width** :math:`0.13\, l` between the ankles, preferred at 1.25 m/s [Donelan2001]_; walkway
  norms show no trend with speed, so it is taken as constant.
- **Toe-out** 5°: foot progression in mid-stance lies between 4° and 5.7° at all five speeds of
  [Schwartz2008]_.
- **Foot flat** two thirds through the first double support, 6 % of the stride at free speed
  (*estimate*; heel-only support lasts 6 to 12 % [Perry1992]_).
- **Heel off** at 56 % of stance: 33 % of the stride at free speed, settled with the weights of the
  walk; 31 % is published [Perry1992]_ and 32 % [Whittle2007]_, where the heel is seen to rise.
- **Ball off**, when only the toes are left [Perry1992]_: at 92 % of stance (*estimate*), or as the
  other foot gets flat where that is within 1 % of the stride, below 0.9 m/s: two changes of contact
  a few milliseconds apart are hard to solve.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.bounds import number
from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import CLASS_SPEEDS, FOOT_OFF
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.task_settings import MAX_WALKING_SPEED, MIN_WALKING_SPEED

STEP_TIMES = (0.15, 3.0)  # [s] minimum and maximum step time

STEP_LENGTH_COEFFICIENT = 1.16  # [leg lengths] step length at a dimensionless speed of 1
GRAVITY_EXPONENT = 0.126  # [1] of gravity in step length: at 0.25 g and equal speed, 16 % shorter
STEP_WIDTH_SHARE = 0.13  # [leg lengths] step width
TOE_OUT = float(np.deg2rad(5.0))
HEEL_OFF = 0.56  # [1] time of heel off relative to stance
FOOT_FLAT_SHARE = 2.0 / 3.0  # [1] time of foot flat relative to double support
FOREFOOT_OFF_SHARE = 0.92  # [1] time of forefoot off relative to stance
SIMULTANEOUS_SHARE = 0.01  # [1] interval of simultaneous contact changes relative to the stride
MAX_STEP_LENGTH = 1.15  # [leg lengths] maximum step length; legs 70° apart


@dataclass(frozen=True)
class GaitParameters:
    """Lengths and times of a walk."""

    speed: float  #: Walking speed [m/s]
    step_length: float  #: From foot to foot along the path [m]
    step_time: float  #: From heel strike to the other foot's heel strike [s]
    stance_fraction: float  #: Foot off as a fraction of the stride
    step_width: float  #: Between the lines on which the ankles step [m]
    toe_out: float  #: How far each foot points outwards [rad]
    foot_flat: float  #: When the whole foot is down, fraction of the stride from heel strike
    heel_off: float  #: When the heel leaves, fraction of the stride
    forefoot_off: float  #: When all but the toes leave, fraction of the stride
    leg_length: float  #: Hip to ground [m]
    gravity: float = GRAVITY  #: Acceleration of gravity [m/s²]

    def __post_init__(self):
        order = (0.0, self.foot_flat, self.heel_off, self.forefoot_off, self.stance_fraction)
        if not (np.all(np.diff(order) >= 0) and 0.5 <= self.stance_fraction < 1):
            raise ParameterError(
                "a walking stance goes from 0 over foot flat, heel off and ball off to foot off at "
                f"0.5 to 1 of the stride; these are {', '.join(f'{x:.3g}' for x in order[1:])}"
            )
        if not (self.speed > 0 and self.step_length > 0 and self.step_time > 0):
            raise ParameterError(
                f"speed {self.speed} m/s, step length {self.step_length} m and step time "
                f"{self.step_time} s must be positive"
            )

    @property
    def stride_time(self) -> float:
        """From heel strike to the same foot's next [s]."""
        return 2.0 * self.step_time

    @property
    def cadence(self) -> float:
        """Steps per minute [1/min]."""
        return 60.0 / self.step_time

    @property
    def swing_time(self) -> float:
        """From foot off to heel strike [s]."""
        return (1.0 - self.stance_fraction) * self.stride_time

    @property
    def double_support(self) -> float:
        """From heel strike to the other foot's foot off [s]."""
        return (self.stance_fraction - 0.5) * self.stride_time

    @property
    def relative_speed(self) -> float:
        r"""Dimensionless speed :math:`v^*`."""
        return self.speed / float(np.sqrt(self.gravity * self.leg_length))


def gait_parameters(
    human: Human | float,
    speed: float,
    *,
    step_length: float | None = None,
    cadence: float | None = None,
) -> GaitParameters:
    """Return how a person walks at a speed.

    Args:
        human: The person, or a leg length, hip to ground [m].
        speed: Walking speed, 0.3 to 2.2 [m/s].
        step_length: Own step length [m]; the cadence then follows from the speed.
        cadence: Own steps per minute [1/min]; the step length then follows from the speed.

    Returns:
        Lengths, times and fractions; :func:`dataclasses.replace` changes single ones.

    Example:
        >>> free = gait_parameters(0.92, 1.3)
        >>> round(free.step_length, 2), round(free.cadence), round(free.stance_fraction, 2)
        (0.7, 111, 0.59)
    """
    length = human.dimensions.leg_length if isinstance(human, Human) else float(human)
    if not 0.2 <= length <= 1.5:
        raise ParameterError(f"a leg length of {length} m must lie between 0.2 and 1.5 m")
    number("speed", speed, MIN_WALKING_SPEED, MAX_WALKING_SPEED, "m/s", "walking")
    gravity = human.gravity if isinstance(human, Human) else GRAVITY
    relative, usual = (float(speed / np.sqrt(g * length)) for g in (gravity, GRAVITY))
    if cadence is not None and not cadence > 0:
        raise ParameterError(f"{cadence=} [1/min] must be positive")
    if step_length is not None:
        step = float(step_length)
    elif cadence is not None:
        step = 60.0 * speed / cadence
    else:
        step = STEP_LENGTH_COEFFICIENT * length * usual**0.5
        step *= (gravity / GRAVITY) ** GRAVITY_EXPONENT
    step_time = _step_time(length, speed, step, cadence)
    stance = float(np.interp(relative, list(CLASS_SPEEDS.values()), list(FOOT_OFF.values()))) / 100
    flat = FOOT_FLAT_SHARE * (stance - 0.5)
    return GaitParameters(
        speed=float(speed),
        step_length=step,
        step_time=float(step_time),
        stance_fraction=stance,
        step_width=STEP_WIDTH_SHARE * length,
        toe_out=TOE_OUT,
        foot_flat=flat,
        heel_off=HEEL_OFF * stance,
        forefoot_off=ball_off(stance, flat),
        leg_length=length,
        gravity=gravity,
    )


def _step_time(length: float, speed: float, step: float, cadence: float | None) -> float:
    """Return the time of a step [s] of a length [m] on legs of a length [m], or refuse it."""
    what = f"walking on legs of {length:.3g} m at this cadence"
    number("step_length", step, 0.02 * length, MAX_STEP_LENGTH * length, "m", what)
    step_time = step / speed
    if cadence is not None and abs(cadence * step_time / 60.0 - 1.0) > 0.01:
        raise ParameterError(
            f"steps of {step:g} m at {speed:g} m/s are {60.0 / step_time:.1f} a minute, not "
            f"{cadence:g}: leave out step length or cadence"
        )
    if not STEP_TIMES[0] <= step_time <= STEP_TIMES[1]:
        raise ParameterError(
            f"a step of {step:g} m at {speed:g} m/s takes {step_time:.3g} s; allowed are "
            f"{STEP_TIMES[0]:g} to {STEP_TIMES[1]:g} s: change step length, cadence or speed"
        )
    return step_time


def ball_off(stance: float, flat: float) -> float:
    """Return when all but the toes leave, by foot off and foot flat; fractions of the stride.

    Example:
        >>> round(ball_off(0.59, 0.06), 3), ball_off(0.65, 0.10)
        (0.543, 0.6)
    """
    off, other = FOREFOOT_OFF_SHARE * stance, 0.5 + flat
    return other if abs(off - other) < SIMULTANEOUS_SHARE else off


@dataclass(frozen=True)
class WalkingTimeBounds:
    """How far the search goes from what people prefer; chosen."""

    step_length: float = 0.15  #: Share of the step length [1]
    stance: float = 0.03  #: Share of the stride [1]
    heel_off: float = 0.06  #: Share of the stride [1]


def free_walking_times(p: GaitParameters) -> tuple[FreeTime, ...]:
    """Return step length [m], foot off and heel off [strides] as free times, by their names."""
    bounds = WalkingTimeBounds()
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
