"""Write a skeleton as MJCF with explicit inertials, which every reader interprets alike."""

from collections.abc import Callable, Mapping
from typing import TypeVar
from xml.etree import ElementTree as ET

import numpy as np

from plantigrade.constants import FRICTION, GRAVITY
from plantigrade.models.parts import Inertia, Solid
from plantigrade.models.skeleton import Body, Skeleton
from plantigrade.side_names import split_side

_T = TypeVar("_T")
_COLOURS = {"r": "0.80 0.36 0.30 1", "l": "0.27 0.47 0.72 1", "": "0.78 0.74 0.68 1"}
_TOUCH = {"condim": "3", "friction": f"{FRICTION} 0.005 0.0001"}


def to_mjcf(
    name: str, skeleton: Skeleton, *, pelvis_height: float, standing: dict[str, float]
) -> str:
    """Return the MJCF text of a person standing on a plane.

    Only the small spheres of the feet have contact (group 3); the solids (group 1) are visual and
    massless. The free joint is called ``root``; each hinge has the name of its coordinate and an
    actuator-force range from its strength.

    Args:
        pelvis_height: Height of the pelvis frame when standing [m].
        standing: Non-zero coordinates of the key frame ``standing`` [rad].
    """
    root = ET.Element("mujoco", model=name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", inertiagrouprange="5 5")
    option = {"gravity": f"0 0 {-GRAVITY}", "timestep": "0.001", "integrator": "implicitfast"}
    ET.SubElement(root, "option", option, jacobian="dense")
    visual = ET.SubElement(root, "visual")
    ET.SubElement(visual, "headlight", ambient="0.4 0.4 0.4", diffuse="0.5 0.5 0.5")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="2 2 4", dir="-0.4 -0.4 -0.8", diffuse="0.5 0.5 0.5")
    floor = {"name": "floor", "type": "plane", "size": "20 20 0.1"}
    touched = {"contype": "0", "conaffinity": "1", **_TOUCH, "rgba": "0.92 0.92 0.90 1"}
    ET.SubElement(world, "geom", {**floor, **touched})
    elements: dict[str, ET.Element] = {"": world}
    for body in skeleton.bodies:
        elements[body.name] = _body(elements[body.parent], body, pelvis_height)
    hinges = [h.name for b in skeleton.bodies for h in b.hinges]
    key = [0.0, 0.0, pelvis_height, 1.0, 0.0, 0.0, 0.0, *(standing.get(h, 0.0) for h in hinges)]
    frames = ET.SubElement(root, "keyframe")
    ET.SubElement(frames, "key", name="standing", qpos=numbers(key))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def read_mjcf(read: Callable[[str], _T], xml: str) -> _T:
    """Return ``read(xml)``, where ``xml`` may hold a long list of numbers, as a height field does.

    MuJoCo looks at ``errno`` after such a list. The C library sets it when the heap cannot grow in
    place, although the memory then comes from elsewhere; a second reading finds that memory.
    """
    try:
        return read(xml)
    except ValueError as error:
        if "unknown error in attribute" not in str(error):
            raise
    return read(xml)


def with_sites(xml: str, sites: Mapping[str, tuple[str, np.ndarray]]) -> str:
    """Return the MJCF text with points fixed to bodies as visual sites (group 4).

    Args:
        sites: Name → body and position in its frame [m]; every body must exist.
    """
    if not sites:
        return xml
    root = ET.fromstring(xml)
    bodies = {b.get("name"): b for b in root.iter("body")}
    look = {"size": "0.007", "group": "4", "rgba": "0.95 0.80 0.20 1"}
    for name, (body, position) in sites.items():
        ET.SubElement(bodies[body], "site", {"name": name, "pos": numbers(position), **look})
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def with_contact_heights(xml: str, offsets: Mapping[str, float]) -> str:
    """Return the MJCF text with contact spheres moved along the vertical of their segment.

    Args:
        offsets: Geom name → upward displacement of its centre [m]; negative for a thicker sole.
    """
    root = ET.fromstring(xml)
    for geom in root.iter("geom"):
        offset = offsets.get(geom.get("name", ""))
        if offset is not None:
            place = np.array([float(v) for v in geom.get("pos", "0 0 0").split()])
            geom.set("pos", numbers(place + [0.0, 0.0, offset]))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def with_gravity(xml: str, gravity: float) -> str:
    """Return the MJCF text with another gravity [m/s²], along -z."""
    root = ET.fromstring(xml)
    for option in root.iter("option"):
        option.set("gravity", f"0 0 {-gravity}")
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def with_inertia(xml: str, body: str, inertia: Inertia) -> str:
    """Return the MJCF text with other mass properties of a body."""
    root = ET.fromstring(xml)
    for inertial in root.iterfind(f".//body[@name='{body}']/inertial"):
        inertial.attrib.update(_inertial(inertia))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _inertial(inertia: Inertia) -> dict[str, str]:
    """Return the attributes of ``<inertial>``."""
    i = inertia.tensor
    return {
        "pos": numbers(inertia.com),
        "mass": numbers([inertia.mass]),
        "fullinertia": numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]),
    }


def _body(parent: ET.Element, body: Body, pelvis_height: float) -> ET.Element:
    position = body.position if body.parent else np.array([0.0, 0.0, pelvis_height])
    element = ET.SubElement(parent, "body", name=body.name, pos=numbers(position))
    if not body.parent:
        ET.SubElement(element, "freejoint", name="root")
    for hinge in body.hinges:
        axis, limits = numbers(hinge.axis), numbers([hinge.low, hinge.high])
        joint = {"name": hinge.name, "type": "hinge", "axis": axis, "range": limits}
        ET.SubElement(element, "joint", joint, actuatorfrcrange=numbers(hinge.torque))
    ET.SubElement(element, "inertial", _inertial(body.inertia))
    add_shapes(element, body)
    return element


def add_shapes(element: ET.Element, body: Body) -> None:
    """Add the visual solids and the contact spheres of a body."""
    _, side = split_side(body.name)
    drawn = {"group": "1", "contype": "0", "conaffinity": "0", "rgba": _COLOURS[side]}
    for solid in body.solids:
        ET.SubElement(element, "geom", {**_shape(solid), **drawn})
    touching = {"group": "3", "contype": "1", "conaffinity": "0", **_TOUCH, "rgba": "0.2 0.2 0.2 1"}
    for name, contact in zip(body.contact_names, body.contacts, strict=True):
        size, pos = numbers([contact.radius]), numbers(contact.position)
        sphere = {"name": name, "type": "sphere", "size": size, "pos": pos}
        ET.SubElement(element, "geom", {**sphere, **touching})


def _shape(solid: Solid) -> dict[str, str]:
    if solid.kind == "capsule":
        ends = numbers([*solid.a, *solid.b])
        return {"type": "capsule", "fromto": ends, "size": numbers([solid.radius])}
    return {"type": solid.kind, "pos": numbers(solid.a), "size": numbers(solid.b)}


def numbers(values) -> str:
    """Return numbers in MJCF format with full precision."""
    return " ".join(f"{float(v) + 0.0:.17g}" for v in values)
