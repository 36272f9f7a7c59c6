"""What a robot is to do: a person's motion scaled to its legs, with feet that stand on its ground.

The robot's foot is one rigid piece. While a foot of the person is flat on the ground, the robot's
sole is flat at one place; before, it rolls over the edge of its heel, and afterwards over that of
its toes, as far as the person's foot is pitched. Between two contacts it follows the person's foot;
what is left between that and the two contacts is spread over the swing.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.blends import cubic_rise
from plantigrade.motion.filters import runs
from plantigrade.record import Record
from plantigrade.robots.robot import Robot
from plantigrade.robots.sole import Sole
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import unit_vectors

PARTS = {
    "pelvis": ("pelvis",),
    "torso": ("thorax", "torso", "abdomen"),
    "head": ("head",),
    "hip": ("femur",),
    "knee": ("tibia",),
    "ankle": ("foot",),
    "shoulder": ("humerus",),
    "elbow": ("ulna", "forearm"),
    "wrist": ("hand",),
}
"""Joint or part → bodies of a person that begin there, the first that the body has."""
MAX_GAP = 0.08  # [s] gap up to which two contacts of a foot are one; a longer one ends in a strike
SWING, FLAT, HEEL, TOE = range(4)
"""What a foot does in a frame: it is in the air, flat, on the edge of its heel, of its toes."""


@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of every frame, in axes of the world, x forward at the start."""

    time: Float[Array, " n"]  #: [s]
    hips: Float[Array, "n 3"]  #: Midpoint of the hips [m]
    rotation: dict[str, Float[Array, "n 3 3"]]  #: Of pelvis, torso, head, from the standing pose
    direction: dict[tuple[str, str], Float[Array, "n 3"]]  #: Limb → unit vector
    position: dict[str, Float[Array, "n 3"]]  #: Side → origin of the robot's sole [m]
    orientation: dict[str, Float[Array, "n 3 3"]]  #: Side → axes of the sole, as columns
    phase: dict[str, Array]  #: Side → SWING, FLAT, HEEL or TOE, (n,)
    scale: float  #: Leg of the robot over leg of the person
    abduction: float = 0.0  #: Angle by which the arms are held away from the body [rad]

    def abducted(self, angle: float) -> "Targets":
        """Return the same with the arms turned outwards about the trunk's forward axis [rad]."""
        trunk = self.rotation["torso" if "torso" in self.rotation else "pelvis"]
        turned = dict(self.direction)
        for (a, b), along in self.direction.items():
            if a.startswith(("shoulder", "elbow")):
                about = trunk[:, :, 0] * (angle if a.endswith("l") else -angle)
                turned[a, b] = Rotation.from_rotvec(about).apply(along)
        return replace(self, direction=turned, abduction=angle)


class _Paths:
    """Positions and orientations of the parts of a person over a motion."""

    def __init__(self, human: Human, motion: Motion):
        self.names = {
            name: found
            for name in (*PARTS, *(f"{part}_{s}" for part in PARTS for s in SIDES))
            if (found := _body(human, name)) is not None
        }
        bodies = [human.body(body) for body in self.names.values()]
        place, turn = body_paths(human, np.vstack([human.standing(), motion.qpos]), bodies)
        index = {name: k for k, name in enumerate(self.names)}
        self.rest = {name: place[0, k] for name, k in index.items()}
        self.position = {name: place[1:, k] for name, k in index.items()}
        self.rotation = {name: turn[1:, k] @ turn[0, k].T for name, k in index.items()}


def _body(human: Human, name: str) -> str | None:
    """Return the body of a person that begins at a joint, None if there is none."""
    part, side = split_side(name)
    names = (f"{body}_{side}" if side else body for body in PARTS[part])
    return next((body for body in names if body in human.body_names), None)


def targets_of(record: Record, motion: Motion, robot: Robot) -> Targets:
    """Return what the robot is to do."""
    ground, human = record.ground, record.human
    if ground.slope or ground.steps or ground.bumps or ground.field is not None:
        raise ParameterError("a robot takes over motions on level ground alone; this one is not")
    paths = _Paths(human, motion)
    floor = np.array([0.0, 0.0, ground.height])
    soles = sole_paths(human, motion.qpos, ground)
    rise = -float(np.median([soles.position[:, soles.of(s), 2].min() for s in SIDES]))
    legs = [
        np.linalg.norm(paths.rest[f"hip_{s}"] - paths.rest[f"knee_{s}"])
        + np.linalg.norm(paths.rest[f"knee_{s}"] - paths.rest[f"ankle_{s}"])
        + _ankle_height(human, paths, s)
        for s in SIDES
    ]
    scale = robot.leg_length / float(np.mean(legs))
    start = paths.position["pelvis"][0] * [1.0, 1.0, 0.0] + floor

    def placed(path: Float[Array, "n 3"]) -> Float[Array, "n 3"]:
        return scale * (path - start + [0.0, 0.0, max(rise, 0.0)])

    hips = (paths.position["hip_r"] + paths.position["hip_l"]) / 2
    rate = 1.0 / float(np.median(np.diff(motion.time)))
    rests = find_rests(soles, rate)
    position, orientation, phase = {}, {}, {}
    for side in SIDES:
        height = np.array([0.0, 0.0, _ankle_height(human, paths, side)])
        turn = paths.rotation[f"ankle_{side}"]
        path = placed(paths.position[f"ankle_{side}"] - turn @ height)
        own = {r: np.zeros(motion.n_frames, dtype=bool) for r in ("heel", "ball", "toes")}
        for rest in rests:
            if rest.side == side:
                own[rest.region][rest.start : rest.stop] = True
        contacts = _contacts(own, rate)
        if not contacts:
            raise ParameterError(
                f"the {'right' if side == 'r' else 'left'} foot never rests on the ground"
            )
        sole = robot.soles[side]
        position[side], orientation[side], phase[side] = _foot(path, turn, contacts, sole)
    turned = {n: paths.rotation[n] for n in ("pelvis", "torso", "head") if n in robot.joints}
    limbs = {}
    for a, b in robot.limbs:
        if a in paths.position and b in paths.position:
            limbs[a, b] = unit_vectors(paths.position[b] - paths.position[a])
    return Targets(motion.time, placed(hips), turned, limbs, position, orientation, phase, scale)


