"""Reproduce recorded gaits from prioritised tasks; several recordings make a study."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands.batch_options import BatchOptions
from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.options import optional
from plantigrade.workflows.settings import ReproduceSettings

if TYPE_CHECKING:
    from plantigrade.commands.progress import Progress


@dataclass(frozen=True, kw_only=True)
class Command(ReproduceSettings, PageOptions, BatchOptions):
    """Reproduce a recorded gait from three prioritised tasks; several make a study.

    The tasks take only foot contacts, heel and centre-of-mass paths, and the posture (by default
    with its rate) at the end of each gait phase from the recording. Everything else is computed.
    """

    files: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("FILE|FOLDER ...")]
    """Recordings of walking (.c3d, .trc, .amc, .bvh, .mot, ...), or folders or patterns of them."""

    def run(self) -> Outcome:
        """Reproduce one recording, or several as a study."""
        from functools import partial

        from plantigrade.workflows.reproduce_many import reproduce_batch

        how = ReproduceSettings.of(self)
        many = partial(reproduce_batch, how=how, command=command_line())
        return self.one_or_many(self.files, "reproduce-study", self._one, many)

    def _one(self, path: Path, progress: "Progress") -> Outcome:
        from plantigrade.workflows.reproduce import run_reproduction

        self.refuse_existing(f"reproduce-{path.stem}")
        settings = ReproduceSettings.of(self)
        run = run_reproduction(path, settings, step=progress.step, command=command_line())
        status = () if run.ok else (run.status,)
        return self.written(run, progress, summary, *status)


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return the summary that is printed."""
    n = metrics["cycles_count"]
    lines = [
        f"{folder}: {metrics['duration_s']:.2f} s of walking, {n} stride{'' if n == 1 else 's'}, "
        f"tasks “{metrics['tasks']}”",
        *figures(metrics),
        f"  report           {folder / 'report.html'}",
        f"  viewer           {folder / 'viewer.html'}",
    ]
    return "\n".join(lines)


def figures(metrics: dict[str, Any]) -> list[str]:
    """Return the lines that say how near the reproduced gait is to the recorded one."""
    from plantigrade.analyze.gait_study import PAPER_TABLE

    lines = []
    if "rom_error_mean_deg" in metrics:
        paper = [row.difference for row in PAPER_TABLE.values()]
        lines.append(
            f"  range of motion  error {metrics['rom_error_mean_deg']:.1f}° mean, "
            f"{metrics['rom_error_max_deg']:.1f}° maximum (paper, nine people: "
            f"{sum(paper) / len(paper):.1f}°, {max(paper)}°)"
        )
    lines.append(
        f"  centre of mass   error {metrics['com_error_max_mm']:.1f} mm maximum; "
        f"contact drift {metrics['contact_drift_max_mm']:.1f} mm, "
        f"lowest sole point {metrics['sole_lowest_mm']:.1f} mm"
    )
    if metrics.get("vertical_force_rmse_bw") is not None:
        lines.append(
            f"  vertical force   RMSE {metrics['vertical_force_rmse_bw']:.3f} body weights, "
            f"r {metrics['vertical_force_correlation']:.2f}"
        )
    if "cycle" in metrics["seconds"]:
        lines.append(f"  time             {metrics['seconds']['cycle']:.2f} s per gait cycle")
    return lines
