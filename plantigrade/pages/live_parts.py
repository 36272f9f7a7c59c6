"""Drawing of bodies, ground and arrows on a viser server."""

from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from io import StringIO
from typing import Any, NamedTuple

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.pages.control_filter import filter_control_messages
from plantigrade.pages.local_only import local_only
from plantigrade.pages.shapes import Shape, mesh_of, rgb

PUSH_OFFSET = 0.3  # [m] of the arrow head of a push from its point, outside of trunk and arms
ARROW_PER_BODY_WEIGHT = 0.6  # [m] length of the arrow of one body weight
HEAD_LENGTH = 0.08  # [m] of an arrow
MIN_LENGTH = 0.015  # [m] of a drawn arrow


def open_server(port: int, title: str, refused: Callable[[str], None] = lambda _: None) -> Any:
    """Return a viser server for this machine only, on ``port`` or the next free one.

    Args:
        port: The port.
        title: Title above the controls.
        refused: Called with a sentence for every refused message.

    Raises:
        ParameterError: If the port is none.
        PlantigradeError: If this version of viser does not let its messages be checked.
    """
    if not 0 < port < 65536:
        raise ParameterError(f"{port=} is not a valid port; choose one from 1024 to 65535")
    import viser

    with (
        redirect_stdout(StringIO()),
        local_only(),
    ):  # without viser's banner, because --json uses standard output
        server = viser.ViserServer(host="localhost", port=port, verbose=False)
    filter_control_messages(server, refused)
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    server.gui.set_panel_label(title)
    server.scene.set_up_direction("+z")
    return server


def address_of(server: Any) -> str:
    """Return the URL of a server."""
    return f"http://localhost:{server.get_port()}"


def close(server: Any) -> None:
    """Stop a server."""
    with redirect_stdout(StringIO()):
        server.stop()


class Arrow(NamedTuple):
    """A force arrow of 1 m along z, with shaft, head, and a disc at its point of application.

    They are meshes, because viser draws its own arrows too pale.
    """

    shaft: Any
    head: Any
    disc: Any

    def place(self, start: Float[Array, " 3"], vector: Float[Array, " 3"]) -> None:
        """Draw the arrow from a point [m] with a vector [m]; hide it if they are unknown."""
        length = float(np.linalg.norm(vector))
        seen = bool(np.isfinite(start).all())
        tip = min(HEAD_LENGTH, 0.4 * length)
        self.disc.visible = seen
        self.shaft.visible = self.head.visible = seen and length > MIN_LENGTH
        if seen:
            self.disc.position = start
        if self.head.visible:
            along, body = vector / length, length - tip
            self.shaft.position, self.shaft.scale = start + along * body / 2, (1.0, 1.0, body)
            self.head.position, self.head.scale = start + along * body, tip / HEAD_LENGTH
            self.shaft.wxyz = self.head.wxyz = turned_to(along)

    def push(self, place: Float[Array, " 3"], vector: Float[Array, " 3"]) -> None:
        """Draw the arrow of a push so that it ends outside of the body [m]."""
        away = vector + PUSH_OFFSET * vector / max(float(np.linalg.norm(vector)), 1e-9)
        self.place(place - away, vector)
        self.disc.visible = False


def add_arrow(server: Any, forces: str, pressure: str, colour: str) -> Arrow:
    """Add the arrow of a force below a node, and its disc below another."""
    scene, paint, name = server.scene, in_bytes(colour), colour.removeprefix("#")
    shaft, disc = (mesh_of(drum(*size)) for size in ((0.012, 0.5), (0.032, 0.004)))
    turn = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    rim = 0.03 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    tip, base = np.array([[0.0, 0.0, HEAD_LENGTH]]), np.zeros((1, 3))
    i, j = np.arange(20), (np.arange(20) + 1) % 20
    head = (
        np.concatenate([rim, tip, base]),
        np.concatenate([np.column_stack([i, j, 0 * i + 20]), np.column_stack([j, i, 0 * i + 21])]),
    )
    parts = ((forces, "shaft", shaft), (forces, "head", head), (pressure, "disc", disc))
    return Arrow(
        *(
            scene.add_mesh_simple(
                f"{where}/{name}_{part}",
                vertices.astype(np.float32),
                faces.astype(np.uint32),
                color=paint,
                visible=False,
            )
            for where, part, (vertices, faces) in parts
        )
    )


