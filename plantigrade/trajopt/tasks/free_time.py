"""A time of a task that the search chooses within bounds."""

from dataclasses import dataclass
from math import isfinite

from plantigrade.bounds import shown
from plantigrade.errors import ParameterError


@dataclass(frozen=True)
class FreeTime:
    """A time, or another number that sets times, which the search chooses.

    Raises:
        ParameterError: If the bounds leave no room, or the guess is not within them.
    """

    name: str  #: Its name
    least: float  #: Lower bound, in its own unit; s of a time
    most: float  #: Upper bound
    guess: float  #: Where the search begins

    def __post_init__(self):
        """Refuse bounds that leave no room, and a guess outside."""
        least, most, guess = (shown(x) for x in (self.least, self.most, self.guess))
        if not (isfinite(self.least) and isfinite(self.most) and self.least < self.most):
            raise ParameterError(
                f"free time {self.name}: bounds from {least} to {most} leave no room; give two "
                "numbers, the lower one first"
            )
        if not self.least <= self.guess <= self.most:
            raise ParameterError(
                f"free time {self.name}: the guess {guess} must lie from {least} to {most}"
            )
