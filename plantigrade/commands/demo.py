"""Run the whole pipeline on built-in data."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.bounds import SEEDS
from plantigrade.commands import fit, reproduce
from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.models.person import Person

if TYPE_CHECKING:
    from plantigrade.analyze.trial import Trial
    from plantigrade.commands.progress import Progress
    from plantigrade.kinematics.textbook_recording import TextbookWalk
    from plantigrade.record import Run
    from plantigrade.workflows.simulate_settings import SimulateSettings

KEPT_FIGURES = (  # of the reproduced gait's figures, in those of the demo
    "rom_error_mean_deg", "rom_error_max_deg", "com_error_max_mm", "contact_drift_max_mm",
    "sole_lowest_mm", "cycles_count",
)  # fmt: skip
PUSHED = "-pushed"
PUSH = "100,0.2,90,1.5"
"""The push of the last part."""
SPEED_FACTOR = 0.8
"""Speed of its walk, relative to that of the recording [1]."""
WALK_DURATION = 4.0
"""Duration of its walk [s]."""
RUN_NAME = "demo"
REPRODUCED_SUFFIX = "-reproduced"
RECORDING_FILE = "textbook_walk.c3d"
PLACEMENT = 0.002
"""Distance of a marker from its landmark in a good laboratory, standard deviation [m]."""
TORSION = 0.30
"""Torsion of the shanks, outward [rad]: adults point their feet 11° outward [Fukuchi2018]_ with
hips turned inward; the body has none, and its second toe lies 4° inward of its foot."""
COMPARED_ANGLES = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")


@dataclass(frozen=True, kw_only=True)
class Command(Person, PageOptions):
    """Run the whole pipeline on built-in data and say where the results are.

    The published mean walk of adults is written as a marker recording with the noise, skin movement
    and gaps of a good laboratory, read back, fitted, and compared with the true angles. The gait is
    then reproduced from prioritised tasks and compared with the recording. Finally the person walks
    in the physics simulation and is pushed.
    """

    activity = "walking"
    ranges = {"speed": (0.1, 3, "m/s"), "seed": SEEDS}

    speed: float = 1.25
    """Walking speed [m/s]."""
    seed: int = 0
    """Random seed of the recording's noise and gaps."""

    def run(self) -> Outcome:
        """Walk, record, fit, reproduce, walk on."""
        import time

        from plantigrade.analyze.norms import MAX_CHILD_HEIGHT
        from plantigrade.commands.progress import Progress
        from plantigrade.dynamics.adult_walk import adult_walk
        from plantigrade.kinematics.textbook_recording import textbook_walk
        from plantigrade.record.folder import refuse_existing
        from plantigrade.record.run import RUNS
        from plantigrade.workflows.save import save
        from plantigrade.workflows.simulate import run_simulation

        started = time.perf_counter()
        progress = Progress(quiet=self.quiet)
        if self.out is not None or self.overwrite:
            out = self.out or RUNS / RUN_NAME
            for folder in (
                out,
                *(out.with_name(out.name + end) for end in (REPRODUCED_SUFFIX, PUSHED)),
            ):
                refuse_existing(folder, self.overwrite)
        provenance = {"command": command_line(), "seed": self.seed}
        human = Person(**{**self.known, "joints": self.joints or "42"}).human()
        with progress.step("generating the textbook walk"):
            adult = human.height >= MAX_CHILD_HEIGHT
            walk = (adult_walk if adult else textbook_walk)(human, speed=self.speed)
        kept, trial, fitted, gait = self._fitted(walk, progress, provenance)
        with progress.step("simulating the walk with a push"):
            pushed = replace(
                run_simulation(fitted, self._push(), command=provenance["command"]),
                title="Textbook walk, pushed",
            )
        more = {f"reproduced_{k}": gait.figures[k] for k in KEPT_FIGURES if k in gait.figures}
        more |= {f"pushed_{k}": pushed.figures[k] for k in ("on_feet", "speed_at_end_m_s")}
        figures = {**fitted.figures, **more, **errors(walk, trial)}
        seconds = {"demo": time.perf_counter() - started}
        fitted = replace(fitted, figures=figures, seconds=seconds, name=RUN_NAME)
        with progress.step("writing the reports and the viewers"):
            fitted = save(
                fitted, self.out, overwrite=self.overwrite, files=kept, beside=REPRODUCED_SUFFIX
            )
            out = fitted.folder or Path()
            gait = save(gait, out.with_name(out.name + REPRODUCED_SUFFIX), overwrite=self.overwrite)
            pushed = save(pushed, out.with_name(out.name + PUSHED), overwrite=self.overwrite)
        metrics = fitted.metrics
        if not gait.ok:
            metrics["status"] = f"reproduced gait: {gait.status}"
        folders = tuple(run.folder for run in (fitted, gait, pushed) if run.folder is not None)
        return Outcome(_text(fitted, gait, pushed), metrics, folders)

    def _fitted(
        self, walk: "TextbookWalk", progress: "Progress", provenance: dict[str, Any]
    ) -> "tuple[dict[str, bytes], Trial, Run, Run]":
        """Return the walk as a recording, what it is fitted to, and both as runs."""
        import tempfile

        from plantigrade.io import write
        from plantigrade.kinematics.textbook_recording import recorded
        from plantigrade.workflows import fit as fitting
        from plantigrade.workflows import reproduce as reproducing
        from plantigrade.workflows.settings import ReproduceSettings

        human = walk.human
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / RECORDING_FILE
            with progress.step("writing it as a marker recording"):
                faults: Any = {"placement": PLACEMENT, "torsion": TORSION, "mirrored": True}
                write(recorded(walk, path, seed=self.seed, **faults), path)
            kept = {RECORDING_FILE: path.read_bytes()}
            own: Any = {"sex": human.sex, "joints": human.joints, "feet": human.feet}
            settings = ReproduceSettings(**own, companions=False)
            recording, trial = fitting.fit_trial(path, settings, progress.step)
            what = recording, trial, settings
            fitted = fitting.run_of(*what, title="Textbook walk", **provenance)
            with progress.step("reproducing the gait from prioritised tasks"):
                title = "Textbook walk, reproduced"
                gait = reproducing.run_of(*what, title=title, **provenance)
        return kept, trial, fitted, gait

    def _push(self) -> "SimulateSettings":
        """Return the settings of the simulation with a push."""
        from plantigrade.workflows.simulate_settings import SimulateSettings

        return SimulateSettings(
            controller="pendulum",
            own=(("speed", f"{SPEED_FACTOR * self.speed:.3g}"),),
            push=(PUSH,),
            duration=WALK_DURATION,
        )


