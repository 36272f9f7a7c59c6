"""Fresh processes: import, help and demo, with the time and the memory each takes."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plantigrade.experiments.table import Row, at_most

PLANTIGRADE = (sys.executable, "-m", "plantigrade")
EVERYTHING = (
    "import plantigrade.analyze.trial, plantigrade.io, plantigrade.kinematics.fit, "
    "plantigrade.models, plantigrade.motion, plantigrade.workflows.fitting"
)
REPEATS = 7  # fresh processes whose median is taken


@dataclass(frozen=True)
class Spent:
    """What a process took.

    Attributes:
        seconds: From its start to its end, as a user waits for it [s].
        peak_mb: Most memory it held at once [MB].
        code: Its exit code.
        message: The last line it wrote on standard error.
    """

    seconds: float
    peak_mb: float
    code: int
    message: str


def measure(command: Sequence[str], folder: Path | None = None) -> Spent:
    """Run a command and return what it took; its memory is that of the one process."""
    environment = dict(os.environ)
    here = str(Path(__file__).resolve().parents[1])
    environment["PYTHONPATH"] = os.pathsep.join(
        [here, *filter(None, [environment.get("PYTHONPATH")])]
    )
    with tempfile.TemporaryFile("w+") as errors:
        begin = time.perf_counter()
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=errors
        )
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)  # it is gone: nothing to wait for
        errors.seek(0)
        lines = errors.read().strip().splitlines()
    return Spent(seconds, _megabytes(usage), process.returncode, lines[-1] if lines else "")


def start_rows() -> Iterator[Row]:
    """Yield how long it takes to import the package and to print the help."""
    note = "Python itself included"
    for code, what in (
        ("import plantigrade", "import plantigrade"),
        (EVERYTHING, "import of all a fit uses from Python"),
    ):
        seconds = _median([sys.executable, "-c", code])
        yield replace(at_most("start", what, seconds, 0.5, "s"), note=note)
    for words in (["--help"], ["fit", "--help"]):
        seconds = _median([*PLANTIGRADE, *words])
        yield at_most("start", " ".join(["plantigrade", *words]), seconds, 0.5, "s")
    yield Row("start", "Python itself", _median([sys.executable, "-c", "pass"]), "s")


def demo_rows() -> Iterator[Row]:
    """Yield time and peak memory of the demo."""
    with tempfile.TemporaryDirectory() as folder:
        spent = measure([*PLANTIGRADE, "demo", "--out", str(Path(folder) / "demo")])
    if spent.code != 0:
        yield Row("demo", "failed", None, note=spent.message, met=False)
        return
    yield at_most("demo", "command to finished run folder", spent.seconds, 60, "s")
    yield at_most("demo", "peak memory", spent.peak_mb, 600, "MB")


def _median(command: Sequence[str]) -> float:
    measure(command)  # fills the disk cache
    return statistics.median(measure(command).seconds for _ in range(REPEATS))


def _megabytes(usage: resource.struct_rusage) -> float:
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kibibytes elsewhere
    return usage.ru_maxrss * unit / 1e6
