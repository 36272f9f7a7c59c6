r"""Leg lengths of a motion of rotations from the feet that stand.

While a foot stands, its toe base stays where it is. With the rotations of the file and the path of
the pelvis known, its position is linear in the bone lengths,

.. math:: p(t) = r(t) + f_1 \left(R_0 o_{hip} + R_{hip} o_{knee}\right)
    + f_2 \left(R_{knee} o_{ankle} + R_{ankle} o_{foot}\right),

so the factors :math:`f` on a mean body's offsets follow by least squares from the deviations from
the mean of each stance. A prior of the spread of adults holds where a motion says little.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.io.skeletons import tree_kinematics
from plantigrade.io.smpl_tree import NAMES, PARENTS
from plantigrade.motion.filters import runs

N_ROUNDS = 4  # stances are found again with the lengths of the round before
MAX_STANCE_HEIGHT = 0.03  # [m] of ankle and toe base above their lowest while a foot stands flat
MAX_STANCE_SPEED = 0.25  # [m/s] of both while a foot stands
LEG = ("hip", "knee", "ankle", "foot")
MIN_STANCE_DURATION = 0.15  # [s] shortest stance that counts
INDEPENDENT = 3.0  # [1/stance] independent measurements in one stance: residuals vary slowly
SIZE_SD = 0.08  # [1] prior of the size of the legs; statures of adults vary by 5 %
RATIO_SD = 0.04  # [1] prior of the ratio of thigh and shank, in adults
MIN_RESIDUAL = 0.002  # [m] assumed error of the toe base at least


@dataclass(frozen=True)
class LegFactors:
    """Factors on the lengths of thigh and shank."""

    thigh: float  #: Factor on hip and knee offsets
    shank: float  #: Factor on ankle and foot offsets
    standard_errors: tuple[float, float]  #: Standard errors of both
    stances: int  #: Number of stances they follow from

    @property
    def size(self) -> float:
        """Factor on the body."""
        return 0.5 * (self.thigh + self.shank)

    def scaled(self, offsets: Float[Array, "22 3"]) -> Float[Array, "22 3"]:
        """Return the offsets of a body with these legs."""
        factor = {"hip": self.thigh, "knee": self.thigh, "ankle": self.shank, "foot": self.shank}
        each = [factor.get(name.partition("_")[2], self.size) for name in NAMES]
        return offsets * np.array(each)[:, None]


def leg_factors(
    local: Float[Array, "n 22 3 3"],
    root: Float[Array, "n 3"],
    offsets: Float[Array, "22 3"],
    rate: float,
) -> LegFactors:
    """Return the factors on leg lengths that let standing feet stand.

    Args:
        local: Rotation of each joint relative to its parent; that of the root in the world.
        root: Position of the pelvis joint, z up [m].
        offsets: Offsets of a mean body [m].
        rate: Frames per second [Hz].
    """
    found = LegFactors(1.0, 1.0, (SIZE_SD, SIZE_SD), 0)
    for _ in range(N_ROUNDS if len(root) > 2 else 0):
        R, p = tree_kinematics(PARENTS, local, root, found.scaled(offsets))
        rows: list[np.ndarray] = []
        for side in SIDES:
            chain = [NAMES.index(f"{SIDE_NAMES[side]}_{joint}") for joint in LEG]
            parts = [R[:, PARENTS[j]] @ offsets[j] for j in chain]
            columns = np.stack([parts[0] + parts[1], parts[2] + parts[3], -root], axis=-1)
            for frames in _stances(p[:, chain[2:]], rate):
                stance = columns[frames]
                rows.append((stance - stance.mean(axis=0)) / np.sqrt(len(stance)))
        found = _solved(rows)
    return found


def _stances(foot: Float[Array, "n 2 3"], rate: float) -> list[slice]:
    """Return the frames of each stance of a foot, given by ankle and toe base."""
    height = foot[:, :, 2] - np.quantile(foot[:, :, 2], 0.05, axis=0)
    speed = np.linalg.norm(np.gradient(foot, 1 / rate, axis=0), axis=2)
    flat = ((height < MAX_STANCE_HEIGHT) & (speed < MAX_STANCE_SPEED)).all(axis=1)
    return [s for s in runs(flat) if s.stop - s.start >= max(MIN_STANCE_DURATION * rate, 2)]


def _solved(rows: list[np.ndarray]) -> LegFactors:
    """Return the most probable factors; each stance counts as few independent measurements."""
    half, difference = np.array([0.5, 0.5]) / SIZE_SD, np.array([1.0, -1.0]) / RATIO_SD
    prior = np.stack([half, difference])
    target = np.array([1.0 / SIZE_SD, 0.0])
    factors, covariance = np.ones(2), np.linalg.inv(prior.T @ prior)
    if rows:
        stances = np.concatenate(rows).reshape(-1, 3)
        A, b = stances[:, :2], stances[:, 2]
        for _ in range(3):  # the residual sets the weight of the motion against the prior
            variance = np.sum((A @ factors - b) ** 2) / (3 * len(rows)) + MIN_RESIDUAL**2
            weight = INDEPENDENT / variance
            covariance = np.linalg.inv(weight * A.T @ A + prior.T @ prior)
            factors = covariance @ (weight * A.T @ b + prior.T @ target)
    factors = np.clip(factors, 0.5, 2.0)
    thigh, shank = (float(f) for f in factors)
    errors = np.sqrt(np.diag(covariance))
    return LegFactors(thigh, shank, (float(errors[0]), float(errors[1])), len(rows))
