r"""A person's own OpenSim model on MuJoCo, in place of a scaled Human.

The coordinates :math:`u` are those of the file. Joints of MuJoCo are functions of them,
:math:`q = f(u)` with :math:`\dot q = G(u)\,\dot u`: the pelvis is a free joint, a knee whose
translations are splines has a slide for each. Moments of the coordinates are
:math:`\tau_u = G^T \tau`, as in OpenSim.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import CoordinateNotFound, FileError, ParameterError, known_names
from plantigrade.io.osim import OsimCoordinate, OsimJoint, OsimModel, parse_osim
from plantigrade.io.osim_shapes import foot_spheres, solids_of
from plantigrade.io.osim_tree import (
    Driven,
    OsimLink,
    check_root,
    links_of,
    root_coordinates,
    root_pose,
)
from plantigrade.models import Human
from plantigrade.models.anthropometry import dimensions
from plantigrade.models.landmarks import Attachment
from plantigrade.models.mjcf import add_shapes, numbers
from plantigrade.models.parts import Inertia, SoleSphere, Solid
from plantigrade.models.skeleton import Body, Hinge, Skeleton
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD as W
from plantigrade.spatial.conventions import rotation_quaternion

MIN_MASS, MIN_INERTIA = 1e-6, 1e-9  # [kg, kg m²] of massless bodies, for MuJoCo's mass matrix
USUAL_STATURE = (
    1.75  # [m] where legs do not tell it; men of ANSUR II: 1.756 on average [Gordon2014]_
)
# [m] hips lower or higher are no standing person's: statures of 0.57 and 2.8 m by [Winter2009]_
HIP_HEIGHTS = (0.3, 1.5)
STEP = 1e-5  # [rad, m] of the differences for G; its square is below the noise of doubles
_KEPT = {"BodySet", "JointSet", "ConstraintSet", "MarkerSet", "Ground", "gravity"}
_DRAWN = ("attached_geometry", "VisibleObject", "WrapObjectSet")


@dataclass(frozen=True)
class OsimHuman(Human):
    """A person given as an OpenSim model.

    :attr:`coordinates` are those of the joints, in the order of the file's joints; joints that
    follow a coordinate are in :attr:`joint_names` only. Build one with :meth:`of`.
    """

    text: str = field(repr=False, kw_only=True)  #: The file, without muscles and shapes
    osim: OsimModel = field(repr=False, kw_only=True)  #: What was read of it
    root: OsimJoint = field(repr=False, kw_only=True)  #: Joint of the root to the ground
    #: Bodies, in the order of MuJoCo
    links: tuple[OsimLink, ...] = field(repr=False, kw_only=True)

    @classmethod
    def of(
        cls,
        text: str,
        path: str | Path = "model.osim",
        *,
        height: float | None = None,
        sex: str | None = None,
    ) -> "OsimHuman":
        """Return the person of an OpenSim model.

        Args:
            height: Stature [m], which the file lacks; by leg length if not given.
            sex: ``"female"`` or ``"male"``; the file lacks it, too, and male is assumed.
        """
        osim = parse_osim(text, path)
        try:
            root, links = links_of(osim)
            check_root(root)
            return cls._built(reduced(text), osim, root, links, height, sex)
        except (ParameterError, ValueError, KeyError) as error:
            if isinstance(error, FileError):
                raise
            raise FileError(path, str(error), remedy="give a model of one person") from error

    @classmethod
    def _built(cls, text, osim, root, links, height, sex) -> "OsimHuman":
        solids, spheres = solids_of(osim, links), foot_spheres(links)
        xml, order = osim_mjcf(osim, root, links, solids, spheres)
        links = tuple(next(link for link in links if link.name == name) for name in order)
        bodies = tuple(body_of(osim, k, solids[k.name], spheres.get(k.name, ())) for k in links)
        mass = sum(s.mass for s in osim.segments.values())
        sex = sex or "male"
        feet = "two-segment" if any(s.startswith("toe") for s in spheres) else "rigid"
        skeleton = Skeleton(bodies, {}, {})
        made = cls(
            height or USUAL_STATURE, mass, sex, "own", feet, dimensions(USUAL_STATURE, sex),
            skeleton, xml, text=text, osim=osim, root=root, links=links,
        )  # fmt: skip
        return made if height else replace(made, height=made._stature())

    def _stature(self) -> float:
        """Return the stature that suits the legs [m]; the usual one where they are not seen."""
        from plantigrade.models.stature import stature_from_legs

        data = mujoco.MjData(self.model)
        data.qpos = self.standing()
        mujoco.mj_kinematics(self.model, data)
        hips = [k for k in self.links if k.parent == self.body_names[0] and "femur" in k.name]
        if not hips or not self.contact_points:
            return USUAL_STATURE
        leg = float(data.body(hips[0].name).xpos[2])
        low, high = HIP_HEIGHTS
        return stature_from_legs(leg, None)[0] if low < leg < high else USUAL_STATURE

    @cached_property
    def drives(self) -> tuple[Driven, ...]:
        """Every joint but the root, in the order of ``qpos[7:]``."""
        return tuple(driven for link in self.links for _, _, driven, _ in link.joints)

    @cached_property
    def every_coordinate(self) -> tuple[OsimCoordinate, ...]:
        """Coordinates of the file, root first, without those that are tied or drive nothing."""
        others = [c for j in self.osim.joints if j is not self.root for c in j.coordinates]
        return (*self.root.coordinates, *(c for c in others if c.name in self.coordinates))

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates that are joints, in the order of ``qpos[7:]``."""
        return tuple(each.name for each in self.drives if each.own)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the MuJoCo joints: ``root``, then the others."""
        return ("root", *(each.name for each in self.drives))

    def hinge(self, coordinate: str) -> int:
        """Return the index of a coordinate within ``qpos[7:]``."""
        if coordinate not in self.coordinates:
            known = known_names(coordinate, self.coordinates)
            raise CoordinateNotFound(f"no coordinate {coordinate!r} in this model; {known}")
        return self.joint_names.index(coordinate) - 1

    @cached_property
    def limits(self) -> Float[Array, "2 n_hinges"]:
        """Lower and upper limits of all joints but the root [rad, m]."""
        spans = [span for link in self.links for *_, span in link.joints]
        return np.array(spans, dtype=float).reshape(-1, 2).T

    @property
    def trunk(self) -> str:
        """Name of the body of the trunk."""
        names = self.body_names
        return next((n for n in names if n in ("torso", "thorax", "trunk")), names[0])

    @cached_property
    def places(self) -> dict[str, Attachment]:
        """Markers of the file on bodies that move, by name."""
        return {
            name: Attachment(frame.body, W @ frame.position, 0.0)
            for name, frame in self.osim.markers.items()
            if frame.body in self.body_names
        }

    def poses(self, u: Float[Array, "n n_coordinates"]) -> Float[Array, "n nq"]:
        """Return configurations of MuJoCo from all coordinates, with the file's signs [rad, m]."""
        n = len(u)
        column = {c.name: u[:, k] for k, c in enumerate(self.every_coordinate)}
        qpos = np.zeros((n, self.model.nq))
        qpos[:, :7] = root_pose(self.root, column, n)
        for k, each in enumerate(self.drives):
            qpos[:, 7 + k] = each.function.value(column[each.coordinate])
        return qpos

    def slopes(self, u: Float[Array, " n_coordinates"]) -> Float[Array, "nv n_coordinates"]:
        """Return the matrix G that turns rates of the coordinates into MuJoCo's velocity."""
        k = len(u)
        ends = self.poses(np.vstack([u + STEP * np.eye(k), u - STEP * np.eye(k)]))
        G = np.empty((k, self.model.nv))
        for i in range(k):
            mujoco.mj_differentiatePos(self.model, G[i], 2 * STEP, ends[k + i], ends[i])
        return G.T

    def defaults(self) -> Float[Array, " n_coordinates"]:
        """Return the default value of every coordinate [rad, m]."""
        return np.array([c.default for c in self.every_coordinate])

    def to_coordinates(
        self, qpos: Float[Array, "n_frames nq"]
    ) -> tuple[tuple[str, ...], Float[Array, "n_frames n_coordinates"]]:
        """Return all coordinates of the file: names and values [rad, m], knee flexion positive."""
        found = root_coordinates(self.root, qpos)
        for c in self.every_coordinate:
            if c.name in self.coordinates:
                found[c.name] = qpos[:, 7 + self.hinge(c.name)]
        names = tuple(c.name for c in self.every_coordinate)
        return names, np.stack([found[n] for n in names], axis=1)

    def file_coordinates(
        self, qpos: Float[Array, "n_frames nq"]
    ) -> tuple[tuple[str, ...], Float[Array, "n_frames n_coordinates"]]:
        """Return all coordinates of the file with the file's own signs [rad, m]."""
        names, values = self.to_coordinates(qpos)
        return names, values * self.signs

    @cached_property
    def signs(self) -> Float[Array, " n_coordinates"]:
        """-1 for each coordinate whose sign in the file is not ours, otherwise 1."""
        turned = {each.coordinate: each.sign for each in self.drives if each.own}
        return np.array([turned.get(c.name, 1.0) for c in self.every_coordinate])

    def from_coordinates(
        self, names: Sequence[str], values: Float[Array, "n_frames n_columns"]
    ) -> Float[Array, "n_frames nq"]:
        """Return configurations from coordinates, the inverse of :meth:`to_coordinates`.

        Those not given keep their default.
        """
        known = [c.name for c in self.every_coordinate]
        if not set(names) & set(known):
            raise ParameterError(f"none of the columns is a coordinate of this model: {known}")
        u = np.tile(self.defaults(), (len(values), 1))
        for k, name in enumerate(names):
            if name in known:
                u[:, known.index(name)] = values[:, k] * self.signs[known.index(name)]
        return self.poses(u)

    def with_mass(self, mass: float) -> "OsimHuman":
        """Return the same person: the masses of the file are kept."""
        return self

    def to_dict(self) -> dict:
        """Return a JSON-serialisable description of the person; see :meth:`from_dict`."""
        return {"osim": self.text, "height": self.height, "sex": self.sex}

    @classmethod
    def from_dict(cls, description: Mapping) -> Human:
        """Return the person described by :meth:`to_dict`, of either kind."""
        if "osim" not in description:
            return Human.from_dict(description)
        try:
            height, sex = float(description["height"]), str(description["sex"])
            return cls.of(str(description["osim"]), height=height, sex=sex)
        except (FileError, KeyError, TypeError, ValueError) as error:
            raise ParameterError(f"not a description of a person: {error}") from error


def reduced(text: str) -> str:
    """Return an OpenSim file without what is not read."""
    root = ET.fromstring(text.lstrip("\ufeff").strip())
    model = root.find("Model")
    assert model is not None  # it was read before
    for child in list(model):
        if child.tag not in _KEPT:
            model.remove(child)
    for parent in list(model.iter()):
        for child in list(parent):
            if child.tag in _DRAWN:
                parent.remove(child)
    return ET.tostring(root, encoding="unicode")


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
