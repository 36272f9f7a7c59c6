"""Take over a person's motion: clock and targets, arms that clear the body, frame after frame."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion.motion import resampled
from plantigrade.record import Record, Run
from plantigrade.robots.motion import RobotMotion
from plantigrade.robots.pose_solver import PoseSolver, RetargetSettings
from plantigrade.robots.robot import Robot
from plantigrade.robots.targets import Targets, targets_of


def retarget(
    record: Record | Run | str | Path,
    robot: Robot | str | Path,
    settings: RetargetSettings | None = None,
    *,
    names: Mapping[str, str] | None = None,
    ordered: bool = True,
    reached: Callable[[float], None] | None = None,
) -> RobotMotion:
    """Put a person's motion on a robot.

    Lengths are scaled by the ratio of leg lengths; time is kept.

    Args:
        record: The motion of a person, on level ground: a record, a run or its folder.
        robot: The robot, or its MJCF file.
        settings: Numbers of the inverse kinematics.
        names: Joint of a person → body of the robot, as :meth:`Robot.load` takes them.
        ordered: Keep the strict order; without it all tasks are one least-squares problem, the
            usual weighted inverse kinematics, for comparison.
        reached: Called with the share of frames that are done.

    Raises:
        FileError: If the robot's file cannot be read.
        FitError: If its hips, knees or ankles cannot be identified.
        ParameterError: If the ground is not level, a foot never touches it, or the motion is too
            short.
    """
    settings = settings or RetargetSettings()
    robot = robot if isinstance(robot, Robot) else Robot.load(robot, names)
    if not isinstance(record, Record):
        record = (record if isinstance(record, Run) else Run.load(record)).record
    motion = record.motion
    lasts = float(motion.time[-1] - motion.time[0])
    count = int(np.floor(lasts * settings.rate + 1e-6)) + 1
    if count < 2:
        raise ParameterError(
            f"the motion lasts {lasts:.3g} s, less than two frames at {settings.rate:g} Hz; give a "
            "longer one, or a higher rate"
        )
    clock = motion.time[0] + np.arange(count) / settings.rate
    targets = targets_of(record, resampled(motion, clock), robot)
    solver = PoseSolver(robot, settings)
    targets = _arms_clear(solver, targets, ordered)
    poses = np.empty((count, robot.model.nq))
    pose = _first_pose(robot, targets)
    for k in range(count):
        pose = solver.solve(pose, targets, k, ordered)
        poses[k] = pose
        if reached is not None:
            reached((k + 1) / count)
    return RobotMotion(robot, targets, poses)


def _arms_clear(solver: PoseSolver, targets: Targets, ordered: bool) -> Targets:
    """Return targets whose arms are abducted as little as clears the hips of the robot.

    Robots have wider hips than people, whose arms hang beside theirs.
    """
    s = solver.settings
    frames = range(0, len(targets.time), max(1, round(s.look_every * s.rate)))
    best = (np.inf, targets)
    for angle in s.abductions:
        tried = targets.abducted(np.radians(angle))
        pose, depth = _first_pose(solver.robot, tried), 0.0
        for k in frames:
            pose = solver.solve(pose, tried, k, ordered, apart=False)
            depth = max(depth, solver.arm_depth())
        if depth < best[0]:
            best = (depth, tried)
        if depth <= 0.0:
            break
    return best[1]


def _first_pose(robot: Robot, targets: Targets) -> Float[Array, " nq"]:
    """Return the standing pose where the person starts, facing the same way."""
    pose = robot.standing.copy()
    axes = targets.rotation["pelvis"][0]
    heading = Rotation.from_euler("z", np.arctan2(axes[1, 0], axes[0, 0]))
    turn = heading * Rotation.from_matrix(robot.facing).inv()
    pose[:2] = targets.hips[0, :2]
    pose[3:7] = (turn * Rotation.from_quat(pose[[4, 5, 6, 3]])).as_quat()[[3, 0, 1, 2]]
    return pose
