"""The path of a swing foot: over the ground in its way, around the stance foot, within reach."""

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.edges import EdgeSettings
from plantigrade.control.gait.person import SoleShape
from plantigrade.control.gait.phase import Foot
from plantigrade.control.gait.swing import SwingOffsetSettings, two_cubics
from plantigrade.control.gait.swing_foot import SwingSettings

SWING_PARTS = np.linspace(0.0, 1.0, 9)  # of the ground along a swing
MIN_PART = 0.1  # of the time of a bent way, for either part: keeps their accelerations finite
MIN_FOOTSTEP_CHANGE = 0.02  # [leg lengths] change of a footstep up to which these samples stay

Height = Callable[[Array], float]  # [m] height of the ground at a position


@dataclass(frozen=True, kw_only=True)
class SwingPathSettings:
    """How feet swing; values were chosen where no reason is given."""

    clearance: float = 0.010
    """Least height of the recorded sole above the ground in the middle of a swing [leg lengths]:
    recorded toes pass it within millimetres, and soles of fitted feet are partly below it."""
    clearance_fading: float = SwingSettings.fixed_phase
    """Part of a swing at its beginning, and at its end, in which that height fades away; as that in
    which footsteps of recovery steps stay."""
    landing_depth: float = 0.0035
    """Depth below the ground at which a recorded foot ends its swing [leg lengths], 3 mm. Recorded
    soles are up to 8 mm above it then: late feet held the gait up by 15 ms, with all joints asked
    to stand still. Settled on the calibration half of ``experiment human-likeness``, with 1.5 mm
    beside it."""
    landing_share: float = 0.5
    """Part of a swing, at its end, in which the foot is lowered to there, and in which that of a
    recovery step is levelled: a heel that struck first after a far step threw the forefoot down by
    20 rad/s, faster than the ankle can hold it, with up to 9 body weights. Angular velocity and
    acceleration of the recording are taken away with the slope: they kept heels 16° down, and the
    slap was of up to 10 body weights."""
    lift_time: float = EdgeSettings.smoothing_time
    """Time before and after a lack of height in which the recorded foot is lifted, too, and time
    after a touchdown for which that foot stays lowered [s]; as over edges."""
    lift_smoothing: float = SwingOffsetSettings.arrival_lead
    """Standard deviation of the filter of that lift [s]: it ends as long before touchdown as a
    departure does."""
    clearance_by_speed: float = 0.02
    """Further height by the speed at which the foot departs from the recorded path [s], up to that
    of a recovery step, greatest after a third of the swing."""
    raised_phase: tuple[float, float] = (0.35, 0.7)
    """Parts of a swing between which the foot is above what is in its way."""
    max_leg_extension: float = 1.02
    """Greatest distance of hip and ankle of a desired foot [leg lengths]: near full extension knees
    resist by themselves. With 0.998, a knee flexed by 7°, feet were stopped in the air by 60 m/s²
    before most touchdowns; that threw the trunk forward, and hips stopped it after the strike with
    up to three times the recorded moment."""
    max_recovery_leg_extension: float = 0.998
    """The same where the divergent component has the error from which trunk and arms balance [leg
    lengths]: with 1.02 a push of 400 N to the side ended in a fall."""
    extension_fading: float = 0.008
    """Distance before full extension over which a foot is less and less led along its leg [leg
    lengths]: a straight leg gets no longer, and pulled the body down and forward before most
    touchdowns, with up to 5 m/s². Twice as wide is worse (raw peak 2.4, then 2.9 BW)."""
    reach_braking: float = SwingOffsetSettings.max_acceleration
    """Deceleration with which a foot stops at that distance [m/s²]. A velocity that ends there at
    once threw the trunk forward in every step."""
    max_inward_departure: float = 0.06
    """Distance by which a step may begin or end farther inward than the recorded one and still
    follow its path [leg lengths]: that passes the stance foot by itself. Feet of narrow walks went
    around it in every step, on curves that swung out 15 cm ahead of the footstep and straightened
    the leg."""
    grazing_lift: float = SwingSettings.clearance
    """Lift of a foot that grazes the ground farther away [leg lengths]; as of recovery steps."""
    grazing_time: float = 0.1
    """Time constant with which it is lowered again [s]."""


