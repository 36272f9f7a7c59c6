r"""Put the motion of another skeleton (ASF/AMC, BVH, DeepMimic) on a person.

**Lengths.** Thigh, shank, hip and shoulder width, upper arm, forearm, trunk and foot are those of
the file's skeleton; stature follows from legs and trunk by the usual proportions.

**Directions.** Joint centres tell where bones point. How a bone is turned about its own axis, and
how pelvis, thorax, head, hands and feet are turned, comes from the file's bone rotations

.. math:: R_{ours}(t) = R_{file}(t)\, A,

with a constant :math:`A` for every bone. Pelvis and head are upright in the rest pose,
:math:`A = 1`. Thigh and upper arm: :math:`A` swings our bone onto the file's in its rest pose, then
turns it about itself so that the hinge of knee or elbow is the axis about which the file's lower
bone turned in the motion. Foot and toes: :math:`A` makes them flat, pointing along the foot, in the
frames in which the file's foot stands flat; so a file's toe base may lie where it likes. Hands:
thumbs point forward in the rest pose where no thumb says otherwise.

**Poses.** Inverse kinematics on joint centres and these directions, joint limits hard. Then the
motion is moved down to the ground and the feet are planted
(:mod:`plantigrade.kinematics.planting`).
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import mujoco
import numpy as np

from plantigrade.constants import SIDES
from plantigrade.errors import FitError
from plantigrade.kinematics.ground_level import level, moving_ground
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.rests import drift_of, find_rests
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import PointSet, integrate
from plantigrade.kinematics.terms import Terms
from plantigrade.models import Human
from plantigrade.models.anthropometry import Dimensions, dimensions
from plantigrade.models.joint_names import JointMap, identify
from plantigrade.motion import Recording
from plantigrade.motion.filters import derivative, lowpass
from plantigrade.motion.recording import SkeletonMotion, rate_of
from plantigrade.motion.turning import quarter_turn_to_face_x, turn

Progress = Callable[[str, int, int], None]

# Joints and the part of our anatomy that hangs on each.
CENTRES = {
    "hip": "femur",
    "knee": "tibia",
    "ankle": "foot",
    "shoulder": "humerus",
    "elbow": "ulna",
    "wrist": "hand",
}
ARM_JOINTS = ("shoulder", "elbow", "wrist")
SCALE_TOLERANCE = 0.06  # of a given stature against the skeleton's, before the file is rescaled
BENT = np.deg2rad(25)  # a hinge bent further than this in the motion shows its axis [rad]
FLAT_TILT = np.deg2rad(25)  # largest tilt of a foot against the rest pose that can be flat [rad]
UNEVEN = 0.08  # feet that sink deeper than this before they are planted are worth a word [m]
LOST = 4e-3  # weighted squares of a frame above which other arm postures are tried [m^2]
ARM_STARTS = (  # flexion, adduction, rotation [rad]
    (0.0, 0.0, 0.0),
    (1.5, 0.0, 0.0),
    (0.0, -1.5, 0.0),
    (2.8, 0.0, 0.0),
    (0.0, -2.7, 0.0),
    (1.2, -1.2, 1.2),
    (1.2, -1.2, -1.2),
    (-0.8, -0.5, 0.0),
)
ARM = 0.20  # length of the vectors that stand for an orientation [m]

# Weights of the terms: joint centres, and vectors of length ARM along bone axes.
WEIGHTS = {
    "hip": 1.0,
    "knee": 1.0,
    "ankle": 1.0,
    "shoulder": 0.4,
    "elbow": 0.4,
    "wrist": 0.4,
    "pelvis": 0.6,
    "thigh": 0.06,
    "shank": 0.02,
    "foot": 0.4,
    "toes": 0.05,
    "thorax": 0.2,
    "thorax_up": 0.02,
    "head": 0.2,
    "upper_arm": 0.02,
    "hand": 0.05,
    "hand_axis": 0.05,
}
_X, _Y, _Z = np.eye(3)


def fit_skeleton(
    recording: Recording,
    *,
    height: float | None = None,
    mass: float | None = None,
    sex: str | None = None,
    joints: str = "42",
    feet: str | None = None,
    names: Mapping[str, str] | None = None,
    plant: bool = True,
    progress: Progress | None = None,
) -> Fit:
    """Put the motion of another skeleton on a person with its lengths.

    Args:
        recording: The recording; it must have a skeleton.
        height: Stature [m]; estimated from the skeleton where neither this nor the file says it.
            Where it differs by more than 6 % from the skeleton's, the file is scaled to it.
        mass: Body mass [kg]; 22.5 times height squared where nobody says.
        sex: ``"female"`` or ``"male"``; male where nobody says.
        joints: Joint set.
        feet: Kind of foot; the joint set's own if not given.
        names: Our joints → the file's names, for skeletons whose names tell nothing
            (``{"hip_l": "Bone7"}``).
        plant: Whether standing feet are held on the ground.
        progress: Called with (what, done, total).

    Raises:
        FitError: If there is no skeleton, or its hips, knees and ankles cannot be told.
    """
    skeleton = recording.skeleton
    if skeleton is None:
        raise FitError(f"{recording.source} has no skeleton to retarget")
    if len(skeleton.time) < 2:
        raise FitError(f"{recording.source} has {len(skeleton.time)} frames; two are needed")
    if not (np.isfinite(skeleton.positions).all() and np.isfinite(skeleton.rotations).all()):
        raise FitError(f"{recording.source}: the skeleton has gaps (NaN); fill them first")
    notes: list[str] = []
    found = identify(skeleton.names, skeleton.parents, skeleton.rest_positions, names)
    if found.swapped:
        notes.append(
            "the feet point backwards as the joints were told by shape: left and right may be "
            "exchanged (say names)."
        )
    if found.by == "shape":
        told = ", ".join(f"{k} = {skeleton.names[i]}" for k, i in sorted(found.joints.items()))
        notes.append(f"the joints' names are unknown; they were told by shape: {told}.")
    source = _Source(skeleton, found)
    angle = quarter_turn_to_face_x(source.facing())
    if angle:
        recording = turn(recording, angle)
        assert recording.skeleton is not None
        source = _Source(recording.skeleton, found)
    said = recording.subject
    height = height or said.height
    stature = source.stature()
    if height and abs(height / stature - 1) > SCALE_TOLERANCE:
        notes.append(
            f"the skeleton is that of a person of {stature:.2f} m; it was scaled by "
            f"{height / stature:.3f} to the height given, {height:.2f} m."
        )
        recording = replace(recording, skeleton=_scaled(recording.skeleton, height / stature))
        assert recording.skeleton is not None
        source = _Source(recording.skeleton, found)
    elif not height:
        notes.append(
            f"the stature is not in the file; {stature:.2f} m was found from the skeleton "
            "(give --height to set it)."
        )
    height = float(height or np.clip(stature, 0.5, 2.5))
    sex = sex or said.sex or "male"
    mass = mass or said.mass or 22.5 * height**2
    lengths = source.lengths(height, sex)
    human = Human.create(height, mass, sex, joints, feet, lengths)
    rate = rate_of(source.time)
    targets = _Targets(human, source)
    n = len(source.time)
    report = _reporter(progress, "following the skeleton", n)
    qpos = targets.follow(report)
    way = source.way()
    qpos, rise = level(human, qpos, rate, way=way)
    rests = find_rests(sole_paths(human, qpos), rate, way=way)
    before = sole_paths(human, qpos)
    if plant and rests:
        qpos = plant_feet(
            human,
            qpos,
            rate=rate,
            rests=rests,
            way=way,
            progress=_reporter(progress, "planting the feet", n),
        )
    elif plant:
        notes.append("no foot ever rests on the ground; the feet were left as they are.")
    after = sole_paths(human, qpos)
    middle = float(np.median(rise))
    if abs(middle) > 0.10:
        notes.append(f"the motion was moved vertically by {middle:+.2f} m to stand on the ground.")
    if np.ptp(rise) > 0.02:
        notes.append(
            f"the file's ground slopes by {1e3 * np.ptp(rise):.0f} mm along the way; it was made "
            "level."
        )
    sunk = float(before.penetration.max())
    if plant and rests and sunk > UNEVEN:
        notes.append(
            f"feet were up to {1e3 * sunk:.0f} mm under the level ground (uneven terrain?); they "
            "were lifted onto it."
        )
    if np.abs(np.ptp(way, axis=0)).max() > 0:
        notes.append("the ground moves under the feet (a treadmill, or walking in place).")
    error = targets.errors(qpos, rise)
    metrics = {
        "joint_rms_mm": 1e3 * float(np.sqrt((error**2).mean())),
        "joint_error_max_mm": 1e3 * float(error.max()),
        "ground_shift_mm": 1e3 * middle,
        "ground_slope_mm": 1e3 * float(np.ptp(rise)),
        "stances": len(rests),
        **_contact_metrics(before, rests, way, "_before"),
        **_contact_metrics(after, rests, way, ""),
        "skeleton_height_m": stature,
        "height_m": human.height,
        **{f"length_{k}_m": getattr(human.dimensions, k) for k in human.dimensions.names()},
    }
    return Fit(
        human=human,
        time=source.time,
        qpos=qpos,
        recording=recording,
        source_kind="skeleton",
        heading=angle,
        metrics=metrics,
        warnings=tuple(recording.warnings) + tuple(notes),
    )


def _reporter(progress: Progress | None, what: str, total: int):
    return (lambda k: progress(what, k, total)) if progress else None


def _contact_metrics(contact, rests, way, suffix: str) -> dict[str, float]:
    drift = drift_of(contact, rests, way) if rests else np.zeros(1)
    depth = contact.penetration
    return {
        f"foot_drift_mean_mm{suffix}": 1e3 * float(drift.mean()),
        f"foot_drift_max_mm{suffix}": 1e3 * float(drift.max()),
        f"penetration_mean_mm{suffix}": 1e3 * float(depth.mean()),
        f"penetration_max_mm{suffix}": 1e3 * float(depth.max()),
    }


def _scaled(skeleton: SkeletonMotion | None, factor: float) -> SkeletonMotion:
    assert skeleton is not None
    return replace(
        skeleton,
        positions=skeleton.positions * factor,
        rest_positions=skeleton.rest_positions * factor,
        ends=skeleton.ends * factor,
    )


def _unit(v: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(size > 1e-12, size, 1.0)


def _swing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotation that takes direction ``a`` to ``b``."""
    from scipy.spatial.transform import Rotation

    a, b = _unit(a), _unit(b)
    axis, cosine = np.cross(a, b), float(a @ b)
    size = np.linalg.norm(axis)
    if size < 1e-9:
        return np.eye(3) if cosine > 0 else Rotation.from_rotvec(np.pi * _X).as_matrix()
    return Rotation.from_rotvec(axis / size * np.arctan2(size, cosine)).as_matrix()


