"""A gymnast on the vaulting table: search the activations, record the best vault; a Run."""

import time as clock
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from plantigrade.analyze.check import check
from plantigrade.extras import require
from plantigrade.models import Human
from plantigrade.record import Provenance, Run
from plantigrade.signatures import takes
from plantigrade.threads import on_one_thread
from plantigrade.vaulting.approach import APPROACH_FIELDS, Approach
from plantigrade.vaulting.approach_sensitivity import ApproachChange, ranking, sensitivity
from plantigrade.vaulting.hand_contact import MAX_CONTACT_TIME, Vault
from plantigrade.vaulting.search import OPTIMISERS, Search, SearchResult, search_activations
from plantigrade.vaulting.segments import Segments
from plantigrade.vaulting.table import VaultingTable
from plantigrade.vaulting.vault_result import VaultResult, angular_difference
from plantigrade.workflows.settings import VaultSettings
from plantigrade.workflows.steps import Step, silent

HEIGHT = 1.66
"""Default height of the gymnast [m]: about the mean of elite men, an estimate."""
MASS = 63.0
"""Default mass of the gymnast [kg]: about the mean of elite men, an estimate."""
RECORDING_STEP = 1e-4  # [s] of the recorded vault: 10 times finer than in the search


@takes(VaultSettings, without=("joints", "feet", "age"))
def vault(
    settings: VaultSettings | None = None,
    *,
    jobs: int = 1,
    backend: Literal["loky", "ray", "dask"] = "loky",
    address: str | None = None,
    **options: Any,
) -> Run:
    """Search the vault with the greatest vertical velocity at take-off.

    Args:
        settings: What decides the result; options replace its fields.
        jobs: How many searches are done side by side; -1 for one per core.
        backend: Where they run: ``loky``, ``ray`` or ``dask``.
        address: Of a running Ray or Dask cluster.
        options: Fields of ``VaultSettings``.

    Returns:
        A run. Where the hands do not leave the table in any vault, or the checker finds something
        wrong, its ``status`` says so.

    Raises:
        ParameterError: If there is no such option, a value is not allowed, or the hands would
            never touch the table.

    Example:
        >>> run = vault(speed=5.2, starts=2, jobs=2)  # doctest: +SKIP
        >>> run.figures["take_off_speed_m_s"]  # doctest: +SKIP
    """
    how = VaultSettings.given("vault", settings, options)
    return run_vault(how, jobs=jobs, backend=backend, address=address)


@on_one_thread
def run_vault(
    how: VaultSettings,
    *,
    jobs: int = 1,
    backend: str = "loky",
    address: str | None = None,
    step: Step = silent,
    command: str = "",
) -> Run:
    """Search with given settings: what :func:`vault` and the command do.

    ``step`` shows progress, and ``command`` is for the provenance.
    """
    require("casadi", "synthesis")
    gymnast = the_vault(how)
    assert gymnast.start is not None  # refuses hands that never touch before any search
    names = OPTIMISERS if how.optimiser == "both" else (how.optimiser,)
    parallel = {"jobs": jobs, "backend": backend, "address": address}
    began = clock.perf_counter()

    def search(who: Vault) -> tuple[SearchResult, ...]:
        words = (
            f"searching with {who.segments.count} segments from {how.starts * len(names)} starts"
        )
        with step(words) as reached:
            how_to = Search(who, how.evaluations, how.activation)
            return search_activations(
                how_to, names, how.starts, seed=how.seed, parallel=parallel, reached=reached
            )

    every = search(gymnast)
    other = the_vault(replace(how, five_segments=not how.five_segments)) if how.compare else None
    other_model = None if other is None else (other, search(other))
    changes: tuple[ApproachChange, ...] = ()
    if how.sensitivity:
        with step("changing the approach") as reached:
            changes = sensitivity(
                gymnast, every[0], max_activation=how.activation, parallel=parallel, reached=reached
            )
    seconds = clock.perf_counter() - began
    with step("recording and checking"):
        return run_of(how, gymnast, every, command, seconds, other_model, changes)


def the_vault(how: VaultSettings) -> Vault:
    """Return who arrives at what, and how."""
    person = {"height": HEIGHT, "mass": MASS, **how.known, "joints": "42", "feet": "rigid"}
    approach = Approach(**{name: getattr(how, name) for name in APPROACH_FIELDS})
    elbow = float(approach.posture[2]) if how.five_segments else None
    dimensions = {name: getattr(how, name) for name in VaultingTable.ranges}
    return Vault(Segments(Human.create(**person), elbow), VaultingTable(**dimensions), approach)


