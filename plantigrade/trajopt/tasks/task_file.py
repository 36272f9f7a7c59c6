"""Tasks as files: a task of one's own in a few lines of TOML, no code.

A file names a task to start from, sets its parameters, and adds or takes away terms::

    [task]
    name = "deep squat, head still"
    base = "squat"
    without = ["acceleration"]

    [parameters]
    depth = 0.4

    [impairments]
    limit = ["knee_r=0:20"]

    [[term]]
    type = "acceleration"
    weight = 0.01

    [[term]]
    type = "upright"
    body = "head"
    turning = 0.2

A time may be free, within bounds; the one that costs least is then searched. It is named once, and
its name stands wherever a time follows from it::

    [free_times]
    up = { least = 0.8, most = 2.5, guess = 1.5 }

    [parameters]
    duration = "up + 0.5"

The base ``"standing"``, a person on both feet, is the one to build on with stances and postures of
one's own. All numbers are in SI units; a key ending in ``_deg`` is in degrees.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from plantigrade.bounds import shown
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import LYING_PITCHES, SUPPORTED_PARTS, limb_site
from plantigrade.contact.plan import SAME_HEIGHT, UP, Footprint, PointSupport, Stance
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import FileError, ParameterError, did_you_mean, known_names
from plantigrade.models import Human
from plantigrade.toml import parse_toml, read_toml
from plantigrade.trajopt.guess.postures import standing_feet
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.tasks.registry import make_task
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.supported import on_moving_ground, with_supports
from plantigrade.trajopt.tasks.task import BASES, MotionTask
from plantigrade.trajopt.tasks.toml_values import as_field, in_radians, is_number, table
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
    *(effort.Torque, effort.Work, effort.Power, effort.Acceleration, effort.Jerk),
    *(posture.Pose, posture.Rest, posture.Quiet, posture.Posture),
    *(posture.Upright, posture.Facing, posture.Symmetry, targets.Reach, targets.CentreOfMass),
    *(momentum.AngularMomentum, solid.SolidLimbs, effort.Endurance),
)
TERMS = {re.sub(r"\B([A-Z])", r"-\1", kind.__name__).lower(): kind for kind in _KINDS}
"""Name of a term in a file → its class, whose fields are the keys."""

RENAMED = {"head-stability": "upright"}  #: Former name of a term → today's
STANDING = "standing"
FOR_EVER = 1e3  # [s] later than the end of any task
MAX_FRICTION = 2.0  # [1] maximum coefficient of friction of a support; rubber on dry stone has 1
_TASK = ("name", "base", "without", "gravity", "nodes_per_second", "basis")
_TIMES = ("heel_strike", "foot_flat", "heel_off", "forefoot_off", "toe_off")
_STANCE = ("side", "x", "y", "height", "heading", *_TIMES)
_SUPPORT_TIMES = ("start", "stop")
_SUPPORT = ("part", "place", "normal", "friction", *_SUPPORT_TIMES, "motion")
_FREE = ("least", "most", "guess")
_TERM_TIMES = ("time", "start", "stop")
_EXPRESSION = re.compile(r"\s*([A-Za-z]\w*)\s*(?:([+-])\s*(\d+(?:\.\d*)?|\.\d+)\s*)?")
"""A free time, and what is added to it or taken from it [s]."""
_TOP = (
    "task", "free_times", "parameters", "impairments", "ground", "term", "stance", "support",
)  # fmt: skip
_MOTION = "motion = [[0.5, 0.0, 0.0, 0.0], [2.0, 0.0, 0.2, 0.0]], rows of time and displacement"


@dataclass(frozen=True)
class TimeUse:
    """A time in a file that follows from a free one."""

    table: str  #: Field of the file: parameters, stances, supports or added
    entry: int  #: Which of the entries of that field; 0 of the parameters
    key: str  #: Which of its keys
    name: str  #: Name of the free time
    later: float = 0.0  #: What is added to it [s]

    @property
    def text(self) -> str:
        """The time as the file has it."""
        if not self.later:
            return self.name
        return f"{self.name} {'-' if self.later < 0 else '+'} {abs(self.later):g}"


@dataclass(frozen=True)
class TaskFile:
    """Content of a task file."""

    name: str  #: Name of the task
    base: str = STANDING  #: A task of :data:`~plantigrade.trajopt.tasks.settings.TASKS`
    parameters: Mapping[str, Any] = field(default_factory=dict)  #: Parameters of the base
    #: Options of the person's impairments, as words
    impairments: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    without: tuple[str, ...] = ()  #: Names of terms of the base that are left out
    #: Names and arguments of terms that are added
    added: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    stances: tuple[Mapping[str, Any], ...] = ()  #: Stances as written; the base's if empty
    supports: tuple[Mapping[str, Any], ...] = ()  #: Supports as written, added to the base's
    ground: SurfaceMotion | None = None  #: How the ground moves; at rest if None
    gravity: float | None = None  #: Relative to the earth's; the earth's if None
    nodes_per_second: float | None = None  #: The base's if None
    basis: str | None = None  #: ``"trigonometric"`` or ``"polynomial"``; the base's if None
    free_times: tuple[FreeTime, ...] = ()  #: Times that are searched; entries have their guesses
    uses: tuple[TimeUse, ...] = ()  #: Where the free times are used

    def task(self, human: Human) -> MotionTask:
        """Return the task of a person.

        Raises:
            ParameterError: If a value is out of range for that person.
        """
        task = make_task(self.base, human, self.parameters)
        left_out = tuple(TERMS[n] for n in self.without)
        kept = tuple(t for t in task.terms if not isinstance(t, left_out))
        more = tuple(TERMS[n](**dict(arguments)) for n, arguments in self.added)
        if self.stances:
            ordered = sorted((_stance(human, s) for s in self.stances), key=lambda s: s.heel_strike)
            task = replace(task, plan=replace(task.plan, stances=tuple(ordered)))
        task = replace(task, name=self.name, terms=(*kept, *more), **self._mesh())
        task = with_supports(task, tuple(_support(human, s) for s in self.supports))
        return task if self.ground is None else on_moving_ground(task, self.ground, human.gravity)

    @property
    def free_parameters(self) -> frozenset[str]:
        """Names of the parameters that follow from free times."""
        return frozenset(use.key for use in self.uses if use.table == "parameters")

    def at(self, times: Mapping[str, float]) -> "TaskFile":
        """Return the file with values of its free times, by name, in which none is free [s]."""
        filled = self._filled({use: times[use.name] + use.later for use in self.uses})
        return replace(filled, free_times=(), uses=())

    def _filled(self, values: Mapping[TimeUse, Any]) -> "TaskFile":
        """Return the file with something in place of the uses of its free times."""
        parameters = dict(self.parameters)
        stances, supports = ([dict(x) for x in each] for each in (self.stances, self.supports))
        added = [(name, dict(arguments)) for name, arguments in self.added]
        entries = {"stances": stances, "supports": supports, "parameters": [parameters]}
        entries["added"] = [arguments for _, arguments in added]
        for use, value in values.items():
            entries[use.table][use.entry][use.key] = value
        return replace(
            self,
            parameters=parameters,
            stances=tuple(stances),
            supports=tuple(supports),
            added=tuple(added),
        )

    @property
    def options(self) -> dict[str, Any]:
        """Options of the person and the place, as ``synthesize`` takes them."""
        place = {} if self.gravity is None else {"gravity": self.gravity}
        return {**place, **self.impairments}

    def _mesh(self) -> dict[str, Any]:
        """Return the options of mesh and basis in the file."""
        given = {"nodes_per_second": self.nodes_per_second, "basis": self.basis}
        return {key: value for key, value in given.items() if value is not None}

    def toml(self) -> str:
        """Return the file's text; reading it gives the same."""
        head: dict[str, Any] = {"name": self.name, "base": self.base}
        if self.without:
            head["without"] = list(self.without)
        if self.gravity is not None:
            head["gravity"] = self.gravity
        parts = [table("[task]", head | self._mesh())]
        if self.free_times:
            bounds = {t.name: {k: getattr(t, k) for k in _FREE} for t in self.free_times}
            parts.append(table("[free_times]", bounds))
        written = self._filled({use: use.text for use in self.uses})
        if self.parameters:
            parts.append(table("[parameters]", written.parameters))
        if self.impairments:
            words = {k: list(v) for k, v in self.impairments.items()}
            parts.append(table("[impairments]", words))
        if self.ground is not None:
            parts.append(table("[ground]", {"motion": self.ground.rows}))
        parts += [table("[[stance]]", s) for s in written.stances]
        for support in written.supports:
            moved = {"motion": support["motion"].rows} if "motion" in support else {}
            parts.append(table("[[support]]", {**support, **moved}))
        parts += [table("[[term]]", {"type": n, **a}) for n, a in written.added]
        return "\n".join(parts)


