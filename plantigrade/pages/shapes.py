"""Visual geoms of a body, as meshes and as outlines."""

from collections.abc import Collection
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.charts import theme
from plantigrade.side_names import side_of

_KINDS = {
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{name.upper()}")): "mesh" if name == "hfield" else name
    for name in ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "hfield")
}
WHITE_SHARE = 0.55  # share of white in paler shapes
GROUND = ("floor", "bump", "relief")
"""Prefixes of the ground's geoms in :mod:`plantigrade.contact.scene`."""
PLATE = "floor_plate"  # Name of the geom of moving ground, as in :mod:`plantigrade.world.platform`
SCENE_OBJECT = "thing"  # Prefix of scene objects
RIM_TONE, SHADE_TONE = 0.62, 0.84
"""Factors of a colour: of the rim, and of shade. Chosen."""


@dataclass(frozen=True)
class Shape:
    """One visual geom, fixed to a body."""

    #: ``"sphere"``, ``"capsule"``, ``"ellipsoid"``, ``"cylinder"``, ``"box"``, ``"mesh"``
    kind: str
    size: Float[Array, " 3"]  #: MuJoCo's sizes: radius, half length, half axes [m]
    position: Float[Array, " 3"]  #: In the body's frame [m]
    quat: Float[Array, " 4"]  #: Rotation into the body's frame, ``wxyz``
    #: Red, green, blue in 0–1; None where the side's colour is to be used (sided bodies) or the
    #: model sets none
    colour: tuple[float, float, float] | None
    body: int  #: Index of the body
    body_name: str  #: Name of the body
    #: Vertices of a mesh, in the shape's frame [m]
    vertices: Float[Array, "n_vertices 3"] | None = None
    faces: Int[Array, "n_faces 3"] | None = None  #: Faces of a mesh
    name: str = ""  #: Name of the geom
    pale: bool = False  #: Whether it is drawn paler, because its motion is assumed

    @property
    def side(self) -> str | None:
        """``"r"``, ``"l"`` or None for the middle."""
        return side_of(self.body_name)

    @property
    def is_ground(self) -> bool:
        """Whether it is ground: a tread, a bump or relief."""
        return self.body == 0 and self.name.startswith(GROUND)

    @property
    def is_plate(self) -> bool:
        """Whether it is moving ground."""
        return self.name == PLATE

    @property
    def is_scene_object(self) -> bool:
        """Whether it is a scene object: a bar, a box, a pack."""
        return self.name.startswith(SCENE_OBJECT)

    @property
    def shade(self) -> float:
        """Brightness; every other tread is darker, so that edges are visible."""
        number = self.name.rpartition("_")[2]
        return 0.94 if self.is_ground and number.isdigit() and int(number) % 2 else 1.0

    @property
    def paint(self) -> tuple[float, float, float]:
        """Red, green and blue in 0–1 for both viewers."""
        if self.is_ground:
            red, green, blue = rgb(theme.FLOOR)
            return red * self.shade, green * self.shade, blue * self.shade
        sides = {"r": theme.RIGHT_BODY, "l": theme.LEFT_BODY}
        colour = self.colour or rgb(sides.get(self.side or "", theme.BODY))
        return whiter(colour, WHITE_SHARE if self.pale else 0.0)


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green and blue in 0–1 of a colour in hexadecimal.

    Example:
        >>> rgb("#ff0033")
        (1.0, 0.0, 0.2)
    """
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def whiter(colour: tuple[float, float, float], share: float) -> tuple[float, float, float]:
    """Return red, green and blue in 0–1 mixed with a share of white."""
    red, green, blue = (part + (1 - part) * share for part in colour)
    return red, green, blue


def hexadecimal(colour: tuple[float, float, float]) -> str:
    """Return a colour of red, green and blue in 0–1 as CSS writes it.

    Example:
        >>> hexadecimal((1.0, 0.0, 0.2))
        '#ff0033'
    """
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour)


def shapes_of(model: mujoco.MjModel, pale: Collection[str] = ()) -> tuple[Shape, ...]:
    """Return the visual geoms (MuJoCo's groups 0 to 2, without planes).

    Those of the bodies ``pale`` are drawn paler.
    """
    shapes = []
    for g in range(model.ngeom):
        kind = _KINDS.get(int(model.geom_type[g]))
        rgba = model.geom_rgba[g]
        if model.geom_matid[g] >= 0:
            rgba = model.mat_rgba[model.geom_matid[g]]
        if kind is None or model.geom_group[g] > 2 or rgba[3] == 0:
            continue
        body = int(model.geom_bodyid[g])
        sided = side_of(model.body(body).name) is not None
        default = sided or bool(np.allclose(rgba[:3], 0.5))
        vertices, faces = _mesh(model, g) if kind == "mesh" else (None, None)
        shapes.append(
            Shape(
                kind=kind,
                size=np.array(model.geom_size[g], dtype=float),
                position=np.array(model.geom_pos[g], dtype=float),
                quat=np.array(model.geom_quat[g], dtype=float),
                colour=None if default else (float(rgba[0]), float(rgba[1]), float(rgba[2])),
                body=body,
                body_name=model.body(body).name,
                vertices=vertices,
                faces=faces,
                name=model.geom(g).name,
                pale=model.body(body).name in pale,
            )
        )
    return tuple(shapes)


def foot_bodies(model: mujoco.MjModel, side: str) -> Bool[Array, " nbody"]:
    """Return which bodies belong to the foot of ``side``, distal to the ankle joint."""
    inside = np.zeros(model.nbody, dtype=bool)
    roots = [
        int(model.jnt_bodyid[j])
        for j in range(model.njnt)
        if "ankle" in model.joint(j).name and side_of(model.joint(j).name) == side
    ]
    words = ("foot", "calc", "talus", "toe", "heel", "meta", "phal")
    for body in range(1, model.nbody):
        name = model.body(body).name
        by_name = not roots and side_of(name) == side and any(w in name.lower() for w in words)
        inside[body] = body in roots or by_name or inside[model.body_parentid[body]]
    return inside


def mesh_of(shape: Shape, *, around: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices [m] and faces of a shape, in its own frame, with polygons for circles."""
    if shape.vertices is not None and shape.faces is not None:
        return shape.vertices, shape.faces
    x, y, z = shape.size
    if shape.kind == "box":
        corners = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)])
        quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        faces = [[a, b, c] for a, b, c, _ in quads] + [[a, c, d] for a, _, c, d in quads]
        return corners, np.array(faces)
    tilt = np.linspace(-np.pi / 2, np.pi / 2, around // 2 + 1)
    if shape.kind == "cylinder":
        profile = np.array([[0, -y], [x, -y], [x, y], [0, y]])
        scale = np.ones(3)
    elif shape.kind == "capsule":
        low, high = tilt[tilt <= 1e-9], tilt[tilt >= -1e-9]
        ends = [
            np.stack([x * np.cos(a), x * np.sin(a) + s * y], 1) for a, s in ((low, -1), (high, 1))
        ]
        profile, scale = np.concatenate(ends), np.ones(3)
    else:
        profile = np.stack([np.cos(tilt), np.sin(tilt)], axis=1)
        scale = np.full(3, x) if shape.kind == "sphere" else np.asarray(shape.size)
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)
    rows = len(profile)
    vertices = np.stack(
        [
            np.outer(np.cos(turn), profile[:, 0]),
            np.outer(np.sin(turn), profile[:, 0]),
            np.tile(profile[:, 1], (around, 1)),
        ],
        axis=2,
    ).reshape(-1, 3)
    a = (rows * np.arange(around)[:, None] + np.arange(rows - 1)).ravel()
    b = (a + rows) % len(vertices)
    return vertices * scale, np.stack([a, b, a + 1, a + 1, b, b + 1], axis=1).reshape(-1, 3)


