r"""Figures of a walk in all planes: trunk, head, arms, centre of mass, friction, angular momentum.

Figures of one walk with its forces, compared with published values of adults. Leans are relative to
the vertical, rotations relative to the direction of walking; an oscillation by :math:`\pm a` is
given as :math:`a`. The phase between two movements is that of their first harmonics over a stride:
180° is counter-phase.

Published ranges (:func:`published`) are after [Orendurff2004]_ (centre of mass), [Chung2010]_
(trunk in space, twenty adults), [Murray1967]_ (arm swing, proportional to the dimensionless speed
as in :mod:`plantigrade.models.upper_body`), [Fong2009]_ (friction below which people walk
cautiously) and [Herr2008]_ (angular momentum). Angles, moments and powers of the legs have curves
of norms.
"""

from collections.abc import Mapping

import numpy as np
from scipy.integrate import trapezoid

from plantigrade.analyze.curves import GaitCurves
from plantigrade.analyze.foot_progression import foot_progression
from plantigrade.analyze.sweep import Sweep, sweep
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import FREE_SPEED
from plantigrade.models.upper_body import ARM_SWING, MAX_SWING_SCALE
from plantigrade.motion.cycles import cut_cycles
from plantigrade.record import Record

MIN_LOAD = 50.0  # [N] normal force of a foot above which its friction is evaluated

EARLY_STANCE_END = 30.0  # [% of cycle] until which peaks of early stance are searched
LATE_SWING_START = 85.0  # [% of cycle] from which peaks of late swing are searched

COM = {"speed": (0.7, 1.6), "com_up_down_mm": (27.4, 48.3), "com_sideways_mm": (69.9, 38.5)}
COM_SD = {"com_up_down_mm": (5.2, 9.2), "com_sideways_mm": (13.4, 14.1)}
"""Excursions of the centre of mass at the lowest and the highest speed: an *estimate* after
[Orendurff2004]_, not checked against its tables."""

TRUNK_LEAN = (0.8, 3.0)
"""Approximate range of lateral trunk lean of twenty adults at 1.2 m/s [Chung2010]_ [deg]."""
TRUNK_ROTATION = (2.0, 5.0)
"""The same of axial trunk rotation [deg]."""

MIN_COMFORTABLE_FRICTION = 0.41
"""Coefficient of friction below which people walk cautiously [Fong2009]_."""

MAX_ANGULAR_MOMENTUM = {"frontal": 0.06, "sagittal": 0.10, "vertical": 0.02}
"""Approximate ranges of angular momentum over a stride, relative to mass times speed times height
of the centre of mass: an *estimate* from curves of [Herr2008]_."""


def plane_figures(record: Record) -> dict[str, float]:
    """Return the figures of a walk over its first complete stride of the right foot.

    Raises:
        ParameterError: If the record has no complete stride, or no forces.
    """
    cycles = cut_cycles(record.motion.events, side="r")
    if not cycles or record.contact_force is None:
        raise ParameterError(
            "figures in all planes need forces and a complete stride of the right foot"
        )
    s, t = sweep(record), record.motion.time
    stride = (t >= cycles[0].start - 1e-9) & (t <= cycles[0].stop + 1e-9)
    displacement = record.motion.qpos[stride][[0, -1], :2]
    speed = float(np.linalg.norm(displacement[1] - displacement[0]) / np.ptp(t[stride]))
    heading = float(np.arctan2(*(displacement[1] - displacement[0])[::-1]))
    return (
        _trunk(record, s, stride, heading)
        | _arms(record, stride)
        | _centre(record, s, stride, heading, speed)
        | _feet(record, stride)
    )


def load_figures(curves: GaitCurves) -> dict[str, float]:
    """Return peaks of moments [N m/kg] and powers [W/kg] of the right leg over the mean cycle."""

    def mean(table: Mapping[str, Array], name: str) -> Float[Array, " n"]:
        return np.nanmean(table[name], axis=0)

    p = curves.percent
    hip = -mean(curves.moments, "hip_flexion_r")
    knee, ankle = (-mean(curves.moments, f"{n}_r") for n in ("knee_angle", "ankle_angle"))
    stance = p <= 60.0
    found = {
        "hip_extensor_early_nm_kg": float(hip[p <= EARLY_STANCE_END].max()),
        "hip_extensor_late_swing_nm_kg": float(hip[p >= LATE_SWING_START].max()),
        "hip_abductor_nm_kg": float(-mean(curves.moments, "hip_adduction_r")[stance].min()),
        "knee_extensor_early_nm_kg": float(knee[p <= EARLY_STANCE_END].max()),
        "ankle_plantarflexor_nm_kg": float(ankle.max()),
    }
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        power = mean(curves.powers, f"{name}_r")
        stem = name.split("_")[0]
        found |= {
            f"{stem}_power_max_w_kg": float(power.max()),
            f"{stem}_power_min_w_kg": float(power.min()),
        }
    forward, left = (mean(curves.forces, f"{n}_r") for n in ("forward", "left"))
    return found | {
        "ground_force_braking_bw": float(-forward.min()),
        "ground_force_pushing_bw": float(forward.max()),
        "ground_force_inward_bw": float(left[stance].max()),
    }


