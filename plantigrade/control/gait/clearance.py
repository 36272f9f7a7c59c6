"""Where a motion passes through itself, and how far its arms are held out so that it does not.

Bodies are solid in a world. Motions are not always: in recorded ones soft tissue yields, and the
trunk of a model may be wider than the person's. Overlaps are those of the cores of
:mod:`plantigrade.contact.scene`.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, spread
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.record import Record
from plantigrade.wbc.tasks.contact import ContactSettings
from plantigrade.world import SimulatedWorld
from plantigrade.world.world_model import world_model

MAX_LEG_OVERLAP = 0.03  # [m] depth that flesh could yield; deeper, legs are no longer solid
N_FRAMES = 60  # frames in which overlaps are looked for
N_STEPS = 8  # steps by which arms are held out
ARM = ("humerus", "ulna", "radius", "hand", "fingers", "clavicle", "scapula")
LEG = ("femur", "tibia", "talus", "foot", "toes", "heel", "medial", "lateral", "patella")


@dataclass(frozen=True, kw_only=True)
class ClearanceSettings:
    """How far arms are held out."""

    max_abduction: float = float(np.deg2rad(16.0))
    """Greatest abduction [rad]. Chosen (±20 %: not met)."""
    min_overlap: float = ContactSettings.touching_height
    """Depth of an overlap from which it counts [m]; as of soles that touch."""


@dataclass(frozen=True)
class SelfClearance:
    """How a motion is kept from passing through itself."""

    abduction: tuple[float, float]  #: Added abduction of each arm, right first [rad]
    legs: float  #: Greatest depth of one leg in the other [m]
    arms: float  #: Greatest depth of the arms in the body, as the motion has them [m]


def clearance_of(record: Record, settings: ClearanceSettings | None = None) -> SelfClearance:
    """Return how far the arms of a motion are to be held out, and whether its legs overlap."""
    settings = settings or ClearanceSettings()
    human, motion = record.human, record.motion
    model = world_model(human, Ground(), step=0.001)
    data = mujoco.MjData(model)
    kind = np.array([part_of(model.body(int(b)).name) for b in model.geom_bodyid])
    every = spread(motion.n_frames, N_FRAMES)
    frames = motion.qpos[every].copy()
    out, first = [0.0, 0.0], [0.0, 0.0]
    legs = 0.0
    names = [f"arm_add_{side}" for side in SIDES]
    held = [names.index(n) for n in names if n in human.coordinates]
    step = settings.max_abduction / N_STEPS
    for turn in range(N_STEPS + 1):
        deep, crossed = _overlaps(model, data, kind, frames)
        if turn == 0:
            first, legs = deep, crossed
        bad = [i for i in held if deep[i] > settings.min_overlap]
        if not bad or turn == N_STEPS:
            break
        for i in bad:
            out[i] += step
            frames[:, 7 + human.hinge(names[i])] -= step
    return SelfClearance((out[0], out[1]), legs, max(first))


def held_out(record: Record, qpos: Float[Array, "n nq"], clearance: SelfClearance) -> Array:
    """Return configurations with the arms held out, within their range."""
    human, moved = record.human, qpos.copy()
    for side, angle in zip(SIDES, clearance.abduction, strict=True):
        if angle:
            moved[:, 7 + human.hinge(f"arm_add_{side}")] -= angle
    return moved


def part_of(body: str) -> str:
    """Return what a body belongs to: ``"arm_r"``, ``"leg_l"`` … or nothing."""
    for kind, names in (("arm", ARM), ("leg", LEG)):
        if body.startswith(names):
            return f"{kind}_{body[-1]}"
    return ""


def _overlaps(model, data, kind: Array, frames: Array) -> tuple[list[float], float]:
    """Return how deep each arm is in anything of the body, and a leg in the other [m]."""
    arms, legs = [0.0, 0.0], 0.0
    for qpos in frames:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        if not data.ncon:
            continue
        pairs, deep = kind[data.contact.geom], -np.array(data.contact.dist)
        body = np.all(model.geom_bodyid[data.contact.geom] > 0, axis=1)
        for i, side in enumerate(SIDES):
            mine = body & (pairs == f"arm_{side}").any(axis=1)
            arms[i] = max(arms[i], float(deep[mine].max(initial=0.0)))
        both = body & (pairs == "leg_r").any(axis=1) & (pairs == "leg_l").any(axis=1)
        legs = max(legs, float(deep[both].max(initial=0.0)))
    return arms, legs


class LegOverlap:
    """Depth to which one leg penetrates the other.

    Attributes:
        deepest: Maximum depth [m].
    """

    def __init__(self, world: SimulatedWorld):
        model = world.model
        kind = np.array([part_of(model.body(int(b)).name) for b in model.geom_bodyid])
        self._leg = (kind == "leg_r") * 1 + (kind == "leg_l") * 2
        self._contact, self.deepest = world.data.contact, 0.0

    def update(self) -> None:
        """Take the contacts of the last step into account."""
        both = self._leg[self._contact.geom].sum(axis=1) == 3
        if both.any():
            self.deepest = max(self.deepest, -float(self._contact.dist[both].min()))
