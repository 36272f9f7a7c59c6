"""An interactive simulation in the browser."""

import sys
import time as clock
import traceback
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event
from typing import Any

from plantigrade.contact.ground import Ground
from plantigrade.errors import PlantigradeError
from plantigrade.live.clock import Clock
from plantigrade.live.session import Choice, Session, SessionWorld, run
from plantigrade.live.slope import Slope
from plantigrade.models import Human
from plantigrade.notes import Info
from plantigrade.pages.live_world import LiveWorld
from plantigrade.record import Run
from plantigrade.threads import on_one_thread
from plantigrade.workflows.live_page import look_on
from plantigrade.workflows.simulate import run_of
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulated_world import surroundings, world_of
from plantigrade.workflows.simulation_start import Start, controller_of, start_of
from plantigrade.workflows.steps import Step, silent
from plantigrade.world import (
    AnyController,
    Controller,
    Disturbance,
    Load,
    Platform,
    controller_from,
)
from plantigrade.world.model_mismatch import ModelMismatch

BY_HAND = Info(
    "A live session: pushes by hand are contact sites of their own (push_…); friction and target "
    "values are the signals live.…"
)


SWITCH_INTERVAL = 1e-3  # [s] switch interval of Python threads while another one waits


class SessionWorlds:
    """Makes the worlds of a session from the settings of a simulation.

    Args:
        begin: The start.
        mismatch: Differences from the plan, the ground included.
        how: The settings.
        acting: Other disturbances.
        own: Controller of one's own; one of the table if absent.
    """

    def __init__(
        self,
        begin: Start,
        mismatch: ModelMismatch,
        how: SimulateSettings,
        acting: Sequence[Disturbance] = (),
        own: AnyController | None = None,
    ):
        self.first, self.mismatch, self.how = begin, mismatch, how
        self.ground = ground = mismatch.ground_of(begin.ground)
        self.acting = tuple(acting)
        self.own = None if own is None else controller_from(own)
        self.begin = begin
        moving = any(isinstance(d, Platform) for d in acting)
        self._level = ground == Ground(friction=ground.friction) and not moving

    @property
    def choice(self) -> Choice:
        """Return the choices that the settings make."""
        word = self.first.controller if self.own is None else self.own.name
        return Choice(word, self.first.human.feet, self.first.human.joints)

    def __call__(
        self, choice: Choice, hand: Disturbance, placement: tuple[float, float, float] | None
    ) -> SessionWorld:
        """Return the world of a choice; see :class:`plantigrade.live.session.WorldFactory`."""
        begin, first = self.first, self.first.human
        if (choice.feet, choice.joints) != (first.feet, first.joints):
            human = another(first, choice.feet, choice.joints)
            begin = replace(begin, human=human, motion=None, record=None, sites=())
        if placement is not None:
            begin = replace(begin, motion=None, record=None, place=placement)
        slope = Slope() if self._level else None
        load = next((d for d in self.acting if isinstance(d, Load)), Load(0.0))
        others = (d for d in self.acting if d is not load)
        acting = (*(() if slope is None else (slope,)), load, *others, hand)

        def controller(name: str) -> Controller:
            own = self.own if name == self.choice.controller else None
            own = own or controller_of(begin, self.ground, self.how, name)
            return self.mismatch.wrapped(own)

        world = world_of(begin, self.mismatch, self.how, acting, controller(choice.controller))
        self.begin = begin
        return SessionWorld(world=world, controller=controller, slope=slope, load=load)


def another(human: Human, feet: str, joints: str) -> Human:
    """Return a person of the same lengths and mass with other feet or joints.

    Raises:
        ParameterError: If the joint set has no such feet.
    """
    names = [name for name in human.dimensions.names() if name != "head"]  # follows from the rest
    lengths = {name: float(getattr(human.dimensions, name)) for name in names}
    return Human.create(human.height, human.mass, human.sex, joints, feet, lengths)


@dataclass(frozen=True, eq=False, kw_only=True)
class Live:
    """A session and what it was made of."""

    session: Session  #: The session
    stage: SessionWorlds  #: Maker of its worlds
    began: float  #: When it began, by the clock of this process [s]

    def run(self) -> Run:
        """Return the run so far.

        Raises:
            ParameterError: If it has no frame.
        """
        session, stage = self.session, self.stage
        record = session.record()
        record = replace(record, notes=(*record.notes, BY_HAND))
        seconds = clock.perf_counter() - self.began
        word = session.choice.controller
        begin, mismatch = stage.begin, stage.mismatch
        moved_by = session.controller
        return run_of(begin, mismatch, stage.how, session.world, record, word, seconds, moved_by)


