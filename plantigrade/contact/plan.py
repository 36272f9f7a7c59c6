"""Contact plans: which part of which foot is in contact, where and when.

A :class:`~plantigrade.contact.site.ContactSite` is a place that can carry force; a
:class:`Stance` is one foot standing on one :class:`Footprint`, rolling from the heel over the flat
foot to the toes; a :class:`ContactPlan` is all stances of a motion. Times at which contact changes
are nodes and knots of the spline: between two of them nothing switches.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError

SAME = 1e-7
"""Times closer than this are one [s]."""


@dataclass(frozen=True)
class Footprint:
    """Position and heading of a foot on the ground.

    Attributes:
        side: ``"r"`` or ``"l"``.
        position: The ground below the ankle joint of the flat foot, world [m].
        heading: Where the foot points, from x towards y [rad].
    """

    side: str
    position: tuple[float, float, float]
    heading: float = 0.0


@dataclass(frozen=True)
class Stance:
    """One foot on one footprint.

    Attributes:
        footprint: Where.
        heel_strike: When the heel touches [s]; at or before the start, the foot stands from the
            start.
        foot_flat: When the whole foot is down [s]; at ``heel_strike`` for a foot put down flat.
        heel_off: When the heel leaves [s].
        forefoot_off: When all but the toes leave [s].
        toe_off: When the toes leave [s]; at or after the end of the motion, the foot stands to the
            end.
        toes_first: Whether ball and toes touch at ``heel_strike`` and the heel follows when the
            foot is flat, as after a jump.
    """

    footprint: Footprint
    heel_strike: float
    foot_flat: float
    heel_off: float
    forefoot_off: float
    toe_off: float
    toes_first: bool = False

    def __post_init__(self):
        """Refuse times out of order."""
        if not all(a <= b for a, b in pairwise(self.times)) or self.toe_off <= self.heel_strike:
            raise ParameterError(
                "a stance goes from heel strike, foot flat, heel off and forefoot off to toe off; "
                f"these times are out of order: {', '.join(f'{t:g}' for t in self.times)} s"
            )

    @property
    def times(self) -> tuple[float, float, float, float, float]:
        """Heel strike, foot flat, heel off, forefoot off and toe off [s]."""
        return self.heel_strike, self.foot_flat, self.heel_off, self.forefoot_off, self.toe_off

    def later(self, seconds: float, forward: float = 0.0, *, mirrored: bool = False) -> "Stance":
        """Return the same stance later [s] and further along x [m], of the other foot if mirrored.

        The mirror is the vertical plane along x.
        """
        f, sign = self.footprint, -1.0 if mirrored else 1.0
        x, y, z = f.position
        side = {"r": "l", "l": "r"}[f.side] if mirrored else f.side
        moved = Footprint(side, (x + forward, sign * y, z), sign * f.heading)
        return Stance(moved, *(t + seconds for t in self.times), toes_first=self.toes_first)

    def interval(self, part: str) -> tuple[float, float]:
        """Return from when to when a part of the foot stands [s]."""
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
    """A point of the body supported by something other than the ground: a chair, a wall, a rail.

    Attributes:
        site: The place; its ``side`` is empty.
        position: Where it rests, world [m].
        start: From when [s].
        stop: To when [s].
    """

    site: ContactSite
    position: tuple[float, float, float]
    start: float
    stop: float


@dataclass(frozen=True)
class ContactPlan:
    """All stances and supports of a motion.

    Attributes:
        duration: How long the motion lasts [s]; one period where it is periodic.
        stances: In order of time; a foot has one at a time. Of a periodic plan, all that touch the
            period.
        periodic: Whether the motion repeats.
        mirrored: Whether a periodic motion repeats as its mirror image, so that its period is half
            a stride; otherwise it is a whole one.
        advance: How far a periodic motion goes along x in a period [m].
        supports: What else carries the body.
        slope: How far the ground rises along x [rad]; places are given along the ground and across
            it, so that level ground at height 0 serves every slope.
    """

    duration: float
    stances: tuple[Stance, ...]
    periodic: bool = False
    mirrored: bool = True
    advance: float = 0.0
    supports: tuple[PointSupport, ...] = ()
    slope: float = 0.0

    @property
    def to_world(self) -> Float[Array, "3 3"]:
        """Rotation from the axes of the ground (x uphill, z off the ground) to world axes."""
        c, s = np.cos(self.slope), np.sin(self.slope)
        return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    @cached_property
    def switches(self) -> Float[Array, " n_switches"]:
        """Times at which contact changes, start and end among them [s]."""
        times = [t for s in self.stances for t in s.times]
        times += [t for s in self.supports for t in (s.start, s.stop)]
        inside = {0.0, self.duration} | {float(t) for t in times if 0.0 < t < self.duration}
        ordered = np.array(sorted(inside))
        return ordered[np.concatenate([[True], np.diff(ordered) > 1e-6 * self.duration])]

    def unrolled(self, *, before: int = 2, after: int = 2) -> tuple[Stance, ...]:
        """Return all stances, of a periodic plan also those of periods before and after, once."""
        if not self.periodic:
            return self.stances
        own = [s for s in self.stances if -SAME <= s.heel_strike < self.duration - SAME]
        return tuple(
            s.later(k * self.duration, k * self.advance, mirrored=self.mirrored and k % 2 == 1)
            for k in range(-before - 1, after + 1)
            for s in own
        )

    def full_stride(self) -> "ContactPlan":
        """Return the same periodic plan with a whole stride as its period."""
        if not (self.periodic and self.mirrored):
            return self
        stride, advance = 2 * self.duration, 2 * self.advance
        touching = tuple(
            s for s in self.unrolled() if s.heel_strike < stride - SAME and s.toe_off > SAME
        )
        return replace(self, duration=stride, stances=touching, mirrored=False, advance=advance)

    def intervals(self, site: ContactSite) -> list[tuple[float, float]]:
        """Return from when to when a site stands, each time it does [s]."""
        if site.side:
            found = [s.interval(site.part) for s in self.stances if s.footprint.side == site.side]
        else:
            found = [(s.start, s.stop) for s in self.supports if s.site.name == site.name]
        return [(start, stop) for start, stop in found if stop > start]

    def standing(
        self, site: ContactSite, times: Float[Array, " n_times"]
    ) -> Bool[Array, " n_times"]:
        """Return whether a site stands at times, first and last instant included."""
        stands = np.zeros(len(times), dtype=bool)
        for start, stop in self.intervals(site):
            stands |= (times >= start - SAME) & (times <= stop + SAME)
        return stands

    def carrying(
        self, site: ContactSite, times: Float[Array, " n_times"]
    ) -> Bool[Array, " n_times"]:
        """Return whether a site stands both before and after each time, so that it may carry force.

        The wrench of a spline is continuous; a force that starts and ends at zero is, too.
        """
        carries = np.zeros(len(times), dtype=bool)
        for start, stop in self.intervals(site):
            if not self.periodic:
                start = -np.inf if start <= 0 else start
                stop = np.inf if stop >= self.duration else stop
            carries |= (times > start + SAME) & (times < stop - SAME)
        return carries

    def footprint(self, side: str, time: float) -> Footprint | None:
        """Return where a foot stands at a time; None while it swings."""
        for s in self.stances:
            if s.footprint.side == side and s.heel_strike - SAME <= time <= s.toe_off + SAME:
                return s.footprint
        return None
