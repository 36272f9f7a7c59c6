"""Output of a command: figures and text."""

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

VERDICTS = {r"\bcheck passed\b": "1;32", r"\bCHECK FAILED\b": "1;31"}
"""Words of a verdict → their colour on a terminal (bold green, bold red)."""


@dataclass(frozen=True)
class Outcome:
    """Output of a command."""

    text: str = ""  #: Text to print
    #: Every figure of the run, as in ``metrics.json``: flat snake_case keys with the unit as
    #: suffix, and ``status``: ``"ok"`` or what went wrong, where and when
    metrics: dict[str, Any] = field(default_factory=dict)
    folders: tuple[Path, ...] = ()  #: Folders of results that it wrote

    @property
    def ok(self) -> bool:
        """Whether the method reached a valid result."""
        return self.metrics.get("status", "ok") == "ok"


def coloured(text: str, stream: Any) -> str:
    """Return a text with its verdict in colour, where it goes to a terminal that is to have any.

    The variable ``NO_COLOR`` turns colours off.
    """
    if os.environ.get("NO_COLOR") or not stream.isatty():
        return text
    for words, colour in VERDICTS.items():
        text = re.sub(words, rf"\033[{colour}m\g<0>\033[0m", text)
    return text
