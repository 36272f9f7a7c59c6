"""Train walking policies."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from plantigrade.commands.options import RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, optional
from plantigrade.workflows.settings import TrainSettings


@dataclass(frozen=True, kw_only=True)
class Command(TrainSettings, RunOptions):
    """Train a walking policy on a reference walk by reinforcement learning.

    The reference is a recording, which is fitted first, or a run; by default a published mean walk.
    Requires pip install '.[learn]'. With --resume, interrupted training continues. The
    exit code is 0 if every seed reached the goal, otherwise 3.
    """

    source: Annotated[tyro.conf.Positional[Path | None], optional("[FILE|RUN]")] = None
    """Recording or run folder with the reference walk."""
    resume: Flag = False
    """Continue an interrupted training in the --out folder."""

    def __post_init__(self):
        super().__post_init__()
        if self.resume and self.overwrite:
            raise ParameterError(
                "--resume continues a training, --overwrite replaces it: give only one"
            )

    def run(self) -> Outcome:
        """Train, and print where the policies are."""
        from plantigrade.commands.progress import Progress
        from plantigrade.record.run import RUNS
        from plantigrade.workflows.train import SPREAD, train

        progress = Progress(quiet=self.quiet)
        out = self.out or RUNS / f"train-{'textbook' if self.source is None else self.source.stem}"
        try:
            taught = train(
                self.source,
                TrainSettings.of(self),
                out=out,
                resume=self.resume,
                overwrite=self.overwrite,
                step=progress.step,
                tell=lambda seed, row: progress.say(line(seed, row)),
            )
        except KeyboardInterrupt:
            progress.warn(f"stopped; nothing is lost: continue with --resume --out {out}")
            raise SystemExit(130) from None
        said = [f"{one.folder}: {ended(one.reached, one.last)}" for one in taught]
        if self.seeds > 1:
            said.append(f"  learning curves  {Path(out) / SPREAD}")
        file = taught[0].folder / "policy.npz"
        said.append(f"  try it           plantigrade simulate --controller {file}")
        missed = [one.seed for one in taught if self.goal and not one.reached]
        metrics: dict[str, Any] = {
            "status": "ok",
            "seeds": [one.seed for one in taught],
            "decisions": [one.last.decisions for one in taught],
            "training_s": [one.last.seconds for one in taught],
            "falls_per_min": [one.last.falls_per_minute for one in taught],
            "goal_reached": [one.reached for one in taught],
        }
        if missed:
            metrics["status"] = f"goal not reached with seed {', '.join(map(str, missed))}"
        return Outcome("\n".join(said), metrics)


def line(seed: int, row: Any) -> str:
    """Return a line of progress."""
    looked = (
        ""
        if row.standing < 0
        else f"; {row.standing} of 16 walks without a fall, mean {row.lasted:.1f} s"
    )
    return (
        f"seed {seed}: {row.decisions / 1e6:.2f} M decisions, {row.seconds / 60:.1f} min: reward "
        f"{row.reward:.2f} (pose {row.pose:.2f}, velocity {row.velocity:.2f}, com {row.com:.2f}, "
        f"ends {row.ends:.2f}), {row.falls_per_minute:.1f} falls/min{looked}"
    )


def ended(reached: bool, row: Any) -> str:
    """Return how a training ended."""
    how = "goal reached" if reached else "ended"
    return f"{how} after {row.decisions / 1e6:.2f} M decisions, {row.seconds / 60:.1f} min"