def read_task_file(path: str | Path) -> TaskFile:
    """Return the contents of a task file, every key checked.

    Raises:
        FileError: If it cannot be read, or a key or value is not allowed.
    """
    return parse_task_file(read_toml(path), path)


def parse_task_file(text: str, path: str | Path = "task.toml") -> TaskFile:
    """Return the contents of a task file from its text; ``path`` is named in errors.

    Raises:
        FileError: If a key or value is not allowed.
    """
    document = parse_toml(text, path)
    reader = _Reader(Path(path))
    reader.known("top level", document, _TOP)
    head = document.get("task")
    if not head:
        remedy = 'write [task] with base = "squat" or another task'
        raise reader.wrong("[task]", "is missing", remedy)
    for key in ("task", "free_times", "parameters", "impairments", "ground"):
        if not isinstance(document.get(key, {}), dict):
            raise reader.wrong(key, "must be a table", f"write it as [{key}]")
    for key in ("term", "stance", "support"):
        entries = document.get(key, [])
        if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
            raise reader.wrong(key, "must be tables", f"write each as [[{key}]]")
    header = reader.head(head)
    free = reader.free_times(document.get("free_times", {}))
    document, uses = reader.guessed(document, free, TASKS[header["base"]].times)
    parameters = in_radians(document.get("parameters", {}))
    reader.known("[parameters]", parameters, [f.name for f in fields(TASKS[header["base"]])])
    parameters = {k: tuple(v) if isinstance(v, list) else v for k, v in parameters.items()}
    try:
        TASKS[header["base"]](**parameters)
    except ParameterError as error:
        raise reader.wrong("[parameters]", str(error)) from error
    impairments = reader.impairments(document.get("impairments", {}))
    ground = document.get("ground", {})
    reader.known("[ground]", ground, ("motion",))
    if "ground" in document and not ground:
        raise reader.wrong("[ground]", "motion is missing", f"write {_MOTION}")
    terms, stances, supports = (
        enumerate(document.get(key, []), start=1) for key in ("term", "stance", "support")
    )
    return TaskFile(
        **header,
        parameters=parameters,
        impairments=impairments,
        added=tuple(reader.term(i, entry) for i, entry in terms),
        stances=tuple(reader.stance(i, entry) for i, entry in stances),
        supports=tuple(reader.support(i, entry) for i, entry in supports),
        ground=reader.motion("[ground]", ground["motion"]) if ground else None,
        free_times=free,
        uses=uses,
    )


