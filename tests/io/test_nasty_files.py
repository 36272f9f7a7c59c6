"""Every reader, with nasty values where the format has its numbers, words and arrays.

Any error but our own, and any warning, fails.
"""

import sys
import tomllib
import warnings

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import read
from plantigrade.io.text import unique_labels
from tests import nasty
from tests.io.test_robust_readers import SAMPLES

TEXT = [name for name in SAMPLES if name not in ("C3D", "npz")]


def survives(path, content: bytes, what: str) -> None:
    """Read a file: a recording, or our own error."""
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            read(path)
        except FileError as error:
            assert error.remedy, what
            assert len(str(error)) < 1000, what
        except Exception as error:
            raise AssertionError(what) from error


@pytest.mark.parametrize("name", [*TEXT, "ASF"])
def test_text(tmp_path, name):
    """Each number and word of a text file in turn is another."""
    suffix, make = SAMPLES["AMC" if name == "ASF" else name]
    path = tmp_path / f"sample{suffix}"
    make(path)
    changed = path.with_suffix(".asf") if name == "ASF" else path
    for what, content in nasty.texts(changed.read_text(), 300):
        changed.write_bytes(content)
        survives(path, path.read_bytes(), what)


def test_npz(tmp_path):
    """Headers of arrays, members, the zip's directory."""
    path = tmp_path / "sample.npz"
    SAMPLES["npz"][1](path)
    for what, content in nasty.archives(path.read_bytes()):
        survives(path, content, what)


def test_npz_with_words_that_are_no_unicode(tmp_path):
    path = tmp_path / "sample.npz"
    SAMPLES["npz"][1](path)
    with np.load(path) as archive:
        arrays = dict(archive)
    words = arrays["joint_names"]
    codes = np.frombuffer(words.tobytes(), np.uint32).copy()
    codes[0] = 0x7FFFFFFF
    np.savez(path, **{**arrays, "joint_names": np.frombuffer(codes.tobytes(), words.dtype)})
    with pytest.raises(FileError, match="joint_names.*characters that do not exist"):
        read(path)


def test_equal_labels_take_time_in_proportion_to_their_number():
    """Lines that are run are counted, since clocks depend on the machine."""

    def lines(labels: list[str]) -> int:
        count = 0

        def trace(*_):
            nonlocal count
            count += 1
            return trace

        before = sys.gettrace()
        sys.settrace(trace)
        try:
            names = unique_labels(labels, [])
        finally:
            sys.settrace(before)
        assert len(set(names)) == len(labels)
        return count

    for labels in (["A"], ["A", "B", "A_2", "A_3"], ["A_2", "A"]):
        assert lines(labels * 1000) < 4.5 * lines(labels * 250)


@pytest.mark.parametrize("key", ["a", '"a b"'])
def test_a_bad_file_does_not_end_a_listing(tmp_path, capsys, key):
    """One file of each kind with a number of 5,000 digits, and all others are listed."""
    from plantigrade.commands.main import main

    for name, (suffix, make) in SAMPLES.items():
        folder = tmp_path / name.replace("/", "-")
        folder.mkdir()
        make(folder / f"good{suffix}")
        for k, (_, content) in enumerate(nasty.texts("time 1\n2 3\n", 20)):
            (folder / f"bad{k}{suffix}").write_bytes(content)
    (tmp_path / "own.toml").write_text(f"{key} = 1")
    assert tomllib.loads((tmp_path / "own.toml").read_text())
    assert main(["data", str(tmp_path), "--quiet"]) == 0
    listed = capsys.readouterr().out
    assert "fault of the program" not in listed
    assert all(f"good{suffix}" in listed for suffix, _ in SAMPLES.values())
