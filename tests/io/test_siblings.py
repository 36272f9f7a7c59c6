"""Files beside a recording are found by name, in time proportional to the size of the folder."""

import os
import sys

import numpy as np
import pytest

from plantigrade.io.asf import find_asf
from plantigrade.io.companions import MAX_CANDIDATES, candidates
from plantigrade.io.subjects import subjects
from plantigrade.motion import Markers, Recording, Subject

TRIALS = 5  # of each person


def folder_of(path, people: int):
    """Make a folder of trials with forces, standing trials and skeletons; return the trials."""
    path.mkdir()
    trials = []
    for k in range(people):
        letters = "".join(chr(ord("a") + int(digit)) for digit in f"{k:03d}")
        (path / f"S{k:03d}_static.trc").touch()
        (path / f"S{k:03d}.asf").touch()
        for j in range(TRIALS):
            named = (f"S{k:03d}_walk{j}", f"{letters}_walk_{'slow ' * j}".strip(), f"run{k}{j}")
            for name in named:
                (path / f"{name}.trc").touch()
                (path / f"{name}_grf.mot").touch()
                trials.append(path / f"{name}.trc")
            (path / f"S{k:03d}_{j}.amc").touch()
    os.utime(path, (1, 1))  # as if it had been made long ago
    return trials


def lines_of(work) -> int:
    """Return the number of lines that are run: clocks depend on the machine."""
    count = 0

    def trace(*_):
        nonlocal count
        count += 1
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        work()
    finally:
        sys.settrace(before)
    return count


def test_a_folder_is_listed_once_for_all_its_files(tmp_path, monkeypatch):
    trials = folder_of(tmp_path / "many", 6)
    listed = []

    def counting(true):
        def counted(where=".", *rest):
            listed.append(where)
            return true(where, *rest)

        return counted

    for name in ("scandir", "listdir"):
        monkeypatch.setattr(os, name, counting(getattr(os, name)))
    for path in trials:
        candidates(path)
        find_asf(path.parent / "S003_1.amc")
    assert len(listed) == 1


@pytest.mark.parametrize("first", [0, 1, 2])
def test_the_search_takes_time_in_proportion_to_the_number_of_files(tmp_path, first):
    """Of every kind of name: numbers of person and trial, names without numbers, one number."""
    few, many = (folder_of(tmp_path / str(n), n) for n in (10, 40))
    few, many = few[first::3], many[first::3]
    counts = [lines_of(lambda them=them: [candidates(path) for path in them])
              for them in (few, many)]  # fmt: skip
    assert counts[1] < 4.4 * counts[0]


def test_recordings_are_compared_in_proportion_to_their_number(tmp_path):
    time = np.arange(5) / 100
    x = np.random.default_rng(0).normal(size=(1, 6, 3)) * np.ones((5, 1, 1))

    def grouped(people: int, placements: int):
        """Compare six trials of each person whose markers are where one of these places is."""
        every = [
            Recording(
                tmp_path / f"p{k}_{j}.c3d",
                Markers(tuple("ABCDEF"), time, (1 + 0.1 * (j % placements)) * x),
                subject=Subject(name=f"P{k}"),
            )
            for k in range(people)
            for j in range(6)
        ]
        assert len(subjects(every)) == people * placements
        return lines_of(lambda: subjects(every))

    assert grouped(24, 1) < 4.4 * grouped(6, 1)
    assert grouped(24, 3) < 4.4 * grouped(6, 3)


def test_what_is_found_is_what_belongs(tmp_path):
    (trial, slow, _), folder = folder_of(tmp_path / "many", 30)[:3], tmp_path / "many"
    others = [f"S000_walk{j}.trc" for j in range(1, TRIALS)]  # one of them may be a standing trial
    found = [path.name for path in candidates(trial)]
    assert found == ["S000_static.trc", *others, "S000_walk0_grf.mot"]
    assert [path.name for path in candidates(slow)] == ["aaa_walk__grf.mot"]
    last = folder / "S029_walk4.trc"
    assert candidates(last)[-1].name == "S029_walk4_grf.mot"
    assert find_asf(folder / "S029_4.amc").name == "S029.asf"


def test_a_folder_that_changes_is_listed_anew(tmp_path):
    (trial, *_), folder = folder_of(tmp_path / "many", 2), tmp_path / "many"
    assert len(candidates(trial)) == 6
    (folder / "S000_cal.trc").touch()
    assert len(candidates(trial)) == 7


def test_too_many_that_may_belong_are_a_doubt(tmp_path):
    for k in range(MAX_CANDIDATES + 1):
        (tmp_path / f"grf_{k}.mot").touch()
    assert candidates(tmp_path / "coordinates.mot") == []
    (tmp_path / "grf_0.mot").unlink()
    assert len(candidates(tmp_path / "coordinates.mot")) == MAX_CANDIDATES


def test_a_folder_that_is_absent_holds_nothing(tmp_path):
    assert candidates(tmp_path / "nowhere" / "walk.trc") == []
