"""The job scripts of the page about batches do what they say, with stand-ins for Slurm."""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.workflows.test_one_subject import trial

PAGE = Path(__file__).parents[1] / "docs" / "batches.md"
SCRIPTS = [text for text in re.findall(r"```bash\n(.*?)```", PAGE.read_text("utf-8"), re.S)
           if "#SBATCH" in text]  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="scripts of a shell")
@pytest.mark.parametrize("script", SCRIPTS, ids=["one node", "several nodes"])
def test_a_job_script_fits_a_list(script, tmp_path):
    if "dask" in script:
        pytest.importorskip("distributed")
    for name in ("a1", "b1"):
        (tmp_path / name).mkdir()
        trial(tmp_path / name / "walk.trc", n=60)
    (tmp_path / "walks.txt").write_text("a1/walk.trc\nb1/walk.trc\n")
    (tmp_path / "venv" / "bin").mkdir(parents=True)
    (tmp_path / "venv" / "bin" / "activate").write_text("")
    commands = tmp_path / "commands"
    commands.mkdir()
    for name, line in {
        "plantigrade": f'exec {sys.executable} -m plantigrade "$@"',
        "dask": f'exec {sys.executable} -m dask "$@"',
        "python": f'exec {sys.executable} "$@"',
        "srun": 'exec "$@"',
    }.items():
        (commands / name).write_text(f"#!/bin/sh\n{line}\n")
        (commands / name).chmod(0o755)
    done = subprocess.run(
        ["bash", "-c", f"trap 'kill $(jobs -p) 2>/dev/null; wait' EXIT\n{script}"],
        cwd=tmp_path,
        env={**os.environ, "PATH": f"{commands}:{os.environ['PATH']}", "SLURM_CPUS_PER_TASK": "2",
             "SLURM_NTASKS": "1"},
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    with (tmp_path / "results" / "batch.csv").open(encoding="utf-8") as stream:
        assert [row["status"] for row in csv.DictReader(stream)] == ["ok", "ok"]
