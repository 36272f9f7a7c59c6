"""A run as a film: MP4, or an animated GIF.

Frames are drawn here, triangle by triangle from far to near, so that no graphics card, driver or
window is needed; a computer without a display makes the same film.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from plantigrade.arrays import Array, Float, Int
from plantigrade.charts import theme
from plantigrade.errors import ParameterError
from plantigrade.exchange.animation import COLOURS, dressed_surfaces, surface_of
from plantigrade.exchange.clock import require_rate
from plantigrade.exchange.gltf import together
from plantigrade.extras import require
from plantigrade.io.writing import whole_file
from plantigrade.pages.camera import Camera
from plantigrade.pages.scene import Scene, build_scene, heading_of
from plantigrade.record import Run
from plantigrade.skin import Skin
from plantigrade.spatial.conventions import rotation_matrix, unit_vectors

VIEW_HEIGHT = 2.3
"""Height of what is seen [m]: a tall person with raised arms."""
PICTURE_MIDDLE = 0.42
"""Height of the middle of the picture above the ground [:data:`VIEW_HEIGHT`]. Chosen."""
FREE_RISE = 0.02
"""Distance of the centre of mass from it at which the camera rises or sinks with it
[:data:`VIEW_HEIGHT`]. Chosen."""
ASPECT_RATIO = 16 / 9  #: Width over height of the picture
SUPERSAMPLING = 2  #: Factor at which frames are drawn before they are reduced, against jagged edges
LIGHT = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
"""Direction of the light: right, up, towards the reader."""
AMBIENT_LIGHT = 0.45  #: Brightness of a surface that the light does not meet
CAMERA_CALM = 0.3  #: Time over which the camera's path is smoothed, standard deviation [s]
SQUARE_SIZE = 0.5
"""Side of the squares of the ground [m]."""
N_SQUARES = 9
"""Number of squares to each side of the body."""
ARROW_LENGTH = 0.6
"""Length of the arrow of one body weight, as in ``viewer.html`` [m]."""
ARROW_WIDTH = 0.02
"""Width of that arrow [m]."""
HEIGHTS = (120, 2160)  #: Allowed height of the picture [pixels]


def write_film(
    run: Run, path: Path, rate: float = 25.0, view: str = "side", height_px: int = 480
) -> tuple[str, ...]:
    """Write a run as MP4 (H.264) or animated GIF, at true speed, with ground reactions as arrows.

    Args:
        path: The file, ``.mp4`` or ``.gif``.
        rate: Frames per second [Hz]; the nearest whole fraction of the motion's rate.
        view: Where the reader stands, one of :data:`~plantigrade.pages.camera.VIEWS`.
        height_px: Height of the picture [pixels].

    Raises:
        MissingExtra: If the libraries that write films are not installed (extra ``video``).
        ParameterError: If a value is not allowed, or the record cannot be drawn.
        FileError: If the file cannot be written.
    """
    require_rate(rate)
    if not HEIGHTS[0] <= height_px <= HEIGHTS[1]:
        low, high = HEIGHTS
        raise ParameterError(f"{height_px=} [pixels] must lie between {low} and {high}")
    require("PIL", "video")
    # H.264 wants even numbers
    size = 2 * round(ASPECT_RATIO * height_px / 2), 2 * round(height_px / 2)
    scene = build_scene(run.record, forces=run.with_forces, rate=rate)
    ahead = heading_of(scene)
    camera = Camera.named(view, np.array([np.cos(ahead), np.sin(ahead), 0.0]))
    frames = _frames(run, scene, camera, size)
    steps = np.diff(scene.time)
    shown = float(1 / steps.mean()) if len(steps) else rate
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with whole_file(path) as part:
        film = part.with_name(f"{part.name}{path.suffix}")  # its writers go by the extension
        try:
            write(film, frames, shown, size)
            os.replace(film, part)
        finally:
            film.unlink(missing_ok=True)
    return ()


def _write_mp4(path: Path, frames: Iterator[Any], rate: float, size: tuple[int, int]) -> None:
    ffmpeg = require("imageio_ffmpeg", "video")
    writer = ffmpeg.write_frames(str(path), size, fps=rate, quality=8, macro_block_size=2)
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.asarray(frame).tobytes())
    finally:
        writer.close()


def _write_gif(path: Path, frames: Iterator[Any], rate: float, size: tuple[int, int]) -> None:
    first, *others = (frame.quantize(128) for frame in frames)
    step = max(2, round(100 / rate)) * 10  # [ms]: GIF counts in hundredths of a second
    first.save(path, save_all=True, append_images=others, duration=step, loop=0)


@dataclass(frozen=True)
class _Triangles:
    """Triangles of a frame: corners in the world [m] and a colour each, red, green, blue in 0–1."""

    corners: Float[Array, "n 3 3"]
    colours: Float[Array, "n 3"]


def _frames(run: Run, scene: Scene, camera: Camera, size: tuple[int, int]) -> Iterator[Any]:
    """Yield the frames as pictures of ``size`` pixels."""
    from PIL import Image, ImageDraw

    skin, solids = _Person(run), _things(scene, run.record.human.model.nbody)
    step = float(np.median(np.diff(scene.time))) if len(scene.time) > 1 else 1.0
    path = gaussian_filter1d(scene.com, CAMERA_CALM / step, axis=0, mode="nearest")
    middle = scene.level + PICTURE_MIDDLE * VIEW_HEIGHT
    beyond = np.maximum(np.abs(path[:, 2] - middle) - FREE_RISE * VIEW_HEIGHT, 0.0)
    path[:, 2] = middle + np.copysign(beyond, path[:, 2] - middle)
    fine = SUPERSAMPLING * size[0], SUPERSAMPLING * size[1]
    scale = fine[1] / VIEW_HEIGHT
    background = theme.FLOOR
    for k in range(len(scene.time)):
        picture = Image.new("RGB", fine, background)
        drawing = ImageDraw.Draw(picture)

        def placed(points: Array, centre: Array = path[k]) -> Array:
            return camera.project(points - centre) * scale + np.array(fine) / 2

        if not scene.ground.steps:
            _draw_ground(drawing, scene, path[k], placed)
        parts = [skin.triangles(scene, k), *(solid(k) for solid in solids)]
        corners = np.concatenate([part.corners for part in parts])
        colours = np.concatenate([part.colours for part in parts])
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        seen = across @ camera.towards > 0
        corners, colours, across = corners[seen], colours[seen], unit_vectors(across[seen])
        light = LIGHT @ np.array([camera.right, camera.up, camera.towards])
        bright = AMBIENT_LIGHT + (1 - AMBIENT_LIGHT) * np.clip(across @ light, 0, 1)
        paint = np.rint(255 * colours * bright[:, None]).astype(int)
        order = np.argsort((corners @ camera.towards).mean(axis=1))
        flat = placed(corners)[order].reshape(-1, 6)
        for six, colour in zip(flat.tolist(), paint[order].tolist(), strict=True):
            drawing.polygon(six, fill=tuple(colour))
        _draw_forces(drawing, scene, k, placed, max(1, round(ARROW_WIDTH * scale)))
        yield picture.resize(size, Image.Resampling.LANCZOS)


class _Person:
    """The dressed skin of a run's person, posed frame by frame."""

    def __init__(self, run: Run):
        self.skin, self.count = Skin.of(run.record.human), run.record.human.model.nbody
        parts = dressed_surfaces(self.skin)
        whole = together(list(parts.values()))
        self.vertices, self.faces = whole.vertices, whole.faces
        self.bones, self.weights = np.asarray(whole.bones), np.asarray(whole.weights) / 255.0
        counts = [len(part.faces) for part in parts.values()]
        self.colours = np.repeat([COLOURS[name] for name in parts], counts, axis=0)

    def triangles(self, scene: Scene, frame: int) -> _Triangles:
        """Return the triangles of a frame."""
        poses = scene.positions[frame, : self.count], scene.quats[frame, : self.count]
        moves = np.einsum("nk,nkij->nij", self.weights, self.skin.motions(*poses)[self.bones])
        places = np.einsum("nij,nj->ni", moves[:, :, :3], self.vertices) + moves[:, :, 3]
        return _Triangles(places[self.faces], self.colours)


