"""Work that runs side by side happens in the folder where it was asked for."""

import os

from plantigrade.record.jobs import run_jobs


def place(_: int) -> str:
    return os.getcwd()


def test_processes_that_wait_go_to_the_folder_of_the_next_work(tmp_path, monkeypatch):
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        found = {done.result for done in run_jobs(place, [1, 2, 3], jobs=2)}
        assert found == {str(tmp_path / name)}
