r"""Inverse dynamics: joint moments from a motion and its measured ground reactions.

With the equations of motion of the free-floating body,

.. math:: M(q)\,\dot v + h(q, v) = \tau + \sum_k J_k^T w_k,

:math:`\tau` is the generalised force that remains after the external wrenches :math:`w_k` (ground
on body) with the Jacobians :math:`J_k` of the loaded segments. Its hinge part is the internal joint
moments; its root part, zero for perfect measurements, is the residual.

:math:`\tau` is computed from MuJoCo's equations of motion without contacts and joint limits. The
model has no passive joint moments; those of ligaments and soft tissue are part of :math:`\tau`.

The moments of a leg follow from the forces under that leg alone, those of the trunk and arms from
the motion alone; only the residual requires measurements of both feet
(:attr:`~plantigrade.dynamics.plates.FootForces.valid_side`).
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.dynamics.centroid import check_motion, root_wrench_at
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.segment_loads import SegmentLoads
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.spatial.conventions import facing

MIN_CARRIED_SHARE = (
    0.8  # [1] minimum share of the required force; with less, a chair or another foot carries load
)
ROOT_NAMES = tuple(f"root_{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz")


@dataclass(frozen=True)
class Moments:
    """Generalised forces of a motion."""

    #: Generalised forces in the order of ``qvel``: the residual at the root as world force [N]
    #: and moment about the pelvis' origin in body axes [N m], then joint moments by the body [N
    #: m], positive in the sense of their coordinate (flexion, dorsiflexion, …)
    tau: Float[Array, "n_frames nv"]
    names: tuple[str, ...]  #: One name per column: those of the root, then the coordinates
    power: Float[Array, "n_frames nv"]  #: Power ``tau * qvel`` [W]; positive generates
    residual_force: Float[Array, "n_frames 3"]  #: Residual force at the root, world [N]
    #: Residual moment about the centre of mass of the body, world axes [N m]
    residual_moment: Float[Array, "n_frames 3"]
    com: Float[Array, "n_frames 3"]  #: Centre of mass [m]

    def __getitem__(self, name: str) -> Float[Array, " n_frames"]:
        """Return the column of a coordinate or of the root."""
        if name not in self.names:
            raise ParameterError(f"no moment {name!r}; there are {', '.join(self.names)}")
        return self.tau[:, self.names.index(name)]


def inverse_dynamics(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    qvel: Float[Array, "n_frames nv"],
    qacc: Float[Array, "n_frames nv"],
    forces: FootForces | None = None,
) -> Moments:
    """Return joint moments and root residuals of a motion.

    Args:
        forces: Ground reactions on the frames of the motion, smoothed like it; none if absent.
    """
    check_motion(human, qpos, qvel, qacc)
    n = len(qpos)
    if forces is not None and len(forces.force) != n:
        raise ParameterError(
            f"the forces have {len(forces.force)} frames, the motion {n}; put both on one clock"
        )
    carriers = SegmentLoads(human)
    tau, com = np.empty((n, human.model.nv)), np.empty((n, 3))
    for f, state in enumerate(sweep(human, qpos, qvel)):
        tau[f], com[f] = state.inverse_dynamics(qacc[f]), state.com
        if forces is not None:
            for k, side in enumerate(SIDES):
                force, point, torque = forces.force[f, k], forces.point[f, k], forces.torque[f, k]
                if not np.isfinite(point).all():
                    continue
                for load in carriers.divide(state, side, force, point, torque):
                    tau[f] -= state.generalised_force(
                        load.body, load.point, load.force, load.torque
                    )
    force, moment = root_wrench_at(tau[:, :6], qpos, com)
    names = ROOT_NAMES + human.coordinates
    return Moments(tau, names, tau * qvel, force, moment, com)


def residual_metrics(moments: Moments, forces: FootForces) -> dict[str, float]:
    """Return the residuals of forces and motion over the frames with complete forces.

    The usual bounds are a residual force of 5 % of the peak ground reaction and a residual moment
    of 1 % of that times the height of the centre of mass [Hicks2015]_; the returned shares refer
    to these two quantities.

    Args:
        moments: From :func:`inverse_dynamics`.
    """
    valid = forces.valid
    if not valid.any():
        return {"residual_frames": 0}
    force = np.linalg.norm(moments.residual_force[valid], axis=1)
    moment = np.linalg.norm(moments.residual_moment[valid], axis=1)
    peak = float(np.linalg.norm(forces.force.sum(axis=1), axis=1)[valid].max())
    height = float(np.mean(moments.com[valid, 2]))
    rms_force, rms_moment = (root_mean_square(x) for x in (force, moment))
    result = {
        "residual_frames": int(valid.sum()),
        "residual_force_rms_n": rms_force,
        "residual_force_max_n": float(force.max()),
        "residual_moment_rms_nm": rms_moment,
        "residual_moment_max_nm": float(moment.max()),
    }
    if peak > 0:
        result["residual_force_rms_share"] = rms_force / peak
        result["residual_moment_rms_share"] = rms_moment / (peak * height)
    return result


def com_metrics(
    moments: Moments, forces: FootForces, qpos: Float[Array, "n_frames nq"]
) -> dict[str, float]:
    r"""Return the offset of the model's centre of mass from that of the measured forces [mm].

    An offset :math:`d` leaves a residual moment :math:`d \times F`; its mean over the frames in
    which the plates carry the whole person gives :math:`d` forward and to the left in the pelvis
    frame. The horizontal force is that of the motion (:math:`m a`), because an error of 10 N of a
    plate would shift the result by more than 10 mm.

    Args:
        moments: From :func:`inverse_dynamics`.
        qpos: Configurations of the motion, for its heading.

    Returns:
        ``com_ahead_mm`` and ``com_left_mm``; empty for fewer than ten usable frames.
    """
    measured = forces.force.sum(axis=1)
    inertial = measured + moments.residual_force  # m (a + g)
    level = np.nanmin(forces.point[..., 2]) if np.isfinite(forces.point).any() else 0.0
    whole = (
        np.asarray(forces.valid)
        & (measured[:, 2] > MIN_CARRIED_SHARE * inertial[:, 2])
        & (measured[:, 2] > 0)
    )
    if whole.sum() < 10:
        return {}
    arm = moments.com[whole, 2] - level
    load, slip = measured[whole, 2], moments.residual_force[whole]
    off = (
        np.stack(
            [
                -moments.residual_moment[whole, 1] - arm * slip[:, 0],
                moments.residual_moment[whole, 0] - arm * slip[:, 1],
            ],
            axis=1,
        )
        / load[:, None]
    )
    forward = facing(qpos[whole, 3:7])
    ahead = np.einsum("ni,ni->n", off, forward)
    left = off[:, 1] * forward[:, 0] - off[:, 0] * forward[:, 1]
    share = load**2 / np.sum(load**2)
    return {"com_ahead_mm": 1e3 * float(share @ ahead), "com_left_mm": 1e3 * float(share @ left)}
