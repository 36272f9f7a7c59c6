"""Many simulations by one command: what ``simulate --seeds`` and ``--vary`` do."""

from pathlib import Path
from typing import TYPE_CHECKING

from plantigrade.commands.options import command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.workflows.simulate_settings import SimulateSettings

if TYPE_CHECKING:
    from plantigrade.commands.simulate import Command


def several(options: "Command") -> Outcome:
    """Simulate all combinations, and write their table."""
    from plantigrade.commands.progress import Progress
    from plantigrade.record.folder import read_metrics
    from plantigrade.record.run import RUNS
    from plantigrade.report.batch_table import PAGE
    from plantigrade.workflows.batch import simulate_many

    progress = Progress(quiet=options.quiet)
    name = options.source.stem if options.source else "standing"
    folder = options.out or RUNS / f"simulations-{name}"
    batch = simulate_many(
        options.source,
        SimulateSettings.of(options),
        vary=varied(options.vary),
        seeds=options.seeds,
        out=folder,
        overwrite=options.overwrite,
        jobs=options.jobs,
        backend=options.backend,
        address=options.address,
        say=progress.say,
        step=progress.step,
        command=command_line(),
    )
    for one in batch.members:
        if one.problem:
            progress.warn(f"{one.name}: {one.problem}")
    if batch.seeds_alike:
        progress.warn(
            "all seeds gave the same result: nothing in this simulation is random (--start-noise, "
            "--sensor-noise-deg and uneven ground such as bumps:2 are)"
        )
    lines = [f"{folder}: {batch.on_feet} of {len(batch.members)} on their feet at the end"]
    lines.append(f"  table            {folder / PAGE}")
    return Outcome("\n".join(lines), read_metrics(Path(folder)))


def varied(given: tuple[tuple[str, ...], ...]) -> dict[str, list[str]]:
    """Return option → values, of what was given as name and values.

    Raises:
        ParameterError: If there are no values, or an option comes twice.

    Example:
        >>> varied((("ground", "flat", "slope:5"), ("control-rate", "30", "100")))
        {'ground': ['flat', 'slope:5'], 'control_rate': ['30', '100']}
    """
    found: dict[str, list[str]] = {}
    for words in given:
        name, values = words[0].lstrip("-").replace("-", "_") if words else "", list(words[1:])
        if not values or name in found:
            raise ParameterError(
                f"--vary {' '.join(words)}: give each option once, followed by its values, such as "
                "--vary ground flat slope:5"
            )
        found[name] = values
    return found
