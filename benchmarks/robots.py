"""Retargeting to robots, in a strict order of tasks and as one weighted problem."""

import time
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from experiments.table import Row, at_most
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.robots import Robot, retarget
from plantigrade.robots.motion import MAX_DEPTH, MAX_SLIP

WHEEL_ROBOTS = {
    "mjlab": "asset_zoo/robots/unitree_g1/xmls/g1.xml",
    "mujoco_playground": "_src/dm_control_suite/xmls/humanoid.xml",
}
"""Robots in wheels: package → MJCF file in it."""


def carried() -> list[Path]:
    """Return the files of the robots of the packages that are installed."""
    found = []
    for package, file in WHEEL_ROBOTS.items():
        spec = find_spec(package)
        if spec is not None and spec.origin is not None:
            found.append(Path(spec.origin).parent / file)
    return found


def walk() -> Record:
    """Return two strides of the textbook walk."""
    human = Human.create(1.75, 73.0)
    textbook = textbook_walk(human, speed=1.2, rate=60.0, cycles=2)
    rest = np.zeros((len(textbook.time), human.model.nv))
    return Record(human, Motion(textbook.time, textbook.qpos, rest, human.joint_names))


def rows(robots: Sequence[Path] = ()) -> Iterator[Row]:
    """Yield figures of each robot, in both orders."""
    files = [*carried(), *robots]
    if not files:
        what = "no robot: pip install mjlab, or name MJCF files with --robots"
        yield Row("robots", "not measured", None, note=what)
        return
    record = walk()
    for file in files:
        robot = Robot.load(file)
        for order in ("strict", "weighted"):
            began = time.process_time()
            motion = retarget(record, robot, ordered=order == "strict")
            spent = time.process_time() - began
            f, subject = motion.figures, f"{file.stem}, {order}"
            slip, depth = (MAX_SLIP, MAX_DEPTH) if order == "strict" else (None, None)
            yield at_most(subject, "slip", f["slip_max_mm"], slip, "mm")
            yield at_most(subject, "below the ground", f["depth_max_mm"], depth, "mm")
            yield Row(subject, "hips, RMS", f["hip_error_mm"], "mm")
            yield Row(subject, "limbs, RMS", f["limb_error_deg"], "deg")
            yield Row(subject, "of processors, a frame", 1000 * spent / len(motion.qpos), "ms")
