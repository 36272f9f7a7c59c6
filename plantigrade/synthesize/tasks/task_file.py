"""Tasks as files: a task of one's own in a few lines of TOML, no code.

A file names a task to start from, sets its parameters, and adds or takes away terms::

    [task]
    name = "deep squat, head still"
    base = "squat"
    without = ["acceleration"]

    [parameters]
    depth = 0.4

    [[term]]
    type = "acceleration"
    weight = 0.01

    [[term]]
    type = "head-stability"
    turning = 0.2

The base ``"standing"`` is nothing but a person on both feet for a while: with stances and postures
of one's own anything is built on it. All numbers are SI; a key with ``_deg`` behind it is in
degrees.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.contact.site import Point
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import Human
from plantigrade.synthesize.guess.postures import (
    KeyPostures,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.synthesize.tasks.registry import TASKS, make_task, parameters_of
from plantigrade.synthesize.tasks.standing import basics
from plantigrade.synthesize.tasks.task import BASES, MotionTask
from plantigrade.synthesize.terms import more_terms, terms

TERMS: Mapping[str, type] = {
    "dynamics": terms.Dynamics,
    "contact": terms.Contact,
    "pose": terms.Pose,
    "limits": terms.Limits,
    "torque": terms.Torque,
    "work": terms.Work,
    "acceleration": terms.Acceleration,
    "jerk": terms.Jerk,
    "posture": terms.Posture,
    "forces": terms.Forces,
    "rest": more_terms.Rest,
    "quiet": more_terms.Quiet,
    "within": more_terms.Within,
    "power-limit": more_terms.PowerLimit,
    "above": more_terms.Above,
    "clearance": more_terms.Clearance,
    "reach": more_terms.Reach,
    "centre-of-mass": more_terms.CentreOfMass,
    "head-stability": more_terms.HeadStability,
    "symmetry": more_terms.Symmetry,
}
"""Name of a term in a file → its class, whose fields are the keys."""

STANDING = "standing"
_TASK = ("name", "base", "without", "nodes_per_second", "basis")
_STANDING = ("duration",)
_STANCE = ("side", "x", "y", "height", "heading", "strike", "flat", "heel_off", "forefoot_off", "off")
_TOP = ("task", "parameters", "term", "stance")


@dataclass(frozen=True)
class TaskFile:
    """What a task file says.

    Attributes:
        name: What the task is called.
        base: A task of :data:`~plantigrade.synthesize.tasks.registry.TASKS`, or ``"standing"``.
        parameters: Of the base.
        without: Names of terms of the base that are left out.
        added: Names and arguments of terms that are added.
        stances: Stances as they are written, instead of the base's.
        nodes_per_second: Nodes a second; the base's if None.
        basis: ``"trigonometric"`` or ``"polynomial"``; the base's if None.
    """

    name: str
    base: str = STANDING
    parameters: Mapping[str, Any] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    added: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    stances: tuple[Mapping[str, Any], ...] = ()
    nodes_per_second: float | None = None
    basis: str | None = None

    def task(self, human: Human) -> MotionTask:
        """Return the task of a person.

        Raises:
            ParameterError: If a value is out of range for that person.
        """
        if self.base == STANDING:
            task = _standing(human, **self.parameters)
        else:
            task = make_task(self.base, human, self.parameters)
        left_out = tuple(TERMS[n] for n in self.without)
        kept = tuple(t for t in task.terms if not isinstance(t, left_out))
        more = tuple(TERMS[n](**dict(arguments)) for n, arguments in self.added)
        task = replace(task, name=self.name, terms=(*kept, *more))
        if self.stances:
            ordered = sorted((_stance(human, s) for s in self.stances), key=lambda s: s.heel_strike)
            task = replace(task, plan=replace(task.plan, stances=tuple(ordered)))
        if self.nodes_per_second is not None:
            task = replace(task, nodes_per_second=float(self.nodes_per_second))
        if self.basis is not None:
            task = replace(task, basis=self.basis)
        return task

    def toml(self) -> str:
        """Return the file's text; reading it gives the same."""
        head: dict[str, Any] = {"name": self.name, "base": self.base}
        if self.without:
            head["without"] = list(self.without)
        for key in ("nodes_per_second", "basis"):
            if getattr(self, key) is not None:
                head[key] = getattr(self, key)
        parts = [_table("[task]", head)]
        if self.parameters:
            parts.append(_table("[parameters]", self.parameters))
        parts += [_table("[[stance]]", s) for s in self.stances]
        parts += [_table("[[term]]", {"type": n, **a}) for n, a in self.added]
        return "\n".join(parts)


