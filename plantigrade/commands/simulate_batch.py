"""Many simulations by one command: what ``simulate --seeds`` and ``--vary`` do."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plantigrade.commands.batch_options import BatchOptions, batch_folder, batch_outcome
from plantigrade.commands.options import RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.workflows.simulate_settings import SimulateSettings


def several(
    options: BatchOptions,
    settings: SimulateSettings,
    sources: Sequence[Path],
    vary: Mapping[str, Sequence[Any]],
    seeds: int,
) -> Outcome:
    """Simulate all combinations, and write their table.

    Args:
        options: Options of the batch and of its folder.
        settings: Settings of all simulations.
        sources: Recordings and runs; none for a person who stands.
        seeds: Number of seeds of each combination.
    """
    from plantigrade.commands.progress import Progress
    from plantigrade.workflows.simulate_many import simulate_batch

    assert isinstance(options, RunOptions)
    progress = Progress(quiet=options.quiet)
    name = f"{sources[0].stem}" if sources else "standing"
    if len(sources) > 1:
        name += f"-and-{len(sources) - 1}-more"
    batch = batch_folder(
        options,
        f"simulations-{name}",
        lambda out: simulate_batch(
            list(sources) or None,
            settings,
            vary,
            seeds,
            options.batch_settings(out, progress),
            command=command_line(),
        ),
    )
    outcome = batch_outcome(batch, progress)
    if seeds > 1 and batch.seeds_alike:
        progress.warn(
            "all seeds gave the same result: nothing in this simulation is random (--start-noise, "
            "--sensor-noise-deg and uneven ground such as bumps:2 are)"
        )
    return outcome


def varied(given: tuple[tuple[str, ...], ...]) -> dict[str, list[str]]:
    """Return option → values, of what was given as name and values.

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
