"""A guest of the push benchmark: DeepMind's humanoid, walked by SIMBICON.

The model is that of ``dm_control`` (``pip install dm_control``), 41 kg and 21 torque motors. The
controller is SIMBICON [Yin2007]_: a swing and a landing pose, the swing hip led by the distance and
speed of the centre of mass from the foot that stands, the pelvis held upright by the hip that
stands. From a checkout::

    plantigrade experiment push-any-controller --controller experiments/guest_humanoid.py:Humanoid
"""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np

from experiments.guest import Guest


@dataclass(frozen=True)
class Simbicon:
    """Constants of the controller, from a random search.

    It asked for 0.8 m/s, little effort, and pushes of 60 to 150 N × 0.4 s from four sides.
    """

    swing_time: float = 0.22  #: before the swing leg is lowered [s]
    hip: tuple[float, float] = (0.669, 0.192)  #: flexion of the swing thigh: early, late [rad]
    knee: tuple[float, float] = (1.407, 0.265)  #: flexion of the swing knee: early, late [rad]
    stance_knee: float = 0.136  #: [rad]
    ahead: tuple[float, float] = (0.425, 0.272)  #: thigh by distance and speed [rad/m, rad s/m]
    aside: tuple[float, float] = (0.632, 0.283)  #: abduction likewise [rad/m, rad s/m]
    width: float = 0.035  #: of the stance, at which abduction is that of standing [m]
    abduction: float = 0.004  #: [rad]
    lean: float = 0.049  #: of the pelvis [rad]
    speed: float = 0.8  #: [m/s]
    toes: float = 0.092  #: dorsiflexion of the swing foot [rad]
    trunk: tuple[float, float] = (385.0, 14.8)  #: gains [N m/rad, N m s/rad]
    turning: tuple[float, float] = (60.0, 8.0)  #: gains about the vertical
    hips: float = 352.0  #: [N m/rad]; damping is a tenth of all of these, in seconds
    knees: float = 130.0
    ankles: float = 65.0
    landed: float = 30.0  #: load at which a foot has landed [N]


