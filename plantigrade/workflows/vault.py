"""A gymnast on the vaulting table: search the activations, record the best vault; a Run."""

import time as clock
from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.analyze.check import check
from plantigrade.models import Human
from plantigrade.record import Provenance, Run
from plantigrade.vault.approach import NAMES, Approach
from plantigrade.vault.result import Vaulted
from plantigrade.vault.search import OPTIMISERS, Found, Search, searched
from plantigrade.vault.segments import Segments
from plantigrade.vault.simulation import Vault
from plantigrade.vault.table import Table
from plantigrade.workflows.fit import Step, silent
from plantigrade.workflows.settings import VaultSettings
from plantigrade.workflows.threads import on_one_thread

HEIGHT, MASS = 1.66, 63.0
"""Of the gymnast where nothing is said [m, kg]: about the mean of elite men, an estimate."""
FINE = 1e-4
"""Step of the vault that is recorded: 10 times finer than those of the search [s]."""


@on_one_thread
def vault(
    settings: VaultSettings | None = None,
    *,
    jobs: int = 1,
    step: Step = silent,
    command: str = "",
    **options: Any,
) -> Run:
    """Search the vault with the greatest vertical velocity at take-off.

    Args:
        settings: What decides the result.
        jobs: How many searches are done side by side; -1 for one per core.
        step: Shows progress.
        command: The command line, for the provenance.
        options: Fields of ``settings`` by name, such as ``speed=5.2`` [m/s]; they replace those
            of ``settings``.

    Returns:
        A run. Where the hands do not leave the table in any vault, or the checker finds something
        wrong, its ``status`` says so.

    Raises:
        ParameterError: If there is no such option, a value is not allowed, or the hands would
            never touch the table.

    Example:
        >>> run = vault(starts=1, evaluations=300, optimiser="evolution")
        >>> run.figures["contact_time_s"] < 0.4
        True
    """
    how = VaultSettings.given("vault", settings, options)
    gymnast = the_vault(how)
    assert gymnast.start is not None  # refuses hands that never touch before any search
    names = OPTIMISERS if how.optimiser == "both" else (how.optimiser,)
    began = clock.perf_counter()
    with step(f"searching from {how.starts * len(names)} starts"):
        search = Search(gymnast, how.evaluations, how.activation)
        every = searched(search, names, how.starts, seed=how.seed, jobs=jobs)
    searching = clock.perf_counter() - began
    with step("recording and checking"):
        return run_of(how, gymnast, every, searching, command)


def the_vault(how: VaultSettings) -> Vault:
    """Return who arrives at what, and how."""
    person = {"height": HEIGHT, "mass": MASS, **how.known, "joints": "42", "feet": "rigid"}
    approach = Approach(**{name: getattr(how, name) for name in NAMES})
    elbow = float(approach.posture[2]) if how.five_segments else None
    told = {name: getattr(how, name) for name in Table.ranges}
    return Vault(Segments(Human.create(**person), elbow), Table(**told), approach)


def run_of(
    how: VaultSettings, gymnast: Vault, every: tuple[Found, ...], seconds: float, command: str
) -> Run:
    """Return the run of the best vault that was found."""
    fine = gymnast.with_step(FINE)
    vaulted = Vaulted(fine, fine.contact(every[0].nodes))
    record = vaulted.record()
    verdict = check(record)
    hinge, share = vaulted.held
    notes = ()
    if share > 100.0:
        notes = (
            f"{hinge}, which the model's rigid segments hold, would need {share:.0f} % of its "
            "strength",
        )
    left = vaulted.contact.left
    status = verdict.status if verdict.status else "ok"
    if not left:
        tried = sum(f.evaluations for f in every)
        status = f"in {tried} vaults the hands never left the table: arrive faster"
    figures = {**figures_of(vaulted), **search_figures(every), **verdict.figures()}
    human = gymnast.segments.human
    words = f"{'five' if how.five_segments else 'six'} segments"
    sentence = (
        f"Contact with the vaulting table of a gymnast of {human.height:.2f} m and "
        f"{human.mass:.1f} kg as {words}, arriving at {how.speed:g} m/s forward and {how.rise:g} "
        f"m/s upward, with the greatest vertical velocity at take-off that {len(every)} searches "
        "found."
    )
    return Run(
        replace(record, signals={**record.signals, **verdict.signals()}, notes=notes),
        "vault",
        f"Vault, {words}",
        sentence,
        status,
        figures,
        Provenance(command, how.plain(), {}, how.seed),
        seconds={"search": seconds},
        name="five-segments" if how.five_segments else "six-segments",
    )


def figures_of(vaulted: Vaulted) -> dict[str, Any]:
    """Return what a vault shows."""
    contact, vault = vaulted.contact, vaulted.vault
    theta, rate, _ = vaulted.coordinates
    weight = vault.segments.human.mass * 9.81
    forward, up = contact.extras[-1, 2], contact.extras[-1, 3]
    hinge, share = vaulted.held
    turn = np.rad2deg(-theta[:, 2]) - 90.0
    elbow = np.pi - theta[:, 4]
    return {
        "take_off_speed_m_s": float(up),
        "take_off_forward_m_s": float(forward),
        "take_off_angle_deg": float(np.rad2deg(np.arctan2(up, forward))),
        "speed_gained_m_s": float(up - vault.approach.rise),
        "contact_time_s": float(contact.time[-1]),
        "hand_force_up_max_bw": float(contact.extras[:, 1].max() / weight),
        "hand_force_back_max_bw": float(-contact.extras[:, 0].min() / weight),
        "table_depth_max_mm": float(-1000.0 * contact.extras[:, 5].min()),
        "trunk_touchdown_deg": float(turn[0]),
        "trunk_take_off_deg": float(turn[-1]),
        "trunk_rate_take_off_deg_s": float(-np.rad2deg(rate[-1, 2])),
        "elbow_touchdown_rad": float(elbow[0]),
        "elbow_take_off_rad": float(elbow[-1]),
        "joint_strength_max_pct": float(100.0 * contact.extras[:, 6].max()),
        "held_joint": hinge,
        "held_joint_strength_max_pct": share,
        "energy_error": vaulted.energy_error,
    }


def search_figures(every: tuple[Found, ...]) -> dict[str, Any]:
    """Return how the searches ended, by optimiser."""
    figures: dict[str, Any] = {
        "optimiser": every[0].optimiser,
        "evaluations": sum(f.evaluations for f in every),
    }
    for name in OPTIMISERS:
        ends = [f.rise for f in every if f.optimiser == name and np.isfinite(f.rise)]
        if ends:
            figures |= {
                f"{name}_best_m_s": max(ends),
                f"{name}_mean_m_s": float(np.mean(ends)),
                f"{name}_sd_m_s": float(np.std(ends, ddof=1)) if len(ends) > 1 else 0.0,
                f"{name}_seconds": sum(f.seconds for f in every if f.optimiser == name),
            }
    return figures
