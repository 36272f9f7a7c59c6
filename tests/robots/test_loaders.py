"""Files of a retargeted motion, read by the programs that they are for.

The tests skip where a program is not installed.
"""

import importlib
import os
import subprocess

import numpy as np
import pytest

from plantigrade.models import Human
from plantigrade.robots import RetargetSettings, Robot, retarget
from tests.robots.biped import biped
from tests.textbook import walk_record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """A stride on a robot, and its folder."""
    folder = tmp_path_factory.mktemp("walk")
    record = walk_record(Human.create(1.75, 73.0), speed=1.2, rate=60.0, cycles=1)
    # loco-mujoco finds joints by their names, the free one too
    text = biped().replace("<freejoint/>", '<freejoint name="root"/>')
    (folder / "robot.xml").write_text(text)
    robot = Robot.load(folder / "robot.xml")
    motion = retarget(record, robot, RetargetSettings(rate=25.0))
    return motion, motion.save(folder / "out")


def imported(name):
    try:
        return importlib.import_module(name)
    except Exception as error:  # whatever a package that does not suit this MuJoCo raises
        pytest.skip(f"{name} cannot be imported: {type(error).__name__}")


def test_mjlab_reads_the_motion(walked):
    torch = imported("torch")
    commands = imported("mjlab.tasks.tracking.mdp.commands")
    motion, folder = walked
    bodies = torch.arange(motion.robot.model.nbody - 1)
    read = commands.MotionLoader(str(folder / "motion.npz"), bodies)
    assert read.time_step_total == len(motion.qpos)
    assert read.joint_pos.numpy() == pytest.approx(motion.qpos[:, 7:], abs=1e-6)
    assert read.joint_vel.numpy() == pytest.approx(motion.qvel[:, 6:], abs=1e-5)
    for theirs, ours in (("pos", "position"), ("quat", "quaternion"), ("lin_vel", "velocity")):
        assert getattr(read, f"body_{theirs}_w").numpy() == pytest.approx(
            motion.bodies[ours], abs=1e-5
        )


LOCO = """
import sys
import mujoco, numpy
from loco_mujoco.trajectory.handler import TrajectoryHandler

model = mujoco.MjModel.from_xml_path("robot.xml")
rate = float(sys.argv[1])
read = TrajectoryHandler(model, traj_path="out/trajectory.npz", control_dt=1 / rate)
data, found = mujoco.MjData(model), read.traj.data
data.qpos, data.qvel = numpy.asarray(found.qpos[10]), numpy.asarray(found.qvel[10])
mujoco.mj_forward(model, data)
off = [abs(numpy.asarray(getattr(found, name)[10]) - getattr(data, name)).max()
       for name in ("xpos", "cvel", "subtree_com")]
numpy.savez("read.npz", qpos=numpy.asarray(found.qpos), off=off, length=read.len_trajectory(0))
"""


def test_loco_mujoco_reads_the_trajectory(walked):
    """By a Python of its own: it needs MuJoCo 3.2.7."""
    python = os.environ.get("LOCO_MUJOCO_PYTHON")
    if python is None:
        pytest.skip("LOCO_MUJOCO_PYTHON names no Python with loco-mujoco")
    motion, folder = walked
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = [python, "-c", LOCO, str(motion.rate)]
    subprocess.run(words, cwd=folder.parent, env=plain, check=True)
    read = np.load(folder.parent / "read.npz")
    assert read["length"] == len(motion.qpos)
    assert read["qpos"] == pytest.approx(motion.qpos, abs=1e-5)
    assert read["off"].max() < 1e-4
