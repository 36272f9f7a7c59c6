r"""Feasibility checks by simple mechanics before optimisation: power, fall, strength, support.

Each limit lies above the abilities of people: a refused motion is impossible.

- **A jump** to the height :math:`h` over a push of length :math:`s`, through which the centre of
  mass rises on the ground, takes the mean force :math:`m g (h / s + 1)` at the mean speed
  :math:`\sqrt{g h / 2}` [Samozino2008]_, whose product is the power of the push.
- **Down and up again** gravity and the legs decide how soon: the body falls freely, then legs stop
  it with :math:`k + 1` body weights, or pushes off with so many and then rises freely. Over a
  distance :math:`d` from rest to rest that takes :math:`\sqrt{2 d (1 + 1 / k) / g}`.
- **A crouch** is held by the torques of hips and knees.
- **Support**: a point mass at the height of the centre of mass, on a leg without mass to a centre
  of pressure within the feet that stand, must get from rest to rest in time. That is a linear
  program [Kajita2001]_; its result is the distance outside the feet at which the ground would have
  to push.
- **A walk** vaults over a leg, and gravity must hold the body on its arc: the Froude number
  :math:`v^2 / g l` is at most 1 [Alexander1989]_, on the moon 1.4.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.plan import ContactPlan, Footprint
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.spatial.conventions import about_vertical

MAX_FROUDE = (0.165, 0.4), (1.4, 1.0)
"""Gravity relative to the earth's, and the largest Froude number of a walk there [1]. A point mass
leaves the ground above 1; people run from 0.5 on, but from 1.39 (SD 0.45) on the moon, in parabolic
flight [DeWitt2014]_."""
MAX_PUSH_POWER = 50.0
"""Maximum mean power of a push-off [W/kg]: weightlifters, who jump with the highest peaks,
reach 80 at the peak. With a constant force power grows with speed, to twice its mean; as the force
of people falls towards the end, the mean is more than half (*estimate*: six tenths)."""
MAX_LEG_FORCE = 4.0
"""Maximum mean force of both legs in stopping or pushing the body [body weights on the earth].
Estimate."""
MAX_OUTSIDE_SUPPORT = 0.1
"""Maximum distance of the centre of pressure of a point mass outside the feet [m], the effect of
hip flexion, arm swing and vertical motion. Estimate."""
HEEL_SHARE = 0.25  # [1] distance from the ankle to the back of the heel relative to foot length
MAX_TIME_STEP = 0.05  # [s] maximum time step of the linear program

Rests = tuple[tuple[float, float, float], tuple[float, float, float]]


def check_push(human: Human, height: float, stroke: float) -> None:
    """Refuse a jump that requires more power than people have.

    Args:
        height: How far the centre of mass rises after take-off [m].
        stroke: How far it rises before [m].
    """
    g = human.gravity
    power = push_power(height, stroke, g)
    if power <= MAX_PUSH_POWER:
        return
    low, high = 0.0, height
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if push_power(middle, stroke, g) <= MAX_PUSH_POWER else (low, middle)
        )
    raise ParameterError(
        f"a jump of {height:.2f} m from a push of {stroke:.2f} m takes {power:.0f} W/kg on "
        f"average, nobody has more than {MAX_PUSH_POWER:.0f}: jump at most {low:.2f} m "
        "high, or with more depth"
    )


def push_power(height: float, stroke: float, gravity: float = GRAVITY) -> float:
    """Return the mean power of the push of a jump, per body mass [W/kg]; [Samozino2008]_.

    Example:
        >>> round(push_power(0.4, 0.4), 1)
        27.5
    """
    return gravity * (height / stroke + 1.0) * float(np.sqrt(gravity * height / 2.0))


def quickest(distance: float, gravity: float = GRAVITY) -> float:
    """Return the least time in which a body goes down or up, from rest to rest [s].

    Example:
        >>> round(quickest(0.3), 2)
        0.29
    """
    return float(
        np.sqrt(2.0 * distance * (1.0 + 1.0 / (MAX_LEG_FORCE * GRAVITY / gravity - 1.0)) / gravity)
    )


def check_time(human: Human, seconds: float, distance: float, what: str) -> None:
    """Refuse to go down or up faster than gravity and legs do.

    Args:
        seconds: Time that there is [s].
        distance: How far the centre of mass goes [m].
        what: The motion, in words.
    """
    least = quickest(distance, human.gravity)
    if seconds < least:
        raise ParameterError(
            f"{what} by {distance:.2f} m in {seconds:.2f} s is too soon: gravity and legs of "
            f"{MAX_LEG_FORCE * GRAVITY / human.gravity:.0f} body weights take {least:.2f} s from "
            "rest to rest"
        )


def check_crouch(human: Human, depth: float, strength: float) -> None:
    """Refuse a crouch that hips and knees do not hold, even with shanks as far forward as can be.

    Weight passes between hips and knees; torques of both together bear half of it at the horizontal
    length of a thigh.

    Args:
        depth: How far the hips are below those in standing [m].
        strength: Part of the joints' torques that may be used.
    """
    d = human.dimensions
    torque = human.model.jnt_actfrcrange[1:]
    have = -sum(torque[human.hinge(f"{joint}_r"), 0] for joint in ("hip_flexion", "knee_angle"))
    lean = human.limits[1, human.hinge("ankle_angle_r")]
    upright = np.clip((d.thigh + d.shank * (1.0 - np.cos(lean)) - depth) / d.thigh, 0.0, 1.0)
    need = human.mass * human.gravity / 2.0 * d.thigh * float(np.sqrt(1.0 - upright**2))
    if need > strength * have:
        raise ParameterError(
            f"a crouch of {depth:.2f} m takes {100 * need / have:.0f} % of the strength of hips "
            f"and knees to hold; {100 * strength:.0f} % may be used"
        )


def check_froude(human: Human, speed: float) -> None:
    """Refuse to walk faster [m/s] than gravity holds a body on the arc of a leg."""
    leg, g = human.dimensions.leg_length, human.gravity
    froude, most = speed**2 / (g * leg), float(np.sqrt(g * leg))
    limit = float(np.interp(g / GRAVITY, *MAX_FROUDE))
    most *= float(np.sqrt(limit))
    if froude > limit:
        raise ParameterError(
            f"{speed:.2f} m/s on legs of {leg:.2f} m is Froude number {froude:.2f}: above "
            f"{limit:.2g} a body leaves the ground, so walk at most {most:.2f} m/s"
        )


def check_support(human: Human, plan: ContactPlan, rests: Rests | None = None) -> None:
    """Refuse a motion on the feet that no centre of pressure near them brings to rest in time.

    Args:
        rests: Centre of mass where the person rests at the start and at the end [m]; over the
            middle of the feet if absent.
    """
    outside = missing_support(human, plan, rests)
    if outside > MAX_OUTSIDE_SUPPORT:
        raise ParameterError(
            f"in {plan.duration:.2f} s the ground would have to push {100 * outside:.0f} cm "
            "outside of the feet to bring the body there and to rest: give it more time, or put "
            "the feet nearer"
        )


def missing_support(human: Human, plan: ContactPlan, rests: Rests | None = None) -> float:
    """Return how far outside of feet and seat a point mass must be pushed, at least [m].

    It is 0 of a motion that leaves the ground. Arguments are those of :func:`check_support`.
    """
    from scipy.optimize import linprog
    from scipy.sparse import coo_array

    times = _times(plan)
    middles, steps = (times[1:] + times[:-1]) / 2, np.diff(times)
    places = [_base(human, plan, float(t)) for t in middles]
    if not all(len(p) for p in places):
        return 0.0
    if rests is None:
        height = BodyState(human, human.standing()).com[2]
        rests = (*places[0].mean(axis=0), height), (*places[-1].mean(axis=0), height)
    rate = float(np.sqrt(human.gravity / min(x[2] for x in rests)))
    n = len(steps)
    out = sum(map(len, places))
    most = out + 2 * n
    # unknowns: parts that corners carry, how far out of the feet the ground pushes along x and y,
    # the greatest of these, and position ± velocity / rate along x and y at all times
    state = most + 1 + 2 * np.arange(2 * (n + 1)).reshape(n + 1, 2)
    rows, known = _pendulum_rows(places, rate * steps, out, state, rests)
    size = int(state[-1, -1]) + 2
    i, j, factors = (np.array(x) for x in zip(*rows, strict=True))
    equations = coo_array((factors, (i, j)), shape=(len(known), size)).tocsr()
    each = np.arange(2 * n)
    within = coo_array(
        (
            np.concatenate([np.ones(2 * n), -np.ones(2 * n), -np.ones(4 * n)]),
            (
                np.concatenate([each, each + 2 * n, np.arange(4 * n)]),
                np.concatenate([out + each, out + each, np.full(4 * n, most)]),
            ),
        ),
        shape=(4 * n, size),
    ).tocsr()
    cost = np.zeros(size)
    cost[most] = 1.0
    limits = [(0.0, None)] * out + [(None, None)] * (size - out)
    found = linprog(cost, within, np.zeros(4 * n), equations, known, limits, method="highs")
    return float(found.fun) if found.success else 0.0


def _times(plan: ContactPlan) -> Array:
    """Return times of a plan at most :data:`MAX_TIME_STEP` apart, changes of contact included."""
    ends = np.unique(np.clip([0.0, *plan.switches, plan.duration], 0.0, plan.duration))
    parts = [
        np.linspace(a, b, int(np.ceil((b - a) / MAX_TIME_STEP)) + 1)[:-1] for a, b in pairwise(ends)
    ]
    return np.append(np.concatenate(parts), plan.duration)


def _pendulum_rows(
    places: Sequence[Array], growth: Array, out: int, state: Array, rests: Rests
) -> tuple[list[tuple[int, int, float]], list[float]]:
    """Return equations of a pendulum from rest to rest: row, column and factor; right sides.

    Args:
        places: Corners of the base of support in every step [m].
        growth: Rate of the pendulum times the duration of every step.
        out: Column of the first push out of the feet.
        rests: Centre of mass at the start and at the end [m].
    """
    rows: list[tuple[int, int, float]] = []
    known: list[float] = []

    def equation(terms: list[tuple[int, float]], value: float) -> None:
        rows.extend((len(known), column, factor) for column, factor in terms)
        known.append(value)

    first = 0
    for k, (place, step) in enumerate(zip(places, growth, strict=True)):
        carried = range(first, first + len(place))
        first += len(place)
        equation([(j, 1.0) for j in carried], 1.0)
        for axis in range(2):
            pressure = [(j, place[i, axis]) for i, j in enumerate(carried)]
            pressure.append((int(out + 2 * k + axis), 1.0))
            for way in (1.0, -1.0):
                # the part that grows is divided by its growth, so that numbers stay small
                grown = float(np.exp(-step))
                this, then = (1.0, grown) if way > 0 else (grown, 1.0)
                own = int(state[k, axis]) + (way < 0)
                after = int(state[k + 1, axis]) + (way < 0)
                moved = [(j, (this - then) * x) for j, x in pressure]
                equation([(after, then), (own, -this), *moved], 0.0)
    for k, rest in ((0, rests[0]), (len(places), rests[1])):
        for axis in range(2):
            for way in range(2):
                equation([(int(state[k, axis]) + way, 1.0)], float(rest[axis]))
    return rows, known


def _base(human: Human, plan: ContactPlan, time: float) -> Float[Array, "n_corners 2"]:
    """Return the corners of the feet that stand at a time, and what else carries [m]."""
    feet = [s.footprint for s in plan.stances if s.heel_strike <= time < s.toe_off]
    seat = [s.places(np.array([time]))[0, :2] for s in plan.supports if s.start <= time < s.stop]
    corners = [_corners(human, foot) for foot in feet]
    return np.concatenate([np.array(seat).reshape(-1, 2), *corners])


def _corners(human: Human, foot: Footprint) -> Float[Array, "4 2"]:
    d = human.dimensions
    along, across = np.array([-HEEL_SHARE, 1.0 - HEEL_SHARE]) * d.foot_length, np.array([-0.5, 0.5])
    flat = np.array([(a, b) for a in along for b in across * d.foot_width])
    return np.array(foot.position[:2]) + flat @ about_vertical(foot.heading)[:2, :2].T
