"""Write a human as an OpenSim model (``.osim``): bodies, joints, coordinates, markers, shapes.

Coordinates have the names and signs of :meth:`~plantigrade.models.Human.to_coordinates`, and a
``.mot`` file of a run moves the model. Each joint is a CustomJoint that turns about the axes of the
hinges in their order. Body frames are ours, in OpenSim's axes (x forward, y up, z right). Muscles,
contact spheres and strengths are left out.
"""

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as ET

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.models.human import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.parts import Inertia, Solid
from plantigrade.models.skeleton import Body
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, PELVIS

VERSION = "40000"  # of the file format; every OpenSim 4 reads it
PELVIS_AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0))  # of tilt, list and rotation, OpenSim's axes
PELVIS_RANGE = (-np.pi, np.pi)  # [rad] of the pelvis angles: any orientation
PLACE_RANGE = (-100.0, 100.0)  # [m] of the pelvis translations: a walkway of 200 m
_LINEAR, _OPAQUE = "1 0", "1"


def to_osim(human: Human, markers: Mapping[str, Attachment] | None = None) -> str:
    """Return the text of the OpenSim 4 model of a person.

    Returns:
        XML text.
    """
    document = ET.Element("OpenSimDocument", Version=VERSION)
    model = ET.SubElement(document, "Model", name=f"human-{human.joints}-{human.feet}")
    _texts(model, length_units="meters", force_units="N", gravity=f"0 {-GRAVITY} 0")
    ET.SubElement(model, "Ground", name="ground")
    bodies, joints, points = (
        ET.SubElement(ET.SubElement(model, kind, name=kind.lower()), "objects")
        for kind in ("BodySet", "JointSet", "MarkerSet")
    )
    for body in human.skeleton.bodies:
        _body(bodies, body)
        _joint(joints, body, human)
    for name, place in (markers or {}).items():
        marker = ET.SubElement(points, "Marker", name=name)
        _texts(marker, socket_parent_frame=f"/bodyset/{place.body}")
        _texts(marker, location=_vector(place.position), fixed="false")
    ET.indent(document)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(document, encoding="unicode")


def _body(parent: ET.Element, body: Body) -> None:
    element = ET.SubElement(parent, "Body", name=body.name)
    frames = ET.SubElement(element, "components")
    for number, solid in enumerate(body.solids):
        _shape(frames, body.name, f"{body.name}_shape_{number + 1}", solid)
    inertia: Inertia = body.inertia
    i = OPENSIM_TO_WORLD.T @ inertia.tensor @ OPENSIM_TO_WORLD
    six = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    _texts(element, mass=_numbers([inertia.mass]), mass_center=_vector(inertia.com))
    _texts(element, inertia=_numbers(six))


def _shape(parent: ET.Element, body: str, name: str, solid: Solid) -> None:
    """Add a visual shape in a frame of its own."""
    capsule = solid.kind == "capsule"
    centre = 0.5 * (solid.a + solid.b) if capsule else solid.a
    along = OPENSIM_TO_WORLD.T @ (solid.b - solid.a) if capsule else np.array([0.0, 1.0, 0.0])
    frame = ET.SubElement(parent, "PhysicalOffsetFrame", name=name)
    geometry = ET.SubElement(frame, "attached_geometry")
    tag = {"capsule": "Cylinder", "box": "Brick", "ellipsoid": "Ellipsoid"}[solid.kind]
    shape = ET.SubElement(geometry, tag, name=f"{name}_geometry")
    _texts(shape, socket_frame="..")
    _texts(ET.SubElement(shape, "Appearance"), opacity=_OPAQUE, color="0.78 0.74 0.68")
    if capsule:
        half = 0.5 * float(np.linalg.norm(along))
        _texts(shape, radius=_numbers([solid.radius]), half_height=_numbers([half]))
    else:  # half sizes have no sign, so only their order changes
        sizes = _numbers(np.abs(OPENSIM_TO_WORLD.T @ solid.b))
        _texts(shape, **{"half_lengths" if solid.kind == "box" else "radii": sizes})
    _texts(frame, socket_parent=f"/bodyset/{body}", translation=_vector(centre))
    _texts(frame, orientation=_numbers(_turn_of_y(along)))


