"""The scene of a motion as MJCF that loads and simulates in plain MuJoCo.

The scene extends :attr:`Human.xml` for simulation: the ground of the motion with its steps, relief
and seats, friction, a motor for every hinge with the Human's torque limits, armature and damping,
and contact between limbs and trunk. Masses and joints keep every digit.

Feet and seats contact the ground with spheres (``contype`` 1). Limbs and trunk contact each other
with *cores* (``contype`` 2, group 4), which are thinner than the drawn shapes because soft tissue
yields. A core has no contact with the two nearest ancestors of its body or with its own foot.

A seat that moves is a ``mocap`` body ``support_0``, …, whose place is how far it has moved:
``data.mocap_pos[:] = ground.shifts(times)[frame]``. The floor stays where it is.

Armature and damping stabilise a simulation; the person has none. Inverse dynamics of a motion
leaves them out, and :func:`motor_forces` adds what the motors of the scene need for them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import GEOM_PREFIX, ContactSite, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.mjcf import numbers
from plantigrade.spatial.conventions import surface_axes

ARMATURE_PER_TORQUE = 1e-4
"""Armature of a hinge per maximum torque [kg m² / (N m)]. Chosen for stability."""
DAMPING_PER_TORQUE = 5e-3  #: Damping of a hinge per maximum torque [s]. Chosen for stability
CORE_SCALE = 0.75  #: Size of a core relative to the drawn shape [1]; no two touch in quiet standing
GROUND_HALF_SIZE = 20.0  #: Extent of the ground from the origin [m]
SEAT_HALF_SIZES = (0.2, 0.2, 0.02)
"""Margin of a seat around its contacts along x and y, and its half thickness [m]."""
BOARD_HALF_SIZES = (0.12, 0.04, 0.015)
"""Half lengths of the board under a single hand: along, across, and half its thickness [m]."""
_STIFF = {"solref": "0.005 1", "condim": "3"}
_CORES = {"group": "4", "contype": "2", "conaffinity": "2", "friction": "0.3 0.005 0.0001"}
_WOOD, _FLOOR = "0.72 0.60 0.45 1", "0.92 0.92 0.90 1"
SHAPES = ("box", "capsule")
"""Shapes of scene objects, with MuJoCo's names."""


@dataclass(frozen=True, eq=False)
class Board:
    """A box that carries a part of the body."""

    centre: Float[Array, " 3"]  #: Its middle, world [m]
    axes: Float[Array, "3 3"]  #: Its axes as columns, the normal last
    half_sizes: tuple[float, float, float]  #: Half of its edges along them [m]


@dataclass(frozen=True)
class SceneObject:
    """An object of simple shape."""

    name: str  #: Name of the object
    kind: str  #: One of :data:`SHAPES`
    #: Half edges of a box; radius and half length of a capsule along z, then zero [m]
    size: tuple[float, float, float]

    def __post_init__(self):
        if self.kind not in SHAPES:
            raise ParameterError(f"a scene object is one of {', '.join(SHAPES)}, not {self.kind!r}")
        if min(self.size) < 0.0 or self.size[0] <= 0.0:
            raise ParameterError(f"sizes of a scene object must not be negative: {self.size}")


def scene_xml(
    human: Human,
    ground: Ground,
    sites: Sequence[ContactSite] = (),
    things: Sequence[tuple[SceneObject, Float[Array, " 7"]]] = (),
) -> str:
    """Return the MJCF text of a person on a ground.

    Args:
        sites: Contact sites; those not on a foot become spheres that contact seats.
        things: Scene objects with their poses, centre [m] and rotation ``wxyz``; they contact
            limbs and trunk.
    """
    root = ET.fromstring(human.xml)
    bodies = {body.get("name"): body for body in root.iter("body")}
    next(root.iter("option")).attrib.update(cone="elliptic", impratio="10")
    feet = {GEOM_PREFIX + site.name for site in contact_sites(human)}
    for geom in root.iter("geom"):
        if geom.get("name") in feet:
            geom.attrib.update(_surface(ground))
    carried = {"group": "3", "contype": "1", "conaffinity": "0", **_surface(ground)}
    for site in sites:
        if not site.side and not site.measured:
            pos, size = numbers(site.position), numbers([site.radius or 0.005])
            sphere = {"name": GEOM_PREFIX + site.name, "type": "sphere", "pos": pos, "size": size}
            ET.SubElement(bodies[site.body], "geom", {**sphere, **carried})
    _replace_floor(root, ground)
    _add_cores(root, human, bodies)
    _add_motors(root, human)
    for i, (thing, pose) in enumerate(things):
        form = {"type": thing.kind, "size": numbers(thing.size), "rgba": _WOOD}
        where = {"name": f"thing_{i}", "pos": numbers(pose[:3]), "quat": numbers(pose[3:])}
        solid = {"contype": "2", "conaffinity": "2", "friction": _CORES["friction"]}
        ET.SubElement(next(root.iter("worldbody")), "geom", {**where, **form, **solid})
    key = next(root.iter("key"))
    qpos = human.standing()
    qpos[2] += _lift(human, ground, qpos)
    key.set("qpos", numbers(qpos))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def motor_forces(
    human: Human,
    torque: Float[Array, "n nv"],
    qvel: Float[Array, "n nv"],
    qacc: Float[Array, "n nv"],
) -> Float[Array, "n nv"]:
    """Return the generalised forces that the motors of a scene must apply for a motion [N m].

    Args:
        torque: Generalised forces of the person, without armature and damping [N m].
    """
    most = np.abs(human.model.jnt_actfrcrange[1:]).max(axis=1)
    out = torque.copy()
    out[:, 6:] += most * (ARMATURE_PER_TORQUE * qacc[:, 6:] + DAMPING_PER_TORQUE * qvel[:, 6:])
    return out


