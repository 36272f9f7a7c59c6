"""Contact schedule of the sole sites, and directions in which heels are guided."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.sole_paths import SitePoints, region_of
from plantigrade.models import Human
from plantigrade.ordered_tasks.gait_reference import GaitReference
from plantigrade.ordered_tasks.stationary_contacts import is_tip
from plantigrade.wbc.tasks import ContactTask


@dataclass(frozen=True, kw_only=True)
class ScheduleSettings:
    """When a heel is guided during roll-off."""

    min_steepness: float = 0.25
    """Sine of the foot pitch from which the heel is guided forwards [1], about 15°. Chosen: the
    heel of a nearly flat foot rises before it moves forwards."""
    step_duration: float = 0.5
    """Approximate time from roll-off to landing [s]; the heel's displacement over this time gives
    its direction of travel."""


class ContactSchedule:
    """Contact state of each sole site over time.

    Args:
        contacts: Contact interval of each region of each foot; by default those from gait events
            and speeds.
        settings: When a heel is guided during roll-off.

    Attributes:
        points: All contact sites of the person.
        side: Foot of each site.
        region: Sole region of each site.
    """

    def __init__(
        self,
        reference: GaitReference,
        contacts: Sequence[ContactInterval] | None = None,
        settings: ScheduleSettings | None = None,
    ):
        self.settings = settings or ScheduleSettings()
        sites = contact_sites(reference.human)
        self.points = SitePoints(reference.human, sites)
        self.side = np.array([site.side for site in sites])
        self.region = np.array([region_of(site) for site in sites])
        self._tip = np.array([is_tip(site) for site in sites])
        self._rolls = np.array([_rolls(reference.human, sites, site) for site in sites])
        intervals = [
            (i, c.start, c.stop)
            for i in range(len(sites))
            for c in (reference.contacts if contacts is None else contacts)
            if c.side == self.side[i] and c.region == self.region[i]
        ]
        self._index = np.array([entry[0] for entry in intervals], dtype=int)
        self._start = np.array([entry[1] for entry in intervals])
        self._stop = np.array([entry[2] for entry in intervals])
        self._feet = [
            tuple((self.side == side) & (self.region == r) for r in ("heel", "ball", "toes"))
            for side in SIDES
        ]
        self._heel = reference.heel
        self._time, self._on = np.nan, np.zeros(len(sites), dtype=bool)

    def __call__(self, time: float) -> np.ndarray:
        """Return which points touch (n_points,).

        With the heel up only points about which the foot can rotate remain in contact. With the
        toes alone on the ground only the tips of the great toe and its neighbour touch; the foot
        then rotates freely about them.
        """
        if time == self._time:
            return self._on
        on = np.zeros(len(self.side), dtype=bool)
        on[self._index[(self._start <= time) & (time < self._stop)]] = True
        for heel, ball, toes in self._feet:
            if on[heel].any():
                continue
            if on[ball].any():
                on[(ball | toes) & ~self._rolls] = False
            elif on[toes].any():
                on[toes] = False
                on[toes & self._tip] = True
        self._time, self._on = time, on
        return on

    def guarded(self, time: float) -> np.ndarray:
        """Return which points the floor constraint applies to (n_points,).

        These are the points without contact, except the forefoot of a foot that rolls off.
        """
        on = self(time)
        guarded = ~on
        for heel, ball, toes in self._feet:
            if on[ball | toes].any() and not on[heel].any():
                guarded[ball | toes] = False
        return guarded

    def swing(self, side: str, contact: ContactTask | None = None):
        """Return the function (state, time) → directions in which a swing heel is guided.

        Args:
            contact: Contact task that reports landing; a late foot is guided until it lands. By
                default the schedule alone decides.
        """
        foot = np.any(self._feet[SIDES.index(side)], axis=0)
        nothing, plane = np.zeros((0, 3)), np.eye(3)[:2]

        def directions(state, time: float) -> np.ndarray:
            on = self(time) if contact is None else contact.on
            return nothing if on[foot].any() else plane

        return directions

    def roll(self, side: str):
        """Return a function giving the direction of travel of a heel during roll-off."""
        heel, ball, toes = self._feet[SIDES.index(side)]
        forefoot, nothing = ball | toes, np.zeros((0, 3))

        tip = self._tip & (self.side == side)

        def directions(state, time: float) -> np.ndarray:
            on = self(time)
            if on[heel].any() or not on[forefoot].any():
                return nothing
            sole = state.position(self.points)
            along = sole[heel].mean(axis=0) - sole[tip].mean(axis=0)
            if along[2] < self.settings.min_steepness * np.linalg.norm(along):
                return nothing
            return self._travel_direction(side, time)[None]

        return directions

    def _travel_direction(self, side: str, time: float) -> np.ndarray:
        """Return the horizontal direction of a heel towards its next landing."""
        path = self._heel[side]
        landing = time + self.settings.step_duration
        step = (path(landing)[0] - path(time)[0]) * [1.0, 1.0, 0.0]
        length = np.linalg.norm(step)
        return step / length if length > 0 else np.array([1.0, 0.0, 0.0])


def _rolls(human: Human, sites: Sequence[ContactSite], site: ContactSite) -> bool:
    """Return whether a site of the forefoot can stay on the ground while the heel is up.

    Hinged toes stay. A rigid foot rotates about the tips of its foremost toes; every other site
    rises or sinks.
    """
    if site.body != f"foot_{site.side}":
        return True
    if f"toes_{site.side}" in human.body_names:
        return False
    mine = [other for other in sites if other.side == site.side]
    return site in sorted(mine, key=lambda s: -s.position[0])[:2]
