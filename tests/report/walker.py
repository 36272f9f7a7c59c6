"""A small capsule human and a made-up walk, with markers and forces, for the pages to draw."""

import mujoco
import numpy as np

from plantigrade.motion import GaitEvent, Markers, Motion
from plantigrade.record import Record

THIGH, SHANK, PELVIS = 0.42, 0.42, 0.93
SPEED, STRIDE = 1.25, 1.1


def _leg(side: str, y: float) -> str:
    bones = "".join(
        f'<geom type="capsule" size=".012" mass=".06" fromto="0 {dy} -.01 .12 {1.3 * dy} -.035"/>'
        for dy in (-0.03, -0.01, 0.01, 0.03)
    )
    return f"""
    <body name="femur_{side}" pos="0 {y} -.05">
      <joint name="hip_adduction_{side}" axis="1 0 0"/>
      <joint name="hip_flexion_{side}" axis="0 -1 0"/>
      <geom type="capsule" size=".065" fromto="0 0 0 0 0 -{THIGH - 0.06}" mass="8"/>
      <body name="tibia_{side}" pos="0 0 -{THIGH}">
        <joint name="knee_angle_{side}" axis="0 1 0"/>
        <geom type="capsule" size=".045" fromto="0 0 0 0 0 -{SHANK - 0.05}" mass="3.5"/>
        <body name="calcn_{side}" pos="0 0 -{SHANK}">
          <joint name="ankle_angle_{side}" axis="0 -1 0"/>
          <geom type="capsule" size=".028" fromto="-.04 0 -.02 .02 0 -.01" mass=".5"/>
          {bones}
          <body name="toes_{side}" pos=".12 0 -.035">
            <joint name="mtp_angle_{side}" axis="0 -1 0"/>
            <geom type="capsule" size=".012" fromto="0 -.03 0 .06 -.03 0" mass=".05"/>
            <geom type="capsule" size=".012" fromto="0 .0 0 .06 .0 0" mass=".05"/>
            <geom type="capsule" size=".012" fromto="0 .03 0 .05 .03 0" mass=".05"/>
          </body>
        </body>
      </body>
    </body>"""


def _arm(side: str, y: float) -> str:
    return f"""
    <body name="humerus_{side}" pos="0 {y} .38">
      <joint name="arm_flex_{side}" axis="0 -1 0"/>
      <geom type="capsule" size=".04" fromto="0 0 0 0 0 -.26" mass="2"/>
      <body name="ulna_{side}" pos="0 0 -.29"><joint name="elbow_flex_{side}" axis="0 -1 0"/>
        <geom type="capsule" size=".03" fromto="0 0 0 0 0 -.22" mass="1.2"/>
        <geom type="ellipsoid" size=".035 .02 .06" pos="0 0 -.3" mass=".4"/></body>
    </body>"""


MJCF = f"""<mujoco><worldbody><geom type="plane" size="5 5 .1"/>
  <body name="pelvis" pos="0 0 {PELVIS}"><freejoint name="root"/>
    <geom type="ellipsoid" size=".1 .15 .09" mass="10"/>
    {_leg("r", -0.09)}{_leg("l", 0.09)}
    <body name="torso" pos="0 0 .1"><joint name="lumbar_extension" axis="0 -1 0"/>
      <geom type="capsule" size=".11" fromto="0 -.05 .2 0 .05 .2" mass="20"/>
      <geom type="box" size=".07 .12 .1" pos="0 0 .08" mass="5"/>
      <geom type="sphere" size=".1" pos=".02 0 .58" mass="5"/>
      <geom type="cylinder" size=".045 .05" pos="0 0 .43" mass="1"/>
      {_arm("r", -0.2)}{_arm("l", 0.2)}
    </body>
  </body></worldbody></mujoco>"""


def walker() -> mujoco.MjModel:
    """Return the capsule human."""
    return mujoco.MjModel.from_xml_string(MJCF)


