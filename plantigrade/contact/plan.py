"""Contact plans: where and when each part of each foot is in contact.

A :class:`~plantigrade.contact.site.ContactSite` is a point that can carry force; a
:class:`Stance` is one foot on one :class:`Footprint`, rolling from the heel over the flat foot to
the toes; a :class:`ContactPlan` holds all stances of a motion. Contact changes only at nodes and
knots of the spline.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.site import ContactSite
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import ParameterError
from plantigrade.motion.recording import GaitEvent
from plantigrade.side_names import opposite

TIME_TOLERANCE = 1e-7  #: Times closer than this are equal [s]
UNIT_TOLERANCE = 1e-6  #: How far the length of a normal may be from one [1]; rounding
SAME_HEIGHT = 1e-9  #: Heights closer than this are equal [m]
UP = (0.0, 0.0, 1.0)  #: Normal of a level surface


@dataclass(frozen=True)
class Footprint:
    """Position and heading of a foot on the ground."""

    side: str  #: ``"r"`` or ``"l"``
    #: The ground below the ankle joint of the flat foot, world [m]
    position: tuple[float, float, float]
    heading: float = 0.0  #: Direction of the foot, from x towards y [rad]


@dataclass(frozen=True)
class Stance:
    """One foot on one footprint."""

    footprint: Footprint  #: Position and heading of the foot
    #: Time of heel strike [s]; zero or less for a foot that stands from the start
    heel_strike: float
    foot_flat: float  #: Time of foot flat [s]; equal to ``heel_strike`` for a flat landing
    heel_off: float  #: Time of heel off [s]
    forefoot_off: float  #: Time at which all but the toes leave [s]
    #: Time of toe-off [s]; the end of the motion or later for a foot that stands to the end
    toe_off: float
    #: Whether ball and toes touch at ``heel_strike`` and the heel at ``foot_flat``, as after a jump
    toes_first: bool = False
    #: Whether the foot rolls backward, as in walking backward: the five times are then those of
    #: toes down, ball down, heel down, forefoot off and heel off
    backward: bool = False

    def __post_init__(self):
        if not all(a <= b for a, b in pairwise(self.times)) or self.toe_off <= self.heel_strike:
            raise ParameterError(
                "a stance goes from heel strike, foot flat, heel off and forefoot off to toe off; "
                f"these times are out of order: {', '.join(f'{t:g}' for t in self.times)} s"
            )

    @property
    def times(self) -> tuple[float, float, float, float, float]:
        """Heel strike, foot flat, heel off, forefoot off and toe off [s]."""
        return self.heel_strike, self.foot_flat, self.heel_off, self.forefoot_off, self.toe_off

    def later(
        self, seconds: float, forward: float = 0.0, aside: float = 0.0, *, mirrored: bool = False
    ) -> "Stance":
        """Return the stance shifted in time [s], along x and y [m], of the other foot if mirrored.

        The mirror plane is x-z.
        """
        f, sign = self.footprint, -1.0 if mirrored else 1.0
        x, y, z = f.position
        side = opposite(f.side) if mirrored else f.side
        moved = Footprint(side, (x + forward, sign * y + aside, z), sign * f.heading)
        times = (t + seconds for t in self.times)
        return Stance(moved, *times, toes_first=self.toes_first, backward=self.backward)

    def reversed(self, about: float) -> "Stance":
        """Return the stance as it is seen backward in time, at ``about`` less its times [s]."""
        times = (about - t for t in self.times[::-1])
        return Stance(self.footprint, *times, toes_first=False, backward=not self.backward)

    def interval(self, part: str) -> tuple[float, float]:
        """Return start and end of the contact of a part of the foot [s]."""
        if self.backward:
            return {
                "heel": (self.heel_off, self.toe_off),
                "sole": (self.heel_off, self.forefoot_off),
                "ball": (self.foot_flat, self.forefoot_off),
                "toe": (self.heel_strike, self.forefoot_off),
            }[part]
        heel, toes = self.heel_strike, self.foot_flat
        if self.toes_first:
            heel, toes = toes, heel
        return {
            "heel": (heel, self.heel_off),
            "sole": (self.foot_flat, self.heel_off),
            "ball": (toes, self.forefoot_off),
            "toe": (toes, self.toe_off),
        }[part]


@dataclass(frozen=True)
class PointSupport:
    """A support of the body other than the ground, such as a chair, a wall or an armrest.

    It pushes along its normal and never pulls, within its cone of friction.
    """

    site: ContactSite  #: The supported site; its ``side`` is empty
    position: tuple[float, float, float]  #: Position of the contact, world [m]
    start: float  #: Start of the contact [s]
    stop: float  #: End of the contact [s]
    normal: tuple[float, float, float] = UP  #: Where the surface faces, of length one
    friction: float | None = None  #: Coefficient of friction; the ground's if None
    #: Forward pitch of the body from which its sphere rolls [rad]; that of a shank which kneels is
    #: a right angle
    pitch: float = 0.0
    #: How the surface moves, in the axes of the plan; it rests there if None
    motion: SurfaceMotion | None = None

    def __post_init__(self):
        if not abs(float(np.linalg.norm(self.normal)) - 1.0) < UNIT_TOLERANCE:
            raise ParameterError(
                f"the normal {self.normal} of the support of {self.site.name} must have length one"
            )
        if self.site.radius and self.normal != UP:
            raise ParameterError(
                f"{self.site.name} is a sphere, which rests on level surfaces: leave out its normal"
            )

    def places(self, times: Float[Array, " n_times"]) -> Float[Array, "n_times 3"]:
        """Return where the contact is at times [m]."""
        at = np.tile(self.position, (len(times), 1))
        return at if self.motion is None else at + self.motion.displacement(times)

    def velocity(self, times: Float[Array, " n_times"]) -> Float[Array, "n_times 3"]:
        """Return how fast the surface moves at times [m/s]."""
        return np.zeros((len(times), 3)) if self.motion is None else self.motion.velocity(times)


@dataclass(frozen=True)
class Obstacle:
    """A block on the ground across the path, which the feet step over."""

    x: float  #: Position of its middle [m]
    height: float  #: Height [m]
    width: float = 0.08  #: Extent along x [m]


@dataclass(frozen=True)
class ContactPlan:
    """All stances and supports of a motion.

    Attributes:
        duration: Duration of the motion [s]; one period of a periodic motion.
        stances: Stances in order of time, one at a time per foot; for a periodic plan all that
            overlap the period.
        periodic: Whether the motion repeats.
        mirrored: Whether a periodic motion repeats as its mirror image, with half a stride as its
            period; otherwise the period is a whole stride.
        advance: Displacement along x per period [m]; negative in walking backward.
        supports: Supports other than the ground.
        slope: Inclination of the ground along x, positive uphill [rad]; positions are in axes of
            the ground.
        obstacles: Blocks on the ground between footprints, in order of x.
        aside: Displacement along y per period [m]; zero where it is mirrored.
        motion: How the ground moves, with all of the plan, in its axes; it rests if None. Places
            are then in axes that move with it, as in a bus.
    """

    duration: float
    stances: tuple[Stance, ...]
    periodic: bool = False
    mirrored: bool = True
    advance: float = 0.0
    supports: tuple[PointSupport, ...] = ()
    slope: float = 0.0
    obstacles: tuple[Obstacle, ...] = ()
    aside: float = 0.0
    motion: SurfaceMotion | None = None

    def __post_init__(self):
        if self.aside and self.mirrored:
            raise ParameterError("a plan that is mirrored cannot lead to the side")
        if self.motion is not None and self.periodic:
            raise ParameterError("a periodic plan has no moving ground")

    @property
    def moves(self) -> bool:
        """Whether the ground or a support moves."""
        return self.motion is not None or any(s.motion is not None for s in self.supports)

    @property
    def to_world(self) -> Float[Array, "3 3"]:
        """Rotation from the axes of the ground (x uphill, z along the normal) to world axes."""
        c, s = np.cos(self.slope), np.sin(self.slope)
        return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    @cached_property
    def switches(self) -> Float[Array, " n_switches"]:
        """Times at which contact changes, including start and end [s]."""
        times = [t for s in self.stances for t in s.times]
        times += [t for s in self.supports for t in (s.start, s.stop)]
        inside = {0.0, self.duration} | {float(t) for t in times if 0.0 < t < self.duration}
        ordered = np.array(sorted(inside))
        return ordered[np.concatenate([[True], np.diff(ordered) > 1e-6 * self.duration])]

    def unrolled(self, *, before: int = 2, after: int = 2) -> tuple[Stance, ...]:
        """Return all stances, for a periodic plan including periods before and after, once each."""
        if not self.periodic:
            return self.stances
        own = [
            s
            for s in self.stances
            if -TIME_TOLERANCE <= s.heel_strike < self.duration - TIME_TOLERANCE
        ]
        return tuple(
            s.later(
                k * self.duration,
                k * self.advance,
                k * self.aside,
                mirrored=self.mirrored and k % 2 == 1,
            )
            for k in range(-before - 1, after + 1)
            for s in own
        )

    def full_stride(self) -> "ContactPlan":
        """Return a periodic plan with a whole stride as its period."""
        if not (self.periodic and self.mirrored):
            return self
        stride, advance = 2 * self.duration, 2 * self.advance
        touching = tuple(
            s
            for s in self.unrolled()
            if s.heel_strike < stride - TIME_TOLERANCE and s.toe_off > TIME_TOLERANCE
        )
        return replace(self, duration=stride, stances=touching, mirrored=False, advance=advance)

    def intervals(self, site: ContactSite) -> list[tuple[float, float]]:
        """Return start and end of every contact of a site [s]."""
        if site.side:
            found = [s.interval(site.part) for s in self.stances if s.footprint.side == site.side]
        else:
            found = [(s.start, s.stop) for s in self.supports if s.site.name == site.name]
        return [(start, stop) for start, stop in found if stop > start]

    def standing(
        self, site: ContactSite, times: Float[Array, " n_times"]
    ) -> Bool[Array, " n_times"]:
        """Return whether a site is in contact at times, first and last instant included."""
        stands = np.zeros(len(times), dtype=bool)
        for start, stop in self.intervals(site):
            stands |= (times >= start - TIME_TOLERANCE) & (times <= stop + TIME_TOLERANCE)
        return stands

    def carrying(
        self, site: ContactSite, times: Float[Array, " n_times"]
    ) -> Bool[Array, " n_times"]:
        """Return whether a site is in contact just before and after each time and may carry force.

        Forces therefore start and end at zero, which keeps the wrench of the spline continuous.
        """
        carries = np.zeros(len(times), dtype=bool)
        for start, stop in self.intervals(site):
            if not self.periodic:
                start = -np.inf if start <= 0 else start
                stop = np.inf if stop >= self.duration else stop
            carries |= (times > start + TIME_TOLERANCE) & (times < stop - TIME_TOLERANCE)
        return carries

    def on_ground(self, support: PointSupport) -> bool:
        """Return whether a support is the level ground itself, not a board above it."""
        level = min((s.footprint.position[2] for s in self.stances), default=0.0)
        return (
            support.normal == UP
            and support.friction is None
            and support.motion is None
            and not self.slope
            and abs(support.position[2] - level) < SAME_HEIGHT
        )

    def footprint(self, side: str, time: float) -> Footprint | None:
        """Return the footprint of a foot at a time; None in swing."""
        for s in self.stances:
            if (
                s.footprint.side == side
                and s.heel_strike - TIME_TOLERANCE <= time <= s.toe_off + TIME_TOLERANCE
            ):
                return s.footprint
        return None


def path_heading(plan: ContactPlan, times: Float[Array, " n_times"]) -> Float[Array, " n_times"]:
    """Return the heading of the way at times [s], left positive [rad].

    In the middle of a double support it is the mean of both footprints, so that toes that point
    outwards cancel; in between it changes evenly. Without footprints of both feet it is zero.
    """
    when, heading = [], []
    stances = sorted(plan.stances, key=lambda s: s.heel_strike)
    for one, two in zip(stances[:-1], stances[1:], strict=True):
        if one.footprint.side != two.footprint.side:
            when.append((two.heel_strike + one.toe_off) / 2)
            heading.append((one.footprint.heading + two.footprint.heading) / 2)
    if not when:
        return np.zeros(len(times))
    order = np.argsort(when)
    return np.interp(times, np.array(when)[order], np.array(heading)[order])


def alternates(plan: ContactPlan) -> bool:
    """Return whether the feet step alternately, as strides require."""
    strikes = sorted(
        (s.heel_strike, s.footprint.side)
        for s in plan.unrolled()
        if plan.periodic or s.heel_strike > 0
    )
    later = TIME_TOLERANCE  # feet that land together do not step
    return len(strikes) > 1 and all(
        a[1] != b[1] and b[0] - a[0] > later for a, b in pairwise(strikes)
    )


def gait_events(plan: ContactPlan, end: float) -> tuple[GaitEvent, ...]:
    """Return heel strikes and toe-offs from the start of a plan to ``end`` [s], by time.

    In a plan without repetition, a foot that stands from the start has no heel strike.
    """
    periods = 0 if not plan.periodic else round(end / plan.duration) + 2
    edge = 10 * TIME_TOLERANCE if plan.periodic else -10 * TIME_TOLERANCE
    events = [
        GaitEvent(min(max(time, 0.0), end), s.footprint.side, kind)
        for s in plan.unrolled(after=periods)
        for time, kind in ((s.heel_strike, "heel_strike"), (s.toe_off, "toe_off"))
        if -edge < time < end + edge
    ]
    return tuple(sorted(events, key=lambda e: e.time))
