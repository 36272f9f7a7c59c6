"""Progress of a batch: what has ended, how fast, and how long the rest will take."""

import time
from collections.abc import Callable

from plantigrade.pages.batch import BatchKind
from plantigrade.workflows.batch_items import Result

MAX_LINES = 200  # Items up to which each is a line of progress
SECONDS_BETWEEN = 5.0  # [s] time between two lines of progress of a larger batch
MIN_PACE_SECONDS = 10.0  # [s] time after which the rest can be estimated


class Pace:
    """Says what has ended, how fast, and how long the rest will take."""

    def __init__(self, count: int, say: Callable[[str], None]):
        self.count, self.say = count, say
        self.done = self.found = self._printed_found = 0
        self._began = self._last_line_time = time.perf_counter()

    def ended(self, result: Result, kind: BatchKind) -> None:
        """Count an item that has ended; print a line, in large batches only now and then."""
        self.close()
        self.done += 1
        now, of = time.perf_counter(), self.done + self.found
        if self.count > MAX_LINES and not result.problem and of < self.count:
            if now - self._last_line_time < SECONDS_BETWEEN:
                return
        self._last_line_time = now
        line = f"{of} of {self.count}: {result.name}: {kind.words(result)}"
        left, passed = self.count - of, now - self._began
        if left and passed > MIN_PACE_SECONDS:
            rate = self.done / passed
            line += f" ({rate:.2g}/s, {_duration(left / rate)} left)"
        self.say(line)

    @property
    def share(self) -> float:
        """Share of the items that have ended [1]."""
        return (self.done + self.found) / max(self.count, 1)

    def close(self) -> None:
        """Print how many items were done before, once."""
        if self.found > self._printed_found:
            self.say(f"{self.found} of {self.count} were there")
            self._printed_found = self.found


def _duration(seconds: float) -> str:
    """Return a time in the units in which people wait.

    Example:
        >>> _duration(42.3), _duration(400), _duration(90_000)
        ('42 s', '7 min', '25 h')
    """
    for most, unit, size in ((100, "s", 1), (6000, "min", 60)):
        if seconds < most:
            return f"{max(round(seconds / size), 1)} {unit}"
    return f"{seconds / 3600:.0f} h"
