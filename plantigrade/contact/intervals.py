"""Time intervals of contact with the ground."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class ContactInterval:
    """A time interval in which a foot, a region of it, or a seat is in contact.

    Attributes:
        side: ``"r"`` or ``"l"``; empty for a seat.
        region: ``"heel"``, ``"ball"`` or ``"toes"``; ``"foot"`` for any of them; empty for a seat.
        start: Beginning [s]; minus infinity if the contact has always been.
        stop: End [s]; infinity if the contact remains.
    """

    side: str
    region: str
    start: float
    stop: float

    def later(self, seconds: float) -> "ContactInterval":
        """Return the same interval some time later."""
        return replace(self, start=self.start + seconds, stop=self.stop + seconds)
