"""Put the motion of a run on a robot."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import FileError, ParameterError
from plantigrade.options import OptionalPath


@dataclass(frozen=True, kw_only=True)
class Command(RunOptions):
    """Put the motion of a run on a robot, an MJCF model with two legs.

    Feet that stand, parts that do not pass through one another, pelvis and trunk, then limbs: in
    this strict order. Writes motion.npz (mjlab), trajectory.npz (loco-mujoco) and motion.csv. The
    exit code is 3 if a foot slips or sinks, or a joint is beyond its range.
    """

    ranges = {"rate": (10, 1000, "Hz")}

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder: the motion of a person on level ground."""
    to: OptionalPath = None
    """MJCF file of the robot, its meshes beside it."""
    names: OptionalPath = None
    """TOML file that says which body is which, for names that tell nothing: hip_l = "link_3"."""
    rate: float = 50.0
    """Frames per second of the robot's motion [Hz]."""

    def run(self) -> Outcome:
        """Retarget, and write the folder.

        Raises:
            ParameterError: If no robot is named, or the ground is not level.
            FileError: If a file or the run cannot be read.
            FitError: If the robot's legs cannot be identified.
        """
        from plantigrade import __version__
        from plantigrade.commands.progress import Progress
        from plantigrade.record import Run
        from plantigrade.record.provenance import source_files
        from plantigrade.robots import RetargetSettings, Robot, retarget
        from plantigrade.robots.robot import read_names

        if self.to is None:
            raise ParameterError("name the robot: --to robot.xml")
        if self.run_folder.is_file():
            remedy = "`plantigrade fit` first: it puts the motion of any file on a human"
            raise FileError(self.run_folder, "is a file, not a run folder", remedy=remedy)
        progress = Progress(quiet=self.quiet)
        name = f"retarget-{self.run_folder.name}-{self.to.stem}"
        self.refuse_existing(name)
        names = None if self.names is None else read_names(self.names)
        robot = Robot.load(self.to, names)
        record = Run.load(self.run_folder).record
        began = time.perf_counter()
        with progress.step(f"retargeting to {self.to.stem}") as reached:
            settings = RetargetSettings(rate=self.rate)
            motion = retarget(record, robot, settings, reached=reached)
        read = [self.to, *([] if self.names is None else [self.names])]
        metrics = {
            "status": motion.status,
            "version": __version__,
            "kind": "retarget",
            "command": command_line(),
            "settings": {"rate": self.rate, "run": self.run_folder, "to": self.to},
            "source_files": source_files(read),
            "seconds": {"retarget": time.perf_counter() - began},
            **motion.figures,
            "bodies": {part: robot.model.body(k).name for part, k in robot.joints.items()},
            "warnings": motion.warnings,
        }
        folder = motion.save(self.out, name=name, metrics=metrics, overwrite=self.overwrite)
        for note in motion.warnings:
            progress.warn(note)
        return Outcome(summary(folder, motion.status, motion.figures), metrics, (folder,))


def summary(folder: Path, status: str, f: dict[str, float]) -> str:
    """Return the summary that is printed."""
    verdict = "check passed" if status == "ok" else f"CHECK FAILED: {status}"
    return "\n".join(
        [
            f"{folder}: {f['duration_s']:.2f} s at {f['rate_hz']:g} Hz, {verdict}",
            f"  size             {f['scale']:.2f} of the person's legs",
            f"  feet             slip by {f['slip_max_mm']:.2f} mm at most, "
            f"{f['depth_max_mm']:.2f} mm below the ground",
            f"  errors (RMS)     hips {f['hip_error_mm']:.0f} mm, pelvis "
            f"{f['pelvis_error_deg']:.1f}°, limbs {f['limb_error_deg']:.1f}°",
            f"  arms             held {f['arm_abduction_deg']:.0f}° away from the body; parts "
            f"{f['self_contact_max_mm']:.1f} mm inside one another",
            f"  joints           {f['hinge_speed_max_rad_s']:.1f} rad/s at most",
            f"  files            {folder / 'motion.npz'}, motion.csv, trajectory.npz",
        ]
    )
