"""A run of every engine passes the check that the documentation prints, in plain MuJoCo."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import plantigrade as pg
from plantigrade import Ground
from plantigrade.record import Record, Run
from tests.analyze.plated_walk import analyse, plated_walk
from tests.analyze.standing import standing_record
from tests.stored.make import MOTIONS, stored

PAGE = Path(__file__).parents[1] / "docs" / "run-folder.md"
NAMED = "runs/fit-walk"
FRAMES = (0.2, 0.35, 0.5, 0.65, 0.8)


def recipe() -> str:
    """Return the recipe in the documentation."""
    text = PAGE.read_text(encoding="utf-8").split("can be checked without plantigrade")[1]
    return text.split("```python\n")[1].split("```")[0]


def self_check(folder: Path, share: float, motion: str = "motion.npz") -> tuple[np.ndarray, float]:
    """Run the recipe on a frame of a folder; return the residuals of the root and of the
    torques."""
    with np.load(folder / motion) as stored:
        frame = int(share * len(stored["time"]))
    code = recipe()
    assert f"{NAMED}/motion.npz" in code and f"{NAMED}/model.xml" in code and "frame = 50" in code
    code = code.replace(f"{NAMED}/motion.npz", str(folder / motion))
    own = folder / motion.replace("npz", "xml")  # of a body other than that of model.xml
    code = code.replace(f"{NAMED}/model.xml", str(own if own.exists() else folder / "model.xml"))
    code = code.replace(NAMED, str(folder)).replace("frame = 50", f"frame = {frame}")
    printed: list = []
    exec(compile(code, str(PAGE), "exec"), {"print": printed.append})
    root, off = printed
    return root, float(off)


@pytest.mark.parametrize("feet", ["rigid", "two-segment", "multi-segment"])
def test_a_recording_over_force_plates(tmp_path, feet):
    record = analyse(plated_walk(feet).fit(), cutoff=None).record()
    folder = Run(record, "fit").save(tmp_path / "run").folder
    for share in FRAMES:
        root, off = self_check(folder, share)
        assert off < 1e-6  # [N m]
        assert np.abs(root).max() < 0.01 * record.weight


@pytest.mark.parametrize("ground", [Ground(), Ground(friction=0.5)])
def test_a_record_of_the_checker(tmp_path, ground):
    record = replace(standing_record(), ground=ground)
    folder = Run(record, "synthesize").save(tmp_path / "run").folder
    for share in FRAMES:
        root, off = self_check(folder, share)
        assert off < 1e-9 and np.abs(root).max() < 1e-6


def test_a_simulation_pushed_on_uneven_ground(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    how = {"duration": 0.3, "rate": 600.0, "feet": "rigid", "joints": "42"}
    run = pg.simulate(ground="bumps:1", push=("50,0.1,30,0.1",), **how).save()
    for share in FRAMES:
        root, off = self_check(run.folder, share)
        assert off < 0.5 and np.abs(root).max() < 0.002 * run.record.weight


@pytest.mark.slow
def test_a_vault(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = pg.vault(starts=1, evaluations=120, optimiser="evolution").save()
    for share in FRAMES:
        root, off = self_check(run.folder, share)
        assert off < 1e-9 and np.abs(root).max() < 1e-9 * run.record.weight


@pytest.mark.slow
def test_a_reproduced_walk_moved_by_forces(demo):
    folder = demo.folder / "runs" / "demo-reproduced"
    weight = Run.load(folder).record.weight
    for share in FRAMES:
        root, off = self_check(folder, share, "forces.npz")
        assert off < 1e-6
        assert np.abs(root).max() < 0.02 * weight


def carried(folder: Path, record: Record) -> None:
    """Forces and torques of a solved motion satisfy the recipe at every part of it."""
    for share in FRAMES:
        root, off = self_check(folder, share)
        assert off < 1e-6
        assert np.abs(root).max() < 0.02 * record.weight


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_from_a_task(tmp_path, name):
    record = stored(name).record
    folder = Run(record, "synthesize").save(tmp_path / "run").folder
    carried(folder, record)


def test_the_motors_of_the_shipped_model_make_the_motion(tmp_path):
    """Plain MuJoCo, forward: the stored forces of motors and ground give the accelerations."""
    record = stored("sit-to-stand").record
    folder = Run(record, "synthesize").save(tmp_path / "run").folder
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, apart = mujoco.MjData(model), 0.0
    with np.load(folder / "motion.npz") as motion:
        for f in range(0, len(motion["time"]), 40):
            data.qpos[:], data.qvel[:] = motion["qpos"][f], motion["qvel"][f]
            mujoco.mj_fwdPosition(model, data)
            given = motion["qfrc_motor"][f].copy()
            for k, body in enumerate(motion["contact_segment"]):
                force, point = motion["contact_force"][f, k], motion["contact_point"][f, k]
                if force.any():
                    at = model.body(str(body)).id
                    mujoco.mj_applyFT(model, data, force, np.zeros(3), point, at, given)
            data.qfrc_applied[:] = given
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(data.qacc, motion["qacc"][f], atol=1e-6)
            person = given - motion["qfrc_motor"][f] + motion["qfrc_actuator"][f]
            data.qfrc_applied[:] = person
            mujoco.mj_forward(model, data)
            apart = max(apart, float(np.abs(data.qacc - motion["qacc"][f]).max()))
    assert apart > 1.0  # rad/s²: the joint torques alone do not make the motion of that model


def test_a_seat_is_in_the_model(tmp_path):
    record = stored("sit-to-stand").record
    out = Run(record, "synthesize").save(tmp_path / "run").folder
    model = mujoco.MjModel.from_xml_path(str(out / "model.xml"))
    data = mujoco.MjData(model)
    data.qpos[:] = record.motion.qpos[0]
    data.qpos[2] -= 1e-3
    mujoco.mj_forward(model, data)
    touched = {model.geom(g).name for pair in data.contact.geom for g in pair}
    assert {"seat_0", "contact_seat_r", "contact_seat_l", "floor"} <= touched
