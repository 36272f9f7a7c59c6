r"""Inverse kinematics of a robot in a strict order of tasks.

In every frame the change :math:`\Delta q` of the pose solves, step by step of a Newton iteration,
the hierarchy :math:`J_k \Delta q = e_k` of

0. joint ranges and speeds, as bounds;
1. feet on the ground: where they touch it they stand still, and nothing is below it;
2. the feet otherwise: how far they are pitched, and their way through the air;
3. no part inside another one, as far as the model has shapes that collide;
4. hips and pelvis, trunk;
5. directions of thighs, shanks, upper arms and forearms, and the head,

by :func:`~plantigrade.wbc.hierarchy.solve_hierarchy`: what a level needs, none below it can take
away. The last one is damped, and what is free in it goes back to the standing pose: with the metric
:math:`H = J_5^T J_5 + \lambda I`, the preferred change is
:math:`H^{-1} (J_5^T e_5 + \lambda\, \Delta q_0)`.
"""

from copy import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.robots.robot import Robot, part_contacts
from plantigrade.robots.targets import FLAT, HEEL, SWING, Targets
from plantigrade.wbc.hierarchy import solve_hierarchy
from plantigrade.wbc.level import Level
from plantigrade.wbc.tasks.point import rotation_to


@dataclass(frozen=True, kw_only=True)
class RetargetSettings:
    """Numbers of the inverse kinematics."""

    rate: float = 50.0
    """Frames per second [Hz]: the control rate of most learned humanoids."""
    max_speed: float = 20.0
    """Maximum speed of a hinge [rad/s]; motors of humanoids reach 10 to 37."""
    iterations: int = 6
    """Maximum number of steps per frame; 2 to 3 are usual."""
    first_iterations: int = 60
    """The same for the first frame, which starts from the standing pose."""
    max_step: float = 0.1
    """Maximum change of a hinge in one step [rad]: a hand moves by less than ``sight``."""
    tolerance: float = 1e-3
    """Change of every coordinate at which a frame is solved [rad, m]."""
    return_share: float = 0.05
    """Share of the way to the standing pose that free joints go in a frame [1]."""
    damping: float = 0.03
    """Weight of a change of a hinge against an error of a direction, :math:`\\lambda` [1]."""
    singular: float = 0.05
    """Gain below which a direction is left to the next level [m/rad or 1]: straight legs."""
    clearance: float = 0.005
    """Least distance of two parts that are no neighbours [m], unless they stand closer."""
    sight: float = 0.05
    """Distance from which parts, or a sole and the ground, are kept apart [m]."""
    abductions: tuple[float, ...] = (0.0, 4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0)
    """Angles by which arms are held away from the body [deg]; the first that clears it is taken."""
    look_every: float = 0.1
    """Time between two frames in which arms are tried [s]."""
    retreat: float = 0.01
    """Maximum distance that parts inside one another move apart in a step [m]."""
    trunk_weight: float = 0.5
    """Weight of the trunk's orientation against that of the pelvis in their level [1]."""


