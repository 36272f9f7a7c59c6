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

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.contact.limb_sites import LYING_PITCHES, limb_site
from plantigrade.contact.plan import SAME_HEIGHT, UP, Footprint, PointSupport, Stance
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.toml import parse_toml, read_toml
from plantigrade.trajopt.guess.postures import standing_feet
from plantigrade.trajopt.tasks.free_time import FreeTime, TimeUse
from plantigrade.trajopt.tasks.registry import make_task
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.supported import on_moving_ground, with_supports
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.task_reader import (
    FREE_TIME_KEYS,
    MOTION_EXAMPLE,
    STANDING,
    TABLES,
    TERMS,
    TaskReader,
)
from plantigrade.trajopt.tasks.toml_values import in_radians, table

FOR_EVER = 1e3  # [s] later than the end of any task


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
            bounds = {t.name: {k: getattr(t, k) for k in FREE_TIME_KEYS} for t in self.free_times}
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
    reader = TaskReader(Path(path))
    reader.known("top level", document, TABLES)
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
        raise reader.wrong("[ground]", "motion is missing", f"write {MOTION_EXAMPLE}")
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
