"""Fit recordings to scaled humans."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from plantigrade.commands.batch_options import BatchOptions
from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.options import optional
from plantigrade.workflows.settings import FitSettings

if TYPE_CHECKING:
    from plantigrade.commands.progress import Progress


@dataclass(frozen=True, kw_only=True)
class Command(FitSettings, PageOptions, BatchOptions):
    """Fit a scaled human to a recording: motion, ground reactions and joint moments.

    Several recordings, folders, patterns or a --list of them make a batch with one table; trials of
    one subject are fitted with one scaled body. A batch that was interrupted continues where it
    stopped. A standing trial, skeleton or force file in the same folder is found by name and
    content, or can be given as an option.
    """

    files: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("FILE|FOLDER ...")]
    """Recordings to fit (.c3d, .trc, .amc, .bvh, .mot, ...), or folders or patterns of them."""
    subject: Literal["auto", "one", "each"] = "auto"
    """Grouping of the recordings: trials of one subject share lengths, marker places and body mass.
    auto: alike in folder, subject or name before the trial number, and marker distances; one: all
    are one subject's; each: every recording on its own."""

    def run(self) -> Outcome:
        """Fit one recording, or many as a batch."""
        from functools import partial

        from plantigrade.workflows.fit_many import fit_batch

        how, command = FitSettings.of(self), command_line()
        many = partial(fit_batch, how=how, subject=self.subject, command=command)
        return self.one_or_many(self.files, "fit-batch", self._one, many)

    def _one(self, path: Path, progress: "Progress") -> Outcome:
        from plantigrade.workflows.fit import run_fit

        name = f"fit-{path.stem}"
        self.refuse_existing(name)
        run = run_fit(path, FitSettings.of(self), step=progress.step, command=command_line())
        status = () if run.ok else (run.status,)
        return self.written(replace(run, name=name), progress, summary, *status)


def summary(folder: Path, metrics: dict) -> str:
    """Return the summary that is printed."""
    lines = [f"{folder}: {metrics['frames']} frames, {metrics['duration_s']:.2f} s"]
    error = metrics.get("marker_rms_mean_mm", metrics.get("joint_rms_mm"))
    if error is not None:
        what = "marker" if "marker_rms_mean_mm" in metrics else "joint centre"
        lines.append(f"  {what} error   {error:.1f} mm RMS")
    lines.append(f"  person         {metrics['height_m']:.3f} m, {metrics['mass_kg']:.1f} kg")
    for what in ("walking", "running"):
        if f"{what}_speed_m_s" in metrics:
            lines.append(
                f"  {what}        {metrics[f'{what}_speed_m_s']:.2f} m/s, "
                f"{metrics['cadence_steps_min']:.0f} steps/min"
            )
    lines.append(f"  report         {folder / 'report.html'}")
    lines.append(f"  viewer         {folder / 'viewer.html'}")
    return "\n".join(lines)
