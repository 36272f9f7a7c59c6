"""Damaged files: what breaks readers, where a format has its numbers, words, lines and arrays.

A mutant is a seed, which is a valid file, changed by one or a few of the functions below. It
depends on its name alone: the same name gives the same bytes. :mod:`tests.nasty.targets` lists what
is read; the tests try a sample of each, and ``python -m tests.nasty`` tries as many as there is
time for.
"""

import io
import json
import random
import re
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

Mutation = Callable[[random.Random, bytes], tuple[str, bytes]]
"""Changes a file: returns what was done, and the bytes."""

NUMBERS = (
    *("0", "-0", "-1", "1e308", "-1e308", "1e-308", "1e999", "nan", "inf", "-inf", "+nan"),
    *("65536", "2147483648", "9223372036854775808", "18446744073709551616", "1" + "0" * 400),
    *("9" * 5000, "-" + "9" * 5000, "0x1F", "1_0", "٣", "²", "1e5", "0.5"),
    *("1000000000", "99999999999999999999", "1,5", "1e", "--1", "2", "1e12", "1e-12"),
)
WORDS = (
    *("", "x", "true", "null", '"x"', "'", '"""', "[[1]]", "{}", "[", "{", "}", ":", "1979-05-27"),
    *("00:00:00", "\x1b]0;x\x07", "\u202e", "\udcff", "\0", "<script>", "../x", "{'a': []}"),
    *("[" * 100_000, "{" * 3000, '{"a":' * 3000, "a." * 3000 + "a = 1\n", "\t", "\n", "\r", "ü"),
    *("x" * 5000, '"' + "x\x1b" * 500 + '"', "/etc/passwd", "a\u2028b", "#", "//", "\\"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 0.5, 1e308, -1e308, 10**19, 10**400, float("nan"), float("inf")),
    *("", "x", "nan", "\x1b]8;;x\x07<script>", "9" * 5000, "\u202e", [], {}, [[]], [1], {"a": 1}),
)
"""Values of JSON in place of any other."""
ENCODINGS = ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig", "cp037", "cp1252")
TOKEN = re.compile(rb"[^\s,=\[\]{}:()]+")
SEPARATORS = set(map(bytes, zip(b" \t\r\n,=[]{}:()", strict=True)))
NUMBER = re.compile(rb"-?\d+(\.\d+)?")
HEAD = 1500
"""Length of what counts as the header of a text [bytes]."""


def mutants(name: str, content: bytes, ways: tuple[Mutation, ...], count: int) -> Iterator[tuple]:
    """Yield so many mutants of a file, each as what was done and the bytes."""
    for number in range(count):
        yield mutant(f"{name}/{number}", content, ways)


def mutant(name: str, content: bytes, ways: tuple[Mutation, ...]) -> tuple[str, bytes]:
    """Return the mutant of that name: mostly one change, sometimes two or three."""
    rng, done = random.Random(name), []
    for _ in range(rng.choice((1, 1, 1, 1, 2, 3))):
        try:
            what, content = rng.choice(ways)(rng, content)
        except Exception:  # the change before left nothing that this one could be made to
            what, content = bytes_changed(rng, content)
        done.append(what)
    return "; ".join(done), content


