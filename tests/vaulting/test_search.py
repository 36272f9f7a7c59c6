"""Searches of activations, their results and the Record of a vault."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.check import check
from plantigrade.errors import ParameterError
from plantigrade.vaulting import (
    Approach,
    Search,
    Vault,
    VaultResult,
    search_activations,
    sensitivity,
)
from plantigrade.vaulting.approach_sensitivity import ranking
from plantigrade.vaulting.vault_result import angular_difference


def test_both_optimisers_beat_random_activations_within_bounds(vault):
    search = Search(vault, evaluations=180, max_activation=0.8)
    found = search_activations(search, starts=1, seed=3)
    assert [f.rise for f in found] == sorted((f.rise for f in found), reverse=True)
    rng = np.random.default_rng(3)
    chance = [vault.objective(rng.uniform(-0.8, 0.8, (6, 5))) for _ in range(5)]
    for each in found:
        assert each.rise > np.median(chance) and np.abs(each.nodes).max() <= 0.8
        assert each.rise == pytest.approx(vault.objective(each.nodes), abs=1e-12)
        assert each.evaluations <= 200
    again = Search(vault, evaluations=60, max_activation=0.8)
    assert np.array_equal(again(("simplex", 3)).nodes, again(("simplex", 3)).nodes)


def test_the_record_of_a_vault_passes_the_check(vault, nodes):
    fine = vault.with_step(2.5e-4)
    vaulted = VaultResult(fine, fine.contact(nodes))
    record = vaulted.record()
    verdict = check(record)
    assert verdict.ok, verdict.status
    assert verdict.measures["root_force"].value < 1e-9
    force, human = record.contact_force, record.human
    assert force is not None and [s.name for s in record.sites[:2]] == ["palm_r", "palm_l"]
    # The impulse of hands and weight is the change of momentum.
    time = record.motion.time
    impulse = np.trapezoid(force.sum(axis=1), time, axis=0)
    impulse[2] -= human.mass * 9.81 * time[-1]
    start, end = vaulted.contact.extras[[0, -1], 2:4]
    assert impulse[[0, 2]] == pytest.approx(human.mass * (end - start), rel=1e-4, abs=1e-2)
    assert start == pytest.approx([vault.approach.speed, vault.approach.rise], abs=1e-9)
    assert vaulted.somersault(0) == pytest.approx(vault.approach.somersault, rel=1e-9)
    assert vaulted.contact.left and vaulted.contact.extras[-1, 1] < 1e-3
    for name in ("hip_flexion", "elbow_flex"):
        assert np.array_equal(record.motion[f"{name}_r"], record.motion[f"{name}_l"])
    # A wrong hand force fails the check.
    wrong = replace(record, contact_force=1.05 * force)
    assert not check(wrong).ok


@pytest.mark.parametrize(
    ("approach", "message"),
    [
        ({"rise": 5.0, "somersault": 0.0}, "hands never touch the table: they move up at"),
        ({"trunk": -0.4}, "hands never touch the table: the centre of mass would be"),
    ],
)
def test_an_approach_without_hand_contact_raises(vault, approach, message):
    with pytest.raises(ParameterError, match=message):
        assert vault.with_approach(Approach(**approach)).start is not None


def test_a_contact_longer_than_the_maximum_has_no_take_off(vault, nodes, monkeypatch):
    monkeypatch.setattr("plantigrade.vaulting.hand_contact.MAX_CONTACT_TIME", 0.05)
    contact = vault.contact(nodes)
    assert not contact.left and contact.time[-1] == pytest.approx(0.05, abs=2e-3)
    assert vault.objective(nodes) == -np.inf
    record = VaultResult(vault, contact).record()
    assert np.isfinite(record.motion.qpos).all() and record.contact_force[-1, 0, 2] > 100.0


def test_the_angular_difference_of_a_vault_to_itself_is_zero(vault, nodes):
    one = VaultResult(vault, vault.contact(nodes))
    other = VaultResult(vault, vault.contact(0.5 * nodes))
    assert angular_difference(one, one) == 0.0 < angular_difference(one, other) < 20.0


def test_activations_are_between_flexion_and_extension(vault, nodes):
    with pytest.raises(ParameterError, match="activation of -1.6 is not between -1"):
        vault.contact(-2.0 * nodes[:, ::-1] + 0.2)
    with pytest.raises(ParameterError, match="one column for each of shoulder, elbow, hip"):
        vault.contact(nodes[:, :4])


@pytest.mark.slow
def test_five_segments_fix_the_elbow_and_pass_the_check(vault):
    elbow = float(vault.approach.posture[2])
    five = Vault(replace(vault.segments, elbow=elbow), vault.table, vault.approach)
    found = search_activations(Search(five, evaluations=600), ("evolution",), starts=1)
    fine = five.with_step(1e-4)
    vaulted = VaultResult(fine, fine.contact(found[0].nodes))
    record = vaulted.record()
    assert np.allclose(record.motion["elbow_flex_r"], np.pi - 2.98, atol=1e-12)
    assert check(record).ok and vaulted.energy_error < 1e-6


@pytest.mark.slow
def test_sensitivity_ranks_the_fields_of_the_approach(vault, monkeypatch):
    monkeypatch.setattr("plantigrade.vaulting.approach_sensitivity.REFINEMENT_EVALUATIONS", 100)
    found = search_activations(Search(vault, evaluations=600), ("evolution",), starts=1)[0]
    changes = sensitivity(vault, found)
    assert len(changes) == 18
    for each in changes:
        assert each.anew >= each.same - 1e-12
    order = ranking(changes, found.rise)
    assert order[0][1] >= order[-1][1] >= 0.0 and len(order) == 9