def published(human: Human, speed: float) -> dict[str, tuple[float, float]]:
    """Return the usual ranges of adults at a speed [m/s] by name of figure."""
    d = human.dimensions
    relative = speed / float(np.sqrt(GRAVITY * (d.thigh + d.shank + d.ankle_height)))
    arm = 2.0 * ARM_SWING * min(relative / FREE_SPEED, MAX_SWING_SCALE)
    usual = {
        "trunk_lean_deg": TRUNK_LEAN,
        "head_lean_deg": (0.0, 2.0),
        "trunk_rotation_deg": TRUNK_ROTATION,
        "arm_swing_deg": (0.5 * arm, 1.5 * arm),
        "arm_phase_deg": (150.0, 210.0),
        "friction_used": (0.15, MIN_COMFORTABLE_FRICTION),
    }
    for name, ends in COM.items():
        if name != "speed":
            mean = float(np.interp(speed, COM["speed"], ends))
            sd = float(np.interp(speed, COM["speed"], COM_SD[name]))
            usual[name] = mean - sd, mean + sd
    momentum = {f"angular_momentum_{n}": (0.0, most) for n, most in MAX_ANGULAR_MOMENTUM.items()}
    return usual | momentum


def _trunk(record: Record, s: Sweep, stride: Array, heading: float) -> dict[str, float]:
    """Return leans and rotations of trunk, head and pelvis."""
    human, found, turned = record.human, {}, {}
    for name, body in (("trunk", human.trunk), ("head", "head"), ("pelvis", "pelvis")):
        R = _along(s.rotation[stride][:, human.body(body)], heading)
        found[f"{name}_lean_deg"] = _amplitude(np.arcsin(R[:, 1, 2]))
        forward = np.rad2deg(np.arctan2(R[:, 0, 2], R[:, 2, 2]))
        found[f"{name}_forward_mean_deg"] = float(forward.mean())
        found[f"{name}_forward_deg"] = _amplitude(np.deg2rad(forward))
        turned[name] = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        found[f"{name}_rotation_deg"] = _amplitude(turned[name])
    t = record.motion.time[stride]
    found["pelvis_trunk_phase_deg"] = _phase(t, turned["trunk"], turned["pelvis"])
    return found


def _arms(record: Record, stride: Array) -> dict[str, float]:
    """Return swing and phase of the right arm; nothing if the model has no moving arms."""
    motion, names = record.motion, record.human.coordinates
    if "arm_flex_r" not in names:
        return {}
    arm, hip = (motion[n][stride] for n in ("arm_flex_r", "hip_flexion_r"))
    found = {
        "arm_swing_deg": 2.0 * _amplitude(arm),
        "arm_phase_deg": _phase(motion.time[stride], arm, hip),
    }
    if "elbow_flex_r" in names:
        found["elbow_range_deg"] = 2.0 * _amplitude(motion["elbow_flex_r"][stride])
    return found


def _centre(
    record: Record, s: Sweep, stride: Array, heading: float, speed: float
) -> dict[str, float]:
    """Return excursions of the centre of mass, and the range of angular momentum about it."""
    height = float(np.mean(s.com[stride] @ record.ground.normal))
    whole = record.human.mass * speed * height
    L = _along(s.momentum[stride][:, 3:], heading) / whole
    across = _along(s.com[stride], heading)[:, 1]
    return {
        "com_up_down_mm": 1000.0 * float(np.ptp(s.com[stride, 2])),
        "com_sideways_mm": 1000.0 * float(np.ptp(across)),
        "angular_momentum_frontal": float(np.ptp(L[:, 0])),
        "angular_momentum_sagittal": float(np.ptp(L[:, 1])),
        "angular_momentum_vertical": float(np.ptp(L[:, 2])),
    }


def _feet(record: Record, stride: Array) -> dict[str, float]:
    """Return the required friction and the foot progression in midstance."""
    used = 0.0
    for side in SIDES:
        force = record.foot(side).force[stride] @ record.ground.to_world
        load = force[:, 2] > MIN_LOAD
        if load.any():
            used = max(used, float(np.max(np.hypot(*force[load, :2].T) / force[load, 2])))
    out = foot_progression(record)
    rows = [x[:, 15:45].mean() for x in out.values() if len(x)]
    found = {"friction_used": used}
    return found | ({"foot_progression_out_deg": float(-np.mean(rows))} if rows else {})


def _along(x: Float[Array, "n ..."], heading: float) -> Float[Array, "n ..."]:
    """Return vectors, or columns of rotations, in the axes of a heading: forward, left, up."""
    c, s = np.cos(heading), np.sin(heading)
    return np.einsum("ij,nj...->ni...", np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]), x)


def _amplitude(x: Float[Array, " n"]) -> float:
    """Return half the range of an angle [rad] in degrees."""
    return float(np.rad2deg(np.ptp(x)) / 2)


def _phase(t: Float[Array, " n"], x: Float[Array, " n"], y: Float[Array, " n"]) -> float:
    """Return the phase of x relative to y, of their first harmonics, from 0 to 360 [deg]."""
    wave = np.exp(-2j * np.pi * (t - t[0]) / np.ptp(t))
    a, b = (trapezoid((z - z.mean()) * wave, t) for z in (x, y))
    return float(np.rad2deg(np.angle(a * np.conj(b))) % 360.0)
