"""What breaks readers, and how to put it where a format has its numbers, words and arrays.

Everything is drawn with fixed seeds. A run of the suite tries a sample of a few seconds; the
environment variable ``PLANTIGRADE_FUZZ`` multiplies it (``PLANTIGRADE_FUZZ=50`` for a night).
"""

import io
import os
import random
import re
import zipfile
from collections.abc import Iterator
from typing import Any

import numpy as np

EFFORT = float(os.environ.get("PLANTIGRADE_FUZZ", "1"))

NUMBERS = (
    *("0", "-0", "-1", "1e308", "-1e308", "1e-308", "1e999", "nan", "inf", "-inf", "+nan"),
    *("65536", "2147483648", "9223372036854775808", "18446744073709551616", "1" + "0" * 400),
    *("9" * 5000, "-" + "9" * 5000, "0x1F", "1_0", "٣", "²", "1e5", "0.5"),
)
WORDS = (
    *("", "x", "true", "null", '"x"', "'", '"""', "[[1]]", "{}", "[", "{", "}", ":", "1979-05-27"),
    *("00:00:00", "\x1b]0;x\x07", "\u202e", "\udcff", "\0", "<script>", "../x", "{'a': []}"),
    *("[" * 100_000, "{" * 3000, '{"a":' * 3000, "a." * 3000 + "a = 1\n"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 0.5, 1e308, -1e308, 10**19, 10**400, float("nan"), float("inf")),
    *("", "x", "nan", "\x1b]8;;x\x07<script>", "9" * 5000, "\u202e", [], {}, [[]], [1], {"a": 1}),
)
"""Values of JSON in place of any other."""

TOKEN = re.compile(r"[^\s,=\[\]{}:()]+")


def sample(things: list, count: int, seed: int = 0) -> list:
    """Return so many of the things at random, times the effort; all of them where there are fewer.

    The same seed gives the same things.
    """
    count = round(count * EFFORT)
    return things if count >= len(things) else random.Random(seed).sample(things, count)


