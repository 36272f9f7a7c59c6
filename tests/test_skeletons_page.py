"""The examples of the page on other skeletons run."""

from pathlib import Path

import pytest

from tests.paste import blocks

PAGE = Path(__file__).resolve().parents[1] / "docs" / "skeletons.md"
EXAMPLES = blocks(PAGE, "python")


@pytest.mark.slow
@pytest.mark.parametrize("code", EXAMPLES, ids=["SMPL", "video"])
def test_an_example_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert len(code.splitlines()) <= 15
    exec(compile(code, str(PAGE), "exec"), {})
    assert float(capsys.readouterr().out) == pytest.approx(1.75)
