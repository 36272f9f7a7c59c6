"""The live viewer: the same scene served to a browser, for ``plantigrade view``.

Works over ssh and in a notebook: the server has no window and no OpenGL, the browser draws.
"""

import sys
import time as clock
import webbrowser
from collections.abc import Callable
from threading import Event
from typing import Any

import numpy as np

from plantigrade.charts import theme
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.report.scene import build_scene, heading_of, standing_height
from plantigrade.report.shapes import Shape, mesh_of, rgb

ARROW = 0.6  # one body weight is drawn this long [m]
PAUSE = 0.6  # the last frame stays this long before the first comes again [s]


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
        record: What to show.
        forces: Whose forces to draw where the record has none.
        port: Port to listen on; the next free one is taken where it is in use.
        open: Whether to open the page in the default browser.
        title: Shown over the controls.
        stop: Ends the service when set (for tests and notebooks).

    Raises:
        ParameterError: If the record cannot be drawn or the port is no port.
    """
    live = LiveViewer(record, forces=forces, port=port, title=title)
    stop = stop or Event()
    try:
        print(f"Viewer at {live.address} (end with Ctrl-C)", file=sys.stderr)
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
        scene: What is drawn.
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
        if not 0 < port < 65536:
            raise ParameterError(f"{port=} is no port; choose one from 1024 to 65535")
        import viser

        self.scene = build_scene(record, forces=forces)
        self.server = viser.ViserServer(host="localhost", port=port, verbose=False)
        self._frame = -1
        self._now = float(self.scene.time[0])
        self._draw_static()
        self._add_controls(title)
        self.show(0)

    @property
    def address(self) -> str:
        """Where a browser finds it."""
        return f"http://localhost:{self.server.get_port()}"

    def close(self) -> None:
        """Stop the server."""
        self.server.stop()

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
            # To follow, the world moves and the camera stays: what the user turned stays turned,
            # and no answer of a slow browser can pull it back.
            at = frame if self._follow.value else 0
            self._world.position = -np.array([*scene.com[at, :2], scene.level[at]])
            for handle, body in self._bodies:
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
            for arrows in self._forces:
                arrows.points, arrows.colors = self._arrows(frame)
            for cloud in self._pressure:
                cloud.points, cloud.colors = self._pressed(frame)

    def _draw_static(self) -> None:
        server, scene = self.server, self.scene
        height = standing_height(scene)
        target = np.array([0.0, 0.0, 0.5 * height])
        angle = heading_of(scene) - 0.95
        away = np.array([np.cos(angle), np.sin(angle), 0.25]) * 1.6 * height
        server.scene.set_up_direction("+z")
        server.initial_camera.position = tuple(target + away)
        server.initial_camera.look_at = tuple(target)
        self._world = server.scene.add_frame("/world", show_axes=False)
        self._add_ground()
        self._bodies = self._add_bodies("/world/body", lambda s: s.body > 0)
        self._add_bodies("/world/seats", lambda s: s.body == 0 and not s.is_ground)
        self._reference = []
        if scene.reference_positions is not None:
            self._reference = self._add_bodies(
                "/world/reference", lambda s: s.body > 0, colour=theme.REFERENCE, opacity=0.4
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
        self._forces, self._pressure = [], []
        if scene.total_force is not None:
            arrows = server.scene.add_arrows(
                "/world/ground_reaction",
                np.zeros((0, 2, 3), np.float32),
                np.zeros((0, 3), np.uint8),
                shaft_radius=0.012,
                head_radius=0.03,
                head_length=0.08,
            )
            self._forces.append(arrows)
            cloud = server.scene.add_point_cloud(
                "/world/centre_of_pressure",
                np.zeros((0, 3), np.float32),
                np.zeros((0, 3), np.uint8),
                point_size=0.03,
                point_shape="circle",
                precision="float32",
            )
            self._pressure.append(cloud)

    def _add_ground(self) -> None:
        """Add a grid on the plane, or on each tread; relief as it is."""
        ground, scene = self.scene.ground, self.server.scene
        half = -ground.slope / 2
        grid: dict[str, Any] = {
            "cell_size": 0.25,
            "section_size": 1.0,
            "cell_color": in_bytes(theme.FLOOR),
            "section_color": in_bytes(theme.GRID),
            "fade_distance": 25.0,
            "shadow_opacity": 0.3,
            "wxyz": (np.cos(half), 0.0, np.sin(half), 0.0),
        }
        if not ground.steps:
            place = ground.normal * ground.height
            scene.add_grid("/world/ground", width=100.0, height=100.0, position=place, **grid)
        self._add_bodies("/world/relief", lambda s: s.is_ground)

    def _add_bodies(
        self, root: str, which: Callable[[Shape], bool], *, colour: str = "", opacity: float = 1.0
    ) -> list:
        """Add one frame per body and its shapes below; return handles with body indices."""
        handles = {}
        for i, shape in enumerate(self.scene.shapes):
            if not which(shape):
                continue
            frame = f"{root}/{shape.body}_{shape.body_name or 'world'}"
            if shape.body not in handles:
                handles[shape.body] = self.server.scene.add_frame(frame, show_axes=False)
            vertices, faces = mesh_of(shape)
            self.server.scene.add_mesh_simple(
                f"{frame}/{i}",
                vertices.astype(np.float32),
                faces.astype(np.uint32),
                color=in_bytes(colour or shape.paint),
                opacity=None if opacity == 1 else opacity,
                flat_shading=shape.kind in ("box", "mesh"),
                side="double",
                receive_shadow=0.3 if shape.is_ground else True,
                position=shape.position,
                wxyz=shape.quat,
            )
        return [(handle, body) for body, handle in handles.items()]

    def _add_controls(self, title: str) -> None:
        gui, scene = self.server.gui, self.scene
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label(title)
        self._playing = gui.add_checkbox("Play", True)
        first, last = float(scene.time[0]), float(scene.time[-1])
        self._slider = gui.add_slider(
            "Time [s]", first, max(last, first + 1e-3), 0.001, first, disabled=last <= first
        )
        back, on = gui.add_button("One frame back"), gui.add_button("One frame on")
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
            if event.client is not None:  # moved by a person, not by the clock
                self._playing.value = False
                self._go(int(np.searchsorted(scene.time, self._slider.value, side="right") - 1))

        back.on_click(lambda _event: self._step(-1))
        on.on_click(lambda _event: self._step(1))
        for box in (self._beside, self._follow):
            box.on_update(lambda _event: self.show(self._frame))

        layers = {
            "Body": [handle for handle, _ in self._bodies],
            other: [handle for handle, _ in self._reference],
            "Recorded markers": self._named("recorded"),
            "Markers on the body": self._named("fitted"),
            "Ground reaction": self._forces,
            "Centre of pressure": self._pressure,
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

    def _arrows(self, frame: int):
        """Return start and end of each ground reaction [m] and its colour."""
        scene = self.scene
        points, colours = [], []
        assert scene.cop is not None and scene.total_force is not None  # both or neither
        for side, colour in enumerate(theme.BY_SIDE):
            start, force = scene.cop[frame, side], scene.total_force[frame, side]
            if np.isfinite(start).all() and np.any(force):
                points.append([start, start + ARROW * force / scene.weight])
                colours.append(in_bytes(colour))
        arrows = np.array(points, np.float32).reshape(-1, 2, 3)
        return arrows, np.array(colours, np.uint8).reshape(-1, 3)

    def _pressed(self, frame: int):
        """Return the centres of pressure [m] and their colours."""
        assert self.scene.cop is not None  # where there are forces
        place = self.scene.cop[frame]
        there = np.isfinite(place).all(axis=1)
        colours = np.array([in_bytes(colour) for colour in theme.BY_SIDE], np.uint8)
        return place[there].astype(np.float32), colours[there]


def in_bytes(colour: str | tuple[float, float, float]) -> tuple[int, int, int]:
    """Return red, green and blue in 0–255, as viser takes them.

    Example:
        >>> in_bytes("#ff0033"), in_bytes((1.0, 0.0, 0.2))
        ((255, 0, 51), (255, 0, 51))
    """
    parts = rgb(colour) if isinstance(colour, str) else colour
    red, green, blue = (round(255 * part) for part in parts)
    return red, green, blue
