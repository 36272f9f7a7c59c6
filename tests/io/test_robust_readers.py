"""Every reader, given every kind of broken file: a Recording, or an error that names the file.

Formats and their small valid files are in :mod:`tests.nasty`; a new format joins there.
"""

import re
import struct
import sys
import tomllib
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io import FORMATS, read, write
from plantigrade.io.text import unique_labels
from plantigrade.motion import Recording, Table
from tests.nasty import TEXT
from tests.nasty.judge import Damaged, findings
from tests.nasty.targets import TARGETS

LIMIT_BYTES = 500e6
READERS = [
    "C3D", "TRC", "MOT/STO", "STO of forces", "CSV", "BVH", "AMC", "ASF", "DeepMimic", "forces",
    "npz", "SMPL", "SMPL pickle", "keypoints",
]  # fmt: skip
TEXTS = [name for name in READERS if name not in ("C3D", "npz", "SMPL", "SMPL pickle")]


@pytest.fixture(scope="module")
def seeds(tmp_path_factory) -> dict[str, Damaged]:
    """A valid file of each format."""
    return {name: Damaged(TARGETS[name], tmp_path_factory.mktemp("seed")) for name in READERS}


def survives(seed: Damaged, content: bytes) -> None:
    """Read ``content``: a recording, or an error of our own that helps."""
    found = seed.outcome(content)
    assert not found.is_finding, found


def memory(call: Callable[[], object]) -> int:
    """Return the most memory that a call takes [bytes]."""
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_every_format_has_a_seed():
    """A format that joins the table joins this harness."""
    assert {kind.name for kind in FORMATS} <= set(READERS)


@pytest.mark.parametrize("name", READERS)
def test_mutants(tmp_path, name):
    """Numbers, words, lines, bytes, arrays and encodings in turn are others, missing or twice."""
    assert findings(name, tmp_path, 300) == []


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("content", [b"", b"\0", b"\n" * 50, b"\0" * 5000, b"\xff" * 5000, b" "])
def test_nothing_in_it(seeds, name, content):
    """An empty file, blanks, zeros."""
    assert seeds[name].outcome(content).kind == "refused"


@pytest.mark.parametrize("name", READERS)
def test_a_huge_file_is_refused_unread(tmp_path, name):
    """Ten gigabytes of nothing behind a good start: an error, no memory taken."""
    seed = Damaged(TARGETS[name], tmp_path)
    with open(seed.path, "ab") as file:
        file.truncate(10_000_000_000)

    def refused():
        with pytest.raises(FileError, match=seed.path.name):
            seed.target.read(seed.path)

    assert memory(refused) < LIMIT_BYTES


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("number", ["1000000000", "9" * 5000, "-1", "0"])
def test_absurd_counts(seeds, name, number):
    """Each number of the header in turn announces a thousand million of something, or none."""
    seed = seeds[name]

    def each():
        for match in list(re.finditer(rb"\d+", seed.content))[:40]:
            survives(
                seed,
                seed.content[: match.start()] + number.encode() + seed.content[match.end() :],
            )

    assert memory(each) < LIMIT_BYTES


@pytest.mark.parametrize("value", [0, 1, 255, 32767, 32768, 65535])
def test_absurd_c3d_header(seeds, value):
    """Each word of the C3D header in turn."""

    def each():
        for word in range(12):
            broken = bytearray(seeds["C3D"].content)
            struct.pack_into("<H", broken, 2 * word, value)
            survives(seeds["C3D"], bytes(broken))

    assert memory(each) < LIMIT_BYTES


def test_missing_and_folder(tmp_path):
    """What is not a file at all."""
    for kind in FORMATS:
        for suffix in kind.suffixes:
            with pytest.raises(FileError, match="no such file"):
                read(tmp_path / f"absent{suffix}")
    with pytest.raises(FileError, match="folder"):
        read(tmp_path)


def test_npz_with_words_that_are_no_unicode(tmp_path):
    with np.load(TARGETS["npz"].make(tmp_path)) as archive:
        arrays = dict(archive)
    words = arrays["joint_names"]
    codes = np.frombuffer(words.tobytes(), np.uint32).copy()
    codes[0] = 0x7FFFFFFF
    arrays["joint_names"] = np.frombuffer(codes.tobytes(), words.dtype)
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(FileError, match="joint_names.*characters that do not exist"):
        read(tmp_path / "a.npz")


