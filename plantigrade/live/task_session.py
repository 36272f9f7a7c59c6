"""A task whose parameters a user changes while its motion is solved again in the background.

The thread that owns a session calls :meth:`TaskSession.advance`; other threads change values and
read :attr:`TaskSession.shown`, the last motion that passed its check, which is replaced as a whole.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from threading import Event
from typing import Any, Protocol, runtime_checkable

from plantigrade.errors import ParameterError, PlantigradeError, known_names
from plantigrade.live.task_controls import Control, Value
from plantigrade.record import Record, Run

SETTLING_TIME = 0.15  # [s] without another change before solving begins; a slider sends many
MAX_OUTDATED_TIME = 3.0  # [s] after which a solution for values that have changed is given up
POLL_INTERVAL = 0.05  # [s] between two looks at the values

Progress = Callable[[str, Any], bool]
"""Called with the stage and the iteration of a solver; returning True would stop it."""


@runtime_checkable
class Solve(Protocol):
    """Function that solves a task."""

    def __call__(self, values: Mapping[str, Value], warm: Record | None, progress: Progress) -> Run:
        """Return the run of a task, checked.

        Args:
            warm: A similar motion to start from; none at first.
            progress: Called with every iteration; may raise.

        Raises:
            PlantigradeError: If the values make no task.
        """
        ...


@dataclass(frozen=True, eq=False)
class Solved:
    """A motion, and the values it was solved for."""

    values: Mapping[str, Value]  #: Values of all controls
    run: Run  #: Its run, with the verdict of the check
    seconds: float  #: Time it took [s]


class Outdated(Exception):
    """Raised in a solver whose task has changed, or whose session has ended."""


class TaskSession:
    """A task that a user changes while it is solved.

    Args:
        solve: Function that solves it.
        now: Function that returns real time [s].

    Attributes:
        controls: Controls by name.
        shown: Last motion that passed the check; at first one that did not, if there is no other.
        kept: Motions that the user keeps.
        compared: The kept motion that is drawn with the shown one; None without one.
        message: What is wrong with the present values; empty if nothing is.
        changed: Event that is set with every change; the display clears it.
        ended: Event that ends the session, and what is being solved.
    """

    def __init__(
        self, controls: Sequence[Control], solve: Solve, now: Callable[[], float] = time.monotonic
    ):
        self.controls = {control.name: control for control in controls}
        self.shown: Solved | None = None
        self.kept: tuple[Solved, ...] = ()
        self.compared: Solved | None = None
        self.message = ""
        self.changed, self.ended = Event(), Event()
        self._values: Mapping[str, Value] = {c.name: c.value for c in controls}
        self._solve, self._now = solve, now
        self._changed_at, self._done = now() - SETTLING_TIME, dict[str, Value]()
        self._stage = ""

    @property
    def values(self) -> Mapping[str, Value]:
        """Present values of all controls."""
        return self._values

    @property
    def busy(self) -> str:
        """What is being solved, in words; empty while nothing is."""
        return self._stage

    def set(self, name: str, value: Value) -> None:
        """Change a value; the motion follows.

        Raises:
            ParameterError: If there is no such control, or it does not allow the value.
        """
        if name not in self.controls:
            raise ParameterError(f"no control {name!r}; {known_names(name, list(self.controls))}")
        control = self.controls[name]
        if not control.allows(value):
            raise ParameterError(f"{control.label} cannot be {value!r}")
        self._assign({**self._values, name: value})

    def reset(self) -> None:
        """Return to the values of the start."""
        self._assign({name: control.value for name, control in self.controls.items()})

    def keep(self) -> None:
        """Keep the motion that is shown."""
        if self.shown is not None and self.shown not in self.kept:
            self.kept = (*self.kept, self.shown)
            self.changed.set()

    def compare(self, number: int | None) -> None:
        """Draw a kept motion with the shown one; None for none.

        Raises:
            ParameterError: If there is no such motion.
        """
        if number is not None and not 0 <= number < len(self.kept):
            raise ParameterError(f"there is no kept motion {number}")
        self.compared = None if number is None else self.kept[number]
        self.changed.set()

    def restore(self, number: int) -> None:
        """Return to the values of a kept motion.

        Raises:
            ParameterError: If there is no such motion.
        """
        if not 0 <= number < len(self.kept):
            raise ParameterError(f"there is no kept motion {number}")
        self.shown = self.kept[number]
        self._done = dict(self.shown.values)
        self._assign(self.shown.values)
        self.message = ""

    def advance(self) -> bool:
        """Solve the task if its values have changed and rest; return whether it did."""
        values = self._values
        if values == self._done or self._now() - self._changed_at < SETTLING_TIME:
            return False
        self._begin("starting")
        began, warm = self._now(), None if self.shown is None else self.shown.run.record

        def progress(stage: str, iterate: Any) -> bool:
            self._begin(f"{stage}, iteration {iterate.number}")
            late = self._now() - began > MAX_OUTDATED_TIME
            if self.ended.is_set() or (self._values != values and late):
                raise Outdated
            return False

        try:
            run = self._solve(values, warm, progress)
        except Outdated:
            return True
        except PlantigradeError as error:
            self.message = str(error)
        else:
            solved = Solved(values, run, self._now() - began)
            self.message = "" if run.status == "ok" else run.status
            if run.status == "ok" or self.shown is None:
                self.shown = solved
        finally:
            self._begin("")
        self._done = dict(values)
        self.changed.set()
        return True

    def _assign(self, values: Mapping[str, Value]) -> None:
        self._values, self._changed_at = values, self._now()
        self.changed.set()

    def _begin(self, stage: str) -> None:
        self._stage = stage
        self.changed.set()


def run(session: TaskSession) -> None:
    """Solve a task whenever it changes, until the session ends."""
    while not session.ended.is_set():
        if not session.advance():
            session.ended.wait(POLL_INTERVAL)


def with_reference(solved: Solved, other: Solved | None) -> Record:
    """Return the record of a motion, with another one as its reference."""
    if other is None or other is solved:
        return solved.run.record
    return replace(solved.run.record, references={"kept motion": other.run.record.motion})
