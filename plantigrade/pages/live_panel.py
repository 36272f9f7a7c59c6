"""The controls of a live session."""

from collections.abc import Callable
from html import escape
from threading import Event
from typing import Any

import numpy as np

from plantigrade.control import CONTROLLERS
from plantigrade.live.clock import Clock
from plantigrade.live.frame import Frame
from plantigrade.live.session import SPEEDS, Choice, Session
from plantigrade.models.feet import FEET
from plantigrade.models.joint_sets import JOINT_SETS
from plantigrade.world import Target

LAYERS = {
    "Ground reaction": "/world/ground_reaction",
    "Centre of pressure": "/world/centre_of_pressure",
    "Centre of mass": "/world/com",
}
LINES = {"Contact forces": "contact_forces", "Support polygon": "support"}


class Panel:
    """Controls and status of a live session.

    Args:
        server: The viser server.
        session: The session.
        clock: Its clock.
        can_save: Whether there is a save button.

    Attributes:
        status: Status above the controls, as HTML.
        targets: Controls of the controller's targets.
        save_requested: Event of the save button.
    """

    def __init__(self, server: Any, session: Session, clock: Clock, *, can_save: bool):
        self.server, self.session, self._clock = server, session, clock
        self.save_requested = Event()
        self.targets: list[Any] = []
        self._of: tuple[Target, ...] | None = None
        self._choice: Choice | None = None
        self.status = ""
        gui = server.gui
        self._line = gui.add_html("")
        self._run_controls(can_save)
        with gui.add_folder("Push"):
            self._force = gui.add_slider("Force [N]", 0.0, 1000.0, 10.0, session.hand.max_force)
            self._way = gui.add_slider("Direction [°]", -180.0, 180.0, 15.0, 0.0)
            self._long = gui.add_slider("Duration [s]", 0.05, 1.0, 0.05, 0.2)
            gui.add_button("Push the trunk").on_click(lambda _: self._push())
            gui.add_markdown("0° is forward, 90° to the left. Or drag a body with the mouse.")
        self._force.on_update(lambda _: self._ask(self._strengthen))
        with gui.add_folder("Ground"):
            level = not session.tilts
            self._slope = gui.add_slider("Slope [°]", -15.0, 15.0, 0.5, 0.0, disabled=level)
            self._cross = gui.add_slider(
                "Slope sideways [°]", -15.0, 15.0, 0.5, 0.0, disabled=level
            )
            friction = session.friction
            least, most = min(0.05, friction), max(1.5, friction)
            self._friction = gui.add_slider("Friction", least, most, 0.05, friction)
        for slider in (self._slope, self._cross):
            slider.on_update(lambda event: event.client is None or self._tilt())
        self._friction.on_update(lambda event: event.client is None or self._rub())
        self._folder = gui.add_folder("Controller")
        with self._folder:
            names = [*CONTROLLERS]
            if session.choice.controller not in names:
                names.append(session.choice.controller)
            self._controller = gui.add_dropdown(
                "Controller", names, initial_value=session.choice.controller
            )
        with gui.add_folder("Person"):
            self._feet = gui.add_dropdown("Feet", [*FEET], initial_value=session.choice.feet)
            self._joints = gui.add_dropdown(
                "Joint set", [*JOINT_SETS], initial_value=session.choice.joints
            )
            gui.add_markdown("Replaces the body by another one, standing at rest.")
            self._load = gui.add_slider(
                "Backpack [kg]", 0.0, max(40.0, session.load), 1.0, session.load
            )
        self._load.on_update(lambda event: event.client is None or self._carry())
        for box in (self._controller, self._feet, self._joints):
            box.on_update(lambda event: event.client is None or self._choose())
        with gui.add_folder("Show"):
            self._follow = gui.add_checkbox("Follow camera", True)
            self._shown = {label: gui.add_checkbox(label, True) for label in (*LAYERS, *LINES)}
        for label, node in LAYERS.items():
            self._shown[label].on_update(lambda _, n=node, la=label: self._show(n, la))

    @property
    def follows(self) -> bool:
        """Whether the camera follows the person."""
        return bool(self._follow.value)

    def shows(self, name: str) -> bool:
        """Return whether lines of a name are drawn."""
        return next((self._shown[label].value for label, own in LINES.items() if own == name), True)

    def begin(self) -> None:
        """Apply the visible layers to another world."""
        for label, node in LAYERS.items():
            self._show(node, label)

    def layer(self, name: str, handle: Any) -> None:
        """Register a new layer."""
        handle.visible = self.shows(name)

    def update(self, frame: Frame) -> None:
        """Update status and controls."""
        session, clock = self.session, self._clock
        speed = "paused" if session.paused else f"{session.speed:g}×"
        reached = "real time" if session.speed == 1.0 else "that speed"
        lines = [
            f"<b>{frame.time:.2f} s</b>, {speed}",
            f"{100 * clock.real_time_factor:.0f} % of {reached}, {clock.time_lost:.2f} s behind",
        ]
        lines += [f"<b>{escape(word)}</b>" for word in (frame.end_message, session.message) if word]
        status = "<br>".join(lines)
        if status != self.status:
            self.status = status
            self._line.content = f'<div style="padding:0 1em;font-size:13px">{status}</div>'
        if session.pending:  # the controls are ahead of pending actions
            return
        self._pause.value = session.paused
        if session.choice != self._choice:
            self._choice = session.choice
            self._controller.value = session.choice.controller
            self._feet.value, self._joints.value = session.choice.feet, session.choice.joints
        if session.targets != self._of:
            self._offer(session.targets)
        self._follow_targets(session.targets)
        ground = [(self._friction, session.friction), (self._load, session.load)]
        if session.desired_slope is not None:
            ground += zip(
                (self._slope, self._cross), np.rad2deg(session.desired_slope), strict=True
            )
        for slider, value in ground:
            if abs(slider.value - value) > 0.52 * slider.step:
                slider.value = float(value)

    def _run_controls(self, can_save: bool) -> None:
        gui, session = self.server.gui, self.session
        self._pause = gui.add_checkbox("Paused", session.paused)
        self._pause.on_update(lambda event: event.client is None or self._hold_on())
        speeds = {f"{speed:g}×": speed for speed in SPEEDS}
        slow = gui.add_dropdown("Speed", [*speeds])

        @slow.on_update
        def _(_: Any) -> None:
            session.speed = speeds[slow.value]

        words = ("One step", "Restart")
        buttons = gui.add_button_group("Time", words)
        acts = dict(zip(words, (session.step, session.restart), strict=True))
        buttons.on_click(lambda _: self._ask(acts[buttons.value]))
        if can_save:
            gui.add_button("Save the run so far").on_click(lambda _: self.save_requested.set())
        for label, key, act in (
            ("Pause or continue", "SPACE", lambda: setattr(session, "paused", not session.paused)),
            ("One step", "N", session.step),
            ("Restart", "R", session.restart),
        ):
            command = gui.add_command(label, hotkey=key)
            command.on_trigger(lambda _, act=act: self._ask(act))
        gui.add_command("Push the trunk", hotkey="P").on_trigger(lambda _: self._push())

    def _ask(self, action: Callable[[], None]) -> None:
        self.session.submit(action)

    def _hold_on(self) -> None:
        paused = bool(self._pause.value)
        self._ask(lambda: setattr(self.session, "paused", paused))

    def _strengthen(self) -> None:
        self.session.hand.max_force = float(self._force.value)

    def _push(self) -> None:
        way, long = float(np.deg2rad(self._way.value)), float(self._long.value)
        self._ask(lambda: self.session.push(way, long))

    def _tilt(self) -> None:
        slope = [float(np.deg2rad(s.value)) for s in (self._slope, self._cross)]
        self._ask(lambda: self.session.tilt(*slope))

    def _rub(self) -> None:
        friction = float(self._friction.value)
        self._ask(lambda: self.session.set_friction(friction))

    def _carry(self) -> None:
        mass = float(self._load.value)
        self._ask(lambda: self.session.set_load(mass))

    def _choose(self) -> None:
        wanted = Choice(self._controller.value, self._feet.value, self._joints.value)
        self._choice = None  # restore the controls if the choice is invalid
        self._ask(lambda: self.session.choose(wanted))

    def _show(self, node: str, label: str) -> None:
        handle = self.server.scene.get_handle_by_name(node)
        if handle is not None:
            handle.visible = self._shown[label].value

    def _follow_targets(self, targets: tuple[Target, ...]) -> None:
        """Update the controls of targets that the controller changes by itself."""
        for shown, target in zip(self.targets, targets, strict=True):
            if target.names:
                shown.value = target.names[round(target.value)]
            elif abs(shown.value - target.value) > 0.52 * shown.step:
                shown.value = target.value

    def _offer(self, targets: tuple[Target, ...]) -> None:
        """Create a control for each target of a controller."""
        before, self._of = self._of or (), targets
        if [_control_of(t) for t in before] == [_control_of(t) for t in targets]:
            return
        for control in self.targets:
            control.remove()
        with self._folder:
            self.targets = [self._control(k, target) for k, target in enumerate(targets)]

    def _control(self, k: int, target: Target) -> Any:
        """Return a dropdown or slider for a target."""
        gui = self.server.gui
        label = f"{target.name} [{target.unit}]" if target.unit else target.name
        if target.names:
            names = target.names
            control = gui.add_dropdown(label, names, initial_value=names[round(target.value)])
        else:
            step = (target.high - target.low) / 200
            control = gui.add_slider(label, target.low, target.high, step, target.value)

        @control.on_update
        def _(event: Any) -> None:
            if event.client is not None and self._of is not None and k < len(self._of):
                own, word = self._of[k], control.value
                value = float(own.names.index(word)) if own.names else float(word)
                self._ask(lambda: own.set(value))

        return control


def _control_of(target: Target) -> tuple[Any, ...]:
    """Return the label of the control of a target."""
    return target.name, target.low, target.high, target.unit, target.names
