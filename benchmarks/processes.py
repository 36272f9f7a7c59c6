"""Fresh processes: import, help and demo, with the time and the memory each takes."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from experiments.table import Row, at_most

PLANTIGRADE = (sys.executable, "-m", "plantigrade")
ALL_IMPORTS = (
    "import plantigrade.analyze.trial, plantigrade.io, plantigrade.kinematics.fit, "
    "plantigrade.models, plantigrade.motion, plantigrade.workflows.fit"
)
N_REPEATS = 7  # fresh processes whose median is taken


@dataclass(frozen=True)
class Spent:
    """What a process took.

    Attributes:
        seconds: From its start to its end, as a user waits for it [s].
        cpu_seconds: Processor time; what is left of it on a machine that does other things [s].
        peak_mb: Most memory it held at once [MB].
        code: Its exit code.
        message: The last line it wrote on standard error.
    """

    seconds: float
    cpu_seconds: float
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
    cpu = usage.ru_utime + usage.ru_stime
    message = lines[-1] if lines else ""
    return Spent(seconds, cpu, _megabytes(usage), process.returncode, message)


def start_rows() -> Iterator[Row]:
    """Yield how long it takes to import the package and to print the help."""
    commands = {
        "import plantigrade": [sys.executable, "-c", "import plantigrade"],
        "import of all a fit uses from Python": [sys.executable, "-c", ALL_IMPORTS],
        "plantigrade --help": [*PLANTIGRADE, "--help"],
        "plantigrade fit --help": [*PLANTIGRADE, "fit", "--help"],
    }
    for what, command in commands.items():
        spent = _median(command)
        note = f"{spent.cpu_seconds:.2f} s of processor time"
        yield replace(at_most("start", what, spent.seconds, 0.5, "s"), note=note)
    bare = _median([sys.executable, "-c", "pass"])
    yield Row("start", "Python itself, in all of these", bare.seconds, "s")


def demo_rows() -> Iterator[Row]:
    """Yield time and peak memory of the demo."""
    with tempfile.TemporaryDirectory() as folder:
        spent = measure([*PLANTIGRADE, "demo", "--out", str(Path(folder) / "demo")])
    if spent.code != 0:
        yield Row("demo", "failed", None, note=spent.message, met=False)
        return
    yield at_most("demo", "command to finished run folder", spent.seconds, 60, "s")
    yield at_most("demo", "peak memory", spent.peak_mb, 600, "MB")


def _median(command: Sequence[str]) -> Spent:
    measure(command)  # fills the disk cache
    runs = sorted((measure(command) for _ in range(N_REPEATS)), key=lambda spent: spent.seconds)
    return runs[N_REPEATS // 2]


def _megabytes(usage: resource.struct_rusage) -> float:
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kibibytes elsewhere
    return usage.ru_maxrss * unit / 1e6