def read_task_file(path: str | Path) -> TaskFile:
    """Return what a task file says, every key checked.

    Raises:
        FileError: If it cannot be read, or a key or value is not allowed.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read: {error}") from error
    return parse_task_file(text, path)


def parse_task_file(text: str, path: str | Path = "task.toml") -> TaskFile:
    """Return what the text of a task file says.

    Args:
        text: TOML.
        path: Named in errors.

    Raises:
        FileError: If a key or value is not allowed.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not TOML: {error}") from error

    def wrong(where: str, problem: str, remedy: str = "") -> FileError:
        return FileError(path, problem, where=where, remedy=remedy)

    def known(where: str, given: Mapping[str, Any], allowed) -> None:
        for key in given:
            if key not in allowed:
                raise wrong(where, f"unknown key {key!r}", f"allowed are {', '.join(allowed)}")

    known("top level", document, _TOP)
    for key in ("task", "parameters"):
        if not isinstance(document.get(key, {}), dict):
            raise wrong(key, "must be a table", f"write it as [{key}]")
    for key in ("term", "stance"):
        entries = document.get(key, [])
        if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
            raise wrong(key, "must be tables", f"write each as [[{key}]]")
    head = document.get("task")
    if not head:
        raise wrong("[task]", "is missing", 'write [task] with base = "squat" or another task')
    known("[task]", head, _TASK)
    base = head.get("base", STANDING)
    if base != STANDING and base not in TASKS:
        raise wrong("[task] base", f"no task {base!r}", f"there are {STANDING}, {', '.join(TASKS)}")
    name = head.get("name", base)
    if not isinstance(name, str) or not name:
        raise wrong("[task] name", f"is {name!r}", "write a name in quotes")
    nodes_per_second = head.get("nodes_per_second")
    if nodes_per_second is not None and not (_is_number(nodes_per_second) and nodes_per_second > 0):
        raise wrong(
            "[task] nodes_per_second",
            f"is {nodes_per_second!r}",
            "nodes a second, a positive number",
        )
    basis = head.get("basis")
    if basis is not None and basis not in BASES:
        raise wrong("[task] basis", f"is {basis!r}", f"allowed are {', '.join(BASES)}")
    without = head.get("without", [])
    if not isinstance(without, list) or any(n not in TERMS for n in without):
        raise wrong("[task] without", f"is {without!r}", f"a list of {', '.join(TERMS)}")

    parameters = _in_radians(document.get("parameters", {}))
    allowed = _STANDING if base == STANDING else tuple(parameters_of(base))
    known("[parameters]", parameters, allowed)
    parameters = {k: tuple(v) if isinstance(v, list) else v for k, v in parameters.items()}

    added = []
    for i, entry in enumerate(document.get("term", []), start=1):
        where = f"[[term]] {i}"
        kind = entry.get("type")
        if kind not in TERMS:
            raise wrong(where, f"type is {kind!r}", f"there are {', '.join(TERMS)}")
        given = _in_radians({k: v for k, v in entry.items() if k != "type"})
        known(f"{where} ({kind})", given, [f.name for f in fields(TERMS[kind])])
        for f in fields(TERMS[kind]):
            if f.name in given:
                try:
                    given[f.name] = _value(f.type, given[f.name])
                except ParameterError as error:
                    raise wrong(f"{where} ({kind}) {f.name}", str(error)) from error
            elif f.default is MISSING and f.default_factory is MISSING:
                raise wrong(f"{where} ({kind})", f"{f.name} is missing")
        added.append((kind, given))

    stances = []
    for i, entry in enumerate(document.get("stance", []), start=1):
        where, given = f"[[stance]] {i}", _in_radians(entry)
        known(where, given, _STANCE)
        if given.get("side") not in ("r", "l"):
            raise wrong(f"{where} side", f"is {given.get('side')!r}", 'write "r" or "l"')
        for key, value in given.items():
            if key != "side" and not _is_number(value):
                raise wrong(f"{where} {key}", f"is {value!r}", "a number is needed")
        stances.append(given)
    return TaskFile(
        name,
        base,
        parameters,
        tuple(without),
        tuple(added),
        tuple(stances),
        nodes_per_second,
        basis,
    )


