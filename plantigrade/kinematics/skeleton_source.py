"""A file's skeleton by our names: joint centres, bone rotations, lengths."""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.errors import FitError
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.models.anatomy import hip, lumbar, shoulder
from plantigrade.models.anthropometry import Dimensions, dimensions
from plantigrade.models.joint_names import JointMap
from plantigrade.motion.filters import derivative, lowpass
from plantigrade.motion.recording import SkeletonMotion, rate_of

_X, _Y, _Z = np.eye(3)


class SkeletonSource:
    """The file's skeleton by our names: joint centres, bone rotations, lengths."""

    def __init__(self, skeleton: SkeletonMotion, found: JointMap):
        self.skeleton, self.found = skeleton, found
        self.time = skeleton.time
        self.rate = rate_of(self.time)

    def has(self, name: str) -> bool:
        """Return whether the file has a joint."""
        return name in self.found.joints

    def at(self, name: str) -> np.ndarray:
        """Return the path of a joint [m]."""
        return self.skeleton.positions[:, self.found[name]]

    def rest(self, name: str) -> np.ndarray:
        """Return where a joint is in the rest pose [m]."""
        return self.skeleton.rest_positions[self.found[name]]

    def rotation(self, name: str) -> np.ndarray:
        """Return how the bone below a joint is turned in every frame."""
        return self.skeleton.rotations[:, self.found[name]]

    def above(self, name: str) -> np.ndarray:
        """Return the rotations of the bone that ends in a joint: the last one before it.

        Skeletons with twist bones, and ASF's forearm of two bones, turn there.
        """
        return self.skeleton.rotations[:, self.skeleton.parents[self.found[name]]]

    def distance(self, a: str, b: str) -> float:
        """Return the median distance of two joints [m]."""
        return float(np.median(np.linalg.norm(self.at(a) - self.at(b), axis=1)))

    def mean_length(self, a: str, b: str) -> float:
        """Return the distance of two joints, mean of both sides [m]."""
        return float(np.mean([self.distance(f"{a}_{s}", f"{b}_{s}") for s in SIDES]))

    def middle(self, name: str) -> np.ndarray:
        """Return the middle of a joint of both sides in every frame [m]."""
        return 0.5 * (self.at(f"{name}_r") + self.at(f"{name}_l"))

    @property
    def arms(self) -> bool:
        """Whether shoulders and elbows are there."""
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
        both = self.found.both("shoulder")
        return float(np.linalg.norm(self.rest_rise()[[0, 2]])) if both else None

    def stature(self) -> float:
        """Return the stature of a usual person with these legs and this trunk [m]."""
        unit = dimensions(1.7)
        legs = self.mean_length("hip", "knee") + self.mean_length("knee", "ankle")
        if not legs > 0:
            raise FitError("the skeleton's legs have no length")
        own, usual = legs, unit.thigh + unit.shank
        trunk = self.trunk()
        if trunk is not None and 0.35 < trunk / legs < 1.0:
            own, usual = own + trunk, usual + _shoulder_height(unit)
        return 1.7 * own / usual

    def lengths(self, height: float, sex: str) -> dict[str, float]:
        """Return the lengths of a person with this skeleton, if it determines them."""
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
            low, high = height - legs - np.array([1.2, 0.8]) * usual.head
            both = usual.pelvis_height + usual.trunk
            factor = float(np.clip(trunk / _shoulder_height(usual), low / both, high / both))
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
            height, smooth, speed = path[:, 2], path - way, np.zeros(len(path))
            if len(path) > 15 and self.rate > 25:
                smooth = lowpass(self.time, smooth, cutoff=10.0)
            if len(path) > 3:
                speed = np.linalg.norm(derivative(self.time, smooth), axis=1)
            calm &= (height < np.quantile(height, 0.03) + 0.03) & (np.nan_to_num(speed) < 0.25)
        return np.flatnonzero(calm)


def _shoulder_height(d: Dimensions) -> float:
    """Return the height of the shoulder joints above the hip joints, standing [m]."""
    return float(np.linalg.norm((lumbar(d) + shoulder(d) - hip(d))[[0, 2]]))
