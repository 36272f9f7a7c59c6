r"""Confidence bands of estimated ground reactions from the rows of the quadratic program.

Every row of the program has an error, from the noise of the motion, the curvature of the true
forces or the deviation of a person's centre-of-pressure path from the mean. Errors with the scale
of each row and a realistic correlation over time are drawn repeatedly; each draw displaces the
optimum by

.. math:: \delta x = (P + G^T \tfrac{z}{s} G)^{-1} A^T e,

with the rows :math:`A` divided by their scales, inequalities :math:`G`, multipliers :math:`z` and
slacks :math:`s`. One factorisation serves all draws. Their standard deviation times a factor for
each quantity is the band.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.required_forces import RequiredForces
from plantigrade.dynamics.segment_loads import SegmentLoads
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.motion.filters import interpolate

N_DRAWS = 32  # [1] Monte Carlo draws; the sampling error of a band is one eighth
HALF_WIDTH_90 = 1.645  # [1] half-width of a 90 % band in standard deviations
# Correlation times of the errors.
NOISE_TIME = 0.04  # [s] motion filtered at about 6 Hz
BEND_TIME = 0.04  # [s] forces and joint moments
PATH_TIME = 0.25  # [s] path of the centre of pressure, which is individual
# Without gait: deviation from minimum activation relative to that activation, and of the path from
# the foot's axis relative to that of a rolling foot.
ACTIVATION_SPREAD = 2.0  # [1]
FLAT_PATH_SPREAD = 0.5  # [1]
EDGE_TIME = 0.06  # [s] time in which the spread of the centre of pressure is about constant
EVENT_SPREAD = 0.010  # [s] standard deviation of gait events detected from the motion
# [BW] standard deviation of the vertical force at an end of the recording, where the filter lacks
# data
END_SPREAD = 0.25
END_TIME = 0.027  # [s] decay time of this error, that of a low-pass at 6 Hz
EVENT_WINDOW = 0.15  # [s] time around landing and take-off affected by errors of events


@dataclass(frozen=True)
class BandFactors:
    """Factors of the standard deviations of an activity, so that bands contain what plates measure.

    Those of walking cover 90 % in half of the people with plates, those of running in a run at
    2 m/s. Squats, chair and jumps are those of one person. Vertical and fore-aft forces of standing
    have half of the factors of walking, more than this person needs (all is inside), who loads both
    legs alike as others do not.
    """

    forward: float = 1.3  #: Fore-aft force [1]
    sideways: float = 1.25  #: Sideways force [1]
    vertical: float = 1.4  #: Vertical force [1]
    point_x: float = 1.45  #: Centre of pressure along the walking direction [1]
    point_y: float = 1.15  #: Centre of pressure across it [1]
    torque: float = 1.6  #: Free moment [1]
    hip: float = 1.35  #: Hip moments [1]
    knee: float = 1.5  #: Knee moment [1]
    other: float = 1.6  #: Moments of other joints and of the root [1]

    @classmethod
    def of(cls, *, walks: bool, flies: bool, sits: bool) -> "BandFactors":
        """Return the factors of walking, running, jumping, sitting or standing."""
        if walks:
            return cls(point_x=1.25, point_y=0.6, hip=1.1) if flies else cls()
        if flies:
            jumps = cls(sideways=1.9, vertical=0.9, point_x=1.95, point_y=2.0)
            return replace(jumps, hip=1.15, knee=1.3, other=1.4)
        if sits:
            return cls(0.65, 0.65, 0.7, 1.05, 0.6, hip=0.6, knee=0.8, other=1.1)
        return cls(0.65, 1.1, 0.7, 0.9, 0.5, hip=0.8, knee=1.0, other=1.0)

    @property
    def force(self) -> tuple[float, float, float]:
        """Factors of the components of a force [1]."""
        return self.forward, self.sideways, self.vertical

    def moments(self, coordinates: Sequence[str]) -> Float[Array, " n"]:
        """Return the factors of the moments of joints [1]."""
        named = {"hip": self.hip, "knee": self.knee}
        return np.array([named.get(c.partition("_")[0], self.other) for c in coordinates])


@dataclass(frozen=True)
class Spread:
    """Standard deviations at the frames of the program."""

    force: Float[Array, "n k 3"]  #: [BW]
    point: Float[Array, "n k 2"]  #: Centre of pressure, x and y [m]
    torque: Float[Array, "n k"]  #: Free moment [BW m]
    joints: Float[Array, "n 2 n_joints"]  #: Joint moments of the legs [BW m]
    root: Float[Array, "n 6"]  #: Force [BW] and moment about the pelvis in its axes [BW m]


def drawn_errors(
    blocks: dict[str, slice], place: dict[str, np.ndarray], n: int, dt: float, pace: float = 1.0
) -> Float[Array, "n_rows n_draws"]:
    """Return random errors of all rows in units of their scales.

    Args:
        place: Frame and support of the rows of a block.
        n: Number of frames.
        dt: Time between frames [s].
        pace: Ratio of the motion's frequencies to those of walking.
    """
    rng = np.random.default_rng(0)
    errors = np.empty((max(s.stop for s in blocks.values()), N_DRAWS))
    for name, rows in blocks.items():
        if name.startswith(("shift", "offset")):  # once for the recording
            errors[rows] = rng.normal(size=(rows.stop - rows.start, N_DRAWS))
            continue
        correlation_time = BEND_TIME / pace
        if name.startswith(("force", "moment", "noise")):
            correlation_time = NOISE_TIME / pace
        elif name.startswith(("path", "free", "effort")):
            correlation_time = PATH_TIME
        frame, foot = place[name]
        for k in np.unique(foot):
            own = np.flatnonzero(foot == k)
            drawn = _smooth_noise(rng, n + 2, correlation_time / dt)
            errors[rows.start + own] = np.sqrt(dt) * drawn[frame[own]]
    return errors


def errors_without_gait(
    errors: Float[Array, "n_rows n_draws"],
    blocks: dict[str, slice],
    missed: Float[Array, " n_rows"],
) -> Float[Array, "n_rows n_draws"]:
    """Return the errors for a motion that is not gait and possibly slower.

    Moments and forces with smaller rates than the scales of walking have smaller errors.

    Args:
        errors: From :func:`drawn_errors`.
        missed: Residuals of the rows in units of their scales.
    """
    out = errors.copy()
    for kind in ("rate", "bend"):
        rows = np.concatenate([np.r_[s] for name, s in blocks.items() if name.startswith(kind)])
        if len(rows):
            out[rows] *= min(1.0, float(np.sqrt(np.mean(missed[rows] ** 2))))
    effort = np.concatenate([np.r_[s] for n, s in blocks.items() if n.startswith("effort")])
    if len(effort):
        out[effort] *= ACTIVATION_SPREAD * float(np.sqrt(np.mean(missed[effort] ** 2)))
    for name, rows in blocks.items():
        if name.startswith("path"):
            out[rows] *= FLAT_PATH_SPREAD
    return out


def _smooth_noise(rng, n: int, width: float) -> np.ndarray:
    """Return unit noise (n, draws) with a correlation length of about ``width`` frames."""
    from scipy.ndimage import gaussian_filter1d, uniform_filter1d

    white = rng.standard_normal((n, N_DRAWS), dtype=np.float32)
    if width < 8:
        white = gaussian_filter1d(white, width, axis=0, mode="nearest")
    else:  # two box filters of the same width are faster
        for _ in range(2):
            white = uniform_filter1d(white, round(np.sqrt(6.0) * width), axis=0, mode="nearest")
    return white / white.std()


def spread_of(
    needs: RequiredForces,
    wrench: Float[Array, "n k 6"],
    moved: Float[Array, "n k 6 n_draws"],
    least: float,
) -> Spread:
    """Return the standard deviations of all results derived from the wrenches.

    Forces and centres of pressure are in world axes.

    Args:
        wrench: The estimate [BW, BW m].
        moved: Displacement of the estimate by each draw [BW, BW m].
        least: Minimum load for a centre of pressure [BW].
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
    needs: RequiredForces,
    wrench: Float[Array, "n k 6"],
    spread: Spread,
    contacts: tuple[ContactInterval, ...],
    time: Float[Array, " n_frames"],
    known: Bool[Array, "n_frames 2"],
    human: Human,
    factors: BandFactors,
) -> dict[str, Array]:
    """Return the half-widths of the 90 % bands of the feet at instants [N, m, N m].

    Joints within a foot have no band (NaN), because the load of its segments is unknown.

    Args:
        wrench: The estimate [BW, BW m].
        spread: From :func:`spread_of`.
        contacts: Intervals in which the feet may carry load.
        time: Times of the bands [s].
        known: Frames with measured force of each foot.
        factors: Factors of the activity.
    """
    force = wrench[:, :2, :3] @ needs.to_world.T
    timing = np.abs(np.gradient(force, needs.time, axis=0)) * EVENT_SPREAD
    near = _near_events(needs.time, contacts)
    force = np.hypot(factors.force * spread.force[:, :2], near * timing)
    point, joints = _beyond_edges(needs, wrench, spread)
    to_end = np.minimum(needs.time - needs.time[0], needs.time[-1] - needs.time)
    blurred = END_SPREAD * np.exp(-to_end / END_TIME)[:, None] * (wrench[:, :2, 2] > 0)
    force[..., 2] = np.hypot(force[..., 2], blurred)
    weight = HALF_WIDTH_90 * needs.weight
    bands = {
        "force_band": weight * force,
        "point_band": HALF_WIDTH_90 * point * (factors.point_x, factors.point_y),
        "torque_band": weight * factors.torque * spread.torque[:, :2],
    }
    result = {}
    for name, band in bands.items():
        here = interpolate(time, needs.time, band)
        here[known] = 0.0
        result[name] = here
    moment = np.zeros((len(time), human.model.nv))
    moment[:, :6] = interpolate(time, needs.time, weight * factors.other * spread.root)
    names = [[human.coordinates[c - 6] for c in own] for own in needs.columns]
    joints = joints * np.array([factors.moments(own) for own in names])
    joints = interpolate(time, needs.time, weight * joints)
    joints[known] = 0.0
    _set_joints(moment, joints, needs, human)
    result["moment_band"] = moment
    return result