class Humanoid(Guest):
    """DeepMind's humanoid."""

    trunk, feet, rate = "torso", {"r": "right_foot", "l": "left_foot"}, 200.0

    def __init__(self):
        package = find_spec("dm_control")
        if package is None or not package.submodule_search_locations:
            raise ImportError("the model comes with dm_control: pip install dm_control")
        folder = Path(package.submodule_search_locations[0])
        self.model = mujoco.MjModel.from_xml_path(str(folder / "suite" / "humanoid.xml"))
        self.how, self.stance, self.since = Simbicon(), "left", 0.0

    def start(self, data):
        """Begin in a step, with the right leg in front."""
        data.joint("right_hip_y").qpos, data.joint("right_knee").qpos = -0.3, -0.3
        data.joint("left_hip_y").qpos, data.joint("left_knee").qpos = 0.1, -0.1
        data.qvel[:2] = 0.9 * self.how.speed, 0.15
        mujoco.mj_kinematics(self.model, data)
        sole = [g for g in range(self.model.ngeom) if "_foot" in self.model.geom(g).name]
        data.qpos[2] -= min(data.geom_xpos[g][2] - self.model.geom_size[g][0] for g in sole)

    def __call__(self, data):
        """Return the torques, each as a fraction of its motor's."""
        how, model = self.how, self.model
        swing = "right" if self.stance == "left" else "left"
        late = data.time - self.since > how.swing_time
        if late and self._load(data, swing) > how.landed:
            self.stance, swing, self.since, late = swing, self.stance, data.time, False
        stance, torque = self.stance, {}

        def hold(joint: str, target: float, gain: float, damping: float) -> None:
            at = data.joint(joint)
            torque[joint] = gain * (target - at.qpos[0]) - damping * at.qvel[0]

        # pelvis: yaw, pitch (nose down), roll (to the right); motion seen along the heading
        r = data.body("pelvis").xmat.reshape(3, 3)
        yaw = np.arctan2(r[1, 0], r[0, 0])
        pitch, roll = np.arctan2(r[0, 2], r[2, 2]), np.arctan2(-r[1, 2], r[2, 2])
        heading = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        spin = np.zeros(6)
        mujoco.mj_objectVelocity(
            model, data, mujoco.mjtObj.mjOBJ_BODY, model.body("pelvis").id, spin, 0
        )
        turning = np.append(heading @ spin[:2], spin[2])
        mujoco.mj_subtreeVel(model, data)
        speed = heading @ data.subtree_linvel[1][:2]
        far = heading @ (data.subtree_com[1] - data.body(f"{stance}_foot").xpos)[:2]

        # swing leg: placed by the distance and speed of the centre of mass
        hip = data.joint(f"{swing}_hip_y")
        flexion = how.hip[late] + how.ahead[0] * far[0] + how.ahead[1] * (speed[0] - how.speed)
        error = flexion + hip.qpos[0] + pitch
        torque[f"{swing}_hip_y"] = -how.hips * (error + 0.1 * (hip.qvel[0] + turning[1]))
        side = 1.0 if swing == "left" else -1.0
        hip = data.joint(f"{swing}_hip_x")
        out = how.abduction + side * (
            how.aside[0] * (far[1] - side * how.width) + how.aside[1] * speed[1]
        )
        error = out + hip.qpos[0] - side * roll
        torque[f"{swing}_hip_x"] = -how.hips * (error + 0.1 * (hip.qvel[0] - side * turning[0]))
        hold(f"{swing}_hip_z", 0.0, 40.0, 4.0)
        hold(f"{swing}_knee", -how.knee[late], how.knees, 0.1 * how.knees)

        # stance leg: carries the pelvis upright, against the torque of the swing leg
        up = how.trunk[0] * (how.lean - pitch) - how.trunk[1] * turning[1]
        torque[f"{stance}_hip_y"] = -up - torque[f"{swing}_hip_y"]
        level = -how.trunk[0] * roll - how.trunk[1] * turning[0]
        torque[f"{stance}_hip_x"] = torque[f"{swing}_hip_x"] - side * level
        ahead = -how.turning[0] * yaw - how.turning[1] * turning[2]
        torque[f"{stance}_hip_z"] = -side * ahead
        hold(f"{stance}_knee", -how.stance_knee, 2.0 * how.knees, 0.15 * how.knees)

        # feet, trunk, arms
        flat = data.joint(f"{swing}_knee").qpos[0] - data.joint(f"{swing}_hip_y").qpos[0] - pitch
        for leg, target, part in ((swing, flat + how.toes, 0.5), (stance, 0.0, 1.0)):
            hold(f"{leg}_ankle_y", target, part * how.ankles, 0.05 * how.ankles)
            hold(f"{leg}_ankle_x", 0.0, part * how.ankles, 0.05 * how.ankles)
        for joint in ("abdomen_x", "abdomen_y", "abdomen_z"):
            hold(joint, 0.0, 300.0, 20.0)
        for arm, sign in (("right", 1.0), ("left", -1.0)):
            hold(f"{arm}_shoulder1", 0.6 * sign, 20.0, 2.0)
            hold(f"{arm}_shoulder2", -0.6 * sign, 20.0, 2.0)
            hold(f"{arm}_elbow", -1.2, 20.0, 2.0)
        names = [model.actuator(i).name for i in range(model.nu)]
        return np.clip([torque[n] for n in names] / model.actuator_gear[:, 0], -1.0, 1.0)

    def _load(self, data, leg: str) -> float:
        """Return the load of a foot, as its touch sensors tell [N]."""
        inner, outer = ("right", "left") if leg == "left" else ("left", "right")
        return float(
            data.sensor(f"{inner}_{leg}_foot_touch").data[0]
            + data.sensor(f"{outer}_{leg}_foot_touch").data[0]
        )
