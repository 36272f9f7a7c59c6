"""Forces estimated from a recorded motion, as what its tracked motion starts from and keeps near.

The estimate (:mod:`plantigrade.dynamics.ground_forces`) gives the wrench on each foot with its
error band; a tracked motion needs the forces at the sites of the feet.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.ground_forces import GroundForces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import interpolate
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.tracking import FootWrenches, JointMoments

# [1] half-width of a 90 % band of a normal distribution in standard deviations
HALF_WIDTH_90 = 1.645
# minimum SDs of force [BW], centre of pressure [m], free moment [BW m]
MIN_FORCE_SPREADS = (0.01, 0.003, 0.002)
MIN_MOMENT_SPREAD = 0.03  # [N m/kg] minimum SD of a joint moment
# [1] initial share of the weight on every standing site, for a strictly feasible start
INITIAL_LOAD_SHARE = 1e-3


def expected_wrenches(
    human: Human, found: GroundForces, time: Float[Array, " n_frames"]
) -> FootWrenches:
    """Return the estimated wrenches on the feet with their standard errors.

    Args:
        found: The estimate, on frames ``time`` of the motion.
        time: Their times, as the task counts them [s].
    """
    weight = human.mass * human.gravity
    forces = found.forces
    point = np.array(forces.point[..., :2])
    here = np.asarray(np.isfinite(point).all(axis=2))
    for k in range(len(SIDES)):
        if here[:, k].any():  # in the air, where it is next or was last: of no weight there
            point[:, k] = interpolate(time, time[here[:, k]], point[here[:, k], k])
    point = np.nan_to_num(point)
    sure = forces.valid_side

    def error(band: Array, least: float, known: Array) -> Array:
        sigma = np.maximum(np.nan_to_num(band, nan=np.inf) / HALF_WIDTH_90, least)
        return np.where(known if band.ndim == 2 else known[..., None], sigma, np.inf)

    return FootWrenches(
        time,
        np.where(sure[..., None], forces.force, 0.0) / weight,
        point,
        np.where(sure, np.nan_to_num(forces.torque[..., 2]), 0.0) / weight,
        error(found.force_band / weight, MIN_FORCE_SPREADS[0], sure),
        error(found.point_band, MIN_FORCE_SPREADS[1], sure & here),
        error(found.torque_band / weight, MIN_FORCE_SPREADS[2], sure),
    )


def expected_moments(
    human: Human, motion: Motion, found: GroundForces, time: Float[Array, " n_frames"]
) -> JointMoments:
    """Return the moments of the hinges with the estimated forces, and their standard errors.

    The error is infinite where there is no estimate: at joints within the foot; in runs and jumps
    also where the ground does not matter, above the pelvis and in flight. Those moments are second
    derivatives of the motion alone, and noise at its frequencies: up to 400 N m in a trunk that
    lands. The bands know of the uncertainty of the ground reactions only.

    Args:
        found: The estimate, on its frames.
        time: Their times, as the task counts them [s].
    """
    assert motion.qacc is not None
    moved = human, motion.qpos, motion.qvel, motion.qacc
    tau = inverse_dynamics(*moved, found.forces).tau[:, 6:]
    band = np.nan_to_num(found.moment_band[:, 6:], nan=np.inf)
    known = np.isfinite(tau)
    least = MIN_MOMENT_SPREAD * human.mass
    if found.flies:
        known &= band / HALF_WIDTH_90 > least
    error = np.where(known, np.maximum(band / HALF_WIDTH_90, least), np.inf)
    return JointMoments(time, human.coordinates, np.nan_to_num(tau), error)


def seat_share(human: Human, found: GroundForces) -> Float[Array, "n_frames 3"]:
    """Return the estimated force of all that carries besides the feet [body weights]."""
    weight = human.mass * human.gravity
    return np.nan_to_num(found.support_force).sum(axis=1) / weight


def forces_at_sites(
    body: ContactBody,
    feet: FootWrenches,
    seat: Float[Array, "n_times 3"],
    q: Float[Array, "n_times nv"],
    carrying: Bool[Array, "n_times n_sites"],
) -> Float[Array, "n_times n_unknowns"]:
    """Return forces at the sites that make up the wrenches as well as pushing ones can.

    Args:
        feet: The wrenches at the given times.
        seat: Force that sites of no foot share [body weights].
        q: Coordinates at these times.
        carrying: Where a site may carry.
    """
    from scipy.optimize import nnls

    n, sites = len(q), body.sites
    places = np.array(body.symbolic.positions(list(sites))(q.T))
    places = places.reshape(3, n, len(sites)).transpose(1, 2, 0)
    out = np.zeros((n, len(sites), 3))
    for i in range(n):
        for k, side in enumerate(SIDES):
            own = [j for j, s in enumerate(sites) if s.side == side and carrying[i, j]]
            if not own:
                continue
            force, arm = feet.force[i, k], places[i, own, :2] - feet.point[i, k]
            # loads that sum up, have no moment about the centre of pressure, and are spread
            A = np.vstack([np.ones(len(own)), 10.0 * arm.T, 0.1 * np.eye(len(own))])
            load = nnls(A, np.r_[max(float(force[2]), 0.0), np.zeros(2 + len(own))])[0]
            total = max(float(load.sum()), INITIAL_LOAD_SHARE)
            out[i, own] = np.outer(load / total, force)
            out[i, own, 2] += INITIAL_LOAD_SHARE
        rest = [j for j, s in enumerate(sites) if not s.side and carrying[i, j]]
        if rest:
            out[i, rest] = seat[i] / len(rest)
            out[i, rest, 2] = np.maximum(out[i, rest, 2], INITIAL_LOAD_SHARE)
    return out.reshape(n, -1)
