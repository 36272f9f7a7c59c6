"""Damage files and read them, for as long as there is time: ``python -m tests.nasty --hours 8``.

Every kind of file in :mod:`tests.nasty.targets` gets its share: in each round mutants of its small
seed, and some of one whole file. Ends in a table, each finding once with the mutant that showed it,
and exit code 1 if there is any. The same options find the same, except where time ends it.
"""

import argparse
import contextlib
import fnmatch
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from multiprocessing.connection import wait
from pathlib import Path

from experiments.table import sheet
from tests import nasty
from tests.conftest import find_data
from tests.nasty.judge import FINDINGS, READ, REFUSED, Damaged, Outcome, outcome
from tests.nasty.targets import BROKEN, TARGETS
from tests.nasty.workers import Job, Report, Worker

SMALL = 50
"""Mutants of a small seed in a round, for a target of cost 1."""
WHOLE_BYTES = 50e3
"""About so many bytes of a whole file are read in a round, for a target of cost 1."""
REPORT_INTERVAL = 60.0
"""Time between two lines of progress [s]."""
FOUND, INTERRUPTED = 1, 130


@dataclass
class Table:
    """Counts and failures of all mutants so far.

    Attributes:
        keep: Where the mutants of findings are kept.
        seconds: Of each target: time of the processor.
        counts: Of each target: outcomes of each kind.
        findings: Each distinct finding: outcome, what was done, target, where it is kept.
    """

    keep: Path
    seconds: Counter = field(default_factory=Counter)
    counts: dict[str, Counter] = field(default_factory=dict)
    findings: dict[tuple[str, str], tuple[Outcome, str, str, Path]] = field(default_factory=dict)

    @property
    def total(self) -> int:
        """How many mutants were read."""
        return sum(count.total() for count in self.counts.values())

    def add(self, report: Report) -> None:
        """Add what a worker reports; keep the mutant of each finding that is new."""
        self.counts.setdefault(report.job.target, Counter()).update(report.counts)
        self.seconds[report.job.target] += report.seconds
        for found, name in report.findings:
            if (found.kind, found.where) not in self.findings:
                what, kept = self._kept(report.job, name)
                self.findings[found.kind, found.where] = (found, what, report.job.target, kept)
                print(f"{found.kind}: {found.where}\n  {kept}", flush=True)

    def _kept(self, job: Job, name: str) -> tuple[str, Path]:
        """Write a mutant again, beside what belongs to it; return what was done, and its path."""
        folder = self.keep / "".join(c if c.isalnum() else "-" for c in name)
        shutil.copytree(job.folder, folder, dirs_exist_ok=True)
        path = folder / job.file
        what, content = nasty.mutant(name, path.read_bytes(), TARGETS[job.target].ways)
        path.write_bytes(content)
        return what, path

    def text(self, seconds: float) -> str:
        """Return the table, and each finding."""
        header = ("", "mutants", READ, REFUSED, *FINDINGS, "mutants/s")
        counts = {name: self.counts[name] for name in TARGETS if name in self.counts}
        counts["together"] = sum(self.counts.values(), Counter())
        spent = {**self.seconds, "together": self.seconds.total()}
        lines = [
            [
                name,
                f"{count.total():,}",
                *(f"{count[kind]:,}" for kind in (READ, REFUSED, *FINDINGS)),
                f"{count.total() / spent[name]:.0f}" if spent[name] else "-",
            ]
            for name, count in counts.items()
        ]
        title = f"{self.total:,} mutants in {seconds:.0f} s"
        findings = [
            f"{found.kind}: {found.where}\n  said: {found.said[:300]!r}\n  mutant: {what[:300]}\n"
            f"  again: python -m tests.nasty --again {str(path)!r} --targets {target!r}"
            for found, what, target, path in self.findings.values()
        ]
        return "\n".join([sheet(title, header, lines), *findings])


@contextlib.contextmanager
def seeds_of(targets: list[str], data: Path | None) -> Iterator[dict[str, list[Job]]]:
    """Make all seeds in a temporary folder: the small one of each target, then whole ones."""
    with tempfile.TemporaryDirectory(prefix="nasty-seeds-") as folder:
        found: dict[str, list[Job]] = {}
        for name in targets:
            target = TARGETS[name]
            for seed, make in (("small", target.make), *target.wholes(data)):
                place = Path(folder) / f"{len(found)}-{len(found.get(name, ()))}"
                whole = Damaged(target, place, make)
                if name not in BROKEN and whole.outcome(whole.content).kind != READ:
                    print(f"left out, since it is not read as it is: {name}, {seed}", flush=True)
                    continue
                size = len(whole.content)
                count = SMALL if seed == "small" else WHOLE_BYTES / size
                count = max(round(count / target.cost), 1)
                file = whole.path.relative_to(place).as_posix()
                found.setdefault(name, []).append(Job(name, seed, place, file, 0, count))
        yield found


