"""What a command returns to be printed: its figures and the words that go with them."""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Outcome:
    """What a command found.

    Attributes:
        text: What to print for a reader.
        metrics: Every figure of the run, as in ``metrics.json``: flat snake_case keys with the unit
            as suffix, and ``status``: ``"ok"`` or what went wrong, where and when.
    """

    text: str = ""
    metrics: dict[str, Any] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether the method reached a valid result."""
        return self.metrics.get("status", "ok") == "ok"


def as_json(metrics: dict[str, Any]) -> str:
    """Return ``metrics`` as JSON text that every parser reads: NaN and infinity become null.

    Example:
        >>> print(as_json({"status": "ok", "cadence_per_min": float("nan")}))
        {
          "status": "ok",
          "cadence_per_min": null
        }
    """
    return json.dumps(_plain(metrics), indent=2, allow_nan=False, ensure_ascii=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # NumPy arrays and scalars, without loading NumPy
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
