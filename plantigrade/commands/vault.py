"""Optimise a gymnast's vault."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plantigrade.commands.options import JobOptions, PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.workflows.settings import VaultSettings


@dataclass(frozen=True, kw_only=True)
class Command(VaultSettings, JobOptions, PageOptions):
    """Optimise a gymnast's vault: the joint activations that give the fastest take-off.

    A torque-driven planar model of six segments, from hand contact to take-off. The exit code is 3
    if the hands never leave the table, the body moves down at take-off, or the check fails.
    """

    def run(self) -> Outcome:
        """Search, and write the run folder."""
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows.vault import run_vault

        progress = Progress(quiet=self.quiet)
        self.refuse_existing(f"vault-{5 if self.five_segments else 6}-segments")
        settings = VaultSettings.of(self)
        run = run_vault(
            settings,
            jobs=self.jobs,
            backend=self.backend,
            address=self.address,
            step=progress.step,
            command=command_line(),
        )
        return self.written(run, progress, summary)


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return the summary that is printed."""
    m = metrics
    how = "passed the check" if m["status"] == "ok" else m["status"]
    lines = [
        f"{folder}: {m['evaluations']} vaults in {m['seconds']['search']:.1f} s, {how}",
        f"  take-off         {m['take_off_speed_m_s']:.2f} m/s upward, "
        f"{m['take_off_forward_m_s']:.2f} m/s forward, after {m['contact_time_s']:.3f} s",
        f"  trunk            {m['trunk_touchdown_deg']:.0f}° above the horizontal at touchdown, "
        f"{m['trunk_take_off_deg']:.0f}° at take-off",
        f"  hands            {m['hand_force_up_max_bw']:.2f} body weights upward at most",
        f"  energy           balanced to {m['energy_error']:.1e}",
    ]
    for name in ("simplex", "evolution"):
        if f"{name}_best_m_s" in m:
            lines.append(
                f"  {name:16} {m[f'{name}_best_m_s']:.3f} m/s at best, "
                f"{m[f'{name}_mean_m_s']:.3f} ± {m[f'{name}_sd_m_s']:.3f} over its starts"
            )
    if "other_take_off_speed_m_s" in m:
        lines.append(
            f"  other model      {m['other_take_off_speed_m_s']:.3f} m/s; angles differ by "
            f"{m['other_angular_difference_pct']:.1f} % on average"
        )
    far = {k: v for k, v in m.items() if k.startswith("sensitivity_")}
    if far:
        listed = (f"{k[12:-4]} {v:.2f}" for k, v in far.items())
        lines.append(f"  5 % of approach  changes it by [m/s]: {', '.join(listed)}")
    lines += [
        f"  report           {folder / 'report.html'}",
        f"  viewer           {folder / 'viewer.html'}",
    ]
    return "\n".join(lines)
