"""Every signal of a Record: name, unit, shape, meaning, the section that draws it; their checks.

``docs/signals.md`` is this table. Axes are named: ``frames`` are those of the motion, ``nv`` its
generalised forces, ``hinges`` its hinges, ``markers`` its recorded markers; other axes of one name
are equally long within a family, which is what stands before the first dot. ``*`` stands for any
word. Names of the families ``controller``, ``live`` and ``user`` are free.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plantigrade.arrays import Array
from plantigrade.contact.scene import SceneObject
from plantigrade.data_files import csv_rows
from plantigrade.errors import ParameterError, known_names

Kind = Literal["number", "word", "flag"]


@dataclass(frozen=True)
class Signal:
    """A signal that the package knows, or a family of them."""

    name: str  #: Its name; ``*`` at the end stands for any word
    kind: Kind  #: What it holds
    shape: str  #: Names or lengths of its axes, with spaces; ``...`` for any shape
    unit: str  #: SI unit, ``°`` or ``%``; empty for words, flags and pure numbers
    meaning: str  #: What it is
    section: str = ""  #: Title of the section of the report that draws it, ``viewer``, or empty

    @property
    def axes(self) -> tuple[str | int, ...]:
        """Names or lengths of its axes."""
        return tuple(int(axis) if axis.isdigit() else axis for axis in self.shape.split())

    @property
    def has_any_shape(self) -> bool:
        """Whether nothing is asked of its kind and shape."""
        return self.shape == "..."


CONTROLLER, USER = "controller.", "user."
"""Beginnings of free names: what a controller or a user stores."""

SIGNALS: Mapping[str, Signal] = {
    row.name: row for row in csv_rows("plantigrade.record", "signals.csv", Signal)
}
"""Every signal by name, and families by ``NAME.*``."""
_FAMILIES = {name[:-1]: signal for name, signal in SIGNALS.items() if name.endswith("*")}


def signal_of(name: str) -> Signal:
    """Return the signal of a name, or the family that it belongs to.

    Example:
        >>> signal_of("controller.com_error").unit
        'm'
    """
    found = SIGNALS.get(name)
    if found is not None:
        return found
    for beginning, family in _FAMILIES.items():
        if name.startswith(beginning) and name != beginning:
            return family
    raise ParameterError(
        f"no signal is called {name!r}; {known_names(name, list(SIGNALS))}. Names of your own "
        f"begin with {USER!r}, those of a controller with {CONTROLLER!r}"
    )


DTYPES: dict[Kind, tuple[str, str]] = {
    "number": ("fiub", "numbers"),
    "word": ("US", "words"),
    "flag": ("b", "yes or no"),
}
"""Kinds of NumPy dtypes that hold each kind of signal, and its name in a message."""

FINITE = (
    "tasks.level",
    "phase.span",
    "contact.span",
    "posture.end",
    "foot.percent",
    "norms.mean",
    "norms.sd",
    "vault.activation",
    "things.size",
)
"""Signals of numbers none of which is missing."""

SETS = (
    ("phase.span", "phase.kind", "phase.swing"),
    ("contact.span", "contact.place"),
    ("norms.people", "norms.names", "norms.mean", "norms.sd"),
    ("measured.moment", "measured.moment_names"),
    ("vault.joints", "vault.activation"),
    ("vault.changed", "vault.change"),
    ("things.name", "things.kind", "things.size", "things.place"),
    (
        "forces.measured",
        "forces.band",
        "forces.point_band",
        "forces.torque_band",
        "forces.moment_band",
    ),
)
"""Signals of which none is there without the others."""


def check_signals(
    signals: Mapping[str, Array], n_frames: int, nv: int, n_markers: int | None = None
) -> None:
    """Refuse unknown signals, and known ones of another kind or shape.

    Args:
        nv: Generalised forces of the person.
        n_markers: Recorded markers; None without a recording.
    """
    sizes: dict[tuple[str, str], int] = {}
    lengths = {"frames": n_frames, "nv": nv, "hinges": nv - 6}
    if n_markers is not None:
        lengths["markers"] = n_markers
    for name, value in signals.items():
        signal = signal_of(name)
        if not signal.has_any_shape:
            _check_kind(name, signal, value)
            _check_shape(name, signal, value.shape, lengths, sizes)
    for names in SETS:
        missing = [name for name in names if name not in signals]
        if missing and len(missing) < len(names):
            raise ParameterError(f"signal {missing[0]} is missing, but others of its kind exist")
    things = (signals.get(f"things.{what}", ()) for what in ("name", "kind", "size"))
    for name, kind, (x, y, z) in zip(*things, strict=True):
        SceneObject(str(name), str(kind), (float(x), float(y), float(z)))


def _check_kind(name: str, signal: Signal, value: Array) -> None:
    dtypes, words = DTYPES[signal.kind]
    empty = value.dtype.kind == "f" and not value.size  # what NumPy makes of an empty list
    if value.dtype.kind not in dtypes and not empty:
        raise ParameterError(f"signal {name} holds {value.dtype}, not {words}")
    if name in FINITE and not np.isfinite(value).all():
        raise ParameterError(f"signal {name} holds numbers that are not finite")


def _check_shape(
    name: str,
    signal: Signal,
    shape: tuple[int, ...],
    lengths: Mapping[str, int],
    sizes: dict[tuple[str, str], int],
) -> None:
    """Refuse another shape; ``sizes`` gathers the lengths of the axes of each family."""
    axes, family, expected = signal.axes, name.partition(".")[0], []
    for axis, size in zip(axes, shape, strict=False):
        if axis == "*":
            axis = size
        elif isinstance(axis, str):
            axis = lengths[axis] if axis in lengths else sizes.setdefault((family, axis), size)
        expected.append(axis)
    if len(shape) != len(axes) or list(shape) != expected:
        allowed = ", ".join(map(str, expected if len(shape) == len(axes) else axes))
        raise ParameterError(f"signal {name} has shape {shape}, not ({allowed})")