def add_ground(server: Any, ground: Ground, shapes: Sequence[Shape]) -> None:
    """Add the ground below ``/world``: grids on planes and treads, and relief."""
    half = -ground.slope / 2
    turn = (np.cos(half), 0.0, np.sin(half), 0.0)
    if not ground.steps:
        place = ground.normal * ground.height
        add_grid(server, "/world/ground", (100.0, 100.0), position=place, wxyz=turn)
    for tread in (s for s in shapes if s.is_ground and s.kind == "box"):
        top = tread.position + ground.normal * (tread.size[2] + 0.001)
        size = (2 * float(tread.size[0]), 2 * float(tread.size[1]))
        add_grid(server, f"/world/{tread.name}", size, position=top, wxyz=turn)
    add_bodies(server, "/world/relief", [s for s in shapes if s.is_ground])


def add_grid(server: Any, name: str, size: tuple[float, float], **where: Any) -> Any:
    """Add a grid of a given size [m], in the colours of the ground."""
    return server.scene.add_grid(
        name,
        width=size[0],
        height=size[1],
        cell_size=0.25,
        section_size=1.0,
        cell_color=in_bytes(theme.FLOOR),
        section_color=in_bytes(theme.GRID),
        fade_distance=25.0,
        shadow_opacity=0.3,
        **where,
    )


def add_bodies(
    server: Any,
    root: str,
    shapes: Sequence[Shape],
    *,
    colour: str = "",
    opacity: float = 1.0,
    on_mesh: Callable[[Any, Shape], None] = lambda handle, shape: None,
) -> list[tuple[Any, int]]:
    """Add one frame per body and its shapes below; return handles with body indices.

    Args:
        server: The server.
        root: Parent node.
        shapes: Shapes to draw.
        colour: Colour instead of their own ones.
        opacity: Opacity of all shapes.
        on_mesh: Called with every mesh and its shape.
    """
    handles = {}
    for i, shape in enumerate(shapes):
        frame = f"{root}/{shape.body}_{shape.body_name or 'world'}"
        if shape.body not in handles:
            handles[shape.body] = server.scene.add_frame(frame, show_axes=False)
        vertices, faces = mesh_of(shape)
        mesh = server.scene.add_mesh_simple(
            f"{frame}/{i}",
            vertices.astype(np.float32),
            faces.astype(np.uint32),
            color=in_bytes(colour or shape.paint),
            opacity=None if opacity == 1 else opacity,
            flat_shading=shape.kind in ("box", "mesh"),
            side="double",
            cast_shadow=not shape.is_ground,
            receive_shadow=not shape.is_ground,  # their grids receive shadows
            position=shape.position,
            wxyz=shape.quat,
        )
        on_mesh(mesh, shape)
    return [(handle, body) for body, handle in handles.items()]


def in_bytes(colour: str | tuple[float, float, float]) -> tuple[int, int, int]:
    """Return red, green and blue in 0–255, as viser expects them.

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
    """Return the shortest rotation, ``wxyz``, from the vertical to a unit vector.

    Example:
        >>> turned_to(np.array([0.0, 0.0, 1.0]))
        array([1., 0., 0., 0.])
    """
    x, y, z = direction
    quat = np.array([1 + z, -y, x, 0.0]) if z > -1 + 1e-9 else np.array([0.0, 1.0, 0.0, 0.0])
    return quat / np.linalg.norm(quat) + 0.0