def test_npz_without_joints_and_markers_is_refused(tmp_path):
    """It was read as a recording of nothing."""
    time, qpos = np.arange(3) / 100, np.tile([0, 0, 0.9, 1, 0, 0, 0, 0.1], (3, 1))
    np.savez(tmp_path / "a.npz", time=time, qpos=qpos)
    with pytest.raises(FileError, match="joint_names: names no joints that fit qpos"):
        read(tmp_path / "a.npz")


def test_npz_whose_joints_have_one_name(tmp_path):
    qpos = np.tile([0, 0, 0.9, 1, 0, 0, 0, 0.1, 0.2], (3, 1))
    names = ["root", "knee_angle_r", "knee_angle_r"]
    np.savez(tmp_path / "a.npz", time=np.arange(3) / 100, qpos=qpos, joint_names=names)
    with pytest.raises(FileError, match="joint_names: names a joint twice"):
        read(tmp_path / "a.npz")


def test_no_address_of_an_object_in_a_message(tmp_path):
    seed = TARGETS["npz"].make(tmp_path)
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (10**18,), }"
    raw = seed.read_bytes()
    start = raw.index(b"{'descr'")
    seed.write_bytes(raw[:start] + header + raw[start + len(header) :])
    with pytest.raises(FileError) as caught:
        read(seed)
    assert " at 0x" not in str(caught.value)


def test_trc_with_a_rate_of_zero_and_no_times(tmp_path):
    path = TARGETS["TRC"].make(tmp_path)
    times = r"(?m)^(\d+)\t0\.\d+"
    text, changed = re.subn(times, r"\1\t0", path.read_text())
    assert changed
    path.write_text(re.sub(r"(?m)^100(\.\d+)?\t", "0\t", text))
    with pytest.raises(FileError, match="DataRate is 0"):
        read(path)


def test_a_force_file_without_rows_is_refused(tmp_path):
    """Its last row was cut off, and only a blank one was left."""
    path = TARGETS["STO of forces"].make(tmp_path)
    head, _, _ = path.read_text().partition("0 1 500")
    path.write_text(f"{head}   \n0 0.2\n")
    with pytest.raises(FileError, match="line 6: this row has 2 fields where 7 are expected"):
        read(path)


@pytest.mark.parametrize("name", ["MOT/STO", "CSV"])
def test_what_a_message_quotes_is_printable(tmp_path, name):
    """Names of columns turn the line around, or command the terminal."""
    path = TARGETS[name].make(tmp_path)
    path.write_text(re.sub("[tT]ime|_r|pelvis", "\u202e\x1b[2J", path.read_text()))
    with pytest.raises(FileError, match=r"\\u202e\\x1b") as caught:
        read(path)
    assert "\u202e" not in str(caught.value) + caught.value.problem


@pytest.mark.parametrize("name", ["a;;b;c", "\udcff"])
def test_any_name_is_written_and_read_back(tmp_path, name):
    """Other separators in a name; a byte that is no UTF-8, which is escaped."""
    table = Table((name,), np.arange(3) / 100, np.zeros((3, 1)))
    write(Recording(tmp_path, coordinates=table), tmp_path / "a.csv")
    found = read(tmp_path / "a.csv").coordinates
    assert found is not None and found.names == (name.encode("utf-8", "backslashreplace").decode(),)


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
    from tests.nasty import mutants

    good = []
    for name in READERS:
        folder = tmp_path / name.replace("/", "-")
        folder.mkdir()
        path = TARGETS[name].make(folder)
        good.append(path.name)
        for k, (_, content) in enumerate(mutants("listing", b"time 1\n2 3\n", TEXT, 20)):
            path.with_stem(f"bad{k}").write_bytes(content)
    (tmp_path / "own.toml").write_text(f"{key} = 1")
    assert tomllib.loads((tmp_path / "own.toml").read_text())
    assert main(["data", str(tmp_path), "--quiet"]) == 0
    listed = capsys.readouterr().out
    assert "fault of the program" not in listed
    assert all(name in listed for name in good if not name.endswith(".asf"))