def _yaw(direction: np.ndarray) -> np.ndarray:
    """Return rotations about the vertical that turn x towards ``direction``."""
    c, s = np.moveaxis(_unit(direction[..., :2]), -1, 0)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.stack([np.stack(r, axis=-1) for r in rows], axis=-2)


def _mean_rotation(R: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to the mean of rotation matrices."""
    u, _, v = np.linalg.svd(R.mean(axis=0))
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v


class _Source:
    """The file's skeleton by our names: joint centres, bone rotations, lengths."""

    def __init__(self, skeleton: SkeletonMotion, found: JointMap):
        self.skeleton, self.found = skeleton, found
        self.time = skeleton.time
        self.rate = rate_of(self.time)

    def has(self, name: str) -> bool:
        return name in self.found.joints

    def at(self, name: str) -> np.ndarray:
        """Return the path of a joint [m]."""
        return self.skeleton.positions[:, self.found[name]]

    def rest(self, name: str) -> np.ndarray:
        return self.skeleton.rest_positions[self.found[name]]

    def rotation(self, name: str) -> np.ndarray:
        return self.skeleton.rotations[:, self.found[name]]

    def above(self, name: str) -> np.ndarray:
        """Return the rotations of the bone that ends in a joint: the last one before it.

        Skeletons with twist bones, and ASF's forearm of two bones, turn there.
        """
        return self.skeleton.rotations[:, self.skeleton.parents[self.found[name]]]

    def distance(self, a: str, b: str) -> float:
        return float(np.median(np.linalg.norm(self.at(a) - self.at(b), axis=1)))

    def mean_length(self, a: str, b: str) -> float:
        """Return the distance of two joints, mean of both sides [m]."""
        return float(np.mean([self.distance(f"{a}_{s}", f"{b}_{s}") for s in SIDES]))

    def middle(self, name: str) -> np.ndarray:
        return 0.5 * (self.at(f"{name}_r") + self.at(f"{name}_l"))

    @property
    def arms(self) -> bool:
        return self.found.both("shoulder") and self.found.both("elbow")

    def facing(self) -> float:
        """Return the direction the pelvis faces on the mean, from x towards y [rad]."""
        across = self.at("hip_l") - self.at("hip_r")
        return float(np.angle(np.mean(across[:, 1] - 1j * across[:, 0])))

    def rest_rise(self) -> np.ndarray:
        """Return the way from mid-hip to mid-shoulder in the rest pose [m]."""
        both = [self.rest(f"shoulder_{s}") - self.rest(f"hip_{s}") for s in SIDES]
        return np.mean(both, axis=0)

    def trunk(self) -> float | None:
        """Return the height of the shoulders above the hips along the rest pose's trunk [m]."""
        if not self.found.both("shoulder"):
            return None
        rise = self.rest_rise()
        return float(np.linalg.norm(rise[[0, 2]]))

    def stature(self) -> float:
        """Return the stature of a usual person with these legs and this trunk [m]."""
        unit = dimensions(1.7)
        legs = self.mean_length("hip", "knee") + self.mean_length("knee", "ankle")
        own, usual = legs, unit.thigh + unit.shank
        trunk = self.trunk()
        if trunk is not None and 0.35 < trunk / legs < 1.0:
            own, usual = own + trunk, usual + _shoulder_height(unit)
        if not own > 0:
            raise FitError("the skeleton's legs have no length")
        return 1.7 * own / usual

    def lengths(self, height: float, sex: str) -> dict[str, float]:
        """Return the lengths of a person with this skeleton; what it cannot tell is left out."""
        usual = dimensions(height, sex)

        def near(name: str, value: float, share: float) -> float:
            middle = getattr(usual, name)
            return float(np.clip(value, (1 - share) * middle, (1 + share) * middle))

        found = {
            "thigh": near("thigh", self.mean_length("hip", "knee"), 0.35),
            "shank": near("shank", self.mean_length("knee", "ankle"), 0.35),
        }
        half = 0.5 * self.distance("hip_r", "hip_l")
        found["pelvis_width"] = near("pelvis_width", (half - 0.0073) / 0.33, 0.35)
        if self.arms:
            found["upper_arm"] = near("upper_arm", self.mean_length("shoulder", "elbow"), 0.35)
            if self.found.both("wrist"):
                found["forearm"] = near("forearm", self.mean_length("elbow", "wrist"), 0.35)
        if self.found.both("shoulder"):
            wide = self.distance("shoulder_r", "shoulder_l")
            found["shoulder_width"] = near("shoulder_width", wide, 0.40)
        trunk = self.trunk()
        if trunk is not None:
            # The head makes up for the rest of the stature, within a fifth of its usual length.
            legs = usual.ankle_height + found["thigh"] + found["shank"]
            factor = trunk / _shoulder_height(usual)
            both = usual.pelvis_height + usual.trunk
            high = (height - legs - 0.8 * usual.head) / both
            low = (height - legs - 1.2 * usual.head) / both
            factor = float(np.clip(factor, low, high))
            if 0.6 < factor < 1.6:
                found["pelvis_height"] = factor * usual.pelvis_height
                found["trunk"] = factor * usual.trunk
        tip = self._foot_reach()
        if tip is not None:
            found["foot_length"] = near("foot_length", tip / (0.130 / 0.240), 0.15)
        return found

    def _foot_reach(self) -> float | None:
        """Return the way from the ankle forward to the toe base, mean of both sides [m]."""
        if not self.found.both("ball"):
            return None
        bone = self.mean_length("ankle", "ball")
        down = 0.6 * 0.039 * self.stature()
        return float(np.sqrt(max(bone**2 - down**2, 1e-6)))

    def forefoot(self, side: str) -> np.ndarray:
        """Return the path of a point in front of the ankle that moves with the foot [m]."""
        ankle, name = self.at(f"ankle_{side}"), f"ball_{side}"
        if self.has(name) and np.linalg.norm(self.rest(name) - self.rest(f"ankle_{side}")) > 0.02:
            return self.at(name)
        end = self.skeleton.ends[:, self.found[f"ankle_{side}"]]
        if np.isfinite(end).all() and np.linalg.norm(end - ankle, axis=1).min() > 0.02:
            return end
        reach = 0.08 * self.stature()
        return ankle + self.rotation(f"ankle_{side}") @ (reach * _X - 0.03 * _Z)

    def way(self) -> np.ndarray:
        """Return the path of the ground under the feet [m]: zero but on a treadmill."""
        heel = np.stack([self.at("ankle_l"), self.at("ankle_r")], axis=1)
        toe = np.stack([self.forefoot("l"), self.forefoot("r")], axis=1)
        return moving_ground(self.time, heel, toe)

    def flat(self, side: str) -> np.ndarray:
        """Return the frames in which a foot stands flat, by its heights and speeds alone."""
        way = self.way()
        calm = np.ones(len(self.time), bool)
        for path in (self.at(f"ankle_{side}"), self.forefoot(side)):
            height = path[:, 2]
            smooth = path - way
            if len(path) > 15 and self.rate > 25:
                smooth = lowpass(self.time, smooth, cutoff=10.0)
            speed = (
                np.linalg.norm(derivative(self.time, smooth), axis=1)
                if len(path) > 3
                else np.zeros(len(path))
            )
            calm &= (height < np.quantile(height, 0.03) + 0.03) & (np.nan_to_num(speed) < 0.25)
        return np.flatnonzero(calm)


def _shoulder_height(d: Dimensions) -> float:
    """Return the height of the shoulder joints above the hip joints, standing [m]."""
    from plantigrade.models.anatomy import hip, lumbar, shoulder

    return float(np.linalg.norm((lumbar(d) + shoulder(d) - hip(d))[[0, 2]]))


class _Targets:
    """What the person's joints and segments are to match in every frame."""

    def __init__(self, human: Human, source: _Source):
        self.human, self.source = human, source
        self.points: list[tuple[str, np.ndarray]] = []
        self.pairs: list[tuple[int, int]] = []
        self.values: list[np.ndarray] = []
        self.weights: list[float] = []
        self.centres: list[tuple[str, int]] = []
        self._joint_centres()
        self._pelvis_and_thorax()
        self._head()
        for side in SIDES:
            self._leg(side)
            self._foot(side)
            if source.arms:
                self._arm(side)

    # -- terms

    def _point(self, body: str, position: np.ndarray) -> int:
        self.points.append((body, np.asarray(position, float)))
        return len(self.points) - 1

    def _add_position(self, body: str, position, values: np.ndarray, weight: float) -> None:
        self.pairs.append((self._point(body, position), -1))
        self.values.append(values)
        self.weights.append(weight)

    def _add_axis(self, part: str, axis: np.ndarray, values: np.ndarray, weight: float) -> None:
        """Ask for the axis of a part (zero pose: world axes) to point along ``values``."""
        body = self.human.skeleton.parts[part][0]
        start = self._point(body, np.zeros(3))
        end = self._point(body, ARM * axis)
        self.pairs.append((end, start))
        self.values.append(ARM * values)
        self.weights.append(weight)

    def _joint_centres(self) -> None:
        moved = self._shoulder_offset()
        for joint, part in CENTRES.items():
            if not self.source.found.both(joint):
                continue
            for side in SIDES:
                name = f"{joint}_{side}"
                body, position = self.human.skeleton.parts[f"{part}_{side}"]
                self.centres.append((name, len(self.pairs)))
                path = self.source.at(name) + (moved if joint in ARM_JOINTS else 0.0)
                self._add_position(body, position, path, WEIGHTS[joint])

    def _shoulder_offset(self) -> np.ndarray:
        """Return what to add to the file's shoulders and arms in every frame [m].

        Skeletons differ in how far the shoulders lie before or behind the hips when the trunk is
        upright, as it is in the rest pose of both; the difference moves with the thorax.
        """
        source = self.source
        if not (source.found.both("shoulder") and source.has("thorax")):
            return np.zeros((len(source.time), 3))
        rise = source.rest_rise()
        x, z = self._neutral_trunk()
        offset = float(np.clip(x - rise[0] * z / rise[2], -0.1, 0.1)) if rise[2] > 0.1 else 0.0
        return source.rotation("thorax") @ (offset * _X)

    def _pelvis_and_thorax(self) -> None:
        source = self.source
        R = source.rotation("pelvis")
        for axis in (_X, _Z):
            self._add_axis("pelvis", axis, R @ axis, WEIGHTS["pelvis"])
        if not source.has("thorax"):
            return
        R = source.rotation("thorax")
        self._add_axis("thorax", _Y, R @ _Y, WEIGHTS["thorax"])
        self._add_axis("thorax", _Z, R @ _Z, WEIGHTS["thorax_up"])

    def _neutral_trunk(self) -> tuple[float, float]:
        from plantigrade.models.anatomy import hip, lumbar, shoulder

        d = self.human.dimensions
        rise = lumbar(d) + shoulder(d) - hip(d)
        return float(rise[0]), float(rise[2])

    def _head(self) -> None:
        name = next((j for j in ("head", "neck") if self.source.has(j)), None)
        if name is None:
            return
        R = self.source.rotation(name)
        for axis in (_X, _Z):
            self._add_axis("head", axis, R @ axis, WEIGHTS["head"])

    # -- limbs

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
        upper, lower = _unit(source.at(b) - source.at(a)), _unit(source.at(c) - source.at(b))
        axis = np.cross(upper, lower)  # points left for a knee, right for an elbow
        sine = np.linalg.norm(axis, axis=1)
        bent = sine > np.sin(BENT)
        if bent.sum() < 3:
            return A
        axis = np.einsum("nji,nj->ni", R, axis)[bent].mean(axis=0)
        if np.linalg.norm(axis) < 0.7 * sine[bent].mean():
            return A  # no hinge: the axis turns with the motion
        axis = _unit(A.T @ axis) * (1.0 if backwards else -1.0)
        ours = self._bend_axis("tibia" if backwards else "ulna", side)
        turn = np.arctan2(axis[1], axis[0]) - np.arctan2(ours[1], ours[0])
        cos, sin = np.cos(turn), np.sin(turn)
        return A @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])

    def _bend_axis(self, part: str, side: str) -> np.ndarray:
        """Return our hinge's axis in the zero pose, the sense in which it points left."""
        coordinate = {"tibia": "knee_angle", "ulna": "elbow_flex"}[part]
        from plantigrade.models.human import coordinate_of

        axis = coordinate_of(f"{coordinate}_{side}").axis_of(side)
        return axis * np.sign(axis[1])

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
        along = _unit(wrist - source.rest(f"elbow_{side}"))
        R = source.rotation(f"wrist_{side}")
        thumb = self._thumb(side, along)
        outward = _Y if side == "l" else -_Y  # where the thumb points in our zero pose
        self._add_axis(f"hand_{side}", outward, R @ thumb, WEIGHTS["hand"])
        distal = along
        if source.has(f"knuckle_{side}"):
            hand = source.rest(f"knuckle_{side}") - wrist
            distal = _unit(hand) if np.linalg.norm(hand) > 0.02 else along
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
                return _unit(square)
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
            own = np.swapaxes(R[flat], 1, 2) @ _yaw(forward[flat])
            own = _mean_rotation(own)
            tilt = np.arccos(np.clip((rest.T @ own)[2, 2], -1, 1))
            if tilt < FLAT_TILT:
                A = own
        for axis in (_X, _Y):
            self._add_axis(f"foot_{side}", axis, R @ (A @ axis), WEIGHTS["foot"])
        ball = f"ball_{side}"
        part = next(
            (p for p in (f"toes_{side}", f"medial_phalanges_{side}") if self._moves(p)), None
        )
        if source.has(ball) and part:
            T = source.rotation(ball)
            relative = np.swapaxes(R, 1, 2) @ T
            B = _mean_rotation(relative[flat]) if len(flat) >= 3 else np.eye(3)
            self._add_axis(part, _X, T @ (B.T @ A @ _X), WEIGHTS["toes"])

    def _moves(self, part: str) -> bool:
        return part in self.human.skeleton.parts and part in self.human.body_names

    # -- solving

    def follow(self, report=None) -> np.ndarray:
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
            if cost[k] > LOST + 1.5 * np.median(cost[: k + 1]) and patience <= 0:
                patience = 10
                others = self._other_arms(qpos[k])
                q, better = self._best(solver, targets[k], others) if others else (qpos[k], np.inf)
                if better < 0.7 * cost[k]:
                    qpos[k], cost[k] = q, better
                    self._rewind(solver, targets, qpos, cost, k)
            patience -= 1
            mujoco.mj_differentiatePos(terms.model, step, 1.0, qpos[k - 1], qpos[k])
            if report and k % 50 == 0:
                report(k + 1)
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
        names = self.human.coordinates
        if not self.source.arms:
            return []
        result = []
        for flexion, adduction, rotation in ARM_STARTS:
            other = q.copy()
            for side in SIDES:
                for c, v in (
                    ("arm_flex", flexion),
                    ("arm_add", adduction),
                    ("arm_rot", rotation),
                    ("elbow_flex", 0.6),
                ):
                    if f"{c}_{side}" in names:
                        other[7 + self.human.hinge(f"{c}_{side}")] = v
            result.append(other)
        return result

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
        picked = [i for _, i in self.centres]
        bodies, places = zip(*(self.points[self.pairs[i][0]] for i in picked), strict=True)
        ours = PointSet(self.human, bodies, np.array(places)).path(qpos)
        theirs = np.stack([self.values[i] for i in picked], axis=1)
        return np.linalg.norm(ours - theirs - rise[:, None, None] * _Z, axis=2)
