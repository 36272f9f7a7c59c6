"""The tree of an OpenSim model as MJCF."""

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from plantigrade.io.osim import OsimJoint, OsimModel
from plantigrade.io.osim_root import root_pose
from plantigrade.io.osim_tree import OsimLink
from plantigrade.models.mjcf import add_shapes, numbers
from plantigrade.models.parts import Inertia, SoleSphere, Solid
from plantigrade.models.skeleton import Body, Hinge
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD as W
from plantigrade.spatial.conventions import rotation_quaternion

MIN_MASS, MIN_INERTIA = 1e-6, 1e-9  # [kg, kg m²] of massless bodies, for MuJoCo's mass matrix


def osim_mjcf(
    osim: OsimModel,
    root: OsimJoint,
    links: Sequence[OsimLink],
    solids: Mapping[str, tuple[Solid, ...]],
    spheres: Mapping[str, tuple[SoleSphere, ...]],
) -> tuple[str, list[str]]:
    """Return the MJCF text, and the bodies in the order of MuJoCo."""
    document = ET.Element("mujoco", model="osim")
    settings = {"angle": "radian", "autolimits": "true", "balanceinertia": "true"}
    ET.SubElement(document, "compiler", settings, inertiagrouprange="5 5")
    option = {"gravity": f"0 0 {-osim.gravity}", "timestep": "0.001", "integrator": "implicitfast"}
    ET.SubElement(document, "option", option, jacobian="dense")
    world = ET.SubElement(document, "worldbody")
    floor = {"name": "floor", "type": "plane", "size": "20 20 0.1", "rgba": "0.92 0.92 0.90 1"}
    ET.SubElement(world, "geom", floor, contype="0", conaffinity="1")
    elements = {"": world}
    for link in links:
        where = {"pos": numbers(link.position), "quat": numbers(rotation_quaternion(link.rotation))}
        element = ET.SubElement(elements[link.parent], "body", {"name": link.name, **where})
        elements[link.name] = element
        if not link.parent:
            ET.SubElement(element, "freejoint", name="root")
        _add_joints(element, link)
        _add_inertial(element, osim, link.name)
        add_shapes(element, body_of(osim, link, solids[link.name], spheres.get(link.name, ())))
    order = [b.get("name", "") for b in world.iter("body")]
    by_name = {link.name: link for link in links}
    values = {c.name: np.array([c.default]) for j in osim.joints for c in j.coordinates}
    key = list(root_pose(root, values, 1)[0])
    for name in order:
        drives = (driven for _, _, driven, _ in by_name[name].joints)
        key += [float(d.function.value(values[d.coordinate])[0]) for d in drives]
    frames = ET.SubElement(document, "keyframe")
    standing = ET.SubElement(frames, "key", name="standing", qpos=numbers(key))
    xml = ET.tostring(document, encoding="unicode")
    low = _lowest(xml, np.array(key), [f"contact_{s.segment}_{s.name}_{b[-1]}"
                                       for b, row in spheres.items() for s in row])  # fmt: skip
    key[2] -= low
    standing.set("qpos", numbers(key))
    ET.indent(document)
    return ET.tostring(document, encoding="unicode"), order


def _lowest(xml: str, qpos: np.ndarray, spheres: list[str]) -> float:
    """Return the lowest point of the soles [m]; zero without feet."""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos = qpos
    mujoco.mj_kinematics(model, data)
    heights = [data.geom(n).xpos[2] - model.geom(n).size[0] for n in spheres]
    return float(min(heights, default=0.0))


def body_of(
    osim: OsimModel, link: OsimLink, solids: tuple[Solid, ...], spheres: tuple[SoleSphere, ...]
) -> Body:
    """Return a link with mass properties and shapes."""
    segment = osim.segments[link.name]
    inertia = Inertia(segment.mass, W @ segment.com, W @ segment.inertia @ W.T)
    hinges = tuple(
        Hinge(driven.name, axis, float(low), float(high), (-np.inf, np.inf))
        for _, axis, driven, (low, high) in link.joints
        if driven.own
    )
    return Body(link.name, link.parent, link.position, hinges, inertia, solids, spheres)


def _add_inertial(element: ET.Element, model: OsimModel, name: str) -> None:
    """Add the mass properties of a body in our axes."""
    segment = model.segments[name]
    i = W @ segment.inertia @ W.T
    i[np.diag_indices(3)] = np.maximum(np.diag(i), MIN_INERTIA)
    six = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    mass = max(segment.mass, MIN_MASS)
    at = {"pos": numbers(W @ segment.com), "mass": numbers([mass])}
    ET.SubElement(element, "inertial", at, fullinertia=numbers(six))


def _add_joints(element: ET.Element, link: OsimLink) -> None:
    """Add the joints of a body."""
    for kind, axis, driven, (low, high) in link.joints:
        at = {"name": driven.name, "type": kind, "axis": numbers(axis), "pos": numbers(link.anchor)}
        limits = {"range": numbers([low, high]), "actuatorfrcrange": "-1000 1000"}
        ET.SubElement(element, "joint", {**at, **limits})
