"""Progress of a solver in one line under the running cell of a notebook."""

import sys
import time
from typing import Any

from plantigrade.trajopt.solve import Progress
from plantigrade.trajopt.solvers.result import Iterate

INTERVAL = 0.2  # [s] between two updates; chosen


def cell_progress() -> Progress | None:
    """Return a line that follows the iterations in place; None outside of a Jupyter kernel."""
    shell: Any = _shell()
    if shell is None:
        return None
    from IPython.display import display

    line: Any = display({"text/plain": "starting"}, raw=True, display_id=True)
    last = -INTERVAL

    def follow(stage: str, iterate: Iterate) -> None:
        nonlocal last
        now = time.monotonic()
        if iterate.number == 0 or now - last >= INTERVAL:
            last = now
            line.update({"text/plain": iteration_text(stage, iterate)}, raw=True)

    return follow


def iteration_text(stage: str, iterate: Iterate) -> str:
    """Return an iteration in one line."""
    text = f"{stage}: iteration {iterate.number}, largest violation {iterate.violation:.1e}"
    return text if iterate.seconds != iterate.seconds else f"{text}, {iterate.seconds:.0f} s"


def _shell() -> Any:
    """Return the shell of the running Jupyter kernel; None elsewhere."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell if hasattr(shell, "kernel") else None
