"""The live viewer: the same scene served to a browser, for ``plantigrade view``.

Works over ssh and in a notebook: the server has no window and no OpenGL, the browser draws.
"""

import sys
import time as clock
import webbrowser
from threading import Event

import numpy as np

from plantigrade.charts import theme
from plantigrade.pages.live_parts import (
    ARROW_PER_BODY_WEIGHT,
    Arrow,
    add_arrow,
    add_bodies,
    add_ground,
    address_of,
    close,
    in_bytes,
    open_server,
)
from plantigrade.pages.scene import build_scene, heading_of, standing_height
from plantigrade.record import Record

PAUSE = 0.6  # [s] after the last frame, before playback restarts


def serve(
    record: Record,
    *,
    forces: Record | None = None,
    port: int = 8080,
    open: bool = True,  # noqa: A002 - the word of the command line's option
    title: str = "plantigrade",
    stop: Event | None = None,
) -> None:
    """Serve ``record`` on http://localhost:``port`` until interrupted, or until ``stop`` is set.

    Args:
        record: Record to show.
        forces: Record whose forces are drawn if ``record`` has none.
        port: Port to listen on, or the next free one.
        open: Whether to open the page in the default browser.
        title: Title above the controls.
        stop: Ends the service when set (for tests and notebooks).

    Raises:
        ParameterError: If the record cannot be drawn or the port is no port.
    """
    live = LiveViewer(record, forces=forces, port=port, title=title)
    stop = stop or Event()
    try:
        print(f"Viewer at {live.address} (press Ctrl-C to stop)", file=sys.stderr)
        if open:
            webbrowser.open(live.address)
        live.play(stop)
    except KeyboardInterrupt:
        pass
    finally:
        live.close()


