"""The live viewer: the same scene served to a browser, for ``plantigrade view``.

Works over ssh and in a notebook: the server has no window and no OpenGL, the browser draws.
"""

import sys
import time as clock
import webbrowser
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from threading import Event
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.report.local_only import local_only
from plantigrade.report.scene import build_scene, heading_of, standing_height
from plantigrade.report.shapes import Shape, mesh_of, rgb

ARROW = 0.6  # one body weight is drawn this long [m]
HEAD, SHORTEST = 0.08, 0.015  # of which the head is; shorter ones are not drawn [m]
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
        with redirect_stdout(StringIO()), local_only():  # its banner: --json owns standard output
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
        with redirect_stdout(StringIO()):
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
            for side, arrow in enumerate(self._arrows):
                self._place(arrow, frame, side)

    def _draw_static(self) -> None:
        server, scene = self.server, self.scene
        height = standing_height(scene)
        target = np.array([0.0, 0.0, 0.5 * height])
        angle = heading_of(scene) - 0.95
        away = np.array([np.cos(angle), np.sin(angle), 0.25]) * 1.25 * height
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
        self._forces, self._arrows = [], []
        if scene.total_force is not None:
            places = ("/world/ground_reaction", "/world/centre_of_pressure")
            self._forces = [server.scene.add_frame(name, show_axes=False) for name in places]
            self._arrows = [self._add_arrow(*places, colour) for colour in theme.BY_SIDE]

    def _add_arrow(self, forces: str, pressure: str, colour: str) -> tuple:
        """Add shaft, head and disc of a side's ground reaction, of length 1 m along z.

        They are meshes, for viser shows the colours of its own arrows too pale.
        """
        scene, paint, name = self.server.scene, in_bytes(colour), colour.removeprefix("#")
        shaft, disc = (mesh_of(drum(*size)) for size in ((0.012, 0.5), (0.032, 0.004)))
        turn = np.linspace(0, 2 * np.pi, 20, endpoint=False)
        rim = 0.03 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
        tip, base = np.array([[0.0, 0.0, HEAD]]), np.zeros((1, 3))
        i, j = np.arange(20), (np.arange(20) + 1) % 20
        head = (
            np.concatenate([rim, tip, base]),
            np.concatenate(
                [np.column_stack([i, j, 0 * i + 20]), np.column_stack([j, i, 0 * i + 21])]
            ),
        )
        parts = ((forces, "shaft", shaft), (forces, "head", head), (pressure, "disc", disc))
        return tuple(
            scene.add_mesh_simple(
                f"{where}/{name}_{part}",
                vertices.astype(np.float32),
                faces.astype(np.uint32),
                color=paint,
                visible=False,
            )
            for where, part, (vertices, faces) in parts
        )

    def _place(self, arrow: tuple, frame: int, side: int) -> None:
        """Put the ground reaction of a side where it acts, or hide it."""
        scene = self.scene
        assert scene.cop is not None and scene.total_force is not None  # both or neither
        start = scene.cop[frame, side]
        vector = ARROW * scene.total_force[frame, side] / scene.weight
        length = float(np.linalg.norm(vector))
        seen = bool(np.isfinite(start).all())
        tip = min(HEAD, 0.4 * length)
        shaft, head, disc = arrow
        disc.visible = seen
        shaft.visible = head.visible = seen and length > SHORTEST
        if seen:
            disc.position = start
        if head.visible:
            along, body = vector / length, length - tip
            shaft.position, shaft.scale = start + along * body / 2, (1.0, 1.0, body)
            head.position, head.scale = start + along * body, tip / HEAD
            shaft.wxyz = head.wxyz = turned_to(along)

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
        for tread in (s for s in self.scene.shapes if s.is_ground and s.kind == "box"):
            top = tread.position + ground.normal * (tread.size[2] + 0.001)
            width, height = 2 * tread.size[:2]
            scene.add_grid(f"/world/{tread.name}", width=width, height=height, position=top, **grid)
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
                cast_shadow=not shape.is_ground,
                receive_shadow=not shape.is_ground,  # their grids do
                position=shape.position,
                wxyz=shape.quat,
            )
        return [(handle, body) for body, handle in handles.items()]

    def _add_controls(self, title: str) -> None:
        gui, scene = self.server.gui, self.scene
        self.server.gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label(title)
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
            if event.client is not None:  # moved by a person, not by the clock
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
            "Centre of pressure": self._forces[1:],
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


def in_bytes(colour: str | tuple[float, float, float]) -> tuple[int, int, int]:
    """Return red, green and blue in 0–255, as viser takes them.

    Example:
        >>> in_bytes("#ff0033"), in_bytes((1.0, 0.0, 0.2))
        ((255, 0, 51), (255, 0, 51))
    """
    parts = rgb(colour) if isinstance(colour, str) else colour
    red, green, blue = (round(255 * part) for part in parts)
    return red, green, blue


def drum(radius: float, half: float) -> Shape:
    """Return a cylinder along z [m]."""
    still = np.array([1.0, 0.0, 0.0, 0.0])
    size = np.array([radius, half, 0.0])
    return Shape("cylinder", size, np.zeros(3), still, None, 0, "world")


def turned_to(direction: Float[Array, " 3"]) -> Float[Array, " 4"]:
    """Return the shortest turn, ``wxyz``, of the vertical to a unit vector.

    Example:
        >>> turned_to(np.array([0.0, 0.0, 1.0]))
        array([1., 0., 0., 0.])
    """
    x, y, z = direction
    quat = np.array([1 + z, -y, x, 0.0]) if z > -1 + 1e-9 else np.array([0.0, 1.0, 0.0, 0.0])
    return quat / np.linalg.norm(quat) + 0.0
