"""Pickles: arrays come back as they were, and nothing of a file is ever run."""

import collections
import gzip
import io
import os
import pickle
import pickletools
import subprocess
import zipfile
import zlib

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.io.pickles import read_pickle

CONTENTS = {
    "poses": np.arange(12.0).reshape(4, 3),
    "single": np.asfortranarray(np.arange(6, dtype="f4").reshape(2, 3)),
    "big-endian": np.arange(3.0, dtype=">f8"),
    "counts": np.arange(4),
    "none": np.zeros((0, 3)),
    "scalar": np.array(120.0),
    "rate": np.float64(59.94),
    "gender": "male",
    "word": np.array("neutral"),
    "bytes": b"male",
    "nothing": b"",
    7: [1, 2.5, None, True, (1, -2), 10**30],
    "nested": collections.OrderedDict(a={"b": np.eye(3)}),
}


def same(one, other):
    assert type(one) is type(other) or isinstance(one, dict)
    if isinstance(one, dict):
        assert list(one) == list(other)
        for key in one:
            same(one[key], other[key])
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    else:
        assert one == other


@pytest.fixture
def file(tmp_path):
    def write(raw: bytes):
        path = tmp_path / "a.pkl"
        path.write_bytes(raw)
        return path

    return write


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_arrays_of_every_protocol_come_back(file, protocol):
    same(CONTENTS, read_pickle(file(pickle.dumps(CONTENTS, protocol)), ""))


@pytest.mark.parametrize("compress", [zlib.compress, gzip.compress])
def test_compressed_files_are_read(file, compress):
    same(CONTENTS, read_pickle(file(compress(pickle.dumps(CONTENTS))), ""))


@pytest.mark.parametrize("compress", [0, 3, ("gzip", 3)])
def test_files_of_joblib_are_read(tmp_path, compress):
    joblib = pytest.importorskip("joblib")
    joblib.dump(CONTENTS, tmp_path / "a.pkl", compress=compress)
    same(CONTENTS, read_pickle(tmp_path / "a.pkl", ""))


