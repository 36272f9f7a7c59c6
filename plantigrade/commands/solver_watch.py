"""Progress of a solver on the command line, and its end by Ctrl-C."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from plantigrade.commands.progress import Progress

PROGRESS_INTERVAL = 0.5  # [s] time between two lines of progress; chosen


class Watch:
    """Says what the solver does, and stops it when asked from the keyboard."""

    def __init__(self, progress: Progress):
        self.progress, self.asked = progress, False
        self._stage, self._said = "", -PROGRESS_INTERVAL
        self._last: Any = None

    def __call__(self, stage: str, iterate: Any) -> bool:
        """Say where the solver is, now and then; return whether it shall stop."""
        now = time.perf_counter()
        if stage != self._stage:
            self._say()
            self._stage, self._said = stage, -PROGRESS_INTERVAL
        self._last = iterate
        if now - self._said >= PROGRESS_INTERVAL:
            self._said = now
            self._say()
        return self.asked

    def close(self, metrics: dict[str, Any]) -> None:
        """Say how it ended."""
        self._say()
        self.progress.say(
            f"{metrics['solver_status']}: {metrics['iterations']} iterations, "
            f"{metrics['seconds']['solve']:.1f} s; checked in {metrics['frames']} frames"
        )

    def _say(self) -> None:
        it = self._last
        if it is None:
            return
        worst = getattr(it, "worst", "")
        named = f" ({worst.replace('_', ' ')})" if worst else ""
        self.progress.say(
            f"{self._stage}: iteration {it.number:3d}, cost {it.objective:.4g}, "
            f"violation {it.violation:.1e}{named}"
        )

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Stop with the best so far at the first Ctrl-C, and at once at the second."""

        def ask(*_: Any) -> None:
            if self.asked:
                raise KeyboardInterrupt
            self.asked = True
            self.progress.warn(
                "stopping with the best solution so far; press Ctrl-C again to abort"
            )

        try:
            before = signal.signal(signal.SIGINT, ask)
        except ValueError:  # not the main thread, where no keys are heard
            yield
            return
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