def _turn_of_y(along: Float[Array, " 3"]) -> Sequence[float]:
    """Return body-fixed X-Y-Z angles that turn the y axis into a direction [rad]."""
    x, y, z = along / np.linalg.norm(along)
    about_z = float(np.arcsin(np.clip(-x, -1.0, 1.0)))
    return (float(np.arctan2(z, y)), 0.0, about_z)


def _joint(parent: ET.Element, body: Body, human: Human) -> None:
    root = not body.parent
    above = body.parent or "ground"
    joint = ET.SubElement(parent, "CustomJoint", name=f"{above}_{body.name}" if root else body.name)
    ends = {"parent": f"{above}_offset", "child": f"{body.name}_offset"}
    _texts(joint, **{f"socket_{end}_frame": frame for end, frame in ends.items()})
    coordinates = ET.SubElement(joint, "coordinates")
    turns = [(h.name, OPENSIM_TO_WORLD.T @ h.axis, (h.low, h.high)) for h in body.hinges]
    if root:
        angles = zip(PELVIS[:3], PELVIS_AXES, strict=True)
        turns = [(name, np.array(axis, dtype=float), PELVIS_RANGE) for name, axis in angles]
    names, standing = human.to_coordinates(human.standing()[None])
    values = dict(zip(names, standing[0].tolist(), strict=True))
    rows = [(name, span) for name, _, span in turns]
    rows += [(name, PLACE_RANGE) for name in PELVIS[3:]] if root else []
    for name, span in rows:
        coordinate = ET.SubElement(coordinates, "Coordinate", name=name)
        _texts(coordinate, default_value=_numbers([values[name]]), range=_numbers(span))
        _texts(coordinate, clamped="false" if root else "true", locked="false")
    frames = ET.SubElement(joint, "frames")
    socket = "/ground" if root else f"/bodyset/{above}"
    place = _vector(np.zeros(3) if root else body.position)
    for name, of, at in (
        (ends["parent"], socket, place),
        (ends["child"], f"/bodyset/{body.name}", "0 0 0"),
    ):
        frame = ET.SubElement(frames, "PhysicalOffsetFrame", name=name)
        _texts(frame, socket_parent=of, translation=at, orientation="0 0 0")
    motion = ET.SubElement(joint, "SpatialTransform")
    axes = _completed([axis for _, axis, _ in turns])
    for k, axis in enumerate(axes):
        _axis(motion, f"rotation{k + 1}", axis, turns[k][0] if k < len(turns) else None)
    for k, axis in enumerate(np.eye(3)):
        _axis(motion, f"translation{k + 1}", axis, PELVIS[3 + k] if root else None)


def _completed(axes: list[np.ndarray]) -> list[np.ndarray]:
    """Return three axes: those given, then some that are not in one plane with them."""
    axes = list(axes)
    while len(axes) < 3:
        others = np.array(axes).reshape(-1, 3)
        left = [e - others.T @ np.linalg.pinv(others.T) @ e for e in np.eye(3)]
        best = max(left, key=lambda v: float(np.linalg.norm(v)))
        axes.append(best / np.linalg.norm(best))
    return axes


def _axis(parent: ET.Element, name: str, axis: np.ndarray, coordinate: str | None) -> None:
    element = ET.SubElement(parent, "TransformAxis", name=name)
    _texts(element, coordinates=coordinate or "", axis=_numbers(axis))
    kind = "LinearFunction" if coordinate else "Constant"
    function = ET.SubElement(element, kind, name="function")
    _texts(function, **({"coefficients": _LINEAR} if coordinate else {"value": "0"}))


def _texts(parent: ET.Element, **texts: str) -> None:
    for tag, text in texts.items():
        ET.SubElement(parent, tag).text = text


def _vector(ours: Float[Array, " 3"]) -> str:
    """Return a vector of our axes in OpenSim's."""
    return _numbers(OPENSIM_TO_WORLD.T @ ours)


def _numbers(values) -> str:
    return " ".join(f"{float(v) + 0.0:.12g}" for v in values)
