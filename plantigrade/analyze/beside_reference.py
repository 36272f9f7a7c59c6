"""A motion held against a reference of its own record: curves, centre of mass and soles.

Nothing of it is stored in a run: whoever shows it computes it from the record.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from plantigrade.analyze.curves import side_of
from plantigrade.analyze.statistics import correlation, rmse
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.cycles import PERCENT, Cycle, cut_cycles, normalise
from plantigrade.record import Record


@dataclass(frozen=True)
class AngleComparison:
    """One coordinate beside the reference's.

    Attributes:
        curves: Angle of each gait cycle [°].
        reference: Likewise, of the reference.
        rom: Range of motion, mean over the cycles [°].
        rom_reference: Likewise, of the reference.
        rmse: Root mean square difference [°].
        correlation: Pearson's r; NaN where one of both does not move.
    """

    curves: Float[Array, "n_cycles n_percent"] = field(repr=False)
    reference: Float[Array, "n_cycles n_percent"] = field(repr=False)
    rom: float
    rom_reference: float
    rmse: float
    correlation: float


class BesideReference:
    """A motion beside a reference motion of the same person.

    Curves are cut at the heel strikes of the coordinate's own side (pelvis and trunk: the
    right's); of the other side where the own has no whole cycle. Without any whole cycle they are
    empty, and ranges, differences and correlations are over the whole motion.

    Attributes:
        record: What happened.
        reference: The reference, on the frames of the record.
        cycles: The whole cycles of both feet.
        percent: Percent of the gait cycle.
    """

    def __init__(self, record: Record, name: str = "recorded"):
        """Hold ``record`` against one of its references.

        Raises:
            ParameterError: If there is no such reference, or the motion has fewer than two frames.
        """
        if name not in record.references:
            raise ParameterError(f"the record has no reference {name!r} to compare with")
        if record.motion.n_frames < 2:
            raise ParameterError("a comparison needs two frames or more")
        self.record = record
        self.reference = resampled(record.references[name], record.motion.time)
        first, last = record.motion.time[[0, -1]]
        step = record.motion.time[1] - first
        self.percent = PERCENT
        self.cycles: tuple[Cycle, ...] = tuple(
            c
            for c in cut_cycles(record.motion.events)
            if c.start > first - step and c.stop < last + step
        )

    @cached_property
    def angles(self) -> dict[str, AngleComparison]:
        """Coordinate → comparison; the pelvis's translations left out."""
        motion = self.record.motion
        spans = {side: self._spans(side) for side in SIDES}
        found = {}
        for name in (*motion.coordinates[:3], *motion.joint_names[1:]):
            mine = spans[side_of(name) or "r"]
            ours, theirs = (
                np.array([normalise(motion.time, np.rad2deg(m[name]), *span) for span in mine])
                for m in (motion, self.reference)
            )
            keep = len(ours) if self.cycles else 0
            found[name] = AngleComparison(
                ours[:keep],
                theirs[:keep],
                float(np.ptp(ours, axis=1).mean()),
                float(np.ptp(theirs, axis=1).mean()),
                rmse(ours, theirs),
                correlation(ours, theirs),
            )
        return found

    @cached_property
    def com_error(self) -> Float[Array, " n"]:
        """Distance of the centre of mass from the reference's in every frame [m]."""
        human = self.record.human
        ours, theirs = (
            centres_of_mass(human, m.qpos) for m in (self.record.motion, self.reference)
        )
        return np.linalg.norm(ours - theirs, axis=1)

    @cached_property
    def soles(self) -> tuple[Float[Array, "n 2"], Float[Array, "n 2"]]:
        """Height of the lowest point of each foot, right and left, and the reference's [m]."""
        ours, theirs = (
            sole_paths(self.record.human, m.qpos) for m in (self.record.motion, self.reference)
        )
        both = [
            np.stack([p.position[:, p.of(side), 2].min(axis=1) for side in SIDES], axis=1)
            for p in (ours, theirs)
        ]
        return both[0], both[1]

    def _spans(self, side: str) -> list[tuple[float, float]]:
        first, last = self.record.motion.time[[0, -1]]
        mine = [c for c in self.cycles if c.side == side] or self.cycles
        return [(max(c.start, first), min(c.stop, last)) for c in mine] or [(first, last)]


def resampled(motion: Motion, time: Float[Array, " n"]) -> Motion:
    """Return a motion at other instants [s], interpolated; beyond its ends as at them."""
    if np.array_equal(motion.time, time):
        return motion
    qpos = motion.qpos.copy()
    turned = np.sum(qpos[1:, 3:7] * qpos[:-1, 3:7], axis=1) < 0  # the same rotation, the other sign
    qpos[1:, 3:7] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
    here, speed = (
        np.stack([np.interp(time, motion.time, column) for column in values.T], axis=1)
        for values in (qpos, motion.qvel)
    )
    here[:, 3:7] /= np.linalg.norm(here[:, 3:7], axis=1, keepdims=True)
    return Motion(time, here, speed, motion.joint_names, events=motion.events)


def centres_of_mass(human: Human, qpos: Float[Array, "n nq"]) -> Float[Array, "n 3"]:
    """Return the centre of mass in every frame [m]."""
    return np.array([state.com for state in sweep(human, qpos)]).reshape(-1, 3)