def _text(fitted: "Run", gait: "Run", pushed: "Run") -> str:
    """Return the summaries of the three runs, and what to run next."""
    import shlex

    out, rebuilt, walked = (run.folder or Path() for run in (fitted, gait, pushed))
    metrics, kept_file = fitted.metrics, shlex.quote(str(out / RECORDING_FILE))
    return (
        f"{fit.summary(out, metrics)}\n  angle error    "
        f"{metrics['angle_error_mean_deg']:.1f}° from the true joint angles, "
        f"{metrics['angle_error_offset_removed_deg']:.1f}° without offsets\n"
        f"{reproduce.summary(rebuilt, gait.metrics)}\n"
        f"{walked}: simulated, pushed with 100 N for 0.2 s: "
        f"{'keeps walking' if pushed.ok else pushed.status}\n"
        f"  viewer           {walked / 'viewer.html'}\n"
        f"next, run the same recording on its own, then yours:\n"
        f"  plantigrade fit {kept_file}\n"
        f"  plantigrade reproduce {kept_file}"
    )


def errors(walk: "TextbookWalk", trial: "Trial") -> dict[str, float]:
    """Return how far the fitted angles are from those that were walked [degrees]."""
    import numpy as np

    from plantigrade.analyze.statistics import compare_curves

    fitted = trial.fit
    raw, free, result = [], [], {}
    for joint in COMPARED_ANGLES:
        for side in ("r", "l"):
            name = f"{joint}_{side}"
            truth = np.rad2deg(walk.qpos[:, 7 + walk.human.hinge(name)])
            truth = np.interp(fitted.time, walk.time, truth)
            ours = np.rad2deg(fitted.qpos[:, 7 + fitted.human.hinge(name)])
            found = compare_curves(ours, truth)
            raw.append(found.rmse)
            free.append(found.rmse_offset_removed)
            result[f"angle_error_{name}_deg"] = raw[-1]
    result["angle_error_mean_deg"] = float(np.mean(raw))
    result["angle_error_offset_removed_deg"] = float(np.mean(free))
    return result