class _Solid:
    """An object around the person, or a step of the ground."""

    def __init__(self, scene: Scene, body: int, vertices: Array, faces: Array, colour: Array):
        self.scene, self.body, self.vertices = scene, body, vertices
        self.faces: Int[Array, "n 3"] = faces
        self.colours = np.tile(colour, (len(faces), 1))

    def __call__(self, frame: int) -> _Triangles:
        """Return its triangles in a frame."""
        turn = rotation_matrix(self.scene.quats[frame, self.body])
        places = self.vertices @ turn.T + self.scene.positions[frame, self.body]
        return _Triangles(places[self.faces], self.colours)


def _things(scene: Scene, bodies: int) -> list[_Solid]:
    """Return objects drawn in addition to the person."""
    found = []
    for shape in scene.shapes:
        if 0 < shape.body < bodies:
            continue
        solid = surface_of(shape)
        colour = np.array(shape.paint)
        found.append(_Solid(scene, shape.body, solid.vertices, solid.faces, colour))
    return found


def _draw_ground(drawing: Any, scene: Scene, centre: Array, placed: Any) -> None:
    """Draw the squares of the ground about the body, fixed to the world."""
    axes, height = scene.ground.to_world, scene.ground.height
    middle = np.round((centre @ axes)[:2] / SQUARE_SIZE)
    places = np.arange(-N_SQUARES, N_SQUARES + 1)
    for along in (0, 1):
        for place in places:
            ends = np.full((2, 3), float(height))
            ends[:, along] = (middle[along] + place) * SQUARE_SIZE
            ends[:, 1 - along] = (middle[1 - along] + places[[0, -1]]) * SQUARE_SIZE
            line = placed(ends @ axes.T).ravel().tolist()
            drawing.line(line, fill=theme.GRID, width=SUPERSAMPLING)


def _draw_forces(drawing: Any, scene: Scene, frame: int, placed: Any, width: int) -> None:
    """Draw the ground reaction of each side as a line from its centre of pressure."""
    if scene.total_force is None or scene.cop is None:
        return
    for row, colour in enumerate(theme.BY_SIDE):
        start = scene.cop[frame, row]
        if not np.isfinite(start).all():
            continue
        end = start + ARROW_LENGTH * scene.total_force[frame, row] / scene.weight
        drawing.line(placed(np.array([start, end])).ravel().tolist(), fill=colour, width=width)