def prepare(
    source: Any = None,
    settings: SimulateSettings | None = None,
    *,
    controller: str | AnyController | None = None,
    disturbances: Sequence[Disturbance] = (),
    step: Step = silent,
    command: str = "",
    **options: Any,
) -> Live:
    """Return a live session, without a page; the arguments are those of ``simulate``.

    Raises:
        PlantigradeError: As ``simulate`` does.
    """
    if isinstance(controller, str):
        options["controller"] = controller
    how = SimulateSettings.given("simulate", settings, options)
    mismatch, acting = surroundings(how)
    named = controller is None or isinstance(controller, str)
    own = None if named else controller_from(controller)
    begin = start_of(source, how, step, command, own)
    stage = SessionWorlds(begin, mismatch, how, (*acting, *disturbances), own)
    session = Session(stage, stage.choice, until=how.duration)
    return Live(session=session, stage=stage, began=clock.perf_counter())


def live(
    source: str | Path | Run | None = None,
    settings: SimulateSettings | None = None,
    *,
    port: int = 8080,
    open: bool = True,  # noqa: A002 - the word of the command line's option
    show: Callable[[str], object] = webbrowser.open,
    tell: Callable[[str], None] = print,
    save: Callable[[Run], Run] | None = None,
    stop: Event | None = None,
    **options: Any,
) -> Run:
    """Simulate in the browser until interrupted, and return the run.

    The physics has a thread of its own, so that drawing does not hold it up.

    Args:
        source: As of ``simulate``.
        settings: As of ``simulate``; a ``duration`` is when it pauses.
        port: Port to listen on; the next free one is taken where it is in use.
        open: Whether to open the page.
        show: Opens the page at an address; in the default browser by default.
        tell: Called with the address, and with how well real time was kept.
        save: Saves a run; called by its button, which is shown if this is given.
        stop: Ends the session when set (for tests and notebooks).
        options: Further arguments of ``simulate``.

    Returns:
        The run. If a fault ended the session after its start, the status says so.

    Raises:
        PlantigradeError: As ``simulate`` does.
        Exception: What a controller raises at once.
    """
    made = prepare(source, settings, **options)
    session, keeps, stop = made.session, Clock(), stop or Event()
    page = LiveWorld(session, keeps, port=port, title="plantigrade", can_save=save is not None)
    failed: list[BaseException] = []

    with responsive():
        try:
            look_on(
                page,
                lambda: on_one_thread(run)(session, stop, keeps),
                "physics",
                stop,
                failed,
                tell=tell,
                show=show if open else None,
                save=lambda: _save(made, save, stop),
            )
        except Exception as error:  # of the page; what was simulated is not lost by it
            failed.append(error)
    tell(f"{session.world.time:.2f} s simulated, {keeps.time_lost:.2f} s behind real time")
    return _after_fault(made, failed[0], tell) if failed else made.run()


def _after_fault(made: Live, fault: BaseException, tell: Callable[[str], None]) -> Run:
    """Return what was simulated before a fault, which its status names.

    Raises:
        BaseException: The fault, where nothing was simulated.
    """
    if not made.session.world.time > 0.0:
        raise fault
    tell("".join(traceback.format_exception(fault)))
    try:
        result = made.run()
    except Exception:
        raise fault from None
    ended = f"the session ended with a fault ({type(fault).__name__}: {fault})"
    return replace(result, status=ended)


@contextmanager
def responsive() -> Iterator[None]:
    """Let the threads of Python take turns more often: the physics asks for many short ones."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


def _save(made: Live, save: Callable[[Run], Run] | None, stop: Event) -> None:
    """Save the run so far; the session pauses meanwhile."""
    session, taken = made.session, Event()
    got: list[Run] = []
    paused = True

    def take() -> None:
        nonlocal paused
        paused, session.paused = session.paused, True
        try:
            got.append(made.run())
        finally:
            taken.set()

    session.submit(take)  # which says what is wrong
    while not taken.wait(0.2):
        if stop.is_set():
            return
    if save is not None and got:
        try:
            session.message = f"Saved: {save(got[0]).folder}"
        except PlantigradeError as error:
            session.message = str(error)
    session.submit(lambda: setattr(session, "paused", paused))