def _standing(human: Human, duration: float = 2.0) -> MotionTask:
    """Return a person who stands on both feet, with the usual conditions and costs."""
    if not 0.1 <= duration <= 60.0:
        raise ParameterError(f"{duration=} [s] must be 0.1 to 60")
    plan = ContactPlan(duration, standing_stances(standing_feet(human), duration))
    q = standing_posture(human)
    return MotionTask(STANDING, plan, basics(), KeyPostures((0.0, duration), (q, q)))


def _stance(human: Human, given: Mapping[str, Any]) -> Stance:
    """Return a stance; what is not given is as in standing, and for ever."""
    foot = standing_feet(human)[given["side"]]
    x, y, z = foot.position
    print_ = Footprint(
        foot.side,
        (float(given.get("x", x)), float(given.get("y", y)), float(given.get("height", z))),
        float(given.get("heading", 0.0)),
    )
    strike = float(given.get("strike", -1.0))
    off = float(given.get("off", 1e3))
    ball = float(given.get("forefoot_off", off))
    heel = float(given.get("heel_off", ball))
    return Stance(print_, strike, float(given.get("flat", strike)), heel, ball, off)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value == value


def _in_radians(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table whose keys with ``_deg`` behind them are in radians, and without it."""

    def turned(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: turned(v) for k, v in value.items()}
        if isinstance(value, list):
            return [turned(v) for v in value]
        return float(np.deg2rad(value)) if _is_number(value) else value

    return {
        k.removesuffix("_deg"): turned(v) if k.endswith("_deg") else v for k, v in given.items()
    }


def _value(kind: Any, value: Any) -> Any:
    """Return a value as a field needs it.

    Raises:
        ParameterError: If it is something else; the message says what is needed.
    """
    text = str(kind)
    if kind is bool:
        if not isinstance(value, bool):
            raise ParameterError(f"is {value!r}; true or false is needed")
        return value
    if kind is str:
        if not isinstance(value, str):
            raise ParameterError(f"is {value!r}; a word in quotes is needed")
        return value
    if kind is float:
        if not _is_number(value):
            raise ParameterError(f"is {value!r}; a number is needed")
        return float(value)
    if kind is Point:
        if not isinstance(value, dict) or set(value) - {"body", "position", "radius"}:
            raise ParameterError(
                'a point is written { body = "hand_r", position = [0.0, 0.0, -0.1] }'
            )
        return Point(**{**value, "position": tuple(value.get("position", (0.0, 0.0, 0.0)))})
    if "Mapping" in text:
        if not isinstance(value, dict):
            raise ParameterError(f"is {value!r}; a table {{ knee_angle = 1.0 }} is needed")
        pairs = "tuple" in text
        for k, v in value.items():
            good = isinstance(v, list) and len(v) == 2 if pairs else _is_number(v)
            if not good:
                raise ParameterError(
                    f"{k} is {v!r}; {'two numbers in brackets' if pairs else 'a number'} is needed"
                )
        return {k: tuple(map(float, v)) if pairs else float(v) for k, v in value.items()}
    n = text.count("float")
    if not isinstance(value, list) or len(value) != n or not all(_is_or_nan(v) for v in value):
        raise ParameterError(f"is {value!r}; {n} numbers in brackets are needed")
    return tuple(float(v) for v in value)


def _is_or_nan(value: Any) -> bool:
    return _is_number(value) or isinstance(value, float)


def _table(title: str, content: Mapping[str, Any]) -> str:
    lines = [f"{key} = {_text(value)}" for key, value in content.items()]
    return "\n".join([title, *lines, ""])


def _text(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {_text(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    if is_dataclass(value):
        return _text({f.name: getattr(value, f.name) for f in fields(value)})
    return repr(value)
