"""A motion from a task alone: solve, and let the checker judge."""

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.synthesize.tasks.task import Task

if TYPE_CHECKING:
    from plantigrade.analyze.check import MotionCheck
    from plantigrade.models import Human
    from plantigrade.motion import GaitEvent
    from plantigrade.record import Record
    from plantigrade.synthesize.diagnose.post_mortem import Broken
    from plantigrade.synthesize.solution import Sampled, Synthesis
    from plantigrade.synthesize.solvers.interior_point import Iterate

Progress = Callable[[str, "Iterate"], bool | None]
"""Told the stage and the iteration; returning True stops with the best so far."""

FINENESS = 10  # frames between two nodes
NOISE = 0.05  # of the guesses of further tries, root mean square [rad]
MOST_SAID = 3  # findings of the status; the report has all of them
NOT_DONE = 1e-3  # a row further off than this, in its own unit, is not what was asked for


@dataclass(frozen=True)
class SynthesizeSettings:
    """Everything that decides the result, as written into ``metrics.json``.

    Attributes:
        task: Name of the task.
        parameters: What the task is told (``speed``, ``steps``, …).
        file: Text of a task file that says more than a name; empty for none.
        height: Body height [m]; average if absent.
        mass: Body mass [kg]; average if absent.
        sex: Sex; male if absent.
        joints: Joint set.
        feet: Foot model; the joint set's own if absent.
        formulation: ``"default"`` or ``"paper"``.
        solver: ``"interior-point"`` or ``"ipopt"``.
        basis: ``"trigonometric"`` or ``"polynomial"``; the task's own if absent.
        nodes_per_second: Nodes a second; the task's own if absent.
        seed: Of the noise on the guesses of further tries.
        tries: First guesses; the cheapest motion that succeeds is taken.
        free_timing: Whether a periodic walk chooses its own step length, stance and heel rise.
        warm: Run folder to start from.
        strides: Strides of a periodic walk that are written.
    """

    task: str = "walk"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    file: str = ""
    height: float | None = None
    mass: float | None = None
    sex: str | None = None
    joints: str = "43"
    feet: str | None = None
    formulation: str = "default"
    solver: str = "interior-point"
    basis: str | None = None
    nodes_per_second: float | None = None
    seed: int = 0
    tries: int = 1
    free_timing: bool = False
    warm: Path | None = None
    strides: int = 2

    def __post_init__(self):
        """Refuse what cannot be.

        Raises:
            ParameterError: If a number is out of range or a word unknown.
        """
        for name, allowed in (
            ("formulation", ("default", "paper")),
            ("solver", ("interior-point", "ipopt")),
            ("basis", (None, "trigonometric", "polynomial")),
        ):
            value = getattr(self, name)
            if value not in allowed:
                allowed = [a for a in allowed if a is not None]
                raise ParameterError(f"{name} is {value!r}; allowed are {', '.join(allowed)}")
        for name, most in (("tries", 1000), ("strides", 100)):
            value = getattr(self, name)
            if not (value == int(value) and 1 <= value <= most):
                raise ParameterError(f"{name}={value}: allowed are whole numbers from 1 to {most}")
        if self.nodes_per_second is not None and not 2 <= self.nodes_per_second <= 500:
            raise ParameterError(
                f"nodes_per_second={self.nodes_per_second:g} [1/s]: allowed are 2 to 500"
            )

    def human(self) -> "Human":
        """Return the person."""
        from plantigrade.models import Human

        names = ("height", "mass", "sex", "feet")
        given = {n: getattr(self, n) for n in names if getattr(self, n) is not None}
        return Human.create(joints=self.joints, **given)

    def plain(self) -> dict[str, Any]:
        """Return the settings as ``metrics.json`` holds them."""
        return {k: str(v) if isinstance(v, Path) else v for k, v in asdict(self).items()}


