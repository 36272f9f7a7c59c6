"""An OpenSim model as a tree of MuJoCo bodies: every axis that moves is a joint.

Axes are ours (x forward, y left, z up) in the world and in every body: :math:`W v` for each vector
:math:`v` of the file and :math:`W R W^T` for each rotation. Translations become slides before the
hinges. An axis that is a curve of its coordinate has a joint of its own, which follows it
(:class:`Driven`); the first axis that *is* the coordinate carries its name. Knee flexion is
positive in the joints, as everywhere here, also where the file counts it negative.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.io.osim import GROUND, Axis, OsimJoint, OsimModel
from plantigrade.io.osim_functions import Function
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD as W
from plantigrade.spatial.conventions import about_axis, rotation_matrix, rotation_quaternion

_KNEE = re.compile(r"knee_angle(_[rl])?")
FREE_RANGE = (-1e3, 1e3)  # of joints that follow a coordinate, and of coordinates without range


@dataclass(frozen=True)
class Driven:
    """A MuJoCo joint and the coordinate that drives it."""

    name: str  #: Name of the joint: that of the coordinate where it is the coordinate itself
    coordinate: str
    function: Function  #: Value of the joint by the coordinate
    sign: float = 1.0  #: -1 where the file counts knee flexion negative; ours is positive

    @property
    def own(self) -> bool:
        """Whether it is the coordinate itself."""
        return self.name == self.coordinate


@dataclass(frozen=True)
class OsimLink:
    """A body on its parent, our axes."""

    name: str
    parent: str  #: Name of the parent; empty for the root
    position: Float[Array, " 3"]  #: Origin in the parent's frame, all joints at zero [m]
    rotation: Float[Array, "3 3"]  #: Rotation into the parent's frame, all joints at zero
    anchor: Float[Array, " 3"]  #: Centre of its joint in its own frame [m]
    #: Type, axis in its own frame, drive and range of each of its joints
    joints: tuple[tuple[str, Float[Array, " 3"], Driven, tuple[float, float]], ...]


def links_of(model: OsimModel) -> tuple[OsimJoint, tuple[OsimLink, ...]]:
    """Return the joint of the root to the ground, and the bodies below it, parents first."""
    roots = [j for j in model.joints if j.parent.body == GROUND and j.coordinates]
    if len(roots) != 1:
        problem = f"{len(roots)} bodies move on the ground"
        raise ParameterError(f"{problem}; a person has one root, such as the pelvis")
    root, owned = roots[0], set()
    links = [OsimLink(root.child.body, "", np.zeros(3), np.eye(3), np.zeros(3), ())]
    reached, todo = {root.child.body}, [j for j in model.joints if j.parent.body != GROUND]
    while todo:
        ready = [j for j in todo if j.parent.body in reached]
        if not ready:
            names = ", ".join(j.name for j in todo[:5])
            raise ParameterError(f"the joints {names} do not hang on {root.child.body}")
        for joint in ready:
            if joint.child.body in reached:
                problem = f"body {joint.child.body} has two joints to its parents"
                raise ParameterError(f"{problem}: closed loops are not read")
            links.append(_link(joint, owned))
            reached.add(joint.child.body)
            todo.remove(joint)
    used = {driven.coordinate for link in links for _, _, driven, _ in link.joints}
    if lost := sorted(used - owned):
        raise ParameterError(f"no axis is the coordinate {lost[0]} itself, only functions of it")
    return root, tuple(links)


def _link(joint: OsimJoint, owned: set[str]) -> OsimLink:
    """Return the body on its parent; ``owned`` are the coordinates that have a joint already."""
    fixed, turn = np.zeros(3), np.eye(3)
    turns: list[tuple[Axis, np.ndarray]] = []
    for axis in joint.axes:
        value = axis.function.constant
        if axis.slides and value is not None:
            fixed = fixed + value * axis.direction
        elif value is not None:  # a fixed rotation moves the axes before it into its own frame
            step = about_axis(axis.direction, np.array([value]))[0]
            turns = [(before, step.T @ direction) for before, direction in turns]
            turn = turn @ step
        elif not axis.slides:
            turns.append((axis, axis.direction))
    P, C = joint.parent.rotation, joint.child.rotation
    rotation = P @ turn @ C.T
    slides = [
        (axis, turn.T @ axis.direction)
        for axis in joint.axes
        if axis.slides and axis.function.constant is None
    ]
    ranges = {c.name: (c.low, c.high) if c.low < c.high else FREE_RANGE for c in joint.coordinates}
    joints = []
    for axis, direction in (*slides, *turns):
        assert axis.coordinate is not None  # else it would be constant
        name, sign = axis.name, 1.0
        if axis.function.line in ((1.0, 0.0), (-1.0, 0.0)) and axis.coordinate not in owned:
            name, sign = axis.coordinate, axis.function.line[0]
            owned.add(name)
        own, turned = name == axis.coordinate, 1.0
        low, high = np.clip(ranges.get(name, FREE_RANGE) if own else FREE_RANGE, *FREE_RANGE)
        if own and _KNEE.fullmatch(name) and -low > high:
            turned, low, high = -1.0, -high, -low
        function = Function.linear(turned) if own else axis.function
        driven = Driven(name, axis.coordinate, function, turned)
        kind = "slide" if axis.slides else "hinge"
        along = W @ C @ direction * sign * turned
        joints.append((kind, along, driven, (float(low), float(high))))
    start = joint.parent.position + P @ fixed
    place = W @ (start - rotation @ joint.child.position)
    anchor = W @ joint.child.position
    parent = joint.parent.body
    return OsimLink(joint.child.body, parent, place, W @ rotation @ W.T, anchor, tuple(joints))


def check_root(root: OsimJoint) -> None:
    """Refuse a root whose pose does not tell its coordinates."""
    moving = [a for a in root.axes if a.function.constant is None]
    turns = [a for a in moving if not a.slides]
    for axis in moving:
        if axis.function.line not in ((1.0, 0.0), (-1.0, 0.0)) or np.abs(axis.direction).max() < 1:
            raise ParameterError(f"axis {axis.name} of the root is not along x, y or z")
    if len({int(np.abs(a.direction).argmax()) for a in turns}) < len(turns):
        raise ParameterError(f"the root {root.name} turns twice about one axis")
    if any(a.function.constant for a in root.axes if not a.slides):
        raise ParameterError(f"the root {root.name} has a fixed rotation in its axes")


def root_pose(root: OsimJoint, column: Mapping[str, np.ndarray], n: int) -> Float[Array, "n 7"]:
    """Return position and quaternion ``wxyz`` of the root's body, our axes."""
    moved, turn = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    for axis in root.axes:
        if axis.function.constant is not None:
            value = np.full((n, 1), axis.function.constant)
        else:
            value = axis.function.value(column[str(axis.coordinate)])[:, None]
        if axis.slides:
            moved = moved + value * axis.direction
        else:
            turn = turn @ about_axis(axis.direction, value[:, 0])
    P, C = root.parent.rotation, root.child.rotation
    R = P @ turn @ C.T
    origin = root.parent.position + moved @ P.T - R @ root.child.position
    return np.hstack([origin @ W.T, rotation_quaternion(W @ R @ W.T)])


