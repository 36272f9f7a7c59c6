r"""Text that is safe to print in a terminal, and names that a file system accepts.

Names of files, markers and people are not trusted: characters that would move the cursor, set the
title of the window, hide a link or reverse the line are written as escapes, as ``\x1b``; so
are bytes of a file name that are not UTF-8.
"""

import re
from collections.abc import Sequence
from typing import Any

UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but tab and line end, C1 among them
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"  # direction of writing, line separators
    "\ud800-\udfff]"  # bytes that are no UTF-8
)
MAX_FOLDER_NAME = 200
"""Maximum length of a folder's name [bytes]; file systems allow 255, and a number may follow."""


def printable(text: str, *, lines: bool = True) -> str:
    r"""Return a text with control characters as escapes.

    Example:
        >>> print(printable("a\x1b]0;b\x07 c\udcff \u202etxt"))
        a\x1b]0;b\x07 c\xff \u202etxt
    """
    text = UNSAFE.sub(_escape, text)
    return text if lines else text.replace("\n", r"\n").replace("\t", r"\t")


def listed(words: Sequence[str], most: int = 8, between: str = ", ") -> str:
    """Return the first items of a list for a message, with an ellipsis if there are more.

    Example:
        >>> listed(["a", "b", "c"], 2)
        'a, b …'
    """
    return between.join(words[:most]) + (" …" if len(words) > most else "")


def joined(words: Sequence[str]) -> str:
    """Return phrases as an enumeration.

    Example:
        >>> joined(["a push", "a slope", "steps"])
        'a push, a slope and steps'
    """
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def short_name(name: str) -> str:
    """Return the name of a folder, shortened in the middle to what file systems allow.

    Example:
        >>> short_name("walk"), len(short_name("x" * 255))
        ('walk', 201)
    """
    raw = name.encode("utf-8", "surrogateescape")
    if len(raw) <= MAX_FOLDER_NAME:
        return name
    half = MAX_FOLDER_NAME // 2
    start, end = raw[:half].decode("utf-8", "ignore"), raw[-half:].decode("utf-8", "ignore")
    return f"{start}…{end}"


def _escape(match: re.Match[str]) -> str:
    code = ord(match[0])
    if 0xDC80 <= code <= 0xDCFF:
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def cell(value: Any) -> Any:
    """Return a value as a table of comma-separated values shows it: six digits, nothing for NaN.

    Example:
        >>> cell(1 / 3), cell(float("nan")), cell(None), cell("ok")
        ('0.333333', '', '', 'ok')
    """
    if value is None or (isinstance(value, float) and value != value):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else value
