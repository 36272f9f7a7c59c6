"""Estimated ground reactions without plates, or the reason why they cannot be estimated.

The program (:mod:`plantigrade.dynamics.ground_forces`) assumes level or given ground, two feet and
a seat. If something else carries load (a hand on a rail), these supports cannot produce the motion,
and the estimate is refused.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.dynamics.centroid import root_wrench_at
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.dynamics.inverse import Moments, inverse_dynamics
from plantigrade.dynamics.loading import MIN_BOX_REST, RUNNING_FREQUENCY_RATIO
from plantigrade.dynamics.plates import FootForces
from plantigrade.errors import ParameterError, SolverError
from plantigrade.kinematics.given_ground import suggested
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs
from plantigrade.notes import Info

MAX_NOISE = 2.0
"""Ratio of noise to the assumed noise above which knee moments are doubtful; 1 mm and 0.3° of noise
on every coordinate give 3 to 5."""
MAX_KNEE_BAND = 0.5
"""Half-width of the 90 % band above which knee moments are doubtful [N m/kg], about their peak in
walking."""
MAX_RESIDUAL_FORCE = 0.25
"""Maximum RMS residual force [BW]. Feet can produce nearly any force, so it is noise: 0.03 to 0.05
with markers, 0.08 to 0.14 with skeleton files."""
MAX_RESIDUAL_MOMENT = 0.1
"""Maximum RMS residual moment about the centre of mass [BW m]; a larger one indicates another
support. Markers give 0.006 to 0.015, skeleton files 0.02 to 0.08."""
MAX_COM_SHIFT = 0.06
"""Maximum shift of the estimated centre of mass from that of the body model [m]."""
MAX_STEP = 0.06  # [m] maximum height difference between stances on level ground
MIN_BOX_HEIGHT = 0.1
"""Smallest height of a box that is put below feet without being asked for [m]. Chosen."""
PREFIX = "ground reactions cannot be estimated from this motion: "


def estimate(
    human: Human,
    motion: Motion,
    measured: FootForces | None,
    soles: Float[Array, "n_frames 2"],
    ground: Ground = LEVEL_GROUND,
    band_factor: float = 1.0,
) -> tuple[GroundForces | None, Moments | None, tuple[str, ...]]:
    """Return ground reactions, measured and estimated, the joint moments, and notes.

    The first two are None if nothing has to be estimated, or nothing can be.

    Args:
        motion: The motion, filtered, with its gait events.
        soles: Height of each sole in stance [m]; NaN in swing.
        ground: The ground, to which these heights refer.
        band_factor: Factor of the bands of the forces, for noise that the program does not see [1].
    """
    if measured is not None and bool(np.all(measured.valid_side)):
        return None, None, ()
    reason = _other_ground(human, motion, soles, ground)
    if reason:
        return None, None, (PREFIX + reason,)
    try:
        found = estimate_forces(human, motion, measured=measured, ground=ground)
    except (ParameterError, SolverError) as error:
        return None, None, (f"{PREFIX}{error}.".replace("..", "."),)
    if band_factor != 1.0:
        found = replace(found, force_band=band_factor * found.force_band)
    assert motion.qacc is not None  # the estimate requires them
    moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, found.forces)
    reason = _refusal(found, *residual_wrench(human, motion, found, moments))
    if reason:
        return None, None, (PREFIX + reason,)
    notes = _box_notes(human, found, motion.time, ground)
    band, noise_factor = knee_band(human, found), RUNNING_FREQUENCY_RATIO if found.flies else 1.0
    if found.noise > noise_factor * MAX_NOISE or band > noise_factor * MAX_KNEE_BAND:
        noisy = f"is {found.noise:.1f} times as noisy as assumed"
        reason = (
            noisy
            if found.noise > noise_factor * MAX_NOISE
            else "hardly determines the load sharing of the feet"
        )
        note = (
            f"the motion {reason}: do not trust the estimated knee moments, whose uncertainty is "
            f"±{band:.2f} N m/kg (90 %)."
        )
        notes = (note, *notes)
    return found, moments, notes


def residual_wrench(
    human: Human, motion: Motion, ground: GroundForces, moments: Moments
) -> tuple[float, float]:
    """Return residual force [BW] and residual pitch and roll moment [BW m] of an estimate.

    They are RMS values of the components over the estimated frames; the moment is about the
    estimated centre of mass.
    """
    weight = human.mass * human.gravity
    root = moments.tau[:, :6] - support_forces(human, motion, ground)[:, :6]
    force, moment = root_wrench_at(root, motion.qpos, moments.com)
    given = ground.forces.force.sum(axis=1) + ground.support_force.sum(axis=1)
    moment = moment + np.cross(ground.com_shift, given + force)
    here = ~ground.measured.all(axis=1)
    # an unknown residual stays unknown: it must not pass as small
    parts = force[here] / weight, moment[here, :2] / weight
    known = [root_mean_square(x) if np.isfinite(x).all() else np.nan for x in parts]
    return known[0], known[1]


def knee_band(human: Human, ground: GroundForces) -> float:
    """Return the median half-width of the knees' 90 % bands in estimated stance [N m/kg]."""
    halves = []
    for k, side in enumerate(SIDES):
        stands = (ground.forces.force[:, k, 2] > 0) & ~ground.measured[:, k]
        halves.append(ground.moment_band[stands, 6 + human.hinge(f"knee_angle_{side}")])
    known = np.concatenate(halves)
    known = known[np.isfinite(known)]
    return float(np.median(known)) / human.mass if len(known) else float("nan")


