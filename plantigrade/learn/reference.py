"""A walk as a reference that goes on for ever: one stride, closed, with how far it leads."""

from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.cycles import LONGEST_CYCLE, SHORTEST_CYCLE, cut_cycles
from plantigrade.options import shown
from plantigrade.record import Record, Run
from plantigrade.spatial.conventions import (
    PELVIS,
    pelvis_angles_to_quaternion,
    pelvis_rates_to_free_joint,
)

RATE = 120.0
"""Rows of the table per second, at least; between them it is linear [1/s]."""
SEAM = 1.0 / 60.0
"""Standard deviation of the Gaussian that smooths a closed stride [s]."""
OPEN = np.deg2rad(10.0)
"""Root mean square of the hinges by which both ends of one stride differ at most [rad]."""
SHORT = 0.2
"""A stride that leads nowhere is on a belt: less than this [m]."""
HANDS = ("hand", "radius", "forearm", "fingers")
"""Bodies of an arm that may be its end, the best first."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A walk at any time: a table of one stride, or of a motion that is no walk and ends.

    The walk leads along x from the origin, on level ground at height zero.

    Attributes:
        human: Who walks.
        period: Duration of the stride, or of the motion [s].
        stride: How far a stride leads; zero where nothing is repeated [m].
        cyclic: Whether it goes on for ever.
        table: One row an instant, both ends included: configuration, velocity, centre of mass,
            ends of the limbs from the pelvis, and depth of the soles, as in :class:`Frame`.
    """

    human: Human
    period: float
    stride: float
    cyclic: bool
    table: Float[Array, "n_rows n_columns"]

    def at(self, time: float | Float[Array, " n"]) -> "Frame":
        """Return the reference at times after its start [s]; at its last row after its end."""
        table, u = self.table, np.asarray(time) / self.period
        laps = np.floor(u) if self.cyclic else np.zeros_like(u)
        place = np.minimum(np.maximum(u - laps, 0.0), 1.0) * (len(table) - 1)
        i = np.minimum(place.astype(int), len(table) - 2)
        row = table[i] + (place - i)[..., None] * (table[i + 1] - table[i])
        return Frame(row, self.human.model.nq, self.human.model.nv, laps * self.stride)

    def phase(self, time: float | Float[Array, " n"]) -> float | Float[Array, " n"]:
        """Return which part of the stride, or of the motion, has passed, from 0 to 1."""
        u = np.asarray(time) / self.period
        return u % 1.0 if self.cyclic else np.minimum(u, 1.0)

    @classmethod
    def of(cls, source: "str | Path | Run | Record | Reference | None" = None) -> "Reference":
        """Return the reference of a run, its folder, or a record; of the textbook walk if absent.

        Raises:
            ParameterError: If it is something else, the ground is not level and even, or the motion
                is too short.
            FileError: If there is no such run.
        """
        if isinstance(source, Reference):
            return source
        if source is None:
            return cls.textbook(Human.create(1.50, 48.5, joints="66"))
        if isinstance(source, str | Path):
            source = Run.load(source)
        record = source.record if isinstance(source, Run) else source
        if not isinstance(record, Record):
            raise ParameterError(
                f"a reference is a run, its folder or a record, not {shown(record)}"
            )
        ground = record.ground
        if ground.slope or ground.steps or ground.uneven or ground.seats:
            raise ParameterError("a reference is walked on level ground, without steps and seats")
        return cls.of_motion(record.human, record.motion)

    @classmethod
    def textbook(cls, human: Human, speed: float | None = None) -> "Reference":
        """Return the published mean walk on a person.

        Args:
            human: The person.
            speed: Walking speed; 0.4 of the root of leg length times gravity if absent, which is
                what people prefer [m/s].
        """
        d = human.dimensions
        speed = speed or 0.4 * float(np.sqrt(9.81 * (d.thigh + d.shank + d.ankle_height)))
        walk = textbook_walk(human, speed=speed, rate=60.0, cycles=2)
        rest = np.zeros((len(walk.time), human.model.nv))
        motion = Motion(walk.time, walk.qpos, rest, human.joint_names, events=walk.events)
        return cls.of_motion(human, motion)

    @classmethod
    def of_motion(cls, human: Human, motion: Motion) -> "Reference":
        """Return the reference of a motion: its most even stride, or the whole if there is none.

        Where gait events cut no stride, a motion whose both ends are nearly one posture is one. A
        walk on a belt gets the belt's way. The ends of the stride are closed by what they differ,
        spread over all of it.

        Raises:
            ParameterError: If the motion is of another person, or too short.
        """
        if motion.joint_names != human.joint_names or motion.n_frames < 4:
            raise ParameterError("a reference needs four frames or more of a motion of this person")
        own = motion.time
        motion = _off_the_belt(human, motion)
        strides = [(c.start, c.stop) for c in cut_cycles(motion.events)]
        strides = [s for s in strides if s[0] >= own[0] - 1e-9 and s[1] <= own[-1] + 1e-9]
        if not strides and SHORTEST_CYCLE <= motion.duration <= LONGEST_CYCLE:
            strides = [(float(own[0]), float(own[-1]))]
        cut = [_coordinates(human, motion, start, stop) for start, stop in strides]
        opening = [float(np.sqrt(np.mean((x[-1, 6:] - x[0, 6:]) ** 2))) for x in cut]
        if cut and min(opening) < OPEN:
            best = int(np.argmin(opening))
            period = strides[best][1] - strides[best][0]
            values, stride = _closed(cut[best], period)
            return cls(human, period, stride, True, _table(human, values, period, cyclic=True))
        values = _coordinates(human, motion, float(own[0]), float(own[-1]))
        values[:, :2] -= values[0, :2]
        table = _table(human, values, motion.duration, cyclic=False)
        return cls(human, motion.duration, 0.0, False, table)


