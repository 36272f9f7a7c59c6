"""Formatting of numbers and names on pages."""

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from plantigrade.charts.labels import title_of
from plantigrade.constants import SIDE_NAMES
from plantigrade.side_names import side_of


def figure_text(value: Any) -> str:
    """Return the text of a figure in a table.

    Example:
        >>> figure_text(-0.012345), figure_text(1234.5), figure_text(None), figure_text(True)
        ('−0.0123', '1234', '', 'yes')
    """
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, str, np.integer)):
        return str(value)
    return number_text(float(value))


def number_text(value: float) -> str:
    """Return a number with three significant digits and a true minus sign."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return text.replace("-", "−")


def signed_text(value: float, digits: int = 1) -> str:
    """Return a signed figure.

    Example:
        >>> signed_text(-0.04), signed_text(-2.0), signed_text(3)
        ('0.0', '−2.0', '+3.0')
    """
    text = f"{value:+.{digits}f}"
    return (text if float(text) else text[1:]).replace("-", "−")


def rounded_text(value: float | None, digits: int = 2) -> str:
    """Return a figure with a number of decimals; a dash if it is unknown."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:.{digits}f}".replace("-", "−")


def power_text(value: float) -> str:
    """Return a small number as a power of ten."""
    return f"{value:.1e}".replace("e-0", "e-").replace("-", "−") if math.isfinite(value) else "–"


def sided_title(name: str) -> str:
    """Return the title of a coordinate with its side.

    Example:
        >>> sided_title("knee_angle_r"), sided_title("pelvis_tilt")
        ('Knee flexion, right', 'Pelvis tilt')
    """
    side = side_of(name)
    return f"{title_of(name)}, {SIDE_NAMES[side]}" if side else title_of(name)


def place_text(name: str, side: str) -> str:
    """Return the name of a place with its side in front.

    Example:
        >>> place_text("heel_back_r", "r"), place_text("chair", "")
        ('right heel back', 'chair')
    """
    plain = name.removesuffix(f"_{side}") if side else name
    front = f"{SIDE_NAMES[side]} " if side in SIDE_NAMES and plain != name else ""
    return f"{front}{plain.replace('_', ' ')}"


def task_text(name: str) -> str:
    """Return a task's name with its side written out.

    Example:
        >>> task_text("swing heel r"), task_text("posture")
        ('swing heel right', 'posture')
    """
    stem, _, side = name.rpartition(" ")
    return f"{stem} {SIDE_NAMES[side]}" if side in SIDE_NAMES and stem else name


def provenance_rows(values: Mapping[str, Any]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return provenance as rows of a name and one value or pairs."""
    rows = []
    for name, value in values.items():
        if value in (None, "", {}, []):
            continue
        if not isinstance(value, Mapping | list | tuple):
            value = [value]
        pairs = value.items() if isinstance(value, Mapping) else [("", v) for v in value]
        shown = [(str(k), _flat(v)) for k, v in pairs if v is not None]
        words = name != "source_files"  # file names are not changed
        shown = [(k.replace("_", " ") if words else k, v) for k, v in shown]
        rows.append((str(name).replace("_", " "), shown))
    return rows


def _flat(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{k}: {_flat(v)}" for k, v in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(_flat(v) for v in value)
    return "–" if value is None else str(value)


def anchor(title: str) -> str:
    """Return the anchor of a section."""
    return "".join(c if c.isalnum() else "-" for c in title.lower()).strip("-")


def unbroken(text: str) -> str:
    r"""Return a text in which no line ends between a number and its unit.

    Example:
        >>> unbroken("a push of 100 N").endswith("100\N{NO-BREAK SPACE}N")
        True
    """
    return re.sub(r"(?<=\d) (?=(?:N|BW|W|J|m|cm|mm|kg|s|ms|Hz|%|m/s|°)\b|[%°])", "\u00a0", text)
