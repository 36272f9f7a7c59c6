"""A cyclic reference walk: one closed stride and its displacement."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.kinematics.stride import Stride, stride_of
from plantigrade.kinematics.textbook_walk import textbook_walk
from plantigrade.models import Human
from plantigrade.models.human import require_scaled
from plantigrade.motion import Motion
from plantigrade.options import shown
from plantigrade.record import Record, Run

HAND_BODIES = ("hand", "radius", "forearm", "fingers")
"""Bodies that may be the end of an arm, in order of preference."""
EXTRA_COLUMNS = 3 + 3 * 4 + 1
"""Columns of a table after configuration and velocity; see :class:`Reference`."""


@dataclass(frozen=True, eq=False)
class ReferenceMotion:
    """A reference motion at any time, from a table of one stride or of a motion that ends.

    The walk starts at the origin and leads along x, on level ground at height zero.

    Attributes:
        human: The person.
        period: Duration of the stride, or of the motion [s].
        stride: Stride length; zero if the motion is not cyclic [m].
        cyclic: Whether the motion repeats.
        table: One row per instant, both ends included: configuration, velocity, centre of mass,
            limb ends relative to the pelvis, and depth of the soles, as in :class:`ReferenceState`.
    """

    human: Human
    period: float
    stride: float
    cyclic: bool
    table: Float[Array, "n_rows n_columns"]

    def at(self, time: float | Float[Array, " n"]) -> "ReferenceInstant":
        """Return the reference at times after its start [s]; after its end, the last row."""
        table, u = self.table, np.asarray(time) / self.period
        laps = np.floor(u) if self.cyclic else np.zeros_like(u)
        place = np.minimum(np.maximum(u - laps, 0.0), 1.0) * (len(table) - 1)
        i = np.minimum(place.astype(int), len(table) - 2)
        row = table[i] + (place - i)[..., None] * (table[i + 1] - table[i])
        return ReferenceInstant(row, self.human.model.nq, self.human.model.nv, laps * self.stride)

    @property
    def digest(self) -> str:
        """Hash of the motion, to 0.1 mm and 1e-4 rad."""
        table = np.round(self.table, 4) + 0.0  # one sign of zero
        return hashlib.sha256(table.tobytes()).hexdigest()[:12]

    def phase(self, time: float | Float[Array, " n"]) -> float | Float[Array, " n"]:
        """Return the phase of the stride or motion, from 0 to 1."""
        u = np.asarray(time) / self.period
        return u % 1.0 if self.cyclic else np.minimum(u, 1.0)

    def cleared(self, clearance: float) -> "ReferenceMotion":
        """Return it with feet that pass the ground at least so high in mid-swing [m].

        Raises:
            ParameterError: If it is not cyclic.
        """
        return replace(self, table=_table(self.human, self._stride.cleared(self.human, clearance)))

    def softened(self) -> "ReferenceMotion":
        """Return it with the centre of mass rising and falling as one sine per step.

        Raises:
            ParameterError: If it is not cyclic.
        """
        return replace(self, table=_table(self.human, self._stride.softened(self.human)))

    @property
    def _stride(self) -> Stride:
        time = np.linspace(0.0, self.period, len(self.table))
        nq, nv = self.human.model.nq, self.human.model.nv
        qpos, qvel = self.table[:, :nq], self.table[:, nq : nq + nv]
        return Stride(time, qpos, qvel, self.stride, self.cyclic)

    @classmethod
    def of(
        cls, source: "str | Path | Run | Record | ReferenceMotion | None" = None
    ) -> "ReferenceMotion":
        """Return the reference of a run, its folder, or a record; of the textbook walk if absent.

        Raises:
            ParameterError: If the source is something else, the ground is not flat, or the motion
                is too short or has gaps.
            FileError: If the run does not exist.
        """
        if isinstance(source, ReferenceMotion):
            return source
        if source is None:
            return cls.textbook(Human.create(1.50, 48.5, joints="66"))
        if isinstance(source, str | Path):
            source = Run.load(source)
        record = source.record if isinstance(source, Run) else source
        if not isinstance(record, Record):
            raise ParameterError(
                f"a reference must be a run, its folder or a record, not {shown(record)}"
            )
        require_scaled(record.human, "a reference")
        ground = record.ground
        if ground.slope or ground.steps or ground.uneven or ground.seats or ground.moves:
            raise ParameterError(
                "a reference must be a walk on level ground at rest, without steps and seats"
            )
        return cls.of_motion(record.human, record.motion)

    @classmethod
    def textbook(cls, human: Human) -> "ReferenceMotion":
        """Return the published mean walk on a person, softened.

        Its speed is the preferred one, 0.4 times the root of leg length times gravity.
        """
        speed = 0.4 * float(np.sqrt(GRAVITY * human.dimensions.leg_length))
        walk = textbook_walk(human, speed=speed, rate=60.0, cycles=2)
        rest = np.zeros((len(walk.time), human.model.nv))
        motion = Motion(walk.time, walk.qpos, rest, human.joint_names, events=walk.events)
        return cls.of_motion(human, motion).softened()

    @classmethod
    def of_motion(cls, human: Human, motion: Motion) -> "ReferenceMotion":
        """Return the most symmetric stride of a motion, or the whole motion if there is none.

        The stride is closed by :func:`~plantigrade.kinematics.stride.stride_of`.

        Raises:
            ParameterError: If the motion is of another person, too short, or has gaps.
        """
        stride = stride_of(human, motion)
        period = float(stride.time[-1])
        return cls(human, period, stride.length, stride.cyclic, _table(human, stride))


class ReferenceInstant:
    """State of a reference at one or several instants.

    Attributes:
        qpos: Configuration.
        qvel: Velocity.
        com: Centre of mass, world [m].
        ends: Hands and feet relative to the pelvis, in its heading [m], flattened.
        depth: Depth of the lowest point of the soles below the ground [m].
    """

    __slots__ = ("com", "depth", "ends", "qpos", "qvel")

    def __init__(
        self, row: Float[Array, "*m k"], nq: int, nv: int, ahead: float | Float[Array, " n"]
    ):
        """Split rows of a table, displaced forward by ``ahead`` [m]."""
        self.qpos, self.qvel = row[..., :nq], row[..., nq : nq + nv]
        self.com, self.ends = row[..., nq + nv : nq + nv + 3], row[..., nq + nv + 3 : -1]
        self.depth = row[..., -1]
        self.qpos[..., 0] += ahead
        self.com[..., 0] += ahead


def limb_ends(human: Human) -> tuple[int, ...]:
    """Return the indices of the bodies at the ends of the limbs: both hands, both feet."""
    names = human.body_names
    hands = [next(f"{h}_{s}" for h in HAND_BODIES if f"{h}_{s}" in names) for s in SIDES]
    return tuple(human.body(name) for name in (*hands, "foot_r", "foot_l"))


def headings(quat: Float[Array, "n 4"]) -> Float[Array, "n 3 3"]:
    """Return maps of row vectors from world axes to the headings of pelves, z up."""
    w, x, y, z = quat.T
    cosine, sine = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
    size = np.maximum(np.hypot(cosine, sine), 1e-12)
    turn = np.zeros((len(quat), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = cosine / size
    turn[:, 1, 0] = sine / size
    turn[:, 0, 1] = -turn[:, 1, 0]
    turn[:, 2, 2] = 1.0
    return turn


def _table(human: Human, stride: Stride) -> Float[Array, "n_rows n_columns"]:
    """Return the table of a stride, as described in :class:`Reference`."""
    qpos, model = stride.qpos, human.model
    data, limbs = mujoco.MjData(model), list(limb_ends(human))
    com, places = np.zeros((len(qpos), 3)), np.zeros((len(qpos), 3 * len(limbs)))
    for k in range(len(qpos)):
        data.qpos[:] = qpos[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        com[k] = data.subtree_com[1]
        turn = headings(qpos[k : k + 1, 3:7])[0]
        places[k] = ((data.xipos[limbs] - data.xpos[1]) @ turn).ravel()
    depth = np.maximum(-lowest(human, qpos), 0.0)[:, None]
    return np.hstack([qpos, stride.qvel, com, places, depth])