class Frame:
    """A reference at an instant, or one row for each of several.

    Attributes:
        qpos: Configuration.
        qvel: Velocity.
        com: Centre of mass, world [m].
        ends: Hands and feet from the pelvis, in the pelvis' heading [m], one after another.
        depth: How far the lowest point of the soles is under the ground [m].
    """

    __slots__ = ("com", "depth", "ends", "qpos", "qvel")

    def __init__(
        self, row: Float[Array, "*m k"], nq: int, nv: int, ahead: float | Float[Array, " n"]
    ):
        """Take rows apart; so far ahead [m]."""
        self.qpos, self.qvel = row[..., :nq], row[..., nq : nq + nv]
        self.com, self.ends = row[..., nq + nv : nq + nv + 3], row[..., nq + nv + 3 : -1]
        self.depth = row[..., -1]
        self.qpos[..., 0] += ahead
        self.com[..., 0] += ahead


def limb_ends(human: Human) -> tuple[int, ...]:
    """Return the indices of the bodies at the ends of the limbs: both hands, both feet."""
    names = human.body_names
    hands = [next(f"{h}_{s}" for h in HANDS if f"{h}_{s}" in names) for s in SIDES]
    return tuple(human.body(name) for name in (*hands, "foot_r", "foot_l"))


def headings(quat: Float[Array, "n 4"]) -> Float[Array, "n 3 3"]:
    """Return what maps rows of world axes to axes that face where a pelvis does, z up."""
    w, x, y, z = quat.T
    cosine, sine = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
    size = np.maximum(np.hypot(cosine, sine), 1e-12)
    turn = np.zeros((len(quat), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = cosine / size
    turn[:, 1, 0] = sine / size
    turn[:, 0, 1] = -turn[:, 1, 0]
    turn[:, 2, 2] = 1.0
    return turn


def _off_the_belt(human: Human, motion: Motion) -> Motion:
    """Return a motion that gets on, if it was on a belt."""
    if np.linalg.norm(motion.qpos[-1, :2] - motion.qpos[0, :2]) > SHORT * motion.duration:
        return motion
    data, model = mujoco.MjData(human.model), human.model
    toes = [max(i for i, b in enumerate(human.body_names) if b[-2:] == f"_{s}") for s in SIDES]
    feet = [human.body(f"foot_{s}") for s in SIDES]
    places = np.zeros((motion.n_frames, 2, 2, 3))
    for k, qpos in enumerate(motion.qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        places[k, 0], places[k, 1] = data.xpos[feet], data.xpos[np.array(toes) + 1]
    qpos = motion.qpos.copy()
    qpos[:, :3] -= moving_ground(motion.time, places[:, 0], places[:, 1])
    return replace(motion, qpos=qpos)


def _coordinates(
    human: Human, motion: Motion, start: float, stop: float
) -> Float[Array, "n_rows nv"]:
    """Return place and angles of the pelvis and the hinges, walking along x."""
    n = max(int(np.ceil((stop - start) * RATE)), 8)
    part = motion.at(np.clip(np.linspace(start, stop, n + 1), motion.time[0], motion.time[-1]))
    names, values = human.to_coordinates(part.qpos)
    angles = np.unwrap(values[:, :3], axis=0)
    place = part.qpos[:, :3] - [*part.qpos[0, :2], 0.0]
    way = place[-1, :2]
    turn = float(np.arctan2(way[1], way[0])) if np.linalg.norm(way) > SHORT else 0.0
    c, s = np.cos(turn), np.sin(turn)
    place[:, :2] = place[:, :2] @ np.array([[c, -s], [s, c]])
    angles[:, PELVIS.index("pelvis_rotation")] -= turn
    middle = angles[:, 2].mean()
    angles[:, 2] -= 2 * np.pi * np.round(middle / (2 * np.pi))
    return np.hstack([place, angles, values[:, 6:]])


def _closed(
    values: Float[Array, "n_rows nv"], period: float
) -> tuple[Float[Array, "n_rows nv"], float]:
    """Return one stride without its way, both ends alike, and the way [m]."""
    n = len(values) - 1
    u = np.linspace(0.0, 1.0, n + 1)[:, None]
    stride = float(values[-1, 0] - values[0, 0])
    drift = values[-1] - values[0]
    shut = values - drift * (u - 0.5 * (np.arange(values.shape[1]) > 0))
    smooth = gaussian_filter1d(shut[:-1], SEAM * n / period, axis=0, mode="wrap")
    smooth[:, 1] -= smooth[:, 1].mean()
    smooth = np.vstack([smooth, smooth[:1]])
    smooth[:, 0] += stride * u[:, 0] - smooth[0, 0]
    return smooth, stride


def _table(
    human: Human, values: Float[Array, "n_rows nv"], period: float, *, cyclic: bool
) -> Float[Array, "n_rows n_columns"]:
    """Return all that is compared with, in every row."""
    n, model = len(values) - 1, human.model
    time = np.linspace(0.0, period, n + 1)
    way = np.zeros_like(values)
    if cyclic:
        way[:, 0] = (values[-1, 0] - values[0, 0]) * time / period
    ends = "periodic" if cyclic else "natural"
    spline = CubicSpline(time, values - way, axis=0, bc_type=ends)
    rate, bend = spline(time, 1), spline(time, 2)
    rate[:, 0] += way[-1, 0] / period
    turn, _ = pelvis_rates_to_free_joint(values[:, 3:6], rate[:, 3:6], bend[:, 3:6])
    quat = pelvis_angles_to_quaternion(values[:, 3:6])
    quat[1:] *= np.cumprod(np.where(np.sum(quat[1:] * quat[:-1], axis=1) < 0, -1.0, 1.0))[:, None]
    qpos = np.hstack([values[:, :3], quat, values[:, 6:]])
    qpos[:, 2] -= np.median(lowest(human, qpos))
    qvel = np.hstack([rate[:, :3], turn, rate[:, 6:]])
    data, limbs = mujoco.MjData(model), list(limb_ends(human))
    com, places = np.zeros((n + 1, 3)), np.zeros((n + 1, 3 * len(limbs)))
    for k in range(n + 1):
        data.qpos[:] = qpos[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        com[k] = data.subtree_com[1]
        turn = headings(qpos[k : k + 1, 3:7])[0]
        places[k] = ((data.xipos[limbs] - data.xpos[1]) @ turn).ravel()
    return np.hstack([qpos, qvel, com, places, np.maximum(-lowest(human, qpos), 0.0)[:, None]])
