"""Reader of task files: every key and value checked, what is wrong named with its place."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from plantigrade.bounds import shown
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import SUPPORTED_PARTS
from plantigrade.contact.plan import UP
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import FileError, ParameterError, did_you_mean, known_names
from plantigrade.trajopt.tasks.free_time import FreeTime, TimeUse
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.task import BASES
from plantigrade.trajopt.tasks.toml_values import as_field, in_radians, is_number
from plantigrade.trajopt.terms import (
    contact,
    device,
    effort,
    external,
    impairment,
    limits,
    momentum,
    posture,
    solid,
    targets,
)
from plantigrade.trajopt.terms.term import Term

_KINDS: tuple[type[Term], ...] = (
    *(contact.Dynamics, contact.Contact, contact.Above, contact.Clearance, contact.Forces),
    *(limits.Limits, limits.Within, limits.PowerLimit),
    *(impairment.Weakness, impairment.Brace, external.Wrench, external.Hold, device.Device),
    *(effort.Torque, effort.Work, effort.AnklePower, effort.Acceleration, effort.Jerk),
    *(posture.Pose, posture.Rest, posture.Quiet, posture.Posture, posture.LumbopelvicRhythm),
    *(posture.Upright, posture.Facing, posture.Symmetry, targets.Reach, targets.CentreOfMass),
    *(momentum.AngularMomentum, solid.SolidLimbs, effort.Endurance),
)
TERMS = {re.sub(r"\B([A-Z])", r"-\1", kind.__name__).lower(): kind for kind in _KINDS}
"""Name of a term in a file → its class, whose fields are the keys."""

RENAMED = {"head-stability": "upright"}  #: Former name of a term → today's
STANDING = "standing"  #: The task that a file starts from if it names none
MAX_FRICTION = 2.0  # [1] maximum coefficient of friction of a support; rubber on dry stone has 1
_TASK = ("name", "base", "without", "gravity", "nodes_per_second", "basis")
_TIMES = ("heel_strike", "foot_flat", "heel_off", "forefoot_off", "toe_off")
_STANCE = ("side", "x", "y", "height", "heading", *_TIMES)
_SUPPORT_TIMES = ("start", "stop")
_SUPPORT = ("part", "place", "normal", "friction", *_SUPPORT_TIMES, "motion")
FREE_TIME_KEYS = ("least", "most", "guess")
_TERM_TIMES = ("time", "start", "stop")
_EXPRESSION = re.compile(r"\s*([A-Za-z]\w*)\s*(?:([+-])\s*(\d+(?:\.\d*)?|\.\d+)\s*)?")
"""A free time, and what is added to it or taken from it [s]."""
TABLES = (
    "task", "free_times", "parameters", "impairments", "ground", "term", "stance", "support",
)  # fmt: skip
MOTION_EXAMPLE = (
    "motion = [[0.5, 0.0, 0.0, 0.0], [2.0, 0.0, 0.2, 0.0]], rows of time and displacement"
)


@dataclass(frozen=True)
class TaskReader:
    """Checks tables of a task file; what is wrong is named with its place."""

    path: Path

    def wrong(self, where: str, problem: str, remedy: str = "") -> FileError:
        """Return the error of a place in the file."""
        return FileError(self.path, problem, where=where, remedy=remedy)

    def no_term(self, where: str, problem: str, given: Sequence[Any]) -> FileError:
        """Return the error of names of no term: the nearest, and a note that explains every one."""
        words = [name for name in given if isinstance(name, str)]
        renamed = [f"{name} is now {RENAMED[name]}" for name in words if name in RENAMED]
        near = [did_you_mean(name, TERMS) for name in words if name not in TERMS]
        remedy = "; ".join(renamed) or f"{''.join(near)}the terms are listed below"
        error = self.wrong(where, problem, remedy)
        if not renamed:
            width = max(map(len, TERMS))
            lines = ((kind.__doc__ or "").split("\n")[0] for kind in TERMS.values())
            listed = (f"  {name:{width}}  {line}" for name, line in zip(TERMS, lines, strict=True))
            error.add_note("\n".join(listed))
        return error

    def known(self, where: str, given: Mapping[str, Any], allowed: Sequence[str]) -> None:
        """Refuse keys that are not allowed."""
        for key in given:
            if key not in allowed:
                raise self.wrong(where, f"unknown key {key!r}", f"allowed are {', '.join(allowed)}")

    def head(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that ``[task]`` gives."""
        self.known("[task]", given, _TASK)
        base, basis = given.get("base", STANDING), given.get("basis")
        if not isinstance(base, str) or base not in TASKS:
            raise self.wrong(
                "[task] base", f"no task {base!r}", known_names(str(base), list(TASKS))
            )
        name = given.get("name", base)
        if not isinstance(name, str) or not name:
            raise self.wrong("[task] name", f"is {shown(name)}", "write a name in quotes")
        gravity = given.get("gravity")
        if gravity is not None and not is_number(gravity):
            raise self.wrong("[task] gravity", f"is {shown(gravity)}", "a number, 1 on the earth")
        rate = given.get("nodes_per_second")
        if rate is not None and not (is_number(rate) and 0 < rate <= 500):
            raise self.wrong("[task] nodes_per_second", f"is {shown(rate)}", "a number up to 500")
        if basis is not None and not (isinstance(basis, str) and basis in BASES):
            raise self.wrong(
                "[task] basis", f"is {shown(basis)}", f"allowed are {', '.join(BASES)}"
            )
        without = given.get("without", [])
        if not isinstance(without, list) or not all(
            isinstance(n, str) and n in TERMS for n in without
        ):
            names = without if isinstance(without, list) else [without]
            raise self.no_term("[task] without", f"is {shown(without)}", names)
        mesh = {"nodes_per_second": None if rate is None else float(rate), "basis": basis}
        return {"name": name, "base": base, "without": tuple(without), "gravity": gravity, **mesh}

    def free_times(self, given: Mapping[str, Any]) -> tuple[FreeTime, ...]:
        """Return the free times; where no guess is given, it is in the middle."""
        found = []
        for name, bounds in given.items():
            where = f"[free_times] {name}"
            if not _EXPRESSION.fullmatch(name) or not isinstance(bounds, dict):
                raise self.wrong(where, "is no free time", "write up = { least = 1.0, most = 3.0 }")
            self.known(where, bounds, FREE_TIME_KEYS)
            for key in ("least", "most"):
                if key not in bounds:
                    raise self.wrong(where, f"{key} is missing")
            for key, value in bounds.items():
                if not is_number(value):
                    raise self.wrong(where, f"{key} is {shown(value)}", "a number is needed")
            least, most = float(bounds["least"]), float(bounds["most"])
            guess = float(bounds.get("guess", (least + most) / 2))
            try:
                found.append(FreeTime(name, least, most, guess))
            except ParameterError as error:
                raise self.wrong("[free_times]", str(error)) from error
        return tuple(found)

    def guessed(
        self, document: Mapping[str, Any], free: Sequence[FreeTime], parameters: Sequence[str]
    ) -> tuple[dict[str, Any], tuple[TimeUse, ...]]:
        """Return a document with guesses in place of its free times, and where they are used."""
        guesses, uses = {t.name: t.guess for t in free}, []
        out = dict(document)
        for key, field_name, times in (
            ("parameters", "parameters", parameters),
            ("stance", "stances", _TIMES),
            ("support", "supports", _SUPPORT_TIMES),
            ("term", "added", _TERM_TIMES),
        ):
            given = document.get(key, {} if key == "parameters" else [])
            entries = [dict(x) for x in ([given] if key == "parameters" else given)]
            for i, entry in enumerate(entries):
                for name in times:
                    word = entry.get(name)
                    if isinstance(word, str):
                        use = self._use(TimeUse(field_name, i, name, word), guesses)
                        uses.append(use)
                        entry[name] = guesses[use.name] + use.later
            if key in document:
                out[key] = entries[0] if key == "parameters" else entries
        unused = [t.name for t in free if t.name not in {use.name for use in uses}]
        if unused:
            raise self.wrong(f"[free_times] {unused[0]}", "is used nowhere", f'write "{unused[0]}" '
                             "in place of a time")  # fmt: skip
        return out, tuple(uses)

    def _use(self, use: TimeUse, guesses: Mapping[str, float]) -> TimeUse:
        """Return the use of a free time, of which ``name`` is still the expression."""
        found = _EXPRESSION.fullmatch(use.name)
        name = found[1] if found else use.name
        if found is None or name not in guesses:
            remedy = f"free times are {', '.join(guesses)}" if guesses else "a number is needed"
            raise self.wrong(use.key, f"is {shown(use.name)}", remedy)
        return replace(use, name=name, later=float((found[2] or "+") + (found[3] or "0")))

    def impairments(self, given: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
        """Return the options that ``[impairments]`` gives."""
        self.known("[impairments]", given, [f.name for f in fields(Impairments)])
        for key, words in given.items():
            if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
                remedy = f'write {key} = ["knee_r=0:20"], with the words of --{key}'
                raise self.wrong(f"[impairments] {key}", f"is {shown(words)}", remedy)
        found = {key: tuple(words) for key, words in given.items()}
        try:
            Impairments(**found)
        except ParameterError as error:
            raise self.wrong("[impairments]", str(error)) from error
        return found

    def term(self, i: int, entry: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
        """Return kind and arguments of a term."""
        where, kind = f"[[term]] {i}", entry.get("type")
        if not isinstance(kind, str) or kind not in TERMS:
            raise self.no_term(where, f"type is {shown(kind)}", [kind])
        where = f"{where} ({kind})"
        given = in_radians({k: v for k, v in entry.items() if k != "type"})
        own = fields(TERMS[kind])  # type: ignore[arg-type]
        self.known(where, given, [f.name for f in own])
        hints = get_type_hints(TERMS[kind])
        for f in own:
            if f.name in given:
                try:
                    given[f.name] = as_field(hints[f.name], given[f.name])
                except ParameterError as error:
                    raise self.wrong(f"{where} {f.name}", str(error)) from error
            elif f.default is MISSING and f.default_factory is MISSING:
                raise self.wrong(where, f"{f.name} is missing")
        if given.get("start", -np.inf) > given.get("stop", np.inf):
            raise self.wrong(where, "stops before it starts", "give a later stop")
        return kind, given

    def stance(self, i: int, entry: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries of a stance, checked."""
        where, given = f"[[stance]] {i}", in_radians(entry)
        self.known(where, given, _STANCE)
        if given.get("side") not in SIDES:
            raise self.wrong(f"{where} side", f"is {shown(given.get('side'))}", 'write "r" or "l"')
        for key, value in given.items():
            if key != "side" and not is_number(value):
                raise self.wrong(f"{where} {key}", f"is {shown(value)}", "a number is needed")
        return given

    def motion(self, where: str, rows: Any) -> SurfaceMotion:
        """Return the motion of a surface, checked."""
        listed = isinstance(rows, list) and all(isinstance(row, list) for row in rows)
        if not listed or not all(is_number(x) for row in rows for x in row):
            raise self.wrong(f"{where} motion", f"is {shown(rows)}", f"write {MOTION_EXAMPLE}")
        try:
            return SurfaceMotion(tuple(tuple(map(float, row)) for row in rows))
        except ParameterError as error:
            raise self.wrong(f"{where} motion", str(error)) from error

    def support(self, i: int, entry: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries of a support, checked."""
        where = f"[[support]] {i}"
        self.known(where, entry, _SUPPORT)
        part = entry.get("part")
        if part not in SUPPORTED_PARTS:
            allowed = ", ".join(SUPPORTED_PARTS)
            raise self.wrong(f"{where} part", f"is {shown(part)}", f"allowed are {allowed}")
        if "place" not in entry:
            raise self.wrong(where, "place is missing", "write place = [0.5, -0.2, 1.0]")
        found: dict[str, Any] = {"part": part}
        for key, value in entry.items():
            kind = tuple[float, float, float] if key in ("place", "normal") else float
            if key == "motion":
                found[key] = self.motion(where, value)
            elif key != "part":
                try:
                    found[key] = as_field(kind, value)
                except ParameterError as error:
                    raise self.wrong(f"{where} {key}", str(error)) from error
                if not np.all(np.isfinite(found[key])):
                    raise self.wrong(f"{where} {key}", f"is {shown(value)}", "finite numbers only")
        if not np.linalg.norm(found.get("normal", UP)) > 0:
            raise self.wrong(f"{where} normal", "is zero", "write where the surface faces")
        if not 0 <= found.get("friction", 0.0) <= MAX_FRICTION:
            raise self.wrong(
                f"{where} friction", f"is {shown(entry['friction'])}", f"0 to {MAX_FRICTION:g}"
            )
        if not found.get("start", -1.0) < found.get("stop", np.inf):
            raise self.wrong(where, "stops before it starts", "give a later stop")
        return found