def _ankle_height(human: Human, paths: _Paths, side: str) -> float:
    """Return the height of the ankle over the sole of a person who stands [m]."""
    soles = sole_paths(human, human.standing()[None])
    return float(paths.rest[f"ankle_{side}"][2] - soles.position[0, soles.of(side), 2].min())


def _contacts(own: dict[str, np.ndarray], rate: float) -> list[tuple[slice, slice]]:
    """Return the frames of each contact of a foot, and of those the ones in which it is flat."""
    any_rest = own["heel"] | own["ball"] | own["toes"]
    for gap in runs(~any_rest):
        if gap.start > 0 and gap.stop < len(any_rest) and gap.stop - gap.start <= MAX_GAP * rate:
            any_rest[gap] = True
    flat = own["heel"] & (own["ball"] | own["toes"])
    found = []
    for contact in runs(any_rest):
        inside = np.flatnonzero(flat[contact]) + contact.start
        if not len(inside):  # it lands on the forefoot: flat for an instant
            middle = (contact.start + contact.stop) // 2
            inside = np.array([middle])
        found.append((contact, slice(int(inside[0]), int(inside[-1]) + 1)))
    return found


def _foot(path, turn, contacts, sole: Sole):
    """Return position and orientation of the robot's sole, and what it does, in every frame."""
    n = len(path)
    position, orientation = path.copy(), turn.copy()
    phase = np.full(n, SWING)
    pitch, yaw = _pitch(turn), _yaw(turn)
    for contact, flat in contacts:
        place = np.median(path[flat], axis=0) * [1.0, 1.0, 0.0]
        heading = np.median(yaw[flat])
        level = Rotation.from_euler("z", heading).as_matrix()
        for k in range(contact.start, contact.stop):
            angle, edge = 0.0, FLAT
            if k < flat.start:
                angle, edge = pitch[k] - pitch[flat.start], HEEL
            elif k >= flat.stop:
                angle, edge = pitch[k] - pitch[flat.stop - 1], TOE
            if (angle <= 0.0) if edge == HEEL else (angle >= 0.0):
                angle, edge = 0.0, FLAT
            own = level @ Rotation.from_euler("y", -angle).as_matrix()
            phase[k], orientation[k], position[k] = edge, own, place
            if edge != FLAT:
                pivot = sole.edge("heel" if edge == HEEL else "toe")
                position[k] = place + level @ pivot - own @ pivot
    _join(position, orientation, path, turn, phase)
    for k in np.flatnonzero(phase == SWING):
        position[k, 2] += max(0.0, -sole.lowest(position[k], orientation[k]))
    return position, orientation, phase


def _join(position, orientation, path, turn, phase) -> None:
    """Lead the swings from one contact to the next, in place."""
    n = len(path)
    for swing in runs(phase == SWING):
        ends = [k for k in (swing.start - 1, swing.stop) if 0 <= k < n]
        shift = [position[k] - path[k] for k in ends]
        twist = [Rotation.from_matrix(orientation[k] @ turn[k].T).as_rotvec() for k in ends]
        for k in range(swing.start, swing.stop):
            share = 0.0
            if len(ends) == 2:
                share = cubic_rise((k - ends[0]) / (ends[1] - ends[0]))
            mixed = [(1.0 - share) * pair[0] + share * pair[-1] for pair in (shift, twist)]
            position[k] = path[k] + mixed[0]
            orientation[k] = Rotation.from_rotvec(mixed[1]).as_matrix() @ turn[k]


def _pitch(turn: Float[Array, "n 3 3"]) -> Float[Array, " n"]:
    """Return how far a foot is pitched, toes up positive [rad]."""
    return np.arctan2(turn[:, 2, 0], np.hypot(turn[:, 0, 0], turn[:, 1, 0]))


def _yaw(turn: Float[Array, "n 3 3"]) -> Float[Array, " n"]:
    return np.unwrap(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))
