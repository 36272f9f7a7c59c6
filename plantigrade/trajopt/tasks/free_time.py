"""A time of a task that the search chooses within bounds, and its uses in a task file."""

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


@dataclass(frozen=True)
class TimeUse:
    """A time in a file that follows from a free one."""

    table: str  #: Field of the file: parameters, stances, supports or added
    entry: int  #: Which of the entries of that field; 0 of the parameters
    key: str  #: Which of its keys
    name: str  #: Name of the free time
    later: float = 0.0  #: What is added to it [s]

    @property
    def text(self) -> str:
        """The time as the file has it."""
        if not self.later:
            return self.name
        return f"{self.name} {'-' if self.later < 0 else '+'} {abs(self.later):g}"
