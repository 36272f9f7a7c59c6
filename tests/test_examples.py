"""Every example runs by itself, in a folder that was empty before the first of them."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
MADE = {  # in this order, in one folder: words → what is printed, and the folder it makes
    "fit.py": (
        r"[234]\.\d mm from the markers\nright knee \S+ to [56]\d degrees\n", "fit-textbook_walk",
    ),
    "reproduce.py runs/demo/textbook_walk.c3d": (
        r"knee_angle_r: [01]\.\d\d rad, recorded 1\.0\d\n.*\ncentre of mass within \d\.\d mm of",
        "reproduce-textbook_walk",
    ),
    "synthesize.py": (r"verdict: ok\nknee moment up to [567]\d N m", "synthesize-squat"),
    "your_own_task.py": (r"Careful squat .* check passed", "synthesize-careful_squat"),
    "your_own_controller.py": (
        r"status: ok\ncentre of mass at 0\.9\d m\nmotors up to \d+ %", "simulate-standing",
    ),
    "own_whole_body_controller.py": (
        r"status: ok\ncentre of mass up to [012]\.\d cm away, 0\.[0-6] cm at the end\n", "",
    ),
    "environment.py": (
        r"324 numbers are seen, 36 decided about\nfell after 0\.\d s, reward 0\.[78]\d\n", "blind",
    ),
    "vault.py": (
        r"off the table at 2\.\d\d m/s upward after 0\.1\d s\nactivation of the hip",
        "vault-6-segments",
    ),
    "check_in_mujoco.py runs/synthesize-squat": (
        r"\de-\d\d N unexplained at the root, motor torques \S+e-1\d N m apart", "",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("examples")


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("words", MADE)
def test_an_example_runs(words, folder):
    name, *arguments = words.split()
    said, makes = MADE[words]
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *arguments],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert re.search(said, done.stdout), done.stdout
    if makes:
        page = folder / "runs" / makes / "report.html"
        assert page.is_file() and f"report: runs/{makes}/report.html" in done.stdout


def test_every_example_is_run_and_short():
    assert {path.name for path in EXAMPLES.glob("*.py")} == {words.split()[0] for words in MADE}
    for path in EXAMPLES.glob("*.py"):
        text = path.read_text("utf-8")
        assert len(text.splitlines()) <= 40 and text.startswith('"""'), path.name
        assert "from plantigrade" not in text, f"{path.name} uses more than the public face"