@dataclass(frozen=True, eq=False)
class Synthesized:
    """A motion from a task, sampled and judged.

    Attributes:
        settings: What was asked.
        synthesis: What the solver found.
        sampled: The motion on the fine grid.
        check: The verdict of the checker.
        broken: Rows the motion does not keep at the nodes, worst first.
        prepared: How long the problem took to set up [s].
        tried: Status of every try.
    """

    settings: SynthesizeSettings
    synthesis: "Synthesis"
    sampled: "Sampled"
    check: "MotionCheck"
    broken: "tuple[Broken, ...]"
    prepared: float = 0.0
    tried: tuple[str, ...] = ()

    @property
    def human(self) -> "Human":
        """The person."""
        return self.synthesis.body.human

    @cached_property
    def status(self) -> str:
        """``"ok"``, or what is wrong, where and when.

        The checker decides whether the motion is physical. A physical motion may still not be the
        one that was asked for: a row that is off by more than :data:`NOT_DONE` says so.
        """
        words = [] if self.check.ok else self.check.words()
        if len(words) > MOST_SAID:
            more = len(words) - MOST_SAID
            words = [*words[:MOST_SAID], f"and {more} more finding{'s' if more > 1 else ''}"]
        if not words:
            words = [b.sentence() for b in self.broken if b.relative > NOT_DONE][:MOST_SAID]
            words = [f"not what was asked for: {w}" for w in words]
        return "; ".join(words) or "ok"

    @cached_property
    def events(self) -> "tuple[GaitEvent, ...]":
        """Gait events of a walk, from its plan; none of other motions."""
        from plantigrade.workflows.synthesis_figures import gait_events

        return gait_events(self.synthesis, self.sampled.time[-1])

    @cached_property
    def record(self) -> "Record":
        """What happened, with every figure."""
        return replace(self._record, metrics=self.metrics)

    @cached_property
    def _record(self) -> "Record":
        from plantigrade.motion import Motion
        from plantigrade.record import Record

        s, sites = self.sampled, self.synthesis.body.sites
        motion = Motion(s.time, s.qpos, s.qvel, self.human.joint_names, s.qacc, self.events)
        loaded = np.linalg.norm(s.force, axis=2, keepdims=True) > 0
        return Record(
            motion=motion,
            qfrc_actuator=self.check.tau,
            contact_force=s.force,
            contact_point=np.where(loaded, self.check.contact_point, np.nan),
            contact_side=tuple(site.side for site in sites),
            contact_segment=tuple(site.body.removesuffix(f"_{site.side}") for site in sites),
            warnings=tuple(self.notes),
        )

    @property
    def notes(self) -> list[str]:
        """What the user should know besides the status."""
        from plantigrade.synthesize.diagnose.post_mortem import pressing

        found = []
        if not self.synthesis.success:
            words = {"stopped": "was stopped; this is the best so far"}
            how = words.get(self.synthesis.status, f"ended with “{self.synthesis.status}”")
            found.append(f"the solver {how}.")
            found += [b.sentence() + "." for b in self.broken[:5]]
            pushed = pressing(self.synthesis.problem, self.synthesis.multipliers)
            if pushed and self.synthesis.status != "stopped":
                found.append(f"limits the solver pushed against hardest: {'; '.join(pushed)}.")
        return found

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """Every figure of the run, flat."""
        from plantigrade.workflows.synthesis_figures import figures

        return figures(self)


def synthesize_task(
    settings: SynthesizeSettings,
    progress: Progress | None = None,
    *,
    warm: "Synthesis | None" = None,
) -> Synthesized:
    """Make a motion and have it checked.

    Args:
        settings: Who is to do what, and how it is solved.
        progress: Told every iteration; returning True stops with the best so far.
        warm: A motion to start from; that of ``settings.warm`` if absent.

    Raises:
        ParameterError: If there is no such task, or what it is told makes no sense.
        FileError: If the run to start from cannot be read.
    """
    from plantigrade.synthesize.guess.walk import perturbed
    from plantigrade.synthesize.solve import synthesize
    from plantigrade.synthesize.tasks.registry import body_for

    started = clock.perf_counter()
    if settings.formulation == "paper":
        return _as_the_paper(settings, progress)
    if warm is None and settings.warm is not None:
        from plantigrade.workflows.synthesis_folder import read_synthesis

        warm = read_synthesis(settings.warm)
    human = settings.human()
    task = task_of(human, settings)
    body = body_for(human, task.plan)
    if settings.free_timing:
        return _on_its_own_times(settings, human, body, progress)
    prepared = clock.perf_counter() - started
    best, tried, halted = None, [], False

    def told(stage: str, iterate: "Iterate") -> bool | None:
        nonlocal halted
        if progress is None:
            return None
        name = stage if settings.tries == 1 else f"try {len(tried) + 1}: {stage}"
        halted = bool(progress(name, iterate)) or halted
        return halted

    for k in range(settings.tries):
        c0 = None
        if k:
            problem = task.problem(body)
            start = task.start(body, problem)[0]  # a warm start's mesh may be another
            c0 = perturbed(start, seed=settings.seed + k, size=NOISE, closure=problem.closure)
        made = synthesize(
            body,
            task,
            solver=settings.solver,  # type: ignore[arg-type]
            warm=warm if k == 0 else None,
            progress=told,
            c0=c0,
        )
        tried.append(made.status)
        if best is None or _rank(made) < _rank(best):
            best = made
        if halted:
            break
    assert best is not None
    return judged(settings, best, prepared=prepared, tried=tuple(tried))


