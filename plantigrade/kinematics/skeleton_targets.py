"""Targets of a person's joints and segments in another skeleton, and their inverse kinematics."""

import mujoco
import numpy as np

from plantigrade.constants import SIDES
from plantigrade.data_files import named_numbers
from plantigrade.kinematics.ground_normal import smallest_turn
from plantigrade.kinematics.inverse import InverseKinematics, Terms
from plantigrade.kinematics.shoulders import arm_starts
from plantigrade.kinematics.skeleton_source import SkeletonSource
from plantigrade.kinematics.state import PointSet, integrate
from plantigrade.kinematics.unmeasured_joints import measured_hinges
from plantigrade.models import Human
from plantigrade.models.anatomy import hip, lumbar, shoulder
from plantigrade.models.coordinates import coordinate_of
from plantigrade.spatial.conventions import about_vertical, unit_vectors

# Joints and the part distal to each.
CENTRES = {
    "hip": "femur",
    "knee": "tibia",
    "ankle": "foot",
    "shoulder": "humerus",
    "elbow": "ulna",
    "wrist": "hand",
}
_X, _Y, _Z = np.eye(3)
FLAT_TILT = np.deg2rad(25)  # [rad] maximum tilt of a flat foot relative to the rest pose
ARM_JOINTS = ("shoulder", "elbow", "wrist")
MIN_HINGE_RANGE = np.deg2rad(25)  # [rad] minimum flexion of a hinge that determines its axis
MAX_FRAME_COST = 4e-3  # [m²] weighted sum of squares above which other arm postures are tried
AXIS_LENGTH = 0.20  # [m] length of the vectors that represent an orientation
# Weights of the terms: joint centres, and vectors of length ARM along bone axes.
WEIGHTS = named_numbers("plantigrade.kinematics", "skeleton_weights.csv")