def estimate_figures(human: Human, ground: GroundForces) -> dict[str, Any]:
    """Return figures of an estimate."""
    return {
        "forces_estimated_pct": 100.0 * (1.0 - float(np.mean(ground.measured))),
        "estimate_noise_factor": ground.noise,
        "estimate_knee_band_nm_kg": knee_band(human, ground),
        "estimate_com_shift_forward_mm": 1e3 * float(ground.com_shift[0]),
        **{
            f"estimate_{support.name}_force_peak_n": float(ground.support_force[:, i, 2].max())
            for i, support in enumerate(ground.supports)
        },
    }


def estimate_signals(ground: GroundForces) -> dict[str, Array]:
    """Return measured frames and half-widths of the 90 % bands as signals of a record."""
    return {
        "forces.measured": np.asarray(ground.measured, dtype=bool),
        "forces.band": ground.force_band,
        "forces.point_band": ground.point_band,
        "forces.torque_band": ground.torque_band,
        "forces.moment_band": ground.moment_band,
    }


def support_forces(human: Human, motion: Motion, ground: GroundForces) -> Float[Array, "n nv"]:
    """Return the generalised force of supports other than the feet, such as a seat."""
    push = np.zeros(motion.qvel.shape)
    bodies = [human.body(support.body) for support in ground.supports]
    for f, state in enumerate(sweep(human, motion.qpos, motion.qvel) if bodies else ()):
        for k, body in enumerate(bodies):
            point = ground.support_point[f, k]
            if np.isfinite(point).all():
                force, torque = ground.support_force[f, k], ground.support_torque[f, k]
                push[f] += state.generalised_force(body, point, force, torque)
    return push


def _refusal(found: GroundForces, force: float, moment: float) -> str:
    """Return the reason to refuse an estimate; empty if it is acceptable."""
    away = float(np.linalg.norm(found.com_shift[:2]))
    cause = (
        "another support seems to carry the body (a hand on a rail, a step), or the motion is too "
        "noisy."
    )
    noise_factor = (
        RUNNING_FREQUENCY_RATIO if found.flies else 1.0
    )  # a higher cut-off leaves more noise
    if not force <= noise_factor * MAX_RESIDUAL_FORCE:
        return f"the residual force is {force:.2f} body weights; {cause}"
    if not moment <= noise_factor * MAX_RESIDUAL_MOMENT:
        return f"the residual moment is {moment:.2f} body weights times metre; {cause}"
    if away > MAX_COM_SHIFT:
        what = f"the centre of mass would have to be {1e3 * away:.0f} mm from that of the body"
        return f"{what}; {cause}"
    return ""


def _other_ground(
    human: Human, motion: Motion, soles: Float[Array, "n_frames 2"], ground: Ground
) -> str:
    """Return the reason why feet and ground do not match; empty if they do."""
    if not motion.events:
        return ""
    step, seems = _step_between(soles), suggested(human, motion.time, motion.qpos)
    if ground.slope or ground.steps:
        if step <= MAX_STEP:
            return ""
        remedy = f"they suggest {seems}" if seems else "omit --ground"
        return (
            "the feet do not match the given ground: stances differ by up to "
            f"{100 * step:.0f} cm in height; {remedy}."
        )
    if step > MAX_STEP:
        how = f"stances of a foot differ by {100 * step:.0f} cm in height"
    elif "slope" in seems:
        how = "it slopes along the way"
    else:
        return ""
    remedy = f"fit the markers with {seems}" if seems else "describe it with --ground"
    return f"the ground is not level: {how}. If it is a slope or stairs, {remedy}."


def _box_notes(
    human: Human, found: GroundForces, time: Float[Array, " n_frames"], ground: Ground
) -> tuple[str, ...]:
    """Return a note on a box that level ground does not have, if feet stand on it for a while."""
    high, rise = on_box(human, found, ground)
    seconds = float(high.any(axis=1).sum() * np.median(np.diff(time)))
    if seconds < MIN_BOX_REST:
        return ()
    return (
        Info(
            f"the feet stand on a box {100 * rise:.0f} cm high for {seconds:.1f} s, which viewer "
            f"and simulation lack; fit the markers with --ground steps:{100 * rise:.0f}."
        ),
    )


def box_height(
    human: Human, found: GroundForces, time: Float[Array, " n_frames"], ground: Ground
) -> float | None:
    """Return the height of a box on which both feet stand for a while [m]; None without one."""
    high, rise = on_box(human, found, ground)
    both = float(high.all(axis=1).sum() * np.median(np.diff(time)))
    return rise if both >= MIN_BOX_REST and rise >= MIN_BOX_HEIGHT else None


def on_box(
    human: Human, found: GroundForces, ground: Ground
) -> tuple[Bool[Array, "n_frames 2"], float]:
    """Return the frames in which feet stand high above level ground, and how high [m].

    Standing feet carry most of the person: those of a person who sits may rest on a rung.
    """
    points, load = found.forces.point[..., 2], found.forces.force[..., 2]
    stands = load.sum(axis=1) > 0.5 * human.mass * human.gravity
    with np.errstate(invalid="ignore"):
        high = (load > 0.0) & (points - ground.height > MAX_STEP) & stands[:, None]
    if ground.slope or ground.steps or not high.any():
        return np.zeros_like(high), 0.0
    return high, float(np.median(points[high])) - ground.height


def _step_between(soles: Float[Array, "n_frames 2"]) -> float:
    """Return the maximum height difference between stances of a foot [m]."""
    heights = []
    for k in range(len(SIDES)):
        for run in runs(np.isfinite(soles[:, k])):
            quarter = (run.stop - run.start) // 4
            middle = soles[run.start + quarter : run.stop - quarter, k]
            if len(middle):
                heights.append(
                    float(np.quantile(middle, 0.1))
                )  # low quantile, for stances with a hop
    return max(heights) - min(heights) if heights else 0.0
