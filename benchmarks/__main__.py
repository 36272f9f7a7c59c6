"""Print every figure of speed and memory with its goal: ``python -m benchmarks --help``."""

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

# Small matrices: a second BLAS thread only costs. It must be said before numpy is loaded.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

from benchmarks import (  # noqa: E402
    batch,
    compiled,
    controllers,
    environment,
    feet,
    fits,
    kinematics,
    live,
    long,
    pendulum,
    pictures,
    processes,
    reading,
    robots,
    synthesis,
    ticks,
    world,
)
from experiments.table import ResultTable, Row  # noqa: E402
from plantigrade import __version__  # noqa: E402

DATA_VARIABLE = "PLANTIGRADE_DATA"
OPENSIM_VARIABLE = "PLANTIGRADE_OPENSIM_PYTHON"
PEERS_VARIABLE = "PLANTIGRADE_PEERS_PYTHON"
PARTS = (
    *("start", "demo", "compiled", "synthesis", "ticks", "feet", "world", "live", "pictures"),
    *("environment", "controllers", "pendulum", "robots"),
    *("kinematics", "opensim", "reading", "fits", "long", "batch"),
)


def main() -> int:
    """Run the chosen parts and print their table; 1 if a goal is missed and that was asked for."""
    arguments = parse()
    where = machine()  # before the benchmark itself makes it busy
    data, why = find_data(arguments.data)
    parts: dict[str, Callable[[], Iterator[Row]]] = {
        "start": processes.start_rows,
        "demo": processes.demo_rows,
        "compiled": compiled.rows,
        "synthesis": synthesis.rows,
        "ticks": lambda: ticks.rows(data, arguments.peers_python),
        "feet": feet.rows,
        "world": world.rows,
        "robots": lambda: robots.rows(arguments.robots),
        "live": live.rows,
        "pictures": pictures.rows,
        "environment": environment.rows,
        "controllers": controllers.rows,
        "pendulum": pendulum.rows,
        "kinematics": lambda: kinematics.rows(data),
        "opensim": lambda: kinematics.opensim_rows(data, arguments.opensim_python),
        "reading": lambda: reading.rows(data),
        "fits": lambda: fits.rows(data),
        "long": lambda: long.rows(data, arguments.minutes),
        "batch": lambda: batch.rows(data, arguments.items, arguments.jobs),
    }
    needing_data = {"kinematics", "opensim", "reading", "fits", "long", "batch"}
    rows: list[Row] = []
    for name in arguments.parts or parts:
        if name in needing_data and data is None:
            rows.append(Row(name, "not measured", None, note=why))
            continue
        for row in parts[name]():
            rows.append(row)
            print(f"{row.subject}: {row.quantity}", file=sys.stderr, flush=True)
    notes = [f"plantigrade {__version__} on {where}"]
    if arguments.json:
        print(json.dumps({"machine": where, "rows": [asdict(row) for row in rows]}, indent=1))
    else:
        print(ResultTable("Speed and memory", rows, notes).text())
    missed = [row for row in rows if row.met is False]
    return 1 if missed and arguments.strict else 0


def parse() -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "parts",
        nargs="*",
        metavar="PART",
        help=f"{', '.join(PARTS)}; all without any",
    )
    parser.add_argument(
        "--data", type=Path, help=f"folder of recordings; else ${DATA_VARIABLE} or ../shared/data"
    )
    parser.add_argument(
        "--opensim-python",
        default=os.environ.get(OPENSIM_VARIABLE, sys.executable),
        metavar="PYTHON",
        help=f"a Python that has OpenSim; else ${OPENSIM_VARIABLE} or this one",
    )
    parser.add_argument(
        "--peers-python",
        default=os.environ.get(PEERS_VARIABLE, sys.executable),
        metavar="PYTHON",
        help=f"a Python that has Pink or mink; else ${PEERS_VARIABLE} or this one",
    )
    parser.add_argument(
        "--robots",
        nargs="+",
        type=Path,
        default=(),
        metavar="ROBOT.xml",
        help="MJCF files of robots, besides those of packages that are installed",
    )
    parser.add_argument(
        "--minutes",
        type=float,
        nargs="+",
        default=long.MINUTES,
        metavar="MIN",
        help="durations of the recordings of long [min] (write PART before it); else 0.2 and 1",
    )
    parser.add_argument(
        "--items", type=int, default=40, help="recordings of the batch; 40 if absent"
    )
    parser.add_argument("--jobs", type=int, default=2, help="processes of the batch; 2 if absent")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a goal is missed")
    arguments = parser.parse_args()
    for part in arguments.parts:
        if part not in PARTS:
            parser.error(f"no part {part!r}; there are {', '.join(PARTS)}")
    return arguments


def find_data(named: Path | None) -> tuple[Path | None, str]:
    """Return the folder of recordings, or None and why there is none."""
    if named is None and DATA_VARIABLE in os.environ:
        named = Path(os.environ[DATA_VARIABLE])
    if named is not None:
        folder = named.expanduser().resolve()
        return (folder, "") if folder.is_dir() else (None, f"{named} is not a folder")
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    if beside.is_dir():
        return beside, ""
    return None, f"no folder of recordings: set {DATA_VARIABLE} or give --data"


def machine() -> str:
    """Return where this was measured."""
    python = f"Python {platform.python_version()}"
    busy = f", {os.getloadavg()[0]:.1f} processes running" if hasattr(os, "getloadavg") else ""
    return f"{platform.machine()}, {os.cpu_count()} cores{busy}, {python}"


if __name__ == "__main__":
    sys.exit(main())
