"""What is stopped goes on as if it had not been; a goal ends it. Needs torch: skipped without."""

import importlib
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.learn import Policy, ReferenceMotion, Rules
from plantigrade.models import Human

pytest.importorskip("stable_baselines3", reason="training needs the extra: torch")
training = importlib.import_module("plantigrade.learn.training")
Hyperparameters, Training = training.Hyperparameters, training.Training

SMALL = Human.create(1.7, 65.0, "female", "42", "rigid")
HOW = Hyperparameters(
    persons=4, steps=8, updates=1, epochs=2, batch=16, layers=(8, 8), evaluation_starts=2
)


@pytest.fixture(scope="module")
def rules():
    return Rules(reference=ReferenceMotion.textbook(SMALL), passive=True, mirrored=True)


def test_what_was_stopped_ends_in_the_same_policy(rules, tmp_path):
    """Number for number, with any number of processes; another seed does not."""
    whole, parts, other = (tmp_path / name for name in ("whole", "parts", "other"))
    for folder in (whole, parts, other):
        folder.mkdir()
    Training(rules, whole, max_decisions=96, hyperparameters=HOW).run()
    rows = []
    Training(rules, parts, max_decisions=32, hyperparameters=HOW).run(rows.append)
    again = Training(rules, parts, max_decisions=96, hyperparameters=HOW)
    assert again.decisions == 32 and [row.decisions for row in again.curve] == [32]
    again.run(rows.append)
    assert [row.decisions for row in rows] == [32, 64, 96]
    assert (whole / "policy.npz").read_bytes() == (parts / "policy.npz").read_bytes()
    (tmp_path / "shared").mkdir()
    shared = Training(rules, tmp_path / "shared", max_decisions=96, hyperparameters=HOW, jobs=3)
    shared.run()
    shared.close()
    assert (whole / "policy.npz").read_bytes() == (tmp_path / "shared/policy.npz").read_bytes()
    Training(rules, other, seed=1, max_decisions=96, hyperparameters=HOW).run()
    assert (whole / "policy.npz").read_bytes() != (other / "policy.npz").read_bytes()
    lines = (parts / "curve.csv").read_text("utf-8").splitlines()
    assert lines[0].startswith("decisions,seconds,reward") and len(lines) == 4
    assert not list(parts.glob(".*"))
    with pytest.raises(ParameterError, match="another training: mirrored differ"):
        Training(replace(rules, mirrored=False), parts, hyperparameters=HOW)
    path, torch = parts / "checkpoint.pt", training._torch
    whole_state = torch.load(path, weights_only=True)
    for name in ("policy", "optimizer", "mean", "count", "rate", "reached"):
        torch.save({k: v for k, v in whole_state.items() if k != name}, path)
        with pytest.raises(FileError, match=f"damaged checkpoint: '{name}'"):
            Training(rules, parts, hyperparameters=HOW)
    torch.save({**whole_state, "var": np.nan * whole_state["var"]}, path)
    with pytest.raises(FileError, match="not finite"):
        Training(rules, parts, hyperparameters=HOW)
    path.write_bytes(b"nothing")
    with pytest.raises(FileError, match="not a checkpoint"):
        Training(rules, parts, hyperparameters=HOW)
    with pytest.raises(ParameterError, match="device='nonsense'"):
        Training(rules, whole, hyperparameters=HOW, device="nonsense")


def test_it_begins_with_a_policy_and_listens_first(rules, tmp_path):
    """In the first part only the critic learns."""
    (tmp_path / "first").mkdir()
    first = Training(rules, tmp_path / "first", max_decisions=32, hyperparameters=HOW).run()
    (tmp_path / "next").mkdir()
    taught = Training(
        rules, tmp_path / "next", seed=3, max_decisions=32, hyperparameters=HOW, start=first
    )
    assert taught.run().about["start"] == first.digest and taught.curve[-1].rate == HOW.rate
    again = Training(
        rules, tmp_path / "next", seed=3, max_decisions=64, hyperparameters=HOW, start=first
    )
    same, seen = (
        taught.policy(),
        first.mean + 0.5 * first.scale * np.sin(np.arange(len(first.mean))),
    )
    # It sees as far as it spreads now, and decides the same.
    assert (same.scale >= first.scale * (1.0 - 1e-6)).all() and same.scale.max() > 0.0
    assert (same.scale > 1.01 * first.scale).any()
    decided = first(seen[None])
    np.testing.assert_allclose(same(seen[None]), decided, atol=1e-5)
    assert not np.allclose(again.run()(seen[None]), decided, atol=1e-4)
    assert again.policy().about["start"] == first.digest
    with pytest.raises(ParameterError, match="start differ"):
        Training(rules, tmp_path / "next", seed=3, hyperparameters=HOW)


def test_the_policy_is_what_torch_computes_and_a_goal_ends_it(rules, tmp_path):
    """With a goal that everybody reaches it ends at the first look."""
    import torch

    taught = Training(
        rules, tmp_path, goal=0.1, hyperparameters=replace(HOW, evaluation_interval=2)
    )
    seen = np.random.default_rng(0).normal(size=(3, 15 * len(SMALL.body_names) + 9))
    before = taught.policy()(seen.astype(np.float32))
    rows = []
    # Falls are rarer than one in four seconds where an episode has hardly begun.
    policy = taught.run(rows.append)
    assert taught.reached and rows[-1].standing == 2 and len(rows) == 2
    assert not np.allclose(policy(seen.astype(np.float32)), before)
    loaded = Policy.load(tmp_path / "policy.npz")
    net = taught.network
    with torch.no_grad():
        x = torch.as_tensor(np.clip((seen - policy.mean) / policy.scale, -8, 8), dtype=torch.float)
        expected = net.action_net(net.mlp_extractor.forward_actor(x)).clamp(-1, 1).numpy()
    np.testing.assert_allclose(loaded(seen.astype(np.float32)), expected, atol=1e-5)
    x = torch.linspace(-9.0, 9.0, 99, requires_grad=True)
    ways = (net.mlp_extractor.policy_net[1], torch.nn.functional.elu)
    values = [way(x) for way in ways]
    torch.testing.assert_close(*values)
    torch.testing.assert_close(*(torch.autograd.grad(y.sum(), x)[0] for y in values))