def _surface(ground: Ground) -> dict[str, str]:
    """Return the attributes of contact surfaces."""
    return {**_STIFF, "friction": numbers([ground.friction, 0.005, 0.0001])}


def _replace_floor(root: ET.Element, ground: Ground) -> None:
    """Replace the floor of the person's model by the ground."""
    world = next(root.iter("worldbody"))
    floor = next(g for g in world.findall("geom") if g.get("name") == "floor")
    place = list(world).index(floor)
    world.remove(floor)
    surface = {"contype": "0", "conaffinity": "1", **_surface(ground)}
    still = ground.at_rest.seats
    for i, shape in enumerate((*_treads(ground), *_relief(root, ground), *_seats(still))):
        world.insert(place + i, ET.Element("geom", {**surface, **shape}))
    # After the person, whose bodies keep their numbers.
    for i, group in enumerate(ground.moving_seats):
        body = ET.SubElement(world, "body", {"name": f"support_{i}", "mocap": "true"})
        for shape in _seats(group):
            ET.SubElement(body, "geom", {**surface, **shape, "name": f"{shape['name']}_of_{i}"})


def _treads(ground: Ground) -> list[dict[str, str]]:
    """Return a plane, or a box per tread of a ground with steps."""
    along = {"xyaxes": numbers(ground.to_world[:, :2].T.ravel()), "rgba": _FLOOR}
    if not ground.steps:
        pos, size = (
            numbers(ground.normal * ground.height),
            numbers((GROUND_HALF_SIZE, GROUND_HALF_SIZE, 0.1)),
        )
        return [{"name": "floor", "type": "plane", "pos": pos, "size": size, **along}]
    heights = [ground.height, *(step.height for step in ground.steps)]
    edges = [-GROUND_HALF_SIZE, *(step.x for step in ground.steps), GROUND_HALF_SIZE]
    bottom = min(heights) - 1.0
    boxes = []
    for i, top in enumerate(heights):
        low, high = edges[i], max(edges[i + 1], edges[i] + 1e-3)
        pos = numbers(ground.to_world @ [(low + high) / 2, 0.0, (top + bottom) / 2])
        size = numbers([(high - low) / 2, GROUND_HALF_SIZE, (top - bottom) / 2])
        name = f"floor_{i}" if i else "floor"
        boxes.append({"name": name, "type": "box", "pos": pos, "size": size, **along})
    return boxes


def _relief(root: ET.Element, ground: Ground) -> list[dict[str, str]]:
    """Return bumps and height field; the heights become an asset."""
    shapes = []
    for i, bump in enumerate(ground.bumps):
        pos, size = numbers(ground.to_world @ bump.centre), numbers([bump.radius])
        sphere = {"name": f"bump_{i}", "type": "sphere", "pos": pos, "size": size}
        shapes.append({**sphere, "rgba": _FLOOR})
    if ground.field is not None:
        field, z = ground.field, np.array(ground.field.heights)
        half, low = np.array(field.size) / 2, float(z.min())
        centre = [*(np.array(field.corner) + half), ground.height + low]
        size = [*half, max(float(np.ptp(z)), 1e-6), low + 0.1]
        asset = ET.SubElement(ET.SubElement(root, "asset"), "hfield")
        asset.attrib.update(
            name="relief",
            nrow=str(z.shape[0]),
            ncol=str(z.shape[1]),
            size=numbers(size),
            elevation=numbers(z[::-1].ravel()),  # MJCF starts at the far side of y
        )
        pos, xyaxes = numbers(ground.to_world @ centre), numbers(ground.to_world[:, :2].T.ravel())
        relief = {"name": "relief", "type": "hfield", "hfield": "relief"}
        shapes.append({**relief, "pos": pos, "xyaxes": xyaxes, "rgba": _FLOOR})
    return shapes


