"""A person and a made-up walk, with markers and forces, for the pages to draw."""

import functools

import mujoco
import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import ContactSite
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Markers, Motion
from plantigrade.record import Record

SPEED, STRIDE = 1.25, 1.1


@functools.cache
def walker() -> Human:
    """Return the person."""
    return Human.create(1.75, 73.0)


def walk(human: Human, *, duration: float = 4.0, rate: float = 100.0) -> Record:
    """Return a walk with forces, markers (one with a gap) and a reference motion."""
    model = human.model
    time = np.arange(round(duration * rate) + 1) / rate
    qpos = np.tile(human.standing(), (len(time), 1))
    columns = {name: 7 + human.hinge(name) for name in human.joint_names[1:]}
    loads = {}
    for side, shift in (("r", 0.0), ("l", 0.5)):
        phase = 2 * np.pi * (time / STRIDE + shift)
        cycle = (time / STRIDE + shift) % 1
        bumps = {at: np.exp(-(((cycle - at) / w) ** 2)) for at, w in ((0.14, 0.07), (0.72, 0.1))}
        push = np.exp(-(((cycle - 0.61) / 0.06) ** 2))
        angles = {
            "hip_flexion": 10 + 22 * np.cos(phase),
            "knee_angle": 8 + 12 * bumps[0.14] + 52 * bumps[0.72],
            "ankle_angle": 8 * np.sin(phase - 1.2) - 18 * push,
            "hip_adduction": 4 * np.sin(phase),
            "mtp_angle": 30 * push,
            "arm_flex": -18 * np.cos(phase),
            "elbow_flex": 25 - 8 * np.cos(phase),
        }
        for name, values in angles.items():
            qpos[:, columns[f"{name}_{side}"]] = np.radians(values)
        loads[side] = np.where(cycle < 0.62, np.sin(np.pi * cycle / 0.62), 0) * (
            1.05 + 0.25 * np.cos(4 * np.pi * cycle / 0.62)
        )
    qpos[:, 0] += SPEED * time
    qpos[:, 1] += 0.02 * np.sin(2 * np.pi * time / STRIDE + np.pi)
    soles, bodies = _on_the_ground(model, qpos)
    force, point = _forces(human.mass * GRAVITY, time, loads, soles)
    fitted = np.repeat(bodies, 2, axis=1)
    fitted[:, ::2] += [0.05, 0, 0]
    fitted[:, 1::2] += [0, 0.05, -0.03]
    rng = np.random.default_rng(1)
    recorded = fitted + rng.normal(0, 0.006, fitted.shape[1:]) + rng.normal(0, 0.002, fitted.shape)
    recorded[100:140, 3] = np.nan
    recorded[:, 7] = np.nan
    names = tuple(f"{model.body(b).name.upper()}{n}" for b in range(1, model.nbody) for n in "12")
    reference = qpos.copy()
    reference[:, columns["knee_angle_r"]] *= 0.7
    reference[:, columns["hip_flexion_l"]] *= 1.2
    qvel, torque = np.zeros((len(time), model.nv)), np.zeros((len(time), model.nv))
    for i in range(len(time)):
        a, b = max(i - 1, 0), min(i + 1, len(time) - 1)
        mujoco.mj_differentiatePos(model, qvel[i], time[b] - time[a], qpos[a], qpos[b])
    for j in range(6, model.nv):
        torque[:, j] = -40 * np.sin(2 * np.pi * time / STRIDE + j)
    events = tuple(e for e in _events() if 0 <= e.time <= duration)
    return Record(
        human,
        Motion(time, qpos, qvel, human.joint_names, events=events),
        qfrc_actuator=torque,
        sites=tuple(
            ContactSite(body=f"foot_{s}", name=f"plate_{s}", side=s, measured=True) for s in "rl"
        ),
        contact_force=force,
        contact_point=point,
        references={"recorded": Motion(time, reference, qvel, human.joint_names)},
        recorded_markers=Markers(names=names, time=time, positions=recorded),
        fitted_markers=fitted,
        notes=("Marker 'TIBIA_R2' is never seen.",),
    )


def _on_the_ground(model, qpos) -> tuple[np.ndarray, np.ndarray]:
    """Lower the body until it touches the ground; return where the feet and all bodies are."""
    data = mujoco.MjData(model)
    soles, bodies = np.zeros((len(qpos), 2, 3)), np.zeros((len(qpos), model.nbody - 1, 3))
    feet = [model.body(f"foot_{side}").id for side in "rl"]
    spheres = [g for g in range(model.ngeom) if model.geom(g).name.startswith("contact_")]
    for i in range(len(qpos)):
        data.qpos[:] = qpos[i]
        mujoco.mj_kinematics(model, data)
        qpos[i, 2] -= (data.geom_xpos[spheres, 2] - model.geom_size[spheres, 0]).min()
        data.qpos[:] = qpos[i]
        mujoco.mj_kinematics(model, data)
        soles[i] = data.xpos[feet] * [1, 1, 0]
        bodies[i] = data.xpos[1:]
    return soles, bodies


def _forces(weight, time, loads, soles) -> tuple[np.ndarray, np.ndarray]:
    """Return ground reactions, right then left, and the centres of pressure."""
    force, point = np.zeros((len(time), 2, 3)), np.full((len(time), 2, 3), np.nan)
    for k, side in enumerate("rl"):
        cycle = (time / STRIDE + (0.5 if side == "l" else 0)) % 1
        braking = np.where(cycle < 0.62, np.sin(2 * np.pi * cycle / 0.62), 0)
        force[:, k, 2] = weight * loads[side]
        force[:, k, 0] = -0.18 * weight * braking
        force[:, k, 1] = (0.04 if side == "r" else -0.04) * force[:, k, 2]
        loaded = force[:, k, 2] > 20
        ahead = np.clip(cycle[loaded] / 0.62, 0, 1) * 0.2 - 0.04
        point[loaded, k] = soles[loaded, k] + np.outer(ahead, [1, 0, 0])
    return force, point


def _events() -> list[GaitEvent]:
    found = [
        GaitEvent(float((k - shift + offset) * STRIDE), side, kind)
        for side, shift in (("r", 0.0), ("l", 0.5))
        for k in range(5)
        for kind, offset in (("heel_strike", 0.0), ("toe_off", 0.62))
    ]
    return sorted(found, key=lambda e: e.time)
