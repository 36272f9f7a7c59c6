"""Run the main job on the embedded default, end to end."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.commands import reproduce
from plantigrade.commands.fit import summary
from plantigrade.commands.options import PersonOptions, RunOptions
from plantigrade.commands.outcome import Outcome

if TYPE_CHECKING:
    from plantigrade.analyze.trial import Trial
    from plantigrade.workflows.textbook import TextbookWalk

KEPT = (  # of the reproduced gait's figures, in those of the demo
    "rom_error_mean_deg", "rom_error_max_deg", "com_error_max_mm", "contact_drift_max_mm",
    "sole_lowest_mm", "cycles_count",
)  # fmt: skip
COMPARED = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RunOptions):
    """Run the main job on the embedded default, end to end, and say where to look.

    A published mean walk is put on a person, written as a marker recording with the faults of a
    real one, read back, fitted, and held against the truth. Then the gait is rebuilt from a few
    ordered tasks and held against the recorded one.
    """

    speed: float = 1.25
    """Walking speed [m/s]."""

    def run(self) -> Outcome:
        """Do it."""
        import tempfile
        import time

        from plantigrade.commands.progress import Progress
        from plantigrade.io import write
        from plantigrade.models import Human
        from plantigrade.workflows import fit as fitting
        from plantigrade.workflows import reproduce as reproducing
        from plantigrade.workflows.textbook import recorded, textbook_walk

        started = time.perf_counter()
        progress = Progress(quiet=self.quiet)
        out = self.out or Path("runs") / "demo"
        rebuilt = out.parent / f"{out.name}-reproduced"
        overwrite = self.overwrite or self.out is None
        for folder in (out, rebuilt):
            fitting.refuse_existing(folder, overwrite=overwrite)
        human = Human.create(
            self.height or 1.74,
            self.mass or 71.0,
            self.sex or "male",
            self.joints or "42",
            self.feet,
        )
        with progress.step("walking by the textbook"):
            walk = textbook_walk(human, speed=self.speed)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "textbook_walk.c3d"
            with progress.step("writing it as a marker recording and reading that back"):
                write(recorded(walk, path, seed=self.seed), path)
                settings = reproducing.ReproduceSettings(
                    sex=human.sex, joints=human.joints, feet=human.feet, companions=False
                )
                loaded = fitting.load(path, settings)
            with progress.step("fitting a body to the recording"):
                fitted = fitting.fit(loaded, settings)
            with progress.step("analysing"):
                trial = fitting.analyse(fitted, settings)
            with progress.step("rebuilding the gait from ordered tasks"):
                gait = reproducing.reproduce_trial(trial, settings.tasks, settings.dynamics)
            with progress.step("writing the reports and the viewers"):
                same: dict[str, Any] = {
                    "command": ["plantigrade", *sys.argv[1:]],
                    "settings": settings,
                    "sources": loaded.sources,
                    "seed": self.seed,
                    "overwrite": overwrite,
                }
                gait_out, gait_metrics = reproducing.write(
                    gait, rebuilt, title="Textbook walk, reproduced", **same
                )
                folder_out, metrics = fitting.write(
                    trial,
                    out,
                    title="Textbook walk",
                    extra={
                        **errors(walk, trial),
                        **{f"reproduced_{k}": gait_metrics[k] for k in KEPT if k in gait_metrics},
                        "demo_time_s": time.perf_counter() - started,
                    },
                    **same,
                )
        text = summary(folder_out, metrics)
        text += (
            "\n  against the truth, joint angles off by "
            f"{metrics['angle_error_mean_deg']:.1f}° (offset removed "
            f"{metrics['angle_error_offset_removed_deg']:.1f}°)"
        )
        text += "\n" + reproduce.summary(gait_out, gait_metrics)
        if gait_metrics["status"] != "ok":
            metrics = {**metrics, "status": f"of the reproduced gait: {gait_metrics['status']}"}
        return Outcome(text, metrics)


def errors(walk: "TextbookWalk", trial: "Trial") -> dict[str, float]:
    """Return how far the fitted angles are from those that were walked [degrees]."""
    import numpy as np

    from plantigrade.analyze.statistics import rmse, rmse_offset_removed

    fit = trial.fit
    raw, free, result = [], [], {}
    for joint in COMPARED:
        for side in ("r", "l"):
            name = f"{joint}_{side}"
            truth = np.rad2deg(walk.qpos[:, 7 + walk.human.hinge(name)])
            truth = np.interp(fit.time, walk.time, truth)
            ours = np.rad2deg(fit.qpos[:, 7 + fit.human.hinge(name)])
            raw.append(rmse(ours, truth))
            free.append(rmse_offset_removed(ours, truth))
            result[f"angle_error_{name}_deg"] = raw[-1]
    result["angle_error_mean_deg"] = float(np.mean(raw))
    result["angle_error_offset_removed_deg"] = float(np.mean(free))
    return result
