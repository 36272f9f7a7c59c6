"""Independent items on several workers: where they run, and what becomes of a worker that dies."""

import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from threading import Event

import pytest

from plantigrade.errors import PlantigradeError
from plantigrade.record import jobs
from plantigrade.record.engines import Processes
from plantigrade.record.jobs import run_jobs
from tests.browser import wait_for

ENGINES = [
    "loky",
    pytest.param("ray", marks=pytest.mark.slow),
    pytest.param("dask", marks=pytest.mark.slow),
]
LIBRARY = {"ray": "ray", "dask": "distributed"}
POISON = 3  # this item kills its worker


def place(_: int) -> str:
    return os.getcwd()


def square(log: Path, deadly: bool, item: int) -> int:
    """Square a number, after a line in a file; one item ends its process as the kernel would."""
    with open(log / f"{item}", "a") as file:
        file.write(f"{os.getpid()}\n")
    if item == POISON and (deadly or len((log / f"{item}").read_text().split()) == 1):
        Event().wait(0.3)  # others are being computed meanwhile
        os.kill(os.getpid(), signal.SIGKILL)
    Event().wait(0.05)
    return item**2


def needs(backend: str) -> None:
    if backend in LIBRARY:
        pytest.importorskip(LIBRARY[backend])


def test_processes_that_wait_go_to_the_folder_of_the_next_work(tmp_path, monkeypatch):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        found = {done.result for done in run_jobs(place, [1, 2, 3], jobs=2)}
        assert found == {str(tmp_path / name)}


@pytest.mark.parametrize("backend", ENGINES)
def test_an_item_whose_worker_was_killed_once_is_computed_again(backend, tmp_path):
    needs(backend)
    done = list(run_jobs(partial(square, tmp_path, False), range(8), jobs=2, backend=backend))
    assert [one.result for one in done] == [i**2 for i in range(8)]
    assert len((tmp_path / str(POISON)).read_text().split()) == 2


@pytest.mark.parametrize("backend", ENGINES)
def test_an_item_that_kills_every_worker_is_a_row_and_ends_no_other(backend, tmp_path):
    needs(backend)
    done = list(run_jobs(partial(square, tmp_path, True), range(8), jobs=2, backend=backend))
    assert [one.item for one in done] == list(range(8))
    assert [one.item for one in done if not one.ok] == [POISON]
    assert "its worker process died 3 times" in done[POISON].problem
    again = [i for i in range(8) if len((tmp_path / str(i)).read_text().split()) > 2]
    assert again == [POISON], "an item that shared its pool is computed at most twice"


def test_what_cannot_be_sent_to_a_worker_is_a_row(tmp_path):
    with open(tmp_path / "file", "w") as file:
        first, other = run_jobs(str, [file, 2], jobs=2)
    assert "pickle" in first.problem and other.result == "2"


def test_a_cluster_that_is_gone_leaves_rows_and_what_has_finished(monkeypatch):
    """Three items are computed, then the engine takes no more of them."""
    taken = []

    class Leaving(Processes):
        def submit(self, call, *arguments):
            taken.append(arguments)
            if len(taken) > 3:
                raise ConnectionError("the scheduler closed the connection")
            return super().submit(call, *arguments)

    monkeypatch.setitem(jobs.ENGINES, "loky", lambda workers, address: Leaving(workers))
    done = list(run_jobs(abs, [-1, -2, -3, -4, -5], jobs=2))
    assert [one.result for one in done] == [1, 2, 3, None, None]
    assert all("scheduler closed" in one.problem for one in done[3:])


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_workers_end_with_a_parent_that_was_killed(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import time\n"
        "from pathlib import Path\n"
        "from plantigrade.record.jobs import run_jobs\n"
        "def work(item):\n"
        "    import os\n"
        f"    Path(r'{tmp_path}', f'pid{{item}}').write_text(str(os.getpid()))\n"
        "    time.sleep(60)\n"
        "if __name__ == '__main__':\n"
        "    list(run_jobs(work, [1, 2], jobs=2))\n"
    )
    parent = subprocess.Popen([sys.executable, script], stderr=subprocess.DEVNULL)
    pids = [tmp_path / "pid1", tmp_path / "pid2"]
    try:
        workers = wait_for(lambda: [int(path.read_text()) for path in pids])
    finally:
        parent.kill()
        parent.wait()
    wait_for(lambda: not any(alive(pid) for pid in workers))


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat")  # a process that has ended but was not waited for is no more
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.mark.parametrize("backend", [pytest.param("dask", marks=pytest.mark.slow)])
def test_an_address_without_an_answer_is_named(backend):
    needs(backend)
    with pytest.raises(PlantigradeError, match=r"no Dask scheduler at tcp://127.0.0.1:9"):
        list(run_jobs(abs, [1], backend=backend, address="tcp://127.0.0.1:9"))
