"""Output of a command: figures and text."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


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
