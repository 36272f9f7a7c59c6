"""glTF 2.0 in one binary file: accessors, nodes, meshes, a skin and an animation.

Only what an exported run needs, after the specification (Khronos, glTF 2.0, sections 3 and 4).
Positions of meshes and nodes are in metres; below a node of rotation :data:`Y_UP` they are in our
axes (x forward, y left, z up), outside it in those of the format (x left, y up, z forward).
"""

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float, Int

Y_UP = [-0.5, -0.5, -0.5, 0.5]
"""Rotation ``xyzw`` that turns our axes to those of the format."""

# Codes of the format: types of numbers, uses of a buffer, shapes of an element.
FLOAT, BYTE, SHORT, LONG = 5126, 5121, 5123, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {(1,): "SCALAR", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}
NUMBERS = {"<f4": FLOAT, "u1": BYTE, "<u2": SHORT, "<u4": LONG}


@dataclass
class Document:
    """A file under construction: its JSON document and the bytes beside it."""

    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    skins: list[dict[str, Any]] = field(default_factory=list)
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    content: bytearray = field(default_factory=bytearray)
    clock: int = -1

    def accessor(
        self,
        values: Array,
        form: str = "<f4",
        *,
        target: int | None = None,
        extent: bool = False,
        normalized: bool = False,
    ) -> int:
        """Add an array of scalars, vectors or matrices (columns first) and return its index.

        Args:
            form: Type of the numbers: ``"<f4"``, ``"u1"``, ``"<u2"`` or ``"<u4"``.
            target: :data:`VERTICES` or :data:`INDICES` for arrays of a mesh.
            extent: Whether least and greatest values are named.
            normalized: Whether whole numbers stand for 0 to 1.
        """
        array = np.ascontiguousarray(values, dtype=form)
        array = array.reshape(len(array), *(array.shape[1:] or (1,)))
        self.content += b"\0" * (-len(self.content) % 4)
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": array.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.content += array.tobytes()
        entry: dict[str, Any] = {"bufferView": len(self.views) - 1, "componentType": NUMBERS[form]}
        entry |= {"count": len(array), "type": KINDS[array.shape[1:]]}
        if extent:
            entry |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        self.accessors.append(entry | ({"normalized": True} if normalized else {}))
        return len(self.accessors) - 1

    def node(self, name: str, **properties: Any) -> int:
        """Add a node and return its index."""
        self.nodes.append({"name": name, **properties})
        return len(self.nodes) - 1

    def material(self, name: str, colour: Sequence[float]) -> int:
        """Add a dull material of a colour (red, green, blue in 0–1, sRGB) and return its index."""
        linear = [_linear(part) for part in colour]
        surface = {"metallicFactor": 0.0, "roughnessFactor": 0.8, "baseColorFactor": [*linear, 1.0]}
        self.materials.append({"name": name, "pbrMetallicRoughness": surface})
        return len(self.materials) - 1

    def mesh(self, name: str, surfaces: "Sequence[tuple[GltfSurface, int]]") -> int:
        """Add a mesh of surfaces with their materials and return its index."""
        primitives = []
        for surface, material in surfaces:
            attributes = {
                "POSITION": self.accessor(surface.vertices, target=VERTICES, extent=True),
                "NORMAL": self.accessor(surface.normals, target=VERTICES),
            }
            if surface.bones is not None and surface.weights is not None:
                attributes["JOINTS_0"] = self.accessor(surface.bones, "u1", target=VERTICES)
                attributes["WEIGHTS_0"] = self.accessor(
                    surface.weights, "u1", target=VERTICES, normalized=True
                )
            form = "<u2" if len(surface.vertices) < 65535 else "<u4"
            indices = self.accessor(surface.faces.ravel(), form, target=INDICES)
            entry = {"attributes": attributes, "indices": indices, "material": material}
            primitives.append(entry)
        self.meshes.append({"name": name, "primitives": primitives})
        return len(self.meshes) - 1

    def animate(self, node: int, path: str, values: Float[Array, "n_frames width"]) -> None:
        """Move a node: its ``translation``, ``rotation`` or ``scale`` over the clock.

        Constant values are written into the node itself.
        """
        rest = [float(v) for v in np.asarray(values[0], dtype="<f4")]
        if np.ptp(values, axis=0).max() < 1e-7:
            if rest != {"scale": [1.0] * 3, "rotation": [0.0, 0.0, 0.0, 1.0]}.get(path, [0.0] * 3):
                self.nodes[node][path] = rest
            return
        self.nodes[node][path] = rest
        output = self.accessor(values)
        self.samplers.append({"input": self.clock, "output": output, "interpolation": "LINEAR"})
        target = {"node": node, "path": path}
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def glb(self, scene: Sequence[int], *, title: str) -> bytes:
        """Return the file."""
        from plantigrade import __version__

        self.content += b"\0" * (-len(self.content) % 4)
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"plantigrade {__version__}"},
            "scene": 0,
            "scenes": [{"name": title, "nodes": list(scene)}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "skins": self.skins,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.content)}],
        }
        if self.channels:
            animation = {"name": title, "samplers": self.samplers, "channels": self.channels}
            document["animations"] = [animation]
        document = {key: value for key, value in document.items() if value != []}
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(self.content)
        parts = [struct.pack("<4sII", b"glTF", 2, length)]
        for kind, part in ((b"JSON", text), (b"BIN\0", bytes(self.content))):
            parts += [struct.pack("<I4s", len(part), kind), part]
        return b"".join(parts)


@dataclass(frozen=True)
class GltfSurface:
    """Triangles with normals, and the bones that move them."""

    vertices: Float[Array, "n_vertices 3"]  #: Places [m]
    normals: Float[Array, "n_vertices 3"]  #: Unit vectors out of the surface
    faces: Int[Array, "n_faces 3"]  #: Corners of each triangle, counter-clockwise seen from outside
    #: Four bones of each vertex; None where nothing moves it
    bones: Int[Array, "n_vertices 4"] | None = None
    weights: Int[Array, "n_vertices 4"] | None = None  #: Their shares in 255ths, 255 in all


def surface(
    vertices: Float[Array, "n_vertices 3"], faces: Int[Array, "n_faces 3"], *, flat: bool = False
) -> GltfSurface:
    """Return a closed surface with its normals; ``flat`` keeps its edges sharp.

    Faces of a surface that lists them from inside are turned.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    if np.einsum("ij,ij->", a - vertices.mean(axis=0), np.cross(b - a, c - a)) < 0:
        faces = faces[:, ::-1]
    if flat:
        vertices, faces = vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3)
    return GltfSurface(vertices, normals_of(vertices, faces), faces)


def normals_of(
    vertices: Float[Array, "n_vertices 3"], faces: Int[Array, "n_faces 3"]
) -> Float[Array, "n_vertices 3"]:
    """Return unit normals at vertices: means of the triangles about them, weighted by area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    found = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(found, faces[:, k], across)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])  # where no triangle has an area
    return np.where(length > 1e-12, found / np.maximum(length, 1e-12), up)


def together(surfaces: Sequence[GltfSurface]) -> GltfSurface:
    """Return several surfaces as one."""
    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces[:-1])])
    faces = np.concatenate([s.faces + k for s, k in zip(surfaces, starts, strict=True)])

    def joined(name: str) -> Any:
        parts = [getattr(s, name) for s in surfaces]
        return None if parts[0] is None else np.concatenate(parts)

    return GltfSurface(
        joined("vertices"), joined("normals"), faces, joined("bones"), joined("weights")
    )


def _linear(part: float) -> float:
    """Return a part of a colour as light: the inverse of sRGB's transfer function."""
    return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