def cut(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A file that ends anywhere."""
    at = rng.randrange(len(raw) + 1)
    return f"ends at byte {at}", raw[:at]


def bytes_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Up to 20 other bytes, more of them near the front, where headers are."""
    changed = bytearray(raw)
    places = [int(rng.random() ** 2 * len(raw)) for _ in range(rng.randint(1, 20))] if raw else []
    for place in places:
        changed[place] = rng.randrange(256)
    return f"other bytes at {places}", bytes(changed)


def head_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Up to 5 other bytes, all within the header of a binary file."""
    changed, size = bytearray(raw), min(len(raw), 6000)
    places = [rng.randrange(size) for _ in range(rng.randint(1, 5))] if size else []
    for place in places:
        changed[place] = rng.randrange(256)
    return f"other bytes of the header at {places}", bytes(changed)


def piece_lost(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Some bytes are missing."""
    at, size = rng.randrange(len(raw) + 1), rng.randint(1, 80)
    return f"{size} bytes lost at {at}", raw[:at] + raw[at + size :]


def piece_twice(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A piece of any length comes again elsewhere."""
    start, stop = sorted(rng.randrange(len(raw) + 1) for _ in range(2))
    at, stop = rng.randrange(len(raw) + 1), min(stop, start + 4096)
    return f"bytes {start} to {stop} again at {at}", raw[:at] + raw[start:stop] + raw[at:]


def noise(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Noise after a good start, or the same byte without end."""
    keep = rng.choice((0, 2, 16, 64, 512, 1024))
    tail = rng.choice(
        (rng.randbytes(rng.randrange(3000)), rng.choice(b" \0\n\xff").to_bytes() * 5000)
    )
    return f"{len(tail)} bytes of noise after {keep}", raw[:keep] + tail


def word_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Any number or word is another."""
    return _token(rng, raw, rng.randrange(len(raw) + 1), NUMBERS + WORDS)


def head_word_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A number or word of the header is another number."""
    return _token(rng, raw, rng.randrange(min(len(raw), HEAD) + 1), NUMBERS)


def _token(rng: random.Random, raw: bytes, at: int, words: tuple[str, ...]) -> tuple[str, bytes]:
    word = rng.choice(words)
    while at and raw[at - 1 : at] not in SEPARATORS:
        at -= 1
    found = TOKEN.search(raw, at) or TOKEN.search(raw)
    start, end = found.span() if found else (0, 0)
    said = raw[start : min(end, start + 20)].decode("latin-1")
    what = f"{said!r} at {start} -> {word[:20]!r} ({len(word)} characters)"
    return what, raw[:start] + word.encode("utf-8", "surrogateescape") + raw[end:]


def numbers_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A share of all numbers is the same other word."""
    word, share = rng.choice(NUMBERS[:20] + ("", "x", "-5")), rng.random()
    new = word.encode()
    if len(new) * len(raw) > 1e7:
        new = new[:20]
    changed = NUMBER.sub(lambda found: new if rng.random() < share else found[0], raw)
    return f"{share:.0%} of all numbers -> {word[:20]!r}", changed


def lines_mixed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Lines in another order, some lost, some twice."""
    lines = raw.split(b"\n")
    return "lines mixed", b"\n".join(rng.choices(lines, k=len(lines)))


def line_twice(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A line comes again, there or elsewhere."""
    lines = raw.split(b"\n")
    i = rng.randrange(len(lines))
    at = rng.choice((i, rng.randrange(len(lines))))
    return f"line {i} again at {at}", b"\n".join([*lines[:at], lines[i], *lines[at:]])


def line_lost(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A line is missing."""
    lines = raw.split(b"\n")
    i = rng.randrange(min(len(lines), rng.choice((20, len(lines)))))
    return f"without line {i}", b"\n".join([*lines[:i], *lines[i + 1 :]])


def encoded(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Another encoding, also with its last byte lost."""
    encoding, lost = rng.choice(ENCODINGS), rng.randrange(2)
    other = raw.decode("utf-8", "replace").encode(encoding, "replace")
    return f"as {encoding}, {lost} bytes lost", other[: len(other) - lost]


def value_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Any value of a JSON text, the whole among them, is another."""
    what, changed = _leaf_changed(rng, json.loads(raw))
    return what, json.dumps(changed).encode()


def _leaf_changed(rng: random.Random, value: Any) -> tuple[str, Any]:
    """Return a JSON value with one part that is another, is missing, or has another name."""
    path = rng.choice(list(_leaves(value)))
    new = rng.choice(VALUES)
    if path and isinstance(path[-1], str) and rng.random() < 0.1:
        inside = value
        for key in path[:-1]:
            inside = inside[key]
        kept = {k: v for k, v in inside.items() if k != path[-1]}
        return f"without {path}", _replaced(value, path[:-1], kept)
    return f"{path} -> {str(new)[:20]!r}", _replaced(value, path, new)


def _leaves(value: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield where each part of a JSON value is, the whole among them."""
    yield path
    if isinstance(value, dict | list):
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _leaves(part, (*path, key))


def _replaced(value: Any, path: tuple, new: Any) -> Any:
    """Return a JSON value with one part replaced."""
    if not path:
        return new
    copy = value.copy()
    copy[path[0]] = _replaced(value[path[0]], path[1:], new)
    return copy


def header_word(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """A word of 16 bits, or a float, of a C3D header or of its parameters is an absurd one."""
    changed = bytearray(raw)
    size = min(len(raw) - 4, rng.choice((24, 512, 6000)))
    at = 2 * rng.randrange(size // 2)
    if rng.random() < 0.7:
        value = rng.choice((0, 1, 2, 255, 256, 32767, 32768, 65535, rng.randrange(65536)))
        struct.pack_into("<H", changed, at, value)
    else:
        value = rng.choice((0.0, -1.0, float("nan"), float("inf"), 1e30, -1e-30, 1e6))
        struct.pack_into("<f", changed, at, value)
    return f"header at {at} -> {value}", bytes(changed)


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
    what, changed = _leaf_changed(rng, json.loads(str(arrays[key])))
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
            return f"{name}: {what}", _zipped({**members, name: _npy(header)})
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


def _npy(header: bytes, version: int = 2) -> bytes:
    header = header.ljust(117) + b"\n"
    data = np.zeros(8).tobytes()
    return b"\x93NUMPY" + bytes([version, 0]) + len(header).to_bytes(4, "little") + header + data


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


ANY: tuple[Mutation, ...] = (cut, bytes_changed, piece_lost, piece_twice, noise)
LINES: tuple[Mutation, ...] = (lines_mixed, line_twice, line_lost, encoded, numbers_changed)
TEXT = (*ANY, *LINES, *[word_changed] * 5, *[head_word_changed] * 5)
"""Ways to damage a text file; those that tell most come more than once."""
JSON = (*TEXT, *[value_changed] * 15)
NPZ = (*ANY, *[array_changed] * 10, *[text_in_array_changed] * 5, *[archive_changed] * 5)
C3D = (*ANY, *[header_word] * 8, *[head_changed] * 4)
NPZ_VALUES = (array_changed, text_in_array_changed)
JSON_VALUES = (value_changed,)
"""Ways that leave the file whole, so that more than its reader sees what was changed."""