def _near_events(
    time: Float[Array, " n"], contacts: tuple[ContactInterval, ...]
) -> Float[Array, "n 2 1"]:
    """Return 1 for each foot near the ends of its contacts that are in the motion, else 0."""
    near = np.zeros((len(time), 2, 1))
    for each in contacts:
        if each.side:
            k = SIDES.index(each.side)
            for edge, seen in ((each.start, each.begins), (each.stop, each.ends)):
                if seen:
                    near[np.abs(time - edge) < EVENT_WINDOW, k] = 1.0
    return near


def _set_joints(moment: Array, joints: Array, needs: RequiredForces, human: Human) -> None:
    """Set the bands of the joints of the legs; NaN within the feet."""
    for k, side in enumerate(SIDES):
        moment[:, needs.columns[k]] = joints[:, k]
        within = PointSet(human, [f"foot_{side}"], np.zeros((1, 3))).moved[0, 0]
        for body in SegmentLoads(human).bodies():
            if human.body_names[body - 1].endswith(f"_{side}"):
                name = human.body_names[body - 1]
                own = PointSet(human, [name], np.zeros((1, 3))).moved[0, 0]
                moment[:, (own > 0) & (within == 0)] = np.nan


def _beyond_edges(
    needs: RequiredForces, wrench: Float[Array, "n k 6"], spread: Spread
) -> tuple[Float[Array, "n 2 2"], Float[Array, "n 2 n_joints"]]:
    """Return the spread of centres of pressure and joint moments without collapse at edges.

    Draws do not move a centre of pressure that is at the edge of the sole, although the error that
    took it there is as large as before and after. The spread at an instant is the largest of
    those within :data:`EDGE_TIME`; its increase acts on the joint moments, too.
    """
    from scipy.ndimage import maximum_filter1d

    load = np.maximum(wrench[:, :2, 2], 0.0)
    size = 2 * round(EDGE_TIME / float(np.median(np.diff(needs.time)))) + 1
    point = np.where(load[..., None] > 0, spread.point[:, :2], 0.0)
    wide = np.where(load[..., None] > 0, maximum_filter1d(point, size, axis=0), point)
    more = load[..., None] * np.sqrt(np.maximum(wide**2 - point**2, 0.0))
    arms = needs.arms[..., [4, 3]]  # moments about y and x by shifts along x and y
    turned = np.einsum("nkji,nki->nkj", arms**2, more**2)
    return wide, np.sqrt(spread.joints**2 + turned)
