"""The signals of a Record that the package knows, and what shape each of them has.

A signal of another name may be any array. Of a known one, the axes are named: ``"frames"`` are
those of the motion, ``"nv"`` its generalised forces, and axes of one name are equally long within a
family (what stands before the dot). So whatever reads a Record may rely on them.
"""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array
from plantigrade.contact.thing import Thing
from plantigrade.errors import ParameterError

NUMBERS, WORDS, FLAGS = "fiub", "US", "b"

SIGNALS: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "check.quantity": (WORDS, ("measures",)),
    "check.value": (NUMBERS, ("measures",)),
    "check.limit": (NUMBERS, ("measures",)),
    "check.time": (NUMBERS, ("measures",)),
    "check.where": (WORDS, ("measures",)),
    "check.side": (WORDS, ("measures",)),
    "check.unit": (WORDS, ("measures",)),
    "check.bad": (NUMBERS, ("measures",)),
    "check.findings": (WORDS, ("findings",)),
    "solver.stage_names": (WORDS, ("stages",)),
    "solver.stage_solvers": (WORDS, ("stages",)),
    "solver.stage_status": (WORDS, ("stages",)),
    "solver.stage_nodes": (NUMBERS, ("stages",)),
    "solver.history": (NUMBERS, ("iterations", 5)),
    "solver.history_worst": (WORDS, ("iterations",)),
    "solver.broken": (WORDS, ("constraints",)),
    "tasks.names": (WORDS, ("tasks",)),
    "tasks.level": (NUMBERS, ("tasks",)),
    "tasks.meanings": (WORDS, ("tasks",)),
    "tasks.active": (NUMBERS, ("frames", "tasks")),
    "tasks.residual": (NUMBERS, ("frames", "tasks")),
    "phase.span": (NUMBERS, ("phases", 2)),
    "phase.kind": (WORDS, ("phases",)),
    "phase.swing": (WORDS, ("phases",)),
    "posture.end": (NUMBERS, ("postures",)),
    "contact.span": (NUMBERS, ("contacts", 2)),
    "contact.place": (WORDS, ("contacts",)),
    "norms.people": (WORDS, (1,)),
    "norms.names": (WORDS, ("curves",)),
    "norms.mean": (NUMBERS, ("curves", "percent")),
    "norms.sd": (NUMBERS, ("curves", "percent")),
    "foot.names": (WORDS, ("angles",)),
    "foot.percent": (NUMBERS, ("percent",)),
    "forces.measured": (FLAGS, ("frames", 2)),
    "forces.band": (NUMBERS, ("frames", 2, 3)),
    "forces.point_band": (NUMBERS, ("frames", 2, 2)),
    "forces.torque_band": (NUMBERS, ("frames", 2)),
    "forces.moment_band": (NUMBERS, ("frames", "nv")),
    "estimated.force": (NUMBERS, ("frames", 2, 3)),
    "measured.force": (NUMBERS, ("frames", 2, 3)),
    "measured.moment": (NUMBERS, ("frames", "moments")),
    "measured.moment_names": (WORDS, ("moments",)),
    "ground.place": (NUMBERS, ("frames", 4)),
    "barrier.clearance": (NUMBERS, ("frames",)),
    "things.name": (WORDS, ("things",)),
    "things.kind": (WORDS, ("things",)),
    "things.size": (NUMBERS, ("things", 3)),
    "things.place": (NUMBERS, ("frames", "things", 7)),
    "vault.joints": (WORDS, ("joints",)),
    "vault.activation": (NUMBERS, ("frames", "joints")),
    "vault.changed": (WORDS, ("changes",)),
    "vault.change": (NUMBERS, ("changes", 3)),
}
"""Name of a signal → numbers or words, and its axes."""

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

TOGETHER = (
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


def check_signals(signals: Mapping[str, Array], n_frames: int, nv: int) -> None:
    """Refuse known signals of another kind or shape.

    Raises:
        ParameterError: If there is one, or a part of what belongs together is missing.
    """
    sizes: dict[tuple[str, str], int] = {}
    own = {"frames": n_frames, "nv": nv}
    for name, value in signals.items():
        if name not in SIGNALS:
            continue
        kind, axes = SIGNALS[name]
        empty = value.dtype.kind == "f" and not value.size  # what NumPy makes of an empty list
        if value.dtype.kind not in kind and not empty:
            what = {NUMBERS: "numbers", WORDS: "words", FLAGS: "yes or no"}[kind]
            raise ParameterError(f"signal {name} holds {value.dtype}, not {what}")
        if name in FINITE and not np.isfinite(value).all():
            raise ParameterError(f"signal {name} holds numbers that are not finite")
        expected = []
        for axis, size in zip(axes, value.shape, strict=False):
            if isinstance(axis, str):
                axis = own[axis] if axis in own else sizes.setdefault(_of(name, axis), size)
            expected.append(axis)
        if value.ndim != len(axes) or list(value.shape) != expected:
            wanted = ", ".join(map(str, expected if value.ndim == len(axes) else axes))
            raise ParameterError(f"signal {name} has shape {value.shape}, not ({wanted})")
    for family in TOGETHER:
        missing = [name for name in family if name not in signals]
        if missing and len(missing) < len(family):
            raise ParameterError(f"signal {missing[0]} is missing, but others of its kind exist")
    things = (signals.get(f"things.{what}", ()) for what in ("name", "kind", "size"))
    for name, kind, (x, y, z) in zip(*things, strict=True):
        Thing(str(name), str(kind), (float(x), float(y), float(z)))
    curves = (f"foot.{name}" for name in signals.get("foot.names", ()))
    length = len(signals.get("foot.percent", ()))
    for name in curves:
        if name in signals and signals[name].shape[1:] != (length,):
            raise ParameterError(f"signal {name} is no row of {length} numbers per cycle")


def _of(name: str, axis: str) -> tuple[str, str]:
    return name.partition(".")[0], axis
