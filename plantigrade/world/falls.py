"""Detection of falls: a body other than the feet touches the ground, or the body sinks too low."""

from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.models import Human
from plantigrade.world.world_model import GROUND_PREFIXES, LIMB_BIT

MIN_COM_HEIGHT = 0.35
"""Minimum height of the centre of mass above the lower foot, as a fraction of that in standing."""

REACH = 0.05
"""Height above the ground below which a body of a motion touches it [m]: the error of a hand fitted
to markers on the wrist. Chosen."""


@dataclass(frozen=True)
class Fall:
    """A fall.

    Attributes:
        time: Time of the fall [s].
        body: Body that touched the ground; empty if the centre of mass was too low.
    """

    time: float
    body: str = ""

    def __str__(self) -> str:
        what = f"{self.body} touched the ground" if self.body else "the centre of mass sank too low"
        return f"fell at {self.time:.2f} s: {what}"


class FallWatch:
    """Detects falls in a world."""

    def __init__(self, human: Human, model: mujoco.MjModel):
        names = [model.geom(i).name for i in range(model.ngeom)]
        self._ground = np.array([name.startswith(GROUND_PREFIXES) for name in names])
        self._body, self._human = np.array(model.geom_bodyid), human
        own = (self._body > 0) & (self._body <= len(human.body_names))
        limb = own & ((np.array(model.geom_contype) & LIMB_BIT) > 0)
        self._model = model
        self._forbid(limb)
        self._limbs, self._max_ground_height = (
            np.flatnonzero(limb),
            _max_ground_height(model, self._ground),
        )
        self._size = np.array(model.geom_rbound)[self._limbs]
        standing = mujoco.MjData(human.model)
        standing.qpos[:] = human.standing()
        mujoco.mj_kinematics(human.model, standing)
        mujoco.mj_comPos(human.model, standing)
        self._feet = [human.body(f"foot_{side}") for side in ("r", "l")]
        self._min_height = MIN_COM_HEIGHT * self._height(standing)

    def _forbid(self, limb: Bool[Array, " n_geoms"]) -> None:
        """Make a fall of the contacts of these parts of limbs with the ground."""
        self._is_limb = limb
        self._ground_contact = np.outer(self._ground, limb) | np.outer(limb, self._ground)

    def allow(self, qpos: Float[Array, "n_frames nq"]) -> None:
        """Let bodies that touch level ground in a motion, as a hand that lifts a box, touch it.

        Shanks, which are as near in standing, still may not.
        """
        if np.isfinite(self._max_ground_height):
            near = self._near(qpos) - self._near([self._human.standing()])
            allowed = np.isin(self._body, sorted(near))
            self._forbid(self._is_limb & ~allowed)

    def _near(self, qpos: Iterable[Float[Array, " nq"]]) -> set[int]:
        """Return the bodies that are near the ground in any frame."""
        model, data = self._model, mujoco.MjData(self._model)
        centre, half = np.split(np.array(model.geom_aabb)[self._limbs], 2, axis=1)
        near = np.zeros(len(self._limbs), dtype=bool)
        for configuration in qpos:
            data.qpos[: len(configuration)] = configuration
            mujoco.mj_kinematics(model, data)
            up = data.geom_xmat[self._limbs].reshape(-1, 3, 3)[:, 2]
            low = data.geom_xpos[self._limbs, 2] + (up * centre - np.abs(up) * half).sum(axis=1)
            near |= low < self._max_ground_height + REACH
        return set(self._body[self._limbs[near]].tolist())

    def detect(self, data: mujoco.MjData, time: float) -> Fall | None:
        """Return the fall in the last step, if there is one."""
        if data.ncon and self._may_touch(data):
            contact = data.contact
            first, second = contact.geom.T
            down = self._ground_contact[first, second]
            if down.any():
                hit = np.flatnonzero(down & (contact.efc_address >= 0))
                if len(hit):
                    geom = int(second[hit[0]] if self._is_limb[second[hit[0]]] else first[hit[0]])
                    return Fall(time, self._human.body_names[int(self._body[geom]) - 1])
        return Fall(time) if self._height(data) < self._min_height else None

    def _may_touch(self, data: mujoco.MjData) -> bool:
        """Return whether a body other than the feet is near the ground, as a fast first test."""
        return bool(
            (data.geom_xpos[:, 2].take(self._limbs) - self._size).min() < self._max_ground_height
        )

    def _height(self, data: mujoco.MjData) -> float:
        """Return the height of the centre of mass above the lower ankle [m]."""
        place = data.xpos
        return float(data.subtree_com[1, 2] - min(place[foot, 2] for foot in self._feet))


def _max_ground_height(model: mujoco.MjModel, ground: Bool[Array, " n_geoms"]) -> float:
    """Return the maximum height of the ground [m]; infinite if it slopes or moves."""
    kinds, heights = mujoco.mjtGeom, []
    for i in np.flatnonzero(ground):
        kind, z, size = model.geom_type[i], float(model.geom_pos[i, 2]), model.geom_size[i]
        if model.geom_bodyid[i] or abs(model.geom_quat[i, 0]) < 1.0:
            return np.inf
        if kind == kinds.mjGEOM_HFIELD:
            z += float(model.hfield_size[model.geom_dataid[i], 2])
        elif kind == kinds.mjGEOM_SPHERE:
            z += float(size[0])
        elif kind == kinds.mjGEOM_BOX:
            z += float(size[2])
        elif kind != kinds.mjGEOM_PLANE:
            return np.inf
        heights.append(z)
    return max(heights, default=np.inf)