class SwingPath:
    """The height of one foot along its swing; ``leg`` is the length of the leg [m]."""

    def __init__(self, leg: float, sole: SoleShape, settings: SwingPathSettings | None = None):
        self.leg, self.sole, self.settings = leg, sole, settings or SwingPathSettings()
        self._start = np.zeros(3)
        self._footstep, self._obstacle = np.full(2, np.inf), 0.0

    def start(self, position: Float[Array, " 3"]) -> None:
        """Begin where the foot stands [m]."""
        self._start, self._footstep = np.array(position), np.full(2, np.inf)

    def height(
        self,
        foot: Foot,
        phase: float,
        rate: float,
        position: Float[Array, " 3"],
        velocity: Float[Array, " 3"],
        footstep: Float[Array, " 2"] | None,
        ground: Height,
        normal: Float[Array, " 3"] | None,
    ) -> tuple[float, float]:
        """Return the height above the recorded path [m], and its rate [m/s].

        Args:
            phase: Phase of the gait [s].
            position: Desired one of the foot [m]; its height does not count.
            velocity: Desired one [m/s].
            footstep: Where it will land; None if that is not planned.
            ground: Height of the ground at a position [m].
            normal: Normal of the ground where it is a plane; else None.
        """
        own = self.settings
        departs = own.clearance_by_speed * hypot(*foot.swing.velocity)
        clear = min(departs, own.grazing_lift * self.leg)
        duration = max(foot.touchdown - foot.lift_off, 1e-3)
        u = min(max((phase - foot.lift_off) / duration, 0.0), 1.0)
        # The cubic ends without a slope: a parabola would let the foot strike the ground.
        rises = 6.75 * clear * (1.0 - u) * (1.0 - 3.0 * u) * rate / duration
        height = 6.75 * clear * u * (1.0 - u) ** 2
        if normal is not None or footstep is None:
            if normal is not None:
                rises -= float(normal[:2] @ velocity[:2]) / float(normal[2])
            return height + ground(position), rises
        start, end = ground(self._start), ground(np.append(footstep, 0.0))
        if np.abs(footstep - self._footstep).max() > MIN_FOOTSTEP_CHANGE * self.leg:
            self._footstep = footstep.copy()
            self._obstacle = self._highest_obstacle(footstep, start, end, ground)
        way = footstep - self._start[:2]
        squared = max(float(way @ way), 1e-6)
        part = min(max(float((position[:2] - self._start[:2]) @ way) / squared, 0.0), 1.0)
        if 0.0 < part < 1.0:
            rises += (end - start) * float(velocity[:2] @ way) / squared
        first, last = own.raised_phase
        up, down = u / first, (1.0 - u) / (1.0 - last)
        raised = min(up, down, 1.0)
        if raised < 1.0:
            speed = (1.0 / first if up < down else -1.0 / (1.0 - last)) * rate / duration
            rises += self._obstacle * 6.0 * raised * (1.0 - raised) * speed
        height += self._obstacle * raised * raised * (3.0 - 2.0 * raised)
        return height + start + (end - start) * part, rises

    def _highest_obstacle(self, footstep: Array, start: float, end: float, ground: Height) -> float:
        """Return the height of the ground above the straight way, under any part of the sole [m].

        A foot tilts with the ground: on a slope toes are no lower over it than heels.
        """
        heel, ball, toe = self.sole.heel, self.sole.ball, self.sole.toes
        way = footstep - self._start[:2]
        ahead = way / max(float(np.linalg.norm(way)), 1e-6)
        highest = 0.0
        for part in SWING_PARTS:
            line = start + (end - start) * part
            ankle = self._start[:2] + part * way
            under, *sole = (
                ground(np.append(ankle + x * ahead, 0.0))
                for x in ((0.0, heel, 0.5 * toe, toe) if part > 0.0 else (0.0,))
            )
            highest = max(highest, under - line)
            if not sole:
                continue
            near = [ground(np.append(ankle + x * ahead, 0.0)) for x in (heel, ball)]
            tilt = (near[1] - near[0]) / (ball - heel)
            for x, level in zip((heel, 0.5 * toe, toe), sole, strict=True):
                highest = max(highest, level - tilt * x - line)
        return highest


