"""The page of a task that is solved again whenever somebody changes it.

It is the page of a motion (:mod:`plantigrade.pages.viewer`) with controls and handles; another
motion is sent to it as a whole.
"""

import json
from collections.abc import Mapping, Sequence
from threading import Event
from typing import Any

from plantigrade.charts import theme
from plantigrade.errors import ParameterError
from plantigrade.live.task_controls import STRENGTH, Control, Value
from plantigrade.live.task_session import Solved, TaskSession, with_reference
from plantigrade.pages.live_commands import Command, a_name, carry_out, whole
from plantigrade.pages.page_server import PageServer, ServedPage
from plantigrade.pages.scene import build_scene
from plantigrade.pages.shown import shown_in
from plantigrade.pages.task_handles import handles_of
from plantigrade.pages.viewer import COLOURS, SCRIPTS, motion_data, stage_html
from plantigrade.pages.viewer_skin import foot_data, skin_data

POLL_INTERVAL = 0.05  # [s] between two checks for the end of the session


class LiveTask(ServedPage):
    """A task on a page.

    Attributes:
        session: The task.
        data: Data of the page that change with the motion.
    """

    def __init__(
        self,
        session: TaskSession,
        *,
        task: str,
        port: int = 8080,
        title: str = "plantigrade",
        can_save: bool = False,
    ):
        """Start the server with the first motion.

        Args:
            session: The task, solved once.
            port: Port to listen on; the next free one is taken where it is in use.
            can_save: Whether there is a save button.

        Raises:
            ParameterError: If the port is no port, or nothing has been solved yet.
        """
        if session.shown is None:
            raise ParameterError("a page needs a motion: solve the task before")
        self.session, self._task, self._title = session, task, title
        self.save_requested, self._can_save = Event(), can_save
        self._note = ""
        self._drawn: tuple[Solved | None, Solved | None] = (None, None)
        self.data: dict[str, Any] = {}
        self._update()
        self.server = PageServer(port, self._html, self.receive)

    def show(self, stop: Event) -> None:
        """Send what changes until ``stop`` is set, or saving is requested."""
        while not (stop.is_set() or self.save_requested.is_set()):
            if self.session.changed.wait(POLL_INTERVAL):
                self.session.changed.clear()
                self.send()

    def say(self, note: str) -> None:
        """Show a sentence, until the next change of a control."""
        self._note = note
        self.session.changed.set()

    def send(self) -> None:
        """Send the motion if it is another one, and the state of the controls."""
        if self._update():
            message = {"kind": "motion", "data": self.data}
            self.server.send(json.dumps(message, separators=(",", ":")))
        self.server.send(json.dumps({"kind": "panel", **self.panel()}))

    def _update(self) -> bool:
        """Make the data of another motion; return whether there is one."""
        session = self.session
        drawn = session.shown, session.compared
        if drawn == self._drawn or session.shown is None:
            return False
        self._drawn = drawn
        record = with_reference(session.shown, session.compared)
        scene = build_scene(record)
        handles = handles_of(self._task, record, scene, session.shown.values)
        plain = [handle.plain() for handle in handles]
        self.data = motion_data(record, scene) | {"handles": plain}
        return True

    def _html(self) -> str:
        """Return the page with the motion that is shown."""
        solved = self._drawn[0]
        if solved is None:
            return ""
        record = solved.run.record
        skin, foot = skin_data(record.human), foot_data(record.human)
        colours = COLOURS | {"handle": theme.RECORDED}
        data = self.data | {"skin": skin, "foot": foot, "colours": colours}
        names = ("recorded", "fitted", "estimated", "plate", "pushes")
        controls = tuple(self.session.controls.values())
        return stage_html(
            "live_task.html",
            data,
            styles=("viewer.css", "live.css"),
            scripts=(*SCRIPTS, "live_socket.js", "live_task.js"),
            title=self._title,
            subtitle="",
            has={name: False for name in names}
            | {"reference": True, "force": True, "cop": True}
            | {"skin": skin is not None, "foot": foot is not None},
            weight=round(record.weight),
            thinned="",
            reference_label="Kept motion",
            controls=[c for c in controls if not c.name.startswith(STRENGTH)],
            strengths=[c for c in controls if c.name.startswith(STRENGTH)],
            can_save=self._can_save,
        )

    def receive(self, text: str) -> None:
        """Carry out a message of a browser, or refuse it and say so."""
        self._note = ""
        if complaint := carry_out(text, self._table()):
            self.say(complaint)

    def _table(self) -> dict[str, Command]:
        session = self.session
        n = len(session.kept)
        kept = {"value": lambda value: whole(value) and 0 <= value < n}
        shown = {"value": lambda value: whole(value) and -1 <= value < n}
        table = {
            "join": Command(session.changed.set, {}),
            "set": Command(self._set, {"name": a_name, "value": lambda value: True}),
            "reset": Command(session.reset, {}),
            "keep": Command(session.keep, {}),
            "compare": Command(lambda value: session.compare(None if value < 0 else value), shown),
            "restore": Command(lambda value: session.restore(value), kept),
        }
        if self._can_save:
            table["save"] = Command(self.save_requested.set, {})
        return table

    def _set(self, name: str, value: Any) -> None:
        try:
            self.session.set(name, tuple(value) if isinstance(value, list) else value)
        except ParameterError as error:
            self.say(str(error))

    def panel(self) -> dict[str, Any]:
        """Return status, values, figures and kept motions, for the script of the page."""
        session, (solved, compared) = self.session, self._drawn
        limits = () if solved is None else solved.run.metrics.get("binding_limits", ())
        return {
            "busy": session.busy,
            "problem": session.message,
            "note": self._note,
            "sentence": "" if solved is None else sentence(solved),
            "limits": list(limits),
            "values": dict(session.values),
            "figures": figures(solved, compared),
            "kept": [described(k, session.controls) for k in session.kept],
            "compared": -1 if compared is None else session.kept.index(compared),
        }


def sentence(solved: Solved) -> str:
    """Return the verdict of a motion in words."""
    run = solved.run
    passed = "passed its check" if run.status == "ok" else f"failed its check: {run.status}"
    return f"This motion {passed}; it took {solved.seconds:.1f} s."


def figures(solved: Solved | None, compared: Solved | None) -> list[list[str]]:
    """Return rows of name, value, and value of the kept motion where one is compared."""
    if solved is None:
        return []
    shown = [each.run.metrics for each in (solved, compared) if each is not None]
    rows = [] if compared is None else [["", "this", "kept"]]
    for one in shown_in("live task"):
        values = [metrics.get(one.key) for metrics in shown]
        if values[0] is not None:
            words = ["–" if v is None else f"{v:.{one.digits}f}" for v in values]
            rows.append([f"{one.label} [{one.unit}]" if one.unit else one.label, *words])
    return rows


def described(solved: Solved, controls: Mapping[str, Control]) -> str:
    """Return a kept motion in words: values other than those of the start."""
    changed = [
        f"{controls[name].label} {_in_words(value, controls[name].unit)}"
        for name, value in solved.values.items()
        if value != controls[name].value
    ]
    return ", ".join(changed) or "as at the start"


def _in_words(value: Value, unit: str) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, int | float):
        return f"{value:.3g}{'' if unit in ('°', '') else ' '}{unit}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(f"{x:.2f}" for x in value)
    return "default" if value is None else value