@dataclass(frozen=True)
class _Reader:
    """Checks tables of a task file; what is wrong is named with its place."""

    path: Path

    def wrong(self, where: str, problem: str, remedy: str = "") -> FileError:
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
            self.known(where, bounds, _FREE)
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
            raise self.wrong(f"{where} motion", f"is {shown(rows)}", f"write {_MOTION}")
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


def _support(human: Human, given: Mapping[str, Any]) -> PointSupport:
    """Return a support, from before the start to after the end where no times are given."""
    normal = np.array(given.get("normal", UP))
    start, stop = given.get("start", -1.0), given.get("stop", FOR_EVER)
    if not start < stop:
        raise ParameterError(
            f"the support of {given['part']} would stop at {stop:g} s, before it starts at "
            f"{start:g} s"
        )
    x, y, z = map(float, normal / np.linalg.norm(normal))
    level = (x, y, z) == UP and abs(given["place"][2]) < SAME_HEIGHT
    on_ground = level and "motion" not in given
    site = limb_site(human, given["part"], on_ground=on_ground)
    return PointSupport(
        site,
        given["place"],
        start,
        stop,
        (x, y, z),
        given.get("friction"),
        LYING_PITCHES.get(site.part, 0.0),
        given.get("motion"),
    )


def _stance(human: Human, given: Mapping[str, Any]) -> Stance:
    """Return a stance; what is not given is as in standing, from before the start to the end."""
    foot = standing_feet(human)[given["side"]]
    x, y, z = foot.position
    place = (float(given.get("x", x)), float(given.get("y", y)), float(given.get("height", z)))
    strike, off = float(given.get("heel_strike", -1.0)), float(given.get("toe_off", FOR_EVER))
    forefoot = float(given.get("forefoot_off", off))
    heel, flat = float(given.get("heel_off", forefoot)), float(given.get("foot_flat", strike))
    footprint = Footprint(foot.side, place, float(given.get("heading", 0.0)))
    return Stance(footprint, strike, flat, heel, forefoot, off)
