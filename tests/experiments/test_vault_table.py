"""The table of the vault: complete, and not searched again where it is kept."""

import pytest

from experiments import vault_table


@pytest.mark.slow
def test_the_short_form_is_whole_and_kept(monkeypatch, tmp_path):
    monkeypatch.setattr(vault_table, "N_QUICK_STARTS", 1)
    monkeypatch.setattr(vault_table, "N_QUICK_EVALUATIONS", 150)
    said = []
    table = vault_table.run(quick=True, out=tmp_path, say=said.append)
    figures = table.metrics()
    for model in vault_table.MODELS:
        words = model.replace(" ", "_")
        assert figures[f"{words}_error_of_energy"] < 1e-6
        assert figures[f"{words}_simplex_best_m_s"] > 1.0
    assert figures["six_segments_elbow_touchdown_rad"] == pytest.approx(2.98)
    assert len(said) == 4 and "report 3.14" in table.text()
    monkeypatch.setattr(vault_table.Search, "__call__", lambda *_: pytest.fail("searched again"))
    assert vault_table.run(quick=True, out=tmp_path).metrics() == figures