def _on_its_own_times(settings, human: "Human", body, progress: Progress | None) -> Synthesized:
    """Return a periodic walk whose times of contact cost least, judged.

    Raises:
        ParameterError: If the task is no periodic walk.
    """
    from plantigrade.synthesize.tasks.free_timing import free_timing
    from plantigrade.synthesize.tasks.gait_parameters import gait_parameters
    from plantigrade.synthesize.tasks.walking import periodic_walk

    told = dict(settings.parameters)
    if settings.task != "walk" or settings.file or not told.pop("periodic", False):
        raise ParameterError(
            "only a periodic walk chooses its own times: plantigrade synthesize walk --periodic "
            "--free-timing"
        )
    slope = told.pop("slope", 0.0)
    start = gait_parameters(human, told.pop("speed", 1.3), **told)

    def task(p):
        made = periodic_walk(human, p, slope=slope)
        named = {"basis": settings.basis, "nodes_per_second": settings.nodes_per_second}
        return replace(made, **{k: v for k, v in named.items() if v is not None})

    found = free_timing(body, task, start, progress=progress)
    tried = tuple(f"{c:.4g} a metre" for c in found.costs)
    return judged(settings, found.synthesis, tried=tried)


def _as_the_paper(settings: SynthesizeSettings, progress: Progress | None) -> Synthesized:
    """Return a motion of the paper, judged.

    Raises:
        ParameterError: If something is asked of it that the paper's problem does not know.
    """
    from plantigrade.workflows.zhakatayev2023 import paper_synthesis

    unknown = {
        "a task file": settings.file,
        "parameters of tasks": settings.parameters,
        "--warm": settings.warm,
        "--nodes-per-second": settings.nodes_per_second,
        "--tries": settings.tries > 1,
        "--free-timing": settings.free_timing,
    }
    for what, asked in unknown.items():
        if asked:
            raise ParameterError(
                f"the paper's formulation knows no {what}: its motions are set by its tables"
            )
    basis = settings.basis or "trigonometric"
    return judged(settings, paper_synthesis(settings.human(), settings.task, basis, progress))


def _rank(made: "Synthesis") -> tuple[float, float]:
    """Return what is smaller for a better motion: first whether it failed, then what it costs."""
    if made.success:
        return 0.0, made.objective
    return 1.0, made.stages[-1].history[-1].violation


def judged(
    settings: SynthesizeSettings,
    synthesis: "Synthesis",
    *,
    prepared: float = 0.0,
    tried: tuple[str, ...] = (),
) -> Synthesized:
    """Return a motion sampled on a grid finer than its nodes, and what the checker says of it."""
    from plantigrade.analyze.check import examine
    from plantigrade.synthesize.diagnose.post_mortem import broken_rows

    periodic = synthesis.task.plan.periodic
    laps = 2 * settings.strides if periodic else 1
    sampled = synthesis.sample(synthesis.times(FINENESS, laps))
    broken = broken_rows(synthesis.problem, synthesis.c, synthesis.u)
    check = examine(under_test(synthesis, sampled))
    return Synthesized(settings, synthesis, sampled, check, broken, prepared, tried)


def under_test(synthesis: "Synthesis", sampled: "Sampled"):
    """Return a sampled motion as the checker takes it: states, forces, plan and limits.

    Of the task only what was asked for goes over: who stands where and when, how rough the ground
    is and how strong the person; nothing of how it was solved.
    """
    from plantigrade.analyze.check import ContactSite, Ground, Limits, MotionUnderTest
    from plantigrade.contact.ground import ground as ground_of
    from plantigrade.synthesize.terms import terms

    body, task = synthesis.body, synthesis.task
    rests = {s.site.name: s.position[2] for s in task.plan.supports}
    sites = tuple(
        ContactSite(
            site.name,
            site.side,
            site.body,
            tuple(float(x) for x in site.position),
            float(site.radius),
            height=rests.get(site.name),
        )
        for site in body.sites
    )
    normal = tuple(float(x) for x in task.plan.to_world[:, 2])
    ground, limits = Ground(normal=normal, height=ground_of(task.plan)), Limits()
    for term in task.terms:
        if isinstance(term, terms.Contact):
            ground = replace(ground, friction=term.friction)
            limits = replace(limits, force=term.force * body.weight)
        elif isinstance(term, terms.Limits):
            torque = body.human.model.jnt_actfrcrange[1:].T * term.strength
            limits = replace(limits, velocity=term.speed, torque=torque)
    return MotionUnderTest(
        body.human.model,
        sampled.time,
        sampled.qpos,
        sampled.qvel,
        sampled.qacc,
        sites,
        sampled.force,
        sampled.standing,
        ground,
        limits,
    )


# Tasks --------------------------------------------------------------------------------------------


def task_of(human: "Human", settings: SynthesizeSettings) -> Task:
    """Return the task that settings name.

    Raises:
        ParameterError: If there is none, or it does not know a parameter.
    """
    from plantigrade.synthesize.tasks.registry import make_task
    from plantigrade.synthesize.tasks.task_file import parse_task_file

    if settings.file:
        told = parse_task_file(settings.file)
        told = replace(told, parameters={**told.parameters, **settings.parameters})
        task = told.task(human)
    else:
        task = make_task(settings.task, human, settings.parameters)
    if settings.basis is not None:
        task = replace(task, basis=settings.basis)
    if settings.nodes_per_second is not None:
        task = replace(task, nodes_per_second=float(settings.nodes_per_second))
    return task
