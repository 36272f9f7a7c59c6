"""Write the report and the viewer page of a run anew."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import FileError


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Write the report and the viewer page of a run anew."""

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to report on."""

    def run(self) -> Outcome:
        """Do it."""
        from dataclasses import replace

        from plantigrade.commands.run_folder import open_run
        from plantigrade.record.npz import read_npz
        from plantigrade.report.reproduction import read_reproduction
        from plantigrade.report.run_report import run_pages
        from plantigrade.report.synthesis import read_drawing
        from plantigrade.workflows import reproduce as reproducing
        from plantigrade.workflows import synthesis_folder
        from plantigrade.workflows.foot_segments import read_foot_segments

        model, record, metrics = open_run(self.run_folder)
        feet = read_foot_segments(self.run_folder)
        gait = read_reproduction(self.run_folder)
        made = read_drawing(self.run_folder)
        title = metrics.get("title") or self.run_folder.resolve().name
        words = {"title": title, "sentence": metrics.get("sentence") or ""}
        record = replace(record, metrics=metrics | words)
        if gait is not None:
            forces = self.run_folder / reproducing.FORCES
            pages = reproducing.pages(
                model, record, gait, read_npz(forces) if forces.is_file() else None
            )
        elif made is not None:
            pages = synthesis_folder.pages(model, record, made)
        else:
            pages = run_pages(
                model,
                record,
                title=words["title"],
                sentence=words["sentence"],
                extra=[feet.section()] if feet else (),
            )
        written = []
        for name, text in pages.items():
            written.append(self.run_folder / name)
            temporary = self.run_folder / f".{name}.part"
            try:
                temporary.write_text(text, encoding="utf-8")
                temporary.replace(written[-1])
            except OSError as error:
                raise FileError(
                    written[-1],
                    f"cannot be written ({error.strerror or error})",
                    remedy="check that the run folder may be written to",
                ) from error
        return Outcome("\n".join(str(path) for path in written), metrics)