def root_coordinates(root: OsimJoint, qpos: Float[Array, "n nq"]) -> dict[str, Float[Array, " n"]]:
    """Return the coordinates of the root from its pose, angles unwrapped over time."""
    P, C = root.parent.rotation, root.child.rotation
    R = W.T @ rotation_matrix(qpos[:, 3:7]) @ W
    place = qpos[:, :3] @ W + R @ root.child.position - root.parent.position
    moved, turn = place @ P, P.T @ R @ C
    moving = [a for a in root.axes if a.function.constant is None]
    turns = [a for a in moving if not a.slides]
    letters = [int(np.abs(a.direction).argmax()) for a in turns]
    letters += [k for k in (2, 0, 1) if k not in letters]
    found = {c.name: np.full(len(qpos), c.default) for c in root.coordinates}
    angles = Rotation.from_matrix(turn).as_euler("".join("XYZ"[k] for k in letters))
    for k, axis in enumerate(turns):
        slope = axis.function.line[0] if axis.function.line else 1.0
        found[str(axis.coordinate)] = np.unwrap(angles[:, k]) * axis.direction[letters[k]] * slope
    for axis in moving:
        if axis.slides and axis.function.line is not None:
            found[str(axis.coordinate)] = moved @ axis.direction * axis.function.line[0]
    return found
