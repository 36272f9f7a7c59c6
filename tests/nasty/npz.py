"""Damaged npz files: their arrays, JSON texts inside them, headers, members, the zip itself."""

import io
import json
import random
import warnings
import zipfile
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from tests.nasty import ANY, leaf_changed


@lru_cache(maxsize=8)
def _arrays(raw: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(raw)) as archive:
        return dict(archive)


def _saved(arrays: dict[str, np.ndarray]) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def array_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Any array of an npz file has another shape, type or value, or is missing."""
    arrays = _arrays(raw)
    key = rng.choice(list(arrays))
    array, what = arrays[key], rng.choice(list(ARRAYS))
    if rng.random() < 0.1:
        return f"{key} missing", _saved({k: v for k, v in arrays.items() if k != key})
    if array.dtype.kind in "fiub" and rng.random() < 0.5:
        value = rng.choice(EXTREMES)
        changed = array.astype(float)
        where = rng.randrange(max(changed.size, 1))
        if rng.random() < 0.3:
            changed[...] = value
        elif changed.size:
            changed.flat[where] = value
        return f"{key} at {where}: {value:g}", _saved({**arrays, key: changed})
    return f"{key}: {what}", _saved({**arrays, key: ARRAYS[what](array)})


def text_in_array_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Any value of a JSON text inside an npz file is another."""
    arrays = _arrays(raw)
    texts = [key for key, a in arrays.items() if a.ndim == 0 and str(a)[:1] in ("{", "[")]
    key = rng.choice(texts)
    what, changed = leaf_changed(rng, json.loads(str(arrays[key])))
    return f"{key} {what}", _saved({**arrays, key: np.array(json.dumps(changed))})


EXTREMES = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, -1e300, 1e-310, 1e9, 2.0**62)
ARRAYS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "a scalar": lambda array: np.array(1.0),
    "a word": lambda array: np.array("x"),
    "a table": lambda array: np.zeros((3, 3)),
    "complex": lambda array: np.zeros(array.shape, complex),
    "times": lambda array: np.zeros(array.shape, "datetime64[s]"),
    "bytes": lambda array: np.full(array.shape, b"\xff"),
    "words": lambda array: np.full(array.shape, "\x1b]8;;x\x07<script>"),
    "words that cannot be printed": lambda array: np.full(array.shape, "\udcff\0"),
    "words that are no Unicode": lambda array: np.full((*array.shape, 1), 0x7FFFFFFF, "<u4").view(
        "<U1"
    )[..., 0],
    "flat": lambda array: array.ravel(),
    "none": lambda array: np.atleast_1d(array)[:0],
    "one": lambda array: np.atleast_1d(array)[:1],
    "half": lambda array: np.atleast_1d(array)[: array.size // 2],
    "twice": lambda array: np.concatenate([np.atleast_1d(array)] * 2),
    "backwards": lambda array: np.atleast_1d(array)[::-1],
    "half precision": lambda array: array.astype(
        np.float16 if array.dtype.kind in "fiub" else "U1"
    ),
    "in another order": np.asfortranarray,
    "of another byte order": lambda array: array.astype(array.dtype.newbyteorder(">")),
}
"""Arrays in place of one: what it is → how it is made."""


def archive_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A damaged npz file: headers of arrays, members, and the directory of the zip."""
    members = _members(raw)
    name = rng.choice(list(members))
    directory, end = raw.rindex(b"PK\x01\x02"), raw.rindex(b"PK\x05\x06")
    whole = members[name]
    match rng.randrange(6):
        case 0:
            what, header = rng.choice(list(HEADERS.items()))
            return f"{name}: {what}", _zipped({**members, name: npy(header, rng.choice((1, 2, 3)))})
        case 1:
            what, content = rng.choice(
                (
                    ("no array", b"hello"),
                    ("an array cut short", whole[:-8]),
                    ("half an array", whole[: len(whole) // 2]),
                    ("nothing", b""),
                    ("a pickle", b"\x80\x04N."),
                    ("a zip within", raw),
                    ("version 9 of the format", whole[:6] + b"\x09\x00" + whole[8:]),
                )
            )
            return f"{name}: {what}", _zipped({**members, name: content})
        case 2:
            method = rng.choice((zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2, zipfile.ZIP_DEFLATED))
            small = {name: whole[:100_000]}  # of a size that is soon packed
            packed = bytearray(_zipped(small, method))
            packed[rng.randrange(34, 90) + len(name)] ^= 0xFF
            return f"damaged compression {method}", bytes(packed)
        case 3:
            others = ("../../x.npy", "/etc/x.npy", "ü\u202e.npy", "a" * 5000 + ".npy", " ", "time")
            other = rng.choice(others)
            return f"a member {other[:12]!r}", _zipped({**members, other: whole})
        case 4:
            return f"member {name} again", _zipped([*members.items(), (name, whole[:-8])])
        case _:
            at, value, what = rng.choice(
                (
                    (directory + 8, 1, "encrypted"),
                    (directory + 10, 99, "an unknown compression"),
                    (directory + 24, 255, "another size"),
                    (directory + 42, 255, "another place"),
                    (end + 10, 255, "another number of members"),
                    (end + 16, 255, "a directory elsewhere"),
                )
            )
            changed = bytearray(raw)
            changed[at] = value
            return f"zip: {what}", bytes(changed)


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


def npy(header: bytes, version: int = 2) -> bytes:
    """Return an array file of 8 numbers with a header of one's own."""
    header = header.ljust(117) + b"\n"
    size = len(header).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + size + header + np.zeros(8).tobytes()


@lru_cache(maxsize=8)
def _members(raw: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        return {info.filename: archive.read(info) for info in archive.infolist()}


def _zipped(members: Any, method: int = zipfile.ZIP_STORED) -> bytes:
    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", method) as archive:
        warnings.simplefilter("ignore")  # of a name twice
        for name, content in members.items() if isinstance(members, dict) else members:
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return stream.getvalue()


VALUES = (array_changed, text_in_array_changed)
"""Ways that leave the file whole, so that more than its reader sees what was changed."""
NPZ = (*ANY, *[array_changed] * 10, *[text_in_array_changed] * 5, *[archive_changed] * 5)
"""Ways to damage an npz file."""
