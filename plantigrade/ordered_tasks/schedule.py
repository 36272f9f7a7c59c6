"""Which sites of the soles touch the ground when, and where heels are led meanwhile."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.sole_paths import SitePoints, region_of
from plantigrade.models import Human
from plantigrade.ordered_tasks.held import is_tip
from plantigrade.ordered_tasks.reference import Reference
from plantigrade.wbc.tasks import ContactTask


@dataclass(frozen=True, kw_only=True)
class ScheduleSettings:
    """When the heel of a foot that rolls off is led."""

    min_steepness: float = 0.25
    """Sine of the angle between ground and foot from which its heel is led forward (some 15°).
    Chosen: the heel of a foot that is nearly flat rises before it goes forward; to lead it forward
    would tear it up."""
    step_duration: float = 0.5
    """Time from roll off to landing [s], about: where the heel is by then is the way it goes."""


class ContactSchedule:
    """Which sites of the soles touch the ground when.

    Args:
        reference: The recorded gait.
        contacts: When each part of each foot touches; as gait events and speeds tell if absent.
        settings: When the heel of a foot that rolls off is led.

    Attributes:
        points: All contact sites of the person.
        side: Foot of each.
        region: Region of the sole of each.
    """

    def __init__(
        self,
        reference: Reference,
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
        of = [
            (i, c.start, c.stop)
            for i in range(len(sites))
            for c in (reference.contacts if contacts is None else contacts)
            if c.side == self.side[i] and c.region == self.region[i]
        ]
        self._index = np.array([o[0] for o in of], dtype=int)
        self._start, self._stop = np.array([o[1] for o in of]), np.array([o[2] for o in of])
        self._feet = [
            tuple((self.side == side) & (self.region == r) for r in ("heel", "ball", "toes"))
            for side in SIDES
        ]
        self._heel = reference.heel
        self._time, self._on = np.nan, np.zeros(len(sites), dtype=bool)

    def __call__(self, time: float) -> np.ndarray:
        """Return which points touch (n_points,).

        A foot whose heel is up rolls: only points about which it can turn stay. Of toes alone on
        the ground only the tip of the great toe touches, and what is beside it: the others have
        left with the ball, and a foot that is about to leave turns about it freely.
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
        """Return which points a floor has to keep above the ground (n_points,).

        Those that do not touch; the forefoot of a foot that rolls turns about its toes.
        """
        on = self(time)
        guarded = ~on
        for heel, ball, toes in self._feet:
            if on[ball | toes].any() and not on[heel].any():
                guarded[ball | toes] = False
        return guarded

    def swing(self, side: str, contact: ContactTask | None = None):
        """Return the directions in which a heel is led in swing: a function of state and time.

        Args:
            side: The foot.
            contact: What says when it has landed: a foot that should touch and is still above the
                ground is led until it does. By the schedule alone if absent.
        """
        foot = np.any(self._feet[SIDES.index(side)], axis=0)
        nothing, plane = np.zeros((0, 3)), np.eye(3)[:2]

        def directions(state, time: float) -> np.ndarray:
            on = self(time) if contact is None else contact.on
            return nothing if on[foot].any() else plane

        return directions

    def roll(self, side: str):
        """Return the direction in which a heel is led while its foot rolls off: the way it goes."""
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
            return self._way(side, time)[None]

        return directions

    def _way(self, side: str, time: float) -> np.ndarray:
        """Return the horizontal direction in which a heel goes from here to its next landing."""
        path = self._heel[side]
        later = time + self.settings.step_duration
        step = (path(later)[0] - path(time)[0]) * [1.0, 1.0, 0.0]
        length = np.linalg.norm(step)
        return step / length if length > 0 else np.array([1.0, 0.0, 0.0])


def _rolls(human: Human, sites: Sequence[ContactSite], site: ContactSite) -> bool:
    """Return whether a site of the forefoot can stay on the ground while the heel is up.

    Toes that are hinged to the foot stay. A foot in one piece turns about the tips of its foremost
    toes: all else would have to rise or to sink with it.
    """
    if site.body != f"foot_{site.side}":
        return True
    if f"toes_{site.side}" in human.body_names:
        return False
    mine = [other for other in sites if other.side == site.side]
    return site in sorted(mine, key=lambda s: -s.position[0])[:2]
