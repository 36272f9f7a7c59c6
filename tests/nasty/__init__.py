"""Damaged files: what breaks readers, where a format has its numbers, words, lines and arrays.

A mutant is a seed, which is a valid file, changed by one or a few of the functions below. It
depends on its name alone: the same name gives the same bytes. :mod:`tests.nasty.targets` lists what
is read; the tests try a sample of each, and ``python -m tests.nasty`` tries as many as there is
time for.
"""

import json
import pickletools
import random
import re
import struct
from collections.abc import Callable, Iterator
from typing import Any

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


def instruction_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Other instructions of the machine that reads pickles, with what may follow them."""
    code = rng.choice(pickletools.opcodes).code.encode("latin1")
    code += rng.choice((b"", b"\0", b"\x01\0\0\0", b"os\nsystem\n", b"\xff" * 8))
    at = int(rng.random() ** 2 * len(raw))
    kept = raw[at + rng.choice((0, 1, len(code))) :]
    return f"instruction {code!r} at {at}", raw[:at] + code + kept


def value_changed(rng: random.Random, raw: bytes) -> tuple[str, bytes]:
    """Any value of a JSON text, the whole among them, is another."""
    what, changed = leaf_changed(rng, json.loads(raw))
    return what, json.dumps(changed).encode()


def leaf_changed(rng: random.Random, value: Any) -> tuple[str, Any]:
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


ANY: tuple[Mutation, ...] = (cut, bytes_changed, piece_lost, piece_twice, noise)
LINES: tuple[Mutation, ...] = (lines_mixed, line_twice, line_lost, encoded, numbers_changed)
TEXT = (*ANY, *LINES, *[word_changed] * 5, *[head_word_changed] * 5)
"""Ways to damage a text file; those that tell most come more than once."""
JSON = (*TEXT, *[value_changed] * 15)
C3D = (*ANY, *[header_word] * 8, *[head_changed] * 4)
PICKLE = (*ANY, *[head_changed] * 8, *[instruction_changed] * 8)
JSON_VALUES = (value_changed,)
"""Ways that leave the file whole, so that more than its reader sees what was changed."""
