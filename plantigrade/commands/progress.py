"""Progress on standard error: a line per step, a bar where a step has many items; solvers."""

import contextlib
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Any, TypeVar

from plantigrade.interrupts import on_signal
from plantigrade.notes import Info
from plantigrade.printable import printable

Item = TypeVar("Item")
BAR_STEP = 0.005  # [1] smallest move of a bar: drawing it takes longer than a step of control
PROGRESS_INTERVAL = 0.5  # [s] time between two lines of progress; chosen


class Progress:
    """Tells on standard error what goes on; standard output stays for results.

    Bars are drawn on a terminal only, so that a log file holds lines and nothing else.
    """

    def __init__(self, *, quiet: bool = False):
        """Open on standard error."""
        from rich.console import Console

        self.quiet = quiet
        self._console = Console(file=sys.stderr, highlight=False, markup=False, soft_wrap=True)

    def say(self, sentence: str) -> None:
        """Print one line, unless quiet."""
        if not self.quiet:
            self._console.print(printable(sentence, lines=False))

    def warn(self, sentence: str) -> None:
        """Print one warning, quiet or not."""
        self._console.print(f"warning: {printable(sentence, lines=False)}", style="yellow")

    def note(self, sentence: str, of: str = "") -> None:
        """Print a note: information unless quiet, a warning always."""
        say = self.say if isinstance(sentence, Info) else self.warn
        say(of + sentence)

    @contextlib.contextmanager
    def step(self, sentence: str) -> Iterator[Callable[[float], None]]:
        """Show that a step is under way until it ends, then a line with the time it took.

        Yields:
            Function called with the share of the step that is done, for the bar and the time left.

        Example:
            >>> with Progress(quiet=True).step("solving") as reached:
            ...     reached(0.5)
        """
        import time

        start = time.perf_counter()
        with self.bar(sentence) as reached:
            yield reached
        self.say(f"{sentence}: {time.perf_counter() - start:.1f} s")

    @contextlib.contextmanager
    def bar(self, sentence: str = "") -> Iterator[Callable[[float], None]]:
        """Draw a bar with the time left while work goes on.

        It moves from side to side until the first share is known.

        Yields:
            Function called with the share of the work that is done [1].
        """
        if self.quiet or not self._console.is_terminal:
            yield lambda share: None
            return
        from rich import progress as rich

        bar = rich.Progress(
            rich.SpinnerColumn(),
            rich.TextColumn("{task.description}", markup=False),
            rich.BarColumn(),
            rich.TimeElapsedColumn(),
            rich.TextColumn("{task.fields[words]}"),
            rich.TimeRemainingColumn(),
            console=self._console,
            transient=True,
        )
        task, drawn = bar.add_task(printable(sentence, lines=False), total=None, words=""), 0.0

        def reached(share: float) -> None:
            nonlocal drawn
            if share - drawn >= BAR_STEP or share >= 1.0:
                drawn = share
                bar.update(task, completed=share, total=1.0, words="left:")

        with bar:
            yield reached

    def track(self, items: Iterable[Item], sentence: str, *, total: int):
        """Yield ``items`` while a bar counts them.

        Example:
            >>> [2 * x for x in Progress(quiet=True).track([1, 2], "doubling", total=2)]
            [2, 4]
        """
        with self.bar(sentence) as reached:
            for done, item in enumerate(items):
                reached(done / total)
                yield item

    @contextlib.contextmanager
    def transfer(self, name: str, n_bytes: int) -> Iterator[Callable[[int], None]]:
        """Show how much of a file has arrived and how fast, then a line with both.

        Yields:
            Function called with the number of bytes received, first those of an earlier transfer.

        Example:
            >>> with Progress(quiet=True).transfer("walk.c3d", 1000) as reached:
            ...     reached(1000)
        """
        import time

        from rich import progress as rich
        from rich.filesize import decimal

        if self.quiet:
            yield lambda reached: None
            return
        name = printable(name, lines=False)
        bar = rich.Progress(
            rich.TextColumn("{task.description}", markup=False),
            rich.BarColumn(),
            rich.DownloadColumn(),
            rich.TransferSpeedColumn(),
            rich.TimeRemainingColumn(),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )
        task, first, last = bar.add_task(name, total=n_bytes), None, 0
        start = time.perf_counter()

        def reach(there: int) -> None:
            nonlocal first, last
            first, last = there if first is None else first, there
            bar.update(task, completed=there)

        with bar:
            yield reach
        rate = max(last - (first or 0), 0) / max(time.perf_counter() - start, 1e-6)
        self.say(f"{name}: {decimal(n_bytes)}, {decimal(int(rate))}/s")


class SolverProgress:
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

    def listening(self) -> AbstractContextManager[None]:
        """On the first Ctrl-C stop and keep the best solution found; on the second abort."""

        def ask(*_: Any) -> None:
            if self.asked:
                raise KeyboardInterrupt
            self.asked = True
            self.progress.warn(
                "stopping with the best solution so far; press Ctrl-C again to abort"
            )

        return on_signal(signal.SIGINT, ask)