def run_of(
    how: VaultSettings,
    gymnast: Vault,
    every: tuple[SearchResult, ...],
    command: str = "",
    seconds: float = 0.0,
    other_model: tuple[Vault, tuple[SearchResult, ...]] | None = None,
    changes: tuple[ApproachChange, ...] = (),
) -> Run:
    """Return the run of the best vault that was found.

    Args:
        gymnast: Name and approach of the gymnast.
        every: What all searches found, the best first.
        seconds: How long the searches took [s].
        other_model: The model with the other number of segments, and results of its searches.
        changes: What changes with the approach.
    """
    vaulted = recorded(gymnast, every[0])
    figures = {**figures_of(vaulted), **search_figures(every)}
    references, signals = {}, {}
    if other_model is not None:
        theirs = recorded(other_model[0], other_model[1][0])
        words = f"{other_model[0].segments.count} segments"
        references[words] = theirs.motion
        figures["other_take_off_speed_m_s"] = theirs.contact.rise
        figures["other_angular_difference_pct"] = angular_difference(vaulted, theirs)
    if changes:
        signals["vault.changed"] = np.array([c.name for c in changes])
        signals["vault.change"] = np.array([(c.share, c.same, c.anew) for c in changes])
        for name, far in ranking(changes, every[0].rise):
            figures[f"sensitivity_{name}_m_s"] = far
    record = vaulted.record(references)
    verdict = check(record)
    hinge, share = vaulted.most_loaded_fixed_joint
    notes = ()
    if share > 100.0:
        notes = (f"{hinge}, which is rigid in the model, would need {share:.0f} % of its strength",)
    human, words = gymnast.segments.human, f"{gymnast.segments.count} segments"
    sentence = (
        f"Contact with the vaulting table of a gymnast of {human.height:.2f} m and "
        f"{human.mass:.1f} kg as {words}, arriving at {how.speed:g} m/s forward and {how.rise:g} "
        f"m/s upward, with the greatest vertical velocity at take-off that {len(every)} searches "
        "found."
    )
    signals |= {**record.signals, **verdict.signals()}
    return Run(
        replace(record, signals=signals, notes=notes),
        "vault",
        f"Vault with {words}",
        sentence,
        _failure(vaulted, every) or verdict.status,
        {**figures, **verdict.figures()},
        Provenance(command, how.plain(), {}, how.seed),
        seconds={"search": seconds, **_seconds(every)},
        name=f"vault-{gymnast.segments.count}-segments",
    )


def _failure(vaulted: VaultResult, every: tuple[SearchResult, ...]) -> str:
    """Return why the best vault failed, and what to do; empty if it succeeded."""
    if not vaulted.contact.left:
        tried = sum(f.evaluations for f in every)
        return (
            f"in {tried} vaults the hands never left the table within {MAX_CONTACT_TIME:g} s: "
            "arrive faster, or on a stiffer table"
        )
    if vaulted.contact.rise <= 0.0:
        return (
            f"the best of the vaults leaves the table with the centre of mass falling at "
            f"{-vaulted.contact.rise:.1f} m/s: arrive faster, or with more rise"
        )
    return ""


def recorded(gymnast: Vault, found: SearchResult) -> VaultResult:
    """Return a vault that was found, in fine steps."""
    fine = gymnast.with_step(RECORDING_STEP)
    return VaultResult(fine, fine.contact(found.nodes))


def figures_of(vaulted: VaultResult) -> dict[str, Any]:
    """Return what a vault shows."""
    contact, vault = vaulted.contact, vaulted.vault
    angles = vaulted.angles
    weight = vault.segments.human.mass * vault.segments.human.gravity
    forward, up = contact.extras[-1, 2], contact.extras[-1, 3]
    hinge, share = vaulted.most_loaded_fixed_joint
    turn, elbow = np.rad2deg(angles[:, 0]), angles[:, 2]
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
        "somersault_take_off_deg_s": float(np.rad2deg(vaulted.somersault(-1))),
        "elbow_touchdown_rad": float(elbow[0]),
        "elbow_take_off_rad": float(elbow[-1]),
        "joint_strength_max_pct": float(100.0 * contact.extras[:, 6].max()),
        "held_joint": hinge,
        "held_joint_strength_max_pct": share,
        "energy_error": vaulted.energy_error,
    }


def _seconds(every: tuple[SearchResult, ...]) -> dict[str, float]:
    """Return how long the searches of each optimiser took [s]."""
    return {
        name: sum(found.seconds for found in every if found.optimiser == name)
        for name in OPTIMISERS
        if any(found.optimiser == name for found in every)
    }


def search_figures(every: tuple[SearchResult, ...]) -> dict[str, Any]:
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
            }
    return figures
