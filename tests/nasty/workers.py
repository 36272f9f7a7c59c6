"""Processes that read mutants; one that hangs, runs out of memory or crashes is a finding."""

import faulthandler
import multiprocessing
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from tests import nasty
from tests.nasty.judge import Damaged, Outcome, Writes, listing
from tests.nasty.targets import BROKEN, TARGETS

CPU_LIMIT_S = 10
"""Longest time of the processor for one mutant [s]: whole recordings take one or two."""
STALL_LIMIT_S = 600.0
"""Longest time on the clock for one mutant [s]: for what waits without working."""
MEMORY_LIMIT = 600e6
"""Most memory that reading a mutant may add to the process [bytes]: files are of up to 3 MB."""
MEMORY_DISK = next((str(folder) for folder in [Path("/dev/shm")] if folder.is_dir()), None)
"""Where mutants lie: a disk takes longer to write a small file than its reader takes."""
ADDRESS_LIMIT = 8e9
"""Most memory that a process may ask for [bytes], so that no mutant ends the machine."""


@dataclass(frozen=True)
class Job:
    """Mutants of one seed.

    Attributes:
        target: Name of the target.
        seed: Name of its seed, and the folder and file that it lies in.
        first: Number of the first mutant.
        count: How many.
    """

    target: str
    seed: str
    folder: Path
    file: str
    first: int
    count: int

    def name(self, number: int, start: int) -> str:
        """Return the name of a mutant, from which everything about it is drawn."""
        return f"{start}/{self.target}/{self.seed}/{number}"


@dataclass
class Report:
    """Result of the mutants of a job: how many of each kind, and each finding once."""

    job: Job
    counts: Counter = field(default_factory=Counter)
    seconds: float = 0.0
    """Time of the processor."""
    findings: list[tuple[Outcome, str]] = field(default_factory=list)
    """Outcome, name of the mutant."""


class Worker:
    """A process that reads mutants, and what it is doing."""

    def __init__(self, start: int):
        """Start the process; ``start`` is what all mutants are drawn from."""
        self.start, self.job = start, None
        self._begin()

    def _begin(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.folder = Path(tempfile.mkdtemp(prefix="nasty-", dir=MEMORY_DISK))
        self.number = context.Value("q", -1)
        self.connection, theirs = context.Pipe()
        arguments = (theirs, self.number, self.folder, self.start)
        self.process = context.Process(target=_work, args=arguments, daemon=True)
        self.process.start()
        theirs.close()
        self._since: tuple[int | None, float] = (None, 0.0)

    def give(self, job: Job) -> None:
        """Have a job done."""
        self.job, self._since = job, (None, 0.0)
        self.connection.send(job)

    def stalls(self, now: float) -> bool:
        """Return whether it has been at the same mutant for too long on the clock."""
        if self.number.value != self._since[0]:
            self._since = (self.number.value, now)
        return now - self._since[1] > STALL_LIMIT_S

    def report(self) -> tuple[Report, list[Job]]:
        """Return what came of its job, and what of it is left to do.

        Where the process died, its mutant is the finding; those before it were not reported.
        """
        job, self.job = self.job, None
        assert job is not None
        try:
            return self.connection.recv(), []
        except (EOFError, OSError):
            number, end = self.number.value, job.first + job.count
            report = Report(replace(job, first=number, count=1))
            found = self._end()
            report.counts[found.kind] += 1
            report.findings.append((found, job.name(number, self.start)))
            before = replace(job, count=number - job.first)
            after = replace(job, first=number + 1, count=end - number - 1)
            self.stop()
            self._begin()
            return report, [rest for rest in (before, after) if rest.count > 0]

    def _end(self) -> Outcome:
        """Return why the process ended."""
        self.process.join()
        code = self.process.exitcode or 0
        log = self.folder / "fault.log"
        text = log.read_text(errors="replace") if log.exists() else ""
        inside = re.findall(r"/plantigrade/(\S+?\.py)\", line (\d+) in (\S+)", text)
        where = "{}:{} {}".format(*inside[0]) if inside else "outside of the package"
        if code == -signal.SIGPROF:
            return Outcome("hang", where, f"more than {CPU_LIMIT_S} s of the processor")
        if code == -signal.SIGTERM:
            return Outcome("hang", where, f"more than {STALL_LIMIT_S:g} s on the clock")
        name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return Outcome("crash", f"{name} {where}", name)

    def stop(self) -> None:
        """End the process, and remove its folder."""
        if self.process.is_alive():
            self.process.terminate()
            self.process.join()
        self.connection.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def _work(connection: Connection, number: Any, folder: Path, start: int) -> None:
    """Read the mutants of one job after the other."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.dont_write_bytecode = True
    warnings.simplefilter("ignore")  # of mutants; what is read makes errors of them
    log = open(folder / "fault.log", "w")  # noqa: SIM115
    faulthandler.enable(log)
    faulthandler.register(signal.SIGPROF, log, chain=True)
    faulthandler.register(signal.SIGTERM, log, chain=True)
    resource.setrlimit(resource.RLIMIT_AS, (int(ADDRESS_LIMIT), resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.chdir(_empty(folder / "here"))
    writes, warm = Writes(), set()
    while (job := connection.recv()) is not None:
        connection.send(_done(job, number, folder, start, writes, warm))


def _empty(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


def _done(
    job: Job, number: Any, folder: Path, start: int, writes: Writes, warm: set[str]
) -> Report:
    place = _empty(folder / "seed")

    def make(into: Path) -> Path:
        shutil.copytree(job.folder, into, dirs_exist_ok=True)
        return into / job.file

    number.value = job.first
    target = TARGETS[job.target]
    seed, report, seen = Damaged(target, place, make, writes), Report(job), set()
    if job.target not in BROKEN and job.target not in warm:
        seed.outcome(seed.content)  # loads what is loaded once: it is no memory of a mutant
        warm.add(job.target)
    begin = time.process_time()
    for k in range(job.first, job.first + job.count):
        name = job.name(k, start)
        _, content = nasty.mutant(name, seed.content, target.ways)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        number.value = k
        signal.setitimer(signal.ITIMER_PROF, CPU_LIMIT_S)
        found = seed.outcome(content)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
        if grown > MEMORY_LIMIT and not found.is_finding:
            found = Outcome("memory", f"{job.target} {found.kind}", f"{grown / 1e6:.0f} MB")
        if listing(folder / "here") and not found.is_finding:
            left = sorted(listing(folder / "here"))
            found = Outcome("files", f"{left[0]} in the working folder", f"{left}")
            _empty(folder / "here")
        report.counts[found.kind] += 1
        if found.is_finding and (found.kind, found.where) not in seen:
            seen.add((found.kind, found.where))
            report.findings.append((found, name))
    report.seconds = time.process_time() - begin
    return report
