"""Ground reactions where no plate measured them, or the reason why they cannot be estimated.

The program (:mod:`plantigrade.dynamics.ground_forces`) gives every foot what the motion needs.
It knows level or given ground, two feet and a seat. Where something else carries load too (a hand
on a rail), these cannot produce the motion, and the estimate is refused.
"""

from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.dynamics.centroid import root_wrench_at
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.dynamics.inverse import Moments, inverse_dynamics
from plantigrade.dynamics.loading import RUNNING_FREQUENCY_RATIO
from plantigrade.dynamics.plates import FootForces
from plantigrade.errors import ParameterError, SolverError
from plantigrade.kinematics.given_ground import suggested
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs

NOISY = 2.0
"""A motion noisier than this many times what is assumed says little of the knee's moment. With 1
mm and 0.3° of noise on every coordinate it is 3 to 5."""
WIDE = 0.5
"""So does a 90 % band of it that is wider each way: about its peak in walking [N m/kg]."""
MOST_FORCE = 0.25
"""Net force that is left over, root mean square [BW]. Feet can give nearly any force, so this is
noise: markers leave 0.03 to 0.05, skeleton files 0.08 to 0.14."""
MOST_MOMENT = 0.1
"""Net moment about the centre of mass that is left over [BW m]: something else carries, beside.
Markers leave 0.006 to 0.015, skeleton files 0.02 to 0.08."""
MOST_SHIFT = 0.06
"""Centre of mass further from the body's own than any body is misjudged by [m]."""
UNEVEN = 0.06
"""Feet that stand at heights further apart are not on level ground [m]."""
CANNOT = "ground reactions cannot be estimated from this motion: "


def estimate(
    human: Human,
    motion: Motion,
    measured: FootForces | None,
    soles: Float[Array, "n_frames 2"],
    ground: Ground = LEVEL_GROUND,
) -> tuple[GroundForces | None, Moments | None, tuple[str, ...]]:
    """Return ground reactions beside the measured ones, moments by them, and what to know of them.

    None where nothing is left to estimate, and where it cannot be told.

    Args:
        human: Whose motion.
        motion: The motion, filtered, with its gait events.
        measured: What plates tell.
        soles: Height of each sole in stance [m]; NaN in swing.
        ground: Ground under the feet, above which those heights are measured.
    """
    if measured is not None and bool(np.all(measured.valid_side)):
        return None, None, ()
    why = _other_ground(human, motion, soles, ground)
    if why:
        return None, None, (CANNOT + why,)
    try:
        found = estimate_forces(human, motion, measured=measured, ground=ground)
    except (ParameterError, SolverError) as error:
        return None, None, (f"{CANNOT}{error}.".replace("..", "."),)
    assert motion.qacc is not None  # it was estimated from them
    moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, found.forces)
    why = _refusal(found, *left_over(human, motion, found, moments))
    if why:
        return None, None, (CANNOT + why,)
    band, more = knee_band(human, found), RUNNING_FREQUENCY_RATIO if found.flies else 1.0
    if found.noise > more * NOISY or band > more * WIDE:
        noisy = f"is {found.noise:.1f} times as noisy as assumed"
        why = (
            noisy if found.noise > more * NOISY else "says little about how the feet share the load"
        )
        note = (
            f"the motion {why}: do not trust the estimated moments of the knee, which are known to "
            f"±{band:.2f} N m/kg (90 %)."
        )
        return found, moments, (note,)
    return found, moments, ()


def left_over(
    human: Human, motion: Motion, ground: GroundForces, moments: Moments
) -> tuple[float, float]:
    """Return the net force [BW] and pitch and roll moment [BW m] that the estimate does not give.

    Root mean squares of the components over the frames in which something was estimated; the
    moment is that about the centre of mass where the estimate puts it.
    """
    weight = human.mass * GRAVITY
    root = moments.tau[:, :6] - support_push(human, motion, ground)[:, :6]
    force, moment = root_wrench_at(root, motion.qpos, moments.com)
    given = ground.forces.force.sum(axis=1) + ground.support_force.sum(axis=1)
    moment = moment + np.cross(ground.com_shift, given + force)
    here = ~ground.measured.all(axis=1)
    return _rms(force[here] / weight), _rms(moment[here, :2] / weight)


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
    """Return how the estimate went, as figures; nothing of it was measured."""
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
    """Return what was measured, and the half-widths of the 90 % bands, as signals of a record."""
    return {
        "forces.measured": np.asarray(ground.measured, dtype=bool),
        "forces.band": ground.force_band,
        "forces.point_band": ground.point_band,
        "forces.torque_band": ground.torque_band,
        "forces.moment_band": ground.moment_band,
    }


def support_push(human: Human, motion: Motion, ground: GroundForces) -> Float[Array, "n nv"]:
    """Return the generalised force of what carries besides the feet, such as a seat."""
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
    """Return why an estimate is no good; empty where it is."""
    away = float(np.linalg.norm(found.com_shift[:2]))
    carries = (
        "something else seems to carry the body too (a hand on a rail, a step), or the "
        "motion is too noisy."
    )
    more = (
        RUNNING_FREQUENCY_RATIO if found.flies else 1.0
    )  # a motion filtered less keeps more noise
    if not force <= more * MOST_FORCE:
        return f"{force:.2f} body weights of net force are left over; {carries}"
    if not moment <= more * MOST_MOMENT:
        return f"{moment:.2f} body weights times metre of net moment are left over; {carries}"
    if away > MOST_SHIFT:
        what = f"the centre of mass would have to lie {1e3 * away:.0f} mm beside the body's own"
        return f"{what}; {carries}"
    return ""


def _other_ground(
    human: Human, motion: Motion, soles: Float[Array, "n_frames 2"], ground: Ground
) -> str:
    """Return why the feet of a gait do not stand on its ground; empty where they do."""
    if not motion.events:
        return ""
    step, seems = _step_between(soles), suggested(human, motion.time, motion.qpos)
    if ground.slope or ground.steps:
        if step <= UNEVEN:
            return ""
        remedy = f"they suggest {seems}" if seems else "leave out --ground"
        return (
            f"the feet do not stand on the given ground, but up to {100 * step:.0f} cm above or "
            f"below each other; {remedy}."
        )
    if step > UNEVEN:
        how = f"the feet stand {100 * step:.0f} cm higher at one step than at another"
    elif "slope" in seems:
        how = "the belt under the feet rises or falls"
    else:
        return ""
    remedy = f"fit again with {seems}" if seems else "describe it with --ground"
    return f"the ground is not level, {how}. If it is a slope or stairs, {remedy}."


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _step_between(soles: Float[Array, "n_frames 2"]) -> float:
    """Return how much higher a foot stands in one stance than in another [m]."""
    heights = []
    for k in range(len(SIDES)):
        for run in runs(np.isfinite(soles[:, k])):
            quarter = (run.stop - run.start) // 4
            middle = soles[run.start + quarter : run.stop - quarter, k]
            if len(middle):
                heights.append(float(np.quantile(middle, 0.1)))  # of a hop: where it lands
    return max(heights) - min(heights) if heights else 0.0