def jobs(seeds: dict[str, list[Job]]) -> Iterator[Job]:
    """Yield jobs without end: rounds of all targets, the whole files of each in turn."""
    for turn in range(sys.maxsize):
        for small, *wholes in seeds.values():
            yield replace(small, first=turn * small.count)
            if wholes:
                whole = wholes[turn % len(wholes)]
                yield replace(whole, first=turn // len(wholes) * whole.count)


def fuzz(table: Table, queue: Iterator[Job], most: float, until: float, how: argparse.Namespace):
    """Have jobs done until there are so many mutants, or until that time on the clock."""
    workers = [Worker(how.seed) for _ in range(how.jobs)]
    again: list[Job] = []
    given, next_report = 0, time.monotonic() + REPORT_INTERVAL
    try:
        while True:
            for worker in workers:
                if worker.job is not None:
                    continue
                if again:
                    worker.give(again.pop())
                elif given < most and time.monotonic() < until:
                    job = next(queue)
                    job = replace(job, count=int(min(job.count, most - given)))
                    given += job.count
                    worker.give(job)
            if time.monotonic() > next_report:
                next_report = time.monotonic() + REPORT_INTERVAL
                print(f"{table.total:,} mutants", file=sys.stderr, flush=True)
            busy = [worker for worker in workers if worker.job is not None]
            if not busy:
                return
            ready = wait([worker.connection for worker in busy], timeout=1.0)
            for worker in busy:
                if worker.connection in ready:
                    report, left = worker.report()
                    table.add(report)
                    again += left
                elif worker.stalls(time.monotonic()):
                    worker.process.terminate()
    finally:
        for worker in workers:
            worker.stop()


def options() -> argparse.ArgumentParser:
    """Return the options of the command."""
    parser = argparse.ArgumentParser("python -m tests.nasty", description=__doc__)
    parser.add_argument("--hours", type=float, help="how long; 0.1 without --mutants")
    parser.add_argument(
        "--mutants", type=int, help="how many; as many as there is time for if absent"
    )
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    parser.add_argument(
        "--targets", nargs="*", default=["*"], help=f"of: {', '.join(TARGETS)}; * matches"
    )
    parser.add_argument("--seed", type=int, default=0, help="another seed gives other mutants")
    parser.add_argument("--data", type=Path, default=find_data(), help="folder of recordings")
    parser.add_argument(
        "--keep", type=Path, default=Path("nasty-findings"), help="folder of findings"
    )
    parser.add_argument("--again", type=Path, help="read one kept mutant again")
    return parser


def main() -> int:
    """Run the command; return its exit code."""
    parser = options()
    how = parser.parse_args()
    names = [name for name in TARGETS if any(fnmatch.fnmatch(name, p) for p in how.targets)]
    if how.targets == ["*"]:
        names = [name for name in names if name not in BROKEN]
    if not names or how.jobs < 1:
        parser.error(f"no target is called {how.targets}; there are {', '.join(TARGETS)}")
    if how.again:
        found = outcome(TARGETS[names[0]], how.again)
        print(f"{found.kind} {found.where}\n{found.said}")
        return FOUND if found.is_finding else 0
    hours = how.hours if how.hours is not None else 0.1 if how.mutants is None else float("inf")
    table, stopped = Table(how.keep), False
    for each in (signal.SIGINT, signal.SIGTERM):  # a shell ignores the first in the background
        signal.signal(each, signal.default_int_handler)
    with seeds_of(names, how.data) as seeds:
        begin = time.monotonic()
        try:
            most = float("inf") if how.mutants is None else how.mutants
            fuzz(table, jobs(seeds), most, begin + 3600 * hours, how)
        except KeyboardInterrupt:
            stopped = True
        print(table.text(time.monotonic() - begin))
    return FOUND if table.findings else INTERRUPTED if stopped else 0


if __name__ == "__main__":
    sys.exit(main())
