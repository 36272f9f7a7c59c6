r"""How sure estimated ground reactions are: bands from the quadratic program's own rows.

Every row of the program has an error: the motion its noise, the true forces a bend that is not
zero, the person a path of the centre of pressure that is not the mean. Errors of the size of each
row's scale, correlated over time as such errors are, are drawn many times; each draw moves the
optimum by

.. math:: \delta x = (P + G^T \tfrac{z}{s} G)^{-1} A^T e,

with the rows :math:`A` over their scales, inequalities :math:`G` by their multipliers :math:`z` and
slacks :math:`s`. One factorisation serves all draws. Their spread, times a factor for each
quantity, is the band.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.carriers import Carriers
from plantigrade.dynamics.force_needs import ForceNeeds
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human

DRAWS = 32  # Monte Carlo draws; their number scatters a band by an eighth
NINETY = 1.645  # standard deviations of the half-width of a 90 % band
# Over how long the errors of rows are alike [s]
NOISE_TIME = 0.04  # of the motion, filtered at some 6 Hz
BEND_TIME = 0.04  # of forces and of joint moments
PATH_TIME = 0.25  # of the centre of pressure's path: a person keeps to their own
# Where nobody walks: how far persons are from the least activation, of that activation, and from
# the foot's axis, of what a rolling foot may be
ACTIVATION, ASIDE = 2.0, 0.5
# What the spreads are multiplied by, so that the bands hold what plates measured
FORCE, POINT, TORQUE, MOMENT = 1.3, 1.7, 1.6, 1.6
TIMING = 0.010  # standard deviation of gait events found from the motion [s]
# Standard deviation of the vertical force at an end of the recording, beyond which the filter does
# not know the motion [BW], and its decay: time constant of a low-pass at 6 Hz [s]
END_SPREAD, END_TIME = 0.25, 0.027
NEAR_EVENT = 0.15  # within this of landing and leaving the instant matters [s]


@dataclass(frozen=True)
class Spread:
    """Standard deviations at the frames of the program."""

    force: Float[Array, "n k 3"]  #: [BW]
    point: Float[Array, "n k 2"]  #: Centre of pressure, x and y [m]
    torque: Float[Array, "n k"]  #: Free moment [BW m]
    joints: Float[Array, "n 2 n_joints"]  #: Joint moments of the legs [BW m]
    root: Float[Array, "n 6"]  #: Force [BW] and moment about the pelvis in its axes [BW m]


def drawn_errors(
    blocks: dict[str, slice],
    place: dict[str, np.ndarray],
    n: int,
    dt: float,
    pace: float = 1.0,
) -> Float[Array, "n_rows n_draws"]:
    """Return errors of all rows, in their scales, by block; the shift's are independent.

    Args:
        blocks: Rows by name.
        place: Frame and carrier of the rows of a block.
        n: Number of frames.
        dt: Time between frames [s].
        pace: How many times higher the frequencies of the motion are than those of walking.
    """
    rng = np.random.default_rng(0)
    errors = np.empty((max(s.stop for s in blocks.values()), DRAWS))
    for name, rows in blocks.items():
        if name.startswith(("shift", "offset")):  # once for the recording
            errors[rows] = rng.normal(size=(rows.stop - rows.start, DRAWS))
            continue
        alike = BEND_TIME / pace
        if name.startswith(("force", "moment", "noise")):
            alike = NOISE_TIME / pace
        elif name.startswith(("path", "free", "effort")):
            alike = PATH_TIME
        frame, foot = place[name]
        for k in np.unique(foot):
            own = np.flatnonzero(foot == k)
            drawn = _smooth_noise(rng, n + 2, alike / dt)
            errors[rows.start + own] = np.sqrt(dt) * drawn[frame[own]]
    return errors


def calm_errors(
    errors: Float[Array, "n_rows n_draws"],
    blocks: dict[str, slice],
    missed: Float[Array, " n_rows"],
) -> Float[Array, "n_rows n_draws"]:
    """Return the errors of a motion that is no gait, slower than one perhaps.

    Moments and forces that change less than the scales of walking allow err less, too.

    Args:
        errors: From :func:`drawn_errors`.
        blocks: Rows by name.
        missed: By how much the rows are missed, in their scales.
    """
    out = errors.copy()
    for kind in ("rate", "bend"):
        rows = np.concatenate([np.r_[s] for name, s in blocks.items() if name.startswith(kind)])
        if len(rows):
            out[rows] *= min(1.0, float(np.sqrt(np.mean(missed[rows] ** 2))))
    effort = np.concatenate([np.r_[s] for n, s in blocks.items() if n.startswith("effort")])
    if len(effort):
        out[effort] *= ACTIVATION * float(np.sqrt(np.mean(missed[effort] ** 2)))
    for name, rows in blocks.items():
        if name.startswith("path"):
            out[rows] *= ASIDE
    return out


def _smooth_noise(rng, n: int, width: float) -> np.ndarray:
    """Return unit noise (n, draws), alike over about ``width`` frames."""
    from scipy.ndimage import gaussian_filter1d, uniform_filter1d

    white = rng.standard_normal((n, DRAWS), dtype=np.float32)
    if width < 8:
        white = gaussian_filter1d(white, width, axis=0, mode="nearest")
    else:  # two boxes spread by as much, and take less time
        for _ in range(2):
            white = uniform_filter1d(white, round(np.sqrt(6.0) * width), axis=0, mode="nearest")
    return white / white.std()


def spread_of(
    needs: ForceNeeds,
    wrench: Float[Array, "n k 6"],
    moved: Float[Array, "n k 6 n_draws"],
    least: float,
) -> Spread:
    """Return the spread of everything that follows from the wrenches.

    Forces and centres of pressure are in world axes.

    Args:
        needs: The motion.
        wrench: The estimate [BW, BW m].
        moved: How far each draw moves it.
        least: Load from which the centre of pressure is told [BW].
    """
    load = np.maximum(wrench[..., 2], least)
    x, y = -wrench[..., 4] / load, wrench[..., 3] / load
    dx = -(moved[:, :, 4] + x[..., None] * moved[:, :, 2]) / load[..., None]
    dy = (moved[:, :, 3] - y[..., None] * moved[:, :, 2]) / load[..., None]
    twist = (
        moved[:, :, 5]
        - x[..., None] * moved[:, :, 1]
        + y[..., None] * moved[:, :, 0]
        - dx * wrench[:, :, 1, None]
        + dy * wrench[:, :, 0, None]
    )
    joints = np.einsum("nkji,nkid->nkjd", needs.arms, moved[:, :2])
    arm = needs.base - needs.pelvis[:, None]
    turning = np.cross(arm[..., None], moved[:, :, :3], axis=2) + moved[:, :, 3:]
    turning = np.einsum("nji,njd->nid", needs.rotation, turning.sum(axis=1))
    force = np.einsum("ij,nkjd->nkid", needs.to_world, moved[:, :, :3])
    root = np.concatenate([force.sum(axis=1), turning], axis=1)
    length = needs.sole[..., [1, 3]] - needs.sole[..., [0, 2]]
    point = np.stack([needs.to_world[0, 0] * dx.std(axis=-1), dy.std(axis=-1)], axis=-1)
    return Spread(
        force.std(axis=-1),
        np.minimum(point, np.maximum(length.max(axis=-1, keepdims=True), 0.01)),
        twist.std(axis=-1),
        joints.std(axis=-1),
        root.std(axis=-1),
    )


def half_widths(
    needs: ForceNeeds,
    wrench: Float[Array, "n k 6"],
    spread: Spread,
    contacts: tuple[ContactInterval, ...],
    time: Float[Array, " n_frames"],
    known: Bool[Array, "n_frames 2"],
    human: Human,
) -> dict[str, Array]:
    """Return the half-widths of the 90 % bands of the feet at instants [N, m, N m].

    Joints within a foot have none (NaN): how its segments share the load is not known.

    Args:
        needs: The motion.
        wrench: The estimate [BW, BW m].
        spread: From :func:`spread_of`.
        contacts: When the feet may carry load.
        time: Instants [s].
        known: Where plates told the force of a foot.
        human: Whose motion.
    """
    force = wrench[:, :2, :3] @ needs.to_world.T
    timing = np.abs(np.gradient(force, needs.time, axis=0)) * TIMING
    near = np.zeros((len(needs.time), 2, 1))
    for each in contacts:
        if each.side:
            k = SIDES.index(each.side)
            for edge, seen in ((each.start, each.begins), (each.stop, each.ends)):
                if seen:
                    near[np.abs(needs.time - edge) < NEAR_EVENT, k] = 1.0
    force = np.hypot(FORCE * spread.force[:, :2], near * timing)
    to_end = np.minimum(needs.time - needs.time[0], needs.time[-1] - needs.time)
    blurred = END_SPREAD * np.exp(-to_end / END_TIME)[:, None] * (wrench[:, :2, 2] > 0)
    force[..., 2] = np.hypot(force[..., 2], blurred)
    weight = NINETY * needs.weight
    bands = {
        "force_band": weight * force,
        "point_band": NINETY * POINT * spread.point[:, :2],
        "torque_band": weight * TORQUE * spread.torque[:, :2],
    }
    result = {}
    for name, band in bands.items():
        here = resampled(needs.time, band, time)
        here[known] = 0.0
        result[name] = here
    nv = human.model.nv
    moment = np.zeros((len(time), nv))
    moment[:, :6] = resampled(needs.time, weight * MOMENT * spread.root, time)
    joints = resampled(needs.time, weight * MOMENT * spread.joints, time)
    joints[known] = 0.0
    for k, side in enumerate(SIDES):
        moment[:, needs.columns[k]] = joints[:, k]
        within = PointSet(human, [f"foot_{side}"], np.zeros((1, 3))).moved[0, 0]
        for body in Carriers(human).bodies():
            if human.body_names[body - 1].endswith(f"_{side}"):
                name = human.body_names[body - 1]
                own = PointSet(human, [name], np.zeros((1, 3))).moved[0, 0]
                moment[:, (own > 0) & (within == 0)] = np.nan
    result["moment_band"] = moment
    return result


def resampled(
    old: Float[Array, " n"], values: Float[Array, " n *more"], new: Float[Array, " n_new"]
) -> Float[Array, " n_new *more"]:
    """Return values at other instants, on straight lines between the old ones."""
    if len(old) == len(new):
        return np.array(values, dtype=float)
    place = np.interp(new, old, np.arange(len(old)))
    before = np.minimum(place.astype(int), len(old) - 2)
    part = (place - before).reshape(-1, *(1,) * (values.ndim - 1))
    return (1.0 - part) * values[before] + part * values[before + 1]