def boards(seats: Sequence[Seat]) -> tuple[Board, ...]:
    """Return one level board per height of seats, and one for every other support."""
    found = []
    shared = [seat for seat in seats if not seat.board]
    for height in sorted({seat.position[2] for seat in shared}):
        places = np.array([s.position[:2] for s in shared if s.position[2] == height])
        low, high = places.min(axis=0), places.max(axis=0)
        half = (*((high - low) / 2 + SEAT_HALF_SIZES[:2]), SEAT_HALF_SIZES[2])
        centre = np.array([*((high + low) / 2), height - SEAT_HALF_SIZES[2]])
        found.append(Board(centre, np.eye(3), half))
    for seat in seats:
        if seat.board:
            normal = np.array(seat.normal)
            centre = np.array(seat.position) - BOARD_HALF_SIZES[2] * normal
            found.append(Board(centre, surface_axes(normal), BOARD_HALF_SIZES))
    return tuple(found)


def _seats(seats: Sequence[Seat]) -> list[dict[str, str]]:
    """Return the boards of seats."""
    return [
        {
            "name": f"seat_{i}", "type": "box", "pos": numbers(board.centre),
            "size": numbers(board.half_sizes), "xyaxes": numbers(board.axes[:, :2].T.ravel()),
            "rgba": _WOOD,
        }
        for i, board in enumerate(boards(seats))
    ]  # fmt: skip


def _add_cores(root: ET.Element, human: Human, bodies: dict[str | None, ET.Element]) -> None:
    """Add a thinner copy of every drawn shape, and exclude contact between neighbours."""
    for name, body in bodies.items():
        for i, drawn in enumerate([g for g in body.findall("geom") if g.get("group") == "1"]):
            size = numbers(CORE_SCALE * float(x) for x in drawn.get("size", "").split())
            core = {**drawn.attrib, "name": f"core_{name}_{i}", "size": size, **_CORES}
            ET.SubElement(body, "geom", core)
    parents = {b.name: b.parent for b in human.skeleton.bodies}
    contact = ET.SubElement(root, "contact")
    for a, b in combinations(parents, 2):
        if a in _above(b, parents)[:2] or b in _above(a, parents)[:2] or _one_foot(a, b, parents):
            ET.SubElement(contact, "exclude", body1=a, body2=b)


def _above(body: str, parents: dict[str, str]) -> list[str]:
    """Return the ancestors of a body, nearest first."""
    above = []
    while body := parents[body]:
        above.append(body)
    return above


def _one_foot(a: str, b: str, parents: dict[str, str]) -> bool:
    """Return whether two bodies belong to one foot, the descendants of one shank."""
    shanks = [
        {x for x in _above(body, parents) if x.startswith(("tibia", "shank"))} for body in (a, b)
    ]
    return bool(shanks[0] & shanks[1])


def _add_motors(root: ET.Element, human: Human) -> None:
    """Add a motor to every hinge, with armature and damping."""
    actuators = ET.SubElement(root, "actuator")
    for joint in root.iter("joint"):
        low, high = (float(x) for x in joint.get("actuatorfrcrange", "").split())
        max_torque, name = max(-low, high), joint.get("name", "")
        joint.set("armature", numbers([ARMATURE_PER_TORQUE * max_torque]))
        joint.set("damping", numbers([DAMPING_PER_TORQUE * max_torque]))
        ET.SubElement(actuators, "motor", name=name, joint=name, ctrlrange=numbers([low, high]))


def _lift(human: Human, ground: Ground, qpos: np.ndarray) -> float:
    """Return the upward shift that puts every sphere of the standing person above ground [m]."""
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(human.model, data)
    sites = contact_sites(human)
    centre = np.array([data.geom(GEOM_PREFIX + site.name).xpos for site in sites])
    low = centre - np.array([[site.radius] for site in sites]) * ground.normal
    return float(-ground.gap(low).min() / ground.normal[2])