def walk(model: mujoco.MjModel, *, duration: float = 4.0, rate: float = 100.0) -> Record:
    """Return a walk with forces, markers (one with a gap) and a reference motion."""
    time = np.arange(round(duration * rate) + 1) / rate
    qpos = np.zeros((len(time), model.nq))
    qpos[:, 3] = 1
    columns = {model.joint(j).name: model.jnt_qposadr[j] for j in range(1, model.njnt)}
    loads = {}
    for side, shift in (("r", 0.0), ("l", 0.5)):
        phase = 2 * np.pi * (time / STRIDE + shift)
        cycle = (time / STRIDE + shift) % 1
        qpos[:, columns[f"hip_flexion_{side}"]] = np.radians(10 + 22 * np.cos(phase))
        qpos[:, columns[f"knee_angle_{side}"]] = np.radians(
            8
            + 12 * np.exp(-(((cycle - 0.14) / 0.07) ** 2))
            + 52 * np.exp(-(((cycle - 0.72) / 0.1) ** 2))
        )
        qpos[:, columns[f"ankle_angle_{side}"]] = np.radians(
            8 * np.sin(phase * 1 - 1.2) - 18 * np.exp(-(((cycle - 0.63) / 0.06) ** 2))
        )
        sign = 1 if side == "r" else -1
        qpos[:, columns[f"hip_adduction_{side}"]] = -sign * np.radians(4 * np.sin(phase))
        qpos[:, columns[f"mtp_angle_{side}"]] = np.radians(
            30 * np.exp(-(((cycle - 0.58) / 0.06) ** 2))
        )
        qpos[:, columns[f"arm_flex_{side}"]] = np.radians(-18 * np.cos(phase))
        qpos[:, columns[f"elbow_flex_{side}"]] = np.radians(25 - 8 * np.cos(phase))
        loads[side] = np.where(cycle < 0.62, np.sin(np.pi * cycle / 0.62), 0) * (
            1.05 + 0.25 * np.cos(4 * np.pi * cycle / 0.62)
        )
    qpos[:, 0] = SPEED * time
    qpos[:, 1] = 0.02 * np.sin(2 * np.pi * time / STRIDE + np.pi)
    data = mujoco.MjData(model)
    soles = np.zeros((len(time), 2, 3))
    feet = [model.body(f"calcn_{side}").id for side in "rl"]
    for i in range(len(time)):
        data.qpos[:] = qpos[i]
        data.qpos[2] = PELVIS
        mujoco.mj_kinematics(model, data)
        low = min(
            data.geom_xpos[g, 2]
            - abs(data.geom_xmat[g, 8]) * model.geom_size[g, 1]
            - model.geom_size[g, 0]
            for g in range(model.ngeom)
            if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_CAPSULE
        )
        qpos[i, 2] = PELVIS - low
        soles[i] = data.xpos[feet] * [1, 1, 0]
    weight = model.body_mass.sum() * 9.81
    force = np.zeros((len(time), 2, 3))
    point = np.full((len(time), 2, 3), np.nan)
    for k, side in enumerate("rl"):
        cycle = (time / STRIDE + (0.5 if side == "l" else 0)) % 1
        force[:, k, 2] = weight * loads[side]
        force[:, k, 0] = (
            -0.18 * weight * np.where(cycle < 0.62, np.sin(2 * np.pi * cycle / 0.62), 0)
        )
        loaded = force[:, k, 2] > 20
        point[loaded, k] = soles[loaded, k] + np.outer(
            np.clip(cycle[loaded] / 0.62, 0, 1) * 0.2 - 0.04, [1, 0, 0]
        )
        if side == "r":
            force[:, k, 1] = 0.04 * force[:, k, 2]
        else:
            force[:, k, 1] = -0.04 * force[:, k, 2]
    rng = np.random.default_rng(1)
    bodies = [b for b in range(1, model.nbody)]
    fitted = np.zeros((len(time), 2 * len(bodies), 3))
    for i in range(len(time)):
        data.qpos[:] = qpos[i]
        mujoco.mj_kinematics(model, data)
        fitted[i, ::2] = data.xpos[bodies] + [0.05, 0, 0]
        fitted[i, 1::2] = data.xpos[bodies] + [0, 0.05, -0.03]
    recorded = fitted + rng.normal(0, 0.006, fitted.shape[1:]) + rng.normal(0, 0.002, fitted.shape)
    recorded[100:140, 3] = np.nan
    recorded[:, 7] = np.nan
    names = tuple(f"{model.body(b).name.upper()}{n}" for b in bodies for n in "12")
    reference = qpos.copy()
    reference[:, columns["knee_angle_r"]] *= 0.7
    reference[:, columns["hip_flexion_l"]] *= 1.2
    events = tuple(
        GaitEvent(float((k - shift + offset) * STRIDE), side, kind)
        for side, shift in (("r", 0.0), ("l", 0.5))
        for k in range(5)
        for kind, offset in (("heel_strike", 0.0), ("toe_off", 0.62))
        if 0 <= (k - shift + offset) * STRIDE <= duration
    )
    qvel = np.zeros((len(time), model.nv))
    for i in range(len(time)):
        a, b = max(i - 1, 0), min(i + 1, len(time) - 1)
        mujoco.mj_differentiatePos(model, qvel[i], time[b] - time[a], qpos[a], qpos[b])
    torque = np.zeros((len(time), model.nv))
    for j in range(1, model.njnt):
        torque[:, model.jnt_dofadr[j]] = -40 * np.sin(2 * np.pi * time / STRIDE + j)
    return Record(
        motion=Motion(
            time=time,
            qpos=qpos,
            qvel=qvel,
            joint_names=tuple(model.joint(j).name for j in range(model.njnt)),
            events=tuple(sorted(events, key=lambda e: e.time)),
        ),
        qfrc_actuator=torque,
        contact_force=force,
        contact_point=point,
        contact_side=("r", "l"),
        contact_segment=("1", "2"),
        reference_qpos=reference,
        recorded_markers=Markers(names=names, time=time, positions=recorded),
        fitted_markers=fitted,
        metrics={"status": "ok", "marker_rms_mm": 10.2, "version": "0.1.0"},
        warnings=("Marker 'TIBIA_R2' is never seen.",),
    )