def surface_points(shape: Shape) -> np.ndarray:
    """Return points on the geom, in its frame, whose hull is (nearly) the geom [m]."""
    return mesh_of(shape, around=24)[0]


def convex_hull(points: np.ndarray) -> np.ndarray:
    """Return the convex hull of points in a plane, in order (Andrew's monotone chain)."""
    ordered = np.unique(np.round(points, 6), axis=0)
    if len(ordered) < 3:
        return ordered

    def chain(rows):
        kept: list[np.ndarray] = []
        for p in rows:
            while len(kept) > 1:
                a, b = kept[-2], kept[-1]
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0:
                    break
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _mesh(model, geom):
    """Return vertices and faces of a mesh or height field, in the geom's frame."""
    if int(model.geom_type[geom]) == int(mujoco.mjtGeom.mjGEOM_MESH):
        mesh = int(model.geom_dataid[geom])
        v0, nv = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        f0, nf = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        vertices, faces = model.mesh_vert[v0 : v0 + nv], model.mesh_face[f0 : f0 + nf]
        return np.array(vertices, dtype=float), np.array(faces, dtype=int)
    field = int(model.geom_dataid[geom])
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    start = int(model.hfield_adr[field])
    half_x, half_y, height, _ = model.hfield_size[field]
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    z = np.array(model.hfield_data[start : start + rows * columns], dtype=float) * height
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + columns], axis=1)
    upper = np.stack([corner + 1, corner + columns + 1, corner + columns], axis=1)
    return np.stack([x.ravel(), y.ravel(), z], axis=1), np.concatenate([lower, upper])


def two_tones(
    name: str, colour: tuple[float, float, float], light: Float[Array, " 2"], *, far: float = 1.0
) -> tuple[str, str, str]:
    """Return the clip of an outline, the outline in shade, and its lit tone, moved and clipped."""
    return (
        f'<clipPath id="{name}c"><use href="#{name}"/></clipPath>',
        f'<use href="#{name}" fill="{tone(colour, SHADE_TONE * far)}"/>',
        f'<g clip-path="url(#{name}c)"><use href="#{name}" fill="{tone(colour, far)}" '
        f'transform="translate({light[0]:.0f} {light[1]:.0f})"/></g>',
    )


def tone(colour: tuple[float, float, float], factor: float) -> str:
    """Return a colour in 0-1, times a factor, as CSS writes it."""
    red, green, blue = (min(1.0, factor * part) for part in colour)
    return hexadecimal((red, green, blue))
