"""Progress on standard error: a line per step, a bar where a step has many items."""

import contextlib
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from plantigrade.notes import Info
from plantigrade.printable import printable

Item = TypeVar("Item")


class Progress:
    """Tells on standard error what goes on; standard output stays for results.

    Bars are drawn on a terminal only, so that a log file holds lines and nothing else.
    """

    def __init__(self, *, quiet: bool = False):
        """Open on standard error.

        Args:
            quiet: Say nothing but warnings.
        """
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
        """Print a note: information unless quiet, a warning always.

        Args:
            sentence: The note.
            of: Its subject, put before it.
        """
        say = self.say if isinstance(sentence, Info) else self.warn
        say(of + sentence)

    @contextlib.contextmanager
    def step(self, sentence: str) -> Iterator[None]:
        """Show that a step is under way until it ends, then a line with the time it took.

        Example:
            >>> with Progress(quiet=True).step("solving"):
            ...     pass
        """
        import time

        from rich.text import Text

        if self.quiet:
            yield
            return
        start = time.perf_counter()
        with self._console.status(Text(printable(sentence, lines=False))):
            yield
        self.say(f"{sentence}: {time.perf_counter() - start:.1f} s")

    def track(self, items: Iterable[Item], sentence: str, *, total: int | None = None):
        """Yield ``items`` while a bar counts them.

        Args:
            items: The items.
            sentence: The work, in words.
            total: How many there are; their length, where they have one, if absent.

        Example:
            >>> [2 * x for x in Progress(quiet=True).track([1, 2], "doubling")]
            [2, 4]
        """
        if self.quiet or not self._console.is_terminal:
            yield from items
            return
        from rich.progress import track

        if total is None and isinstance(items, Sequence):
            total = len(items)
        yield from track(
            items,
            printable(sentence, lines=False),
            total=total,
            console=self._console,
            transient=True,
            update_period=0.1,
        )

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
