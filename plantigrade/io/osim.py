"""OpenSim models (``.osim``, versions 3 and 4) as they are in the file: axes x forward, y up.

Read are bodies, joints, coordinates, couplers and markers. Muscles, other forces, wrapping surfaces
and shapes are counted and left out. A coordinate that a CoordinateCouplerConstraint ties to another
is none of its own: its axes become functions of the other.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import STANDARD_GRAVITY
from plantigrade.errors import FileError
from plantigrade.io.osim_functions import Function, numbers, read_function
from plantigrade.io.text import read_text

GROUND = "ground"  # name of the world in every model
MAX_BYTES = 50e6  # of a file [bytes]; models with wrapped muscles have some megabytes
MAX_NESTING = 20  # offset frames on one another; a frame on itself has no end
FIRST_VERSION = 30000  # of the file format; older ones have other joints

X, Y, Z = np.eye(3)
# Axes of the joints without a table of their own: translations first, then rotations, each with
# the number of its coordinate.
_SLIDES, _TURNS = ((3, X), (4, Y), (5, Z)), ((0, X), (1, Y), (2, Z))
_SIMPLE: dict[str, tuple[tuple, tuple]] = {
    "WeldJoint": ((), ()),
    "PinJoint": ((), ((0, Z),)),
    "SliderJoint": (((0, X),), ()),
    "UniversalJoint": ((), _TURNS[:2]),
    "GimbalJoint": ((), _TURNS),
    "BallJoint": ((), _TURNS),
    "PlanarJoint": (((1, X), (2, Y)), ((0, Z),)),
    "FreeJoint": (_SLIDES, _TURNS),
}


@dataclass(frozen=True)
class BodyFrame:
    """A frame fixed to a body."""

    body: str  #: Name of the body
    position: Float[Array, " 3"]  #: Origin in the body's frame [m]
    rotation: Float[Array, "3 3"]  #: Maps its axes to the body's


@dataclass(frozen=True)
class OsimCoordinate:
    """One coordinate of a joint."""

    name: str
    default: float  #: Value [rad, m]
    low: float  #: Lower end of its range
    high: float  #: Upper end
    locked: bool  #: Whether it keeps its default
    clamped: bool  #: Whether it stays in its range


@dataclass(frozen=True)
class Axis:
    """A translation along an axis of the parent frame, or a rotation about it."""

    name: str  #: Name of the joint and of the axis
    slides: bool  #: Whether it translates
    direction: Float[Array, " 3"]  #: Unit vector
    coordinate: str | None  #: The coordinate that drives it
    function: Function  #: Value [rad, m] by that coordinate


@dataclass(frozen=True)
class OsimJoint:
    """A joint: translations first, then rotations, each about the axes moved by those before."""

    name: str
    parent: BodyFrame
    child: BodyFrame
    axes: tuple[Axis, ...]
    coordinates: tuple[OsimCoordinate, ...]


@dataclass(frozen=True)
class SegmentMass:
    """Mass properties of a body."""

    name: str
    mass: float  #: [kg]
    com: Float[Array, " 3"]  #: Centre of mass [m]
    inertia: Float[Array, "3 3"]  #: About the centre of mass, axes of the body [kg m²]


@dataclass(frozen=True)
class OsimModel:
    """What is read of an OpenSim model."""

    name: str
    segments: dict[str, SegmentMass]  #: Bodies by name, without the ground
    joints: tuple[OsimJoint, ...]
    markers: dict[str, BodyFrame]  #: Marker name → its place
    gravity: float  #: [m/s²]
    coupled: tuple[str, ...]  #: Coordinates tied to others
    left_out: dict[str, int]  #: Kind of force or constraint → how many were left out


def read_osim(path: str | Path) -> OsimModel:
    """Read an OpenSim model.

    Raises:
        FileError: If it cannot be read, or has joints or functions that are not read.
    """
    return parse_osim(read_text(Path(path), MAX_BYTES), path)


def parse_osim(text: str, path: str | Path = "model.osim") -> OsimModel:
    """Return the model of an OpenSim text; ``path`` is named in errors."""
    remedy = "export it again from OpenSim 3 or 4"
    try:
        root = ET.fromstring(text.lstrip("\ufeff").strip())
    except (ET.ParseError, ValueError) as error:
        raise FileError(path, f"is not an XML file: {error}", remedy=remedy) from error
    model = root.find("Model")
    if root.tag != "OpenSimDocument" or model is None:
        raise FileError(path, "is not an OpenSim model", remedy="name an .osim file")
    version = root.get("Version", "")
    if not version.isdigit() or int(version) < FIRST_VERSION:
        problem = f"has file version {version[:20]!r}"
        raise FileError(path, problem, remedy="open it in OpenSim 4 and save it again")
    try:
        return _model(model)
    except (ValueError, OverflowError, np.linalg.LinAlgError) as error:
        raise FileError(path, str(error), remedy=remedy) from error


def _model(model: ET.Element) -> OsimModel:
    segments = {_named(b): _segment(b) for b in model.iterfind("BodySet/objects/Body")}
    segments.pop(GROUND, None)
    frames = _Frames(model, set(segments))
    joints = [_joint4(j, frames) for j in model.iterfind("JointSet/objects/*")]
    for body in model.iterfind("BodySet/objects/Body"):
        joints += [_joint3(j, _named(body)) for j in body.iterfind("Joint/*")]
    if not joints:
        raise ValueError("the model has no joints")
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end.body not in segments and end.body != GROUND:
                raise ValueError(f"joint {joint.name} is on {end.body!r}, which is no body")
    ties = dict(map(_tie, model.iterfind("ConstraintSet/objects/CoordinateCouplerConstraint")))
    markers = {}
    for node in model.iterfind("MarkerSet/objects/Marker"):
        at = frames.find(node.findtext("socket_parent_frame") or node.findtext("body") or "")
        place = at.position + at.rotation @ numbers(node, "location", 3)
        markers[_named(node)] = replace(at, position=place)
    constraints = (n.tag for n in model.iterfind("ConstraintSet/objects/*"))
    forces = (n.tag for n in model.iterfind("ForceSet/objects/*"))
    gravity = (
        numbers(model, "gravity", 3) if model.find("gravity") is not None else -STANDARD_GRAVITY * Y
    )
    return OsimModel(
        model.get("name", "model"),
        segments,
        tuple(_tied(joint, ties) for joint in joints),
        markers,
        float(np.linalg.norm(gravity)),
        tuple(ties),
        dict(Counter([*forces, *(c for c in constraints if c != "CoordinateCouplerConstraint")])),
    )


def _segment(node: ET.Element) -> SegmentMass:
    if node.find("inertia") is not None:
        xx, yy, zz, xy, xz, yz = numbers(node, "inertia", 6)
    else:
        tags = ("xx", "yy", "zz", "xy", "xz", "yz")
        xx, yy, zz, xy, xz, yz = (numbers(node, f"inertia_{t}", 1, 0.0)[0] for t in tags)
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass = float(numbers(node, "mass", 1, 0.0)[0])
    if mass < 0:
        raise ValueError(f"body {_named(node)} has a mass of {mass:g} kg")
    return SegmentMass(_named(node), mass, numbers(node, "mass_center", 3, 0.0), tensor)


class _Frames:
    """Frames by the path that a socket names."""

    def __init__(self, model: ET.Element, bodies: set[str]):
        self.bodies = bodies
        self.offsets = {_named(n): n for n in model.iter("PhysicalOffsetFrame")}

    def find(
        self, path: str, own: dict[str, ET.Element] | None = None, depth: int = 0
    ) -> BodyFrame:
        """Return the frame at the end of a path; ``own`` are the frames of the joint itself."""
        name = path.strip().rpartition("/")[2]
        node = (own or {}).get(name)
        if node is None and (name in self.bodies or name == GROUND):
            return BodyFrame(name, np.zeros(3), np.eye(3))
        node = self.offsets.get(name) if node is None else node
        if node is None or depth > MAX_NESTING:
            raise ValueError(f"there is no frame {path.strip()[:60]!r}")
        base = self.find(node.findtext("socket_parent") or "", None, depth + 1)
        return BodyFrame(
            base.body,
            base.position + base.rotation @ numbers(node, "translation", 3, 0.0),
            base.rotation @ rotation_xyz(numbers(node, "orientation", 3, 0.0)),
        )


def _joint4(node: ET.Element, frames: _Frames) -> OsimJoint:
    """Return a joint of version 4."""
    own = {_named(n): n for n in node.iterfind("frames/PhysicalOffsetFrame")}
    parent, child = (
        frames.find(node.findtext(f"socket_{end}_frame") or "", own) for end in ("parent", "child")
    )
    return _joint(node, parent, child, node.iterfind("coordinates/Coordinate"))


def _joint3(node: ET.Element, body: str) -> OsimJoint:
    """Return a joint of version 3, which is part of its child."""
    if (node.findtext("reverse") or "").strip() == "true":
        raise ValueError(f"joint {_named(node)} is reversed, which is not read")
    parent, child = (
        BodyFrame(
            name,
            numbers(node, f"location{end}", 3, 0.0),
            rotation_xyz(numbers(node, f"orientation{end}", 3, 0.0)),
        )
        for name, end in (((node.findtext("parent_body") or "").strip(), "_in_parent"), (body, ""))
    )
    return _joint(node, parent, child, node.iterfind("CoordinateSet/objects/Coordinate"))


def _joint(
    node: ET.Element, parent: BodyFrame, child: BodyFrame, found: Iterable[ET.Element]
) -> OsimJoint:
    coordinates = tuple(_coordinate(each) for each in found)
    name, names = _named(node), [c.name for c in coordinates]
    table = node.find("SpatialTransform")
    if node.tag in _SIMPLE:
        straight, sides = Function.linear(1.0), _SIMPLE[node.tag]
        if len(names) < sum(map(len, sides)):
            raise ValueError(f"joint {name} of kind {node.tag} has {len(names)} coordinates")
        axes = [
            Axis(f"{name}_{names[k]}", kind == 0, direction, names[k], straight)
            for kind, rows in enumerate(sides)
            for k, direction in rows
        ]
    elif node.tag == "CustomJoint" and table is not None:
        nodes = list(table.iterfind("TransformAxis"))
        nodes.sort(key=lambda n: not _named(n).startswith("translation"))
        axes = [_axis(each, name, names) for each in nodes]
    else:
        raise ValueError(f"joint {name} is of kind {node.tag[:40]}, which is not read")
    return OsimJoint(name, parent, child, tuple(axes), coordinates)


def _axis(node: ET.Element, joint: str, known: list[str]) -> Axis:
    driven = (node.findtext("coordinates") or "").split()
    plain = ("axis", "coordinates")
    inner = next((child for child in node if child.tag not in plain), None)
    function = Function.linear(0.0) if inner is None else read_function(inner)
    direction = numbers(node, "axis", 3)
    length = float(np.linalg.norm(direction))
    name = f"{joint}_{_named(node)}"
    if len(driven) > 1 or any(c not in known for c in driven) or not length:
        raise ValueError(f"axis {name} needs one coordinate of its joint and a direction")
    if not driven:  # a function of no coordinate keeps its value
        function = Function.linear(0.0, float(function.value(np.zeros(1))[0]))
    slides = _named(node).startswith("translation")
    return Axis(name, slides, direction / length, driven[0] if driven else None, function)


def _coordinate(node: ET.Element) -> OsimCoordinate:
    low, high = numbers(node, "range", 2) if node.find("range") is not None else (-np.inf, np.inf)
    flags = {t: (node.findtext(t) or "").strip() == "true" for t in ("locked", "clamped")}
    default = float(numbers(node, "default_value", 1, 0.0)[0])
    return OsimCoordinate(_named(node), default, float(low), float(high), **flags)


def _tie(node: ET.Element) -> tuple[str, tuple[str, Function]]:
    """Return a dependent coordinate, the one it depends on, and how."""
    others = (node.findtext("independent_coordinate_names") or "").split()
    function = node.find("coupled_coordinates_function")
    dependent = (node.findtext("dependent_coordinate_name") or "").strip()
    if len(others) != 1 or function is None or not dependent:
        raise ValueError(f"constraint {_named(node)} does not tie one coordinate to one other")
    return dependent, (others[0], read_function(function))


def _tied(joint: OsimJoint, ties: dict[str, tuple[str, Function]]) -> OsimJoint:
    """Return the joint with the axes of tied coordinates driven by the others."""

    def followed(axis: Axis) -> Axis:
        for _ in ties:
            if axis.coordinate not in ties:
                break
            other, how = ties[axis.coordinate]
            axis = replace(axis, coordinate=other, function=axis.function.of(how))
        if axis.coordinate in ties:
            raise ValueError(f"the couplers of {axis.coordinate} lead back to itself")
        return axis

    free = tuple(c for c in joint.coordinates if c.name not in ties)
    return replace(joint, axes=tuple(map(followed, joint.axes)), coordinates=free)


def rotation_xyz(angles: Float[Array, " 3"]) -> Float[Array, "3 3"]:
    """Return the rotation by body-fixed angles about x, y and z [rad]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler("XYZ", angles).as_matrix()


def _named(node: ET.Element) -> str:
    name = (node.get("name") or "").strip()
    if not name:
        raise ValueError(f"a {node.tag[:40]} has no name")
    return name