def torch_file(tensor: bytes, storage: np.ndarray) -> bytes:
    """Return a file as torch.save writes it, with one tensor of a storage of single floats."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("a/data.pkl", tensor)
        archive.writestr("a/byteorder", "little")
        archive.writestr("a/data/0", storage.astype("<f4").tobytes())
    return stream.getvalue()


def tensor(offset: int, shape: tuple, stride: tuple, count: int = 6) -> bytes:
    """Return the pickle of a tensor, as torch writes it."""

    def numbers(values) -> bytes:
        return (
            b"(" + b"".join(b"J" + int(v).to_bytes(4, "little", signed=True) for v in values) + b"t"
        )

    storage = b"(X\x07\0\0\0storagectorch\nFloatStorage\nX\x01\0\0\x000X\x03\0\0\0cpu"
    storage += b"J" + count.to_bytes(4, "little") + b"tQ"
    whole = b"ctorch._utils\n_rebuild_tensor_v2\n(" + storage + b"J" + offset.to_bytes(4, "little")
    whole += numbers(shape) + numbers(stride) + b"\x89ccollections\nOrderedDict\n)RtR."
    return b"\x80\x02" + whole


def test_tensors_of_torch_are_read(file):
    got = read_pickle(file(torch_file(tensor(1, (2, 2), (1, 2)), np.arange(6))), "")
    np.testing.assert_array_equal(got, [[1, 3], [2, 4]])


def test_a_real_file_of_torch_is_read(tmp_path):
    torch = pytest.importorskip("torch")
    values = {"body_pose": torch.arange(6.0).reshape(2, 3).T, "transl": torch.zeros(2, 3)}
    torch.save({"smpl_params_global": values}, tmp_path / "a.pt")
    got = read_pickle(tmp_path / "a.pt", "")["smpl_params_global"]
    np.testing.assert_array_equal(got["body_pose"], [[0, 3], [1, 4], [2, 5]])


@pytest.mark.parametrize(
    ("offset", "shape", "stride", "count"),
    [(0, (7,), (1,), 6), (5, (2,), (1,), 6), (0, (2,), (-1,), 6), (0, (1 << 30,), (0,), 6),
     (0, (2, 2), (1,), 6), (0, (2,), (1,), 7), (-1 % 2**31, (1,), (1,), 6)],
)  # fmt: skip
def test_a_tensor_stays_within_its_storage(file, offset, shape, stride, count):
    with pytest.raises(FileError):
        read_pickle(file(torch_file(tensor(offset, shape, stride, count), np.arange(6))), "")


def test_a_storage_that_is_named_often_is_read_once(file, monkeypatch):
    one = tensor(0, (2,), (1,))[:-1]
    reads, read = [], zipfile.ZipFile.read
    monkeypatch.setattr(
        zipfile.ZipFile, "read", lambda self, name, *a: reads.append(name) or read(self, name, *a)
    )
    got = read_pickle(file(torch_file(b"(" + 50 * one + b"l.", np.arange(6))), "")
    assert len(got) == 50 and len(reads) == len(set(reads))


def test_a_tensor_needs_a_storage_of_torch(file):
    array = pickle.dumps(np.arange(6.0).reshape(2, 3), 2)[2:-1]
    call = b"ctorch._utils\n_rebuild_tensor_v2\n(" + array + b"K\x01K\x05\x85K\x01\x85tR."
    with pytest.raises(FileError, match="a tensor of an unknown kind"):
        read_pickle(file(b"\x80\x02" + call), "")


class Runs:
    """Pickled as a call."""

    def __init__(self, function, *arguments):
        self.call = function, arguments

    def __reduce__(self):
        return self.call


class Stateful:
    """Pickled as an object with attributes."""

    def __init__(self):
        self.poses = 1


CALLS = {
    "a command": Runs(os.system, "touch ran"),
    "a process": Runs(subprocess.check_output, ["touch", "ran"]),
    "code": Runs(eval, "open('ran', 'w')"),
    "an import": Runs(__import__, "antigravity"),
    "a file": Runs(open, "ran", "w"),
    "an attribute": Runs(getattr, "", "join"),
    "numpy's loader": Runs(np.load, "ran", None, True),
    "memory": Runs(np.zeros, (1 << 40,)),
    "bytes": Runs(bytearray, 1 << 40),
    "an object": Stateful(),
    "objects in an array": np.array([Runs(os.system, "touch ran")], dtype=object),
    "a set": {1, 2},
    "a complex number": 1j,
    "a key that takes long": {(1, 2): 3},
}


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize("what", CALLS)
@pytest.mark.parametrize("protocol", [0, 2, 4])
def test_calls_are_refused_and_not_made(file, tmp_path, monkeypatch, what, protocol, wrapped):
    monkeypatch.chdir(tmp_path)
    inner = {"poses": CALLS[what]} if wrapped else CALLS[what]
    with pytest.raises(FileError, match="nothing of it was run"):
        read_pickle(file(pickle.dumps(inner, protocol)), "")
    assert not (tmp_path / "ran").exists()


PROGRAMS = {
    "a call of an old pickle": b"(S'touch ran'\nios\nsystem\n.",
    "a call by class": b"(cos\nsystem\nS'touch ran'\no.",
    "a name from the stack": b"\x80\x04\x8c\x05posix\x8c\x06system\x93\x8c\x09touch ran\x85R.",
    "a call of an array": b"cnumpy.core.multiarray\n_reconstruct\n)R)R.",
    "an allowed name as data": b"cnumpy\ndtype\n.0",
    "attributes of a type": b"cnumpy\ndtype\n(S'f8'\ntR}S'make'\ncos\nsystem\nsb.",
    "a dotted name": b"\x80\x04\x8c\x05numpy\x8c\x11ndarray.__class__\x93.",
    "an extension": b"\x80\x02\x82\x01.",
    "an outside reference": b"Pfile\n.",
    "a long string that is not there": b"\x80\x04\x8d" + (1 << 40).to_bytes(8, "little") + b".",
    "a long byte array that is not there": b"\x80\x05\x96" + (1 << 40).to_bytes(8, "little") + b".",
    "a frame that is not there": b"\x80\x04\x95" + (1 << 60).to_bytes(8, "little") + b".",
    "a key that takes forever to hash": b"\x80\x02}(K\x01" + b"q\0h\0\x86" * 60 + b"K\x02u.",
    "a number of many digits": b"L" + b"9" * 100_000 + b"L\n.",
    "a type of many bytes": b"cnumpy\ndtype\n(S'S2000000000'\ntR.",
}


@pytest.mark.parametrize("what", PROGRAMS)
def test_programs_are_refused_and_not_run(file, tmp_path, monkeypatch, what):
    monkeypatch.chdir(tmp_path)
    try:
        got = read_pickle(file(PROGRAMS[what]), "")
    except FileError:
        got = None
    assert not callable(got)
    assert not (tmp_path / "ran").exists()


def test_every_instruction_of_pickle_is_read_or_refused(file):
    for instruction in pickletools.opcodes:
        raw = b"\x80\x04" + instruction.code.encode("latin1") + b"os\nsystem\n."
        try:
            assert not callable(read_pickle(file(raw), ""))
        except FileError:
            pass


def test_a_file_that_decompresses_to_much_is_refused(file):
    bomb = zlib.compress(pickle.dumps(b"\0" * 30_000_000), 9)
    with pytest.raises(FileError, match="decompresses to more"):
        read_pickle(file(bomb), "")


def test_a_file_of_too_many_objects_is_refused(file, monkeypatch):
    monkeypatch.setattr("plantigrade.io.pickles.MAX_INSTRUCTIONS", 1000)
    with pytest.raises(FileError, match="more objects than a motion has"):
        read_pickle(file(b"\x80\x04" + b"]" * 1001), "")


def test_one_long_text_does_not_become_many_arrays(file, monkeypatch):
    monkeypatch.setattr("plantigrade.io.pickles.MAX_BYTES", 1_000_000)
    text = b"X" + (100_000).to_bytes(4, "little") + b"a" * 100_000 + b"q\0"
    call = b"c_codecs\nencode\nq\x01h\0X\x06\0\0\0latin1q\x02\x86R"
    again = b"h\x01h\0h\x02\x86R" * 200
    with pytest.raises(FileError, match="again and again"):
        read_pickle(file(b"\x80\x02]" + text + call + again + b"."), "")


def test_the_message_says_what_was_named_and_what_to_do(file):
    with pytest.raises(FileError, match=r"system, and only arrays.* — give another") as caught:
        read_pickle(file(pickle.dumps(Runs(os.system, "true"))), "give another")
    assert "nothing of it was run" in str(caught.value)
