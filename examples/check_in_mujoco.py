"""Check a run in plain MuJoCo: python check_in_mujoco.py [RUN]. A squat is made where none is."""

import sys
from pathlib import Path

import mujoco
import numpy as np

if len(sys.argv) > 1:
    folder = Path(sys.argv[1])
else:
    import plantigrade as pg

    folder = pg.synthesize("squat").report().parent

model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
motion = np.load(folder / "motion.npz")
model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT  # no contacts, no joint limits
data = mujoco.MjData(model)
worst = np.zeros(2)
for frame in range(len(motion["time"])):
    data.qpos, data.qvel, data.qacc = (motion[key][frame] for key in ("qpos", "qvel", "qacc"))
    mujoco.mj_inverse(model, data)
    explained = np.zeros(model.nv)
    for k, body in enumerate(motion["contact_segment"]):
        force, point = motion["contact_force"][frame, k], motion["contact_point"][frame, k]
        if force.any():
            mujoco.mj_applyFT(model, data, force, 0 * force, point, model.body(body).id, explained)
    tau = data.qfrc_inverse - explained
    off = np.abs(tau[:6]).max(), np.abs(tau - motion["qfrc_motor"][frame])[6:].max()
    worst = np.maximum(worst, off)
print(f"{worst[0]:.1e} N unexplained at the root, motor torques {worst[1]:.1e} N m apart")