class SkeletonTargets:
    """Targets of the person's joints and segments in every frame."""

    def __init__(self, human: Human, source: SkeletonSource):
        self.human, self.source = human, source
        self.points: list[tuple[str, np.ndarray]] = []
        self.pairs: list[tuple[int, int]] = []
        self.values: list[np.ndarray] = []
        self.weights: list[float] = []
        self.centres: list[int] = []  # which of the terms are joint centres
        self._joint_centres()
        self._trunk()
        for side in SIDES:
            self._leg(side)
            self._foot(side)
            if source.arms:
                self._arm(side)

    def _add(self, pair: tuple[int, int], values: np.ndarray, weight: float) -> None:
        self.pairs.append(pair)
        self.values.append(values)
        self.weights.append(weight)

    def _add_axis(self, part: str, axis: np.ndarray, values: np.ndarray, weight: float) -> None:
        """Ask for the axis of a part (zero pose: world axes) to point along ``values``."""
        body, n = self.human.skeleton.parts[part][0], len(self.points)
        self.points += [(body, np.zeros(3)), (body, AXIS_LENGTH * axis)]
        self._add((n + 1, n), AXIS_LENGTH * values, weight)

    def _joint_centres(self) -> None:
        moved = self._shoulder_offset()
        for joint, part in CENTRES.items():
            if not self.source.found.both(joint):
                continue
            for side in SIDES:
                name = f"{joint}_{side}"
                body, position = self.human.skeleton.parts[f"{part}_{side}"]
                self.centres.append(len(self.pairs))
                self.points.append((body, np.asarray(position, float)))
                path = self.source.at(name) + (moved if joint in ARM_JOINTS else 0.0)
                self._add((len(self.points) - 1, -1), path, WEIGHTS[joint])

    def _shoulder_offset(self) -> np.ndarray:
        """Return what to add to the file's shoulders and arms in every frame [m].

        Skeletons differ in how far the shoulders lie before or behind the hips when the trunk is
        upright, as it is in the rest pose of both; the difference moves with the thorax.
        """
        source = self.source
        if not (source.found.both("shoulder") and source.has("thorax")):
            return np.zeros((len(source.time), 3))
        rise = source.rest_rise()
        d = self.human.dimensions
        x, _, z = lumbar(d) + shoulder(d) - hip(d)
        offset = float(np.clip(x - rise[0] * z / rise[2], -0.1, 0.1)) if rise[2] > 0.1 else 0.0
        return source.rotation("thorax") @ (offset * _X)

    def _trunk(self) -> None:
        source = self.source
        targets = [("pelvis", "pelvis", _X, "pelvis"), ("pelvis", "pelvis", _Z, "pelvis")]
        if source.has("thorax"):
            targets += [("thorax", "thorax", _Y, "thorax"), ("thorax", "thorax", _Z, "thorax_up")]
        top = next((joint for joint in ("head", "neck") if source.has(joint)), None)
        if top is not None:
            targets += [("head", top, _X, "head"), ("head", top, _Z, "head")]
        for part, joint, axis, weight in targets:
            self._add_axis(part, axis, source.rotation(joint) @ axis, WEIGHTS[weight])

    def _hinge(self, a: str, b: str, c: str, side: str, backwards: bool) -> np.ndarray:
        """Return the rotation from our upper bone to the file's, ``A`` of the module's text.

        The bone's rest direction gives its swing; the axis about which the lower bone bends in
        the motion gives the twist, else the rest pose.
        """
        source = self.source
        a, b, c = (f"{j}_{side}" for j in (a, b, c))
        down = source.rest(b) - source.rest(a)
        A = _swing(-_Z, down)
        R = source.above(b)
        upper, lower = source.at(b) - source.at(a), source.at(c) - source.at(b)
        # It points to the left for a knee, to the right for an elbow.
        axis = np.cross(unit_vectors(upper), unit_vectors(lower))
        sine = np.linalg.norm(axis, axis=1)
        bent = sine > np.sin(MIN_HINGE_RANGE)
        if bent.sum() < 3:
            return A
        axis = np.einsum("nji,nj->ni", R, axis)[bent].mean(axis=0)
        if np.linalg.norm(axis) < 0.7 * sine[bent].mean():
            return A  # no hinge: the axis turns with the motion
        axis = unit_vectors(A.T @ axis) * (1.0 if backwards else -1.0)
        coordinate = "knee_angle" if backwards else "elbow_flex"
        ours = coordinate_of(f"{coordinate}_{side}").axis_of(side)
        ours = ours * np.sign(ours[1])  # the sense in which it points left
        turn = np.arctan2(axis[1], axis[0]) - np.arctan2(ours[1], ours[0])
        return A @ _yaw(np.array([np.cos(turn), np.sin(turn), 0.0]))

    def _leg(self, side: str) -> None:
        source = self.source
        A = self._hinge("hip", "knee", "ankle", side, True)
        R = source.above(f"knee_{side}")
        self._add_axis(f"femur_{side}", _Y, R @ (A @ _Y), WEIGHTS["thigh"])
        down = source.rest(f"ankle_{side}") - source.rest(f"knee_{side}")
        # The shank's own turn counts from the thigh's: both hinges look the same way at rest.
        thigh = source.rest(f"knee_{side}") - source.rest(f"hip_{side}")
        across = A @ _Y
        S = _swing(thigh, down)
        R = source.above(f"ankle_{side}")
        self._add_axis(f"tibia_{side}", _Y, R @ (S @ across), WEIGHTS["shank"])

    def _arm(self, side: str) -> None:
        source, found = self.source, self.source.found
        if not found.both("wrist"):
            return
        A = self._hinge("shoulder", "elbow", "wrist", side, False)
        R = source.above(f"elbow_{side}")
        self._add_axis(f"humerus_{side}", _Y, R @ (A @ _Y), WEIGHTS["upper_arm"])
        wrist = source.rest(f"wrist_{side}")
        along = unit_vectors(wrist - source.rest(f"elbow_{side}"))
        R = source.rotation(f"wrist_{side}")
        thumb = self._thumb(side, along)
        outward = _Y if side == "l" else -_Y  # where the thumb points in our zero pose
        self._add_axis(f"hand_{side}", outward, R @ thumb, WEIGHTS["hand"])
        distal = along
        if source.has(f"knuckle_{side}"):
            hand = source.rest(f"knuckle_{side}") - wrist
            distal = unit_vectors(hand) if np.linalg.norm(hand) > 0.02 else along
        self._add_axis(f"hand_{side}", -_Z, R @ distal, WEIGHTS["hand_axis"])

    def _thumb(self, side: str, along: np.ndarray) -> np.ndarray:
        """Return where the thumb's side of the hand points in the rest pose, square to it."""
        source = self.source
        index, pinky = f"index_{side}", f"pinky_{side}"
        thumb = f"thumb_{side}"
        guesses = []
        if source.has(index) and source.has(pinky):
            guesses.append(source.rest(index) - source.rest(pinky))
        if source.has(thumb):
            i = source.found[thumb]
            tip = source.skeleton.ends[0, i] - source.skeleton.positions[0, i]
            tip = source.skeleton.rotations[0, i].T @ tip
            tip = tip if np.isfinite(tip).all() else np.zeros(3)
            guesses.append(source.rest(thumb) + tip - source.rest(f"wrist_{side}"))
        for guess in [*guesses, _X, _Y if side == "l" else -_Y]:
            square = guess - (guess @ along) * along
            if np.linalg.norm(square) > 0.3 * np.linalg.norm(guess) > 1e-4:
                return unit_vectors(square)
        return _X

    def _foot(self, side: str) -> None:
        source = self.source
        ankle, R = f"ankle_{side}", source.rotation(f"ankle_{side}")
        flat = source.flat(side)
        forward = source.forefoot(side) - source.at(ankle)
        at_rest = np.einsum("nji,nj->ni", R, forward).mean(axis=0)
        # In the rest pose the foot stands square to the shank, wherever that points.
        S = _swing(-_Z, source.rest(ankle) - source.rest(f"knee_{side}"))
        at_rest = S.T @ at_rest
        rest = S @ _yaw(at_rest) if np.linalg.norm(at_rest[:2]) > 1e-3 else S
        A = rest
        if len(flat) >= 3:
            own = _mean_rotation(np.swapaxes(R[flat], 1, 2) @ _yaw(forward[flat]))
            tilt = np.arccos(np.clip((rest.T @ own)[2, 2], -1, 1))
            if tilt < FLAT_TILT:
                A = own
        for axis in (_X, _Y):
            self._add_axis(f"foot_{side}", axis, R @ (A @ axis), WEIGHTS["foot"])
        ball = f"ball_{side}"
        parts = (f"toes_{side}", f"medial_phalanges_{side}")
        skeleton, bodies = self.human.skeleton.parts, self.human.body_names
        part = next((p for p in parts if p in skeleton and p in bodies), None)
        if source.has(ball) and part:
            T = source.rotation(ball)
            relative = np.swapaxes(R, 1, 2) @ T
            B = _mean_rotation(relative[flat]) if len(flat) >= 3 else np.eye(3)
            self._add_axis(part, _X, T @ (B.T @ A @ _X), WEIGHTS["toes"])

    @property
    def seen(self) -> np.ndarray:
        """Hinges that the skeleton determines."""
        return measured_hinges(Terms(self.human, self.points, self.pairs))

    def follow(self) -> np.ndarray:
        """Return the configurations of all frames."""
        terms = Terms(self.human, self.points, self.pairs)
        solver = InverseKinematics(terms, np.array(self.weights), tolerance=2e-4, max_iterations=60)
        targets = np.stack(self.values, axis=1)
        start = self._start()
        qpos = np.empty((len(targets), len(start)))
        cost = np.empty(len(targets))
        qpos[0], cost[0] = self._best(solver, targets[0], [start, *self._other_arms(start)])
        solver.max_iterations = 12
        step = np.zeros(terms.model.nv)
        patience = 0
        for k in range(1, len(targets)):
            qpos[k], cost[k] = self._solved(
                solver, targets[k], integrate(terms.model, qpos[k - 1], step)
            )
            # Arms caught on the wrong side of a joint limit: try the other ways to hold them.
            if cost[k] > MAX_FRAME_COST + 1.5 * np.median(cost[: k + 1]) and patience <= 0:
                patience = 10
                others = self._other_arms(qpos[k])
                q, better = self._best(solver, targets[k], others) if others else (qpos[k], np.inf)
                if better < 0.7 * cost[k]:
                    qpos[k], cost[k] = q, better
                    self._rewind(solver, targets, qpos, cost, k)
            patience -= 1
            mujoco.mj_differentiatePos(terms.model, step, 1.0, qpos[k - 1], qpos[k])
        return qpos

    @staticmethod
    def _solved(solver: InverseKinematics, target: np.ndarray, start: np.ndarray):
        solution = solver.solve(target, start)
        return solution.qpos, float(solver.weights @ solution.residual**2)

    def _best(self, solver, target, starts):
        most, solver.max_iterations = solver.max_iterations, 40
        found = [self._solved(solver, target, q) for q in starts]
        solver.max_iterations = most
        return min(found, key=lambda f: f[1])

    def _rewind(self, solver, targets, qpos, cost, k: int) -> None:
        """Carry a better solution back in time for as long as it stays better."""
        for j in range(k - 1, -1, -1):
            q, value = self._solved(solver, targets[j], qpos[j + 1])
            if value > 1.05 * cost[j] + 1e-7:
                break
            qpos[j], cost[j] = q, value

    def _other_arms(self, q: np.ndarray) -> list[np.ndarray]:
        """Return configurations with the arms held otherwise: down, forward, sideways, up."""
        return list(arm_starts(self.human, q)) if self.source.arms else []

    def _start(self) -> np.ndarray:
        """Return a standing configuration at the first frame's hips, facing their way."""
        q = self.human.standing()
        facing = self.source.rotation("pelvis")[0] @ _X
        across = self.source.at("hip_l")[0] - self.source.at("hip_r")[0]
        yaw = np.arctan2(-across[0], across[1])
        if np.hypot(*across[:2]) < 0.5 * np.linalg.norm(across):
            yaw = np.arctan2(facing[1], facing[0])
        q[:3] = self.source.middle("hip")[0]
        q[3:7] = np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)
        return q

    def errors(self, qpos: np.ndarray, rise: np.ndarray) -> np.ndarray:
        """Return how far each joint centre is from the file's, which was lifted by ``rise`` [m]."""
        bodies, places = zip(*(self.points[self.pairs[i][0]] for i in self.centres), strict=True)
        ours = PointSet(self.human, bodies, np.array(places)).path(qpos)
        theirs = np.stack([self.values[i] for i in self.centres], axis=1)
        return np.linalg.norm(ours - theirs - rise[:, None, None] * _Z, axis=2)


def _swing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotation that takes direction ``a`` to ``b``."""
    return smallest_turn(unit_vectors(a)[None], unit_vectors(b)[None])[0][0]


def _yaw(direction: np.ndarray) -> np.ndarray:
    """Return rotations about the vertical that turn x towards ``direction``."""
    return about_vertical(np.arctan2(direction[..., 1], direction[..., 0]))


def _mean_rotation(R: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to the mean of rotation matrices."""
    u, _, v = np.linalg.svd(R.mean(axis=0))
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
