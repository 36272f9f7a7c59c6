"""Recordings that are too long, or too large for the memory there is, are refused at once."""

import tracemalloc
from unittest.mock import patch

import numpy as np
import pytest

from plantigrade.commands.main import main
from plantigrade.errors import FileError
from plantigrade.io import length, read
from plantigrade.io.length import MAX_FRAMES, free_memory
from tests.io.c3d_bytes import build

MILLION = 1_000_000


@pytest.fixture
def million(tmp_path):
    """Return a C3D file of a million frames of one point, whose zeros take no space on the disk."""
    group = {"LABELS": ["LKNE"], "UNITS": ["mm"], "SCALE": -1.0, "LONG_FRAMES": float(MILLION)}
    raw = build(np.ones((1, 1, 3)), np.empty((1, 1, 0)), {"POINT": group}, first=65535)
    path = tmp_path / "long.c3d"
    path.write_bytes(raw)
    with open(path, "r+b") as file:
        file.truncate(len(raw) + 16 * MILLION)
    return path


def test_a_million_frames_are_refused_before_memory_is_taken(million):
    tracemalloc.start()
    with pytest.raises(FileError, match="1000000 frames; at most 360000 .* in parts"):
        read(million)
    assert tracemalloc.get_traced_memory()[1] < 4e6  # [bytes]: the frames are 16 MB
    tracemalloc.stop()


def test_a_fit_of_a_million_frames_ends_in_one_sentence(million, tmp_path, capsys):
    assert main(["fit", str(million), "--out", str(tmp_path / "run")]) == 2
    assert f"at most {MAX_FRAMES}" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_every_format_is_held_to_it(tmp_path):
    path = tmp_path / "long.csv"
    rows = [f"{k / 100},{k},{k},{k}" for k in range(21)]
    path.write_text("\n".join(["time,LKNE_x,LKNE_y,LKNE_z", *rows]))
    with patch.object(length, "MAX_FRAMES", 21):
        assert len(read(path).markers.time) == 21
    with patch.object(length, "MAX_FRAMES", 20), pytest.raises(FileError, match="has 21 frames"):
        read(path)


def test_what_does_not_fit_into_free_memory_is_refused(tmp_path):
    path = tmp_path / "walk.c3d"
    group = {"LABELS": ["LKNE"], "UNITS": ["mm"], "SCALE": -1.0}
    path.write_bytes(build(np.ones((500, 1, 3)), np.empty((500, 1, 0)), {"POINT": group}))
    assert len(read(path).markers.time) == 500
    with patch.object(length, "free_memory", lambda: 1e4):
        with pytest.raises(FileError, match="need .* GB of memory .* are free"):
            read(path)


def test_free_memory_is_that_of_a_machine():
    assert 1e6 < free_memory() < 1e14
