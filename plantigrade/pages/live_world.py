"""The page of a live session, drawn by the browser with the scripts of ``viewer.html``.

The session runs in a thread of its own (:func:`plantigrade.live.session.run`). This page sends its
last frame, up to sixty times a second, as one message: body, forces and centre of mass are drawn
together. Status, controls and curves follow more slowly.
"""

import json
from collections.abc import Mapping, Sequence
from threading import Event
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float, spread
from plantigrade.charts import theme
from plantigrade.charts.labels import MIN_SPANS, title_of
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.control import CONTROLLERS
from plantigrade.live.clock import Clock
from plantigrade.live.frame import HISTORY_DURATION, LiveFrame
from plantigrade.live.session import SPEEDS, Session
from plantigrade.models.feet import FEET
from plantigrade.models.joint_sets import JOINT_SETS
from plantigrade.pages.contact_plate import SoleOutline, plate_svg
from plantigrade.pages.live_commands import FIRST_JOINT, Commands
from plantigrade.pages.live_scene import frame_data, weight_of, world_data
from plantigrade.pages.page_server import PageServer, ServedPage
from plantigrade.pages.viewer import SHARED_SCRIPTS, stage_html
from plantigrade.side_names import side_of
from plantigrade.world import Target, World

MAX_POINTS = 125  # of a curve: one for two pixels of its width
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


def status_lines(session: Session, clock: Clock, frame: LiveFrame) -> list[str]:
    """Return the lines above the person."""
    speed = "paused" if session.paused else f"{session.speed:g}×"
    reached = "real time" if session.speed == 1.0 else "that speed"
    behind = f", {clock.time_lost:.2f} s behind" if clock.time_lost >= 0.005 else ""
    lines = [
        f"{frame.time:.2f} s, {speed}, {100 * clock.real_time_factor:.0f} % of {reached}{behind}"
    ]
    return lines + [word for word in (frame.end_message, session.message) if word]


def control_values(session: Session) -> dict[str, Any]:
    """Return the values of all controls, under the names of the commands that set them."""
    slope = session.desired_slope
    ahead, left = (0.0, 0.0) if slope is None else np.rad2deg(slope).tolist()
    return {
        "pause": session.paused,
        "speed": session.speed,
        "force": session.hand.max_force,
        "slope": ahead,
        "cross_slope": left,
        "friction": session.friction,
        "load": session.load,
        "controller": session.choice.controller,
        "feet": session.choice.feet,
        "joints": session.choice.joints,
        "targets": [target_value(target) for target in session.targets],
    }


def target_value(target: Target) -> dict[str, Any]:
    """Return a target of a controller as a control."""
    return {
        "name": target.name,
        "unit": target.unit,
        "low": target.low,
        "high": target.high,
        "value": target.value,
        "names": list(target.names),
    }


def soles_of(session: Session) -> list[SoleOutline]:
    """Return both soles of the person."""
    return [SoleOutline.of(session.world.human, session.world.sites, side) for side in SIDES]


def curves_data(frame: LiveFrame, soles: Sequence[SoleOutline], joint: str) -> dict[str, Any]:
    """Return the contact plate and curves of the last seconds.

    Args:
        frame: The state, with its recent history.
        joint: Joint whose angle and torque are shown, with that of the other side.
    """
    world, past, weight = frame.world, frame.history, weight_of(frame.world)
    names = world.human.coordinates
    pair = [n for side in SIDES if (n := f"{joint[:-2]}_{side}") in names and side_of(joint)]
    own = [world.human.hinge(name) for name in pair or [joint]]
    feet = {SIDE_NAMES[s]: theme.SIDE_COLOURS[s] for s in SIDES}
    joints = {SIDE_NAMES[n[-1]]: theme.SIDE_COLOURS[n[-1]] for n in pair} or {"": theme.MIDDLE}
    rows = spread(len(past.time), MAX_POINTS)
    title = title_of(joint)

    def chart(title: str, unit: str, lines: dict[str, str], values: Float[Array, "n k"]) -> Any:
        return {
            "title": title,
            "unit": unit,
            "span": MIN_SPANS.get(unit, 1.0),
            "lines": [
                {"label": label, "colour": colour, "values": _plain(values[rows, k])}
                for k, (label, colour) in enumerate(lines.items())
            ],
        }

    ways = {"forward": theme.RECORDED, "left": theme.FORCE}
    return {
        "plate": plate_svg(soles, frame.force[:, 2] / weight),
        "seconds": HISTORY_DURATION,
        "time": _plain(past.time[rows] - past.time[-1]),
        "charts": [
            chart(title, "°", joints, np.rad2deg(past.angles[:, own])),
            chart(f"{title}, torque", "N m", joints, past.torques[:, own]),
            chart(title_of("ground_force_up"), "BW", feet, past.vertical / weight),
            chart("Centre of pressure", "cm", ways, 100.0 * past.cop),
        ],
    }


def _plain(values: Array) -> list[float | None]:
    """Return numbers for JSON, rounded so that noise at rest does not scale an axis."""
    return [None if np.isnan(value) else round(float(value), 3) for value in values]
