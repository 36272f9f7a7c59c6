r"""Ground reactions from motion, with or without plates, by one quadratic program over time.

The unknowns are the wrench of each foot in every frame of its contacts (force :math:`F` and moment
:math:`M` about a point of the floor below the ankle), the noise :math:`\eta` of the motion, and for
the whole recording one shift :math:`d` of the centre of mass and one constant offset of each foot's
centre of pressure from its mean path. With the required net wrench :math:`F_n, M_n` about the
model's centre of mass :math:`c` and the joint moments :math:`\tau_0` without ground reactions, the
objective is the time integral of

* :math:`\sum F - F_n - \ddot\eta_F` and :math:`\sum (p - c) \times F + M - M_n - d \times F_n -
  \ddot\eta_M`, the net wrench; as an exact constraint it would transfer the noise of the motion to
  the centre of pressure;
* :math:`\eta`, because position noise is similar at all frequencies and acceleration noise grows
  with frequency; slow components such as body weight are accurate;
* :math:`\frac{d}{dt}(\tau_0 - J^T w)` of the joints of each leg, because joint moments change
  slowly;
* :math:`\ddot F` and :math:`\ddot M`, with zero wrench outside the contacts, because forces are
  smooth;
* the free moment, and in walking the distance of the centre of pressure from its mean path,

each squared and divided by its scale, subject to :math:`F_z \ge 0`, friction, and a centre of
pressure within the part of the sole on the floor. Measured wrenches are given, not unknown.

**Noise.** The residual of the net wrench is compared with the residual expected for the assumed
errors (drawn as for the bands, :mod:`plantigrade.dynamics.force_bands`). A larger residual means a
noisier motion: the scales of that row are multiplied by :math:`k` (vertical force :math:`\sqrt k`),
and the program is solved again, at most twice.

A long recording is solved in windows (:mod:`plantigrade.dynamics.force_windows`).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.centroid import check_motion
from plantigrade.dynamics.force_bands import BandFactors, half_widths
from plantigrade.dynamics.force_program import MIN_PRESSURE_LOAD
from plantigrade.dynamics.force_scales import ForceScales
from plantigrade.dynamics.force_windows import solve_in_windows
from plantigrade.dynamics.loading import Support, find_loading
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.required_forces import RequiredForces, required_forces
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.filters import interpolate
from plantigrade.motion.motion import Motion

MAX_RATE = 150.0  # [Hz] maximum frame rate of the program; faster recordings are decimated
MAX_FRAMES = 800  # [1] number of frames above which recordings are decimated further
MIN_RATE = 50.0  # [Hz] minimum frame rate of this decimation


@dataclass(frozen=True)
class GroundForces:
    """Ground reactions of both feet over a motion, with confidence bands; sides r, l."""

    forces: FootForces  #: Forces on both feet in every frame
    measured: Bool[Array, "n_frames 2"]  #: Frames with measured force
    #: Half-width of the 90 % band of the force [N]
    force_band: Float[Array, "n_frames 2 3"]
    point_band: Float[Array, "n_frames 2 2"]  #: Half-width for the centre of pressure, x and y [m]
    torque_band: Float[Array, "n_frames 2"]  #: Half-width for the free moment [N m]
    #: Half-width for the generalised forces of inverse dynamics with these forces [N, N m]
    moment_band: Float[Array, "n_frames nv"]
    com_shift: Float[
        Array, " 3"
    ]  #: Estimated offset of the true centre of mass from the model's [m]
    noise: float  #: Noise of the motion relative to the assumed noise [1]
    #: RMS residual of the net force in excess of the noise of the motion [BW]
    residual_force: float
    residual_moment: float  #: RMS residual of the pitch and roll moment [BW m]
    contacts: tuple[ContactInterval, ...] = field(repr=False)  #: When feet and supports were loaded
    supports: tuple[Support, ...]  #: Supports other than the feet
    support_force: Float[Array, "n_frames n_supports 3"]  #: Force of each on the body [N]
    #: Centre of pressure of each support [m]; NaN if unloaded
    support_point: Float[Array, "n_frames n_supports 3"]
    support_torque: Float[Array, "n_frames n_supports 3"]  #: Free moment of each support [N m]
    flies: bool = False  #: Whether the person runs or jumps


NO_CONTACT = (
    "no foot touches the ground in this motion; forces need a standing foot (or give `contacts` "
    "when something carries)"
)


def estimate_forces(
    human: Human,
    motion: Motion,
    *,
    measured: FootForces | None = None,
    contacts: tuple[ContactInterval, ...] | None = None,
    supports: tuple[Support, ...] = (),
    scales: ForceScales | None = None,
    ground: Ground = LEVEL_GROUND,
) -> GroundForces:
    """Return the ground reaction on each foot in every frame.

    Args:
        motion: The motion, filtered, with accelerations and gait events.
        measured: Measured forces, kept in the frames of ``valid_side``.
        contacts: Intervals in which each foot or support may carry load; by default detected from
            the motion (:func:`~plantigrade.dynamics.loading.find_loading`).
        supports: Supports other than the feet, loaded according to ``contacts``.
        scales: Scales of the program; by default those of the activity.
        ground: Ground under the feet. On a slope the program is stated in the axes of the slope.

    Raises:
        ParameterError: If the motion has no accelerations, is too short, has no contacts, or the
            measured forces are not on its frames.
        SolverError: If the program cannot be solved.
    """
    qacc = _check(human, motion, measured)
    flies, factors = False, BandFactors()
    if contacts is None or scales is None:
        loading = find_loading(human, motion, ground)
        if contacts is None:
            contacts, supports = loading.contacts, loading.supports
        scales = scales or ForceScales.of(walks=loading.walks, pace=loading.pace)
        flies, sits = loading.flies, bool(loading.supports)
        factors = BandFactors.of(walks=loading.walks, flies=flies, sits=sits)
    if not contacts and measured is None:
        raise ParameterError(NO_CONTACT)
    step = _step(motion)
    chosen = slice(None, None, step)
    needs = required_forces(human, motion.frames(chosen), qacc[chosen], contacts, supports, ground)
    data = None if measured is None else _in_axes(measured, step, needs)
    found = solve_in_windows(human, needs, contacts, supports, data, scales)
    force, point, torque = _at_pressure(motion.time, needs, found.wrench)
    known, feet = _with_measured(measured, force, point, torque)
    instants = contacts, motion.time, known, human, factors
    return GroundForces(
        feet,
        known,
        **half_widths(needs, found.wrench, found.spread, *instants),
        com_shift=needs.to_world @ found.shift,
        noise=found.noise,
        residual_force=found.residual_force,
        residual_moment=found.residual_moment,
        contacts=contacts,
        supports=supports,
        support_force=force[:, 2:],
        support_point=point[:, 2:],
        support_torque=torque[:, 2:],
        flies=flies,
    )


def _at_pressure(time, needs: RequiredForces, wrench) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return forces [N], centres of pressure [m] and free moments [N m], world."""
    w, base = (interpolate(time, needs.time, x) for x in (wrench, needs.base))
    load = w[..., 2] > MIN_PRESSURE_LOAD
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = -w[..., 4] / w[..., 2], w[..., 3] / w[..., 2]
    point = base + np.stack([x, y, np.zeros_like(x)], axis=-1)
    point[~load] = np.nan
    torque = np.zeros_like(point)
    torque[..., 2] = np.where(load, w[..., 5] - x * w[..., 1] + y * w[..., 0], 0.0)
    force = np.where(load[..., None], w[..., :3], 0.0)
    to_ground = needs.to_world.T
    return needs.weight * force @ to_ground, point @ to_ground, needs.weight * torque @ to_ground


