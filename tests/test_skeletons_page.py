"""The example of the page on other skeletons runs."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[1] / "docs" / "skeletons.md"


@pytest.mark.slow
def test_the_example_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S)
    assert len(code.splitlines()) <= 12
    exec(compile(code, str(PAGE), "exec"), {})
    assert float(capsys.readouterr().out) == pytest.approx(1.75)