def texts(text: str, count: int, seed: int = 0) -> Iterator[tuple[str, bytes]]:
    """Yield what was done to a text, and its bytes: each token replaced, lines repeated or lost."""
    tokens = list(TOKEN.finditer(text))
    lines = text.split("\n")
    changes = [(m.start(), m.end(), word) for m in tokens for word in NUMBERS + WORDS]
    counts = [m for m in tokens[:60] if m[0].isdecimal()]  # of a header
    head = [(m.start(), m.end(), word) for m in counts for word in NUMBERS]
    for start, end, word in sample(head, count // 2, seed) + sample(changes, count // 2, seed):
        what = f"{text[start:end]} at {start} -> {word[:20]} ({len(word)} characters)"
        yield what, _raw(text[:start] + word + text[end:])
    for i in sample(list(range(len(lines))), max(count // 20, 3), seed):
        yield f"line {i} twice", _raw("\n".join([*lines[: i + 1], *lines[i:]]))
        yield f"without line {i}", _raw("\n".join([*lines[:i], *lines[i + 1 :]]))


def leaves(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield where each part of a JSON value is, the whole among them."""
    yield path
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(part, (*path, key))


def replaced(value: Any, path: tuple, new: Any) -> Any:
    """Return a JSON value with one part replaced."""
    if not path:
        return new
    copy = value.copy()
    copy[path[0]] = replaced(value[path[0]], path[1:], new)
    return copy


def arrays(array: np.ndarray) -> Iterator[tuple[str, np.ndarray | None]]:
    """Yield arrays of other shapes, types and values in place of one; None to leave it out."""
    yield "missing", None
    yield "a scalar", np.array(1.0)
    yield "a word", np.array("x")
    yield "a table", np.zeros((3, 3))
    yield "complex", np.zeros(array.shape, complex)
    yield "times", np.zeros(array.shape, "datetime64[s]")
    yield "bytes", np.full(array.shape, b"\xff")
    yield "words", np.full(array.shape, "\x1b]8;;x\x07<script>")
    yield "words that cannot be printed", np.full(array.shape, "\udcff\0")
    yield "flat", array.ravel()
    if array.ndim:
        yield "none", array[:0]
        yield "one", array[:1]
        yield "half", array[: len(array) // 2]
        yield "twice", np.concatenate([array, array])
        yield "backwards", array[::-1]
    if array.dtype.kind in "fiub":
        yield "another type", array.astype(np.float16)
        yield "in another order", np.asfortranarray(array)
        values = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, -1e300, 1e-310, 1e9, 2.0**62)
        for value in values:
            yield f"all {value:g}", np.full(array.shape, value)
            if array.size:
                changed = array.astype(float)
                changed.flat[changed.size // 2] = value
                yield f"one {value:g}", changed


def archives(raw: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield damaged npz files: headers of arrays, members and the directory of the zip."""
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        members = {info.filename: archive.read(info) for info in archive.infolist()}
    name = next(iter(members))
    whole = members[name]
    for what, header in HEADERS.items():
        yield f"header: {what}", _zipped({**members, name: _npy(header)})
    for what, content in {
        "no array": b"hello",
        "an array cut short": whole[:-8],
        "half an array": whole[: len(whole) // 2],
        "nothing": b"",
        "a pickle": b"\x80\x04N.",
        "a zip within": raw,
        "version 9 of the format": whole[:6] + b"\x09\x00" + whole[8:],
    }.items():
        yield what, _zipped({**members, name: content})
    for method in (zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2, zipfile.ZIP_DEFLATED):
        packed = bytearray(_zipped(members, method))
        for place in (34, 45, 60, 80):
            packed[place + len(name)] ^= 0xFF
        yield f"damaged compression {method}", bytes(packed)
    for other in ("../../x.npy", "/etc/x.npy", "ü\u202e.npy", "a" * 5000 + ".npy", " ", "time"):
        yield f"a member {other[:12]!r}", _zipped({**members, other: whole})
    stream = io.BytesIO(raw)
    with zipfile.ZipFile(stream, "a") as archive:
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            archive.writestr(name, whole[:-8])
    yield "a member twice", stream.getvalue()
    directory = raw.rindex(b"PK\x01\x02")
    end = raw.rindex(b"PK\x05\x06")
    for place, value, what in (
        (directory + 8, 1, "encrypted"),
        (directory + 10, 99, "an unknown compression"),
        (directory + 24, 255, "another size"),
        (directory + 42, 255, "another place"),
        (end + 10, 255, "another number of members"),
        (end + 16, 255, "a directory elsewhere"),
    ):
        changed = bytearray(raw)
        changed[place] = value
        yield f"zip: {what}", bytes(changed)


HEADERS = {
    "unfinished": b"{'descr': '<f8', 'fortran_order': False, 'shape': (8,), }(",
    "a line that goes on": b"{'descr': '<f8', 'fortran_order': False, 'shape': (\\",
    "a negative length": b"{'descr': '<f8', 'fortran_order': False, 'shape': (-8,), }",
    "10**18 numbers": b"{'descr': '<f8', 'fortran_order': False, 'shape': (10**18,), }",
    "1e18 numbers": b"{'descr': '<f8', 'fortran_order': False, 'shape': (1%s,), }" % (b"0" * 18),
    "5000 digits": b"{'descr': '<f8', 'fortran_order': False, 'shape': (%s,), }" % (b"9" * 5000),
    "80 dimensions": b"{'descr': '<f8', 'fortran_order': False, 'shape': (%s), }" % (b"1," * 80),
    "objects": b"{'descr': '|O', 'fortran_order': False, 'shape': (8,), }",
    "columns": b"{'descr': [('a', '<f8', (-1,))], 'fortran_order': False, 'shape': (8,), }",
    "an unknown type": b"{'descr': '<q9', 'fortran_order': False, 'shape': (8,), }",
    "deep": b"{'descr': " + b"[" * 3000 + b"}",
    "a word for a shape": b"{'descr': '<f8', 'fortran_order': False, 'shape': 'x', }",
    "a yes that is none": b"{'descr': '<f8', 'fortran_order': 7, 'shape': (8,), }",
    "a key twice": b"{'descr': '<f8', 'descr': [], 'fortran_order': False, 'shape': (8,), }",
    "a list for a key": b"{[]: '<f8', 'fortran_order': False, 'shape': (8,), }",
    "no Latin": "{'descr': '<f8', 'fortran_order': False, 'shape': (８,), }".encode(),
}
"""Headers of array files: what is wrong → the header."""


def _npy(header: bytes, version: int = 2) -> bytes:
    header = header.ljust(117) + b"\n"
    data = np.zeros(8).tobytes()
    return b"\x93NUMPY" + bytes([version, 0]) + len(header).to_bytes(4, "little") + header + data


def _zipped(members: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def _raw(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")