class PoseSolver:
    """The pose of a robot, solved frame by frame."""

    def __init__(self, robot: Robot, settings: RetargetSettings):
        self.robot, self.settings, model = robot, settings, robot.model
        self.near = copy(model)  # parts that come near are contacts
        self.near.geom_margin[:] = np.maximum(model.geom_margin, settings.sight / 2)
        self.near.geom_gap[:] = 0.0
        self.data = data = mujoco.MjData(model)
        data.qpos[:] = robot.standing
        mujoco.mj_kinematics(self.near, data)
        mujoco.mj_collision(self.near, data)
        self.clearance: dict[tuple[int, int], float] = {}  # pair of bodies → least distance
        for pair, contact in part_contacts(self.near, data):
            least = min(settings.clearance, float(contact.dist))
            self.clearance[pair] = min(self.clearance.get(pair, least), least)
        pelvis = robot.joints["pelvis"]
        hips = [self._point(f"hip_{side}") for side in ("r", "l")]
        axes = data.xmat[pelvis].reshape(3, 3)
        self.hips = axes.T @ (np.mean(hips, axis=0) - data.xpos[pelvis])
        parts = ("pelvis", "torso", "head")
        self.rest = {
            name: robot.facing.T @ data.xmat[robot.joints[name]].reshape(3, 3)
            for name in parts
            if name in robot.joints
        }
        ends = {*robot.joints.values(), *(sole.body for sole in robot.soles.values())}
        ends -= {robot.joints[n] for n in ("wrist_r", "wrist_l") if n in robot.joints}
        moving = {body for end in ends for body in _up(model, end)}
        #: Hinges that no target needs, such as the wrists': they stay as in the standing pose
        self.idle = np.array([b not in moving for b in model.jnt_bodyid[1:].tolist()], dtype=bool)
        shoulders = {robot.joints[n] for n in ("shoulder_r", "shoulder_l") if n in robot.joints}
        self.arms = [bool(shoulders & set(_up(model, b))) for b in range(model.nbody)]
        limited = model.jnt_limited[1:] != 0
        self.low = np.where(limited, model.jnt_range[1:, 0], -np.inf)
        self.high = np.where(limited, model.jnt_range[1:, 1], np.inf)

    def _point(self, name: str) -> Float[Array, " 3"]:
        body = self.robot.joints[name]
        axes = self.data.xmat[body].reshape(3, 3)
        return self.data.xpos[body] + axes @ self.robot.points[name]

    def _jacobian(self, point: Float[Array, " 3"], body: int):
        """Return the Jacobians of a point of a body and of the body's rotation, world."""
        nv = self.robot.model.nv
        along, about = np.zeros((3, nv)), np.zeros((3, nv))
        mujoco.mj_jac(self.robot.model, self.data, along, about, point, body)
        return along, about

    def solve(
        self,
        start: Float[Array, " nq"],
        targets: Targets,
        k: int,
        ordered: bool,
        *,
        apart: bool = True,
    ) -> Float[Array, " nq"]:
        """Return the pose of a frame, from that of the frame before."""
        s, model = self.settings, self.robot.model
        pose = start.copy()
        span = np.pi if k == 0 else s.max_speed / s.rate
        least = np.maximum(self.low, start[7:] - span)
        most = np.minimum(self.high, start[7:] + span)
        least, most = np.minimum(least, self.high), np.maximum(most, self.low)
        least[self.idle] = most[self.idle] = start[7:][self.idle]
        rest = start[7:] + s.return_share * (self.robot.standing[7:] - start[7:])
        count = s.first_iterations if k == 0 else s.iterations
        for _ in range(count):
            self.data.qpos[:] = pose
            mujoco.mj_kinematics(self.near, self.data)
            mujoco.mj_comPos(self.near, self.data)
            mujoco.mj_collision(self.near, self.data)
            levels = self._levels(targets, k, apart)
            if not ordered:
                levels = [_together(levels)]
            *levels, limbs = levels
            lower = np.full(model.nv, -s.max_step)
            upper = -lower
            lower[6:] = np.clip(least - pose[7:], -s.max_step, 0.0)
            upper[6:] = np.clip(most - pose[7:], 0.0, s.max_step)
            back = np.zeros(model.nv)
            back[6:] = np.clip(rest - pose[7:], -s.max_step, s.max_step)
            metric = limbs.matrix.T @ limbs.matrix + s.damping * np.eye(model.nv)
            change = solve_hierarchy(
                levels,
                lower=lower,
                upper=upper,
                preferred=np.linalg.solve(metric, limbs.matrix.T @ limbs.lower + s.damping * back),
                metric=metric,
                singular=s.singular,
            ).x
            mujoco.mj_integratePos(model, pose, change, 1.0)
            pose[7:] = np.clip(pose[7:], self.low, self.high)  # by rounding alone
            if np.abs(change).max() < s.tolerance:
                break
        return pose

    def _levels(self, targets: Targets, k: int, apart: bool) -> list[Level]:
        stand, feet = _Rows(), _Rows()
        for side in self.robot.soles:
            self._foot(side, targets, k, stand, feet)
        away, trunk, limbs = self._apart() if apart else _Rows(), _Rows(), _Rows()
        pelvis = self.robot.joints["pelvis"]
        point = self.data.xpos[pelvis] + self.data.xmat[pelvis].reshape(3, 3) @ self.hips
        along, _ = self._jacobian(point, pelvis)
        trunk.add(along, targets.hips[k] - point)
        for name, goals in targets.rotation.items():
            rows = limbs if name == "head" else trunk
            weight = 1.0 if name == "pelvis" else self.settings.trunk_weight
            body = self.robot.joints[name]
            goal = goals[k] @ self.rest[name]
            _, about = self._jacobian(self.data.xpos[body], body)
            rows.add(weight * about, weight * rotation_to(goal, self.data.xmat[body].reshape(3, 3)))
        for (a, b), goals in targets.direction.items():
            ends = [(self._point(name), self.robot.joints[name]) for name in (a, b)]
            along = ends[1][0] - ends[0][0]
            length = float(np.linalg.norm(along))
            own = self._jacobian(*ends[1])[0] - self._jacobian(*ends[0])[0]
            across = np.eye(3) - np.outer(along, along) / length**2
            limbs.add(across @ own / length, across @ (goals[k] - along / length))
        parts = {"standing feet": stand, "feet": feet, "parts": away, "trunk": trunk}
        parts["limbs"] = limbs
        return [rows.level(name) for name, rows in parts.items() if rows.matrix]

    def _apart(self) -> "_Rows":
        """Return the rows that keep parts out of one another."""
        rows, s = _Rows(), self.settings
        nearest: dict[tuple[int, int], mujoco.MjContact] = {}
        for pair, contact in part_contacts(self.near, self.data):
            if pair not in nearest or contact.dist < nearest[pair].dist:
                nearest[pair] = contact
        for pair, contact in nearest.items():
            a, b = (int(k) for k in self.robot.model.geom_bodyid[contact.geom])
            relative = self._jacobian(contact.pos, b)[0] - self._jacobian(contact.pos, a)[0]
            missing = self.clearance.get(pair, s.clearance) - float(contact.dist)
            missing = np.array([min(missing, s.retreat)])
            rows.add(contact.frame[None, :3] @ relative, missing, above=True)
        return rows

    def arm_depth(self) -> float:
        """Return how far arms are nearer to the rest of the body than they may be [m]."""
        arms, depth = self.arms, 0.0
        for (a, b), contact in part_contacts(self.near, self.data):
            if arms[a] != arms[b]:
                least = self.clearance.get((a, b), self.settings.clearance)
                depth = max(depth, least - float(contact.dist))
        return depth

    def _foot(self, side: str, targets: Targets, k: int, stand: "_Rows", feet: "_Rows") -> None:
        """Add the rows of a foot."""
        sole, phase = self.robot.soles[side], targets.phase[side][k]
        goal_place, goal = targets.position[side][k], targets.orientation[side][k]
        place = self.data.xpos[sole.body]
        axes = self.data.xmat[sole.body].reshape(3, 3)
        now = axes @ sole.rotation
        origin = place + axes @ sole.origin
        pivot = np.zeros(3)
        if phase not in (SWING, FLAT):
            pivot = sole.edge("heel" if phase == HEEL else "toe")
        point = origin + now @ pivot
        along, about = self._jacobian(point, sole.body)
        turn = rotation_to(goal, now)
        if phase == SWING:
            feet.add(along, goal_place + goal @ pivot - point)
            feet.add(about, turn)
        else:
            stand.add(along, goal_place + goal @ pivot - point)
            split = goal.T @ about, goal.T @ turn  # about x, y and z of the foot
            held = [0, 1, 2] if phase == FLAT else [0, 2]
            stand.add(split[0][held], split[1][held])
            if phase != FLAT:
                feet.add(split[0][[1]], split[1][[1]])
        centres = origin + sole.points @ now.T
        height = centres[:, 2] - sole.radius
        near = np.flatnonzero(height < self.settings.sight)
        if phase == FLAT:
            near = near[:0]
        if len(near):
            arm = centres[near] - point
            lift = along[2] + np.outer(arm[:, 1], about[0]) - np.outer(arm[:, 0], about[1])
            stand.add(lift, -height[near], above=True)


def _up(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all between it and the world."""
    found = []
    while body:
        found.append(body)
        body = int(model.body_parentid[body])
    return found


class _Rows:
    """Rows of a level that is being collected."""

    def __init__(self):
        self.matrix, self.lower, self.upper = [], [], []

    def add(self, matrix: Array, right: Array, *, above: bool = False) -> None:
        """Add equations, or, with ``above``, lower bounds."""
        self.matrix.append(matrix)
        self.lower.append(right)
        self.upper.append(np.full(len(right), np.inf) if above else right)

    def level(self, name: str) -> Level:
        """Return the level."""
        lower, upper = np.concatenate(self.lower), np.concatenate(self.upper)
        return Level(np.concatenate(self.matrix), lower, upper, name)


def _together(levels: list[Level]) -> Level:
    """Return all equations of some levels as one."""
    keep = [level.lower == level.upper for level in levels]
    pairs = list(zip(levels, keep, strict=True))
    right = np.concatenate([level.lower[k] for level, k in pairs])
    return Level(np.concatenate([level.matrix[k] for level, k in pairs]), right, right, "all tasks")
