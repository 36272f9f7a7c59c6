"""Pink and mink on one body and three tasks, in whatever Python has them.

``python weighted_ik.py FOLDER`` reads ``model.xml`` and ``targets.npz`` from the folder and writes
``figures.json`` there. It stands alone: that Python need not have plantigrade. Both solve one
weighted quadratic program per tick in the velocity, without inequalities: where tasks conflict,
weights decide. Each tick counts kinematics, Jacobians and the program together.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

COSTS = {"heel": 100.0, "com": 10.0, "posture": 0.1}
SOLVER = "daqp"
REPEATS = 3  # runs of which the fastest counts, tick by tick


def main(folder: Path) -> None:
    """Time what can be imported; say why the rest cannot."""
    given = np.load(folder / "targets.npz")
    figures = {}
    for name, run in (("pink", run_pink), ("mink", run_mink)):
        try:
            figures[name] = run(folder / "model.xml", given)
        except ImportError as error:
            figures[name] = {"missing": str(error)}
    (folder / "figures.json").write_text(json.dumps(figures))


def run_pink(model_file: Path, given) -> dict:
    """Follow the targets with Pink on Pinocchio."""
    import pink
    import pinocchio as pin
    from pink.tasks import ComTask, FrameTask, PostureTask

    model = pin.buildModelFromMJCF(str(model_file))
    feet = []
    for side, local in zip("rl", given["heel_local"], strict=True):
        joint = model.frames[model.getFrameId(f"foot_{side}")]
        place = joint.placement * pin.SE3(np.eye(3), local)
        frame = pin.Frame(f"heel_{side}", joint.parentJoint, place, pin.FrameType.OP_FRAME)
        model.addFrame(frame)
        feet.append(FrameTask(f"heel_{side}", COSTS["heel"], 0.0))
    order = pinocchio_order(model, given["joint_names"], given["joint_counts"])
    tasks = [*feet, ComTask(COSTS["com"]), PostureTask(COSTS["posture"])]

    def follow(k: int) -> None:
        for task, place in zip(feet, given["heel"][:, k], strict=True):
            task.set_target(pin.SE3(np.eye(3), place))
        tasks[2].set_target(given["com"][k])
        tasks[3].set_target(to_pinocchio(given["posture"][k], order))

    start = to_pinocchio(given["qpos"], order)
    dt, n = float(given["step"]), len(given["com"])
    spent, missed = np.full((REPEATS, n), np.inf), np.zeros(n)
    for repeat, k in np.ndindex(REPEATS, n):
        if not k:
            configuration = pink.Configuration(model, model.createData(), start)
        follow(k)
        begin = time.perf_counter()
        velocity = pink.solve_ik(
            configuration, tasks, dt, solver=SOLVER, limits=[], safety_break=False
        )
        configuration.integrate_inplace(velocity, dt)
        spent[repeat, k] = time.perf_counter() - begin
        com = pin.centerOfMass(model, configuration.data)
        missed[k] = np.linalg.norm(com - given["com"][k])
    return summary(spent, missed, f"{pink.__version__}, pin {pin.__version__}", model.nv)


def pinocchio_order(model, names, counts) -> np.ndarray:
    """Return Pinocchio's place of each of MuJoCo's hinges.

    Pinocchio makes one joint of all hinges of a body and names it after the first.
    """
    order, first = [], 0
    for count in counts:
        name = str(names[first])
        joint = model.getJointId(name if count == 1 else f"Composite_{name}")
        order += [model.idx_qs[joint] + k for k in range(count)]
        first += count
    return np.array(order)


def to_pinocchio(qpos, order) -> np.ndarray:
    """Return a configuration with the quaternion's scalar last and the hinges in their order."""
    result = np.concatenate([qpos[:3], qpos[4:7], qpos[3:4], qpos[7:]])
    result[order] = qpos[7:]
    return result


def run_mink(model_file: Path, given) -> dict:
    """Follow the targets with mink on MuJoCo."""
    import mink
    import mujoco

    spec = mujoco.MjSpec.from_file(str(model_file))
    for side, local in zip("rl", given["heel_local"], strict=True):
        spec.body(f"foot_{side}").add_site(name=f"heel_{side}", pos=local)
    model = spec.compile()
    feet = [mink.FrameTask(f"heel_{side}", "site", COSTS["heel"], 0.0) for side in "rl"]
    tasks = [*feet, mink.ComTask(COSTS["com"]), mink.PostureTask(model, COSTS["posture"])]
    dt, n = float(given["step"]), len(given["com"])
    spent, missed = np.full((REPEATS, n), np.inf), np.zeros(n)
    for repeat, k in np.ndindex(REPEATS, n):
        if not k:
            configuration = mink.Configuration(model, given["qpos"])
        for task, place in zip(feet, given["heel"][:, k], strict=True):
            task.set_target(mink.SE3.from_translation(place))
        tasks[2].set_target(given["com"][k])
        tasks[3].set_target(given["posture"][k])
        begin = time.perf_counter()
        velocity = mink.solve_ik(configuration, tasks, dt, solver=SOLVER, limits=[])
        configuration.integrate_inplace(velocity, dt)
        spent[repeat, k] = time.perf_counter() - begin
        missed[k] = np.linalg.norm(configuration.data.subtree_com[1] - given["com"][k])
    version = f"{getattr(mink, '__version__', '')}, mujoco {mujoco.__version__}".lstrip(", ")
    return summary(spent, missed, version, model.nv)


def summary(spent, missed, version: str, nv: int) -> dict:
    """Return median and 95th percentile of a tick, and how far the centre of mass was."""
    spent = spent.min(axis=0)
    return {
        "version": version,
        "nv": int(nv),
        "median_us": 1e6 * float(np.median(spent)),
        "p95_us": 1e6 * float(np.percentile(spent, 95)),
        "com_mm": 1e3 * float(np.median(missed)),
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]))
