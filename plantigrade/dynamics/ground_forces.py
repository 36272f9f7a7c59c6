r"""Ground reactions from motion, with or without plates: one quadratic program over time.

Unknown are the wrench of each foot in every frame of its contacts, force :math:`F` and moment
:math:`M` about a point of the floor below the ankle, the noise :math:`\eta` of the motion, and for
the whole recording one shift :math:`d` of the centre of mass and one constant by which the centre
of pressure of each foot lies beside its usual path. With the net wrench :math:`F_n, M_n` about the
model's centre of mass :math:`c` and the joint moments :math:`\tau_0` that the motion needs,
minimise the time integral of

* :math:`\sum F - F_n - \ddot\eta_F` and :math:`\sum (p - c) \times F + M - M_n - d \times F_n -
  \ddot\eta_M`: the net wrench. Held exactly, what the motion has of noise would go into the centre
  of pressure;
* :math:`\eta`: places are off by much the same at all frequencies, accelerations therefore the
  more the higher the frequency. What changes slowly, such as body weight, is told well;
* :math:`\frac{d}{dt}(\tau_0 - J^T w)` of the joints of each leg: joint moments change slowly;
* :math:`\ddot F` and :math:`\ddot M`, zero outside the contacts: forces are smooth;
* the free moment, and in walking the distance of the centre of pressure from its usual path,

each squared and over its scale, subject to :math:`F_z \ge 0`, friction, and a centre of pressure
within the part of the sole that is on the floor. Wrenches that plates measured are no unknowns.

**Noise.** How far the net wrench is missed is compared with what errors of the sizes assumed would
leave of themselves (drawn as for the bands, :mod:`plantigrade.dynamics.force_bands`). Where it is
missed by more, the motion is noisier: the scales of that row are taken :math:`k` times (vertical
force :math:`\sqrt k`), and the program is solved again, twice at most.

A long recording is solved in windows (:mod:`plantigrade.dynamics.force_windows`).
"""

from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.centroid import check_motion
from plantigrade.dynamics.force_bands import half_widths, resampled
from plantigrade.dynamics.force_needs import ForceNeeds, force_needs
from plantigrade.dynamics.force_program import LIGHT, ForceScales
from plantigrade.dynamics.force_windows import solve_in_windows
from plantigrade.dynamics.load_intervals import Support
from plantigrade.dynamics.loading import find_loading
from plantigrade.dynamics.plates import FootForces
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.motion import Motion

FASTEST = 150.0  # frames are left out above this rate [Hz]
MANY, SLOWEST = 800, 50.0  # more frames than so many are left out too, down to this rate [Hz]


@dataclass(frozen=True)
class GroundForces:
    """Ground reactions of both feet over a motion, with confidence bands; sides r, l."""

    forces: FootForces  #: Every foot in every frame
    measured: Bool[Array, "n_frames 2"]  #: Where plates told them
    #: Half-width of the 90 % band of the force [N]
    force_band: Float[Array, "n_frames 2 3"]
    point_band: Float[Array, "n_frames 2 2"]  #: The same of the centre of pressure, x and y [m]
    torque_band: Float[Array, "n_frames 2"]  #: The same of the free moment [N m]
    #: The same of the generalised forces of inverse dynamics with these forces [N, N m]
    moment_band: Float[Array, "n_frames nv"]
    com_shift: Float[Array, " 3"]  #: Where the true centre of mass lies from the model's [m]
    noise: float  #: How many times noisier the motion is than assumed; 1 as assumed
    #: Root mean square of the net force that is missed beside the noise of the motion [BW]
    residual_force: float
    residual_moment: float  #: The same of the pitch and roll moment [BW m]
    contacts: tuple[ContactInterval, ...] = field(repr=False)  #: When feet and supports were loaded
    supports: tuple[Support, ...]  #: Supports besides the feet
    support_force: Float[Array, "n_frames n_supports 3"]  #: Force of each on the body [N]
    #: Its centre of pressure [m]; NaN where it carries nothing
    support_point: Float[Array, "n_frames n_supports 3"]
    support_torque: Float[Array, "n_frames n_supports 3"]  #: Its free moment [N m]
    flies: bool = False  #: Whether the person runs or jumps


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
        human: Whose motion.
        motion: The motion, filtered, with accelerations and gait events.
        measured: What plates tell; it is kept, where ``valid_side`` says it is known.
        contacts: When each foot or support may carry load; as the motion tells if absent
            (:func:`~plantigrade.dynamics.loading.find_loading`).
        supports: What may carry load besides the feet, where ``contacts`` say so.
        scales: What the program weighs by; what suits the activity if absent.
        ground: Ground under the feet. On a slope the program is stated in the axes of the slope.

    Raises:
        ParameterError: If the motion has no accelerations, is too short, nothing ever carries, or
            the measured forces are not on its frames.
        SolverError: If the program cannot be solved.
    """
    qacc = _check(human, motion, measured)
    flies = False
    if contacts is None or scales is None:
        loading = find_loading(human, motion, ground)
        if contacts is None:
            contacts, supports = loading.contacts, loading.supports
        if scales is None:
            scales = ForceScales.of(walks=loading.walks, pace=loading.pace)
        flies = loading.flies
    if not contacts and measured is None:
        raise ParameterError(
            "no foot touches the ground in this motion; forces need a standing foot (or give "
            "`contacts` when something carries)"
        )
    step = _step(motion)
    coarse = motion.frames(slice(None, None, step))
    needs = force_needs(human, coarse, qacc[::step], contacts, supports, ground)
    data = None
    if measured is not None:
        told = measured.frames(slice(None, None, step))
        turned = (each @ needs.to_world for each in (told.force, told.point, told.torque))
        data = replace(told, **dict(zip(("force", "point", "torque"), turned, strict=True)))
    found = solve_in_windows(human, needs, contacts, supports, data, scales)
    known = np.zeros((motion.n_frames, 2), bool)
    if measured is not None:
        known = np.array(measured.valid_side)
    force, point, torque = _at_pressure(motion.time, needs, found.wrench)
    if measured is not None:
        force[:, :2][known], point[:, :2][known] = measured.force[known], measured.point[known]
        torque[:, :2][known] = measured.torque[known]
    sure = np.ones(known.shape, bool)
    feet = FootForces(
        force[:, :2],
        point[:, :2],
        torque[:, :2],
        sure,
        sure[:, 0].copy(),
        () if measured is None else measured.uses,
        () if measured is None else measured.warnings,
    )
    return GroundForces(
        feet,
        known,
        **half_widths(needs, found.wrench, found.spread, contacts, motion.time, known, human),
        com_shift=needs.to_world @ found.shift,
        noise=found.noise,
        residual_force=found.missed_force,
        residual_moment=found.missed_moment,
        contacts=contacts,
        supports=supports,
        support_force=force[:, 2:],
        support_point=point[:, 2:],
        support_torque=torque[:, 2:],
        flies=flies,
    )


def _at_pressure(time, needs: ForceNeeds, wrench) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the wrenches, world: forces [N] at centres of pressure [m], free moments [N m]."""
    w, base = resampled(needs.time, wrench, time), resampled(needs.time, needs.base, time)
    load = w[..., 2] > LIGHT
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
    """Return every how manieth frame is taken: fewer of fast and of long recordings."""
    step = np.ceil(motion.rate / FASTEST)
    longer = min(np.ceil(motion.n_frames / MANY), motion.rate // SLOWEST)
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
