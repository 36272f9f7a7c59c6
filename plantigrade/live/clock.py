"""How a simulation keeps to real time."""

import time
from collections import deque
from collections.abc import Callable

MOST = 0.05
"""What a slow machine owes beyond this is given up, so that it stays responsive [s]."""
WINDOW = 1.0
"""Over this time the speed is measured [s]."""


class Clock:
    """Says how much time a simulation owes, and how well it keeps up.

    Args:
        now: Returns real time [s].

    Attributes:
        behind: Simulated time that was given up since the start [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now, self._last, self._owed, self.behind = now, now(), 0.0, 0.0
        self._kept: deque[tuple[float, float, float]] = deque()

    def owed(self, speed: float) -> float:
        """Return how much is to be simulated by now [s].

        Args:
            speed: Simulated per real time; zero while it is paused.
        """
        now = self._now()
        passed, self._last = now - self._last, now
        if speed == 0.0:
            self._owed = 0.0
            self._kept.clear()
            return 0.0
        self._owed += speed * passed
        given_up = max(self._owed - MOST, 0.0)
        self.behind += given_up
        self._owed -= given_up
        self._kept.append((now, speed * passed, given_up))
        while now - self._kept[0][0] > WINDOW:
            self._kept.popleft()
        return self._owed

    def did(self, simulated: float) -> None:
        """Take note of what was simulated [s]."""
        self._owed -= simulated

    def begin(self) -> None:
        """Owe nothing for the time until now."""
        self._last, self._owed = self._now(), 0.0

    @property
    def share(self) -> float:
        """What was simulated in the last second, by what was to be; 1 while it is paused."""
        kept = tuple(self._kept)  # the physics goes on meanwhile
        wanted = sum(wanted for _, wanted, _ in kept)
        return 1.0 - sum(lost for *_, lost in kept) / wanted if wanted > 0.0 else 1.0


class Pace:
    """Keeps a loop to a rate: a turn that took longer is made up for, a whole one is left out.

    Args:
        rate: Turns per second [1/s].
        now: Returns real time [s].
    """

    def __init__(self, rate: float, now: Callable[[], float] = time.monotonic):
        self._every, self._now, self._due = 1.0 / rate, now, now()

    def rest(self) -> float:
        """Return how long to wait until the next turn [s]."""
        now = self._now()
        self._due += self._every
        if self._due < now - self._every:
            self._due = now
        return max(0.0, self._due - now)