class LiveViewer:
    """A record on a viser server, with playback controls in its panel.

    Attributes:
        scene: The scene.
        server: The viser server, for more controls and shapes.
    """

    def __init__(
        self,
        record: Record,
        *,
        forces: Record | None = None,
        port: int = 8080,
        title: str = "plantigrade",
    ):
        """Start the server and draw the first frame; the arguments are those of :func:`serve`."""
        self.scene = build_scene(record, forces=forces)
        self.server = open_server(port, title)
        self._frame = -1
        self._now = float(self.scene.time[0])
        self._draw_static()
        self._add_controls()
        self.show(0)

    @property
    def address(self) -> str:
        """URL of the page."""
        return address_of(self.server)

    def close(self) -> None:
        """Stop the server."""
        close(self.server)

    def play(self, stop: Event) -> None:
        """Run the clock until ``stop`` is set."""
        times = self.scene.time
        before = clock.monotonic()
        while not stop.wait(1 / 60):
            now = clock.monotonic()
            if self._playing.value and len(times) > 1:
                speed = float(self._speed.value.rstrip("x"))
                self._now += (now - before) * speed
                if self._now > times[-1] + PAUSE * speed:
                    self._now = float(times[0])
                frame = int(np.searchsorted(times, self._now, side="right") - 1)
                if frame != self._frame:
                    self._slider.value = float(times[frame])
                    self.show(frame)
            before = now

    def show(self, frame: int) -> None:
        """Draw frame ``frame`` of the scene."""
        scene = self.scene
        self._frame = frame
        with self.server.atomic():
            # To follow, the world moves instead of the camera, so the view of the user is kept even
            # with a slow browser.
            at = frame if self._follow.value else 0
            self._world.position = -np.array([*scene.com[at, :2], scene.level[at]])
            for handle, body in (*self._bodies, *self._plate):
                handle.position = scene.positions[frame, body]
                handle.wxyz = scene.quats[frame, body]
            for handle, body in self._things:
                handle.visible = bool(np.isfinite(scene.positions[frame, body, 0]))
                if handle.visible:
                    handle.position = scene.positions[frame, body]
                    handle.wxyz = scene.quats[frame, body]
            if scene.reference_positions is not None and scene.reference_quats is not None:
                shift = self._sideways()
                for handle, body in self._reference:
                    handle.position = scene.reference_positions[frame, body] + shift
                    handle.wxyz = scene.reference_quats[frame, body]
            for name, handle in self._clouds.items():
                points = getattr(scene, name)[frame]
                handle.points = points[np.isfinite(points).all(axis=1)].astype(np.float32)
            self._com.position = scene.com[frame]
            below = [*scene.com[frame, :2], scene.floor[frame]]
            self._plumb.points = np.array([[scene.com[frame], below]], np.float32)
            for side, arrow in enumerate(self._arrows):
                self._place(arrow, frame, side)
            if scene.force is not None and scene.point is not None:
                for k, arrow in zip(scene.pushes, self._pushing, strict=True):
                    arrow.push(
                        scene.point[frame, k],
                        ARROW_PER_BODY_WEIGHT * scene.force[frame, k] / scene.weight,
                    )

    def _draw_static(self) -> None:
        server, scene = self.server, self.scene
        height = standing_height(scene)
        target = np.array([0.0, 0.0, 0.5 * height])
        angle = heading_of(scene) - 0.95
        away = np.array([np.cos(angle), np.sin(angle), 0.25]) * 1.25 * height
        server.initial_camera.position = tuple(target + away)
        server.initial_camera.look_at = tuple(target)
        self._world = server.scene.add_frame("/world", show_axes=False)
        if not scene.plate:
            add_ground(server, scene.ground, scene.shapes)
        bodies = [s for s in scene.shapes if s.body > 0 and not (s.is_plate or s.is_thing)]
        self._bodies = add_bodies(server, "/world/body", bodies)
        self._plate = add_bodies(server, "/world/plate", [s for s in scene.shapes if s.is_plate])
        things = [s for s in scene.shapes if s.is_thing]
        self._things = add_bodies(server, "/world/things", things)
        seats = [s for s in scene.shapes if s.body == 0 and not s.is_ground]
        add_bodies(server, "/world/seats", seats)
        self._reference = []
        if scene.reference_positions is not None:
            self._reference = add_bodies(
                server, "/world/reference", bodies, colour=theme.REFERENCE, opacity=0.4
            )
        self._clouds = {
            name: server.scene.add_point_cloud(
                f"/world/markers/{name}",
                np.zeros((0, 3), np.float32),
                in_bytes(colour),
                point_size=0.012,
                point_shape="circle",
                precision="float32",
            )
            for name, colour in (("recorded", theme.RECORDED), ("fitted", theme.FITTED))
            if getattr(scene, name) is not None
        }
        gold = in_bytes(theme.COM)
        self._com = server.scene.add_icosphere("/world/com", radius=0.035, color=gold)
        self._plumb = server.scene.add_line_segments(
            "/world/plumb_line", np.zeros((1, 2, 3), np.float32), gold
        )
        self._forces, self._arrows = [], []
        if scene.total_force is not None:
            places = ("/world/ground_reaction", "/world/centre_of_pressure")
            self._forces = [server.scene.add_frame(name, show_axes=False) for name in places]
            self._arrows = [add_arrow(server, *places, colour) for colour in theme.BY_SIDE]
        self._pushing = []
        if scene.force is not None and scene.pushes:
            root = "/world/pushes"
            self._forces.append(server.scene.add_frame(root, show_axes=False))
            for k in scene.pushes:
                place = f"{root}/{k}"
                self._pushing.append(add_arrow(server, place, place, theme.PUSHED))

    def _place(self, arrow: Arrow, frame: int, side: int) -> None:
        """Draw the ground reaction of a side, or hide it."""
        scene = self.scene
        assert scene.cop is not None and scene.total_force is not None  # both exist or neither
        vector = ARROW_PER_BODY_WEIGHT * scene.total_force[frame, side] / scene.weight
        arrow.place(scene.cop[frame, side], vector)

    def _add_controls(self) -> None:
        gui, scene = self.server.gui, self.scene
        self._playing = gui.add_checkbox("Play", True)
        first, last = np.floor(1e3 * scene.time[0]) / 1e3, np.ceil(1e3 * scene.time[-1]) / 1e3
        self._slider = gui.add_slider(
            "Time [s]", first, max(last, first + 1e-3), 0.001, first, disabled=len(scene.time) < 2
        )
        frame = gui.add_button_group("One frame", ("back", "on"))
        self._speed = gui.add_dropdown(
            "Speed", ("0.1x", "0.25x", "0.5x", "1x", "2x"), initial_value="1x"
        )
        self._follow = gui.add_checkbox("Follow camera", True)
        other = scene.reference_name.capitalize()
        self._beside = gui.add_checkbox(
            f"{other} beside", False, visible=scene.reference_positions is not None
        )

        @self._slider.on_update
        def _(event) -> None:
            if event.client is not None:  # set by the user, not by playback
                self._playing.value = False
                self._go(int(np.searchsorted(scene.time, self._slider.value, side="right") - 1))

        frame.on_click(lambda _event: self._step(1 if frame.value == "on" else -1))
        for box in (self._beside, self._follow):
            box.on_update(lambda _event: self.show(self._frame))

        layers = {
            "Body": [handle for handle, _ in self._bodies],
            other: [handle for handle, _ in self._reference],
            "Recorded markers": self._named("recorded"),
            "Markers on the body": self._named("fitted"),
            "Ground reaction": self._forces[:1],
            "Centre of pressure": self._forces[1:2],
            "Pushes": self._forces[2:],
            "Centre of mass": [self._com, self._plumb],
        }
        with gui.add_folder("Show"):
            for label, handles in layers.items():
                if not handles:
                    continue
                box = gui.add_checkbox(label, True)

                @box.on_update
                def _(_event, box=box, handles=handles) -> None:
                    for handle in handles:
                        handle.visible = box.value

    def _named(self, cloud: str) -> list:
        return [self._clouds[cloud]] if cloud in self._clouds else []

    def _step(self, by: int) -> None:
        self._playing.value = False
        self._go(self._frame + by)
        self._slider.value = self._now

    def _go(self, frame: int) -> None:
        frame = int(np.clip(frame, 0, len(self.scene.time) - 1))
        self._now = float(self.scene.time[frame])
        self.show(frame)

    def _sideways(self) -> np.ndarray:
        angle = heading_of(self.scene)
        reach = 0.75 if self._beside.value else 0.0
        return reach * np.array([-np.sin(angle), np.cos(angle), 0.0])
