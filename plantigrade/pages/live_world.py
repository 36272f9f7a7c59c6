"""The page of a live session, drawn in another thread than the physics.

The session runs in a thread of its own (:func:`plantigrade.live.session.run`); this page draws its
last frame, sixty times a second, and asks it for whatever somebody does.
"""

from threading import Event
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.constants import SIDES
from plantigrade.live.clock import Clock
from plantigrade.live.frame import MIN_LOAD, Frame
from plantigrade.live.session import Session
from plantigrade.pages.live_curves import LiveCurves
from plantigrade.pages.live_panel import Panel
from plantigrade.pages.live_parts import (
    ARROW_PER_BODY_WEIGHT,
    Arrow,
    add_arrow,
    add_bodies,
    add_grid,
    add_ground,
    address_of,
    close,
    in_bytes,
    open_server,
)
from plantigrade.pages.shapes import PLATE, Shape, convex_hull, shapes_of
from plantigrade.world import Drawing, World

PANEL_INTERVAL = 8  # frames between updates of figures and curves
IDLE_WAIT = 0.05  # [s] for a new frame, before other changes are drawn
MIN_MOVEMENT = 2e-4  # [m, rad] of a body that is drawn again
LINE_HEIGHT = 0.003  # [m] of lines above the ground


class LiveWorld:
    """A session on a viser server.

    Attributes:
        session: The session.
        server: The viser server.
        panel: The controls.
        drawn: Number of drawn frames.
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
        """Start the server and draw the first frame.

        Args:
            session: The session.
            clock: Its clock.
            port: Port to listen on; the next free one is taken where it is in use.
            title: Title above the controls.
            can_save: Whether there is a save button.

        Raises:
            ParameterError: If the port is no port.
        """
        self.session = session
        self.server = open_server(port, title, lambda said: setattr(session, "message", said))
        self._world: World | None = None
        self._frame: Frame | None = None
        self.drawn = 0
        self._offset = np.zeros(3)
        height = session.world.human.height
        self.server.initial_camera.position = (1.25 * height, -1.0 * height, 0.75 * height)
        self.server.initial_camera.look_at = (0.0, 0.0, 0.5 * height)
        self.panel = Panel(self.server, session, clock, can_save=can_save)
        self._beside = LiveCurves(self.server, session)
        self.draw(session.frame)

    @property
    def address(self) -> str:
        """URL of the page."""
        return address_of(self.server)

    @property
    def save_requested(self) -> Event:
        """Event of the save button, cleared after saving."""
        return self.panel.save_requested

    def close(self) -> None:
        """Stop the server."""
        close(self.server)

    def show(self, stop: Event) -> None:
        """Draw until ``stop`` is set, or saving is requested."""
        turn, news = 0, self.session.frame_ready
        while not (stop.is_set() or self.save_requested.is_set()):
            news.wait(IDLE_WAIT)
            news.clear()
            frame = self.session.frame
            if frame is not self._frame:
                self.draw(frame)
            if turn % PANEL_INTERVAL == 0:
                self.panel.update(frame)
            elif turn % PANEL_INTERVAL == PANEL_INTERVAL // 2:
                self._beside.update(frame)
            turn += 1

    def draw(self, frame: Frame) -> None:
        """Draw a frame."""
        if frame.world is not self._world:
            self._begin(frame)
        self._frame, self.drawn = frame, self.drawn + 1
        with self.server.atomic():
            if self.panel.follows:
                self._offset = np.array([*frame.com[:2], 0.0])
                self._root.position = -self._offset
            self._bodies_to(frame)
            self._com.position = frame.com
            self._forces_to(frame)
            self._rope_to(frame)
            self._pushes_to(frame)
            self._pack_to(frame)
            self._drawings_to(frame)

    def _begin(self, frame: Frame) -> None:
        """Draw another world."""
        server, scene, world = self.server, self.server.scene, frame.world
        if self._world is not None:
            scene.remove_by_name("/world")
        self._world = world
        self._root = scene.add_frame("/world", show_axes=False)
        shapes = [s for s in shapes_of(world.model) if not s.is_plate]  # a grid is drawn instead
        plates = [i for i in range(world.model.ngeom) if world.model.geom(i).name == PLATE]
        self._handles = add_bodies(
            server, "/world/body", [s for s in shapes if s.body > 0], on_mesh=self._can_be_dragged
        )
        add_bodies(server, "/world/seats", [s for s in shapes if s.body == 0 and not s.is_ground])
        for geom in plates:
            body = int(world.model.geom_bodyid[geom])
            ground = scene.add_frame("/world/platform", show_axes=False)
            height = float(world.model.geom_pos[geom, 2] + world.model.geom_size[geom, 2])
            size = 2 * world.model.geom_size[geom]
            extent = (float(size[0]), float(size[1]))
            add_grid(server, "/world/platform/grid", extent, position=(0.0, 0.0, height))
            self._handles.append((ground, body))
        if not plates:
            add_ground(server, world.ground, shapes)
        self._last = np.full((world.model.nbody, 7), np.nan)
        self._weight = world.human.mass * float(-world.model.opt.gravity[2])
        self._com = scene.add_icosphere("/world/com", radius=0.03, color=in_bytes(theme.COM))
        places = ("/world/ground_reaction", "/world/centre_of_pressure")
        for name in places:
            scene.add_frame(name, show_axes=False)
        self._arrows = [add_arrow(server, *places, colour) for colour in theme.BY_SIDE[:2]]
        self._middle = scene.add_icosphere(
            "/world/centre_of_pressure/both", radius=0.014, color=in_bytes(theme.COM)
        )
        self._sides = [np.array([s.side == side for s in world.sites]) for side in SIDES]
        scene.add_frame("/world/pushes", show_axes=False)
        self._pushing: list[Arrow] = []
        self._pack = None
        self._lines: dict[str, Any] = {}
        self._drawn: set[str] = set()
        self.panel.begin()
        self._beside.begin()

    def _can_be_dragged(self, mesh: Any, shape: Shape) -> None:
        """Make a body draggable by its mesh."""
        session = self.session

        @mesh.on_drag("left")
        async def _(event: Any) -> None:  # async handlers are called in order
            start, end = np.array(event.start_position), np.array(event.end_position)
            if event.phase == "end":
                session.submit(lambda: session.hand.hold(None))
            elif event.phase == "start":
                at, to, body = start + self._offset, end + self._offset, shape.body
                session.submit(lambda: session.hold(body, at, to))
            else:
                to = end + self._offset
                session.submit(lambda: session.pull(to))

    def _bodies_to(self, frame: Frame) -> None:
        now = np.concatenate([frame.positions, frame.quats], axis=1)
        moved = ~(np.abs(now - self._last).max(axis=1) < MIN_MOVEMENT)
        for handle, body in self._handles:
            if moved[body]:
                handle.position, handle.wxyz = frame.positions[body], frame.quats[body]
                self._last[body] = now[body]

    def _forces_to(self, frame: Frame) -> None:
        """Draw ground reactions, centres of pressure and the support polygon."""
        up = np.maximum(frame.force[:, 2], 0.0)
        for arrow, own in zip(self._arrows, self._sides, strict=True):
            load = float(up[own].sum())
            place = np.full(3, np.nan)
            if load > MIN_LOAD * self._weight:
                place = up[own] @ frame.point[own] / load
            arrow.place(place, ARROW_PER_BODY_WEIGHT * frame.force[own].sum(axis=0) / self._weight)
        load = float(up.sum())
        self._middle.visible = load > MIN_LOAD * self._weight
        if self._middle.visible:
            self._middle.position = up @ frame.point / load
        touching = frame.point[up > 0.0]
        ends = touching + ARROW_PER_BODY_WEIGHT * frame.force[up > 0.0] / self._weight
        self._segments("contact_forces", np.stack([touching, ends], axis=1), theme.FORCE)
        self._segments("support", outline_of(touching), theme.RECORDED)

    def _rope_to(self, frame: Frame) -> None:
        empty = np.zeros((0, 2, 3))
        self._segments("rope", empty if frame.rope is None else frame.rope[None], theme.FITTED, 4.0)

    def _pushes_to(self, frame: Frame) -> None:
        """Draw pushes and the rope."""
        for k in range(len(self._pushing), len(frame.pushes)):
            place = f"/world/pushes/{k}"
            self._pushing.append(add_arrow(self.server, place, place, theme.PUSHED))
        nowhere = np.full((2, 3), np.nan)
        for k, arrow in enumerate(self._pushing):
            place, force = frame.pushes[k] if k < len(frame.pushes) else nowhere
            arrow.push(place, ARROW_PER_BODY_WEIGHT * force / self._weight)

    def _pack_to(self, frame: Frame) -> None:
        """Draw the pack, with a volume in proportion to its mass."""
        if self._pack is not None and self._pack[0] != frame.pack:
            self._pack[1].remove()
            self._pack = None
        if frame.pack is None:
            return
        if self._pack is None:
            size = tuple(2.0 * half for half in frame.pack.size)
            box = self.server.scene.add_box("/world/pack", in_bytes(theme.THING), dimensions=size)
            self._pack = frame.pack, box
        self._pack[1].position, self._pack[1].wxyz = frame.pack_pose[:3], frame.pack_pose[3:]

    def _drawings_to(self, frame: Frame) -> None:
        """Draw the drawings of the controller, and remove old ones."""
        names = set()
        for drawing in frame.drawings:
            names.add(drawing.name)
            self._offer(drawing)
        for name in self._drawn - names:
            self._offer(Drawing(name=name))
        self._drawn = names

    def _offer(self, drawing: Drawing) -> None:
        name = f"offered/{drawing.name.replace('/', ' ')}"
        lines = np.zeros((0, 2, 3)) if drawing.lines is None else drawing.lines
        self._segments(f"{name}/lines", lines, drawing.colour, 3.0)
        points = np.zeros((0, 3)) if drawing.points is None else drawing.points
        node = f"/world/{name}/points"
        if node not in self._lines:
            if not len(points):
                return
            self._lines[node] = self.server.scene.add_point_cloud(
                node,
                points.astype(np.float32),
                in_bytes(drawing.colour),
                point_size=0.03,
                point_shape="circle",
                precision="float32",
            )
        self._lines[node].points = points.astype(np.float32)
        self._lines[node].visible = len(points) > 0

    def _segments(
        self, name: str, lines: Float[Array, "n 2 3"], colour: str, width: float = 2.0
    ) -> None:
        """Draw segments, replacing those of the same name."""
        node = f"/world/{name}"
        handle = self._lines.get(node)
        if handle is None:
            if not len(lines):
                return
            self._lines[node] = self.server.scene.add_line_segments(
                node,
                lines.astype(np.float32),
                in_bytes(colour),
                thickness=width,
                thickness_units="screen",
            )
            self.panel.layer(name, self._lines[node])
            return
        if len(lines):
            handle.points = lines.astype(np.float32)
        shown = len(lines) > 0 and self.panel.shows(name)
        if handle.visible != shown:
            handle.visible = shown


def outline_of(points: Float[Array, "n 3"]) -> Float[Array, "m 2 3"]:
    """Return the sides of the convex hull of points over the ground, a little above them [m]."""
    if len(points) < 2:
        return np.zeros((0, 2, 3))
    corners = convex_hull(points[:, :2])
    nearest = np.abs(corners[:, None] - points[None, :, :2]).sum(axis=2).argmin(axis=1)
    ring = points[nearest] + [0.0, 0.0, LINE_HEIGHT]
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
