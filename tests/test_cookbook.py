"""The jobs of the cookbook run from top to bottom in one folder."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[1] / "docs" / "cookbook.md"
JOBS = re.findall(r"^### (\d+)\. .*?$(.*?)(?=^##|\Z)", PAGE.read_text("utf-8"), re.M | re.S)
BLOCK = re.compile(r"^```(python|bash)\n(.*?)^```", re.M | re.S)


def test_there_are_twenty_jobs_of_at_most_ten_lines():
    assert [number for number, _ in JOBS] == [str(k) for k in range(1, 21)]
    for number, text in JOBS:
        ((_, code),) = BLOCK.findall(text)
        assert len(code.splitlines()) <= 10, number


@pytest.mark.slow
@pytest.mark.solver
def test_the_jobs_run_in_order(tmp_path, monkeypatch, capsys):
    from plantigrade.commands.main import main

    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "__main__"}
    for language, code in BLOCK.findall(PAGE.read_text("utf-8")):
        if language == "python":
            exec(compile(code, str(PAGE), "exec"), names)
            continue
        for line in code.splitlines():
            words = shlex.split(line)
            if words[0] == "plantigrade":
                assert main([*words[1:], "--quiet"]) == 0, line
            elif words[0] == "mkdir":
                Path(words[-1]).mkdir()
            else:
                shutil.copy(*words[1:])
    printed = capsys.readouterr().out
    assert printed.count("ok") >= 5 and "N m" in printed
    for name in ("angles.svg", "curves.csv", "walk.bvh", "walk.glb", "markers.trc", "walk.svg",
                 "anna.xml", "runs/fit-walk/report.html", "runs/monday/batch.csv"):  # fmt: skip
        assert Path(name).stat().st_size > 500, name
