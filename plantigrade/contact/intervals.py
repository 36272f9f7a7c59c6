"""Time intervals of contact with the ground or with another support."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float


@dataclass(frozen=True)
class ContactInterval:
    """A time interval of contact of a foot, a region of it, or a support such as a seat."""

    side: str  #: ``"r"`` or ``"l"``; empty for anything but a foot
    #: ``"heel"``, ``"ball"`` or ``"toes"``; ``"foot"`` for a whole foot, which rolls from heel to
    #: toes; ``"sole"`` for a foot that stays flat; otherwise the name of the support
    region: str
    start: float  #: Beginning [s]; minus infinity if the contact has always been
    stop: float  #: End [s]; infinity if the contact remains
    begins: bool = True  #: Whether the contact begins at ``start``; false where a recording cuts it
    ends: bool = True  #: Whether the contact ends at ``stop``; false where a recording cuts it

    @property
    def rolls(self) -> bool:
        """Whether a foot, and with it the centre of pressure, rolls from heel to toes."""
        return self.region == "foot"

    @property
    def whole(self) -> bool:
        """Whether both ends were observed."""
        return self.begins and self.ends

    def later(self, seconds: float) -> "ContactInterval":
        """Return the same interval some time later."""
        return replace(self, start=self.start + seconds, stop=self.stop + seconds)

    def frames(self, time: Float[Array, " n"]) -> Bool[Array, " n"]:
        """Return the frames that belong to the interval."""
        return (time >= self.start) & (time <= self.stop)

    def share(self, time: Float[Array, " n"], usual: float) -> Float[Array, " n"]:
        """Return the share of the contact that has passed, 0 to 1.

        Args:
            time: Instants [s].
            usual: Duration of a contact of this kind, for one that a recording cuts [s].
        """
        length = self.stop - self.start
        if not self.whole:
            length = max(length, usual)
        start = self.start if self.begins or not self.ends else self.stop - length
        return np.clip((time - start) / max(length, 1e-6), 0.0, 1.0)

    def within(self, first: float, last: float) -> "ContactInterval":
        """Return what a recording from ``first`` to ``last`` [s] would show of the interval."""
        return replace(
            self,
            start=max(self.start, first),
            stop=min(self.stop, last),
            begins=self.begins and bool(self.start >= first),
            ends=self.ends and bool(self.stop <= last),
        )


def grouped(
    intervals: Iterable[ContactInterval], max_gap: float = 0.0
) -> list[list[ContactInterval]]:
    """Return intervals in groups, each of those that overlap or follow within ``max_gap`` [s]."""
    groups: list[list[ContactInterval]] = []
    for each in sorted(intervals, key=lambda c: c.start):
        if groups and each.start <= max(c.stop for c in groups[-1]) + max_gap:
            groups[-1].append(each)
        else:
            groups.append([each])
    return groups
