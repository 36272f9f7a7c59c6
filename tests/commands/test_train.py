"""The command train: what is missing, stopped, in the way or short of its goal is said."""

import sys
from types import SimpleNamespace

import pytest

from plantigrade.commands import main
from plantigrade.errors import ParameterError
from plantigrade.extras import install_command
from plantigrade.learn import PAPER_GAINS, Gains, ReferenceMotion
from plantigrade.learn.action import LANDING_GAINS
from plantigrade.workflows import train as training
from plantigrade.workflows.settings import TrainSettings

ROW = SimpleNamespace(
    decisions=20480, seconds=30.0, reward=0.7, pose=0.8, velocity=0.1, com=0.9, ends=0.3,
    falls_per_minute=12.0, standing=3, lasted=11.5,
)  # fmt: skip


def test_without_the_extra_it_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.delitem(sys.modules, "plantigrade.learn.training", raising=False)
    monkeypatch.delitem(sys.modules, "plantigrade.learn.sb3_environment", raising=False)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    out = tmp_path / "out"
    assert main.main(["train", "--out", str(out)]) == main.BAD_INPUT
    assert install_command("learn") in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("reached", [True, False])
def test_it_says_how_it_went_and_whether_the_goal_was_reached(
    reached, monkeypatch, tmp_path, capsys
):
    def taught(source, settings, *, tell, **_):
        assert settings.gains == "fixed" and settings.seeds == 1
        tell(0, ROW)
        return (training.Taught(0, tmp_path / "seed-0", reached, ROW),)

    monkeypatch.setattr(training, "train", taught)
    code = main.main(["train", "--gains", "fixed", "--out", str(tmp_path)])
    said = capsys.readouterr()
    assert code == (main.DONE if reached else main.NO_RESULT)
    assert "12.0 falls/min; 3 of 16 walks without a fall, mean 11.5 s" in said.err
    assert ("goal reached" in said.out) == reached and "simulate --controller" in said.out


def test_what_is_stopped_says_how_to_go_on(monkeypatch, tmp_path, capsys):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "train", stopped)
    assert main.main(["train", "--out", str(tmp_path)]) == main.INTERRUPTED
    assert "--resume" in capsys.readouterr().err


def test_a_training_is_neither_lost_nor_mixed(tmp_path, capsys):
    assert main.main(["train", "--resume", "--overwrite"]) == main.BAD_INPUT
    assert "give only one" in capsys.readouterr().err
    (tmp_path / "seed-0").mkdir()
    (tmp_path / "seed-0" / "curve.csv").write_text("decisions\n")
    if "torch" in sys.modules or _there("torch"):
        assert main.main(["train", "--out", str(tmp_path)]) == main.BAD_INPUT
        assert "--resume to take it up" in capsys.readouterr().err


def _there(name: str) -> bool:
    from importlib.util import find_spec

    return find_spec(name) is not None


def test_the_rules_are_the_requested_ones(tmp_path):
    """An even stride is learned in the mirror, as printed it is not; a run has its own person."""
    lean = training.rules_of(None, TrainSettings(joints="42", feet="rigid"))
    assert lean.mirrored and lean.passive and lean.gains
    assert lean.reference.human.height == 1.5 and lean.reference.human.feet == "rigid"
    landing = training.rules_of(
        None, TrainSettings(joints="42", feet="rigid", landing=True, terrain=4.0, pushes=120.0)
    )
    assert lean.weights is None and landing.weights is not None and landing.weights.force > 0.0
    assert landing.terrain == pytest.approx(0.04) and landing.pushes == 120.0
    assert lean.base is None and landing.base == LANDING_GAINS
    raised, as_it_is = (
        training.rules_of(None, TrainSettings(joints="42", feet="rigid", clearance=cm, terrain=t))
        for cm, t in ((3.0, 0.0), (0.0, 4.0))
    )
    digests = [ReferenceMotion.of(r.reference).digest for r in (raised, landing, as_it_is, lean)]
    assert digests[0] == digests[1] != digests[2] == digests[3]
    assert LANDING_GAINS.damping < Gains().damping == PAPER_GAINS.damping
    with pytest.raises(ParameterError, match="one per core, not 0"):
        TrainSettings(jobs=0)
    with pytest.raises(ParameterError, match="landing needs form=lean"):
        training.rules_of(None, TrainSettings(joints="42", form="paper", landing=True))
    paper = training.rules_of(None, TrainSettings(joints="42", feet="rigid", form="paper"))
    assert not paper.mirrored and not paper.passive
    with pytest.raises(ParameterError, match="its own person"):
        training.rules_of(tmp_path, TrainSettings(height=1.8))


def test_the_curves_of_several_seeds_become_one(tmp_path):
    """An environment that has reached the goal counts no more."""
    curves = []
    for i, falls in enumerate(([30.0, 20.0, 6.0], [40.0, 10.0])):
        rows = [f"{100 * (k + 1)},{0.5 + 0.1 * k},{f}" for k, f in enumerate(falls)]
        curves.append(tmp_path / f"{i}.csv")
        curves[-1].write_text("\n".join(["decisions,reward,falls_per_minute", *rows]))
    training.write_spread(tmp_path / "curves.csv", curves)
    lines = (tmp_path / "curves.csv").read_text("utf-8").splitlines()
    assert lines == [
        "decisions,seeds,reward,reward_sd,falls_per_minute,falls_per_minute_sd",
        "100,2,0.5,0,35,7.07107",
        "200,2,0.6,0,15,7.07107",
        "300,1,0.7,,6,",
    ]
