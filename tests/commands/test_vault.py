"""``plantigrade vault`` as a user calls it: a run, one that never leaves, and what it refuses."""

import json

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands import main as cli

SMALL = ("--starts", "1", "--evaluations", "200", "--optimiser", "evolution")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_a_vault_is_searched_written_and_read(folder, capsys, monkeypatch):
    monkeypatch.setattr("plantigrade.vaulting.approach_sensitivity.REFINEMENT_EVALUATIONS", 60)
    assert cli.main(["vault", *SMALL, "--compare", "--sensitivity", "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)
    made = folder / "runs" / "vault-6-segments"
    assert metrics == json.loads((made / "metrics.json").read_text("utf-8"))
    assert metrics["status"] == "ok" and 0.08 < metrics["contact_time_s"] < 0.25
    assert metrics["energy_error"] < 1e-6 and metrics["take_off_speed_m_s"] > 2.0
    run = pg.load_run(made)
    assert pg.check(run).ok and list(run.record.references) == ["5 segments"]
    page = (made / "report.html").read_text("utf-8")
    assert "Activation of the joints" in page and "Sensitivity to the approach" in page


@pytest.mark.slow
def test_a_body_that_falls_ends_in_3_with_a_run(folder, capsys):
    words = ("--speed", "0.5", "--rise", "-3", "--somersault", "0", "--stiffness", "10")
    assert cli.main(["vault", *SMALL, *words, "--damping", "0", "--quiet"]) == 3
    run = pg.load_run(folder / "runs" / "vault-6-segments")
    assert "with the centre of mass falling at" in run.status
    assert np.isfinite(run.record.motion.qpos).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--activation", "-0.5"], "activation must be 0.01–1 for a vault"),
        (["--speed", "40"], "speed must be 0.5–9 m/s for an approach"),
        (["--rise", "5", "--somersault", "0"], "the hands never touch the table"),
        (["--elbow", "190"], "elbow must be 60–180 degrees"),
        (["--grip", "-1"], "grip must be 0–5"),
        (["--joints", "66"], "joints is always 42 in a vault: leave it out"),
        (["--age", "20"], "age has no effect in a vault"),
        (["--starts", "0"], "starts must be a whole number"),
    ],
)
def test_bad_input_is_said_before_anything_is_written(folder, capsys, words, said):
    assert cli.main(["vault", *words]) == 2
    assert said in capsys.readouterr().err and not list(folder.iterdir())