def _step(motion: Motion) -> int:
    """Return the decimation factor for fast and long recordings."""
    step = np.ceil(motion.rate / MAX_RATE)
    longer = min(np.ceil(motion.n_frames / MAX_FRAMES), motion.rate // MIN_RATE)
    return max(1, int(max(step, longer)))


def _check(human: Human, motion: Motion, measured: FootForces | None) -> np.ndarray:
    if motion.qacc is None:
        raise ParameterError("the motion has no accelerations; filter and differentiate it first")
    check_motion(human, motion.qpos, motion.qvel, motion.qacc)
    if motion.n_frames < 4:
        raise ParameterError(f"{motion.n_frames} frames are too few; forces need at least 4")
    if measured is not None and len(measured.force) != motion.n_frames:
        raise ParameterError(
            f"the forces have {len(measured.force)} frames, the motion {motion.n_frames}; put both "
            "on one clock"
        )
    return motion.qacc


def _in_axes(measured: FootForces, step: int, needs: RequiredForces) -> FootForces:
    """Return measured forces at every ``step``-th frame in the axes of the program."""
    frames = measured.frames(slice(None, None, step))
    turned = (each @ needs.to_world for each in (frames.force, frames.point, frames.torque))
    return replace(frames, **dict(zip(("force", "point", "torque"), turned, strict=True)))


def _with_measured(
    measured: FootForces | None, force: Array, point: Array, torque: Array
) -> tuple[Bool[Array, "n_frames 2"], FootForces]:
    """Return the frames of measured force on each foot, and measured and estimated forces."""
    known = np.zeros((len(force), 2), bool)
    if measured is not None:
        known = np.array(measured.valid_side)
        force[:, :2][known], point[:, :2][known] = measured.force[known], measured.point[known]
        torque[:, :2][known] = measured.torque[known]
    sure = np.ones(known.shape, bool)
    notes = ((), ()) if measured is None else (measured.uses, measured.warnings)
    feet = FootForces(force[:, :2], point[:, :2], torque[:, :2], sure, sure[:, 0].copy(), *notes)
    return known, feet
