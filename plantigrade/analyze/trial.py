"""From a fitted recording to everything that is known about it: one Record and its curves.

Filter and differentiate, find the gait events, share the plates out to the feet, compute the
joint moments, cut the cycles, measure the gait.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.analyze.curves import GRAVITY
from plantigrade.analyze.gait import GaitMeasures, gait_measures
from plantigrade.arrays import Array, Float
from plantigrade.dynamics.carriers import segment_forces
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.inverse import Moments, inverse_dynamics, residual_metrics
from plantigrade.dynamics.plates import FootForces, assign_plates, over_plates, sole_points
from plantigrade.kinematics.points import Points
from plantigrade.kinematics.result import Fit
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Motion
from plantigrade.motion.cycles import Cycle, cut_cycles
from plantigrade.motion.events import detect_gait_events
from plantigrade.record import Record

CUTOFF = 6.0  # low-pass of motion and forces alike [Hz], usual for walking [Winter2009]_
SIDES = ("l", "r")


@dataclass(frozen=True)
class FootPath:
    """Where the feet were.

    Attributes:
        heel: Back of the heel, left then right [m].
        toe: Forefoot, left then right: midway between second metatarsal head and hallux [m].
        pelvis: Middle of the pelvis [m].
    """

    heel: Float[Array, "n_frames 2 3"]
    toe: Float[Array, "n_frames 2 3"]
    pelvis: Float[Array, "n_frames 3"]


@dataclass(frozen=True)
class Trial:
    """A fitted recording, analysed.

    Attributes:
        fit: The fit; its Human has the mass that was found.
        record: Motion, moments, forces, markers.
        feet: Paths of the feet.
        cycles: Gait cycles of both feet, by start.
        measures: Spatio-temporal measures.
        forces: Ground reactions by foot, where they were measured.
        moments: Inverse dynamics, where forces were measured.
    """

    fit: Fit
    record: Record
    feet: FootPath
    cycles: tuple[Cycle, ...]
    measures: GaitMeasures
    forces: FootForces | None
    moments: Moments | None


def analyse(fit: Fit, *, cutoff: float | None = CUTOFF, mass: float | None = None) -> Trial:
    """Analyse a fitted recording.

    Args:
        fit: The fit.
        cutoff: Low-pass of motion and forces [Hz]; None to leave them as they are.
        mass: Body mass [kg] as told by the user; where nobody tells it, it is found from the
            measured forces.
    """
    human = fit.human
    warnings = list(fit.warnings)
    if mass is not None and abs(mass - human.mass) > 1e-9:
        human = human.with_mass(mass)
    cutoff = _possible_cutoff(fit.time, cutoff)
    smooth = differentiate(human, fit.time, fit.qpos, cutoff)
    qpos, qvel, qacc = smooth.qpos, smooth.qvel, smooth.qacc
    feet = foot_path(human, fit.qpos)  # as fitted: the filter of the dynamics blurs contact
    events = detect_gait_events(fit.time, feet.heel, feet.toe, feet.pelvis)
    cycles = cut_cycles(events)
    forces = moments = None
    if fit.recording.plates:
        plates, soles = fit.recording.plates, sole_points(human, qpos)
        forces = assign_plates(plates, fit.time, soles, cutoff=cutoff)
        warnings += forces.warnings
        if mass is None and fit.recording.subject.mass is None:
            found = (
                mass_from_forces(fit.time, forces, cycles)
                if cycles
                else mass_from_standing(fit.time, plates, over_plates(plates, soles) | forces.valid)
            )
            if found is not None:
                human = human.with_mass(found)
                warnings.append(
                    f"the body mass is not in the file; {found:.1f} kg was found from the plates."
                )
        moments = inverse_dynamics(human, qpos, qvel, qacc, forces)
    if mass is None and fit.recording.subject.mass is None and human.mass == fit.human.mass:
        warnings.append(
            f"the body mass is not known; {human.mass:.1f} kg is taken for the stature "
            "(give --mass to set it)."
        )
    fit = replace(fit, human=human)
    motion = Motion(fit.time, qpos, qvel, human.joint_names, qacc, events)
    measures = gait_measures(fit.time, feet.heel, feet.toe, events)
    record = _record(fit, motion, forces, moments, measures, warnings)
    return Trial(fit, record, feet, cycles, measures, forces, moments)


def foot_path(human: Human, qpos: Float[Array, "n_frames nq"]) -> FootPath:
    """Return heel, toe and pelvis of a motion [m]."""
    table = attachments(human)
    names = ["heel_l", "heel_r", "metatarsal_2_head_l", "metatarsal_2_head_r"]
    names += ["hallux_l", "hallux_r"]
    names += ["asis_l", "asis_r", "psis_l", "psis_r"]
    points = Points(
        human, [table[n].body for n in names], np.array([table[n].position for n in names])
    )
    x = np.array([points.at(q) for q in qpos])
    return FootPath(x[:, 0:2], (x[:, 2:4] + x[:, 4:6]) / 2, x[:, 6:].mean(axis=1))


def mass_from_standing(time, plates, known) -> float | None:
    """Return the body mass on the plates [kg]: the median of their total vertical force.

    Whose foot is on which plate does not matter for it.

    Args:
        time: Time of each frame [s].
        plates: Force plates.
        known: Frames in which the plates carry the whole person.
    """
    total = np.zeros(len(time))
    for plate in plates:
        push = np.nan_to_num(plate.force[:, 2])
        total += np.interp(time, plate.time, push, left=0.0, right=0.0)
    steady = total[known & (total > 50)]
    return float(np.median(steady) / GRAVITY) if len(steady) > 10 else None


def mass_from_forces(time, forces: FootForces, cycles) -> float | None:
    """Return the body mass that the forces of a walk carry [kg]; None where they cannot tell.

    Over a stride the impulses of one stance of each foot make up body weight times the stride's
    duration, for the body neither rises nor sinks from stride to stride.
    """
    vertical = forces.force[..., 2]
    dt = float(np.median(np.diff(time)))
    weights: dict[str, list[float]] = {"l": [], "r": []}
    for c in cycles:
        if c.toe_off is None:
            continue
        k = forces.sides.index(c.side)
        stance = (time >= c.start - 0.03) & (time <= c.toe_off + 0.03)
        known = _leg_known(forces, c.side)[stance]
        if known.mean() > 0.97 and vertical[stance, k].max() > 100:
            weights[c.side].append(float(vertical[stance, k].sum() * dt / c.duration))
    if not weights["l"] and not weights["r"]:
        stride = np.median([c.duration for c in cycles])
        return _mass_from_stances(time, forces, vertical, dt, stride)
    sides = [float(np.mean(w)) for w in weights.values() if w]
    return float(2 * np.mean(sides) / GRAVITY)


def _mass_from_stances(time, forces, vertical, dt, stride) -> float | None:
    """Use single stances on a plate where no whole cycle was seen."""
    impulses = []
    for k, side in enumerate(forces.sides):
        on = (vertical[:, k] > 20) & _leg_known(forces, side)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(int), [0]])))
        for a, b in edges.reshape(-1, 2):
            if 0 < a and b < len(on) and (b - a) * dt > 0.3:
                impulses.append(float(vertical[a:b, k].sum() * dt / stride))
    return float(2 * np.mean(impulses) / GRAVITY) if impulses else None


def _leg_known(forces: FootForces, side: str) -> np.ndarray:
    """Return the frames in which the force on one foot is known (also when it is in the air)."""
    return np.asarray(forces.valid_side)[:, forces.sides.index(side)]


def _possible_cutoff(time, cutoff: float | None) -> float | None:
    """Return the cut-off, or None where the frame rate is too low for it to do anything."""
    if cutoff is None or len(time) < 12:
        return None
    rate = (len(time) - 1) / (time[-1] - time[0])
    return cutoff if cutoff < 0.45 * rate else None


def _record(fit: Fit, motion, forces, moments, measures, warnings) -> Record:
    markers, fitted = fit.markers, None
    if markers is not None:
        kept = markers.positions
        if fit.kept is not None:
            kept = np.where(fit.kept[..., None], kept, np.nan)
        markers = Markers(markers.names, markers.time, kept)
        points = Points(
            fit.human, [p.body for p in fit.places], np.array([p.position for p in fit.places])
        )
        fitted = np.array([points.at(q) for q in motion.qpos])
    metrics = dict(fit.metrics)
    metrics |= {"height_m": fit.human.height, "mass_kg": fit.human.mass}
    metrics |= {"frames": motion.n_frames, "duration_s": float(motion.time[-1] - motion.time[0])}
    metrics |= {"heading_turned_deg": float(np.rad2deg(fit.heading))}
    metrics |= measures.metrics()
    if moments is not None:
        metrics |= _moment_metrics(fit.human, forces, moments)
    contact = known = None
    if forces is not None:
        contact = segment_forces(fit.human, motion.qpos, forces.force, forces.point, forces.torque)
        known = np.stack([_leg_known(forces, side) for side in contact.side], axis=1)
    return Record(
        motion=motion,
        qfrc_actuator=None if moments is None else moments.tau,
        contact_force=None if contact is None else contact.force,
        contact_point=None if contact is None else contact.point,
        contact_torque=None if contact is None else contact.torque,
        contact_side=() if contact is None else contact.side,
        contact_segment=() if contact is None else contact.segment,
        contact_known=known,
        recorded_markers=markers,
        fitted_markers=fitted,
        metrics=metrics,
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _moment_metrics(human: Human, forces, moments) -> dict:
    result: dict = dict(residual_metrics(moments, forces))
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in SIDES:
            known = _leg_known(forces, side)
            tau = moments.tau[known, 6 + human.hinge(f"{name}_{side}")] / human.mass
            if len(tau):
                peak = tau[np.abs(tau).argmax()]
                result[f"{name}_moment_peak_{side}_nm_kg"] = float(peak)
    return result
