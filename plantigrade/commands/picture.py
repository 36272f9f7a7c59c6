"""Draw a run as an animated SVG, or as a strip of still frames."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import FileError, ParameterError, RunExists
from plantigrade.options import Flag, OptionalWord, OutPath, Seconds

if TYPE_CHECKING:
    from plantigrade.record import Run

View = Literal["side", "left", "front", "back", "quarter"]
Foot = Literal["right", "left", "none"]


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Draw a run as an animated SVG, or as a strip of still frames.

    The SVG contains no script, so it also plays in a README. A steady gait loops over one stride;
    any other motion plays its first ten seconds, or the interval from --start to --stop.
    """

    ranges = {
        "start": (-1e6, 1e6, "s"),
        "stop": (-1e6, 1e6, "s"),
        "rate": (1, 100, "1/s"),
        "speed": (0.05, 10, "times true speed"),
        "height_px": (100, 2000, "pixels"),
    }

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to draw."""
    out: OutPath = None
    """File to write (.svg); by default picture.svg in the run folder."""
    overwrite: Flag = False
    """Replace the file if it exists outside the run folder."""
    still: Flag = False
    """Draw a strip of still frames instead."""
    view: View = "side"
    """View of the walker: right side, left side, front, back, or three-quarter front."""
    foot: Foot = "right"
    """Foot to show enlarged."""
    solids: Flag = False
    """Draw the solids that physics sees in place of the skin."""
    x_ray: Flag = False
    """Show the bones of the feet through the skin; those of the enlarged foot always show."""
    start: Seconds = None
    """First instant [s]."""
    stop: Seconds = None
    """Last instant [s]."""
    rate: float = 20.0
    """Key frames per second; the browser interpolates between them."""
    speed: float = 1.0
    """Playback speed; 1 is real time."""
    height_px: int = 420
    """Height [pixels]."""
    title: OptionalWord = None
    """Title; that of the run by default."""

    def run(self) -> Outcome:
        """Draw it and write the file, whole or not at all.

        Raises:
            FileError: If the folder is no run folder, or the file is no SVG.
            ParameterError: If a value is not allowed, or the motion cannot be drawn.
            RunExists: If the file exists and is not to be replaced.
        """
        from plantigrade.io.writing import write_text
        from plantigrade.record import Run
        from plantigrade.record.folder import replace_files

        out = self.run_folder / "picture.svg" if self.out is None else self.out
        if out.suffix.lower() != ".svg":
            raise FileError(
                out, f"cannot write a picture as {out.suffix or 'a file without extension'}",
                remedy="choose a name ending in .svg",
            )  # fmt: skip
        self._refuse()
        own = out.parent.resolve() == self.run_folder.resolve()
        if out.exists() and not own and not self.overwrite:
            raise RunExists(f"{out} exists; choose another file or add --overwrite")
        run = Run.load(self.run_folder)
        svg, facts = self._still(run) if self.still else self._moving(run)
        if own:
            replace_files(self.run_folder, {out.name: svg})  # it becomes one of the run's files
        else:
            write_text(out, svg)
        size = len(svg.encode()) / 1000
        metrics = {"status": "ok", "command": "picture", "target_file": out, **facts}
        shown = f"{facts['frames']} still frames"
        if not self.still:
            long = "one looping stride" if facts["loop"] else f"{facts['seconds']:.1f} s"
            shown = f"{long}, {facts['frames']} frames"
        return Outcome(text=f"wrote {out}: {shown}, {size:.0f} kB", metrics=metrics)

    def _refuse(self) -> None:
        if self.still:
            default = Command(run_folder=self.run_folder)
            for name in ("foot", "rate", "speed", "title"):
                if getattr(self, name) != getattr(default, name):
                    raise ParameterError(f"--{name} has no effect with --still")

    def _moving(self, run: "Run") -> tuple[str, dict[str, Any]]:
        from plantigrade.pages.animation import moving_picture
        from plantigrade.pages.run_pages import title_of_run
        from plantigrade.pages.section import ReportedRun

        picture = moving_picture(
            run.record,
            forces=ReportedRun(run).forces,
            view=self.view,
            foot=self.foot,
            start=self.start,
            stop=self.stop,
            rate=self.rate,
            speed=self.speed,
            height_px=self.height_px,
            solids=self.solids,
            x_ray=self.x_ray,
            title=title_of_run(run) if self.title is None else self.title,
        )
        facts = {"frames": picture.frames, "seconds": picture.seconds, "loop": picture.loop}
        return picture.svg, facts

    def _still(self, run: "Run") -> tuple[str, dict[str, Any]]:
        from plantigrade.pages.run_pages import STRIP_PICTURES, strip_of
        from plantigrade.pages.section import ReportedRun

        svg = strip_of(
            ReportedRun(run),
            height_px=self.height_px,
            solids=self.solids,
            x_ray=self.x_ray,
            background="#f6f7f9",
            view=self.view,
            start=self.start,
            stop=self.stop,
        )
        return svg + "\n", {"frames": min(STRIP_PICTURES, run.record.motion.n_frames)}
