"""What every test may use: the folder of public recordings, where it is there."""

import os
from pathlib import Path

# One thread per solve: idle BLAS threads slow the small matrices of this package down. It must be
# said before numpy loads, and this file loads before any test.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import pytest  # noqa: E402

DATA_VARIABLE = "PLANTIGRADE_DATA"


def find_data() -> Path | None:
    """Return the folder of public recordings, or None where there is none."""
    named = os.environ.get(DATA_VARIABLE)
    if named:
        folder = Path(named).expanduser()
        if not folder.is_dir():
            raise pytest.UsageError(f"{DATA_VARIABLE}={named} is not a folder")
        return folder
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    return beside if beside.is_dir() else None


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of public recordings; the test is skipped, visibly, where it is absent."""
    folder = find_data()
    if folder is None:
        pytest.skip(f"no folder of recordings: set {DATA_VARIABLE} to one (see docs/usage.md)")
    return folder


@pytest.fixture(scope="session")
def synthesized(tmp_path_factory):
    """A periodic walk made from the task alone: what was made, its run folder, what was told."""
    from plantigrade.workflows.synthesis_folder import write
    from plantigrade.workflows.synthesize import SynthesizeSettings, synthesize_task

    told = []
    settings = SynthesizeSettings(
        parameters={"speed": 1.0, "periodic": True}, height=1.7, mass=65.0, joints="42",
        basis="polynomial", nodes_per_second=28.0, file=QUICK_WALK,
    )  # fmt: skip
    made = synthesize_task(settings, lambda stage, it: told.append((stage, it)))
    folder = tmp_path_factory.mktemp("synthesized") / "walk"
    write(made, folder, title="A walk", command=["plantigrade", "synthesize", "walk"])
    return made, folder, told


QUICK_WALK = '[task]\nname = "walk"\nbase = "walk"\nwithout = ["work"]\n'
"""A walk that takes half the iterations: its work costs nothing."""


def pytest_report_header(config: pytest.Config) -> str:
    """Say at the top of the run which recordings it uses."""
    return f"recordings: {find_data() or f'none ({DATA_VARIABLE} is not set)'}"