def limit_to_reach(
    reach: float,
    hip: Float[Array, " 3"],
    hip_velocity: Float[Array, " 3"],
    position: Float[Array, " 3"],
    velocity: Float[Array, " 3"],
    acceleration: Float[Array, " 3"],
    braking: float,
) -> None:
    """Limit the desired motion of a swing foot to where its leg reaches, at its desired height.

    Farther away it would pull the body along with a straight leg, and hang over the ground
    meanwhile, while footsteps move on. Therefore it touches down nearer to the hip.

    Args:
        reach: Reach of the leg [m].
        hip: Its hip [m].
        hip_velocity: Velocity of the hip [m/s].
        position: Desired one of the foot [m]; changed.
        velocity: Desired one [m/s]; changed.
        acceleration: Desired one [m/s²]; changed.
        braking: Deceleration with which the foot stops there [m/s²].
    """
    away = position - hip
    down = min(abs(float(away[2])), reach)
    far, most = hypot(*away[:2]), sqrt(reach**2 - down**2)
    if far <= 0.0:
        return
    out = away[:2] / far
    speed = float((velocity - hip_velocity)[:2] @ out)
    fastest = sqrt(2.0 * braking * max(most - far, 0.0))
    if speed > fastest:
        velocity[:2] -= (speed - fastest) * out
        acceleration[:2] -= max(float(acceleration[:2] @ out), 0.0) * out
    if far > most:
        position[:2] -= (far - most) * out


def detours(
    start: Float[Array, " 2"], ends: Float[Array, "m 2"], size: Float[Array, " 2"]
) -> tuple[Float[Array, "m 2"], Array]:
    """Return points by which a foot goes around the stance foot, and which ways need them.

    Seen from above, legs hang together at the hips: a foot gets from behind the stance foot to
    ahead of it on its own side alone, however far it has crossed over on either side. The point is
    on the ellipse, in the direction in which the straight way is nearest to the stance foot; half
    way round where that would be on the wrong side.

    Args:
        start: Position of the foot: ahead of the stance foot, and outward from it [m].
        ends: Where it could land, likewise [m].
        size: Half axes of the ellipse around the stance foot [m].
    """
    a, b = start / size, ends / size
    begins, turns = np.arctan2(a[0], a[1]), np.arctan2(b[:, 0], b[:, 1])
    way = b - a
    part = -(way @ a) / np.maximum((way * way).sum(axis=1), 1e-12)
    near = a + part[:, None] * way
    far = np.sqrt((near * near).sum(axis=1))
    crosses = (part > 0.0) & (part < 1.0)
    wrong = np.abs(turns - begins) >= np.pi  # through the stance leg
    middle = 0.5 * (begins + turns)
    out = near / np.maximum(far, 1e-9)[:, None]
    out = np.where(wrong[:, None], np.stack([np.sin(middle), np.cos(middle)], axis=1), out)
    return out * size, wrong | (crosses & (far < 1.0))


def bent_way(
    first: Float[Array, "m 2"],
    then: Float[Array, "m 2"],
    velocity: Float[Array, " 2"],
    time: Float[Array, " m"],
) -> Float[Array, " m"]:
    """Return the straight way from rest to rest that takes as much acceleration as a bent one [m].

    The foot goes by a point on two cubics, as
    :meth:`plantigrade.control.gait.swing.SwingOffset.go` leads it; their acceleration is greatest
    at an end of either.

    Args:
        first: From the foot to the point [m].
        then: From the point to the footstep [m].
        velocity: Velocity of the foot [m/s].
        time: To touchdown [s].
    """
    near, far = (np.sqrt((leg * leg).sum(axis=1)) for leg in (first, then))
    h = (time * np.clip(near / np.maximum(near + far, 1e-9), MIN_PART, 1.0 - MIN_PART))[:, None]
    rest = time[:, None] - h
    begin, passing = two_cubics(first, then, velocity, h, rest)
    ends = (
        begin,
        (-6.0 * first / h + 2.0 * velocity + 4.0 * passing) / h,
        (-6.0 * then / rest + 2.0 * passing) / rest,
    )
    most = np.sqrt(np.max([(a * a).sum(axis=1) for a in ends], axis=0))
    return most * time**2 / 6.0
