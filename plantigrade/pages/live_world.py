"""The page of a live session, drawn by the browser with the scripts of ``viewer.html``.

The session runs in a thread of its own (:func:`plantigrade.live.session.run`). This page sends its
last frame, up to sixty times a second, as one message: body, forces and centre of mass are drawn
together. Status, controls and curves follow more slowly.
"""

import json
from collections.abc import Mapping
from threading import Event
from typing import Any

from plantigrade.charts.labels import title_of
from plantigrade.control import CONTROLLERS
from plantigrade.live.clock import Clock
from plantigrade.live.frame import LiveFrame
from plantigrade.live.session import SPEEDS, Session
from plantigrade.models.feet import FEET
from plantigrade.models.joint_sets import JOINT_SETS
from plantigrade.pages.live_commands import FIRST_JOINT, Commands
from plantigrade.pages.live_panel import control_values, curves_data, soles_of, status_lines
from plantigrade.pages.live_scene import frame_data, world_data
from plantigrade.pages.page_server import PageServer, ServedPage
from plantigrade.pages.viewer import SHARED_SCRIPTS, stage_html
from plantigrade.side_names import side_of
from plantigrade.world import World

PANEL_INTERVAL = 8  # frames between updates of figures and curves
IDLE_WAIT = 0.05  # [s] for a new frame, before other changes are sent
SCRIPTS = (*SHARED_SCRIPTS, "live_socket.js", "live_drag.js", "live_panels.js", "live.js")


class LiveWorld(ServedPage):
    """A session on a page.

    Attributes:
        session: The session.
        commands: What browsers may ask for.
        drawn: Number of frames sent.
    """

    def __init__(
        self,
        session: Session,
        clock: Clock,
        *,
        port: int = 8080,
        title: str = "plantigrade",
        can_save: bool = False,
    ):
        """Start the server with the first frame.

        Args:
            port: Port to listen on; the next free one is taken where it is in use.
            can_save: Whether there is a save button.

        Raises:
            ParameterError: If the port is no port.
        """
        self.session, self._clock, self._title, self._can_save = session, clock, title, can_save
        self.commands = Commands(session, can_save=can_save)
        self.save_requested = self.commands.save_requested
        self.drawn = self._worlds = 0
        self._world: World | None = None
        self._frame: LiveFrame | None = None
        self._page, self._sent = "", dict[str, str]()
        self._begin(session.frame)
        self.server = PageServer(port, lambda: self._page, self._receive)
        self.draw(session.frame)

    def show(self, stop: Event) -> None:
        """Send frames until ``stop`` is set, or saving is requested."""
        turn, news = 0, self.session.frame_ready
        while not (stop.is_set() or self.save_requested.is_set()):
            news.wait(IDLE_WAIT)
            news.clear()
            frame = self.session.frame
            if frame is not self._frame:
                self.draw(frame)
            if turn % PANEL_INTERVAL == 0:
                self.update_controls(frame)
            elif turn % PANEL_INTERVAL == PANEL_INTERVAL // 2:
                self.update_curves(frame)
            turn += 1

    def draw(self, frame: LiveFrame) -> None:
        """Send a frame; where its world is another one, browsers load the page anew."""
        if frame.world is not self._world:
            self._begin(frame)
            self._send("world", {"number": self._worlds})
        self._frame, self.drawn = frame, self.drawn + 1
        self._send("frame", frame_data(frame), droppable=True)

    def update_controls(self, frame: LiveFrame) -> None:
        """Send status and values of the controls, unless actions are still to be done."""
        status: dict[str, Any] = {"lines": status_lines(self.session, self._clock, frame)}
        if not self.session.pending:  # else the controls are ahead of the session
            status["values"] = control_values(self.session)
        self._send("panel", status)

    def update_curves(self, frame: LiveFrame) -> None:
        """Send the contact plate and the curves."""
        if frame.world is self.session.world and len(frame.history.time) > 1:
            self._send("curves", curves_data(frame, self._soles, self.commands.joint))

    def _begin(self, frame: LiveFrame) -> None:
        """Make the page of another world."""
        self._world = frame.world
        self._worlds += 1
        self._soles = soles_of(self.session)
        if self.commands.joint not in frame.world.human.coordinates:
            self.commands.joint = FIRST_JOINT
        self._page = self._html(world_data(frame.world) | {"world": self._worlds})

    def _html(self, data: dict[str, Any]) -> str:
        session = self.session
        coordinates = session.world.human.coordinates
        return stage_html(
            "live.html",
            data,
            styles=("viewer.css", "live.css"),
            scripts=SCRIPTS,
            title=self._title,
            has={name: data[name] is not None for name in ("skin", "foot")},
            weight=round(data["weight"]),
            ranges=self.commands.ranges(),
            values=control_values(session),
            speeds=SPEEDS,
            controllers=list(dict.fromkeys([*CONTROLLERS, session.choice.controller])),
            feet=list(FEET),
            joints=list(JOINT_SETS),
            coordinates={name: title_of(name) for name in coordinates if side_of(name) != "l"},
            joint=self.commands.joint,
            tilts=session.tilts,
            can_save=self._can_save,
        )

    def _receive(self, text: str) -> None:
        self.commands.receive(text)
        if self.commands.joined.is_set():
            self.commands.joined.clear()
            for message in tuple(self._sent.values()):
                self.server.send(message)

    def _send(self, kind: str, data: Mapping[str, Any], *, droppable: bool = False) -> None:
        """Send a message to all browsers, unless it is that of the last time."""
        message = json.dumps({"kind": kind, "world": self._worlds, **data}, separators=(",", ":"))
        if self._sent.get(kind) != message:
            self._sent[kind] = message
            self.server.send(message, droppable=droppable)
